"""Convex pieces grown until they hold every triangle of a mesh, which is decided exactly.

In: a mesh and pieces that about hold it, as CoACD gives them. Out: grown pieces whose union holds the mesh.

A triangle whose corners are within `slack` of one piece is added to that piece; any other triangle is cut into four,
down to the depth `DEEPEST`. A piece with the corners of a triangle holds the triangle. Distances from pieces are in
doubles, so an exact test follows whether each part of a triangle is in its piece (`exact_coverage`). Corners of parts
are rounded, so a part may still stick out; then its corners are added again, moved away from the piece's middle by a
millionth of a millimetre or so.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plannercheck.bodies.exact_coverage import Parts, are_inside
from plannercheck.bodies.pieces import Pieces, extreme, hull_volume
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.protrusion import protrusion
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct_rows
from plannercheck.common.errors import PlannercheckError

# How often a triangle is halved at most: from 1 m down to 4 mm; after that, a piece grows by more than the slack.
DEEPEST = 8

# Corners this deep in a piece, as a part of its size, are taken as inside at first.
_SURELY_INSIDE = 1e-12

# By how much corners are moved outwards, as a part of their distance from the piece's middle, each time that they are
# added again.
_FURTHER = (1e-12, 1e-9, 1e-6, 1e-3)


def repaired(mesh: TriangleMesh, pieces: Sequence[Floats], slack: float) -> Pieces:
    """Pieces grown until they hold every triangle of the mesh.

    Args:
        mesh: The mesh.
        pieces: Points (n, 3) of each piece, m.
        slack: How far a triangle may stick out of a piece and still be added to it, m.

    Returns:
        The grown pieces.

    Raises:
        PlannercheckError: If they can't be made to hold the mesh, since they are flat.
    """
    planes = [facet_planes(Polytope(points)) for points in pieces]
    owned: list[list[Parts]] = [[] for _ in pieces]
    added: list[list[Floats]] = [[] for _ in pieces]
    excess = growth = 0.0
    parts = Parts.of(mesh.points[mesh.triangles])
    for depth in range(DEEPEST + 1):
        outside = np.stack([_beyond(parts.corners, each) for each in planes], axis=2)  # (m, 3, pieces)
        excess = max(excess, float(outside.min(axis=2).max(initial=0.0)))
        whole = outside.max(axis=1)
        best = whole.argmin(axis=1)
        least = whole[np.arange(len(whole)), best]
        held = (least <= slack) | (depth == DEEPEST)
        growth = max(growth, float(least[held].max(initial=0.0)))
        for k, (normals, _) in enumerate(planes):
            mine = held & (best == k)
            size = float(np.abs(pieces[k]).max(initial=1e-3)) if len(normals) else 0.0
            added[k].append(parts.corners[mine][outside[mine, :, k] > -_SURELY_INSIDE * size])
            owned[k].append(parts.of_rows(mine))
        parts = parts.of_rows(~held).quartered()
        if not len(parts):
            break
    grown = tuple(
        _holding(extreme([points, *more]), parts) for points, more, parts in zip(pieces, added, owned, strict=True)
    )
    volume = sum(hull_volume(points) for points in grown)
    return Pieces(grown, excess, growth, protrusion(grown, mesh), mesh.volume, hull_volume(mesh.points), volume)


def _holding(points: Floats, owned: Sequence[Parts]) -> Floats:
    """A piece (n, 3), m, grown a little until it holds its parts exactly."""
    middle = points.mean(axis=0)
    for further in (0.0, *_FURTHER):
        hull = Polytope(points)
        missing = [parts.of_rows(~are_inside(parts, hull)).corners.reshape(-1, 3) for parts in owned]
        outer = np.concatenate(missing)
        if not len(outer):
            return points
        points = extreme([points, outer + further * (outer - middle)])
    raise PlannercheckError(
        f"a convex piece of {len(points)} vertices can't be made to hold the {len(outer) // 3} parts of triangles in it"
    )


def facet_planes(polytope: Polytope) -> tuple[Floats, Floats]:
    """Outward unit normals (f, 3) and offsets (f,), m, of a hull's triangles; none without volume."""
    a, b, c = (polytope.vertices[polytope.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    kept = lengths[:, 0] > 0
    normals = normals[kept] / lengths[kept]
    return normals, np.einsum("ij,ij->i", normals, a[kept])


def _beyond(triangles: Floats, planes: tuple[Floats, Floats]) -> Floats:
    """(m, 3) how far corners (m, 3, 3) are beyond the furthest plane, negative inside; at most their distance, m."""
    normals, offsets = planes
    if not len(normals):
        return np.full(triangles.shape[:2], np.inf)
    points, index = distinct_rows(triangles.reshape(-1, 3))
    return np.asarray((points @ normals.T - offsets).max(axis=1)[index.reshape(-1)].reshape(-1, 3))
