"""Distances of two posed bodies (cpp/narrow_phase/distance): how far apart they are, between proved bounds, and where.

In: two prepared bodies and their poses. Out: a `Distance`. The descent of Gilbert, Johnson and Keerthi runs on the
hierarchies until a plane's gap and the length between two points meet; near contact it goes on in double-double, and
whether the bodies share a point is always the exact verdict.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.bodies.given_shapes import GivenShape, given_polytope
from plannercheck.bodies.polytope import Polytope
from plannercheck.common.core import core
from plannercheck.common.public_names import set_module

Floats = NDArray[np.float64]


@set_module("plannercheck")
@dataclass(frozen=True)
class Distance:
    """How far apart two bodies are.

    Attributes:
        distance: In m, within 1e-9 of max(distance, 1e-3 of the larger body's radius), or within 1e-319 m, where
            doubles are too coarse; 0 if and only if the bodies share a point, by the exact verdict.
        point_p: (3,) in the world, m: of the first body, nearest to the second. If they overlap: the point of the
            first body that is deepest in the second along the way out that was found.
        point_r: (3,) in the world, m: of the second body, nearest to the first. If they overlap: where `point_p` gets
            when the first body is moved out.
        lower_bound: A proved lower bound of the distance, m. If they overlap it is negative: a translation by so much
            separates them, and the least that does is no longer. Which is found: of disjoint hulls within their
            swells the least one; else the best along all facets' normals, the boxes' axes and the centres' axis,
            where least ones along products of two edges are missed.
        direction: (3,) of length 1 up to rounding, from the second to the first body: along it they are about
            `lower_bound` apart, or to be moved apart.
    """

    distance: float
    point_p: Floats
    point_r: Floats
    lower_bound: float
    direction: Floats


@set_module("plannercheck")
def distance(
    P: Polytope | GivenShape,
    R: Polytope | GivenShape,
    pose_p: ArrayLike | None = None,
    pose_r: ArrayLike | None = None,
) -> Distance:
    """The distance of two posed bodies, swells included.

    Args:
        P: A body, as for `intersects`.
        R: Another.
        pose_p: Pose (4, 4) of P in the world, m; None is the identity. Used as the affine map that its doubles give.
        pose_r: Pose (4, 4) of R in the world, m.

    Returns:
        The distance with nearest points.

    Raises:
        PlannercheckError: If a pose is not finite or not rigid.
    """
    P, pose_p = given_polytope(P, pose_p, "P")
    R, pose_r = given_polytope(R, pose_r, "R")
    overlap, found, lower, on_p, on_r, along = core.distance_batch(P.core, pose_p[None], R.core, pose_r[None])
    return Distance(0.0 if overlap[0] else float(found[0]), on_p[0], on_r[0], float(lower[0]), along[0])
