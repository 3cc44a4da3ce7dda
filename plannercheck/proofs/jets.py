"""Second-order jets of affine maps in ball arithmetic: value, first and second derivative by the motion's parameter.

In: jets of the maps from each joint to the next, over a point or an interval of the parameter. Out: those of chains. A
matrix is a 4 x 4 `flint.arb_mat`; its entries are balls that hold the true values on the whole interval. A derivative
that is 0 is None.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from flint import arb, arb_mat


class Jet(NamedTuple):
    """A map over an interval, 4 x 4, its first and its second derivative; None is 0."""

    value: Any
    first: Any = None
    second: Any = None


def by_length(numbers: Sequence[Any]) -> list[Any]:
    """Numbers as balls, divided by their length."""
    balls = [arb(x) for x in numbers]
    length = sum((x * x for x in balls), arb(0)).sqrt()
    return [x / length for x in balls]


def product(a: Jet, b: Jet) -> Jet:
    """The jet of a product: (A B)' = A' B + A B', (A B)'' = A'' B + 2 A' B' + A B''."""
    crossed = None if a.first is None or b.first is None else a.first * b.first * 2
    return Jet(
        a.value * b.value,
        total(times(a.first, b.value), times(a.value, b.first)),
        total(times(a.second, b.value), crossed, times(a.value, b.second)),
    )


def times(a: Any, b: Any) -> Any:
    """A product of matrices; None stands for 0."""
    return None if a is None or b is None else a * b


def total(*terms: Any) -> Any:
    """A sum of matrices; None stands for 0."""
    out = None
    for term in terms:
        if term is not None:
            out = term if out is None else out + term
    return out


def affine(rows: Sequence[float]) -> Any:
    """The 4 x 4 matrix of 12 doubles, exactly."""
    return arb_mat(4, 4, [*rows, 0, 0, 0, 1])


def linear(entries: Sequence[Any]) -> Any:
    """A 4 x 4 matrix of 9 entries (3 x 3), zero elsewhere: a part of a rotation, or a turn's derivative."""
    a = entries
    return arb_mat(4, 4, [a[0], a[1], a[2], 0, a[3], a[4], a[5], 0, a[6], a[7], a[8], 0, 0, 0, 0, 0])


def ball_between(low: float, high: float) -> Any:
    """A ball that holds all numbers from low to high."""
    return arb(low).union(arb(high))
