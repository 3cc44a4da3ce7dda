"""npy and npz: arrays of numpy, read block by block, so that only one block is in memory.

In: a path or a binary stream. Out: `RowBlock`s. Only arrays in Fortran's order inside an npz or on a stream are read
whole, since their rows are scattered.
"""

from __future__ import annotations

import os
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import BROKEN_FILE
from plannercheck.common.errors import PlannercheckError
from plannercheck.validation.formats.blocks import (
    NAMES_KEY,
    RowBlock,
    check_unread_names,
    chosen_key,
    fields_of,
    places_of,
    stacked,
    table_shape,
)
from plannercheck.validation.formats.columns import Columns

NPY_MAGIC = b"\x93NUMPY"


@contextmanager
def _whole(kind: str) -> Iterator[None]:
    """Says of what numpy and zipfile raise that the file is no whole one of its kind."""
    try:
        yield
    except BROKEN_FILE as error:
        if isinstance(error, PlannercheckError):
            raise
        raise PlannercheckError(f"is no whole {kind} of numbers, cut short perhaps: {error!s:.200}") from None


def npy_blocks(path: Path, columns: Columns, size: int) -> Iterator[RowBlock]:
    """Rows of an npy file, read from one descriptor: a file that takes its place meanwhile is never mixed in.

    It is read, not mapped: a mapping of a file that somebody cuts short kills the process.
    """
    with _whole("npy file"), path.open("rb") as file:
        if os.fstat(file.fileno()).st_size == 0:
            raise PlannercheckError("is empty")
        whole = np.lib.format.open_memmap(path, mode="r")  # maps only; says whether the file is complete
        layout, offset = _Layout.of(whole.shape, whole.dtype, whole.flags.fnc, columns), whole.offset
        _check_end(offset + whole.nbytes < os.fstat(file.fileno()).st_size)
        del whole
        for first in range(0, layout.total, size):
            n = min(size, layout.total - first)
            if layout.by_column:
                rows = np.empty((n, columns.width))
                for k in range(columns.width):
                    rows[:, k] = _window(file, layout.dtype, offset, k * layout.total + first, n)
            else:
                rows = layout.rows(_window(file, layout.dtype, offset, first * layout.numbers, n * layout.numbers), n)
            yield RowBlock(rows, (first + n) / layout.total)


def _window(file: BinaryIO, dtype: np.dtype[Any], offset: int, first: int, count: int) -> NDArray[Any]:
    file.seek(offset + first * dtype.itemsize)
    return _values(file, dtype, count)


class _Layout(NamedTuple):
    """How rows lie in an array.

    Attributes:
        total: Number of rows.
        width: Numbers in a row.
        numbers: Values in a row: one if they are records.
        dtype: Type of a value.
        fields: The joints' fields of a record, in order; None if values are numbers.
        by_column: Whether columns, not rows, are together.
    """

    total: int
    width: int
    numbers: int
    dtype: np.dtype[Any]
    fields: list[str] | None
    by_column: bool

    @classmethod
    def of(cls, shape: tuple[int, ...], dtype: np.dtype[Any], by_column: bool, columns: Columns) -> _Layout:
        """The layout of an array, or an error if it is no table of configurations."""
        fields = fields_of(dtype, columns)
        if fields is None:
            count, width = table_shape(shape, columns)
            return cls(count, width, width, dtype, None, by_column and len(shape) > 1)
        if len(shape) != 1:
            raise PlannercheckError(f"must have shape (n,) if its numbers have names, not {shape}")
        return cls(shape[0], len(fields), 1, dtype, fields, False)

    def rows(self, values: NDArray[Any], count: int) -> Floats:
        """Consecutive values as so many rows of their own memory."""
        if self.fields is not None:
            return stacked(values, self.fields)
        return np.array(values, dtype=np.float64).reshape(count, self.width)


