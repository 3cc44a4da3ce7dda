"""What a change costs: this checkout's times beside those of another one, in turns.

Run: `python tests/benchmarks/against_checkout.py OTHER_CHECKOUT [--rounds 6] [--loading] [--output FILE.jsonl]`. Both
hold a built core (see CONTRIBUTING.md); the other one is, for example, of `git worktree add ../before COMMIT`.

Out: a table; for each kind of work the least time of this checkout over the least time of the other, then the same of
medians. Above 1, this checkout is slower. Each round starts a process of its own for each checkout, in the order
A B B A; within it, each kind of work is done several times and the least process time counts. With --loading it is the
import and the loading of each shipped robot, each once in a process of its own, with warm caches.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

HERE = Path(__file__).parents[2]
PLANS = 30
ROBOTS = ("panda", "ur3", "ur5", "ur10", "xarm7", "kinova", "baxter", "tiago", "pr2", "talos", "g1", "go2")


def main() -> int:
    options = _parser().parse_args()
    if options.work:
        print(json.dumps(loading(options.checkout, options.work) if options.loading else times(options.checkout)))
        return 0
    other = options.checkout.resolve()
    found: dict[Path, list[dict[str, float]]] = {HERE: [], other: []}
    for _ in range(options.rounds):
        for checkout in (HERE, other, other, HERE):
            if options.loading:
                parts = [_in_process(checkout, "--loading", "--work", robot) for robot in ROBOTS]
                found[checkout].append({name: spent for part in parts for name, spent in part.items()})
            else:
                found[checkout].append(_in_process(checkout, "--work", "all"))
    print(f"{'work':<28} {'here':>9} {'there':>9} {'least':>7} {'median':>7}")
    for name in found[HERE][0]:
        here, there = ([times[name] for times in found[checkout]] for checkout in (HERE, other))
        row = {
            "work": name,
            "here, s": min(here),
            "there, s": min(there),
            "least": min(here) / min(there),
            "median": statistics.median(here) / statistics.median(there),
        }
        print(f"{name:<28} {min(here):9.2e} {min(there):9.2e} {row['least']:7.3f} {row['median']:7.3f}", flush=True)
        if options.output is not None:
            with options.output.open("a", encoding="utf-8") as table:
                table.write(json.dumps(row) + "\n")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("checkout", type=Path, help="the other checkout, with a built core")
    parser.add_argument("--rounds", type=int, default=6, help="each has two processes of each checkout")
    parser.add_argument("--output", type=Path, metavar="FILE.jsonl", help="results are added to this file")
    parser.add_argument("--loading", action="store_true", help="time the import and the loading of each shipped robot")
    parser.add_argument("--work", help=argparse.SUPPRESS)
    return parser


def _in_process(checkout: Path, *options: str) -> dict[str, float]:
    """Times of a checkout, by a process that imports plannercheck from it."""
    command = [sys.executable, __file__, str(checkout), *options]
    variables = os.environ | {"PYTHONPATH": str(checkout), "OMP_NUM_THREADS": "1"}
    ran = subprocess.run(command, env=variables, cwd=checkout, capture_output=True, text=True, check=True)
    times: dict[str, float] = json.loads(ran.stdout.splitlines()[-1])
    return times


def _imported(checkout: Path) -> Any:
    """The package of a checkout."""
    import plannercheck as pc

    if not Path(pc.__file__).is_relative_to(checkout):
        raise SystemExit(f"plannercheck comes from {pc.__file__}, not from {checkout}")
    return pc


def loading(checkout: Path, robot: str) -> dict[str, float]:
    """Process time of the import and of loading a robot, s."""
    began = time.process_time()
    pc = _imported(checkout)
    imported = time.process_time()
    pc.Robot.load(robot)
    return {"import": imported - began, f"load {robot}": time.process_time() - imported}


def times(checkout: Path) -> dict[str, float]:
    """Process time of an item of each kind of work, s. Only what both checkouts know is called."""
    import numpy as np

    pc = _imported(checkout)
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
    q = checker.robot.random_configurations(20_000, 1)
    free = q[checker.check_states(q)]
    rng = np.random.default_rng(3)
    starts, ends = free[:400], free[400:800]
    ends = starts + (ends - starts) / np.linalg.norm(ends - starts, axis=1)[:, None]  # 1 rad
    near = np.repeat(free[:40], 25, axis=0)  # as a planner asks: many motions from one state
    to = near + 0.3 * rng.normal(size=near.shape) / np.sqrt(near.shape[1])
    passed = checker.check_motions(near, to)

    def motions(q0: np.ndarray, q1: np.ndarray) -> Callable[[], object]:
        return lambda: checker.check_motions(q0, q1)

    def single_motions(q0: np.ndarray, q1: np.ndarray) -> Callable[[], object]:
        pairs = list(zip(q0[:300], q1[:300], strict=True))
        return lambda: [checker.check_motion(*pair) for pair in pairs]

    def plans() -> None:
        for seed, (start, goal) in enumerate(zip(free[:PLANS], free[PLANS : 2 * PLANS], strict=True), 1):
            pc.ompl.plan(checker, start, goal, time_limit=5, simplify=False, seed=seed)

    some = list(q[:2_000])
    work: dict[str, tuple[Callable[[], object], int]] = {
        "states, batch": (lambda: checker.check_states(q), len(q)),
        "states, one by one": (lambda: [checker.is_valid(each) for each in some], len(some)),
        "motions of 1 rad, batch": (motions(starts, ends), len(starts)),
        "motions of 1 rad, singly": (single_motions(starts, ends), 300),
        "motions of 0.3 rad, batch": (motions(near, to), len(near)),
        "motions of 0.3 rad, singly": (single_motions(near, to), 300),
        "  of these free, batch": (motions(near[passed], to[passed]), int(passed.sum())),
        "  of these refused, batch": (motions(near[~passed], to[~passed]), int((~passed).sum())),
        "  of these refused, singly": (single_motions(near[~passed], to[~passed]), min(300, int((~passed).sum()))),
        "plans": (plans, PLANS),
    }
    return {name: _least(call, 3 if name == "plans" else 9) / count for name, (call, count) in work.items()}


def _least(call: Callable[[], object], repeats: int) -> float:
    """The least process time of several calls, s."""
    found = []
    for _ in range(repeats):
        began = time.process_time()
        call()
        found.append(time.process_time() - began)
    return min(found)


if __name__ == "__main__":
    sys.exit(main())
