"""Chunks of checked rows, from files of any format and size, or from standard input.

In: paths. Out: `Chunk`s, so that a set may be larger than memory. Errors name the file and, where there is one, the row
(counted from 0).
"""

from __future__ import annotations

import io
import itertools
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple, cast

import numpy as np

from plannercheck.checking.protocols import AnyRobot
from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.file_kinds import kind_of
from plannercheck.common.package_data import is_file, is_folder, why_no_file
from plannercheck.validation.formats.blocks import RowBlock
from plannercheck.validation.formats.columns import Columns, HeaderError, WidthError, columns_of
from plannercheck.validation.formats.csv import csv_blocks, csv_stream_blocks
from plannercheck.validation.formats.hdf5 import hdf5_blocks
from plannercheck.validation.formats.npy import NPY_MAGIC, npy_blocks, npy_stream_blocks, npz_blocks
from plannercheck.validation.formats.parquet import parquet_blocks

# Rows read at once: some megabytes for any robot, and enough to keep all threads busy.
CHUNK_ROWS = 65_536

STANDARD_INPUT = Path("-")

_PARQUET = (".parquet", ".pq")
_SINGLE = {".npy": npy_blocks, ".csv": csv_blocks, ".tsv": csv_blocks}
_KEYED = {
    ".npz": npz_blocks,
    ".parquet": parquet_blocks,
    ".pq": parquet_blocks,
    ".hdf5": hdf5_blocks,
    ".h5": hdf5_blocks,
}
# Suffixes of files that hold several arrays, of which `key` says which to take.
KEYED_SUFFIXES = tuple(_KEYED)
SUFFIXES = (".npy", ".npz", ".csv", ".tsv", ".parquet", ".pq", ".hdf5", ".h5")

# The first bytes of formats that can't be read from a stream.
_SEEKING = {b"PK\x03\x04": "npz", b"PAR1": "parquet", b"\x89HDF": "hdf5"}


@dataclass(frozen=True, eq=False)
class Chunk:
    """Consecutive rows of a set.

    Attributes:
        first_row: The chunk's first row in its file, from 0.
        rows: (n, nq) float64, rad and m, all finite.
        file: The index of its file, from 0.
        part: The part of all files that has been read with this chunk, 0 to 1; None if unknown.
    """

    first_row: int
    rows: Floats
    file: int = 0
    part: float | None = None


def files_of(paths: Sequence[Path]) -> list[Path]:
    """The paths, with the parquet files in a folder, in the order of their names, in place of it."""
    files: list[Path] = []
    for path in paths:
        parts = sorted(p for p in path.glob("*") if p.suffix.lower() in _PARQUET) if is_folder(path) else []
        files += parts or [path]
    return files


def read_sets(
    paths: Sequence[Path], columns: Columns, key: str | None = None, size: int = CHUNK_ROWS
) -> Iterator[Chunk]:
    """Reads files chunk by chunk, one after the other.

    Args:
        paths: npy, npz, csv, parquet or hdf5 files; `-` is standard input, npy or csv.
        columns: The columns to read.
        key: The array, dataset or column of lists, for files that hold several.
        size: Most rows of a chunk.

    Yields:
        Chunks in order; none goes over the end of a file.

    Raises:
        PlannercheckError: If a file can't be read, has the wrong columns, or a row is not finite.
    """
    if paths.count(STANDARD_INPUT) > 1:
        raise PlannercheckError("standard input can be read only once")
    for path in paths:  # not after hours of work on those before it
        with error_context(_called(path)):
            _check_file(path)
    states = [_state(path) for path in paths]
    sizes = [None if state is None else state.size for state in states]
    total = None if None in sizes else max(1, sum(size or 0 for size in sizes))
    for number, path in enumerate(paths):
        before, own = sum(size or 0 for size in sizes[:number]), sizes[number] or 0
        with error_context(_called(path)):
            for chunk in _checked(_configurations(path, columns, key, size)):
                known = total is not None and chunk.part is not None
                part = (before + own * (chunk.part or 0.0)) / total if known and total else None
                yield Chunk(chunk.first_row, chunk.rows, number, part)
            if _state(path) != states[number]:
                raise PlannercheckError(
                    "has changed while it was read, so what was judged may be a mixture: judge it once more"
                )


def read_chunks(path: str | Path, joint_names: Sequence[str], width: int) -> Iterator[Chunk]:
    """Reads one file, rad and m; a header has to call the joints by these names. See `read_sets`."""
    yield from read_sets([Path(path)], Columns(tuple(joint_names), width), size=CHUNK_ROWS)


def read_states(path: str | Path, robot: AnyRobot) -> Iterator[Chunk]:
    """Reads one file of a robot's configurations, rad and m, in any of its ways. See `read_sets`."""
    yield from read_sets([Path(path)], columns_of(robot), size=CHUNK_ROWS)


