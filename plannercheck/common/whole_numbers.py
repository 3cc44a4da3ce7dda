"""Whole numbers that callers give: Python's and NumPy's."""

from __future__ import annotations

from numbers import Integral

from plannercheck.common.errors import PlannercheckError


def whole_number(value: object, wanted: str, least: int = 1) -> int:
    """The number, at least so large, or an error that says what is wanted.

    Raises:
        PlannercheckError: "`wanted`, not …", also for truth values.
    """
    if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
        raise PlannercheckError(f"{wanted}, not {value!r}")
    return int(value)


def row_of_table(row: object, count: int) -> int:
    """The row of a table of so many, from 0 on.

    Raises:
        PlannercheckError: If there is none.
    """
    wanted = f"row must be one of {count} of the table, from 0 on"
    k = whole_number(row, wanted, 0)
    if k >= count:
        raise PlannercheckError(f"{wanted}, not {row!r}")
    return k
