"""How far an approximation of a body sticks out of it or falls short of it: one-sided Hausdorff distances.

In: points, or balls, and a convex body of vertices and outward triangles. Out: the greatest distance of any of them
from the body, in m. For an approximation inside the body, the body's vertices are measured from the approximation; for
one around it, the other way round. The distance to a convex body is a convex function, so vertices are enough.
"""

from __future__ import annotations

import numpy as np

from plannercheck.bodies.piece_repair import facet_planes
from plannercheck.bodies.polytope import Polytope
from plannercheck.common.array_types import Floats

# Pairs of points and triangles that are measured at once, to bound memory.
_BLOCK = 1_000_000


def furthest(points: Floats, body: Polytope) -> float:
    """The greatest distance (m) of points (n, 3) from a body with volume, its radius left out; 0 if all are inside."""
    outside = points[heights(points, body) > 0]
    step = max(1, _BLOCK // len(body.faces))
    blocks = [outside[k : k + step] for k in range(0, len(outside), step)]
    return max((float(_to_triangles(block, body.vertices[body.faces]).max()) for block in blocks), default=0.0)


def furthest_of_balls(centres: Floats, radii: Floats, body: Polytope) -> float:
    """The greatest distance (m) of a point of balls from a body with volume.

    From a centre inside, it is the radius less the distance to the nearest facet's plane: along its normal the ball
    reaches out furthest.
    """
    reach = heights(centres, body)
    outside = reach > 0
    reach[outside] = [furthest(centre[None], body) for centre in centres[outside]]
    return max(0.0, float((reach + radii).max()))


def heights(points: Floats, body: Polytope) -> Floats:
    """For each of points (n, 3) the greatest signed distance from a facet's plane, (n,), m: at most 0 inside."""
    normals, offsets = facet_planes(body)
    step = max(1, _BLOCK // len(normals))
    blocks = [points[k : k + step] @ normals.T - offsets for k in range(0, len(points), step)]
    return np.concatenate([block.max(axis=1) for block in blocks]) if blocks else np.zeros(0)


def _to_triangles(points: Floats, corners: Floats) -> Floats:
    """Distances (n,) of points (n, 3) from the nearest of triangles (m, 3, 3)."""
    to_edges = [_to_segments(points, corners[:, k], corners[:, (k + 1) % 3]) for k in range(3)]
    to_inside = _to_interiors(points, corners)
    return np.asarray(np.minimum(np.minimum.reduce(to_edges), to_inside).min(axis=1))


def _to_segments(points: Floats, start: Floats, end: Floats) -> Floats:
    along = end - start
    squares = np.maximum(np.einsum("ij,ij->i", along, along), np.finfo(float).tiny)
    t = np.clip((points @ along.T - np.einsum("ij,ij->i", start, along)) / squares, 0, 1)
    return np.asarray(np.linalg.norm(points[:, None] - (start + t[..., None] * along), axis=2))


def _to_interiors(points: Floats, corners: Floats) -> Floats:
    """Distances (n, m) from the planes, infinite where a point does not lie over the triangle."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)
    height = (points @ normals.T - np.einsum("ij,ij->i", normals, corners[:, 0])) / lengths
    over = np.ones(height.shape, dtype=bool)
    for k in range(3):
        inward = np.cross(normals, corners[:, (k + 1) % 3] - corners[:, k])
        over &= points @ inward.T >= np.einsum("ij,ij->i", inward, corners[:, k])
    return np.where(over, np.abs(height), np.inf)
