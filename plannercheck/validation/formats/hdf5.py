"""HDF5, by h5py: a dataset (n, nq), or one dataset (n,) for each joint.

In: a path. Out: `RowBlock`s. A dataset may name its columns by an attribute `joint_names`, by a dataset of that name
beside it, or by fields.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from plannercheck.common.errors import PlannercheckError
from plannercheck.common.optional_imports import extra_module
from plannercheck.validation.formats.blocks import (
    NAMES_KEY,
    RowBlock,
    check_real,
    check_unread_names,
    chosen_key,
    fields_of,
    places_of,
    stacked,
    table_shape,
)
from plannercheck.validation.formats.columns import Columns


def hdf5_blocks(path: Path, columns: Columns, size: int, key: str | None = None) -> Iterator[RowBlock]:
    """Rows of an HDF5 file; `key` is the path of the dataset or of the group with one dataset a joint."""
    h5py = extra_module("h5py", "hdf5", "hdf5 files")
    try:
        with h5py.File(path, "r") as file:
            group = file if key is None or not isinstance(_item(h5py, file, key), h5py.Group) else file[key]
            joints = [_item(h5py, group, name) for name in columns.names]
            if joints and all(isinstance(joint, h5py.Dataset) for joint in joints):
                yield from _of_joints(joints, columns, size)
            else:
                table = _dataset(h5py, file, key)
                yield from _of_table(table, _names(h5py, file, table, columns), columns, size)
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:
        if isinstance(error, PlannercheckError):
            raise
        raise PlannercheckError(f"is no whole hdf5 file: {error}") from None


def _dataset(h5py: Any, file: Any, key: str | None) -> Any:
    found: list[str] = []
    file.visititems(lambda name, item: found.append(name) if isinstance(item, h5py.Dataset) else None)
    found = [name for name in found if name.rpartition("/")[2] != NAMES_KEY]
    return _item(h5py, file, chosen_key(found, None if key is None else key.strip("/"), "dataset"))


def _names(h5py: Any, file: Any, table: Any, columns: Columns) -> Any:
    """What the columns are called; None if the file does not say it. Names that are not read are refused."""
    beside = _item(h5py, table.parent, NAMES_KEY)
    given = table.attrs.get(NAMES_KEY, beside[()] if isinstance(beside, h5py.Dataset) else None)
    if given is None:
        for group in (table, table.parent, file):
            texts = {name: np.atleast_1d(group.attrs[name]) for name in group.attrs}
            if group is not table:
                texts |= {name: group[name][()] for name in group if _is_text(h5py, group, name, len(columns.names))}
            for name, values in texts.items():
                check_unread_names(name, values.ravel().tolist(), columns)
    return given


def _is_text(h5py: Any, group: Any, name: str, count: int) -> bool:
    """Whether a name is of so many texts in this file."""
    item = group[name] if isinstance(group.get(name, getlink=True), h5py.HardLink) else None
    if not isinstance(item, h5py.Dataset) or item.shape != (count,) or item.external or item.is_virtual:
        return False
    return h5py.check_string_dtype(item.dtype) is not None


def _item(h5py: Any, group: Any, name: str) -> Any:
    """A dataset or group of this file, None if there is none; numbers that lie in another file are never read."""
    parts = [part for part in name.split("/") if part]
    for k in range(len(parts)):
        if isinstance(group.get("/".join(parts[: k + 1]), getlink=True), h5py.ExternalLink):
            raise PlannercheckError(f"{name!r} leads to another file, which is not read: copy it into this one")
    item = group.get(name)
    if isinstance(item, h5py.Dataset) and (item.external or item.is_virtual):
        raise PlannercheckError(f"dataset {name!r} lies in another file, which is not read: copy it into this one")
    return item


def _of_joints(joints: list[Any], columns: Columns, size: int) -> Iterator[RowBlock]:
    shapes = {tuple(joint.shape) for joint in joints}
    if len(shapes) != 1 or len(joints[0].shape) != 1:
        raise PlannercheckError(f"datasets of the joints must all have the same shape (n,), not {sorted(shapes)}")
    for joint in joints:
        check_real(joint.dtype)
    count = int(joints[0].shape[0])
    for first in range(0, count, size):
        last = min(first + size, count)
        rows = np.stack([np.asarray(joint[first:last], dtype=np.float64) for joint in joints], axis=1)
        yield RowBlock(rows, last / count)


def _of_table(table: Any, names: Any, columns: Columns, size: int) -> Iterator[RowBlock]:
    fields = fields_of(table.dtype, columns)
    places = places_of(names, columns)
    if fields is None:
        width = None if places is None else len(names)
        count = table_shape(tuple(table.shape), columns, width)[0]
    else:
        count = int(table.shape[0])
    for first in range(0, count, size):
        last = min(first + size, count)
        values = np.asarray(table[first:last] if table.ndim > 1 or fields else table[()])
        rows = np.atleast_2d(values.astype(np.float64)) if fields is None else stacked(values, fields)
        yield RowBlock(rows if places is None else rows[:, places], last / count)
