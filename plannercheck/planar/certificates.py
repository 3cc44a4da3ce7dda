"""Proofs of a verdict about two polygons: a line between them, or a common point.

In: two posed polygons. Out: frozen values in the plane, and `verify`, which proves them in exact arithmetic from the
vertices alone, without the core. A certificate is the certificate of the same polygons as flat bodies in space
(plannercheck/bodies/certificates.py), without the third coordinate.

The certificate is also found here, in integers, by the algorithm of Gilbert, Johnson and Keerthi for the point of A - B
nearest to the origin. In the plane each step keeps at most two vertices, and all its signs are exact, so it ends. If it
contradicts a verdict of the core, the core has a fault.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from itertools import combinations
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies import certificates as space
from plannercheck.bodies.exact_planes import Bodies, PosedBody
from plannercheck.bodies.integers import IntegerHull, Integers, cross, dot, in_common_unit, minus, negated
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.public_names import set_module
from plannercheck.planar.polygons import checked_polygon, checked_poses, intersects


@set_module("plannercheck.planar")
@dataclass(frozen=True, eq=False)
class Separation(OwnsArrays):
    """A line between two polygons: normal · x > offset for all x of the first, < offset for all of the second.

    Attributes:
        normal: Unit vector (2,) in the world, from the second polygon to the first.
        offset: The line is normal · x = offset, in m; halfway between the polygons.
        gap: A lower bound of their distance in m, rounded down.
        plane: The same as a plane in space, with its exact form.
    """

    normal: Floats
    offset: float
    gap: float
    plane: space.Separation = field(repr=False)

    def verify(self) -> bool:
        """Whether the line separates the polygons strictly, proved in exact arithmetic with all their vertices."""
        same = [*self.normal, 0.0] == self.plane.normal.tolist()
        return same and (self.offset, self.gap) == (self.plane.offset, self.plane.gap) and self.plane.verify()


@set_module("plannercheck.planar")
@dataclass(frozen=True, eq=False)
class SharedPoint(OwnsArrays):
    """A point of both polygons.

    Attributes:
        point: (2,) in the world, in m, rounded.
        first: Vertices of the first polygon and weights that mix the point.
        second: The same for the second polygon.
        place: The same as a point in space, with its exact form.
    """

    point: Floats
    first: space.Mixture
    second: space.Mixture
    place: space.SharedPoint = field(repr=False)

    def verify(self) -> bool:
        """Whether the point is in both polygons, proved in exact arithmetic."""
        same = [*self.point, 0.0] == self.place.point.tolist()
        return same and (self.first, self.second) == (self.place.first, self.place.second) and self.place.verify()


Certificate: TypeAlias = Separation | SharedPoint


@set_module("plannercheck.planar")
def certify(
    A: ArrayLike, B: ArrayLike, pose_a: ArrayLike | None = None, pose_b: ArrayLike | None = None
) -> Certificate:
    """The verdict of `intersects` with its proof.

    Args:
        A: Vertices (n, 2) of a convex polygon in order, m.
        B: Vertices of another.
        pose_a: Pose (3, 3) of A in the world, m; None is the identity.
        pose_b: Pose (3, 3) of B in the world, m.

    Returns:
        A `Separation`, its normal from B to A, or a `SharedPoint`; in world coordinates.
    """
    shared = intersects(A, B, pose_a, pose_b)
    bodies = _in_space(A, pose_a, "A"), _in_space(B, pose_b, "B")
    certificate = _found(bodies)
    if isinstance(certificate, SharedPoint) != shared:
        raise space.UnprovedVerdictError("exact arithmetic contradicts the core's verdict about two polygons")
    return certificate


def _in_space(vertices: ArrayLike, pose: ArrayLike | None, name: str) -> PosedBody:
    flat = checked_polygon(vertices, name)
    matrix = np.eye(4)
    planar = checked_poses(pose, f"pose of {name}")[0]
    matrix[:2, :2], matrix[:2, 3] = planar[:2, :2], planar[:2, 2]
    return PosedBody(np.column_stack([flat, np.zeros(len(flat))]), matrix)


@dataclass(frozen=True)
class _Difference:
    """A vertex of A less one of B, and the indices of both."""

    vector: Integers
    a: int
    b: int


# The point nearest to the origin in the hull of a few differences (times any positive factor), and weights of sum 1.
_Nearest: TypeAlias = tuple[Integers, dict[_Difference, Fraction]]


def _found(bodies: tuple[PosedBody, PosedBody]) -> Certificate:
    p, r = in_common_unit(*(IntegerHull(body.vertices, body.pose) for body in bodies))
    nearest, mixture = _on_point(_Difference(minus(p.point(0), r.point(0)), 0, 0))
    while any(nearest):
        a, b = p.lowest(nearest), r.lowest(negated(nearest))
        further = _Difference(minus(p.point(a), r.point(b)), a, b)
        if dot(nearest, further.vector) >= dot(nearest, next(iter(mixture)).vector):
            return _separation(nearest, bodies)
        nearest, mixture = _nearest([*mixture, further])
    return _shared_point(mixture, bodies)


def _separation(direction: Integers, bodies: Bodies) -> Separation:
    x, y, z = (Fraction(component) for component in direction)
    plane = space.separation((x, y, z), bodies)
    assert plane is not None
    return Separation(plane.normal[:2], plane.offset, plane.gap, plane)


def _shared_point(mixture: dict[_Difference, Fraction], bodies: Bodies) -> SharedPoint:
    first: dict[int, Fraction] = {}
    second: dict[int, Fraction] = {}
    for difference, weight in mixture.items():
        first[difference.a] = first.get(difference.a, Fraction(0)) + weight
        second[difference.b] = second.get(difference.b, Fraction(0)) + weight
    place = space.shared_point(first, second, bodies)
    return SharedPoint(place.point[:2], place.first, place.second, place)


def _nearest(corners: list[_Difference]) -> _Nearest:
    """The point of a segment or triangle nearest to the origin: the origin if it is inside, else a point of a side."""
    if len(corners) == 3:
        weights = _around_origin(corners)
        if weights is not None:
            return (0, 0, 0), weights
    sides = [_on_segment(a, b) for a, b in combinations(corners, 2)]
    return min(sides, key=lambda side: _squared_distance(side[1]))


def _around_origin(corners: list[_Difference]) -> dict[_Difference, Fraction] | None:
    """Weights that mix the origin, if it is in the triangle."""
    a, b, c = (corner.vector for corner in corners)
    areas = [cross(b, c)[2], cross(c, a)[2], cross(a, b)[2]]
    whole = sum(areas)
    if whole == 0 or any(area * whole < 0 for area in areas):
        return None
    return {corner: Fraction(area, whole) for corner, area in zip(corners, areas, strict=True) if area}


def _on_segment(a: _Difference, b: _Difference) -> _Nearest:
    way = minus(b.vector, a.vector)
    along, square = -dot(a.vector, way), dot(way, way)
    if along <= 0 or along >= square:
        return _on_point(a if along <= 0 else b)
    # Across the segment, towards it from the origin.
    normal = (-way[1], way[0], 0)
    height = dot(normal, a.vector)
    nearest = normal if height > 0 else negated(normal) if height < 0 else (0, 0, 0)
    part = Fraction(along, square)
    return nearest, {a: 1 - part, b: part}


def _on_point(a: _Difference) -> _Nearest:
    return a.vector, {a: Fraction(1)}


def _squared_distance(mixture: dict[_Difference, Fraction]) -> Fraction:
    sums = [sum((w * d.vector[k] for d, w in mixture.items()), Fraction(0)) for k in (0, 1)]
    return sums[0] ** 2 + sums[1] ** 2
