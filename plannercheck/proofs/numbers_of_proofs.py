"""Limits of what a proof holds, in space and in the plane: numbers, placements, vertices, pairs.

In: parts of a proof. Out: nothing, or an `UnprovedError`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.proofs.faults import UnprovedError

# The largest norm of M^T M - 1 of a placement, or of a pose in the world.
LARGEST_DEFECT = 1e-6

# Larger numbers, rad and m, belong to no configuration or scene.
LARGEST_NUMBER = 1e15

# A short way round is at most half a turn, rad, up to the rounding of its end.
HALF_TURN = math.pi + 1e-6


def check_numbers(values: Iterable[Any], what: str) -> None:
    """Raises an `UnprovedError` for a number that is not finite or is too large."""
    for value in values:
        if not isinstance(value, float) or not abs(value) <= LARGEST_NUMBER:
            raise UnprovedError(
                f"{what} has the number {value!r:.40}, which is not finite, or beyond {LARGEST_NUMBER:g}"
            )


def check_length(values: Sequence[Any], length: int, what: str) -> None:
    """Raises an `UnprovedError` unless there are `length` numbers."""
    if len(values) != length:
        raise UnprovedError(f"{what} has {len(values)} numbers, not {length}")


def check_rigid(matrix: Floats, what: str) -> None:
    """Raises an `UnprovedError` unless a square matrix turns, up to `LARGEST_DEFECT`."""
    defect = float(np.linalg.norm(matrix.T @ matrix - np.eye(len(matrix))))
    if not defect <= LARGEST_DEFECT or not np.linalg.det(matrix) > 0:
        raise UnprovedError(f"{what} that is not rigid: |M^T M - 1| is {defect:.3g}, or it is a reflection")


def check_vertices(vertices: Any, dimension: int, what: str) -> None:
    """Raises an `UnprovedError` unless vertices are an array (n, dimension) of doubles that are not too large."""
    if type(vertices) is not np.ndarray or vertices.dtype != np.float64:
        raise UnprovedError(f"{what} has vertices that are no array of doubles")
    shape = vertices.shape
    if len(shape) != 2 or shape[1] != dimension or not shape[0]:
        raise UnprovedError(f"{what} has vertices of shape {shape}, not (n, {dimension})")
    if not (np.abs(vertices) <= LARGEST_NUMBER).all():
        raise UnprovedError(f"{what} has a vertex that is not finite, or beyond {LARGEST_NUMBER:g}")


def check_pairs(pairs: Iterable[tuple[int, int]], bodies: int) -> None:
    """Raises an `UnprovedError` for a pair that is not of two of the bodies."""
    for index, (a, b) in enumerate(pairs):
        if a == b or not (0 <= a < bodies and 0 <= b < bodies):
            raise UnprovedError(f"pair {index} is of bodies {a} and {b}: they must be two of {bodies}")
