"""Checks that a PLY file is complete, before it reaches a library that would crash on it; reads the points of a cloud.

In: a path. Out: nothing, or its points, or an error that says what is wrong. Assimp and coal crash on PLY files that
are cut short, or whose faces name missing vertices. So header, lengths and indices are checked here first. In other
formats they find such faults themselves.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError, shortened

# The most bytes of a header; a valid one takes some hundred.
_LONGEST_HEADER = 1 << 16

_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_INDICES = ("vertex_indices", "vertex_index")
_FEWEST_CORNERS = 3
# The element of organised clouds: which vertex each place of the scan has. PCL writes it.
_SCAN = "range_grid"
_AXES = ("x", "y", "z")


@dataclass(frozen=True)
class _Property:
    """A property: a number, or, with a type of its count, a list."""

    name: str
    kind: str
    count: str | None = None


@dataclass(frozen=True)
class _Element:
    name: str
    rows: int
    properties: list[_Property]


def check_ply(path: Path) -> None:
    """Raises unless a PLY file is complete and its faces name vertices that it has.

    Args:
        path: The file.

    Raises:
        PlannercheckError: If it is not, or has unknown types of numbers.
    """
    _checked(path)


def points_of_ply(path: Path) -> Floats:
    """The points (n, 3) of a PLY file, in m, as the file has them: a cloud, or a mesh's vertices.

    Raises:
        PlannercheckError: If the file is not complete, has more than its header says, or vertices are not its first
            element. A text must end with an end of line, since its last number could be cut short otherwise.
    """
    content, order, elements, body = _checked(path, exactly=True)
    vertex = elements[0]
    if vertex.name != "vertex" or any(each.count for each in vertex.properties):
        raise PlannercheckError("a PLY file of points must have 'vertex' as its first element, without lists")
    if order:
        table = np.frombuffer(content, _row_type(order, vertex, {}), vertex.rows, body)
        with np.errstate(invalid="ignore"):  # of signalling NaNs, which are points like other NaNs
            return np.column_stack([table[axis].astype(np.float64) for axis in _AXES])
    columns = [[each.name for each in vertex.properties].index(axis) for axis in _AXES]
    lines = [line.split() for line in content[body:].decode("latin-1").splitlines() if line.strip()]
    rows = [[float(words[column]) for column in columns] for words in lines[: vertex.rows]]
    return np.array(rows, dtype=np.float64).reshape(-1, len(_AXES))


def _checked(path: Path, exactly: bool = False) -> tuple[bytes, str, list[_Element], int]:
    """The content of a complete file, its byte order ("" for text), its elements, and where they begin.

    Args:
        path: The file.
        exactly: Whether nothing may follow the elements, and a text must end with an end of line.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise PlannercheckError(f"can't be read: {error.strerror or error}") from None
    order, elements, body = _header(content)
    vertices = [element for element in elements if element.name == "vertex"]
    if len(vertices) != 1 or not {*_AXES} <= {each.name for each in vertices[0].properties if not each.count}:
        raise PlannercheckError("a PLY file needs one element 'vertex' with x, y and z")
    if order == "" and exactly and not content.endswith((b"\n", b"\r")):
        raise PlannercheckError("is cut short: its last line has no end; if it is whole, add an end of line")
    rows = (_words if order == "" else _numbers)(content, body, order, elements, exactly)
    for name, indices in rows:
        if len(indices) and not (indices.min() >= 0 and indices.max() < vertices[0].rows):
            raise PlannercheckError(f"element {name!r} names a vertex that is not among the {vertices[0].rows}")
    return content, order, elements, body


def _header(content: bytes) -> tuple[str, list[_Element], int]:
    """The byte order ("" for text), the elements, and where they begin."""
    end = content.find(b"end_header", 0, _LONGEST_HEADER)
    after = content.find(b"\n", end)
    if not content.startswith(b"ply") or end < 0 or after < 0 or content[end + 10 : after].strip():
        raise PlannercheckError("is no PLY file: it must have a header from 'ply' to 'end_header'")
    lines = [line.split() for line in content[:end].decode("latin-1").splitlines()[1:]]
    lines = [words for words in lines if words and words[0] not in ("comment", "obj_info")]
    if not lines or lines[0][0] != "format" or lines[0][1:] not in [[order, "1.0"] for order in _ORDERS]:
        raise PlannercheckError(f"a PLY file must say its format, {', '.join(_ORDERS)}, and version 1.0")
    elements: list[_Element] = []
    for words in lines[1:]:
        if words[0] == "element" and len(words) == 3 and words[2].isdecimal() and len(words[2]) < 16:
            elements.append(_Element(words[1], int(words[2]), []))
        elif words[0] == "property" and elements:
            elements[-1].properties.append(_property(words[1:]))
        else:
            raise PlannercheckError(f"its PLY header has a line {shortened(' '.join(words))!r}")
    names = [(element.name, each.name) for element in elements for each in element.properties]
    if len(set(names)) < len(names) or len({element.name for element in elements}) < len(elements):
        raise PlannercheckError("its PLY header has an element or a property twice")
    return _ORDERS[lines[0][1]], elements, after + 1


