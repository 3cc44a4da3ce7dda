"""One checker, used by several threads at once: what a build with a thread sanitizer runs.

    cmake -S plannercheck/cpp -B build-tsan -DPLANNERCHECK_SANITIZE=thread -DPLANNERCHECK_LEVELS=v3
    cmake --build build-tsan && cp build-tsan/*.so plannercheck/
    LD_PRELOAD=$(gcc -print-file-name=libtsan.so) TSAN_OPTIONS=exitcode=66 python tests/support/threads.py

It prints what it found; the sanitizer's exit code says whether it saw a race. Python and NumPy are not instrumented, so
only races within the core show.
"""

import threading
from collections.abc import Callable

import numpy as np

import plannercheck as pc

STATES, CALLERS, ROUNDS = 400, 4, 3


def main() -> None:
    """Runs all calls from several threads, each with threads of its own where it takes them."""
    robot = pc.Robot.load("panda")
    checker = pc.Checker(robot, pc.Scene.load("bookshelf"))
    q = robot.random_configurations(STATES, 1)
    q[::7] = robot.upper + 0.1  # these need the full table, which the first caller compiles
    ends = q + 0.05
    expected = pc.Checker(robot, pc.Scene.load("bookshelf"), tuning=pc.Tuning(reach=False)).check_states(q)
    calls: list[Callable[[], object]] = [
        lambda: checker.check_states(q, threads=4),
        lambda: checker.first_colliding_pair(q, threads=3) < 0,
        lambda: np.array([checker.is_valid(row) for row in q]),
        lambda: ~checker.colliding_pairs(q).any(axis=1),
        lambda: checker.check_motions(q[:40], ends[:40], 0.01),
        lambda: checker.check_motions(q[:40], ends[:40]),
        checker.statistics,
        checker.motion_certifier.statistics,
    ]
    wrong: list[int] = []

    def work(caller: int) -> None:
        for turn in range(ROUNDS * len(calls)):
            k = (caller + turn) % len(calls)
            found = calls[k]()
            if k < 4 and not np.array_equal(np.asarray(found), expected):
                wrong.append(k)

    threads = [threading.Thread(target=work, args=(caller,)) for caller in range(CALLERS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if wrong:
        raise SystemExit(f"verdicts differ between threads: calls {sorted(set(wrong))}")
    print(f"{CALLERS} threads, {STATES} states: the same verdicts everywhere")


if __name__ == "__main__":
    main()
