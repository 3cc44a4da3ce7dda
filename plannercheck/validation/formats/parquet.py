"""Parquet, by pyarrow: one column for each joint, found by name, or one column of lists.

In: a path. Out: `RowBlock`s, decoded batch by batch.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.optional_imports import extra_module
from plannercheck.validation.formats.blocks import RowBlock, chosen_key, even
from plannercheck.validation.formats.columns import Columns, WidthError

# Bytes that are read at once from each column of a row group, which may be larger than memory.
_BUFFER = 1 << 20


def parquet_blocks(path: Path, columns: Columns, size: int, key: str | None = None) -> Iterator[RowBlock]:
    """Rows of a parquet file; `key` is the column of lists, if it is not the only one."""
    arrow = extra_module("pyarrow", "parquet", "parquet files")
    parquet = extra_module("pyarrow.parquet", "parquet", "parquet files")
    try:
        with parquet.ParquetFile(path, buffer_size=_BUFFER, pre_buffer=False) as file:
            chosen = _chosen(arrow, file.schema_arrow, columns, key)
            yield from even(_batches(arrow, file, chosen, columns, size), size, columns.width)
    except (arrow.ArrowException, OSError, ValueError) as error:  # the last for names that are no text
        if isinstance(error, PlannercheckError):
            raise
        raise PlannercheckError(f"is no whole parquet file: {error}") from None


def _chosen(arrow: Any, schema: Any, columns: Columns, key: str | None) -> list[str]:
    """The columns to read: that of lists, or the joints' in the robot's order."""
    names = list(schema.names)
    lists = [name for k, name in enumerate(names) if _is_list(arrow, schema.field(k).type)]  # names may repeat
    if key is not None or (lists and not all(name in names for name in columns.names)):
        columns.check_nameless()
        return [chosen_key(lists, key, "column of lists")]
    return [names[place] for place in columns.places(names)]


def _is_list(arrow: Any, kind: Any) -> bool:
    types = arrow.types
    return bool(types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind))


def _batches(arrow: Any, file: Any, chosen: list[str], columns: Columns, size: int) -> Iterator[RowBlock]:
    total, done = file.metadata.num_rows, 0
    for batch in file.iter_batches(batch_size=size, columns=chosen):
        # Columns come in the file's order.
        arrays = [batch.column(batch.schema.get_field_index(name)) for name in chosen]
        first = arrays[0]
        is_list = len(chosen) == 1 and _is_list(arrow, first.type)
        rows = _of_list(first, columns.width, done) if is_list else _of_columns(arrays, chosen, done)
        done += len(rows)
        yield RowBlock(rows, done / max(total, 1))


def _of_list(values: Any, width: int, first_row: int) -> Floats:
    """(n, width) of lists that all have as many numbers."""
    lengths = _numbers(values.value_lengths() if hasattr(values, "value_lengths") else None, len(values), width)
    missing = np.asarray(values.is_null())
    bad = np.flatnonzero(missing | (lengths != width))
    if len(bad):
        held = "nothing" if missing[bad[0]] else f"{int(lengths[bad[0]])}"
        raise WidthError(f"row {first_row + int(bad[0])} must have {width} numbers, not {held}")
    flat = values.flatten()
    return _real(flat, "the column of lists", first_row, width).reshape(-1, width)


def _numbers(lengths: Any, count: int, width: int) -> NDArray[Any]:
    """Lengths of lists; those of fixed size have none of their own."""
    if lengths is None:
        return np.full(count, width)
    return np.asarray(lengths.fill_null(width).to_numpy(zero_copy_only=False))


def _of_columns(arrays: list[Any], names: list[str], first_row: int) -> Floats:
    return np.stack([_real(a, f"column {n!r}", first_row, 1) for a, n in zip(arrays, names, strict=True)], axis=1)


def _real(array: Any, what: str, first_row: int, width: int) -> Floats:
    """An array of pyarrow as numbers; nothing is no number."""
    if array.null_count:
        row = first_row + int(np.flatnonzero(np.asarray(array.is_null()))[0]) // width
        raise PlannercheckError(f"row {row} has no number in {what}")
    values = array.to_numpy(zero_copy_only=False)
    if values.dtype.kind not in "fiu":
        raise PlannercheckError(f"{what} must hold real numbers, not {array.type}")
    return np.asarray(values, dtype=np.float64)
