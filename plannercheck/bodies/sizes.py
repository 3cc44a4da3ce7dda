"""Sizes of shapes as users give them: numbers in m.

In: anything. Out: floats that are finite and not negative, or an error that names the size.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.common.arrays import real_numbers, unmasked
from plannercheck.common.errors import PlannercheckError


def array_of(values: ArrayLike, what: str) -> NDArray[np.float64]:
    """A float64 copy of an array, or an error that names what is no array of numbers."""
    try:
        given = np.asarray(unmasked(values))
        if given.dtype.kind != "O" or any(isinstance(each, str | bytes) for each in given.flat):
            given = real_numbers(values)  # those of Python's other kinds, e.g. fractions, are objects
        return np.array(given, dtype=np.float64)
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


def number(value: Any, wanted: str) -> float:
    """The value as a float, or the error "`wanted`, not …", also for truth values, texts and complex numbers."""
    try:
        if isinstance(value, str | bytes | bool | np.bool_) or np.iscomplexobj(value):
            raise TypeError
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"{wanted}, not {value!r:.80}") from None


def length(value: float, what: str) -> float:
    """The value as a float, if it is finite and not negative."""
    found = number(value, f"{what} must be a number in m")
    if not (math.isfinite(found) and found >= 0):
        raise PlannercheckError(f"{what} must be finite and not negative (m), not {found}")
    return found + 0.0  # -0.0 is 0.0
