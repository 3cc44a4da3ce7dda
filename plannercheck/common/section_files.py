"""Files of named arrays behind a checksum, as plannercheck's C++ library reads them (cpp/library/cell_file.hpp).

In: sections, in the order in which they are read. Out: bytes. A file has a header of 48 bytes (magic word, format of
the file and of bodies, size, number of sections, CRC-32 of all that follows the header), an entry of 64 bytes for each
section (name, type, columns, rows, place), and the sections, each at a multiple of 64. Numbers are little-endian.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.errors import PlannercheckError

_MAGIC = b"plannercheck\n"
_HEADER, _ENTRY = struct.Struct("<16sIIQIIQ"), struct.Struct("<32sIIQQQ")
_ALIGNMENT = 64
_TYPES = {np.dtype("u1"): 1, np.dtype("<i4"): 2, np.dtype("<f8"): 3}


class Section(NamedTuple):
    """A named array.

    Attributes:
        name: At most 31 letters.
        values: (rows,) or (rows, columns…) of uint8, int32 or float64; a number is one row.
    """

    name: str
    values: NDArray[Any] | float


Sections: TypeAlias = Iterable[Section]


def text(name: str, value: str) -> Section:
    """A section of a text in UTF-8."""
    return Section(name, np.frombuffer(value.encode(), dtype=np.uint8))


def texts(name: str, values: Sequence[str]) -> Section:
    """A section of texts that a zero ends each.

    Raises:
        PlannercheckError: If one of them has a zero.
    """
    for value in values:
        if "\0" in value:
            raise PlannercheckError(f"{name}: {value!r} has a zero character, which a file can't hold")
    return text(name, "".join(f"{value}\0" for value in values))


def file_of(sections: Sections, file_format: int, body_format: int) -> bytes:
    """The bytes of a file of sections, given its format and that of bodies in it."""
    arrays = [(name, _array(values)) for name, values in sections]
    entries, data = b"", b""
    start = end = _HEADER.size + len(arrays) * _ENTRY.size
    blocks: list[bytes] = []
    for name, array in arrays:
        offset = -(-end // _ALIGNMENT) * _ALIGNMENT
        columns = int(np.prod(array.shape[1:], dtype=np.int64))
        entries += _ENTRY.pack(name.encode(), _TYPES[array.dtype], columns, len(array), offset, 0)
        blocks += [bytes(offset - end), array.tobytes()]
        end = offset + array.nbytes
    data = entries + b"".join(blocks)
    assert len(data) == end - start + len(entries)
    header = _HEADER.pack(_MAGIC, file_format, body_format, end, len(arrays), zlib.crc32(data), 0)
    return header + data


def _array(values: NDArray[Any] | float) -> NDArray[Any]:
    array = np.atleast_1d(np.asarray(values))
    kind = {"u": "u1", "b": "u1", "i": "<i4", "f": "<f8"}[array.dtype.kind]
    return np.ascontiguousarray(array, dtype=kind)
