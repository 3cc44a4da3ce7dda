"""Posed vertices as integers, for arithmetic without rounding.

In: vertices (n, 3), a pose (4, 4) and an inflation radius, doubles in metres, each taken as the exact number it is.
Out: the posed vertices and the inflation radius as integers times one power of two, and the vertex with the least
product with an integer direction.

The idea: doubles only choose the vertices that can be extreme, within a bound of their rounding; integers decide among
these. So a query needs one rounded product a vertex and a handful of exact products.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.common.errors import PlannercheckError

Integers = tuple[int, int, int]
Exact = TypeVar("Exact", int, Fraction)

_MANTISSA_BITS = 53
# A rounded product of three terms with a rounded direction errs by at most 5 · 2^-53 of the sum of |g_k v_k|,
# in any order of summation; 8 leaves room for computing that sum in doubles.
_DOT_ERROR = 8 * 2.0**-53
# Products of doubles below 2^-1022 lose bits; all factors are at most 1, so this absolute slack covers them.
_UNDERFLOW = 2.0**-1000
# Entries of a direction are cut to this many bits before they become doubles: more than a double holds, so that the
# rounding stays within 2^-53, and few enough not to overflow.
_DIRECTION_BITS = 64


class IntegerHull:
    """The vertices of one body under its pose, as integers times 2^unit, made when asked for."""

    def __init__(self, vertices: ArrayLike, pose: ArrayLike | None, inflation_radius: float = 0.0) -> None:
        self._inflation_radius = _checked_inflation_radius(inflation_radius)
        points = _checked(vertices, "vertices", (None, 3))
        matrix = np.eye(4) if pose is None else _checked(pose, "pose", (4, 4))
        self._mantissas, exponents = _mantissas_and_exponents(points)
        vertex_unit = _smallest_exponent(self._mantissas, exponents)
        self._shifts = np.where(self._mantissas == 0, 0, exponents - vertex_unit)
        self._scaled = np.ldexp(points, -int(np.frexp(np.abs(points).max())[1]))
        self._reach = np.abs(self._scaled).max(axis=0)
        rows, matrix_unit = _integer_rows(matrix[:3])
        self._linear = [row[:3] for row in rows]
        # The products M v have the unit of both factors, the translation only that of the matrix.
        self._offset_exponents = (vertex_unit + matrix_unit, matrix_unit)
        self._translation = [row[3] for row in rows]
        self.unit = min(*self._offset_exponents, _smallest_exponent(*self._inflation_radius))
        self._points: dict[int, Integers] = {}

    def use_unit(self, unit: int) -> None:
        """Counts in 2^unit m from now on; `unit` is at most the body's own."""
        self.unit = unit

    @property
    def inflation_radius(self) -> int:
        """The inflation radius, in units of 2^unit m."""
        mantissa, exponent = self._inflation_radius[0].item(), self._inflation_radius[1].item()
        return int(mantissa << (exponent - self.unit)) if mantissa else 0

    def point(self, index: int) -> Integers:
        """One posed vertex, in units of 2^unit m."""
        if index not in self._points:
            vertex = self._vertex(index)
            shift, offset_shift = (exponent - self.unit for exponent in self._offset_exponents)
            x, y, z = (
                (dot(row, vertex) << shift) + (offset << offset_shift)
                for row, offset in zip(self._linear, self._translation, strict=True)
            )
            self._points[index] = (x, y, z)
        return self._points[index]

    def lowest(self, direction: Integers) -> int:
        """The index of a vertex with the least product with a direction, exactly."""
        pulled = _pulled_back(self._linear, direction)
        rounded = _rounded(pulled)
        products = self._scaled @ rounded
        slack = 2 * (_DOT_ERROR * float(np.abs(rounded) @ self._reach) + _UNDERFLOW)
        candidates = np.flatnonzero(products <= products.min() + slack).tolist()
        if len(candidates) == 1:
            return int(candidates[0])
        return int(min(candidates, key=lambda index: dot(pulled, self._vertex(index))))

    def _vertex(self, index: int) -> Integers:
        mantissas, shifts = self._mantissas[index].tolist(), self._shifts[index].tolist()
        return (mantissas[0] << shifts[0], mantissas[1] << shifts[1], mantissas[2] << shifts[2])


