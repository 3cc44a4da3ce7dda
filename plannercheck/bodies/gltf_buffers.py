"""Numbers of glTF files: accessors, on views, on buffers.

In: the file's JSON, its folder, and a GLB's binary chunk. Out: arrays, with sparse entries put in.
"""

from __future__ import annotations

import base64
from pathlib import Path
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.gltf_json import Table
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.errors import PlannercheckError, shortened
from plannercheck.common.package_data import is_file

_KINDS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_INDEX_KINDS = (5121, 5123, 5125)
_PLACE_KINDS = (5126, 5120, 5121, 5122, 5123)  # the last four by KHR_mesh_quantization
_COLUMNS = {"SCALAR": 1, "VEC3": 3}

# Largest values of normalised whole numbers, which stand for 1.
_ONE = {5120: 127, 5121: 255, 5122: 32767, 5123: 65535}

# Most numbers of an accessor without data, which are zeros: it needs no bytes in the file.
_MOST_ZEROS = 100_000_000


class Buffers:
    """The numbers of one file; its buffers are read when they are first needed."""

    def __init__(self, root: Table, folder: Path, binary: bytes | None) -> None:
        """Binary is the chunk of a GLB file, the first buffer of files that name no other."""
        self._root, self._folder, self._binary = root, folder, binary
        self._read: dict[int, bytes] = {}

    def places(self, accessor: int) -> Floats:
        """Places (n, 3), as doubles.

        Raises:
            PlannercheckError: If they are not finite, or not there.
        """
        table = self._root.pick("accessors", accessor)
        kind = table.integer("componentType")
        with np.errstate(invalid="ignore"):  # of signalling NaNs
            found = self._accessed(table, "VEC3", _PLACE_KINDS).astype(np.float64)
        if not np.isfinite(found).all():
            raise PlannercheckError(
                f"{table.name}: place {int(np.argmin(np.isfinite(found).all(axis=1)))} is not finite"
            )
        if kind in _ONE and table.items.get("normalized") is True:
            found = np.maximum(found / _ONE[kind], -1.0)
        return found

    def indices(self, accessor: int) -> Ints64:
        """Indices (n,) of vertices."""
        table = self._root.pick("accessors", accessor)
        return self._accessed(table, "SCALAR", _INDEX_KINDS).reshape(-1).astype(np.int64)

    def _accessed(self, table: Table, kind: str, allowed: tuple[int, ...]) -> NDArray[np.generic]:
        """The numbers (n, columns) of an accessor."""
        columns, count = _COLUMNS[kind], table.integer("count")
        if table.text("type") != kind or table.integer("componentType") not in allowed:
            raise PlannercheckError(f"{table.name} must be {kind} of a type that glTF allows there")
        dtype = np.dtype(_KINDS[table.integer("componentType")])
        if "bufferView" in table.items:
            found = self._viewed(table, dtype, count, columns)
        elif "sparse" not in table.items:
            raise PlannercheckError(f"{table.name} has no data: it may be compressed, which is not read")
        elif count * columns > _MOST_ZEROS:
            raise PlannercheckError(f"{table.name} says {count} zeros")
        else:
            found = np.zeros((count, columns), dtype=dtype)
        return self._with_sparse(table, found, dtype) if "sparse" in table.items else found

    def _with_sparse(
        self, table: Table, found: NDArray[np.generic], dtype: np.dtype[np.generic]
    ) -> NDArray[np.generic]:
        sparse = table.table("sparse")
        count, places = sparse.integer("count"), sparse.table("indices")
        if places.integer("componentType") not in _INDEX_KINDS:
            raise PlannercheckError(f"{places.name} must have a type of whole numbers")
        rows = self._viewed(places, np.dtype(_KINDS[places.integer("componentType")]), count, 1).reshape(-1)
        rows = rows.astype(np.int64)
        if len(rows) and (rows.max() >= len(found) or (np.diff(rows) <= 0).any()):
            raise PlannercheckError(f"{places.name} must grow, and stay below {len(found)}")
        found = found.copy()
        found[rows] = self._viewed(sparse.table("values"), dtype, count, found.shape[1])
        return found

    def _viewed(self, table: Table, dtype: np.dtype[np.generic], count: int, columns: int) -> NDArray[np.generic]:
        """Numbers (count, columns) where an accessor, or a part of a sparse one, says."""
        view = self._root.pick("bufferViews", table.integer("bufferView"))
        if any("meshopt" in name for name in view.table("extensions", {}).items):
            raise PlannercheckError(f"{view.name} is compressed (meshopt), which is not read: export without it")
        data = self._buffer(view.integer("buffer"))
        begin, length, offset = (
            view.integer("byteOffset", 0),
            view.integer("byteLength"),
            table.integer("byteOffset", 0),
        )
        row = columns * dtype.itemsize
        stride = view.integer("byteStride", row)
        if begin + length > len(data):
            raise PlannercheckError(f"{view.name} ends beyond its buffer of {len(data)} bytes")
        if stride < row or (count and offset + (count - 1) * stride + row > length):
            raise PlannercheckError(f"{table.name} has {count} entries, which do not fit into {view.name}")
        octets = np.frombuffer(data, np.uint8)
        if not count:
            return np.zeros((0, columns), dtype=dtype)
        at = begin + offset
        rows = np.lib.stride_tricks.as_strided(octets[at:], (count, row), (stride, 1), writeable=False)
        return np.ascontiguousarray(rows).view(dtype)

    def _buffer(self, index: int) -> bytes:
        if index not in self._read:
            table = self._root.pick("buffers", index)
            length = table.integer("byteLength")
            data = self._data(table, index)
            if len(data) < length:
                raise PlannercheckError(f"{table.name} has {len(data)} bytes, but says {length}")
            self._read[index] = data[:length]
        return self._read[index]

    def _data(self, table: Table, index: int) -> bytes:
        if "uri" not in table.items:
            if index or self._binary is None:
                raise PlannercheckError(f"{table.name} has no data")
            return self._binary
        uri = table.text("uri")
        if uri.startswith("data:"):
            head, _, text = uri.partition(",")
            try:
                if not head.endswith(";base64"):
                    raise ValueError("not in base64")
                return base64.b64decode(text, validate=True)
            except ValueError as error:
                raise PlannercheckError(f"{table.name} has data that can't be read: {error}") from None
        if "://" in uri:
            raise PlannercheckError(f"{table.name} is at {shortened(uri)!r}: only files are read")
        path = self._folder / unquote(uri)
        if not is_file(path):
            raise PlannercheckError(f"{table.name}: file {shortened(path)!r} does not exist")
        try:
            return path.read_bytes()
        except OSError as error:
            raise PlannercheckError(f"{table.name}: {shortened(path)!r} can't be read: {error.strerror}") from None
