"""Moves configurations along tangent vectors, to make motions through a chosen state.

In: a robot's joints, configurations, tangent vectors. Out: configurations. A motion from `moved(q, -t d)` to
`moved(q, (1 - t) d)` is at q at the parameter t, for all kinds of joints: single numbers move linearly; circles, ball,
planar and floating joints move along one screw, seen from the moving frame (Pinocchio's `integrate`, independent of the
core). On the path "slerp", positions of planar and floating joints move straight, seen from the parent's frame, and
turns as those of ball joints.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.motion_paths import MotionPath
from plannercheck.robots.joints import KINDS, JointKind
from plannercheck.robots.robot import Robot

# Numbers of a tangent vector that a turn takes.
_TURNS = {"pair": 1, "quaternion": 3}

# Below this angle, rad, sin(a) / a and the like are taken from their series.
_SMALL = 1e-4


@dataclass(frozen=True)
class Tangents:
    """The tangent space of a robot's configurations.

    Attributes:
        linear: Columns that are angles or lengths of their own.
        parts: Kind, first column, first number in a tangent vector, of joints with a unit vector.
        slides: (dimension,) which numbers of a tangent vector are lengths, m, else angles, rad.
        turning: (dimension,) which numbers are angles of which only the short way counts.
        owners: (dimension,) the joint, or column, that each number belongs to.
        path: How planar and floating joints move.
    """

    linear: Ints64
    parts: tuple[tuple[JointKind, int, int], ...]
    slides: NDArray[np.bool_]
    turning: NDArray[np.bool_]
    owners: Ints64
    path: MotionPath = "screw"

    @property
    def dimension(self) -> int:
        """Numbers in a tangent vector."""
        return len(self.slides)

    def moved(self, q: Floats, way: Floats) -> Floats:
        """Configurations (n, nq) moved by tangent vectors (n, dimension)."""
        out = np.array(np.broadcast_to(q, (len(way), q.shape[-1])))
        out[:, self.linear] += way[:, : len(self.linear)]
        for kind, column, first in self.parts:
            own = slice(column, column + kind.numbers)
            out[:, own] = _moved(kind, out[:, own], way[:, first : first + _width(kind)], self.path)
        return out


def tangents_of(robot: Robot, path: MotionPath = "screw") -> Tangents:
    """The tangent space of a robot that the compiled kernel poses; `path` is how planar and floating joints move."""
    table = robot.joint_table
    assert table is not None
    pairs = zip((KINDS[k] for k in table.kinds.tolist()), table.columns.tolist(), strict=True)
    moved = [(columns, kind) for kind, columns in pairs if columns[0] >= 0]
    found = sorted({columns[0]: kind for columns, kind in moved if kind.unit}.items())
    covered = {column + k for column, kind in found for k in range(kind.numbers)}
    linear = np.array([c for c in range(robot.nq) if c not in covered], dtype=np.int64)
    lengths = {column for columns, kind in moved if not kind.unit for column in columns[: kind.lengths]}
    free = np.isinf(robot.lower) & np.isinf(robot.upper)
    slides, turning = [c in lengths for c in linear.tolist()], free[linear].tolist()
    owners, parts = linear.tolist(), []
    for column, kind in found:
        parts.append((kind, column, len(slides)))
        turns = _TURNS[kind.turn]
        slides += [True] * kind.lengths + [False] * turns
        turning += [False] * kind.lengths + [True] * turns
        owners += [column] * _width(kind)
    return Tangents(
        linear, tuple(parts), np.array(slides, bool), np.array(turning, bool), np.array(owners, np.int64), path
    )


def _width(kind: JointKind) -> int:
    """How many numbers of a tangent vector a joint with a unit vector takes."""
    return kind.lengths + _TURNS[kind.turn]


def _moved(kind: JointKind, q: Floats, way: Floats, path: MotionPath) -> Floats:
    """The numbers (n, numbers) of one joint, moved: it slides along a screw, or straight, and turns."""
    shift = way[:, : kind.lengths]
    if kind.is_pose and path != "slerp":
        shift = _SCREW_SHIFTS[kind.turn](q[:, kind.lengths :], way)
    turned = _TURNED[kind.turn](q[:, kind.lengths :], way[:, kind.lengths :])
    return np.hstack([q[:, : kind.lengths] + shift, turned])


def _turned_circle(q: Floats, angle: Floats) -> Floats:
    whole = np.arctan2(q[:, 1], q[:, 0]) + angle[:, 0]
    return np.stack([np.cos(whole), np.sin(whole)], axis=1)


def _turned_ball(q: Floats, turn: Floats) -> Floats:
    return _product(q, _exponential(turn))


def _planar_shift(circle: Floats, way: Floats) -> Floats:
    """Where a planar twist (v, w) takes the origin, in the parent's frame."""
    zero = np.zeros(len(way))
    own = _screw_shift(np.stack([way[:, 0], way[:, 1], zero], 1), np.stack([zero, zero, way[:, 2]], 1))
    c, s = circle[:, 0], circle[:, 1]
    return np.stack([c * own[:, 0] - s * own[:, 1], s * own[:, 0] + c * own[:, 1]], axis=1)


def _floating_shift(q: Floats, way: Floats) -> Floats:
    """The same for a twist in space."""
    return _rotated(q, _screw_shift(way[:, :3], way[:, 3:]))


def _screw_shift(slide: Floats, turn: Floats) -> Floats:
    """Where a twist takes the origin in unit time, in the frame at its begin."""
    angle = np.linalg.norm(turn, axis=1)[:, None]
    small, safe = angle < _SMALL, np.where(angle > 0, angle, 1)
    first = np.where(small, 0.5 - angle**2 / 24, 2 * np.sin(safe / 2) ** 2 / safe**2)
    second = np.where(small, 1 / 6 - angle**2 / 120, (safe - np.sin(safe)) / safe**3)
    across = np.cross(turn, slide)
    return np.asarray(slide + first * across + second * np.cross(turn, across))


def _exponential(turn: Floats) -> Floats:
    """Unit quaternions (n, 4), x y z w, of rotation vectors (n, 3)."""
    angle = np.linalg.norm(turn, axis=1)[:, None]
    part = np.where(angle > 0, np.sin(angle / 2) / np.where(angle > 0, angle, 1), 0.5)
    return np.hstack([part * turn, np.cos(angle / 2)])


def _product(a: Floats, b: Floats) -> Floats:
    v, w = a[:, :3], a[:, 3:]
    x, y = b[:, :3], b[:, 3:]
    found = np.hstack([w * x + y * v + np.cross(v, x), w * y - (v * x).sum(axis=1, keepdims=True)])
    return np.asarray(found / np.linalg.norm(found, axis=1)[:, None])


def _rotated(q: Floats, v: Floats) -> Floats:
    twice = 2 * np.cross(q[:, :3], v)
    return np.asarray(v + q[:, 3:] * twice + np.cross(q[:, :3], twice))


# By how a joint turns: where its screw takes it, and its turn's numbers after a rotation.
_SCREW_SHIFTS = {"pair": _planar_shift, "quaternion": _floating_shift}
_TURNED = {"pair": _turned_circle, "quaternion": _turned_ball}
