"""Time of `check_states` by threads: `python tests/benchmarks/thread_scaling.py [--robot panda --scene bookshelf]`.

Wall-clock time of all states with 1, 2, ... threads up to the machine's cores, by turns; the least of each counts.
"""

from __future__ import annotations

import argparse
import os
import time

import plannercheck as pc

ROUNDS = 60


def main() -> None:
    """Prints a row a number of threads."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--scene", default="bookshelf")
    parser.add_argument("--states", type=int, default=50_000)
    parser.add_argument("--threads", type=int, default=os.cpu_count() or 1, help="at most; default: the cores")
    options = parser.parse_args()
    checker = pc.Checker(pc.Robot.load(options.robot), pc.Scene.load(options.scene))
    q = checker.robot.random_configurations(options.states, 0)
    counts = range(1, options.threads + 1)
    best = dict.fromkeys(counts, float("inf"))
    for turn in range(ROUNDS):
        for threads in counts if turn % 2 == 0 else reversed(counts):
            began = time.perf_counter()
            checker.check_states(q, threads)
            best[threads] = min(best[threads], time.perf_counter() - began)
    print("threads  µs a state  times as fast as one")
    for threads, seconds in best.items():
        print(f"{threads:7d}  {1e6 * seconds / len(q):10.2f}  {best[1] / seconds:20.2f}")


if __name__ == "__main__":
    main()
