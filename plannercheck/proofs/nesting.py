"""Whether one body of a pair is inside the other, where their surfaces never meet: decided at the start of a motion.

In: a pair of bodies of which one at least is a solid, at poses in ball arithmetic. Out: nothing, or an `UnprovedError`.
While two surfaces do not meet, the winding number of each about every point of the other stays the same. So one state
decides, and one point of each connected part of a surface. A ray from the point crosses triangles to one side or the
other, and the sum is the winding number. Signs are signs of determinants in doubles beyond a bound of their errors. If
a ray comes too near to an edge, another ray is taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct
from plannercheck.proofs.data import PosedBody
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.parts import VERTICES

# Rays that are tried from a point.
_RAYS = 24
# Vertices in a frame (n, 3), m, and how far each coordinate may be off, m.
Placed: TypeAlias = tuple[Floats, float]

# Covers the rounding of a determinant of three rows, as a part of the product of their lengths, and of bounds.
_ROUNDING = 64 * 2.0**-53


def check_not_nested(a: PosedBody, pose_a: Any, b: PosedBody, pose_b: Any) -> None:
    """Raises an `UnprovedError` unless both bodies are shown to be outside of each other.

    Their poses are 4 x 4 maps into one frame, in ball arithmetic.
    """
    first, second = _placed(a, pose_a), _placed(b, pose_b)
    _check_outside(a, first, b, second)
    _check_outside(b, second, a, first)


def _check_outside(inner: PosedBody, points: Placed, outer: PosedBody, corners: Placed) -> None:
    """Raises an `UnprovedError` unless each part of one body's surface is outside of the other body."""
    if not outer.triangles or not is_closed(outer):
        return
    around, error = corners[0][_winding_triangles(outer)], corners[1] + points[1]
    for row in _within_box(_samples(inner), points[0], corners[0], error):
        if _winding(around - points[0][row], error) != 0:
            raise UnprovedError(f"{inner.name!r} ({inner.label!r}) is inside {outer.name!r} ({outer.label!r})")


def _within_box(rows: Sequence[int], points: Floats, corners: Floats, error: float) -> list[int]:
    """The rows whose points are not surely outside of the box around the corners."""
    room = (error + float(np.abs(corners).max()) * _ROUNDING) * (1 + _ROUNDING)
    low, high = corners.min(axis=0) - room, corners.max(axis=0) + room
    own = points[list(rows)]
    outside = ((own < low) | (own > high)).any(axis=1)
    return [row for row, is_out in zip(rows, outside.tolist(), strict=True) if not is_out]


def is_closed(body: PosedBody) -> bool:
    """Whether the directed edges of a solid cancel."""
    a, b = _triangles(body)[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).T
    many = len(body.vertices)
    return np.array_equal(np.sort(a * many + b), np.sort(b * many + a))


def _triangles(body: PosedBody) -> NDArray[np.int64]:
    return np.array(body.triangles, dtype=np.int64).reshape(-1, 3)


def _winding_triangles(body: PosedBody) -> NDArray[np.int64]:
    """The triangles of three corners; others are segments or points, which wind about nothing."""
    triangles = _triangles(body)
    a, b, c = triangles.T
    distinct: NDArray[np.bool_] = (a != b) & (b != c) & (c != a)
    return triangles[distinct]


def _samples(body: PosedBody) -> list[int]:
    """A vertex of each connected part of a surface, or of each part of a set; any of a convex body."""
    if body.parts:
        return list(range(0, len(body.vertices), VERTICES[body.parts]))
    if not body.triangles:
        return [0]
    part = np.arange(len(body.vertices))
    triangles = _triangles(body)
    while True:  # the least index spreads over shared corners
        least = part[triangles].min(axis=1)
        spread = part.copy()
        np.minimum.at(spread, triangles.ravel(), np.repeat(least, 3))
        spread = spread[spread]
        if np.array_equal(spread, part):
            return [int(k) for k in distinct(part[triangles])]
        part = spread


def _placed(body: PosedBody, pose: Any) -> Placed:
    """Vertices (n, 3) in the frame, in doubles, and how far each coordinate may be off."""
    entries = pose.entries()[:12]
    middle = np.array([float(x.mid()) for x in entries]).reshape(3, 4)
    loose = np.array([float(x.rad()) for x in entries]).reshape(3, 4) + np.abs(middle) * _ROUNDING
    vertices = body.vertices.reshape(-1, 3)
    sizes = np.append(np.abs(vertices).max(axis=0, initial=0.0), 1.0)
    return vertices @ middle[:, :3].T + middle[:, 3], float((loose @ sizes).max()) * (1 + _ROUNDING)


def _winding(corners: Floats, error: float) -> int:
    """How often triangles (n, 3, 3) wind about the origin; each coordinate is off by at most `error`."""
    error += float(np.abs(corners).max(initial=0.0)) * _ROUNDING  # of the differences
    for ray in np.random.default_rng(0).normal(size=(_RAYS, 3)):
        found = _crossings(corners, ray / np.linalg.norm(ray), error)
        if found is not None:
            return found
    raise UnprovedError("a point of one body is too near to the other one's surface for its winding number to be sure")


def _crossings(corners: Floats, ray: Floats, error: float) -> int | None:
    """The signed crossings of a ray; None if a sign is not sure."""
    a, b, c = corners.transpose(1, 0, 2)
    sides = np.stack([_signs(ray[None], first, second, error, 0.0) for first, second in ((a, b), (b, c), (c, a))])
    outside = (sides == 1).any(axis=0) & (sides == -1).any(axis=0)
    sure = (sides == sides[0]).all(axis=0) & (sides[0] != 0)
    if not (outside | sure).all():
        return None
    heights = _signs(a[sure], b[sure], c[sure], error, error)
    if (heights == 0).any():
        return None
    side = sides[0][sure]
    return int(side[heights == side].sum())


def _signs(a: Floats, b: Floats, c: Floats, error: float, error_a: float) -> NDArray[np.int64]:
    """(n,) the signs of determinants of rows, 0 where they are not sure; rows are off by so much in each coordinate."""
    value = (a * np.cross(b, c)).sum(axis=1)
    x, y, z = (np.abs(row).sum(axis=1) for row in (a, b, c))
    off, off_a = 3 * error, 3 * error_a
    bound = (x + off_a) * (y + off) * (z + off) - x * y * z + _ROUNDING * (x + off_a) * (y + off) * (z + off)
    sign = np.sign(value).astype(np.int64)
    return np.where(np.abs(value) > bound * (1 + _ROUNDING) + 1e-290, sign, 0)
