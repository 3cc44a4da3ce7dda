"""PCD files, the point clouds of PCL: text, bytes, and bytes packed field by field.

In: the content of a file. Out: x, y and z of all points, in m, as the file has them: NaN where the sensor had no
return, organised clouds row by row, and the viewpoint, which PCL does not apply to the points either.
(pointclouds.org, "The PCD file format"; PCL's io/src/pcd_io.cpp.)
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.lzf import unpacked
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError, shortened

_KEYS = ("VERSION", "FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA")
_AXES = ("x", "y", "z")
_KINDS = {"F": "f", "I": "i", "U": "u"}
_SIZES = {"F": (4, 8), "I": (1, 2, 4, 8), "U": (1, 2, 4, 8)}
_ENCODINGS = ("ascii", "binary", "binary_compressed")

# The most bytes of a header, and of numbers in it; valid ones take some hundred, and a dozen.
_LONGEST_HEADER, _LONGEST_NUMBER = 1 << 16, 15

# PCL's name for bytes that only fill a point up; packed data does not have them.
_FILLING = "_"

# The most zeros that may follow the points of a binary file: PCL reserves a page for the header, whatever it takes.
_LARGEST_PAGE = 1 << 16

_NO_VIEWPOINT = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class PcdPoints:
    """What a PCD file holds of a cloud.

    Attributes:
        points: (n, 3) in m, as the file has them.
        viewpoint: The sensor's position in m and unit quaternion w, x, y, z, by which the points are not moved.
    """

    points: Floats
    viewpoint: tuple[float, ...]


@dataclass(frozen=True)
class _Field:
    """A field of a point: `count` numbers of a type."""

    name: str
    kind: str
    count: int

    @property
    def size(self) -> int:
        return self.count * np.dtype(self.kind).itemsize


@dataclass(frozen=True)
class _Header:
    fields: list[_Field]
    points: int
    viewpoint: tuple[float, ...]
    encoding: str
    end: int


def read_pcd(content: bytes) -> PcdPoints:
    """The points of a PCD file's content.

    Raises:
        PlannercheckError: If it is none, is cut short, or its header contradicts itself.
    """
    header = _header(content)
    body = content[header.end :]
    if header.encoding == "ascii":
        points = _of_text(body, header)
    elif header.encoding == "binary":
        points = _of_bytes(body, header)
    else:
        points = _of_packed_bytes(body, header)
    return PcdPoints(points, header.viewpoint)


def is_moved(viewpoint: Sequence[float]) -> bool:
    """Whether a viewpoint is another one than the points' own origin."""
    return tuple(viewpoint) != _NO_VIEWPOINT


def _header(content: bytes) -> _Header:
    """The header's lines; each key once, the last is DATA."""
    entries: dict[str, list[str]] = {}
    at = 0
    while "DATA" not in entries:
        end = content.find(b"\n", at, _LONGEST_HEADER)
        if end < 0:
            raise PlannercheckError("is no PCD file, or its header is cut short: a header ends with a line DATA")
        words = content[at:end].decode("latin-1").split()
        at = end + 1
        if not words or words[0].startswith("#"):
            continue
        key = "FIELDS" if words[0] == "COLUMNS" else words[0]  # its name in old files
        if key not in _KEYS or key in entries:
            twice = "twice" if key in entries else f"that is none of {', '.join(_KEYS)}"
            raise PlannercheckError(f"its PCD header has a line {shortened(words[0])!r} {twice}")
        entries[key] = words[1:]
    if entries["DATA"] not in [[name] for name in _ENCODINGS]:
        raise PlannercheckError(
            f"its PCD header has DATA {shortened(' '.join(entries['DATA']))!r}, valid are {', '.join(_ENCODINGS)}"
        )
    fields = _fields(entries)
    points = _count_of_points(entries)
    return _Header(fields, points, _viewpoint(entries), entries["DATA"][0], at)


def _fields(entries: dict[str, list[str]]) -> list[_Field]:
    names = entries.get("FIELDS", [])
    types = _as_many(entries, "TYPE", names, "F")
    sizes = [_whole(word, "SIZE") for word in _as_many(entries, "SIZE", names, "4")]
    counts = [_whole(word, "COUNT") for word in _as_many(entries, "COUNT", names, "1")]
    for name, kind, size in zip(names, types, sizes, strict=True):
        if size not in _SIZES.get(kind, ()):
            raise PlannercheckError(f"its PCD field {shortened(name)!r} has TYPE {shortened(kind)} of SIZE {size}")
    fields = [
        _Field(name, f"<{_KINDS[kind]}{size}", count)
        for name, kind, size, count in zip(names, types, sizes, counts, strict=True)
    ]
    for axis in _AXES:
        found = [field for field in fields if field.name == axis]
        if len(found) != 1 or found[0].count != 1:
            raise PlannercheckError(f"a PCD file of points needs one field {axis!r} of COUNT 1")
    return fields


def _as_many(entries: dict[str, list[str]], key: str, names: list[str], default: str) -> list[str]:
    """The words of a key, one for each field."""
    words = entries.get(key, [default] * len(names))
    if len(words) != len(names):
        raise PlannercheckError(f"its PCD header has {len(names)} FIELDS, but {len(words)} entries of {key}")
    return words


