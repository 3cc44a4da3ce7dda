"""The penetration depth of two bodies: the shortest translation that separates them, between proved bounds.

In: two prepared bodies that overlap, and their poses. Out: a `Depth`, which is what `signed_distance` says of bodies
that overlap, without its points.
"""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from plannercheck.bodies.distance import pair_bounds
from plannercheck.bodies.given_bodies import GivenBody
from plannercheck.common.array_types import Floats
from plannercheck.common.public_names import set_module


@set_module("plannercheck")
@dataclass(frozen=True)
class Depth:
    """How deep two bodies are in each other.

    Attributes:
        depth: A translation of the first body by this along `direction` separates the bodies, up to contact, m, rounded
            up; 0 if they share no point. Of solids and sets of parts it is the shortest that is found, at most the
            depth of their hulls and of the boxes around sets.
        lower_bound: No shorter translation separates them, m. Of two convex bodies, and of any body and a half-space,
            the two differ by rounding only. Of solids and sets of parts it is the depth of the deepest two convex
            pieces, see `signed_distance`.
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
    """The penetration depth of two posed bodies of any size, inflation radii included.

    Args:
        P: A body, as for `intersects`.
        R: Another body.
        pose_p: Pose (4, 4) of P in the world, m; None is the identity.
        pose_r: Pose (4, 4) of R in the world, m.

    Returns:
        The depth.

    Raises:
        PlannercheckError: If a pose is not finite or not rigid.
    """
    overlap, (upper, _, _, lower, direction) = pair_bounds(P, R, pose_p, pose_r, depths=True)
    return Depth(0.0 - lower, 0.0 - upper, direction) if overlap else Depth(0.0, 0.0, direction)
