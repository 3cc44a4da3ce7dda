"""`plannercheck bench clouds`, `maps`, `camera`: a robot before points, in a map, on rough ground, before a camera.

In: options. Out: tables on the terminal and, with --output, CSV and JSON in a folder.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from plannercheck.cli.bench_options import Subcommand, add_robot, add_seed, keep, note, positive, ratio_of, show, sizes
from plannercheck.cli.robot_options import robot_of
from plannercheck.common.array_types import Floats
from plannercheck.evaluation.bench import clouds, maps, motions, states
from plannercheck.evaluation.bench.clouds import CostRow
from plannercheck.evaluation.bench.methods import Kind, methods
from plannercheck.evaluation.bench.motion_methods import METHODS, OURS
from plannercheck.evaluation.bench.motion_sets import MotionCase, MotionSet, recorded_set
from plannercheck.evaluation.bench.motions import MotionRow
from plannercheck.evaluation.bench.problems import Task
from plannercheck.evaluation.bench.states import StateRow
from plannercheck.evaluation.bench.tables import number
from plannercheck.motions.checker import Checker
from plannercheck.scenes.scene import Scene

# Range of the recorded searches, rad.
_RANGE = 0.5
# Which others judge: libraries that have clouds or maps.
_KINDS: tuple[Kind, ...] = ("coal", "fcl", "vamp")
_JUDGES = (
    *("plannercheck, batch", "plannercheck, one by one", "python-fcl", "VAMP, in C++"),
    *(f"Pinocchio + coal, {how}, tolerance 1e-06" for how in ("AABB tree", "all pairs")),
)
_MOVERS = (OURS, "plannercheck, one by one", "VAMP, in C++", "Pinocchio + coal, AABB tree", "python-fcl")


def _add_clouds(parser: argparse.ArgumentParser) -> None:
    add_robot(parser)
    parser.add_argument("--scene", default="bookshelf", help="what the cameras see, with a start and a goal")
    listed = [1000, 10_000, 100_000, 1_000_000]
    parser.add_argument("--points", type=sizes, default=listed, help="of each cloud (default: 1000,...,1000000)")
    _add_counts(parser)


def _add_maps(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--storeys", type=positive, default=3, help="of the building (default: %(default)s)")
    parser.add_argument("--length", type=positive, default=40, help="of the building, m (default: %(default)s)")
    parser.add_argument(
        "--ground", type=positive, default=4096, help="points along each side of the ground (default: %(default)s)"
    )
    _add_counts(parser)


def _add_camera(parser: argparse.ArgumentParser) -> None:
    add_robot(parser)
    parser.add_argument("--scene", default="table", help="what the camera sees, with a start and a goal")
    parser.add_argument("--frames", type=positive, default=300, help="of the camera (default: %(default)s)")
    parser.add_argument("--points", type=positive, default=100_000, help="of each frame (default: %(default)s)")
    add_seed(parser)


def _add_counts(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--states", type=positive, default=10_000, help="uniformly random (default: %(default)s)")
    parser.add_argument("--motions", type=positive, default=400, help="that RRTConnect asks (default: %(default)s)")
    add_seed(parser)


def _run_clouds(options: argparse.Namespace) -> None:
    robot, scene = robot_of(options), Scene.load(options.scene)
    ends = scene.start(robot.name), scene.goal(robot.name)
    found: tuple[list[Any], ...] = [], [], []
    for count in options.points:
        sensed = clouds.sensed_scene(scene, count, options.seed)
        checker, q = Checker(robot, sensed), robot.random_configurations(options.states, options.seed)
        found[0].extend(_states(checker, q, options.rounds))
        if checker.check_states(np.array(ends)).all():
            asked = recorded_set(sensed.name, [Task(checker, *ends)], _RANGE, options.motions)
            found[1].extend(_motions(asked, options.rounds))
        else:
            note(f"{sensed.name}: motions are left out, since the scene's start or goal collides with the cloud")
        found[2].extend(_costs(clouds.measure_costs(clouds.points_of(sensed), options.robot, note)))
        for name, rows in zip(("states", "motions", "costs"), found, strict=True):  # now: the next cloud may take long
            keep(options.output, f"clouds_{name}", rows)


def _run_maps(options: argparse.Namespace) -> None:
    found: tuple[list[Any], ...] = [], [], []
    counts = options.states, options.motions, options.seed
    for make in (
        partial(maps.in_building, options.length, options.storeys, *counts),
        partial(maps.on_ground, options.ground, *counts),
    ):
        case = make()
        held = case.held
        print(f"\n{held.name}: {held.parts:,} parts, {held.build:.2f} s, {held.own:.1f} bytes a part")
        found[0].extend(_states(case.checker, case.q, options.rounds))
        cases = [MotionCase(case.mover, case.starts, case.ends)]
        found[1].extend(_motions(MotionSet(case.mover.scene.name, "0.5 rad", cases), options.rounds))
        found[2].append(held)
    for name, rows in zip(("states", "motions", "costs"), found, strict=True):
        keep(options.output, f"maps_{name}", rows)


def _run_camera(options: argparse.Namespace) -> None:
    from plannercheck.cli.camera_frames import follow  # OMPL's import takes a second

    rows = follow(robot_of(options), Scene.load(options.scene), options.frames, options.points, options.seed)
    keep(options.output, "camera", rows)


def _states(checker: Checker, q: Floats, rounds: int) -> list[StateRow]:
    judges = [method for method in methods(checker, _KINDS) if method.name in _JUDGES]
    rows = states.measure(checker, judges, q, rounds, note)
    print(f"\n{rows[0].robot} before {rows[0].scene}: {rows[0].states:,} random states, {rows[0].valid:.0%} valid")
    show(rows, {"method": _method, "µs a state": _time, **_RATES})
    return rows


def _motions(asked: MotionSet, rounds: int) -> list[MotionRow]:
    if not sum(len(case.starts) for case in asked.cases):
        note(f"{asked.where}: motions are left out, since no random state is free")
        return []
    movers = [method for method in METHODS if method.name in _MOVERS]
    rows = motions.measure(asked, rounds, note, movers)
    print(f"\n{rows[0].robot} before {asked.where}: {rows[0].motions} motions, {asked.kind}, {rows[0].free:.0%} free")
    show(rows, {"method": _method, "µs a motion": _time, **_RATES})
    return rows


def _costs(rows: Sequence[CostRow]) -> Sequence[CostRow]:
    columns: dict[str, Callable[[CostRow], object]] = {
        "method": _method,
        "built in ms": lambda row: number(1e3 * row.build),
        "changed in ms": lambda row: number(1e3 * row.update),
        "bytes a point": lambda row: number(row.bytes),
        "by its own account": lambda row: number(row.own),
    }
    if rows:
        print(f"\n{rows[0].points:,} points")
        show(rows, columns)
    return rows


def _method(row: StateRow | MotionRow | CostRow) -> str:
    return row.method


def _time(row: StateRow | MotionRow) -> str:
    return f"{row.microseconds:.2f}"


_RATES: dict[str, Callable[[StateRow | MotionRow], object]] = {
    "x": ratio_of,
    "false free %": lambda row: f"{100 * row.false_free:.2f}",
    "false coll. %": lambda row: f"{100 * row.false_collision:.2f}",
}

SUBCOMMANDS = {
    "clouds": Subcommand("a robot before clouds of points", _add_clouds, _run_clouds),
    "maps": Subcommand("an arm in a mapped building, a quadruped on rough ground", _add_maps, _run_maps),
    "camera": Subcommand("planning again with every frame of a moving camera", _add_camera, _run_camera, rounds=0),
}
