"""Exact separating planes: the extents of two posed bodies along a direction, in exact arithmetic.

In: posed bodies (vertices, poses and inflation radii as the exact numbers that their doubles are) and a direction. Out:
the plane halfway between them, or whether a given plane keeps them apart.

A body with an inflation radius consists of all points within that distance of the hull, so a plane must be at least the
inflation radius away from the vertices. A rational upper bound of the normal's length is enough to check that, so no
root is needed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

import numpy as np

from plannercheck.bodies.integers import IntegerHull, Integers
from plannercheck.bodies.integers import dot as product
from plannercheck.bodies.posed_half_spaces import PosedHalfSpace
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.exact_numbers import root_above

Point: TypeAlias = tuple[Fraction, Fraction, Fraction]

# Bits of a normal's length; it is rounded up by less than doubles can show.
_LENGTH_BITS = 64


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

    def lowest(self, direction: Point) -> Fraction | None:
        """The least product of a direction with its points, the radius left out."""
        whole, denominator = in_integers(direction)
        hull = IntegerHull(self.vertices, self.pose)
        return product(whole, hull.point(hull.lowest(whole))) * Fraction(2) ** hull.unit / denominator


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


def direction_of(normal: Floats) -> Point:
    """A vector of doubles (3,), brought to unit length in doubles, as exact numbers."""
    u, v, w = (normal / np.abs(normal).max()).tolist()
    length = math.sqrt(u * u + v * v + w * w)  # in the order of the C++ library, whose planes have the same bits
    return Fraction(u / length), Fraction(v / length), Fraction(w / length)


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


def plane_between(direction: Point, bodies: Bodies) -> ExactPlane | None:
    """The plane halfway between two bodies along a direction of any length; None if their extents along it meet."""
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
    x, y, z = direction
    low, minus_high = first.lowest(direction), second.lowest((-x, -y, -z))
    if low is None or minus_high is None:
        return None
    return low, -minus_high, Fraction(first.inflation_radius), Fraction(second.inflation_radius)


def in_integers(direction: Point) -> tuple[Integers, int]:
    """Integers, and the common denominator."""
    denominator = math.lcm(*(x.denominator for x in direction))
    x, y, z = (x.numerator * (denominator // x.denominator) for x in direction)
    return (x, y, z), denominator
