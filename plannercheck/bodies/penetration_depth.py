"""The penetration depth of two bodies: the shortest translation that separates them, between proved bounds.

In: two prepared bodies of few vertices that overlap, and their poses. Out: a `Depth`. The differences of their vertices
span the Minkowski difference, in which the origin lies; the depth is the origin's distance from its boundary. The hull
of the differences is built with exact predicates. Along the normal of each of its triangles, the overlap of the
vertices is the length of a translation that separates the bodies: the least one is an upper bound. The origin's
distance from the nearest triangle is a lower bound. Inflation radii add to both. Both bounds are proved: rounding is
added to the upper one and subtracted from the lower one.

The number of differences is the product of the numbers of vertices, so this is for small bodies. For any bodies,
`distance` bounds the depth from above.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.distance import distance
from plannercheck.bodies.given_bodies import GivenBody, given_polytope
from plannercheck.bodies.kinds import Kind
from plannercheck.bodies.polytope import Polytope
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module

# The most differences of vertices: their hull takes some tenths of a second.
MOST_DIFFERENCES = 100_000

# The rounding of posed points, differences and products (some ten operations), as a part of all lengths in a bound.
_ROUNDING = 64 * 2.0**-53

# A triangle's normal, the product of two of its edges, errs by less than 4 u of the longest edge's square; so does the
# height over the triangle, a product with a corner, relative to the corner's length. Twice that is taken.
_NORMAL_ROUNDING = 8 * 2.0**-53


# Why there is none.
_NO_DEPTHS: dict[Kind, str] = {
    "solid": "depths are of convex bodies: take hulls, pc.Polytope(solid.vertices)",
    "half_space": "depths are of bounded bodies: into a half-space, take -distance(...).lower_bound",
}


@set_module("plannercheck")
@dataclass(frozen=True)
class Depth:
    """How deep two bodies are in each other.

    Attributes:
        depth: A translation of the first body by this along `direction` separates the bodies, up to contact, m, rounded
            up; 0 if they share no point.
        lower_bound: No shorter translation separates them, m. The two differ by rounding only, unless the hull of the
            differences has needle-like triangles.
        direction: (3,) unit vector in the world.
    """

    depth: float
    lower_bound: float
    direction: Floats


@set_module("plannercheck")
def depth(
    P: GivenBody,
    R: GivenBody,
    pose_p: ArrayLike | None = None,
    pose_r: ArrayLike | None = None,
) -> Depth:
    """The penetration depth of two posed bodies, inflation radii included.

    Args:
        P: A body, as for `intersects`.
        R: Another body; the product of the numbers of vertices is at most `MOST_DIFFERENCES`.
        pose_p: Pose (4, 4) of P in the world, m; None is the identity.
        pose_r: Pose (4, 4) of R in the world, m.

    Returns:
        The depth.

    Raises:
        PlannercheckError: If a pose is not finite or not rigid, a body is a solid or a half-space, or there are too
            many vertices.
    """
    P, pose_p = given_polytope(P, pose_p, "P")
    R, pose_r = given_polytope(R, pose_r, "R")
    for kind, reason in _NO_DEPTHS.items():
        if kind in (P.kind, R.kind):
            raise PlannercheckError(reason)
    count = len(P.vertices) * len(R.vertices)
    if count > MOST_DIFFERENCES:
        raise PlannercheckError(
            f"depths are for small bodies: {len(P.vertices)} times {len(R.vertices)} vertices are more than "
            f"{MOST_DIFFERENCES}; distance(...).lower_bound bounds the depth of any bodies"
        )
    poses = [pose_p, pose_r]
    apart = distance(P, R, *poses)
    if apart.distance > 0:
        return Depth(0.0, 0.0, apart.direction)
    inflation_radius = P.inflation_radius + R.inflation_radius
    hulls = distance(Polytope(P.vertices), Polytope(R.vertices), *poses) if inflation_radius > 0 else apart
    on_p, on_r = (b.vertices @ pose[:3, :3].T + pose[:3, 3] for b, pose in zip((P, R), poses, strict=True))
    extent = float(np.abs(on_p).max() + np.abs(on_r).max()) + inflation_radius
    rounding = _ROUNDING * extent
    if hulls.distance > 0:  # only the inflation radii overlap: their sum less the distance is the depth
        upper = inflation_radius - hulls.lower_bound + rounding
        return Depth(upper, max(inflation_radius - hulls.distance - rounding, 0.0), hulls.direction)
    differences = (on_p[:, None] - on_r).reshape(-1, 3)
    hull = Polytope(differences)
    normals = _normals(hull)
    reached = (hull.vertices @ normals.T).max(axis=0)
    best = int(reached.argmin())
    upper = max(float(reached[best]), 0.0) + inflation_radius + rounding
    lower = max(float(_from_triangles(hull).min()) - rounding, 0.0) if hull.dimension == 3 else 0.0
    return Depth(upper, lower + inflation_radius * (1 - _ROUNDING), -normals[best])


def _normals(hull: Polytope) -> Floats:
    """(k, 3) unit normals to try: the outward normals of the triangles; for a flat hull both normals of its plane."""
    a, b, c = (hull.vertices[hull.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    if hull.dimension < 3:
        _, _, axes = np.linalg.svd(hull.vertices - hull.vertices.mean(axis=0))
        normals = np.array([axes[2], -axes[2]])
    lengths = np.linalg.norm(normals, axis=1)
    return np.asarray(normals[lengths > 0] / lengths[lengths > 0, None])


def _from_triangles(hull: Polytope) -> Floats:
    """At most the origin's distance from each triangle of a hull that holds it, (m,).

    Over a triangle the distance is the height; beside it, it is the distance from the edges. Where rounding leaves open
    which one applies, the smaller one counts. For a needle it is at least the distance from its edges less its width.
    """
    corners = hull.vertices[hull.faces]
    edges = np.roll(corners, -1, axis=1) - corners
    lengths = np.linalg.norm(edges, axis=2)
    squares = np.maximum(lengths**2, np.finfo(float).tiny)
    t = np.clip(-(corners * edges).sum(axis=2) / squares, 0, 1)
    furthest = np.linalg.norm(corners, axis=2).max(axis=1)
    from_edges = np.linalg.norm(corners + t[..., None] * edges, axis=2).min(axis=1) - _ROUNDING * furthest
    normals = np.cross(edges[:, 0], edges[:, 1])
    areas, longest = np.linalg.norm(normals, axis=1), lengths.max(axis=1)
    error = _NORMAL_ROUNDING * (longest**2 + areas)  # of the normal
    inward = np.cross(normals[:, None], edges)
    inside = -(corners * inward).sum(axis=2)
    beside = (inside < -(error * furthest * longest)[:, None]).any(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        height = (np.abs((corners[:, 0] * normals).sum(axis=1)) - error * furthest) / (areas + error)
    needle = from_edges - (areas + error) / longest
    over = np.fmax(np.fmin(height, from_edges), needle)
    return np.asarray(np.where(beside, from_edges, over))
