"""Rows of measurements as a table on the terminal and as CSV; the folder of results.

In: frozen dataclasses, all of one kind. Out: text, files.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.errors import PlannercheckError


def write_csv(path: Path, rows: Sequence[Any]) -> None:
    """Writes rows, one column a field; None is an empty cell.

    Args:
        path: Path of the file that is written.
        rows: Dataclasses of one kind, at least one.
    """

    def write(aside: Path) -> None:
        with aside.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, [field.name for field in fields(rows[0])])
            writer.writeheader()
            writer.writerows(asdict(row) for row in rows)

    write_atomically(path, write)


def output_folder(path: Path | None) -> Path | None:
    """Makes the folder that results go to."""
    if path is not None:
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise PlannercheckError(f"folder {str(path)!r} can't be made: {error.strerror or error}") from None
    return path


def size_of(count: int | None) -> str:
    """Bytes in kB."""
    return "-" if count is None else f"{count / 1024:.0f}"


def number(value: float | None, digits: int = 3) -> str:
    """A number to some digits, without an exponent where it is neither tiny nor huge."""
    return "-" if value is None else f"{value:.{digits}g}" if abs(value) < 10**digits else f"{value:.0f}"
