"""Proofs about a half-space and another body, found in exact arithmetic.

In: two posed bodies, one of them a half-space. Out: a `Separation` along its normal, or a `SharedPoint` at the other
body's vertex that is deepest in it. No other plane can separate them, so nothing has to be searched.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from plannercheck.bodies.certificates import Certificate, SharedPoint, separation, shared_point_at
from plannercheck.bodies.exact_planes import Bodies, CertifiedBody, PosedBody, in_integers
from plannercheck.bodies.integers import IntegerHull, dot
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.posed_half_spaces import PosedHalfSpace, Vector
from plannercheck.common.array_types import Floats


def certified_body(body: Polytope, pose: Floats) -> CertifiedBody:
    """A posed body as certificates have it."""
    if body.traits.is_bounded:
        return PosedBody(body.vertices, pose, body.inflation_radius)
    normal, offset = body.core.shape
    return PosedHalfSpace(np.array(normal), offset, pose, body.inflation_radius)


def certify_half_space(p: Polytope, r: Polytope, pose_p: Floats, pose_r: Floats) -> Certificate:
    """The proof that a half-space and another body, which is no set of parts, share a point, or that they do not."""
    bodies = certified_body(p, pose_p), certified_body(r, pose_r)
    sense, (other, half_space) = (1, bodies) if p.traits.is_bounded else (-1, bodies[::-1])
    assert isinstance(other, PosedBody)
    assert isinstance(half_space, PosedHalfSpace)
    x, y, z = half_space.plane()[0]
    apart = separation((sense * x, sense * y, sense * z), bodies)
    return _contact(half_space, other, bodies) if apart is None else apart


def _contact(half_space: PosedHalfSpace, other: PosedBody, bodies: Bodies) -> SharedPoint:
    """At the deepest vertex, or between it and the plane, in the ratio of the inflation radii."""
    vertex, place = _deepest(half_space, other)
    normal, height = half_space.plane()[0], half_space.height(place)
    radii = Fraction(other.inflation_radius) + Fraction(half_space.inflation_radius)
    part = Fraction(0)
    if height > 0 and radii:
        part = height / dot(normal, normal) * Fraction(other.inflation_radius) / radii
    x, y, z = (u - part * v for u, v in zip(place, normal, strict=True))
    own = {vertex: Fraction(1)}
    first, second = ({}, own) if bodies[0] is half_space else (own, {})
    return shared_point_at((x, y, z), first, second, bodies)


def _deepest(half_space: PosedHalfSpace, other: PosedBody) -> tuple[int, Vector]:
    """The vertex furthest against the normal, and where it is in the world, m."""
    normal, hull = half_space.plane()[0], IntegerHull(other.vertices, other.pose)
    vertex = hull.lowest(in_integers(normal)[0])
    x, y, z = (coordinate * Fraction(2) ** hull.unit for coordinate in hull.point(vertex))
    return vertex, (x, y, z)
