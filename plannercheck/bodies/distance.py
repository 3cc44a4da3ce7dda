"""The distance of two posed bodies, between proved bounds, and the nearest points (cpp/narrow_phase/distance).

In: two prepared bodies and their poses. Out: a `Distance`. The descent of Gilbert, Johnson and Keerthi runs on the
hierarchies until the gap along a plane's normal equals the distance of two points. Near contact it continues in
double-double. Whether the bodies share a point is always the exact verdict.
"""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from plannercheck.bodies.given_bodies import GivenBody, given_polytope
from plannercheck.bodies.half_space_certificates import is_of_half_space
from plannercheck.bodies.pair_queries import queries
from plannercheck.common.array_types import Floats
from plannercheck.common.core import core
from plannercheck.common.public_names import set_module


@set_module("plannercheck")
@dataclass(frozen=True)
class Distance:
    """How far apart two bodies are.

    Attributes:
        distance: In m, within 1e-9 of max(distance, 1e-3 of the larger body's radius), or within 1e-319 m, where
            doubles are too coarse, wherever the bodies are; 0 if and only if they share a point, by the exact verdict.
        point_p: (3,) in the world, m: the first body's point nearest to the second body. If they overlap: the first
            body's point that is deepest in the second body along `direction`.
        point_r: (3,) in the world, m: the second body's point nearest to the first body. If they overlap: where
            `point_p` is after the translation that separates them.
        lower_bound: A proved lower bound of the distance, m. If the bodies overlap it is negative: a translation of
            that length separates them, and the shortest such translation is no longer. It is the shortest one if only
            the inflation radii overlap, not the hulls. Else it is the shortest along all facets' normals, the boxes'
            axes and the centres' axis; directions at right angles to two edges are not tried. Of solids it is that of
            their hulls, of sets of parts that of the boxes around them. Into a half-space it is the depth, rounded up.
        direction: (3,) of length 1 up to rounding, from the second to the first body: along it they are about
            `lower_bound` apart, or the first body has to be moved.
    """

    distance: float
    point_p: Floats
    point_r: Floats
    lower_bound: float
    direction: Floats


@set_module("plannercheck")
def distance(
    P: GivenBody,
    R: GivenBody,
    pose_p: ArrayLike | None = None,
    pose_r: ArrayLike | None = None,
) -> Distance:
    """The distance of two posed bodies, inflation radii included.

    Args:
        P: A body, as for `intersects`.
        R: Another body.
        pose_p: Pose (4, 4) of P in the world, m; None is the identity. Used as the affine map that its doubles give.
        pose_r: Pose (4, 4) of R in the world, m.

    Returns:
        The distance with nearest points.

    Raises:
        PlannercheckError: If a pose is not finite or not rigid.
    """
    known = queries.distance(P, R, pose_p, pose_r)
    if known is None:
        return distance_checked(P, R, pose_p, pose_r)
    apart, lower_bound, (point_p, point_r, direction) = known
    return Distance(apart, point_p, point_r, lower_bound, direction)


def distance_checked(
    P: GivenBody, R: GivenBody, pose_p: ArrayLike | None = None, pose_r: ArrayLike | None = None
) -> Distance:
    """`distance` for whatever users give: converted, and checked in Python, whose errors say what is wrong."""
    P, pose_p = given_polytope(P, pose_p, "P")
    R, pose_r = given_polytope(R, pose_r, "R")
    is_of_half_space(P, R)  # which refuses two of them
    overlap, found, lower, on_p, on_r, along = core.distance_batch(P.core, pose_p[None], R.core, pose_r[None])
    return Distance(0.0 if overlap[0] else float(found[0]), on_p[0], on_r[0], float(lower[0]), along[0])
