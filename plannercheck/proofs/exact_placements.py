"""Placements and axes of a URDF as its text has them: decimals as fractions, turns and products in ball arithmetic.

In: elements of a URDF. Out: `Placement`, a matrix of balls that hold the exact numbers; and the proved distance of a
proof's doubles from it. A placement in doubles that the chain of `Placement.count` origins was multiplied to may be off
by `ROUNDING` for each origin, times the larger of 1 m and the origins' shifts together.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from typing import Any
from xml.etree.ElementTree import Element

from flint import arb, arb_mat, ctx, fmpq

from plannercheck.proofs.jets import by_length, linear

# What an origin's sines, cosines, products and normalised quaternion in doubles may be off by; the largest difference
# in 1,175 URDFs is 12 times 2^-53.
ROUNDING = 32 * 2.0**-53

# Of balls: far more than doubles have, so that a distance of doubles from them is a rounding's.
_BITS = 128

_DECIMAL = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?0*\d{1,4})?", re.ASCII)


@dataclass(frozen=True, eq=False)
class Placement:
    """What so many origins are multiplied to, 4 x 4 balls, m, and the lengths of their shifts together, rounded, m."""

    matrix: Any
    count: int = 0
    shift: float = 0.0

    def times(self, other: Placement) -> Placement:
        """This placement and then another, in its frame."""
        return Placement(self.matrix * other.matrix, self.count + other.count, self.shift + other.shift)

    @classmethod
    def of_rows(cls, rows: Sequence[Sequence[Fraction]]) -> Placement:
        """The placement whose matrix has these 4 rows."""
        numbers = [number for row in rows for number in row]
        return cls(arb_mat(4, 4, balls(numbers)), 1, math.hypot(*(float(row[3]) for row in rows[:3])))

    @property
    def allowance(self) -> float:
        """How far doubles may be off."""
        return ROUNDING * self.count * max(1.0, self.shift)


@contextmanager
def enough_digits() -> Iterator[None]:
    """Ball arithmetic of 128 bits."""
    bits, ctx.prec = ctx.prec, _BITS
    try:
        yield
    finally:
        ctx.prec = bits


def at_rest() -> Placement:
    """The placement that moves nothing."""
    return Placement(arb_mat(4, 4, [int(k % 5 == 0) for k in range(16)]))


def furthest(numbers: Sequence[float], exact: Sequence[Any]) -> float:
    """An upper bound of how far doubles are from what balls hold, proved; NaN if there is none."""
    bound = arb(0)
    for number, ball in zip(numbers, exact, strict=True):
        bound = bound.max((arb(number) - ball).abs_upper())
    return float(bound.abs_upper()) * (1 + 2.0**-50)


def off_placement(rows: Sequence[float], exact: Placement) -> float:
    """An upper bound of how far the 12 numbers of a placement are off, proved."""
    return furthest(rows, exact.matrix.entries()[:12])


def decimals(text: str | None, count: int, what: str) -> list[Fraction]:
    """The numbers of a text, exactly; `what` names it in errors.

    Raises:
        ValueError: If they are not so many decimals within the range of doubles.
    """
    words = (text or "").split()
    if len(words) != count or not all(map(_DECIMAL.fullmatch, words)) or not all(map(math.isfinite, map(float, words))):
        raise ValueError(f"{what} must be {count} numbers, not {text!r:.80}")
    return [Fraction(word) for word in words]


def balls(numbers: Sequence[Fraction]) -> list[Any]:
    """Fractions as balls."""
    return [arb(fmpq(number.numerator, number.denominator)) for number in numbers]


def origin_of(element: Element) -> Placement:
    """The placement that an element's <origin> gives.

    Raises:
        ValueError: If it has other numbers than it should.
    """
    origin = element.find("origin")
    given = {} if origin is None else origin.attrib
    shift = decimals(given.get("xyz", "0 0 0"), 3, "xyz of <origin>")
    if "quat_xyzw" not in given:
        return placed(shift, decimals(given.get("rpy", "0 0 0"), 3, "rpy of <origin>"))
    quaternion = decimals(given["quat_xyzw"], 4, "quat_xyzw of <origin>")
    if not 0.25 <= sum(x * x for x in quaternion) <= 4:
        raise ValueError(f"quat_xyzw of <origin>, {[*map(float, quaternion)]}, must have length 1")
    return placed(shift, (), quaternion)


def placed(
    shift: Sequence[Fraction], angles: Sequence[Fraction], quaternion: Sequence[Fraction] | None = None
) -> Placement:
    """A shift in m, and a turn by roll, pitch and yaw in rad, or by a quaternion x, y, z, w of any length but 0."""
    turn = _of_angles(balls(angles)) if quaternion is None else _of_quaternion(quaternion)
    x, y, z = balls(shift)
    matrix = linear(turn) + arb_mat(4, 4, [0, 0, 0, x, 0, 0, 0, y, 0, 0, 0, z, 0, 0, 0, 1])
    return Placement(matrix, 1, math.hypot(*map(float, shift)))


def unit(numbers: Sequence[Fraction]) -> list[Any]:
    """A vector of length 1 in the direction of numbers that are not all 0."""
    return by_length(balls(numbers))


def _of_angles(angles: Sequence[Any]) -> list[Any]:
    """Turned about the fixed axes x, y, z by roll, pitch, yaw, in this order: 9 entries."""
    (sr, cr), (sp, cp), (sy, cy) = (angle.sin_cos() for angle in angles)
    return [
        *(cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        *(sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        *(-sp, cp * sr, cp * cr),
    ]


def _of_quaternion(numbers: Sequence[Fraction]) -> list[Any]:
    """Turned by a quaternion, which is made a unit one: 9 entries."""
    if not any(numbers):
        raise ValueError("a quaternion of zeros has no direction")
    x, y, z, w = unit(numbers)
    return [
        *(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        *(2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        *(2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    ]
