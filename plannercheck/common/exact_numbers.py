"""Fractions as doubles, for certificates that show their exact numbers.

In: fractions. Out: the nearest doubles, doubles below, upper bounds of roots, and whether doubles are a unit normal.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from fractions import Fraction

_LARGEST_DOUBLE = Fraction(sys.float_info.max)
# The error of a unit normal in doubles: two roundings of each entry, with room to spare.
_NORMAL_ROUNDING = Fraction(1, 2**50)


def exact_number(number: tuple[str, int]) -> Fraction:
    """A hexadecimal integer times a power of two, as the core gives exact numbers."""
    digits, exponent = number
    return int(digits, 16) * Fraction(2) ** exponent


def rounded(number: Fraction) -> float:
    """The nearest double; the largest one beyond it."""
    return float(max(-_LARGEST_DOUBLE, min(number, _LARGEST_DOUBLE)))


def rounded_down(number: Fraction) -> float:
    """A double that is at most a positive number."""
    nearest = rounded(number)
    return nearest if Fraction(nearest) <= number else math.nextafter(nearest, 0.0)


def root_above(square: Fraction, bits: int) -> Fraction:
    """An upper bound of the root, larger by at most a part of 2^(1 - bits)."""
    # Shifted by an even number of bits, so that the integer root has the bits that are wanted.
    shift = max(0, bits - (square.numerator.bit_length() - square.denominator.bit_length()) // 2)
    scaled = -(-(square.numerator << (2 * shift)) // square.denominator)
    root = math.isqrt(scaled)
    return Fraction(root if root * root == scaled else root + 1, 1 << shift)


def is_unit_normal(normal: Sequence[float], exact: Sequence[Fraction], length: Fraction) -> bool:
    """Whether doubles are an exact vector over its length, rounded."""
    return all(abs(Fraction(x) * length - y) <= _NORMAL_ROUNDING * length for x, y in zip(normal, exact, strict=True))
