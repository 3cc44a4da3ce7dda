"""How far convex pieces stick out of the mesh that they stand for: a proved upper bound.

In: the pieces and the mesh. Out: an upper bound of the distance of any point of a piece from the solid that the mesh
bounds. The holes of an open mesh are filled first, by triangles from their edges to their middle.

The idea: branch and bound over boxes that cover a piece. The points of a box are no further from the solid than its
middle is, plus its radius r. A box whose middle is in the solid, at least r away from all triangles, lies within the
solid. Boxes off the piece are left out. All others are cut into eight until they can't be further out than the furthest
known point plus a small tolerance. Distances are the core's, and whether a point is in the solid is exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.intersection import intersects
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.solids import Solid
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import distinct, distinct_rows
from plannercheck.common.core import core
from plannercheck.common.transforms import at_places

# The bound is at most this many times the furthest point that was found, or this part of the mesh's size further.
_RELATIVE, _FINE = 1.2, 4e-3
# Boxes that are looked at in one step at most: after that, the bound is what they give.
_MOST_BOXES = 100_000
# Along its longest side, a piece is cut into this many boxes at first.
_FIRST_BOXES = 4
# Points of each piece that are tried at first, and between how many vertices each is.
_SAMPLES, _CORNERS = 200, 3
# Distances are off by at most this part of the mesh's size; planes that are off by more are not used.
_ROUNDING = 1e-9
# A point's distance from the plane of a triangle with sides u and v errs by less than this times |u| |v| times the
# largest coordinate, over the normal's length: some 13 roundings of sums of at most twelve such terms.
_PLANE_ERROR = 256 * 2.0**-53


def protrusion(pieces: Sequence[Floats], mesh: TriangleMesh) -> float:
    """A proved bound, m, on how far points of pieces, given by vertices (n, 3), are from a mesh and what it encloses.

    Of an open mesh the holes are filled.
    """
    solid = SolidDistances(filled(mesh))
    known, bound = float(solid.apart(_samples(pieces)).max(initial=0.0)), 0.0
    for points in pieces:
        of_piece, known = _of_piece(points, solid, known)
        bound = max(bound, of_piece)
    return bound + _ROUNDING * solid.size


def filled(mesh: TriangleMesh) -> Solid:
    """The solid that a mesh bounds, its holes filled by triangles from their edges to the middle of their corners.

    The edges that have no reverse form closed curves, so each connected curve, with triangles to one point, is closed.
    """
    a, b = mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).T
    low, high = np.minimum(a, b), np.maximum(a, b)
    edges, index = distinct_rows(np.stack([low, high], axis=1))
    surplus = np.zeros(len(edges), dtype=np.int64)
    np.add.at(surplus, index.reshape(-1), np.where(a < b, 1, -1))
    open_edges = np.where(surplus[:, None] < 0, edges, edges[:, ::-1])  # those that are missing
    rim = np.repeat(open_edges, np.abs(surplus), axis=0)
    points, triangles = mesh.points, mesh.triangles
    for curve in _connected(rim):
        middle = points[distinct(curve)].mean(axis=0)
        triangles = np.concatenate([triangles, np.column_stack([curve, np.full(len(curve), len(points))])])
        points = np.concatenate([points, middle[None]])
    return Solid(points, triangles)


def _connected(edges: Ints64) -> list[Ints64]:
    """Edges (k, 2) by connected curve."""
    label = {int(vertex): int(vertex) for vertex in distinct(edges)}

    def root(vertex: int) -> int:
        while label[vertex] != vertex:
            label[vertex] = vertex = label[label[vertex]]
        return vertex

    for a, b in edges.tolist():
        label[root(a)] = root(b)
    of_edge = np.array([root(a) for a in edges[:, 0].tolist()], dtype=np.int64)
    return [edges[of_edge == each] for each in distinct(of_edge)]


class SolidDistances:
    """Distances of points from a closed solid, and from its triangles."""

    def __init__(self, solid: Solid) -> None:
        points, triangles = solid.used
        # A triangle that occurs twice opens the mesh: the solid is then its triangles alone.
        surface = Solid(points, np.concatenate([triangles, triangles[:1]]), "triangles")
        self._point = Polytope(np.zeros((1, 3)))
        self._solid, self._surface = prepared_solid(solid), prepared_solid(surface)
        self.size = float(np.ptp(points, axis=0).max())

    def apart(self, points: Floats) -> Floats:
        """How far points (n, 3) are from the solid, about; 0 if and only if they are in it."""
        found = np.zeros(len(points))
        if len(points):
            is_off = ~np.asarray(intersects(self._point, self._solid, at_places(points)))
            found[is_off] = self._distances(points[is_off], self._solid)[1]
        return found

    def depths(self, points: Floats) -> Floats:
        """How far points (n, 3) are from the solid's triangles, at least."""
        touching, _, lower, *_ = self._distances(points, self._surface)
        return np.where(touching != 0, 0.0, np.maximum(lower, 0.0))

    def _distances(self, points: Floats, body: Polytope) -> tuple[NDArray[Any], ...]:
        """What the core says of points (n, 3): whether they touch, upper and lower bounds, and more."""
        if not len(points):
            return (np.zeros(0),) * 3
        rows: tuple[NDArray[Any], ...] = core.distance_batch(
            self._point.core, at_places(points), body.core, np.eye(4)[None]
        )
        return rows


