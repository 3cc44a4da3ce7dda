"""Numbers of measurements as text, and the folder of results."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from plannercheck.common.errors import PlannercheckError

# Times of which digits after the point say nothing.
_MANY = 100


def make_output_folder(path: Path | None) -> None:
    """Makes the folder that results go to."""
    if path is not None:
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise PlannercheckError(f"folder {str(path)!r} can't be made: {error.strerror or error}") from None


def ratio(value: float | None, noise: float) -> str:
    """A ratio of times, of which nothing is told that the same code run twice would differ by."""
    if value is None:
        return "-"
    return "1" if 1 / noise <= value <= noise else f"{value:.2f}" if value < _MANY else f"{value:.0f}"


def null_control(rows: Sequence[Any]) -> str:
    """What the same code differed by in these rows."""
    least, most = (100 * (of(row.noise for row in rows) - 1) for of in (min, max))
    return f"null control: the same code twice differs by {least:.1f} to {most:.1f} %; ratios within that are 1"


def size_of(count: int | None) -> str:
    """Bytes in kB."""
    return "-" if count is None else f"{count / 1024:.0f}"


def number(value: float | None, digits: int = 3) -> str:
    """A number to some digits, without an exponent where it is neither tiny nor huge."""
    return "-" if value is None else f"{value:.{digits}g}" if abs(value) < 10**digits else f"{value:.0f}"
