"""The distance of two posed bodies, between proved bounds, and the nearest points (cpp/narrow_phase/distance).

In: two prepared bodies and their poses. Out: a `Distance`. The descent of Gilbert, Johnson and Keerthi runs on the
hierarchies until the gap along a plane's normal equals the distance of two points. Near contact it continues in
double-double. Whether the bodies share a point is always the exact verdict. If they do, an expanding polytope finds how
deep they are in each other (cpp/narrow_phase/penetration_depth).
"""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from plannercheck.bodies.given_bodies import GivenBody, given_polytope, queries
from plannercheck.bodies.kinds import are_bounded
from plannercheck.common.array_types import Floats
from plannercheck.common.core import core
from plannercheck.common.public_names import set_module


@set_module("plannercheck")
@dataclass(frozen=True)
class Distance:
    """How far apart two bodies are, or how deep they are in each other.

    The signed distance of bodies that overlap is minus their penetration depth, the length of the shortest translation
    of one body that separates them up to contact. It is 0 where they touch.

    Attributes:
        distance: In m. Bodies apart: within 1e-9 of max(distance, 1e-3 of the larger body's radius), or within
            1e-319 m, where doubles are too coarse, wherever the bodies are. Bodies that share a point, by the exact
            verdict: 0 as `distance` gives it; an upper bound of the signed distance, 0 at most, as `signed_distance`
            gives it.
        point_p: (3,) in the world, m: the first body's point nearest to the second body. If they overlap: the first
            body's point that is deepest in the second body along `direction`.
        point_r: (3,) in the world, m: the second body's point nearest to the first body. If they overlap: where
            `point_p` is after the translation that separates them.
        lower_bound: A proved lower bound of the signed distance, m. If the bodies overlap it is negative: a translation
            of the first body by that length along `direction` separates them. Of convex bodies it is the signed
            distance up to rounding, about 1e-14 of their size and of their distance from the origins of their frames.
            Of solids it is that of their hulls, of sets of parts that of the boxes around them: a shorter translation
            may separate these, and `signed_distance` looks for one. Into a half-space it is minus the depth of any
            body, rounded down.
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
    """The distance of two posed bodies, inflation radii included; 0 if and only if they share a point.

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
    overlap, found = pair_bounds(P, R, pose_p, pose_r, depths=False)
    return Distance(0.0, *found[1:]) if overlap else Distance(*found)


@set_module("plannercheck")
def signed_distance(
    P: GivenBody,
    R: GivenBody,
    pose_p: ArrayLike | None = None,
    pose_r: ArrayLike | None = None,
) -> Distance:
    """The signed distance of two posed bodies, inflation radii included: minus the penetration depth if they overlap.

    It is in [`lower_bound`, `distance`] of what is returned, both proved. They differ by rounding, unless one body is a
    solid or a set of parts and both overlap: then `distance` is minus the depth of the deepest two convex pieces, one
    of each body, and `lower_bound` the same up to rounding if the translation that takes these apart separates the
    bodies. Else it is the shortest translation that is found along the ways out of the deepest pieces and of the hulls,
    and along the axes of both bodies' frames, by the exact verdict.

    Pieces of a set are its parts. A solid whose shells are all convex consists of these. Pieces of any other solid are
    its triangles, a box and balls in it: they do not fill it, so that its bounds may stay open.

    Args:
        P: A body, as for `intersects`.
        R: Another body.
        pose_p: Pose (4, 4) of P in the world, m; None is the identity. Used as the affine map that its doubles give.
        pose_r: Pose (4, 4) of R in the world, m.

    Returns:
        The bounds with points.

    Raises:
        PlannercheckError: If a pose is not finite or not rigid.
    """
    return Distance(*pair_bounds(P, R, pose_p, pose_r, depths=True)[1])


Bounds = tuple[float, Floats, Floats, float, Floats]


def pair_bounds(
    P: GivenBody, R: GivenBody, pose_p: ArrayLike | None, pose_r: ArrayLike | None, depths: bool
) -> tuple[bool, Bounds]:
    """Whether two bodies share a point, and a `Distance`'s values with the upper bound of the signed distance.

    `depths`: all pieces of solids and sets that overlap are looked at, for closer bounds.
    """
    known = queries.distance(P, R, pose_p, pose_r, depths)
    if known is None:
        return pair_bounds_checked(P, R, pose_p, pose_r, depths)
    overlap, upper, lower, (point_p, point_r, direction) = known
    return overlap, (upper, point_p, point_r, lower, direction)


def pair_bounds_checked(
    P: GivenBody, R: GivenBody, pose_p: ArrayLike | None, pose_r: ArrayLike | None, depths: bool
) -> tuple[bool, Bounds]:
    """The same for whatever users give: converted, and checked in Python, whose errors say what is wrong."""
    P, pose_p = given_polytope(P, pose_p, "P")
    R, pose_r = given_polytope(R, pose_r, "R")
    are_bounded(P, R)  # which refuses two half-spaces
    overlap, upper, lower, on_p, on_r, along = core.distance_batch(P.core, pose_p[None], R.core, pose_r[None], depths)
    return bool(overlap[0]), (float(upper[0]), on_p[0], on_r[0], float(lower[0]), along[0])
