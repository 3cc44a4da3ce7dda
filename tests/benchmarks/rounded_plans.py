"""Plans of the Panda as they are executed: corners rounded, a spline through waypoints, or timed by `pc.time_path`.

`python tests/benchmarks/rounded_plans.py SET_panda.tar.bz2 ... --every 5 --seeds 20`: plans by RRTConnect, shortened,
every motion proved, in five shipped scenes and in MotionBenchMaker's sets. Each plan with a corner is executed so:

- Its corners are rounded as MoveIt's TimeOptimalTrajectoryGeneration does by default: by circles within 0.1 rad of the
  corner, on half a leg at most. States 1 mrad apart are judged; of the rounded plans that collide, those are missed
  whose waypoints 0.1 rad apart along the path are all free.
- A cubic spline runs from rest to rest through the plan's waypoints 0.1 rad apart (the controller "jtc-upsampled"), at
  an even speed along the path. It is judged by such states, and proved.
- `pc.time_path`, by the URDF's speeds and Franka's accelerations: how many are proved, what blends save, how often they
  were cut.
"""

import argparse
import time
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

import plannercheck as pc
from plannercheck.cli.common import table
from plannercheck.common.array_types import Floats
from plannercheck.evaluation.bench.problems import Task, name_of_set, tasks
from plannercheck.evaluation.bench.records import write_record
from plannercheck.timing.time_path import UnprovedPathError

SCENES = ("bookshelf", "cage", "kitchen", "bin", "table")
DEVIATION = 0.1  # rad, MoveIt's path_tolerance
SPACING = 0.1  # rad, between waypoints
STATES = 1e-3  # rad, between states that are judged
ACCELERATION = np.array([3.75, 1.875, 2.5, 3.125, 3.75, 5.0, 5.0])  # rad/s², panda_moveit_config


class Executed(NamedTuple):
    """What became of one plan; the durations are those of `pc.time_path`, s, NaN if it proves nothing."""

    rounded_collides: bool
    missed: bool
    spline_collides: bool
    spline_proved: bool
    proved: bool
    duration: float
    saved: float
    corners: int
    cut: int
    stops: int
    seconds: float  # what `pc.time_path` took


class Row(NamedTuple):
    """A scene or set: how many plans, and of them how many; part of the time that blends save; medians."""

    set: str
    plans: int
    rounded_collide: int
    missed: int
    spline_collides: int
    spline_proved: int
    proved: int
    saved: float
    corners: int
    cut: int
    stops: int
    median_ms: float


def spaced(path: Floats, spacing: float) -> Floats:
    """A path (k, nq) with waypoints between its own, at most so far apart, rad."""
    parts = [path[:1]]
    for a, b in pairwise(path):
        count = max(int(np.ceil(np.linalg.norm(b - a) / spacing)), 1)
        parts.append(a + np.linspace(0, 1, count + 1)[1:, None] * (b - a))
    return np.concatenate(parts)


def rounded(path: Floats, spacing: float) -> Floats:
    """States of a path whose corners are circles as MoveIt's, at most so far apart."""
    parts = [path[:1]]
    for a, corner, b in zip(path[:-2], path[1:-1], path[2:], strict=True):
        before, after = (corner - a), (b - corner)
        room = min(np.linalg.norm(before), np.linalg.norm(after)) / 2
        u, v = before / np.linalg.norm(before), after / np.linalg.norm(after)
        turn = np.arccos(np.clip(u @ v, -1, 1))
        if abs(u @ v) > 0.999999:
            parts.append(corner[None])
            continue
        distance = min(room, DEVIATION * np.sin(turn / 2) / (1 - np.cos(turn / 2)))
        radius = distance / np.tan(turn / 2)
        centre = corner + (v - u) / np.linalg.norm(v - u) * radius / np.cos(turn / 2)
        out = corner - distance * u - centre
        angles = np.linspace(0, turn, max(int(np.ceil(turn * radius / spacing)), 1) + 1)[:, None]
        parts.append(centre + np.cos(angles) * out + np.sin(angles) * radius * u)
    return spaced(np.concatenate([*parts, path[-1:]]), spacing)


