"""Overlaps that hold for a range of configurations: two bodies share a point at all of them.

In: a checker, a configuration, by how much each number may change. Out: whether a pair is proved to overlap at every
configuration of that box.

Where numbers change by e, no point of a body leaves its place by more than μ: joint by joint from the body to its root,
a point is moved by e times its distance from the joint's axis, which has grown by at most what the joints after it have
moved the point, seen from the joint. If two bodies that are moved by μ and ν no longer meet, then a translation by
μ + ν along the normal of a plane between them separated them where they were. Translations of a convex body that meet
another convex one form a convex set. So it is enough that bodies meet after twelve translations whose hull, an
icosahedron, has the ball of radius μ + ν in it. Each is judged exactly. A ball that inflates a body is a ball however
it is turned, so that the vertices are all that counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from plannercheck.bodies.intersection import intersects
from plannercheck.bodies.polytope import Polytope
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct
from plannercheck.motions.checker import Checker
from plannercheck.robots.configurations import PLAIN

# Corners of an icosahedron around the unit ball: its inner radius is 0.7947 of the outer one, and rounding has room.
_GOLDEN = (1 + 5**0.5) / 2
_CORNERS = np.array([np.roll([0.0, a, b * _GOLDEN], k) for k in range(3) for a, b in product((-1.0, 1.0), repeat=2)])
_TRANSLATIONS = _CORNERS / np.linalg.norm(_CORNERS[0]) * (1.001 / 0.7946)

# How many of the first numbers are lengths, for joints of several numbers.
_LENGTHS = {"JointModelFreeFlyer": 3, "JointModelPlanar": 2}

# Rounding of poses, velocities and lengths, and unit vectors that are off (`MOST_OFF`), as a part of all lengths, m.
_ROUNDING = 2.0**-32


class Overlap(NamedTuple):
    """A pair that overlaps.

    Attributes:
        pair: Row of the checker's pairs.
        depth: Proved: no shorter translation separates the bodies, m.
    """

    pair: int
    depth: float


class _Arms(NamedTuple):
    """How joints move a body, from its own joint to the root's.

    Attributes:
        columns: (k,) of Pinocchio's velocities.
        arms: (k,) how far a point of the body moves for 1 rad or 1 m, at most, m.
        turns: (k,) 1 for a joint that turns, 0 for one that slides.
    """

    columns: list[int]
    arms: list[float]
    turns: list[float]


class Overlaps:
    """Proves overlaps for one checker."""

    def __init__(self, checker: Checker, low: Floats, high: Floats) -> None:
        """Takes a checker, and the least and the largest (nq,) of each number of configurations; rad and m."""
        self._checker, robot = checker, checker.robot
        self._model, self._data = robot.model, robot.model.createData()
        self._error = 2 * robot.kinematic_error_within(low, high)
        names = set(robot.link_names)
        self._joints = [
            int(robot.model.frames[robot.model.getBodyId(body.link)].parentJoint) if body.link in names else 0
            for body in checker.bodies
        ]
        self._polytopes = checker.polytopes
        kinds = [None if body is None else body.kind for body in self._polytopes]
        self._is_convex = np.array(
            [kind == "hull" or (kind == "half_space" and not at) for kind, at in zip(kinds, self._joints, strict=True)]
        )

    def shared(self, q: Floats, changes: Sequence[Floats]) -> Overlap | None:
        """The first pair that overlaps at q (nq,) and all around it, numbers changed as in one of `changes` (nq,)."""
        checker = self._checker
        rows = np.flatnonzero(checker.colliding_pairs(q[None])[0])
        rows = rows[self._is_convex[checker.pairs[rows]].all(axis=1)]
        if not len(rows):
            return None
        poses, rates = checker.body_poses(q[None])[0], [self._rates(change) for change in changes]
        full = checker.robot.expand(q)
        speeds = np.asarray(pin.computeJointJacobians(self._model, self._data, full))
        for row in rows.tolist():
            a, b = checker.pairs[row].tolist()
            arms = [self._arms(body, poses[body], speeds) for body in (a, b)]
            for rate in rates:
                away = self._error + sum(_away(each, rate) for each in arms)
                away += _ROUNDING * (1.0 + float(np.abs(poses[[a, b], :3, 3]).max()))
                if np.isfinite(away) and self._meet(a, b, poses, away):
                    return Overlap(row, away)
        return None

    def moved(self, q: Floats, change: Floats) -> Floats:
        """(bodies,) how far points of each body leave their places at q (nq,) where numbers change, at most; m."""
        poses, rates = self._checker.body_poses(q[None])[0], self._rates(change)
        speeds = np.asarray(pin.computeJointJacobians(self._model, self._data, self._checker.robot.expand(q)))
        used = distinct(self._checker.pairs).tolist()
        found = np.zeros(len(poses))
        found[used] = [_away(self._arms(body, poses[body], speeds), rates) for body in used]
        return found

    def _meet(self, a: int, b: int, poses: Floats, radius: float) -> bool:
        """Whether two convex bodies meet after all translations by no more than a radius."""
        p, r = needed(self._polytopes, a), needed(self._polytopes, b)
        moved = np.repeat(poses[a][None], len(_TRANSLATIONS), axis=0)
        moved[:, :3, 3] += radius * _TRANSLATIONS
        return bool(np.all(intersects(p, r, moved, np.ascontiguousarray(poses[b]))))

    def _arms(self, body: int, pose: Floats, speeds: Floats) -> _Arms:
        """The arms of a body at a pose (4, 4); `speeds`: (6, nv) of the world's origin, and angular, by joint."""
        polytope, joint = needed(self._polytopes, body), self._joints[body]
        if not joint:
            return _Arms([], [], [])
        points = polytope.vertices @ pose[:3, :3].T + pose[:3, 3]
        columns = [
            column
            for own in reversed(self._model.supports[joint].tolist()[1:])
            for column in range(
                self._model.joints[own].idx_v, self._model.joints[own].idx_v + self._model.joints[own].nv
            )
        ]
        linear, angular = speeds[:3, columns].T, speeds[3:, columns].T
        moved = linear[:, None] + np.cross(angular[:, None], points[None])
        arms = np.linalg.norm(moved, axis=2).max(axis=1) * (1 + _ROUNDING) + _ROUNDING
        return _Arms(columns, arms.tolist(), np.linalg.norm(angular, axis=1).tolist())

    def _rates(self, change: Floats) -> Floats:
        """(nv,) by how much Pinocchio's joints change, from above; infinite where unit vectors change."""
        sources, model = self._checker.robot.configuration_map, self._model
        numbers = np.where(sources.columns >= 0, np.abs(sources.multipliers) * change[sources.columns], 0.0)
        rates = np.zeros(model.nv)
        for joint in list(model.joints)[1:]:
            own, first = numbers[joint.idx_q : joint.idx_q + joint.nq], joint.idx_v
            is_angle = bool((sources.roles[joint.idx_q : joint.idx_q + joint.nq] != PLAIN).all())
            lengths = _LENGTHS.get(joint.shortname(), 0)
            if joint.nq == 1 or (joint.nv == 1 and is_angle):
                rates[first] = own.max()
            elif not own[lengths:].any():
                rates[first : first + lengths] = np.linalg.norm(own)
            else:
                rates[first : first + joint.nv] = np.inf
        return rates


def needed(polytopes: Sequence[Polytope | None], body: int) -> Polytope:
    """The prepared body of a pair, which has one."""
    found = polytopes[body]
    assert found is not None
    return found


def _away(arms: _Arms, rates: Floats) -> float:
    """How far points of a body leave their places at most, where joints change by `rates`; m."""
    away = 0.0
    for column, arm, turn in zip(*arms, strict=True):
        if rates[column] > 0.0:
            away += float(rates[column]) * (arm + turn * away)
    return away * (1 + _ROUNDING)