def in_common_unit(p: IntegerHull, r: IntegerHull) -> tuple[IntegerHull, IntegerHull]:
    """Both bodies, counting in the finer of their units."""
    unit = min(p.unit, r.unit)
    p.use_unit(unit)
    r.use_unit(unit)
    return p, r


def _checked(values: ArrayLike, name: str, shape: tuple[int | None, int]) -> NDArray[np.float64]:
    array = np.asarray(values, dtype=np.float64)
    rows = shape[0] if shape[0] is not None else max(1, len(array) if array.ndim else 0)
    if array.shape != (rows, shape[1]):
        wanted = "(n, 3) with n > 0" if shape[0] is None else "(4, 4)"
        raise PlannercheckError(f"{name} have the shape {array.shape}: {wanted} is expected")
    if not np.isfinite(array).all():
        raise PlannercheckError(f"{name} hold NaN or infinity: finite numbers are expected")
    return array


def on_one_scale(values: NDArray[np.float64]) -> NDArray[Any]:
    """Doubles as Python's integers, times one power of two."""
    fractions, exponents = np.frexp(values)
    mantissas = np.ldexp(fractions, _MANTISSA_BITS).astype(np.int64)
    lowest = int(exponents.min(where=mantissas != 0, initial=int(exponents.max())))
    shifts = np.where(mantissas == 0, 0, exponents - lowest)
    whole: NDArray[Any] = mantissas.astype(object) << shifts.astype(object)
    return whole


def _checked_inflation_radius(inflation_radius: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """An inflation radius's mantissa and exponent."""
    if not 0 <= inflation_radius < np.inf:
        raise PlannercheckError(
            f"inflation radius is {inflation_radius!r}: a finite length in m of at least 0 is expected"
        )
    return _mantissas_and_exponents(np.array(inflation_radius, dtype=np.float64))


def _mantissas_and_exponents(values: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Integers m and e with values = m · 2^e."""
    fractions, exponents = np.frexp(values)
    return np.ldexp(fractions, _MANTISSA_BITS).astype(np.int64), exponents.astype(np.int64) - _MANTISSA_BITS


def _smallest_exponent(mantissas: NDArray[np.int64], exponents: NDArray[np.int64]) -> int:
    return int(exponents.min(where=mantissas != 0, initial=0))


def _integer_rows(values: NDArray[np.float64]) -> tuple[list[list[int]], int]:
    mantissas, exponents = _mantissas_and_exponents(values)
    unit = _smallest_exponent(mantissas, exponents)
    shifts = np.where(mantissas == 0, 0, exponents - unit)
    return [
        [m << s for m, s in zip(row, shift, strict=True)]
        for row, shift in zip(mantissas.tolist(), shifts.tolist(), strict=True)
    ], unit


def _pulled_back(linear: list[list[int]], direction: Integers) -> Integers:
    """The direction in the body's frame: Mᵀ d."""
    a, b, c = linear
    u, v, w = direction
    return (
        a[0] * u + b[0] * v + c[0] * w,
        a[1] * u + b[1] * v + c[1] * w,
        a[2] * u + b[2] * v + c[2] * w,
    )


def _rounded(direction: Integers) -> NDArray[np.float64]:
    """A direction in doubles, scaled to at most 1, each entry to relative 2^-53."""
    bits = max(component.bit_length() for component in direction)
    excesses = [max(0, component.bit_length() - _DIRECTION_BITS) for component in direction]
    leading = [float(component >> excess) for component, excess in zip(direction, excesses, strict=True)]
    return np.ldexp(leading, [excess - bits for excess in excesses])


def dot(a: Sequence[Exact], b: Sequence[Exact]) -> Exact:
    """The product a·b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Sequence[Exact], b: Sequence[Exact]) -> tuple[Exact, Exact, Exact]:
    """The product a × b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def minus(a: Integers, b: Integers) -> Integers:
    """A - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def negated(a: Integers) -> Integers:
    """-a."""
    return (-a[0], -a[1], -a[2])


def times(factor: int, a: Integers) -> Integers:
    """a, scaled."""
    return (factor * a[0], factor * a[1], factor * a[2])


def sum_of(a: Integers, weight_a: int, b: Integers, weight_b: int) -> Integers:
    """A weighted sum."""
    return (
        weight_a * a[0] + weight_b * b[0],
        weight_a * a[1] + weight_b * b[1],
        weight_a * a[2] + weight_b * b[2],
    )
