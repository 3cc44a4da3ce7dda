"""A robot in large maps: a Panda in a mapped building of many storeys, a Go2 on rough ground.

In: sizes and a seed. Out: `MapCase`s: a checker, states and motions of 0.5 rad, and what making the map took. The arm
stands on the slab of the lowest storey, in the middle of a room. The quadruped's trunk stands at random places above
the ground for states, and for motions at the one that is highest above it.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from plannercheck.bodies.height_fields import HeightField
from plannercheck.bodies.octrees import Octree
from plannercheck.bodies.part_sets import PartSet
from plannercheck.common.array_types import Floats
from plannercheck.common.transforms import pose_of
from plannercheck.evaluation.bench.motion_sets import random_motions
from plannercheck.evaluation.sensing.buildings import building
from plannercheck.evaluation.sensing.terrains import terrain
from plannercheck.motions.checker import Checker
from plannercheck.robots.description import description_of
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

# Where the arm stands in the building: in the middle of the first room, just above the slab of 0.2 m, m.
_PLACE = (2.55, 2.55, 0.205)
# A step of the ground, m, and its lower side.
_STEP, _BASE = 0.02, -1.0
# How high the trunk is over the ground, m: standing it is 0.33.
_HEIGHTS = (0.3, 0.7)
# How far the trunk may lean, rad.
_LEAN = 0.2
# rad: of motions.
_LENGTH = 0.5


@dataclass(frozen=True)
class MapRow:
    """What holding a map takes.

    Attributes:
        name: The map.
        parts: How many parts it has.
        build: Seconds of the processor to build it from arrays, all threads together.
        own: Bytes a part.
    """

    name: str
    parts: int
    build: float
    own: float


@dataclass(frozen=True)
class MapCase:
    """A robot in a map.

    Attributes:
        checker: The exact one.
        q: (n, nq) states.
        mover: The checker of motions.
        starts: (m, nq) rad.
        ends: (m, nq) rad.
        held: What holding the map takes.
    """

    checker: Checker
    q: Floats
    mover: Checker
    starts: Floats
    ends: Floats
    held: MapRow


def in_building(length: float, storeys: int, states: int, motions: int, seed: int) -> MapCase:
    """A Panda in a building that is half as wide as long, m."""
    cells = building(length, length / 2, storeys, seed=seed)
    began = time.process_time()
    shape = Octree.from_cells(cells.keys, cells.resolution, cells.sizes)
    held, spent = shape.core, time.process_time() - began
    robot = Robot.load("panda")
    name = f"building, {shape.count:,} leaves"
    checker = Checker(robot, _scene(name, shape, -np.array(_PLACE)))
    q = robot.random_configurations(states, seed)
    ends = random_motions(checker, _LENGTH, motions, np.random.default_rng(seed))
    return MapCase(checker, q, checker, *ends, MapRow(name, shape.count, spent, held.nbytes / shape.count))


def on_ground(points: int, states: int, motions: int, seed: int) -> MapCase:
    """A Go2 on ground of so many points along each side."""
    heights = terrain(points, seed)
    began = time.process_time()
    shape = HeightField(heights, (_STEP, _STEP), _BASE)
    held, spent = shape.core, time.process_time() - began
    name = f"ground, {points:,} x {points:,} points"
    found = description_of("go2")
    robot = Robot.from_urdf(found.urdf, found.srdf, found.package_dirs, floating=True)
    rng = np.random.default_rng(seed)
    places = _places(heights, states, rng)
    legs = Robot.load("go2")
    mover = Checker(legs, _scene(name, shape, -places[np.argmax(places[:, 2] - _under(heights, places))]))
    ends = random_motions(mover, _LENGTH, motions, rng)
    q = np.hstack([places, _leaning(states, rng), legs.random_configurations(states, seed)])
    row = MapRow(name, shape.count, spent, held.nbytes / shape.count)
    return MapCase(Checker(robot, _scene(name, shape)), q, mover, *ends, row)


def _scene(name: str, shape: PartSet, shift: Floats | None = None) -> Scene:
    scene = Scene(name)
    scene.add("map", shape, None if shift is None else pose_of(shift, np.eye(3)))
    return scene


def _places(heights: Floats, count: int, rng: np.random.Generator) -> Floats:
    """Places (n, 3) of a trunk above the ground, away from its border, m."""
    margin = len(heights) // 16
    at = rng.integers(margin, len(heights) - margin, (count, 2))
    return np.column_stack([at * _STEP, heights[at[:, 0], at[:, 1]] + rng.uniform(*_HEIGHTS, count)])


def _under(heights: Floats, places: Floats) -> Floats:
    """(n,) how high the ground is under places (n, 3) over points of it, m."""
    i, j = np.round(places[:, :2] / _STEP).astype(int).T
    return np.asarray(heights[i, j])


def _leaning(count: int, rng: np.random.Generator) -> Floats:
    """Unit quaternions (n, 4), x, y, z, w: any heading, and a little roll and pitch."""
    heading, lean = rng.uniform(-np.pi, np.pi, count) / 2, rng.uniform(-_LEAN, _LEAN, (count, 2)) / 2
    found = np.column_stack([lean, np.sin(heading), np.cos(heading)])
    return np.asarray(found / np.linalg.norm(found, axis=1)[:, None])
