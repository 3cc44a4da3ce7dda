"""Whether convex pieces hold every triangle of a mesh, decided exactly.

In: triangles and the vertices of pieces, in doubles. Out: which triangles lie in the union of the pieces.

The idea: a triangle is in a piece if its corners are. A triangle that is in no single piece is cut into four at the
middles of its edges, again and again. The corners of the parts are no doubles, but whole numbers: weights of the
triangle's corners, which sum to a power of two. Signs against the planes of a piece's facets are computed in doubles
with a proved bound; signs that the bound leaves open are computed in integers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plannercheck.bodies.integers import on_one_scale
from plannercheck.bodies.polytope import Polytope
from plannercheck.common.array_types import Bools, Floats, Ints64
from plannercheck.common.arrays import distinct

# The sign of (p - a) · n for n = (b - a) × (c - a) and p = Σ w_i c_i: differences, products and sums round at most 13
# times, each by 2^-53 of the sum of the terms' sizes; 24 leaves room for computing that sum in doubles.
_SIDE_ERROR = 24 * 2.0**-53
# Products that underflow err by less than this: coordinates are below 1e50 m.
_UNDERFLOW = 1e-200
# Corners against facets that are held at once.
_MOST_SIGNS = 1 << 22


@dataclass(frozen=True, eq=False)
class Parts:
    """Parts of triangles, all cut equally often.

    Attributes:
        triangles: (m, 3, 3) m, the corners of the whole triangles.
        source: (m,) which triangle of the mesh each one is.
        weights: (m, 3, 3) of each corner of the part, the weights of the triangle's corners; they sum to `whole`.
        whole: A power of two.
    """

    triangles: Floats
    source: Ints64
    weights: Ints64
    whole: int

    @staticmethod
    def of(triangles: Floats) -> Parts:
        """Whole triangles (m, 3, 3)."""
        weights = np.tile(np.eye(3, dtype=np.int64), (len(triangles), 1, 1))
        return Parts(triangles, np.arange(len(triangles)), weights, 1)

    def __len__(self) -> int:
        return len(self.triangles)

    @property
    def corners(self) -> Floats:
        """(m, 3, 3) m, rounded."""
        return np.asarray((self.weights / self.whole) @ self.triangles)

    def of_rows(self, rows: Bools | Ints64) -> Parts:
        """Some of the parts."""
        return Parts(self.triangles[rows], self.source[rows], self.weights[rows], self.whole)

    def quartered(self) -> Parts:
        """Each part cut at the middles of its edges: (4 m)."""
        a, b, c = (self.weights[:, k] for k in range(3))
        ab, bc, ca, twice = a + b, b + c, c + a, 2 * self.weights
        cut = [(twice[:, 0], ab, ca), (ab, twice[:, 1], bc), (ca, bc, twice[:, 2]), (ab, bc, ca)]
        weights = np.concatenate([np.stack(each, axis=1) for each in cut])
        return Parts(np.tile(self.triangles, (4, 1, 1)), np.tile(self.source, 4), weights, 2 * self.whole)


def uncovered(triangles: Floats, pieces: Sequence[Floats], deepest: int) -> Ints64:
    """Indices of triangles (m, 3, 3) that are not proved to lie in the union of convex pieces of vertices (n, 3), m.

    Those left out lie in the union, exactly. A triangle is cut `deepest` times at most.
    """
    hulls = [Polytope(points) for points in pieces]
    parts = Parts.of(triangles)
    for depth in range(deepest + 1):
        held = np.zeros(len(parts), dtype=bool)
        for hull in hulls:
            rows = np.flatnonzero(~held)
            held[rows] = are_inside(parts.of_rows(rows), hull)
        parts = parts.of_rows(~held)
        if depth < deepest:
            parts = parts.quartered()
    return distinct(parts.source)


def are_inside(parts: Parts, hull: Polytope) -> Bools:
    """(m,) whether parts lie in a convex body, exactly; bodies without volume hold none."""
    inside = np.zeros(len(parts), dtype=bool)
    if hull.dimension < 3:
        return inside
    vertices, corners = np.asarray(hull.vertices), parts.corners
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    margin = 1e-9 * (high - low).max()  # only to leave out what is far away
    near = np.flatnonzero(((corners >= low - margin) & (corners <= high + margin)).all(axis=(1, 2)))
    facets = vertices[np.asarray(hull.faces)]
    step = max(1, _MOST_SIGNS // (3 * len(facets)))
    for first in range(0, len(near), step):
        rows = near[first : first + step]
        inside[rows] = _are_within(parts.of_rows(rows), facets)
    return inside


def _are_within(parts: Parts, facets: Floats) -> Bools:
    """(m,) whether all corners of parts are on the inner side of facets (f, 3, 3), or on their planes."""
    a = facets[:, 0]
    (ux, uy, uz), (vx, vy, vz) = (facets[:, 1] - a).T, (facets[:, 2] - a).T
    normals = np.stack([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx])
    ux, uy, uz, vx, vy, vz = map(np.abs, (ux, uy, uz, vx, vy, vz))
    sizes = np.stack([uy * vz + uz * vy, uz * vx + ux * vz, ux * vy + uy * vx])
    shares = (parts.weights / parts.whole).reshape(-1, 3, 3)
    points = (shares @ parts.triangles).reshape(-1, 3)
    reach = (shares @ np.abs(parts.triangles)).reshape(-1, 3)
    sides = points @ normals - np.einsum("fk,kf->f", a, normals)
    errors = _SIDE_ERROR * (reach @ sizes + np.einsum("fk,kf->f", np.abs(a), sizes)) + _UNDERFLOW
    out = (sides > errors).any(axis=1)
    corner, facet = np.nonzero((np.abs(sides) <= errors) & ~out[:, None])
    if len(corner):
        weights, triangles = parts.weights.reshape(-1, 3), np.repeat(parts.triangles, 3, axis=0)
        beyond = _beyond_exactly(weights[corner], triangles[corner], parts.whole, facets[facet])
        out[corner[beyond]] = True
    return np.asarray(~out.reshape(-1, 3).any(axis=1))


def _beyond_exactly(weights: Ints64, triangles: Floats, whole: int, facets: Floats) -> Bools:
    """(k,) whether points, weights (k, 3) of triangles (k, 3, 3), are beyond the planes of facets (k, 3, 3)."""
    numbers = on_one_scale(np.stack([triangles, facets]))
    corners, (a, b, c) = numbers[0], (numbers[1][:, k] for k in range(3))
    point = sum(weights[:, k, None].astype(object) * corners[:, k] for k in range(3)) - whole * a
    (ux, uy, uz), (vx, vy, vz), (px, py, pz) = (b - a).T, (c - a).T, point.T
    value = px * (uy * vz - uz * vy) + py * (uz * vx - ux * vz) + pz * (ux * vy - uy * vx)
    return np.asarray(value > 0, dtype=bool)
