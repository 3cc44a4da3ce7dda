"""Posed bodies in exact integers: vertices as points, halfspaces as rows.

In: a body's doubles and its pose, taken as the exact affine map that its doubles give. Out: integer points X, which
stand for X · 2^unit, and integer rows (α, β), which stand for α·X ≤ β; positive factors are dropped.

The idea: as in `plannercheck.bodies.integers`, doubles only choose which vertices can be extreme, within a bound of
their rounding, and integers decide among those.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.ndim.integers import Matrix, Row, dot, integers_of, inverse, matrix_of, times_transposed
from plannercheck.ndim.poses import Affine

# Entries of a direction are cut to this many bits before they become doubles: more than a double holds.
_DIRECTION_BITS = 64
# Products of doubles below 2^-1022 lose bits; all factors are at most 1, so this absolute slack covers them.
_UNDERFLOW = 2.0**-1000


class ExactVertices:
    """A posed body given by its vertices."""

    def __init__(self, vertices: Floats, pose: Affine) -> None:
        self._doubles = vertices
        self._rows, self._row_unit = matrix_of(pose.matrix)
        self._shift, self._shift_unit = integers_of(pose.shift)
        self._vertex_unit = _unit(vertices)
        self.unit = min(self._vertex_unit + self._row_unit, self._shift_unit)
        self._points: dict[int, Row] = {}

    def __len__(self) -> int:
        return len(self._doubles)

    def point(self, index: int) -> Row:
        """One posed vertex, in units of 2^unit."""
        if index not in self._points:
            vertex = self._vertex(index)
            lift, shift_lift = self._vertex_unit + self._row_unit - self.unit, self._shift_unit - self.unit
            self._points[index] = [
                (dot(row, vertex) << lift) + (offset << shift_lift)
                for row, offset in zip(self._rows, self._shift, strict=True)
            ]
        return self._points[index]

    def lowest(self, direction: Sequence[int]) -> int:
        """The index of a vertex with the least product with an integer direction, exactly."""
        pulled = times_transposed(self._rows, direction)
        rounded = _rounded(pulled)
        products = self._scaled @ rounded
        width = len(rounded)
        # A product of d terms with a rounded direction errs by less than (d + 2) · 2^-53 of Σ |g_k v_k|.
        slack = 2 * ((width + 6) * 2.0**-53 * float(np.abs(rounded) @ self._reach) + width * _UNDERFLOW)
        candidates = np.flatnonzero(products <= products.min() + slack).tolist()
        if len(candidates) == 1:
            return int(candidates[0])
        return int(min(candidates, key=lambda index: dot(pulled, self._vertex(index))))

    @cached_property
    def _scaled(self) -> Floats:
        return np.ldexp(self._doubles, -int(np.frexp(np.abs(self._doubles).max())[1]))

    @cached_property
    def _reach(self) -> Floats:
        return np.asarray(np.abs(self._scaled).max(axis=0))

    def _vertex(self, index: int) -> Row:
        integers, unit = integers_of(self._doubles[index])
        return [x << (unit - self._vertex_unit) if x else 0 for x in integers]


class ExactRows:
    """A posed body given by halfspaces."""

    def __init__(self, normals: Floats, offsets: Floats, pose: Affine) -> None:
        self._normals, self._offsets = normals, offsets
        self._matrix, self._matrix_unit = matrix_of(pose.matrix)
        self._shift, self._shift_unit = integers_of(pose.shift)
        self.unit = 0
        self._cache: dict[int, tuple[Row, int]] = {}
        self._lowest_units: dict[int, int] = {}

    def __len__(self) -> int:
        return len(self._normals)

    def scale(self, index: int) -> Fraction:
        """The c > 0 with α = c · a M^-1, where a is the normal as it was given."""
        self.row(index)
        return self._inverse[1] * Fraction(2) ** (self.unit - self._lowest_units[index])

    def row(self, index: int) -> tuple[Row, int]:
        """(α, β) of one halfspace: α·X ≤ β for points X in units of 2^unit."""
        if index not in self._cache:
            self._cache[index] = self._posed_row(index)
        return self._cache[index]

    def excess(self, index: int, point: Sequence[int], denominator: int) -> int:
        """α·X - β times a positive denominator of X."""
        alpha, beta = self.row(index)
        return dot(alpha, point) - beta * denominator

    def worst(self, point: Sequence[int], denominator: int) -> int | None:
        """The most violated row, by its own scale, at X = point / denominator > 0; None if it is inside."""
        over = [k for k in range(len(self)) if self.excess(k, point, denominator) > 0]
        return max(over, key=lambda k: self._size_of_excess(k, point, denominator), default=None)

    def _size_of_excess(self, index: int, point: Sequence[int], denominator: int) -> int:
        # The ratio to the normal, as a difference of bit lengths: any violated row would do.
        return self.excess(index, point, denominator).bit_length() - max(
            abs(x).bit_length() for x in self.row(index)[0]
        )

    @cached_property
    def _inverse(self) -> tuple[Matrix, int]:
        found = inverse(self._matrix)
        assert found is not None, "poses are checked to be invertible"
        return found

    def _posed_row(self, index: int) -> tuple[Row, int]:
        normal, normal_unit = integers_of(self._normals[index])
        (offset,), offset_unit = integers_of(self._offsets[index : index + 1])
        scaled, denominator = self._inverse
        alpha = times_transposed(scaled, normal)
        linear_unit = normal_unit - self._matrix_unit
        units = (linear_unit + self.unit, linear_unit + self._shift_unit, offset_unit)
        lowest = min(units)
        self._lowest_units[index] = lowest
        shifts = [unit - lowest for unit in units]
        beta = (dot(alpha, self._shift) << shifts[1]) + (offset * denominator << shifts[2])
        return [x << shifts[0] for x in alpha], beta


Exact = ExactVertices | ExactRows


def in_common_unit(p: Exact, r: Exact) -> None:
    """Lets both bodies count in one unit, the finer one."""
    units = [body.unit for body in (p, r) if isinstance(body, ExactVertices)]
    p.unit = r.unit = min(units, default=0)


def _unit(values: Floats) -> int:
    """The exponent of the last bit that any of the values may have set."""
    exponents = np.frexp(values)[1][values != 0]
    return int(exponents.min()) - 53 if len(exponents) else 0


def _rounded(direction: Sequence[int]) -> Floats:
    """A direction in doubles, scaled to at most 1, each entry to relative 2^-53."""
    bits = max(component.bit_length() for component in direction)
    excesses = [max(0, component.bit_length() - _DIRECTION_BITS) for component in direction]
    leading = [float(component >> excess) for component, excess in zip(direction, excesses, strict=True)]
    return np.asarray(np.ldexp(np.array(leading), np.array([excess - bits for excess in excesses])))
