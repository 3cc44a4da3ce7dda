"""A robot before what a camera has seen: clouds of very many points, a map of a building, rough ground.

In: a robot, a scene that is rendered, numbers of points. Out: rows of states and of motions, as of `bench states` and
`bench motions`, and `CostRow`s: what building, changing and holding each takes, measured in a process of its own.
"""

from __future__ import annotations

import json
import resource
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from plannercheck.bodies.octrees import Octree
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.point_clouds import PointCloud
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct_rows
from plannercheck.common.isolated_process import run_isolated_lines
from plannercheck.evaluation.bench.build_cost import resident_bytes
from plannercheck.evaluation.bench.sensed_peers import coal_map, fcl_map
from plannercheck.evaluation.bench.vamp_model import VampModel
from plannercheck.evaluation.sensing.clouds import cloud, scene_bodies
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

# Radius of the points, m.
RADIUS = 0.01
RADII = np.array([RADIUS])
# Radius and height of where the robot stands, m.
BASE = (0.3, 0.1)
# Name of what was sensed, in scenes.
NAME = "camera"
# How often a cost is measured, unless that took so many seconds before; the least counts.
_TURNS, _ENOUGH = 3, 5.0
# VAMP's tree takes 5 kB a point of so many, and more of more.
_MOST_OF_VAMP = 200_000
# The most that a process may take whose cost is measured, bytes, and s.
_MOST_MEMORY, _PATIENCE = 12 << 30, 600
_RUN = (
    "import json, sys; from plannercheck.evaluation.bench.clouds import costs; "
    "print(json.dumps(costs(*json.loads(sys.argv[1]))))"
)


@dataclass(frozen=True)
class CostRow:
    """What holding a cloud takes.

    Attributes:
        points: How many.
        method: Who holds it.
        build: Seconds of the processor to build it from an array, all threads together.
        update: Seconds from the next frame's array to the first state that can be asked.
        bytes: Resident bytes that it took, a point.
        own: Bytes a point by its own account; None where it has none.
    """

    points: int
    method: str
    build: float
    update: float
    bytes: float | None
    own: float | None


def sensed_scene(scene: Scene, count: int, seed: int) -> Scene:
    """A scene of as many points as cameras see of another scene, and nothing else."""
    seen = Scene(f"{scene.name}, {count:,} points")
    seen.add(NAME, PointCloud(cloud(scene_bodies(scene), count, seed, base=BASE), RADII))
    return seen


def points_of(scene: Scene) -> Floats:
    """The points (n, 3) of a sensed scene, m."""
    shape = scene.object(NAME).parts[0].shape
    assert isinstance(shape, PointCloud)
    return shape.points


def measure_costs(
    points: Floats, robot_name: str, skipped: Callable[[str], None] = lambda reason: None
) -> list[CostRow]:
    """What building, changing and holding a cloud (n, 3), m, takes with each method, each in a process of its own."""
    rows = []
    with TemporaryDirectory(prefix="plannercheck-") as folder:
        file = Path(folder) / "points.npy"
        np.save(file, points)
        for method in HOLDERS:
            done = run_isolated_lines(_RUN, json.dumps([str(file), robot_name, method]), time_limit=_PATIENCE)
            if done.returncode:
                skipped(f"{method} of {len(points):,} points is left out: {done.stderr.strip().splitlines()[-1:]}")
            else:
                rows.append(CostRow(len(points), method, *json.loads(done.stdout.splitlines()[-1])))
    return rows


def costs(file: str, robot_name: str, method: str) -> tuple[float | None, ...]:
    """The figures of a row, measured in this process."""
    resource.setrlimit(resource.RLIMIT_AS, (_MOST_MEMORY, _MOST_MEMORY))
    points = np.load(file)
    checker = Checker(Robot.load(robot_name), Scene())
    checker.check_states(checker.robot.random_configurations(1, 0))
    holder = HOLDERS[method]
    holder(checker, points[:100])  # what is loaded once
    before = resident_bytes()
    held, update = holder(checker, points)
    after = resident_bytes()
    taken = None if before is None or after is None else (after - before) / len(points)
    own = held.nbytes / len(points) if hasattr(held, "nbytes") else None
    spent: list[tuple[float, float]] = []
    while len(spent) < _TURNS and sum(both for _, both in spent) < _ENOUGH:
        began = time.process_time()
        held, update = holder(checker, points)
        built = time.process_time()
        ready = update()
        spent.append((built - began, time.process_time() - began))
        del held, ready
    return *np.min(spent, axis=0).tolist(), taken, own


Holder = Callable[[Checker, Floats], tuple[Any, Callable[[], object]]]


def _ours(shape_of: Callable[[Floats], PartSet], checker: Checker, points: Floats) -> tuple[Any, Callable[[], object]]:
    shape = shape_of(points)

    def update() -> Checker:
        scene = Scene()
        scene.add(NAME, shape)
        changed = checker.with_scene(scene)
        changed.is_valid(changed.robot.reference)
        return changed

    return shape.core, update


def _cells(points: Floats) -> PartSet:
    return Octree.from_cells(distinct_rows(np.floor(points / (2 * RADIUS)).astype(np.int32))[0], 2 * RADIUS)


def _coal(checker: Checker, points: Floats) -> tuple[Any, Callable[[], object]]:
    import pinocchio as pin

    tree = coal_map(PointCloud(points, RADII))[0]

    def update() -> object:
        geometry = pin.GeometryModel()
        geometry.addGeometryObject(pin.GeometryObject(NAME, 0, pin.SE3.Identity(), tree))
        return geometry, geometry.createData()

    return tree, update


def _fcl(checker: Checker, points: Floats) -> tuple[Any, Callable[[], object]]:
    import fcl

    tree = fcl_map(PointCloud(points, RADII))
    return tree, lambda: fcl.CollisionObject(tree)


def _vamp(checker: Checker, points: Floats) -> tuple[Any, Callable[[], object]]:
    scene = Scene()
    scene.add(NAME, PointCloud(points, RADII))
    return VampModel(checker.with_scene(scene), _MOST_OF_VAMP), lambda: None


HOLDERS: dict[str, Holder] = {
    "plannercheck, balls": partial(_ours, lambda points: PointCloud(points, RADII)),
    "plannercheck, cells": partial(_ours, _cells),
    "coal's octree": _coal,
    "python-fcl's octree": _fcl,
    "VAMP's CAPT": _vamp,
}
