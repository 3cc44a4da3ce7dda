"""Poses: any invertible affine map x ↦ M x + t, in doubles that are taken as exact.

In: None, a (d + 1, d + 1) matrix, or a pair (M, t). Out: `Affine`.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import read_only, read_only_copy, real_numbers
from plannercheck.common.errors import PlannercheckError
from plannercheck.ndim.integers import inverse, matrix_of

Pose: TypeAlias = ArrayLike | tuple[ArrayLike, ArrayLike] | None

# Larger numbers could overflow in products of three.
LARGEST = 1e50
# Below this reciprocal of the condition number doubles don't tell whether a map is invertible.
_CLEARLY_INVERTIBLE = 1e-10


@dataclass(frozen=True, eq=False)
class Affine:
    """The map x ↦ M x + t of a matrix (d, d) and a shift (d,); `is_identity` if it maps nothing."""

    matrix: Floats
    shift: Floats
    is_identity: bool

    def of(self, points: Floats) -> Floats:
        """Points (n, d) mapped, rounded."""
        return points if self.is_identity else points @ self.matrix.T + self.shift

    def of_rounding(self, reach: Floats) -> Floats:
        """|M| reach + |t| (d,): times a few roundings, how far `of` can be wrong."""
        return np.asarray(np.abs(self.matrix) @ reach + np.abs(self.shift))


@lru_cache(maxsize=16)
def identity(dimension: int) -> Affine:
    """The map that moves nothing."""
    return Affine(read_only(np.eye(dimension)), read_only(np.zeros(dimension)), True)


def affine_of(pose: Pose, dimension: int, name: str) -> Affine:
    """The map of a pose: None, (d + 1, d + 1), or M (d, d) and t (d,); the name is for errors."""
    if pose is None:
        return identity(dimension)
    matrix, shift = _split(pose, dimension, name)
    if not (np.isfinite(matrix).all() and np.isfinite(shift).all()):
        raise PlannercheckError(f"{name} holds NaN or infinity: finite numbers are expected")
    if max(np.abs(matrix).max(), np.abs(shift).max()) > LARGEST:
        raise PlannercheckError(f"{name} holds numbers beyond {LARGEST:g} in size")
    _check_invertible(matrix, name)
    return Affine(read_only_copy(matrix), read_only_copy(shift), False)


def rounded_inverse(matrix: Floats) -> Floats:
    """The inverse of an invertible matrix (d, d), in doubles; where those can't find it, the exact one, rounded."""
    try:
        return np.asarray(np.linalg.inv(matrix), dtype=np.float64)
    except np.linalg.LinAlgError:
        pass
    rows, unit = matrix_of(matrix)
    found = inverse(rows)
    assert found is not None, "poses are invertible"
    scaled, denominator = found
    scale = denominator * Fraction(2) ** unit
    largest = Fraction(float(np.finfo(np.float64).max))
    return np.array([[float(max(-largest, min(x / scale, largest))) for x in row] for row in scaled])


def solved(matrix: Floats, right: Floats) -> Floats:
    """About the x with matrix x = right, for guides: of a matrix that is singular in doubles, a least one."""
    try:
        return np.asarray(np.linalg.solve(matrix, right))
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0])


def _split(pose: Any, d: int, name: str) -> tuple[Floats, Floats]:
    wanted = f"{name} must be None, a ({d + 1}, {d + 1}) matrix, or a ({d}, {d}) matrix and a ({d},) translation"
    try:
        if isinstance(pose, tuple) and len(pose) == 2:
            matrix, shift = (np.array(real_numbers(part), dtype=np.float64) for part in pose)
            if matrix.shape == (d, d) and shift.shape == (d,):
                return matrix, shift
            raise PlannercheckError(f"{wanted}, not {matrix.shape} and {shift.shape}")
        whole = np.array(real_numbers(pose), dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        if isinstance(error, PlannercheckError):
            raise
        raise PlannercheckError(f"{wanted}: {error}") from error
    if whole.shape != (d + 1, d + 1):
        raise PlannercheckError(f"{wanted}, not {whole.shape}")
    if whole[d, :d].any() or whole[d, d] != 1:
        raise PlannercheckError(f"{name}: the last row of an affine map is 0 … 0 1, not {whole[d].tolist()}")
    return whole[:d, :d], whole[:d, d]


def _check_invertible(matrix: Floats, name: str) -> None:
    sizes = np.linalg.svd(matrix, compute_uv=False)
    if sizes[-1] > _CLEARLY_INVERTIBLE * sizes[0] > 0:
        return
    if inverse(matrix_of(matrix)[0]) is None:
        raise PlannercheckError(f"{name} is singular: an invertible map is expected")
