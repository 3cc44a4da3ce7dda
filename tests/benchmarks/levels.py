"""Instruction sets beside each other, single calls and batches: `python tests/benchmarks/levels.py --levels v4 v3`.

In: levels that are built (see CONTRIBUTING.md) and that this processor runs. Out: a table; for each robot and kind of
work the least time of each level, and the others' over the first one's. A process of each level waits for its turn:
kinds and levels alternate every few milliseconds, so that what else the machine does burdens all of them alike. Process
time, the least of all rounds.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from ompl import base

import plannercheck as pc
from plannercheck.common.core import available_levels, core
from plannercheck.evaluation.bench.records import write_record

ROBOTS = {"panda": "bookshelf", "ur5": "kitchen", "baxter": "kitchen", "talos": None}
TURN = 0.015  # s: how long a worker works at a time, about
BETWEEN = "|"  # names of kinds of work


class Work(NamedTuple):
    """What is timed, and how many states or motions it judges."""

    call: Callable[[], object]
    count: int


def main() -> None:
    """Measures, or works for a process that measures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--levels", nargs="+", default=available_levels()[:2], help="the first is what others are over")
    parser.add_argument("--robot", nargs="*", default=list(ROBOTS), choices=list(ROBOTS))
    parser.add_argument("--rounds", type=int, default=60)
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    parser.add_argument("--work", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.work:
        take_turns(options.robot[0])
        return
    rows = [row for robot in options.robot for row in measured(robot, options.levels, options.rounds)]
    if options.output:
        write_record(options.output, rows)


def measured(robot: str, levels: list[str], rounds: int) -> list[dict[str, object]]:
    """Prints and returns a row for each kind of work of a robot."""
    workers = [_worker(robot, level) for level in levels]
    kinds = _line(workers[0]).split(BETWEEN)
    assert all(_line(worker).split(BETWEEN) == kinds for worker in workers[1:])
    least = {(kind, level): float("inf") for kind in kinds for level in levels}
    for k in range(rounds):
        for kind in kinds:
            for level, worker in list(zip(levels, workers, strict=True))[:: 1 if k % 2 == 0 else -1]:
                worker.stdin.write(f"{kind}\n")
                worker.stdin.flush()
                least[kind, level] = min(least[kind, level], float(_line(worker)))
    for worker in workers:
        worker.communicate()
    rows: list[dict[str, object]] = []
    for kind in kinds:
        times = {level: 1e6 * least[kind, level] for level in levels}
        shown = "  ".join(f"{level} {spent:7.3f} µs ({spent / times[levels[0]]:.3f})" for level, spent in times.items())
        print(f"{robot:8} {kind:26} {shown}", flush=True)
        rows.append({"robot": robot, "scene": ROBOTS[robot] or "empty", "work": kind, "microseconds": times})
    return rows


def _worker(robot: str, level: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-W", "ignore", __file__, "--work", "--robot", robot],
        env=os.environ | {"PLANNERCHECK_LEVEL": level, "OMP_NUM_THREADS": "1"},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def _line(worker: subprocess.Popen[str]) -> str:
    line = worker.stdout.readline().strip()
    if not line:
        raise SystemExit("a worker ended: is its level built, and does this processor have it?")
    return line


def take_turns(robot: str) -> None:
    """Names the kinds of work, then times each that is asked for, s a state or motion."""
    works = all_work(robot)
    repeats = {}
    for kind, (call, _) in works.items():
        call()
        repeats[kind] = max(1, int(TURN / max(_seconds(call), 1e-6)))
    assert core.__name__.endswith(os.environ["PLANNERCHECK_LEVEL"])
    print(BETWEEN.join(works), flush=True)
    for line in sys.stdin:
        print(_seconds(works[line.strip()].call, repeats[line.strip()]) / works[line.strip()].count, flush=True)


def _seconds(call: Callable[[], object], times: int = 1) -> float:
    """Process time of one of several calls, s."""
    began = time.process_time()
    for _ in range(times):
        call()
    return (time.process_time() - began) / times


def all_work(robot: str) -> dict[str, Work]:
    """Kinds of work: random states and motions of 0.3 and 1 rad, one by one and in batches."""
    scene = ROBOTS[robot]
    checker = pc.Checker(pc.Robot.load(robot), pc.Scene.load(scene) if scene else None)
    q = checker.robot.random_configurations(4000, 0)
    rows = list(q[:600])
    judge = checker.state_validity()
    space = pc.ompl.space_of(checker)
    information = base.SpaceInformation(space.ompl_space())
    states = [space.state(information, row) for row in rows]
    works = {
        "states, singly": Work(lambda: [checker.is_valid(row) for row in rows], len(rows)),
        "states, OMPL's callback": Work(lambda: [judge(state) for state in states], len(rows)),
        "states, batch": Work(lambda: checker.check_states(q), len(q)),
    }
    starts = q[checker.check_states(q)][:60]
    towards = checker.robot.random_configurations(4000, 2)[: len(starts)] - starts
    towards /= np.linalg.norm(towards, axis=1)[:, None]
    for length in (0.3, 1.0):
        pairs = list(zip(starts, starts + length * towards, strict=True))
        ends = starts + length * towards

        def singly(pairs: list[tuple[np.ndarray, np.ndarray]] = pairs) -> object:
            return [checker.check_motion(*pair) for pair in pairs]

        def together(ends: np.ndarray = ends) -> object:
            return checker.check_motions(starts, ends)

        works |= {
            f"motions of {length:g} rad, singly": Work(singly, len(pairs)),
            f"motions of {length:g} rad, batch": Work(together, len(pairs)),
        }
    return works


if __name__ == "__main__":
    main()
