"""Polynomials in Bernstein form, in ball arithmetic: value, first and second derivative over a ball of the parameter.

In: control points, doubles or fractions. Out: a function from a ball of t to three balls.

A polynomial is expanded about the middle m of the ball, exactly, in fractions: p(m + h) = c0 + c1 h + c2 h^2 + …. With
h from -r to r, Horner's rule gives an enclosure that is wider than the range by terms of r^2 alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import comb
from typing import Any

from flint import arb, fmpq, fmpq_poly

# Value, first and second derivative over a ball; None for a derivative that is 0.
Values = Callable[[Any], tuple[Any, Any, Any]]


def exact(x: float) -> Any:
    """A double as a fraction."""
    return fmpq(*x.as_integer_ratio())


def polynomial(control: Sequence[float], multiplier: float = 1.0, offset: float = 0.0) -> Values:
    """The function multiplier * p + offset of a polynomial p by its control points, at least three."""
    powers = _powers([exact(x) for x in control]) * exact(multiplier) + exact(offset)
    first = powers.derivative()
    parts = (powers, first, first.derivative())

    def values(t: Any) -> tuple[Any, Any, Any]:
        middle = t.mid()
        about, h = fmpq_poly([middle.fmpq(), 1]), t - middle
        value, rate, bend = (_horner(part(about), h) for part in parts)
        return value, rate, bend

    return values


def line(control: Sequence[float], multiplier: float = 1.0, offset: float = 0.0) -> Values:
    """The same of two control points."""
    start, end = (arb(x) for x in control)
    value, rate = multiplier * start + offset, multiplier * (end - start)
    return lambda t: (value + t * rate, rate, None)


def _powers(control: Sequence[Any]) -> Any:
    """The polynomial in powers of t: its k-th coefficient is C(n, k) times the k-th difference at the start."""
    degree, rows, found = len(control) - 1, list(control), []
    for k in range(degree + 1):
        found.append(rows[0] * comb(degree, k))
        rows = [b - a for a, b in pairwise(rows)]
    return fmpq_poly(found)


def _horner(coefficients: Any, h: Any) -> Any:
    out = arb(0)
    for c in reversed(coefficients.coeffs()):
        out = out * h + arb(c)
    return out
