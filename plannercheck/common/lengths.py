"""Lengths that callers give: Python's and NumPy's numbers, in m."""

from __future__ import annotations

from plannercheck.common.real_numbers import positive_number


def check_length(value: float, what: str) -> None:
    """Raises an error that names what is no positive length; a number beyond all doubles is none."""
    positive_number(value, f"{what} must be a positive length in m")
