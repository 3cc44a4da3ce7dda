"""Sizes of shapes as users give them: numbers in m.

In: anything. Out: floats that are finite and not negative, or an error that names the size.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.common.arrays import unmasked
from plannercheck.common.errors import PlannercheckError


def array_of(values: ArrayLike, what: str) -> NDArray[np.float64]:
    """A float64 copy of an array, or an error that names what is no array of numbers."""
    try:
        return np.array(unmasked(values), dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise PlannercheckError(f"{what} must be an array of numbers: {error}") from None


def numbers(values: Sequence[float], what: str) -> tuple[float, ...]:
    """A list of numbers as floats."""
    if type(values) in (tuple, list) and all(type(value) is float for value in values):  # most of all
        return tuple(values)
    array = array_of(values, what)
    if array.ndim != 1:
        raise PlannercheckError(f"{what} must be a list of numbers, not {values!r}")
    return tuple(float(v) for v in array)


def length(value: float, what: str) -> float:
    """The value as a float, if it is finite and not negative."""
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"{what} must be a number in m, not {value!r}") from None
    if not (math.isfinite(number) and number >= 0):
        raise PlannercheckError(f"{what} must be finite and not negative (m), not {number}")
    return number + 0.0  # -0.0 is 0.0
