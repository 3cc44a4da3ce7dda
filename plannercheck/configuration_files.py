"""Sets of configurations in files: npy (memory-mapped), npz and csv.

In: a path. Out: `Chunk`s of checked rows, so that a set may be larger than memory. What is wrong with a file
is said with its name and, where there is one, the row (counted from 0).

A csv file has one configuration a line, separated by commas, semicolons, tabs or spaces. Its first line may
name the columns: then the joints' columns are found by name, in any order, and others are left out.
"""

from __future__ import annotations

import tokenize
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from plannercheck.errors import PlannercheckError
from plannercheck.hints import shape_hint
from plannercheck.reading import within

Floats = NDArray[np.float64]

# Rows read at once: some megabytes for any robot, and enough to keep all threads busy.
CHUNK_ROWS = 65_536

# Arrays of an npz file that are taken if it holds several.
_NPZ_KEYS = ("q", "configurations")

_READERS = (".npy", ".npz", ".csv")


@dataclass(frozen=True, eq=False)
class Chunk:
    """Consecutive rows of a set.

    Attributes:
        first_row: Of the chunk in its file, from 0.
        rows: (n, nq) float64, rad and m, all finite.
    """

    first_row: int
    rows: Floats


def read_chunks(path: str | Path, joint_names: Sequence[str], width: int) -> Iterator[Chunk]:
    """Reads a set chunk by chunk.

    Args:
        path: An npy, npz or csv file.
        joint_names: Of the columns, for csv files with a header.
        width: Numbers a configuration must have, nq.

    Yields:
        Chunks of at most `CHUNK_ROWS` rows, in order.

    Raises:
        PlannercheckError: If the file can't be read, has the wrong width, or a row is not finite.
    """
    path = Path(path)
    with within(f"file {str(path)!r}"):
        if path.suffix.lower() not in _READERS:
            raise PlannercheckError(f"must be one of {', '.join(_READERS)}, not {path.suffix or 'without suffix'}")
        if not path.is_file():
            raise PlannercheckError("is a folder" if path.is_dir() else "does not exist")
        is_text = path.suffix.lower() == ".csv"
        blocks = _csv_blocks(path, joint_names, width) if is_text else _blocks(path, joint_names, width)
        yield from _checked(blocks)


def _checked(blocks: Iterator[NDArray[Any]]) -> Iterator[Chunk]:
    first = 0
    for block in blocks:
        rows = np.ascontiguousarray(block, dtype=np.float64)
        bad = np.flatnonzero(~np.isfinite(rows).all(axis=1))
        if len(bad):
            raise PlannercheckError(f"row {first + int(bad[0])} is not finite: {rows[bad[0]].tolist()}")
        yield Chunk(first, rows)
        first += len(rows)


def _blocks(path: Path, joint_names: Sequence[str], width: int) -> Iterator[NDArray[Any]]:
    array = _shaped(_npy(path) if path.suffix.lower() == ".npy" else _npz(path), joint_names, width)
    return (array[first : first + CHUNK_ROWS] for first in range(0, len(array), CHUNK_ROWS))


def _npy(path: Path) -> NDArray[Any]:
    try:
        if path.stat().st_size == 0:
            raise PlannercheckError("is empty")
        return np.lib.format.open_memmap(path, mode="r")
    except (OSError, ValueError, EOFError, tokenize.TokenError) as error:  # the last for a broken header
        if isinstance(error, PlannercheckError):
            raise
        raise PlannercheckError(f"is no whole npy file of numbers, cut short perhaps: {error}") from None


def _npz(path: Path) -> NDArray[Any]:
    try:
        with np.load(path, allow_pickle=False) as archive:
            return np.asarray(archive[_npz_key(list(archive.files))])
    except (
        OSError,
        ValueError,
        EOFError,
        NotImplementedError,  # of zipfile, for an unknown compression
        RuntimeError,  # of zipfile, for encryption
        tokenize.TokenError,
        zipfile.BadZipFile,
        zlib.error,
    ) as error:
        if isinstance(error, PlannercheckError):
            raise
        raise PlannercheckError(f"is no whole npz file of numbers: {error}") from None


