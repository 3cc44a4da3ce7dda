"""Whether points are in the convex hull of others, decided in whole numbers.

In: vertices and points in doubles. Out: the row of a point outside, or None. A point is inside if four of the vertices
carry it: its weights on them, determinants over a determinant, are at least 0. Which four is guessed in doubles, for
all points at once: while a weight is below 0, its vertex is exchanged for the one furthest on the point's side of the
plane of the other three. If doubles leave a sign open, a determinant of whole numbers decides it. Where the guess
fails, the same exchange is done in whole numbers, by least indices if it takes long (Bland's rule), so that it ends:
with four vertices that carry the point, or with a plane beyond which the point alone is.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Bools, Floats

# Points that are looked at together.
_BLOCK = 2000
# Exchanges of the guess; meshes of robots need some ten.
_ROUNDS = 60
# Weights down to this count as 0 for the guess.
_ZERO = 1e-13
# A determinant of three differences errs by less than this part of the product of their lengths' sums.
_ROUNDING = 64 * 2.0**-53

Row: TypeAlias = tuple[int, int, int]


class FlatError(ValueError):
    """The vertices span no volume."""


def point_outside(vertices: Floats, points: Floats) -> int | None:
    """The row of the first of points (m, 3) outside of the hull of vertices (n, 3); None if all are in or on it.

    Raises:
        FlatError: If no four vertices span a volume, as far as doubles tell.
    """
    known = {tuple(row) for row in (vertices + 0.0).tolist()}
    rows = [k for k, row in enumerate((points + 0.0).tolist()) if tuple(row) not in known]
    exact = _Whole(vertices, points) if rows else None
    first = _spanning(vertices) if rows else ()
    for start in range(0, len(rows), _BLOCK):
        block = rows[start : start + _BLOCK]
        found = _guessed(vertices, points[block], first)
        sure = _surely_inside(vertices, points[block], found)
        for row, basis, is_sure in zip(block, found.tolist(), sure.tolist(), strict=True):
            assert exact is not None
            if not is_sure and not exact.is_inside(row, basis):
                return row
    return None


def _spanning(vertices: Floats) -> tuple[int, ...]:
    """Four vertices that span a volume, far from each other."""
    a = int(np.argmin(vertices[:, 0]))
    away = vertices - vertices[a]
    b = int(np.argmax((away**2).sum(axis=1)))
    normals = np.cross(away, away[b])
    c = int(np.argmax((normals**2).sum(axis=1)))
    heights = np.abs(away @ normals[c])
    d = int(np.argmax(heights))
    if not heights[d] > _ROUNDING * float(np.prod([np.linalg.norm(away[k]) for k in (b, c, d)])):
        raise FlatError
    return a, b, c, d


def _guessed(vertices: Floats, points: Floats, first: Sequence[int]) -> NDArray[np.int64]:
    """(m, 4) of each point the vertices that carry it, as far as doubles tell."""
    lifted = np.column_stack([vertices, np.ones(len(vertices))])
    wanted = np.column_stack([points, np.ones(len(points))])
    basis = np.tile(np.array(first), (len(points), 1))
    open_ = np.arange(len(points))
    for _ in range(_ROUNDS):
        try:
            inverse = np.linalg.inv(lifted[basis[open_]].transpose(0, 2, 1))
        except np.linalg.LinAlgError:
            break
        weights = (inverse @ wanted[open_, :, None])[:, :, 0]
        worst = weights.argmin(axis=1)
        bad = np.flatnonzero(weights.min(axis=1) < -_ZERO)
        rows = inverse[bad, worst[bad]] @ lifted.T
        entering = rows.argmin(axis=1)
        better = rows[np.arange(len(bad)), entering] < -_ZERO
        bad, entering = bad[better], entering[better]
        basis[open_[bad], worst[bad]] = entering
        open_ = open_[bad]
        if not len(open_):
            break
    return basis


def _surely_inside(vertices: Floats, points: Floats, basis: NDArray[np.int64]) -> Bools:
    """(m,) of which points all four weights are above 0 beyond the rounding of doubles."""
    corners = vertices[basis] - points[:, None]
    signs = []
    for k in range(4):
        a, b, c = (corners[:, j] for j in range(4) if j != k)
        value = (a * np.cross(b, c)).sum(axis=1)
        bound = _ROUNDING * np.prod([np.abs(x).sum(axis=1) for x in (a, b, c)], axis=0)
        signs.append(np.where(np.abs(value) > bound, np.sign(value), 0.0) * (1 if k % 2 else -1))
    sure: Bools = (np.array(signs) == signs[0]).all(axis=0) & (signs[0] != 0)
    return sure


class _Whole:
    """Vertices and points as whole numbers of one small unit."""

    def __init__(self, vertices: Floats, points: Floats) -> None:
        self._vertices, self._points = vertices, points
        numbers = np.concatenate([vertices, points]).ravel()
        parts = [float(x).as_integer_ratio()[1] for x in set(numbers.tolist())]
        self._unit = max(parts, default=1)

    def is_inside(self, row: int, basis: Sequence[int]) -> bool:
        """Whether a point is in the hull; `basis`: four vertices that may carry it."""
        point = self._whole(self._points[row])
        corners = [self._whole(self._vertices[k]) for k in basis]
        if not _orientation(*corners):
            basis = _spanning(self._vertices)
        return self._decided(point, sorted(basis))

    def _whole(self, row: Floats) -> Row:
        (x, a), (y, b), (z, c) = (value.as_integer_ratio() for value in row.tolist())
        return x * (self._unit // a), y * (self._unit // b), z * (self._unit // c)

    def _decided(self, point: Row, basis: list[int]) -> bool:
        """The exchange in whole numbers; by least indices, once it takes long, so that it ends."""
        for exchanges in itertools.count():
            corners = [self._whole(self._vertices[k]) for k in basis]
            volume = _orientation(*corners)
            weak = [k for k in range(4) if _with(corners, k, point) * volume < 0]
            if not weak:
                return True
            out = min(weak, key=lambda k: basis[k])
            others = [basis[j] for j in range(4) if j != out]
            for k in self._perhaps_beyond(others, basis[out], exchanges < _ROUNDS):
                if _with(corners, out, self._whole(self._vertices[k])) * volume < 0:
                    basis[out] = k
                    break
            else:
                return False
        raise AssertionError

    def _perhaps_beyond(self, plane: Sequence[int], opposite: int, furthest: bool) -> list[int]:
        """The vertices that doubles do not show to be on one side of a plane of three with another vertex.

        Those furthest on the other side come first, if asked for.
        """
        a, b, c = self._vertices[plane]
        (ux, uy, uz), (vx, vy, vz) = (b - a).tolist(), (c - a).tolist()
        away = self._vertices - a
        sides = away @ np.array([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx])
        lengths = (abs(ux) + abs(uy) + abs(uz)) * (abs(vx) + abs(vy) + abs(vz))
        bound = (_ROUNDING * lengths) * (np.abs(away) @ np.ones(3))
        if not abs(sides[opposite]) > bound[opposite]:
            return list(range(len(away)))
        sides *= np.sign(sides[opposite])
        found = np.flatnonzero(sides < bound)
        order: list[int] = (found[np.argsort(sides[found], kind="stable")] if furthest else found).tolist()
        return order


def _with(corners: Sequence[Row], k: int, point: Row) -> int:
    """The orientation of four corners, of which a point takes the place of the k-th."""
    a, b, c, d = (point if j == k else corners[j] for j in range(4))
    return _orientation(a, b, c, d)


def _orientation(a: Row, b: Row, c: Row, d: Row) -> int:
    """The determinant of b - a, c - a, d - a."""
    (bx, by, bz), (cx, cy, cz), (dx, dy, dz) = ((p[0] - a[0], p[1] - a[1], p[2] - a[2]) for p in (b, c, d))
    return bx * (cy * dz - cz * dy) - by * (cx * dz - cz * dx) + bz * (cx * dy - cy * dx)
