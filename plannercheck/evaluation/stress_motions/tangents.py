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
from plannercheck.robots.robot import Robot

# The kernel's joint kinds (JointKind in cpp/robots/joints.hpp): unit turns, and joints of several numbers.
_CIRCLES = range(4, 8)
_PLANAR, _BALL, _FREE = 9, 10, 11
# Numbers of a configuration and of a tangent vector that a part takes.
_WIDTHS = {**dict.fromkeys(_CIRCLES, (2, 1)), _PLANAR: (4, 3), _BALL: (4, 3), _FREE: (7, 6)}
# Of a tangent vector, which are lengths: of planar and floating joints the first ones.
_LENGTHS = {_PLANAR: 2, _FREE: 3}

# Below this angle, rad, sin(a) / a and the like are taken from their series.
_SMALL = 1e-4


@dataclass(frozen=True)
class Tangents:
    """The tangent space of a robot's configurations.

    Attributes:
        linear: Columns that are angles or lengths of their own.
        parts: Kind, first column, first number in a tangent vector, of what takes several numbers.
        slides: (dimension,) which numbers of a tangent vector are lengths, m, else angles, rad.
        turning: (dimension,) which numbers are angles of which only the short way counts.
        owners: (dimension,) the joint, or column, that each number belongs to.
        path: How planar and floating joints move.
    """

    linear: Ints64
    parts: tuple[tuple[int, int, int], ...]
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
            width, tangent = _WIDTHS[kind]
            move = _moved_straight if self.path == "slerp" and kind in _LENGTHS else _moved
            out[:, column : column + width] = move(
                kind, out[:, column : column + width], way[:, first : first + tangent]
            )
        return out


def tangents_of(robot: Robot, path: MotionPath = "screw") -> Tangents:
    """The tangent space of a robot that the compiled kernel poses; `path` is how planar and floating joints move."""
    table = robot.joint_table
    assert table is not None
    found = sorted(
        {
            (int(columns[0]), kind)
            for kind, columns in zip(table.kinds.tolist(), table.columns.tolist(), strict=True)
            if kind in _WIDTHS and columns[0] >= 0
        }
    )
    covered = {column + k for column, kind in found for k in range(_WIDTHS[kind][0])}
    linear = np.array([c for c in range(robot.nq) if c not in covered], dtype=np.int64)
    lengths = {
        int(columns[0])
        for kind, columns in zip(table.kinds.tolist(), table.columns.tolist(), strict=True)
        if kind == 8 and columns[0] >= 0
    }
    free = np.isinf(robot.lower) & np.isinf(robot.upper)
    slides, turning = [c in lengths for c in linear.tolist()], free[linear].tolist()
    owners, parts = linear.tolist(), []
    for column, kind in found:
        parts.append((kind, column, len(slides)))
        many, straight = _WIDTHS[kind][1], _LENGTHS.get(kind, 0)
        slides += [k < straight for k in range(many)]
        turning += [k >= straight for k in range(many)]
        owners += [column] * many
    return Tangents(
        linear, tuple(parts), np.array(slides, bool), np.array(turning, bool), np.array(owners, np.int64), path
    )


def _moved(kind: int, q: Floats, way: Floats) -> Floats:
    if kind in _CIRCLES:
        return _turned_circle(q, way[:, 0])
    if kind == _PLANAR:
        return np.hstack([q[:, :2] + _planar_shift(q[:, 2:], way), _turned_circle(q[:, 2:], way[:, 2])])
    if kind == _BALL:
        return _product(q, _exponential(way))
    shift = _rotated(q[:, 3:], _screw_shift(way[:, :3], way[:, 3:]))
    return np.hstack([q[:, :3] + shift, _product(q[:, 3:], _exponential(way[:, 3:]))])


def _moved_straight(kind: int, q: Floats, way: Floats) -> Floats:
    """Planar or floating joints whose position and turn move by themselves."""
    count = _LENGTHS[kind]
    turn = _turned_circle(q[:, 2:], way[:, 2]) if kind == _PLANAR else _product(q[:, 3:], _exponential(way[:, 3:]))
    return np.hstack([q[:, :count] + way[:, :count], turn])


def _turned_circle(q: Floats, angle: Floats) -> Floats:
    whole = np.arctan2(q[:, 1], q[:, 0]) + angle
    return np.stack([np.cos(whole), np.sin(whole)], axis=1)


def _planar_shift(circle: Floats, way: Floats) -> Floats:
    """Where a planar twist (v, w) takes the origin, in the parent's frame."""
    zero = np.zeros(len(way))
    own = _screw_shift(np.stack([way[:, 0], way[:, 1], zero], 1), np.stack([zero, zero, way[:, 2]], 1))
    c, s = circle[:, 0], circle[:, 1]
    return np.stack([c * own[:, 0] - s * own[:, 1], s * own[:, 0] + c * own[:, 1]], axis=1)


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
