"""csv: one configuration a line, separated by commas, semicolons, tabs or spaces.

In: a text stream. Out: `RowBlock`s. The first line may name the columns: then the joints' columns are found by name, in
any order, and other columns are ignored. Empty lines and lines that start with # are skipped, but for a comment before
the first row that is exactly the joints' names, as np.savetxt writes it: it names the columns, too.
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import TextIO

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.validation.formats.blocks import RowBlock
from plannercheck.validation.formats.columns import Columns

# From this many lines on, another library is faster although it takes a moment to load.
MANY_LINES = 10_000


def csv_blocks(path: Path, columns: Columns, size: int) -> Iterator[RowBlock]:
    """Rows of a csv file."""
    try:
        with path.open(encoding="utf-8-sig", newline=None) as file:
            yield from csv_stream_blocks(file, columns, size, path.stat().st_size)
    except (OSError, UnicodeDecodeError) as error:
        raise PlannercheckError(f"is no readable text: {error}") from None


def csv_stream_blocks(file: TextIO, columns: Columns, size: int, total: int | None = None) -> Iterator[RowBlock]:
    """Rows of a text stream; `total` is its length in bytes, if that is known."""
    lines = _Lines(file, columns.names)
    first = next(lines, None)
    if first is None and columns.width == 0:  # a robot that nothing moves has one configuration, of no numbers
        yield RowBlock(np.empty((1, 0)), 1.0)
        return
    if first is None:  # NumPy writes an empty set so
        yield RowBlock(np.empty((0, columns.width)), 1.0)
        return
    separator = next((s for s in ",;\t" if s in first), None)
    names = _fields(first, separator)
    pending = [first] if _is_row(names) else []
    heading = lines.heading if pending else names
    places = columns.places(heading) if len(heading) == len(names) else None
    done = 0
    while block := pending + list(islice(lines, size - len(pending))):
        rows = _parsed(block, separator, done, len(names))
        if places is None:
            columns.check_width(rows.shape[1])
        part = None if total is None else min(1.0, lines.read / max(total, 1))
        yield RowBlock(rows if places is None else rows[:, places], part)
        done, pending = done + len(rows), []


class _Lines:
    """Lines that hold something, how many characters have been read, and the joints in the order of a comment."""

    def __init__(self, file: TextIO, joints: Sequence[str]) -> None:
        self._file, self._joints = file, sorted(joints)
        self.read = 0
        self.heading: list[str] = []
        self._began = False

    def __iter__(self) -> Iterator[str]:
        return self

    def __next__(self) -> str:
        for line in self._file:
            self.read += len(line)
            if line.strip() and not line.lstrip().startswith("#"):
                self._began = True
                return line
            if not self._began:
                words = [word.strip("\"'") for word in re.split(r"[,;\s]+", line.strip().lstrip("#").strip())]
                self.heading = words if sorted(words) == self._joints else self.heading
        raise StopIteration


def _parsed(lines: list[str], separator: str | None, first_row: int, width: int) -> Floats:
    """The numbers of some lines (n, width)."""
    if len(lines) >= MANY_LINES and separator is not None:
        quick = _parsed_by_arrow(lines, separator, width)
        if quick is not None:
            return quick
    try:
        rows = np.loadtxt(lines, delimiter=separator, ndmin=2, comments=None)
        if rows.shape[1] == width:
            return rows
    except ValueError:
        pass
    for k, line in enumerate(lines):  # slow, but only to say which line it is
        fields = _fields(line, separator)
        is_quoted = '"' in line
        if len(fields) != width or not _is_row(fields) or is_quoted:
            shown, wanted = line.strip()[:60], f"{width} numbers{', without quotes' * is_quoted}"
            raise PlannercheckError(f"row {first_row + k} must have {wanted}, not {shown!r}")
    raise PlannercheckError(f"rows from {first_row} on are no table of numbers")


def _parsed_by_arrow(lines: list[str], separator: str, width: int) -> Floats | None:
    """The same in a quarter of the time, if pyarrow is installed and the lines are plain numbers; else None."""
    try:
        arrow, reader = importlib.import_module("pyarrow"), importlib.import_module("pyarrow.csv")
    except ImportError:
        return None
    try:
        table = reader.read_csv(
            arrow.py_buffer("".join(lines).encode()),
            reader.ReadOptions(autogenerate_column_names=True, use_threads=False),
            reader.ParseOptions(delimiter=separator, quote_char=False),
            reader.ConvertOptions(column_types={f"f{k}": arrow.float64() for k in range(width)}),
        )
    except arrow.ArrowException:
        return None
    plain = table.shape == (len(lines), width) and not any(column.null_count for column in table.columns)
    return np.stack([column.to_numpy() for column in table.columns], axis=1) if plain else None


def _fields(line: str, separator: str | None) -> list[str]:
    return [field.strip().strip('"') for field in line.strip().split(separator)]


def _is_row(fields: Sequence[str]) -> bool:
    """Whether a line holds numbers, not names."""
    try:
        for field in fields:
            float(field)
    except ValueError:
        return False
    return True
