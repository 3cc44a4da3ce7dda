"""Proofs of a verdict about one pair: a separating plane, or a common point.

In: two posed bodies and the core's answer. Out: frozen values in world coordinates, in doubles and in exact form, and
`verify`, which proves them in exact arithmetic from the bodies' vertices alone, without the core.

The idea: a plane or a mixture of vertices is easy to check, whoever found it. All given numbers (vertices, poses as
affine maps, inflation radii) are taken as the exact numbers that their doubles are. A body with an inflation radius
consists of all points within that distance of the hull, so a plane must be at least the inflation radius away from the
vertices. A rational upper bound of the normal's length is enough to check that, so no root is needed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeAlias

import numpy as np

from plannercheck.bodies.integers import IntegerHull, Integers, in_common_unit, negated
from plannercheck.bodies.integers import dot as product
from plannercheck.bodies.posed_half_spaces import PosedHalfSpace
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.exact_numbers import is_unit_normal, root_above, rounded, rounded_down
from plannercheck.common.public_names import set_module

Point: TypeAlias = tuple[Fraction, Fraction, Fraction]

# More vertices than these are never needed (Carathéodory).
_MOST_VERTICES = 4
# Bits of a normal's length; it is rounded up by less than doubles can show.
_LENGTH_BITS = 64


class UnprovedVerdictError(PlannercheckError):
    """A verdict of the core that its own certificate does not prove: a fault of the core."""


@dataclass(frozen=True, eq=False)
class PosedBody(OwnsArrays):
    """A body that a certificate is about.

    Attributes:
        vertices: (n, 3) in the body's frame, m.
        pose: (4, 4) in the world, m.
        inflation_radius: The inflation radius, m.
    """

    vertices: Floats
    pose: Floats
    inflation_radius: float = 0.0

    @property
    def swell(self) -> float:
        """`inflation_radius` by its former name, for one release."""
        return self.inflation_radius


CertifiedBody: TypeAlias = PosedBody | PosedHalfSpace
Bodies: TypeAlias = tuple[CertifiedBody, CertifiedBody]


@dataclass(frozen=True)
class ExactPlane:
    """An exact separating plane: each body's vertices are beyond it by more than length times the body's radius.

    Attributes:
        normal: Normal of any length, from the second body to the first.
        length: At least the normal's length, and larger by at most a part of 2^-63.
        offset: The plane is normal · x = offset.
        gap: A positive lower bound of the bodies' distance, m.
    """

    normal: Point
    length: Fraction
    offset: Fraction
    gap: Fraction


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
    """The plane halfway between two bodies along a direction.

    Args:
        direction: In the world, any length, from the second body to the first.
        bodies: The two bodies.

    Returns:
        The plane, or None if the bodies' extents along the direction meet.
    """
    plane = _plane_between(direction, bodies)
    if plane is None:
        return None
    normal = np.array([rounded(x / plane.length) for x in plane.normal])
    return Separation(normal, rounded(plane.offset / plane.length), rounded_down(plane.gap), plane, bodies)


def shared_point(first: dict[int, Fraction], second: dict[int, Fraction], bodies: Bodies) -> SharedPoint:
    """The common point of two mixtures of vertices, which must be no further apart than the sum of the inflation radii.

    Args:
        first: Weights of vertices of the first body, of sum 1.
        second: The same for the second body.
        bodies: The two bodies.

    Returns:
        The point that divides the segment from one mixture to the other in the ratio of the inflation radii.
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
    """The certificate of a common point, which both mixtures are no further from than the inflation radii.

    Args:
        point: In the world, m.
        first: Weights of vertices of the first body, of sum 1; none of a half-space.
        second: The same for the second body.
        bodies: The two bodies.
    """
    place = ExactPoint(point, tuple(first.values()), tuple(second.values()))
    return SharedPoint(np.array([rounded(x) for x in point]), _mixture(first), _mixture(second), place, bodies)


def direction_of(normal: Floats) -> Point:
    """A vector of doubles (3,), brought to unit length in doubles, as exact numbers."""
    scaled = normal / np.abs(normal).max()
    x, y, z = (scaled / np.linalg.norm(scaled)).tolist()
    return Fraction(x), Fraction(y), Fraction(z)


def separates_exactly(plane: ExactPlane, bodies: Bodies) -> bool:
    """Whether a plane keeps two bodies apart, by its gap at least, proved with all their vertices."""
    if plane.length <= 0 or plane.length**2 < sum(x * x for x in plane.normal):
        return False
    extents = _extents(plane.normal, bodies)
    if extents is None:
        return False
    low, high, inflation_p, inflation_r = extents
    apart = low - inflation_p * plane.length > plane.offset > high + inflation_r * plane.length
    return apart and 0 < plane.gap <= (low - high) / plane.length - inflation_p - inflation_r


def _plane_between(direction: Point, bodies: Bodies) -> ExactPlane | None:
    extents = _extents(direction, bodies)
    if extents is None:
        return None
    low, high, inflation_p, inflation_r = extents
    square, apart, inflation = sum((x * x for x in direction), Fraction(0)), low - high, inflation_p + inflation_r
    if apart <= 0 or apart**2 <= inflation**2 * square:
        return None
    bits = _LENGTH_BITS
    while apart <= inflation * (length := root_above(square, bits)):
        bits *= 2
    offset = (low + high + (inflation_r - inflation_p) * length) / 2
    return ExactPlane(direction, length, offset, apart / length - inflation)


def _extents(direction: Point, bodies: Bodies) -> tuple[Fraction, Fraction, Fraction, Fraction] | None:
    """The least product with a point of the first body, the largest with one of the second, and the radii.

    None if a half-space reaches on and on along the direction.
    """
    first, second = bodies
    if isinstance(first, PosedHalfSpace) or isinstance(second, PosedHalfSpace):
        return _extents_of_half_space(direction, first, second)
    whole, denominator = in_integers(direction)
    p, r = in_common_unit(*(IntegerHull(body.vertices, body.pose, body.inflation_radius) for body in (first, second)))
    low, high = product(whole, p.point(p.lowest(whole))), product(whole, r.point(r.lowest(negated(whole))))
    unit = Fraction(2) ** p.unit
    return low * unit / denominator, high * unit / denominator, p.inflation_radius * unit, r.inflation_radius * unit


def _extents_of_half_space(
    direction: Point, first: CertifiedBody, second: CertifiedBody
) -> tuple[Fraction, Fraction, Fraction, Fraction] | None:
    x, y, z = direction
    low, minus_high = _lowest(first, direction), _lowest(second, (-x, -y, -z))
    if low is None or minus_high is None:
        return None
    return low, -minus_high, Fraction(first.inflation_radius), Fraction(second.inflation_radius)


def _lowest(body: CertifiedBody, direction: Point) -> Fraction | None:
    """The least product of a direction with a body's points, its radius left out; None if there is none."""
    if isinstance(body, PosedHalfSpace):
        return body.lowest(direction)
    whole, denominator = in_integers(direction)
    hull = IntegerHull(body.vertices, body.pose)
    return product(whole, hull.point(hull.lowest(whole))) * Fraction(2) ** hull.unit / denominator


def in_integers(direction: Point) -> tuple[Integers, int]:
    """Integers, and the common denominator."""
    denominator = math.lcm(*(x.denominator for x in direction))
    x, y, z = (x.numerator * (denominator // x.denominator) for x in direction)
    return (x, y, z), denominator


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
