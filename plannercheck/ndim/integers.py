"""Exact linear algebra in Python integers, for any dimension.

In: doubles, each taken as the exact number it is, or integers. Out: homogeneous integer vectors, inverses, and the
answer to "is there λ ≥ 0 with M λ = r", as a λ or as a y that proves that there is none (Farkas).

The idea: rows may be scaled by any positive number without changing a verdict, so there are no fractions on the way.
The simplex method keeps one common denominator (Edmonds, Bareiss): every division is exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plannercheck.common.array_types import Floats

Row = list[int]
Matrix = list[Row]

_MANTISSA_BITS = 53
# Pivots by steepest cost before Bland's rule, which can't cycle, takes over.
_FREE_PIVOTS = 200


def integers_of(values: Floats) -> tuple[list[int], int]:
    """Integers m, in the order of `values.ravel()`, and one exponent e with values = m · 2^e, exactly; all finite."""
    fractions, exponents = np.frexp(values.ravel())
    mantissas = np.ldexp(fractions, _MANTISSA_BITS).astype(np.int64)
    shifts = exponents.astype(np.int64) - _MANTISSA_BITS
    unit = int(shifts[mantissas != 0].min()) if mantissas.any() else 0
    shifts = np.where(mantissas == 0, 0, shifts - unit)
    return [m << s for m, s in zip(mantissas.tolist(), shifts.tolist(), strict=True)], unit


def matrix_of(values: Floats) -> tuple[Matrix, int]:
    """The same of a matrix (n, d): its rows."""
    flat, unit = integers_of(values)
    width = values.shape[1]
    return [flat[k : k + width] for k in range(0, len(flat), width)], unit


def dot(a: Sequence[int], b: Sequence[int]) -> int:
    """The product a·b."""
    return sum(x * y for x, y in zip(a, b, strict=True))


def times_transposed(matrix: Matrix, vector: Sequence[int]) -> Row:
    """Mᵀ v."""
    return [sum(row[k] * v for row, v in zip(matrix, vector, strict=True)) for k in range(len(matrix[0]))]


def inverse(matrix: Matrix) -> tuple[Matrix, int] | None:
    """N and D > 0 with M N = D · 1 for M (d, d), or None if M is singular."""
    size = len(matrix)
    rows = [[*row, *(int(k == r) for k in range(size))] for r, row in enumerate(matrix)]
    previous = 1
    for column in range(size):
        swap = next((r for r in range(column, size) if rows[r][column]), None)
        if swap is None:
            return None
        rows[column], rows[swap] = rows[swap], rows[column]
        previous = pivot(rows, column, column, previous)
    sign = 1 if previous > 0 else -1
    return [[sign * x for x in row[size:]] for row in rows], sign * previous


def pivot(rows: Matrix, chosen: int, column: int, previous: int) -> int:
    """One fraction-free step of elimination, in place; returns the new common denominator."""
    source = rows[chosen]
    lead = source[column]
    for r, row in enumerate(rows):
        if r != chosen:
            factor = row[column]
            if factor:
                rows[r] = [(lead * x - factor * s) // previous for x, s in zip(row, source, strict=True)]
            elif lead != previous:
                rows[r] = [lead * x // previous for x in row]
    return lead


@dataclass(frozen=True)
class Mix:
    """A solution of M λ = r: positive integers λ, to be divided by `denominator`, by column."""

    weights: dict[int, int]
    denominator: int


@dataclass(frozen=True)
class Farkas:
    """A proof that no λ ≥ 0 has M λ = r: y·m ≤ 0 for every column m of M, and y·r > 0."""

    row: Row


def solve(columns: Sequence[Sequence[int]], right: Sequence[int]) -> Mix | Farkas:
    """Finds a basic λ ≥ 0 with Σ λ_k columns[k] = right, or proves that there is none."""
    return _Simplex(columns, right).run()


class _Simplex:
    """Phase one of the simplex method on a dense integer tableau, whose last row is the cost."""

    def __init__(self, columns: Sequence[Sequence[int]], right: Sequence[int]) -> None:
        height, self.width = len(right), len(columns)
        self.signs = [-1 if value < 0 else 1 for value in right]
        # Where a slack can start in the basis, no artificial column is needed.
        slacks = {row: k for k, column in enumerate(columns) if (row := _unit_row(column)) is not None}
        artificial = [r for r in range(height) if self.signs[r] < 0 or r not in slacks]
        self.starts = [slacks[r] if r not in artificial else self.width + artificial.index(r) for r in range(height)]
        self.rows: Matrix = [
            [*(sign * column[r] for column in columns), *(int(k == r) for k in artificial), sign * right[r]]
            for r, sign in enumerate(self.signs)
        ]
        sums = [-sum(self.rows[r][k] for r in artificial) for k in range(self.width)]
        self.rows.append([*sums, *(0 for _ in artificial), -sum(self.rows[r][-1] for r in artificial)])
        self.basis = list(self.starts)
        self.denominator = 1

    def run(self) -> Mix | Farkas:
        steps = 0
        while (column := self._entering(steps)) is not None:
            row = self._leaving(column)
            self.denominator = pivot(self.rows, row, column, self.denominator)
            self.basis[row] = column
            steps += 1
        return self._proof() if self.rows[-1][-1] else self._solution()

    def _entering(self, steps: int) -> int | None:
        costs = self.rows[-1]
        if costs[-1] == 0:
            return None
        if steps < _FREE_PIVOTS:
            best = min(range(self.width), key=costs.__getitem__, default=None)
            return best if best is not None and costs[best] < 0 else None
        return next((k for k in range(self.width) if costs[k] < 0), None)

    def _leaving(self, column: int) -> int:
        best = -1
        for r in range(len(self.basis)):
            if self.rows[r][column] > 0 and (best < 0 or self._before(r, best, column)):
                best = r
        return best

    def _before(self, r: int, best: int, column: int) -> bool:
        left = self.rows[r][-1] * self.rows[best][column]
        right = self.rows[best][-1] * self.rows[r][column]
        return left < right or (left == right and self.basis[r] < self.basis[best])

    def _solution(self) -> Mix:
        weights = {k: self.rows[r][-1] for r, k in enumerate(self.basis) if k < self.width and self.rows[r][-1]}
        return Mix(weights, self.denominator)

    def _proof(self) -> Farkas:
        # The cost of an artificial column is 1, of a slack 0.
        costs = self.rows[-1]
        return Farkas(
            [
                sign * ((self.denominator if start >= self.width else 0) - costs[start])
                for sign, start in zip(self.signs, self.starts, strict=True)
            ]
        )


def _unit_row(column: Sequence[int]) -> int | None:
    """The place of the only entry that is not 0, if it is 1."""
    places = [r for r, x in enumerate(column) if x]
    return places[0] if len(places) == 1 and column[places[0]] == 1 else None
