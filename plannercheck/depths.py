"""How deep two bodies are in each other: the least translation that parts them, between proved bounds.

In: two prepared bodies of few vertices that overlap, and their poses. Out: a `Depth`. All differences of their vertices
span the bodies' Minkowski difference, in which the origin lies; the depth is the origin's distance from its boundary.
The hull of the differences is built with exact predicates. Its triangles' normals are directions to try, along each of
which the vertices say how far the bodies are in each other: any of these lengths is enough. The origin's distance from
the nearest triangle bounds all of them from below. What swells add, they add to both.

The number of differences is the product of the vertices' numbers, so this is for small bodies; `distance` bounds the
depth of any from above.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.distances import distance
from plannercheck.errors import PlannercheckError
from plannercheck.hull import Polytope
from plannercheck.shapes import POSED_TOLERANCE, checked_pose

Floats = NDArray[np.float64]

# Differences of vertices: their hull takes some tenths of a second.
MOST_DIFFERENCES = 100_000

# Of all lengths that go into a bound: rounding of posed points, differences and products, some ten operations.
_ROUNDING = 64 * 2.0**-53

# Triangles thinner than this part of their longest edge have no reliable normal; they are as near as their edges, less
# their width.
_THIN = 1e-7


@dataclass(frozen=True)
class Depth:
    """How deep two bodies are in each other.

    Attributes:
        depth: Translating the first body by this along `direction` parts the bodies, up to contact, m; 0 if they share
            no point.
        lower_bound: No shorter translation does, m. Both differ by rounding alone.
        direction: (3,) unit vector in the world.
    """

    depth: float
    lower_bound: float
    direction: Floats


def depth(P: Polytope, R: Polytope, pose_p: ArrayLike | None = None, pose_r: ArrayLike | None = None) -> Depth:
    """How deep two posed bodies are in each other, swells included.

    Args:
        P: A body.
        R: Another; the product of the numbers of vertices is at most `MOST_DIFFERENCES`.
        pose_p: Pose (4, 4) of P in the world, m; None is the identity.
        pose_r: Pose (4, 4) of R in the world, m.

    Returns:
        The depth.

    Raises:
        PlannercheckError: If a pose is not finite or not rigid, or the bodies have too many vertices.
    """
    count = len(P.vertices) * len(R.vertices)
    if count > MOST_DIFFERENCES:
        raise PlannercheckError(
            f"depths are for small bodies: {len(P.vertices)} times {len(R.vertices)} vertices are more than "
            f"{MOST_DIFFERENCES}; distance(...).lower_bound bounds the depth of any bodies"
        )
    poses = [checked_pose(pose, name, POSED_TOLERANCE) for pose, name in ((pose_p, "pose_p"), (pose_r, "pose_r"))]
    apart = distance(P, R, *poses)
    if apart.distance > 0:
        return Depth(0.0, 0.0, apart.direction)
    swell = P.swell + R.swell
    if swell > 0 and distance(Polytope(P.vertices), Polytope(R.vertices), *poses).distance > 0:
        return Depth(-apart.lower_bound, -apart.lower_bound, apart.direction)  # the hulls are apart: nothing is missed
    on_p, on_r = (b.vertices @ pose[:3, :3].T + pose[:3, 3] for b, pose in zip((P, R), poses, strict=True))
    differences = (on_p[:, None] - on_r).reshape(-1, 3)
    hull = Polytope(differences)
    normals = _normals(hull)
    reached = (hull.vertices @ normals.T).max(axis=0)
    best = int(reached.argmin())
    extent = float(np.abs(on_p).max() + np.abs(on_r).max()) + swell
    upper = max(float(reached[best]), 0.0)
    lower = max(float(_from_triangles(hull).min()) - _ROUNDING * extent, 0.0) if hull.dimension == 3 else 0.0
    return Depth(upper + swell, min(lower, upper) + swell, -normals[best])


def _normals(hull: Polytope) -> Floats:
    """(k, 3) unit normals to try: outward ones of the triangles; of a flat hull both of its plane."""
    a, b, c = (hull.vertices[hull.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    if hull.dimension < 3:
        _, _, axes = np.linalg.svd(hull.vertices - hull.vertices.mean(axis=0))
        normals = np.array([axes[2], -axes[2]])
    lengths = np.linalg.norm(normals, axis=1)
    return np.asarray(normals[lengths > 0] / lengths[lengths > 0, None])


def _from_triangles(hull: Polytope) -> Floats:
    """At most the origin's distance from each triangle of a hull, (m,)."""
    corners = hull.vertices[hull.faces]
    edges = np.roll(corners, -1, axis=1) - corners
    squares = np.maximum((edges**2).sum(axis=2), np.finfo(float).tiny)
    t = np.clip(-(corners * edges).sum(axis=2) / squares, 0, 1)
    from_edges = np.linalg.norm(corners + t[..., None] * edges, axis=2).min(axis=1)
    normals = np.cross(edges[:, 0], edges[:, 1])
    areas = np.linalg.norm(normals, axis=1)
    longest = np.sqrt(squares.max(axis=1))
    width = areas / longest
    thin = width < _THIN * longest
    inward = np.cross(normals[:, None], edges)
    above = (-(corners * inward).sum(axis=2) >= 0).all(axis=1)
    height = np.abs((corners[:, 0] * normals).sum(axis=1)) / np.maximum(areas, np.finfo(float).tiny)
    return np.asarray(np.where(thin, from_edges - width, np.where(above, height, from_edges)))
