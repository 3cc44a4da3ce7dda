"""Time of `check_states` by threads: `python tests/benchmarks/thread_scaling.py [--robot panda --scene bookshelf]`.

Wall-clock time of all states with 1, 2, ... threads up to the machine's cores, by turns; the least of each counts.
Small sets are judged more often, so that a machine whose speed changes has its best moments in all of them. Beside it,
as many processes that share nothing and judge a part each with one thread: what the machine itself allows.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import time
from multiprocessing.queues import Queue
from multiprocessing.synchronize import Barrier
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import plannercheck as pc
from plannercheck.evaluation.bench.records import write_record

JUDGED = 3_000_000  # states, by each number of threads
MOST_ROUNDS = 3_000

Times = list[tuple[float, float]]  # s: when each round began and ended


def _judge_parts(
    robot: str, scene: str, q: NDArray[np.float64], rounds: int, start: Barrier, times: Queue[Times]
) -> None:
    """What a process does: its part, each time that all are ready."""
    checker = pc.Checker(pc.Robot.load(robot), pc.Scene.load(scene))
    spans = []
    for _ in range(rounds):
        start.wait()
        began = time.perf_counter()
        checker.check_states(q)
        spans.append((began, time.perf_counter()))
    times.put(spans)


def seconds_of_processes(robot: str, scene: str, q: NDArray[np.float64], rounds: int, count: int) -> float:
    """The least wall-clock time in which so many processes judge all of q, from the first's start to the last's end."""
    context = multiprocessing.get_context("spawn")
    start, times = context.Barrier(count), context.Queue()
    parts = np.array_split(q, count)
    workers = [context.Process(target=_judge_parts, args=(robot, scene, part, rounds, start, times)) for part in parts]
    for worker in workers:
        worker.start()
    spans = np.array([times.get() for _ in workers])
    for worker in workers:
        worker.join()
    return float((spans[:, :, 1].max(axis=0) - spans[:, :, 0].min(axis=0)).min())


def main() -> None:
    """Prints a row a number of threads."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--scene", default="bookshelf")
    parser.add_argument("--states", type=int, default=50_000)
    parser.add_argument("--threads", type=int, default=os.cpu_count() or 1, help="at most; default: the cores")
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    checker = pc.Checker(pc.Robot.load(options.robot), pc.Scene.load(options.scene))
    q = checker.robot.random_configurations(options.states, 0)
    rounds = min(max(JUDGED // options.states, 1), MOST_ROUNDS)
    counts = range(1, options.threads + 1)
    best = dict.fromkeys(counts, float("inf"))
    for turn in range(rounds):
        for threads in counts if turn % 2 == 0 else reversed(counts):
            began = time.perf_counter()
            checker.check_states(q, threads)
            best[threads] = min(best[threads], time.perf_counter() - began)
    print("threads  µs a state  times as fast as one   processes, µs a state  times as fast as one")
    rows: list[dict[str, object]] = []
    alone = seconds_of_processes(options.robot, options.scene, q, rounds, 1)
    for threads, seconds in best.items():
        apart = alone if threads == 1 else seconds_of_processes(options.robot, options.scene, q, rounds, threads)
        print(
            f"{threads:7d}  {1e6 * seconds / len(q):10.2f}  {best[1] / seconds:20.2f}"
            f"   {1e6 * apart / len(q):21.2f}  {alone / apart:20.2f}"
        )
        rows.append({"count": threads, "threads": 1e6 * seconds / len(q), "processes": 1e6 * apart / len(q)})
    if options.output:
        write_record(options.output, rows)


if __name__ == "__main__":
    main()