def _called(path: Path) -> str:
    return "standard input" if path == STANDARD_INPUT else f"file {str(path)!r}"


class _State(NamedTuple):
    """By what a file is known to be the same as before."""

    device: int
    number: int
    size: int
    changed: int


def _state(path: Path) -> _State | None:
    """The status of a file; None for standard input, and for a file that is gone."""
    if path == STANDARD_INPUT:
        return None
    try:
        found = path.stat()
    except OSError:
        return None
    return _State(found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns)


# What `kind_of` says of files that are what their suffix says.
_KINDS = {
    ".npy": "it is a numpy array, as .npy files are",
    ".npz": "it is a zip archive, as .npz files are",
    **dict.fromkeys((".parquet", ".pq"), "it is a parquet file"),
    **dict.fromkeys((".hdf5", ".h5"), "it is an HDF5 file"),
}


def _check_file(path: Path) -> None:
    """Raises if a file is not there, or in no format that can be read."""
    if path == STANDARD_INPUT:
        return
    if path.suffix.lower() not in SUFFIXES:
        raise PlannercheckError(f"must be one of {', '.join(SUFFIXES)}, not {path.suffix or 'without suffix'}")
    if not is_file(path):
        raise PlannercheckError(why_no_file(path))
    kind = kind_of(path)
    if kind not in ("", "it is empty", _KINDS.get(path.suffix.lower())):
        raise PlannercheckError(f"is no {path.suffix.lower()[1:]} file: {kind}")


def _blocks(path: Path, columns: Columns, key: str | None, size: int) -> Iterator[RowBlock]:
    if path == STANDARD_INPUT:
        if sys.stdin is None:
            raise PlannercheckError("is closed")
        return _stream_blocks(sys.stdin.buffer, columns, size)
    suffix = path.suffix.lower()
    if suffix in _KEYED:
        return _KEYED[suffix](path, columns, size, key)
    return _SINGLE[suffix](path, columns, size)


def _stream_blocks(stream: BinaryIO, columns: Columns, size: int) -> Iterator[RowBlock]:
    """Rows of a stream, npy or csv as its first bytes say."""
    start = stream.read(len(NPY_MAGIC))
    buffered = cast(BinaryIO, io.BufferedReader(_Continued(start, stream)))
    for magic, kind in _SEEKING.items():
        if start.startswith(magic):
            raise PlannercheckError(f"holds {kind}, which can't be read as a stream: npy and csv can")
    if start.startswith(NPY_MAGIC):
        return npy_stream_blocks(buffered, columns, size)
    return _text_stream_blocks(buffered, columns, size)


def _text_stream_blocks(stream: BinaryIO, columns: Columns, size: int) -> Iterator[RowBlock]:
    try:
        with io.TextIOWrapper(stream, encoding="utf-8-sig", newline=None) as text:
            yield from csv_stream_blocks(text, columns, size)
    except UnicodeDecodeError as error:
        raise PlannercheckError(f"is no readable text: {error}") from None


class _Continued(io.RawIOBase):
    """A stream whose first bytes have been read already."""

    def __init__(self, start: bytes, rest: BinaryIO) -> None:
        self._start, self._rest = start, rest

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        part = self._start[: len(buffer)] or self._rest.read(len(buffer))
        self._start = self._start[len(buffer) :]
        buffer[: len(part)] = part
        return len(part)


def _configurations(path: Path, columns: Columns, key: str | None, size: int) -> Iterator[RowBlock]:
    """Blocks of configurations, in whichever of the robot's ways the file gives them."""
    ways = (columns,) if path == STANDARD_INPUT else (columns, *columns.others)
    errors: list[WidthError] = []
    for way in ways:
        blocks = _blocks(path, way, key, size)
        try:
            first = next(blocks, None)
        except WidthError as error:
            errors.append(error)
            continue
        for block in () if first is None else itertools.chain([first], blocks):
            yield RowBlock(way.configurations(block.rows), block.part)
        return
    raise next((error for error in errors if not isinstance(error, HeaderError)), errors[0])


def _checked(blocks: Iterator[RowBlock]) -> Iterator[Chunk]:
    first = 0
    for block in blocks:
        rows = np.ascontiguousarray(block.rows)
        # A sum is quick and not finite if a number is not; if it overflows, the second look tells.
        if not np.isfinite(rows.sum()):
            _check_finite(rows, first)
        yield Chunk(first, rows, part=block.part)
        first += len(rows)


def _check_finite(rows: Floats, first: int) -> None:
    bad = np.flatnonzero(~np.isfinite(rows).all(axis=1))
    if len(bad):
        raise PlannercheckError(f"row {first + int(bad[0])} is not finite: {rows[bad[0]].tolist()}")