def _count_of_points(entries: dict[str, list[str]]) -> int:
    """POINTS, or WIDTH times HEIGHT, which must agree."""
    given = {key: _whole(_only(entries[key], key), key) for key in ("WIDTH", "HEIGHT", "POINTS") if key in entries}
    if "WIDTH" not in given:
        if "POINTS" not in given:
            raise PlannercheckError("its PCD header says neither POINTS nor WIDTH")
        return given["POINTS"]
    count = given["WIDTH"] * given.get("HEIGHT", 1)
    if given.get("POINTS", count) != count:
        raise PlannercheckError(
            f"its PCD header has WIDTH {given['WIDTH']} and HEIGHT {given.get('HEIGHT', 1)}, but "
            f"{given['POINTS']} POINTS"
        )
    return count


def _viewpoint(entries: dict[str, list[str]]) -> tuple[float, ...]:
    words = entries.get("VIEWPOINT")
    if words is None:
        return _NO_VIEWPOINT
    try:
        numbers = tuple(float(word) for word in words)
    except ValueError:
        numbers = ()
    if len(numbers) != len(_NO_VIEWPOINT) or not all(math.isfinite(number) for number in numbers):
        raise PlannercheckError(f"its PCD VIEWPOINT must be seven numbers, not {shortened(' '.join(words))!r}")
    return numbers


def _only(words: list[str], key: str) -> str:
    if len(words) != 1:
        raise PlannercheckError(f"its PCD header has {key} {shortened(' '.join(words))!r}, it must be one number")
    return words[0]


def _whole(word: str, key: str) -> int:
    if not (word.isdecimal() and word.isascii() and len(word) <= _LONGEST_NUMBER):
        raise PlannercheckError(f"its PCD header has {key} {shortened(word)!r}, it must be a whole number")
    return int(word)


def _of_text(body: bytes, header: _Header) -> Floats:
    """A point a line; each line has all numbers of all fields. They become doubles, whatever SIZE says."""
    if header.points and not body.endswith((b"\n", b"\r")):
        raise PlannercheckError("is cut short: its last line has no end; if it is whole, add an end of line")
    lines = [line for line in body.decode("latin-1").splitlines() if line.strip()]
    if len(lines) != header.points:
        raise _other_size(header, f"{len(lines)} lines")
    width = sum(field.count for field in header.fields)
    column = _starts(header.fields, [field.count for field in header.fields])
    points = np.empty((len(lines), 3))
    for row, line in enumerate(lines):
        words = line.split()
        if len(words) != width:
            raise PlannercheckError(f"point {row} has {len(words)} numbers, the header says {width}")
        try:
            if "_" in line:  # Python reads 1_000
                raise ValueError
            points[row] = [float(words[column[axis]]) for axis in _AXES]
        except ValueError:
            raise PlannercheckError(f"point {row} is {shortened(line)!r}, these are no numbers") from None
    return points


def _of_bytes(body: bytes, header: _Header) -> Floats:
    """Point after point, each with all of its fields."""
    sizes = [field.size for field in header.fields]
    step = sum(sizes)
    if not _is_filled(body, step * header.points):
        raise _other_size(header, f"{len(body)} bytes, not {step * header.points}")
    if not header.points:
        return np.zeros((0, 3))
    start, kind = _starts(header.fields, sizes), {field.name: field.kind for field in header.fields}
    return _columns([np.ndarray((header.points,), kind[a], body, start[a], (step,)) for a in _AXES])


def _of_packed_bytes(body: bytes, header: _Header) -> Floats:
    """All values of the first field, then all of the next; two sizes stand before the packed bytes."""
    fields = [field for field in header.fields if field.name != _FILLING]
    wanted = header.points * sum(field.size for field in fields)
    if len(body) < 8:
        raise _other_size(header, f"{len(body)} bytes, and needs its two sizes")
    packed_size, size = np.frombuffer(body, "<u4", 2).tolist()
    if size != wanted or not _is_filled(body, 8 + packed_size):
        raise _other_size(
            header, f"{len(body) - 8} packed bytes of {size}: its sizes say {packed_size}, its header {wanted}"
        )
    data = unpacked(body[8 : 8 + packed_size], size)
    start, kind = _starts(fields, [field.size for field in fields]), {field.name: field.kind for field in fields}
    return _columns([np.frombuffer(data, kind[a], header.points, start[a] * header.points) for a in _AXES])


def _starts(fields: list[_Field], sizes: list[int]) -> dict[str, int]:
    """Where each field begins in a point, by its name."""
    return {field.name: sum(sizes[:k]) for k, field in enumerate(fields) if field.name in _AXES}


def _is_filled(body: bytes, size: int) -> bool:
    """Whether the body has as many bytes, and after them nothing but zeros, less than a page of them."""
    return 0 <= len(body) - size < _LARGEST_PAGE and not any(body[size:])


def _columns(columns: Sequence[NDArray[np.generic]]) -> Floats:
    """Points (n, 3) of their coordinates, exact doubles of what the file has."""
    with np.errstate(invalid="ignore"):  # of signalling NaNs, which are points like other NaNs
        return np.column_stack([column.astype(np.float64) for column in columns]).reshape(-1, 3)


def _other_size(header: _Header, found: str) -> PlannercheckError:
    return PlannercheckError(f"is cut short or broken: its header says {header.points} points, it has {found}")