def _property(words: list[str]) -> _Property:
    if len(words) == 2 and words[0] in _TYPES:
        return _Property(words[1], _TYPES[words[0]])
    if len(words) == 4 and words[0] == "list" and words[1] in _TYPES and words[2] in _TYPES:
        return _Property(words[3], _TYPES[words[2]], _TYPES[words[1]])
    raise PlannercheckError(f"its PLY header has a property {shortened(' '.join(words))!r}")


def _words(
    content: bytes, body: int, order: str, elements: list[_Element], exactly: bool
) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Of a text, the indices of vertices in each element; raises for rows that are not whole."""
    lines = [line for line in content[body:].decode("latin-1").splitlines() if line.strip()]
    at = 0
    for element in elements:
        found = []
        for line in lines[at : at + element.rows]:
            found += _indices_of_line(line, element)
        if len(lines) - at < element.rows:
            raise _cut_short(element)
        at += element.rows
        yield element.name, np.array(found, dtype=np.float64)
    if exactly and at < len(lines):
        raise PlannercheckError(f"{len(lines) - at} lines follow the rows that its header says")


def _indices_of_line(line: str, element: _Element) -> list[float]:
    """The indices of vertices in a row of text."""
    try:
        values, found = [float(word) for word in line.split()], []
        for each in element.properties:
            length = 1 if each.count is None else int(values.pop(0))
            if (each.count is not None and length < _least(element, each)) or length > len(values):
                raise ValueError(line)
            if each.name in _INDICES:
                found += values[:length]
            del values[:length]
    except (ValueError, IndexError, OverflowError):
        raise PlannercheckError(f"element {element.name!r} has a row {shortened(line)!r}") from None
    if values:
        raise PlannercheckError(f"element {element.name!r} has a row with {len(values)} numbers more than it says")
    return found


def _numbers(
    content: bytes, at: int, order: str, elements: list[_Element], exactly: bool
) -> Iterator[tuple[str, NDArray[np.int64]]]:
    """The same of bytes. Rows of one length, as those of triangles are, are read at once."""
    for element in elements:
        if not element.properties:  # its rows take no bytes, however many they are
            continue
        lengths = _lengths(content, at, order, element)
        row = _row_type(order, element, lengths)
        if element.rows and row.itemsize and at + element.rows * row.itemsize <= len(content):
            table = np.frombuffer(content, row, element.rows, at)
            if all((table[f"count {k}"] == length).all() for k, length in lengths.items()):
                at += element.rows * row.itemsize
                named = [table[each.name] for each in element.properties if each.name in _INDICES]
                yield element.name, np.concatenate([part.ravel() for part in named] or [np.zeros(0)]).astype(np.int64)
                continue
        found: list[NDArray[np.int64]] = []
        for _ in range(element.rows):
            row = _row_type(order, element, _lengths(content, at, order, element))
            if at + row.itemsize > len(content):
                raise _cut_short(element)
            values = np.frombuffer(content, row, 1, at)
            named = [values[each.name].ravel() for each in element.properties if each.name in _INDICES]
            found += [part.astype(np.int64) for part in named]
            at += row.itemsize
        yield element.name, np.concatenate([*found, np.zeros(0, dtype=np.int64)])
    if exactly and at < len(content):
        raise PlannercheckError(f"{len(content) - at} bytes follow the rows that its header says")


def _lengths(content: bytes, at: int, order: str, element: _Element) -> dict[int, int]:
    """How long the lists of the row that begins there are, by the property's number."""
    lengths: dict[int, int] = {}
    for k, each in enumerate(element.properties):
        if each.count is None:
            at += np.dtype(each.kind).itemsize
            continue
        count = np.dtype(order + each.count)
        if at + count.itemsize > len(content):
            if element.rows:
                raise _cut_short(element)
            return {}
        lengths[k] = int(np.frombuffer(content, count, 1, at)[0])
        at += count.itemsize + lengths[k] * np.dtype(each.kind).itemsize
        if not _least(element, each) <= lengths[k] <= len(content):
            raise PlannercheckError(f"element {element.name!r} has a list of {lengths[k]} numbers")
    return lengths


def _least(element: _Element, each: _Property) -> int:
    """Numbers that a list must have: a face needs three corners; a place of a scan has a vertex or none."""
    return _FEWEST_CORNERS if each.name in _INDICES and element.name != _SCAN else 0


def _row_type(order: str, element: _Element, lengths: dict[int, int]) -> np.dtype[np.void]:
    fields: list[tuple[str, str, tuple[int, ...]]] = []
    for k, each in enumerate(element.properties):
        if each.count is not None:
            fields.append((f"count {k}", order + each.count, ()))
        fields.append((each.name, order + each.kind, (lengths.get(k, 0),) if each.count is not None else ()))
    return np.dtype(fields)


def _cut_short(element: _Element) -> PlannercheckError:
    return PlannercheckError(f"is cut short: element {shortened(element.name)!r} must have {element.rows} rows")
