"""Motions of a robot before random sets of parts: no motion that is proved free may have a colliding state.

In: a seed and a number. Out: how many motions were proved free, refused, and missed: proved free although a sampled
state collides. States are judged one by one, as pairs are.
"""

from __future__ import annotations

import warnings
from collections import Counter
from functools import cache

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.height_fields import HeightField
from plannercheck.bodies.lattice_cells import LatticeCells
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.point_clouds import PointCloud
from plannercheck.common.array_types import Floats
from plannercheck.evaluation.stress.contact_poses import random_directions, turns_onto
from plannercheck.evaluation.stress_parts.bodies import Body
from plannercheck.evaluation.stress_parts.given import Balls, Cells, Columns, Given
from plannercheck.evaluation.stress_parts.set_families import SETS, random_set
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

FREE, REFUSED, MISSED = "proved free", "refused", "missed"
OUTCOMES = (FREE, REFUSED, MISSED)
_ROBOT = "panda"
# Of one set: motions, and states along each that is proved free, its ends included.
MOTIONS, _STATES = 60, 96
_COUNTS, _SIZES = (1, 9, 60, 400, 2000), (0.2, 0.5, 1.0, 2.0)
# Where the middle of a set is, m, about which it is off by this standard deviation.
_MIDDLE, _AROUND = np.array([0.45, 0.0, 0.45]), 0.3
# Sets that are further from their own origin, m, are refused: rounding would be no small part of motions' tolerance.
_FARTHEST = 1e3
_SHORTEST, _LONGEST = 0.02, 3.0  # rad
_NAME = "set"


def judge_motions(seed: int, number: int) -> Counter[tuple[str, str]]:
    """Motions before the `number`-th set of a seed, by family and outcome."""
    rng = np.random.default_rng([seed, number])
    family = str(rng.choice(list(SETS)))
    body = random_set(family, int(rng.choice(_COUNTS)), float(rng.choice(_SIZES)), rng)
    if np.abs(body.corners).max() > _FARTHEST:
        return Counter()
    checker = _checker(body, rng)
    start, end = _motions(rng)
    free = np.asarray(checker.check_motions(start, end))
    share = np.linspace(0, 1, _STATES)[:, None, None]
    states = start[free] + share * (end[free] - start[free])
    valid = np.asarray(checker.check_states(states.reshape(-1, start.shape[1]))).reshape(_STATES, -1)
    missed = int((~valid.all(axis=0)).sum())
    found = {FREE: int(free.sum()) - missed, REFUSED: int((~free).sum()), MISSED: missed}
    return Counter({(family, outcome): count for outcome, count in found.items()})


def shape_of(given: Given) -> PartSet:
    """The shape that users would make of a set's numbers."""
    if isinstance(given, Balls):
        return PointCloud(given.points, given.radii)
    if isinstance(given, Cells):
        return Lattice(given)
    assert isinstance(given, Columns)
    steps, origin = ((float(each[0]), float(each[1])) for each in (given.steps, given.origin))
    return HeightField(given.heights, steps, given.base, origin)


class Lattice(LatticeCells):
    """Cells of any size anywhere in a lattice, which neither an octree nor a grid has."""

    def __init__(self, given: Cells) -> None:
        """Takes the numbers as they are."""
        self._given, self.resolution = given, given.step
        self.origin = tuple(given.origin.tolist())

    @property
    def cells(self) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """The boxes."""
        return self._given.keys.astype(np.int32), self._given.sizes.astype(np.int32)


@cache
def _robot() -> Robot:
    return Robot.load(_ROBOT)


def _checker(body: Body, rng: np.random.Generator) -> Checker:
    """The robot before a set, which is turned any way and moved to where the robot reaches."""
    pose = np.eye(4)
    if rng.integers(2):
        pose[:3, :3] = turns_onto(random_directions(1, rng), random_directions(1, rng), rng)[0]
    middle = (body.corners.min(axis=0) + body.corners.max(axis=0)) / 2
    pose[:3, 3] = _MIDDLE + _AROUND * rng.normal(size=3) - pose[:3, :3] @ middle
    scene = Scene()
    scene.add(_NAME, shape_of(body.given), pose)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a set that the robot's fixed base touches
        return Checker(_robot(), scene, padding={_NAME: body.given.padding}, self_collision=False)


def _motions(rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Both ends (n, joints) of motions of any length, rad."""
    robot = _robot()
    start = robot.random_configurations(MOTIONS, seed=int(rng.integers(2**31)))
    way = rng.normal(size=start.shape)
    length = np.exp(rng.uniform(np.log(_SHORTEST), np.log(_LONGEST), size=(MOTIONS, 1)))
    end = start + way * (length / np.linalg.norm(way, axis=1, keepdims=True))
    return start, np.clip(end, robot.lower, robot.upper)
