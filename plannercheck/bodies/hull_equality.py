"""Whether a mesh bounds its convex hull, decided exactly: such a solid is tested as its hull.

In: points and triangles of a mesh. Out: one truth value. A closed mesh whose triangles all lie in the boundary of its
hull winds equally often about all inner points of the hull; if that is not 0 times, it covers the boundary, and the
solid is the hull. A triangle with a vertex of the hull lies in the boundary if and only if it lies in the plane of a
facet at that vertex; for any other triangle, all facets are tried. Signs of determinants in doubles have a proved
bound; signs that the bound leaves open are computed in integers.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.core_polytopes import core_polytope
from plannercheck.bodies.integers import on_one_scale
from plannercheck.common.array_types import Bools, Floats, Ints, Ints64

# The determinant of orient3d in doubles errs by at most (7 + 56 u) u times its permanent, u = 2^-53 (Shewchuk,
# "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", section 4.3); 8 leaves room.
_ORIENTATION_ERROR = 8 * 2.0**-53
# Coordinates are scaled to at most 1; products, or coordinates, that underflow err by less than this.
_UNDERFLOW = 2.0**-1000
# A volume is summed from products of three numbers: their roundings, and those of the sum, a term each.
_VOLUME_ERROR = 2.0**-52
_CORNERS = 3

# Triangles and facets that are compared at first, and at most at once: a concave mesh is mostly known by a few.
_FIRST_PAIRS, _MOST_PAIRS = 1 << 10, 1 << 20
# Up to this many points, a hull is computed faster than it is found in the cache.
_FEW_POINTS = 32


def is_hull(points: Floats, triangles: Ints, is_closed: bool) -> bool:
    """Whether a mesh, with what it encloses, is its convex hull; each point (n, 3), m, occurs once and is used.

    True only if it is. False for a mesh with a volume only if it is not; flat meshes are their hulls if one triangle
    has all the hull's vertices.
    """
    hull = core_polytope(points, cached=len(points) > _FEW_POINTS)
    source = hull.source()
    if hull.dimension < 3:
        has_all = [(triangles == vertex).any(axis=1) for vertex in source.tolist()[: _CORNERS + 1]]
        return bool(np.logical_and.reduce(has_all).any())
    if not is_closed:
        return False
    signs = _Signs(points)
    return _lie_in_boundary(triangles, source[hull.triangles()], signs) and signs.volume_sign(triangles) != 0


def _lie_in_boundary(triangles: Ints, facets: Ints, signs: _Signs) -> bool:
    """Whether all triangles (k, 3) lie in the planes of facets (m, 3) of the hull."""
    order = np.argsort(facets.ravel(), kind="stable")
    at_vertex = (order // 3).astype(np.int64)  # facets, by their corners
    degree = np.bincount(facets.ravel(), minlength=signs.count)
    first = np.cumsum(degree) - degree
    # The corner that is in the fewest facets of the hull.
    degrees = np.where(degree[triangles] > 0, degree[triangles], len(facets) + 1)
    chosen = triangles[np.arange(len(triangles)), degrees.argmin(axis=1)]
    has_vertex = degree[chosen] > 0
    with_vertex, without = np.flatnonzero(has_vertex), np.flatnonzero(~has_vertex)
    counts = degree[chosen[with_vertex]]
    for rows in _parts(counts):
        corner = chosen[with_vertex[rows]]
        owner = np.repeat(np.arange(len(rows)), counts[rows])
        step = np.arange(len(owner)) - np.repeat(np.cumsum(counts[rows]) - counts[rows], counts[rows])
        candidates = at_vertex[first[corner][owner] + step]
        on = signs.in_plane(triangles[with_vertex[rows]][owner], facets[candidates])
        if not np.bincount(owner[on], minlength=len(rows)).all():
            return False
    for rows in _parts(np.full(len(without), len(facets))):
        owner = np.repeat(np.arange(len(rows)), len(facets))
        on = signs.in_plane(triangles[without[rows]][owner], np.tile(facets, (len(rows), 1)))
        if not np.bincount(owner[on], minlength=len(rows)).all():
            return False
    return True


def _parts(counts: NDArray[np.int64]) -> Iterator[Ints64]:
    """Ranges of rows with a few pairs each (`counts` of a row), then with more and more."""
    ends = np.cumsum(counts)
    start, most = 0, _FIRST_PAIRS
    while start < len(counts):
        before = int(ends[start - 1]) if start else 0
        stop = max(start + 1, int(np.searchsorted(ends, before + most, side="right")))
        yield np.arange(start, stop)
        start, most = stop, min(8 * most, _MOST_PAIRS)


class _Signs:
    """Signs of determinants of points, without rounding."""

    def __init__(self, points: Floats) -> None:
        self.count = len(points)
        self._points = points
        self._scaled = np.ldexp(points, -int(np.frexp(np.abs(points).max())[1]))

    def in_plane(self, triangles: Ints, facets: Ints) -> Bools:
        """(k,) whether triangles (k, 3) lie in the planes of facets (k, 3)."""
        on = np.ones(len(triangles), dtype=bool)
        for is_in_plane in (self._may_be_in_plane, self._is_in_plane):  # the first costs less, and settles most
            for corner in range(_CORNERS):
                rows = np.flatnonzero(on)
                point = triangles[rows, corner]
                is_own = (facets[rows] == point[:, None]).any(axis=1)
                rows, point = rows[~is_own], point[~is_own]
                if len(rows):
                    on[rows] = is_in_plane(point, facets[rows])
        return on

    def _may_be_in_plane(self, points: Ints, facets: Ints) -> Bools:
        """(k,) False where doubles prove a determinant not to be 0."""
        d = self._scaled[points].T
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (self._scaled[facets[:, k]].T - d for k in range(3))
        minors = ((bx * cy, cx * by, az), (cx * ay, ax * cy, bz), (ax * by, bx * ay, cz))
        value, size = np.zeros(len(points)), np.zeros(len(points))
        for plus, minus, height in minors:
            value += (plus - minus) * height
            size += (np.abs(plus) + np.abs(minus)) * np.abs(height)
        return np.asarray(np.abs(value) <= _ORIENTATION_ERROR * size + _UNDERFLOW)

    def _is_in_plane(self, points: Ints, facets: Ints) -> Bools:
        d = self._integers[points]
        a, b, c = (self._integers[facets[:, k]] - d for k in range(3))
        return np.asarray(_determinant(a, b, c) == 0, dtype=bool)

    def volume_sign(self, triangles: Ints) -> int:
        """The sign of the volume that closed triangles (k, 3) enclose, each region times its winding number."""
        a, b, c = (self._scaled[triangles[:, k]] for k in range(3))
        volume = float(_determinant(a, b, c).sum())
        size = float(_determinant(np.abs(a), np.abs(b), np.abs(c), 1).sum())
        if abs(volume) > _VOLUME_ERROR * (len(triangles) + 8) * size + _UNDERFLOW * len(triangles):
            return 1 if volume > 0 else -1
        a, b, c = (self._integers[triangles[:, k]] for k in range(3))
        exact = int(_determinant(a, b, c).sum())
        return (exact > 0) - (exact < 0)

    @cached_property
    def _integers(self) -> NDArray[np.object_]:
        return on_one_scale(self._points)


def _determinant(a: NDArray, b: NDArray, c: NDArray, sign: int = -1) -> NDArray:  # type: ignore[type-arg]
    """(k,) the determinants of rows a, b, c (k, 3) of numbers of any kind; their permanents if `sign` is 1."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = a.T, b.T, c.T
    value: NDArray = (  # type: ignore[type-arg]
        ax * (by * cz + sign * (bz * cy)) + ay * (bz * cx + sign * (bx * cz)) + az * (bx * cy + sign * (by * cx))
    )
    return value