def prepared_solid(solid: Solid) -> Polytope:
    """A solid, prepared on the hull of its points."""
    return Polytope(solid.used[0]).of_solid(solid)


def _samples(pieces: Sequence[Floats]) -> Floats:
    """Some points (n, 3) of each piece, between few of its vertices."""
    generator = np.random.default_rng(0)
    weights = generator.dirichlet(np.ones(_CORNERS), _SAMPLES)
    chosen = [points[generator.integers(len(points), size=(_SAMPLES, _CORNERS))] for points in pieces]
    samples: Floats = np.einsum("nk,pnki->pni", weights, np.stack(chosen))
    return samples.reshape(-1, 3)


def _of_piece(points: Floats, solid: SolidDistances, known: float) -> tuple[float, float]:
    """An upper bound for one piece, m, and the furthest point known now; one as far out as `known` is known before."""
    normals, offsets = _planes(points, solid.size)
    middles, half = _first_boxes(points)
    bound = 0.0
    while len(middles):
        radius = float(np.linalg.norm(half))
        beyond = (middles @ normals.T - offsets).max(axis=1, initial=-np.inf)  # at most the distance
        is_near = beyond <= radius + 2 * _ROUNDING * solid.size
        middles, beyond = middles[is_near], beyond[is_near]
        apart = solid.apart(middles)
        known = max(known, float(apart.max(where=beyond <= 0, initial=0.0)))
        enough = max(_RELATIVE * known, known + _FINE * solid.size)
        furthest = apart + radius
        cut = np.flatnonzero((apart == 0.0) & (furthest > enough))
        furthest[cut[solid.depths(middles[cut]) >= radius]] = 0.0
        goes_on = furthest > enough
        if goes_on.sum() > _MOST_BOXES:
            goes_on[:] = False
        bound = max(bound, float(furthest.max(where=~goes_on, initial=0.0)))
        half = half / 2
        corners = np.array(list(product((-1.0, 1.0), repeat=3))) * half
        middles = (middles[goes_on][:, None] + corners).reshape(-1, 3)
    return bound, known


def _first_boxes(points: Floats) -> tuple[Floats, Floats]:
    """Middles (n, 3) of equal boxes that cover points, and half their sides (3,)."""
    low, extent = points.min(axis=0), np.ptp(points, axis=0)
    counts = np.maximum(1, np.ceil(_FIRST_BOXES * extent / max(float(extent.max()), 1e-300))).astype(int)
    half = extent / counts / 2
    steps = np.array(list(product(*(range(count) for count in counts.tolist()))))
    return low + half * (2 * steps + 1), half * (1 + _ROUNDING)


def _planes(points: Floats, size: float) -> tuple[Floats, Floats]:
    """Outward unit normals (f, 3) and offsets (f,), m, of a hull's triangles, less those that rounding may have moved.

    Without a plane, only more boxes are looked at.
    """
    hull = Polytope(points)
    if hull.dimension < 3:
        return np.zeros((0, 3)), np.zeros(0)
    a, b, c = (hull.vertices[hull.faces[:, k]] for k in range(3))
    u, v = b - a, c - a
    normals = np.cross(u, v)
    lengths = np.linalg.norm(normals, axis=1)
    terms = np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1) * (np.abs(points).max() + size)
    is_sure = _PLANE_ERROR * terms < _ROUNDING * size * lengths
    normals = normals[is_sure] / lengths[is_sure, None]
    return normals, np.einsum("ij,ij->i", normals, a[is_sure])