def executed(task: Task, path: Floats) -> Executed:
    """What becomes of a plan."""
    checker = task.checker
    states = rounded(path, STATES)
    collides = not checker.check_states(states).all()
    lengths = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(states, axis=0), axis=1))])
    at = np.linspace(0, lengths[-1], int(np.ceil(lengths[-1] / SPACING)) + 1)
    waypoints = np.stack([np.interp(at, lengths, column) for column in states.T], axis=1)
    missed = collides and bool(checker.check_states(waypoints).all())
    points = spaced(path, SPACING)
    times = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    spline = pc.Trajectory(times, points, controller="jtc-upsampled")
    between = spline.position(np.linspace(0, spline.duration, int(spline.duration / STATES) + 2))
    spline_collides = not checker.check_states(between).all()
    spline_proved = bool(checker.check_trajectories([spline])[0])
    before = time.perf_counter()
    try:
        made = pc.time_path(checker, path, None, ACCELERATION)
    except UnprovedPathError as error:
        print(error, flush=True)
        made = None
    seconds = time.perf_counter() - before
    verdicts = collides, missed, spline_collides, spline_proved
    if made is None or made.timing is None:
        return Executed(*verdicts, False, np.nan, np.nan, 0, 0, 0, seconds)
    timing = made.timing
    proved = bool(checker.check_trajectories([made])[0])
    counts = timing.corners, timing.cut, timing.stops
    return Executed(*verdicts, proved, made.duration, timing.saved, *counts, seconds)


def row(name: str, all_found: list[Executed]) -> Row:
    """The counts of a set."""
    found = np.array(all_found, dtype=float)
    duration, saved = np.nansum(found[:, 5:7], axis=0).tolist()
    counts = [int(value) for value in found[:, :5].sum(axis=0)]
    corners, cut, stops = (int(value) for value in found[:, 7:10].sum(axis=0))
    part, ms = saved / (duration + saved), 1e3 * float(np.median(found[:, 10]))
    return Row(name, len(found), *counts, part, corners, cut, stops, ms)


def all_tasks(options: argparse.Namespace) -> Iterator[tuple[str, Task]]:
    """The shipped scenes and the sets, each with its name."""
    robot = pc.Robot.load("panda")
    for name in SCENES:
        scene = pc.Scene.load(name)
        yield name, Task(pc.Checker(robot, scene), scene.start("panda"), scene.goal("panda"))
    for path in options.problems:
        for task in tasks(path, robot, options.every):
            yield name_of_set(path), task


def main() -> None:
    """Runs it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("problems", nargs="*", type=Path, metavar="SET")
    parser.add_argument("--every", type=int, default=5, help="take every so-many-th problem of a set")
    parser.add_argument("--seeds", type=int, default=20, help="plans in a shipped scene; one for each problem of a set")
    parser.add_argument("--output", type=Path, metavar="FILE.json")
    options = parser.parse_args()
    found: dict[str, list[Executed]] = {}
    for name, task in all_tasks(options):
        for seed in range(1, 1 + (options.seeds if name in SCENES else 1)):
            plan = pc.ompl.plan(task.checker, task.start, task.goal, planner="RRTConnect", seed=seed)
            if plan.solved and len(plan.path) > 2:
                found.setdefault(name, []).append(executed(task, plan.path))
    rows = [row(name, each) for name, each in found.items()]
    rows.append(row("all", [one for each in found.values() for one in each]))
    print(table(Row._fields, [(*each[:7], f"{each[7]:.3f}", *each[8:11], f"{each[11]:.0f}") for each in rows]))
    if options.output is not None:
        write_record(options.output, [each._asdict() for each in rows])


if __name__ == "__main__":
    main()
