"""What a judgement of a gate takes: `python tests/benchmarks/gate_times.py [--count 100000] [--output FILE.json]`.

The Panda gets chunks of 16 and of 50 waypoints at 50 Hz, among the bookshelf's boxes and before a cloud of it. Chunks
start at random free states, with random velocities and bends; ten times as many judgements as chunks are made, in ten
rounds. Processor time of one thread, in µs: p50, p99 and worst of all judgements, and of the least of each chunk's ten
(what a quiet machine shows: on a busy one, others' work in the caches and on the other half of a core counts as well).
The control is one chunk judged as often. Then come the share that passes, p99 of the least of those and of others, and
by how much Python's blocks and the process's memory, KiB, have grown since the first round.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

import numpy as np

import plannercheck as pc
from plannercheck.evaluation.bench.clouds import NAME, sensed_scene
from plannercheck.evaluation.bench.records import write_record

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
from long_runs.memory import resident

_ROUNDS, _RATE = 10, 50.0
# Speeds, rad/s, and bends, rad/s², of chunks.
_SPEED, _BEND = 0.3, 0.5


def chunks_of(checker: pc.Checker, count: int, length: int) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Waypoints, where the robot stands, and its velocities."""
    rng, robot = np.random.default_rng(0), checker.robot
    q = robot.random_configurations(8 * count, 0)
    after = np.arange(1, length + 1)[:, None] / _RATE
    q = q[checker.check_states(q)]
    q = q[np.arange(count) % len(q)]
    dq, bends = rng.normal(size=q.shape) * _SPEED, rng.normal(size=q.shape) * _BEND
    return [
        (row + speed * after + bend * after**2 / 2, row, speed) for row, speed, bend in zip(q, dq, bends, strict=True)
    ]


def measured(name: str, scene: pc.Scene, length: int, count: int) -> dict[str, object]:
    """A row of the table."""
    checker = pc.Checker(pc.Robot.load("panda"), scene)
    gate = pc.Gate(checker, acceleration=None, brake=5.0)
    chunks = chunks_of(checker, count // _ROUNDS, length)
    times, passes = np.empty((_ROUNDS, len(chunks))), np.empty(len(chunks), dtype=bool)
    for k in range(_ROUNDS):
        for i, (positions, q, dq) in enumerate(chunks):
            began = time.thread_time_ns()
            passes[i] = gate.judge(positions, _RATE, start=(q, dq)).ok
            times[k, i] = time.thread_time_ns() - began
        if k == 0:
            blocks, memory = sys.getallocatedblocks(), resident()
    grown = {"blocks": sys.getallocatedblocks() - blocks, "KiB": (resident() - memory) >> 10}
    control = np.empty(len(chunks))
    positions, q, dq = chunks[int(np.argmax(passes))]
    for i in range(len(chunks)):
        began = time.thread_time_ns()
        gate.judge(positions, _RATE, start=(q, dq))
        control[i] = time.thread_time_ns() - began
    times, control = times / 1e3, control / 1e3
    least = times.min(axis=0)
    row: dict[str, object] = {"scene": name, "waypoints": length, "judgements": times.size}
    for what, values in (("all", times), ("least", least), ("control", control)):
        row |= {
            f"{what} p50": np.median(values),
            f"{what} p99": np.percentile(values, 99),
            f"{what} worst": values.max(),
        }
    for what, some in (("pass", passes), ("others", ~passes)):
        row |= {f"{what} p99 of least": np.percentile(least[some], 99) if some.any() else np.nan}
    return {key: round(float(v), 1) if isinstance(v, float) else v for key, v in row.items()} | {
        "passes": passes.mean(),
        **grown,
    }


def main() -> int:
    """Prints and writes a row for each scene and length."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--count", type=int, default=100_000, help="judgements a row")
    parser.add_argument("--points", type=int, default=100_000, help="of the cloud")
    parser.add_argument("--lengths", type=int, nargs="+", default=[16, 50], help="waypoints of a chunk")
    parser.add_argument("--output", type=Path, metavar="FILE.json")
    options = parser.parse_args()
    shelf = pc.Scene.load("bookshelf")
    cloud = sensed_scene(shelf, options.points, 0)
    for link in ("panda_link0", "panda_link1"):
        cloud.allow(NAME, link)
    rows = []
    for name, scene in (("boxes", shelf), (f"{options.points} points", cloud)):
        for length in options.lengths:
            rows.append(measured(name, scene, length, options.count))
            print("; ".join(f"{key}: {value}" for key, value in rows[-1].items()), flush=True)
    print(f"load of {os.cpu_count()} cores at the end: {', '.join(f'{each:.1f}' for each in os.getloadavg())}")
    if options.output is not None:
        write_record(options.output, rows)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
