"""Real numbers that callers give: Python's and NumPy's."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np

from plannercheck.common.errors import PlannercheckError


def positive_number(value: Any, wanted: str, *, or_zero: bool = False) -> float:
    """The number, finite and above 0 (or 0), or an error that says what is wanted.

    Raises:
        PlannercheckError: "`wanted`, not …", also for truth values and texts.
    """
    number = -1.0
    is_plain = type(value) is float or type(value) is int
    if is_plain or not (isinstance(value, str | bytes | bool | np.bool_) or np.iscomplexobj(value)):
        with suppress(TypeError, ValueError, OverflowError):
            number = float(value) if is_plain or np.ndim(value) == 0 else -1.0
    if not (0 < number < np.inf or (or_zero and number == 0)):
        raise PlannercheckError(f"{wanted}, not {value!r:.80}")
    return number


def check_length(value: float, what: str) -> None:
    """Raises an error that names what is no positive length; a number beyond all doubles is none."""
    positive_number(value, f"{what} must be a positive length in m")
