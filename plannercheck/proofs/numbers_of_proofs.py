"""Limits of the numbers in a proof, in space and in the plane.

In: numbers of a proof. Out: nothing, or an `UnprovedError`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

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