def npy_stream_blocks(stream: BinaryIO, columns: Columns, size: int, kind: str = "npy file") -> Iterator[RowBlock]:
    """Rows of an npy file that can only be read from its beginning to its end."""
    with _whole(kind):
        shape, by_column, dtype = _header(stream)
        if dtype.hasobject:
            raise PlannercheckError("must hold real numbers, not objects")
        layout = _Layout.of(shape, dtype, by_column, columns)
    if layout.total < 0:
        raise PlannercheckError(f"is no whole {kind} of numbers: its header tells of {layout.total} rows")
    if layout.by_column:
        with _whole(kind):
            values = _values(stream, layout.dtype, layout.total * layout.width)
        whole = np.array(values.reshape(layout.width, layout.total).T, dtype=np.float64, order="C")
    for first in range(0, layout.total, size):
        n = min(size, layout.total - first)
        if layout.by_column:
            rows = whole[first : first + n]
        else:
            with _whole(kind):
                rows = layout.rows(_values(stream, layout.dtype, n * layout.numbers), n)
        yield RowBlock(rows, (first + n) / layout.total)
    _check_end(bool(stream.read(1)))


def _check_end(goes_on: bool) -> None:
    """Raises if a file goes on behind its array: its rows would be lost."""
    if goes_on:
        raise PlannercheckError("holds more behind its array, of which nothing is read: give each array its own file")


def _header(stream: BinaryIO) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Shape, whether columns are together, and type of the array that a stream begins with."""
    version = np.lib.format.read_magic(stream)
    readers = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
    if version not in readers:
        raise PlannercheckError(f"is of npy version {version}; 1.0 and 2.0 can be read as a stream")
    return readers[version](stream)


def _values(stream: BinaryIO, dtype: np.dtype[Any], count: int) -> NDArray[Any]:
    wanted = count * dtype.itemsize
    parts = []
    while wanted:
        part = stream.read(wanted)
        if not part:
            raise PlannercheckError(f"is cut short: {wanted} bytes are missing")
        parts.append(part)
        wanted -= len(part)
    return np.frombuffer(parts[0] if len(parts) == 1 else b"".join(parts), dtype=dtype)


def npz_blocks(path: Path, columns: Columns, size: int, key: str | None = None) -> Iterator[RowBlock]:
    """Rows of an array in an npz file: the one named by `key`, its only one, or the one with the usual name.

    An array `joint_names` beside it names the columns.
    """
    with _whole("npz file"), zipfile.ZipFile(path) as archive:
        names = [name.removesuffix(".npy") for name in archive.namelist() if name != f"{NAMES_KEY}.npy"]
        chosen = chosen_key(names, key, "array")
        given = _joint_names(path) if f"{NAMES_KEY}.npy" in archive.namelist() else None
        if given is None:
            _check_texts(path, archive, columns)
        places = places_of(given, columns)
        with archive.open(f"{chosen}.npy") as stream:
            for rows, part in npy_stream_blocks(
                cast(BinaryIO, stream), columns if given is None else _all(given), size, "npz file"
            ):
                yield RowBlock(rows if places is None else rows[:, places], part)


def _check_texts(path: Path, archive: zipfile.ZipFile, columns: Columns) -> None:
    """Raises if an array of texts names the joints without being read."""
    for member in archive.namelist():
        if member.endswith(".npy"):
            with archive.open(member) as stream:
                shape, _, dtype = _header(cast(BinaryIO, stream))
            if dtype.kind in "US" and shape == (len(columns.names),):
                name = member.removesuffix(".npy")
                with np.load(path, allow_pickle=False) as arrays:
                    check_unread_names(name, arrays[name].tolist(), columns)


def _all(names: list[str]) -> Columns:
    """All columns of an array, as they are."""
    return Columns(tuple(names), len(names))


def _joint_names(path: Path) -> list[str]:
    with np.load(path, allow_pickle=False) as archive:
        return [str(name) for name in np.atleast_1d(archive[NAMES_KEY])]
