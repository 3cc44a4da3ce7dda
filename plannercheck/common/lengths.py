"""Lengths that callers give: Python's and NumPy's numbers, in m."""

from __future__ import annotations

import sys

import numpy as np

from plannercheck.common.errors import PlannercheckError


def check_length(value: float, what: str) -> None:
    """Raises an error that names what is no positive length; a number beyond all doubles is none."""
    try:
        is_length = np.ndim(value) == 0 and bool(0 < value <= sys.float_info.max)
    except (TypeError, ValueError):
        is_length = False
    if not is_length:
        raise PlannercheckError(f"{what} must be a positive length in m, not {value!r:.80}")