def _npz_key(names: list[str]) -> str:
    """Which array to take: the only one, or the one with the usual name."""
    if len(names) == 1:
        return names[0]
    found = [key for key in _NPZ_KEYS if key in names]
    if not found:
        held = ", ".join(names) or "nothing"
        raise PlannercheckError(f"must hold one array, or one named {' or '.join(_NPZ_KEYS)}; it holds {held}")
    return found[0]


def _shaped(array: NDArray[Any], joint_names: Sequence[str], width: int) -> NDArray[Any]:
    """The array as (n, nq); a single configuration (nq,) is one row."""
    if array.dtype.kind not in "fiu":
        raise PlannercheckError(f"must hold real numbers, not {array.dtype}")
    rows = array[None] if array.ndim == 1 else array
    if rows.ndim != 2 or rows.shape[1] != width:
        hint = shape_hint(array.shape, joint_names, width)
        raise PlannercheckError(f"must have shape (n, {width}), not {array.shape}; {hint}")
    return rows


def _csv_blocks(path: Path, joint_names: Sequence[str], width: int) -> Iterator[Floats]:
    try:
        with path.open(encoding="utf-8-sig", newline=None) as file:
            yield from _csv_rows(file, joint_names, width)
    except (OSError, UnicodeDecodeError) as error:
        raise PlannercheckError(f"is no readable text: {error}") from None


def _csv_rows(file: TextIO, joint_names: Sequence[str], width: int) -> Iterator[Floats]:
    lines = (line for line in file if line.strip() and not line.lstrip().startswith("#"))
    first = next(lines, None)
    if first is None:
        raise PlannercheckError("holds no configuration")
    separator = next((s for s in ",;\t" if s in first), None)
    names = _fields(first, separator)
    columns = None if _is_row(names) else _columns(names, joint_names, width)
    pending = [first] if columns is None else []
    done = 0
    while block := pending + list(islice(lines, CHUNK_ROWS - len(pending))):
        rows = _parsed(block, separator, done, len(names))
        if columns is None and rows.shape[1] != width:
            raise PlannercheckError(f"must have {width} columns ({', '.join(joint_names)}), not {rows.shape[1]}")
        yield rows if columns is None else rows[:, columns]
        done, pending = done + len(rows), []


def _parsed(lines: list[str], separator: str | None, first_row: int, width: int) -> Floats:
    """The numbers of some lines (n, width)."""
    try:
        rows = np.loadtxt(lines, delimiter=separator, ndmin=2, comments=None)
        if rows.shape[1] == width:
            return rows
    except ValueError:
        pass
    for k, line in enumerate(lines):  # slow, but only to say which line it is
        fields = _fields(line, separator)
        if len(fields) != width or not _is_row(fields):
            shown = line.strip()[:60]
            raise PlannercheckError(f"row {first_row + k} must have {width} numbers, not {shown!r}")
    raise PlannercheckError(f"rows from {first_row} on are no table of numbers")


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


def _columns(names: Sequence[str], joint_names: Sequence[str], width: int) -> list[int]:
    """Where the header has each joint."""
    if len(joint_names) != width:
        raise PlannercheckError(
            f"has a header, but {len(joint_names)} joints take {width} numbers: leave the header out"
        )
    for joint in joint_names:
        if names.count(joint) > 1:
            raise PlannercheckError(f"has {names.count(joint)} columns named {joint!r}")
    missing = [joint for joint in joint_names if joint not in names]
    if len(missing) == len(joint_names):
        raise PlannercheckError(
            f"begins with neither numbers nor names of joints: {', '.join(names)[:60]!r}; write decimal points, not "
            f"commas, or a header of {', '.join(joint_names)}"
        )
    if missing:
        raise PlannercheckError(f"has no column for joint {missing[0]!r}; its header is {', '.join(names)}")
    return [names.index(joint) for joint in joint_names]
