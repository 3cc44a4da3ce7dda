"""Proofs of a verdict about one pair: a separating plane, or a common point.

In: two posed bodies and the core's answer. Out: frozen values in world coordinates, in doubles and in exact form, and
`verify`, which proves them in exact arithmetic from the bodies' vertices alone, without the core.

The idea: a plane or a mixture of vertices is easy to check, whoever found it. All given numbers (vertices, poses as
affine maps, inflation radii) are taken as the exact numbers that their doubles are. A body with an inflation radius
consists of all points within that distance of the hull, so a plane must be at least the inflation radius away from the
vertices. A rational upper bound of the normal's length is enough to check that, so no root is needed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np

from plannercheck.bodies.exact_planes import (
    Bodies,
    CertifiedBody,
    ExactPlane,
    Point,
    PosedBody,
    plane_between,
    separates_exactly,
)
from plannercheck.bodies.integers import IntegerHull
from plannercheck.bodies.posed_half_spaces import PosedHalfSpace
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.exact_numbers import exact_number, is_unit_normal, rounded, rounded_down
from plannercheck.common.public_names import set_module

# More vertices than these are never needed (Carathéodory).
_MOST_VERTICES = 4


class UnprovedVerdictError(PlannercheckError):
    """A verdict of the core that its own certificate does not prove: a fault of the core."""


@dataclass(frozen=True)
class ExactPoint:
    """An exact common point: no further from each body's mixture of vertices than the body's inflation radius.

    Attributes:
        point: In the world, m.
        first: Weights of the first mixture's vertices, at least 0, of sum 1.
        second: Weights of the second mixture's vertices.
    """

    point: Point
    first: tuple[Fraction, ...]
    second: tuple[Fraction, ...]


@dataclass(frozen=True, eq=False)
class Mixture(OwnsArrays):
    """A convex combination of vertices.

    Attributes:
        vertices: Indices into the polytope's vertices (k,), at most four.
        weights: Rounded to doubles (k,).
    """

    vertices: Ints64
    weights: Floats

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Mixture)
            and np.array_equal(self.vertices, other.vertices)
            and np.array_equal(self.weights, other.weights)
        )

    __hash__ = None  # type: ignore[assignment]


@set_module("plannercheck")
@dataclass(frozen=True, eq=False)
class Separation(OwnsArrays):
    """A plane between two bodies: normal · x > offset for all x of the first, < offset for all of the second.

    The doubles are rounded; `exact` gives the plane that separates strictly.

    Attributes:
        normal: Unit vector (3,) in the world, from the second body to the first.
        offset: The plane is normal · x = offset, in m; halfway between the bodies.
        gap: A lower bound of the distance between the bodies in m, inflation radii included, rounded down.
        plane: The plane in exact form.
        bodies: The separated bodies.
    """

    normal: Floats
    offset: float
    gap: float
    plane: ExactPlane = field(repr=False)
    bodies: Bodies = field(repr=False)

    def exact(self) -> ExactPlane:
        """The plane in fractions."""
        return self.plane

    def verify(self) -> bool:
        """Whether the plane separates the two bodies, proved in exact arithmetic with all their vertices.

        Returns:
            True if the exact plane separates strictly, the gap is a lower bound of the distance, and the doubles are
            the exact values, rounded.
        """
        return self._doubles_agree() and separates_exactly(self.plane, self.bodies)

    def _doubles_agree(self) -> bool:
        plane = self.plane
        if not np.isfinite([*self.normal, self.offset, self.gap]).all() or plane.length <= 0:
            return False
        is_normal = is_unit_normal(self.normal.tolist(), plane.normal, plane.length)
        is_offset = self.offset == rounded(plane.offset / plane.length)
        return is_normal and is_offset and 0 <= Fraction(self.gap) <= plane.gap

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Separation)
            and np.array_equal(self.normal, other.normal)
            and (self.offset, self.gap, self.plane) == (other.offset, other.gap, other.plane)
        )

    __hash__ = None  # type: ignore[assignment]


@set_module("plannercheck")
@dataclass(frozen=True, eq=False)
class SharedPoint(OwnsArrays):
    """A point of both bodies.

    Attributes:
        point: (3,) in the world, in m, rounded.
        first: Vertices of the first body and weights that mix the point, or a point within the body's inflation radius
            of it; none of a half-space.
        second: The same for the second body.
        place: Point and weights in exact form.
        bodies: The bodies that share the point.
    """

    point: Floats
    first: Mixture
    second: Mixture
    place: ExactPoint = field(repr=False)
    bodies: Bodies = field(repr=False)

    def exact(self) -> ExactPoint:
        """Point and weights in fractions."""
        return self.place

    def verify(self) -> bool:
        """Whether the point is in both bodies, proved in exact arithmetic.

        Returns:
            True if the exact point is in both bodies, and the doubles are the exact values, rounded.
        """
        return (
            [float(x) for x in self.point] == [rounded(x) for x in self.place.point]
            and _holds_point(self.bodies[0], self.first, self.place.first, self.place.point)
            and _holds_point(self.bodies[1], self.second, self.place.second, self.place.point)
        )

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, SharedPoint)
            and np.array_equal(self.point, other.point)
            and (self.first, self.second, self.place) == (other.first, other.second, other.place)
        )

    __hash__ = None  # type: ignore[assignment]


Certificate: TypeAlias = Separation | SharedPoint


def separation(direction: Point, bodies: Bodies) -> Separation | None:
    """The plane halfway between two bodies along a direction of the world, of any length, from the second to the first.

    None if the bodies' extents along the direction meet.
    """
    plane = plane_between(direction, bodies)
    if plane is None:
        return None
    normal = np.array([rounded(x / plane.length) for x in plane.normal])
    return Separation(normal, rounded(plane.offset / plane.length), rounded_down(plane.gap), plane, bodies)


def mixed_point(found: dict[str, Any], bodies: Bodies) -> SharedPoint:
    """The common point that the core's `certify_pair` found of two bodies, which have the core's vertices."""
    weights = [exact_number(weight) for weight in found["exact_weights"]]
    return shared_point(_merged(found["vertices_a"], weights), _merged(found["vertices_b"], weights), bodies)


def _merged(vertices: Sequence[int], weights: Sequence[Fraction]) -> dict[int, Fraction]:
    """Weights of sum 1 by vertex; a vertex may come more than once."""
    total, merged = sum(weights), dict.fromkeys(map(int, vertices), Fraction(0))
    for vertex, weight in zip(vertices, weights, strict=True):
        merged[int(vertex)] += weight / total
    return merged


def shared_point(first: dict[int, Fraction], second: dict[int, Fraction], bodies: Bodies) -> SharedPoint:
    """The common point of two mixtures of vertices, which must be no further apart than the sum of the inflation radii.

    Weights are of sum 1. The point divides the segment from one mixture to the other in the ratio of the inflation
    radii.
    """
    one, two = bodies
    assert isinstance(one, PosedBody)
    assert isinstance(two, PosedBody)
    p, r = _mixed(one, list(first), first.values()), _mixed(two, list(second), second.values())
    inflation_p, inflation_r = Fraction(bodies[0].inflation_radius), Fraction(bodies[1].inflation_radius)
    part = inflation_p / (inflation_p + inflation_r) if inflation_p else Fraction(0)
    point = (p[0] + part * (r[0] - p[0]), p[1] + part * (r[1] - p[1]), p[2] + part * (r[2] - p[2]))
    return shared_point_at(point, first, second, bodies)


def shared_point_at(
    point: Point, first: dict[int, Fraction], second: dict[int, Fraction], bodies: Bodies
) -> SharedPoint:
    """The certificate of a common point, m, which both mixtures are no further from than the inflation radii.

    The mixtures are weights of vertices of each body, of sum 1; none of a half-space.
    """
    place = ExactPoint(point, tuple(first.values()), tuple(second.values()))
    return SharedPoint(np.array([rounded(x) for x in point]), _mixture(first), _mixture(second), place, bodies)


def _holds_point(body: CertifiedBody, mixture: Mixture, weights: tuple[Fraction, ...], point: Point) -> bool:
    """Whether weights are convex and agree with the rounded ones, and the point within the radius of their mixture."""
    if isinstance(body, PosedHalfSpace):
        return len(weights) == len(mixture.vertices) == len(mixture.weights) == 0 and body.holds(point)
    vertices = [int(v) for v in mixture.vertices]
    if not len(vertices) == len(mixture.weights) == len(weights) or not 0 < len(vertices) <= _MOST_VERTICES:
        return False
    if not all(0 <= v < len(body.vertices) for v in vertices) or min(weights) < 0 or sum(weights) != 1:
        return False
    if [float(w) for w in mixture.weights] != [rounded(w) for w in weights]:
        return False
    apart = (x - m for x, m in zip(point, _mixed(body, vertices, weights), strict=True))
    return sum(x * x for x in apart) <= Fraction(body.inflation_radius) ** 2


def _mixed(body: PosedBody, vertices: list[int], weights: Iterable[Fraction]) -> Point:
    """The mixture of posed vertices in the world, m."""
    hull = IntegerHull(body.vertices[vertices], body.pose)
    posed = [hull.point(k) for k in range(len(vertices))]
    unit, mass = Fraction(2) ** hull.unit, list(weights)
    x, y, z = (sum((w * p[k] for w, p in zip(mass, posed, strict=True)), Fraction(0)) * unit for k in range(3))
    return x, y, z


def _mixture(weights: dict[int, Fraction]) -> Mixture:
    return Mixture(np.array(list(weights), dtype=np.int64), np.array([rounded(w) for w in weights.values()]))
