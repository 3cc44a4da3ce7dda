"""Points of PLY files: clouds, or the vertices of meshes.

In: a path. Out: the points, or an error that names the fault: header, lengths and indices are checked, since a
truncated file would silently be a smaller cloud.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.ply_headers import PlyElement, PlyProperty, header_of_ply
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError, shortened

_INDICES = ("vertex_indices", "vertex_index")
_FEWEST_CORNERS = 3
# The element of organised clouds: which vertex each place of the scan has. PCL writes it.
_SCAN = "range_grid"
_AXES = ("x", "y", "z")


def points_of_ply(path: Path) -> Floats:
    """The points (n, 3) of a PLY file, in m, as the file has them: a cloud, or a mesh's vertices.

    Raises:
        PlannercheckError: If the file is not complete, has more than its header says, or vertices are not its first
            element. A text must end with an end of line, since its last number could be cut short otherwise.
    """
    content, order, elements, body = _checked(path)
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


def _checked(path: Path) -> tuple[bytes, str, list[PlyElement], int]:
    """The content of a complete file, its byte order ("" for text), its elements, and where they begin."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise PlannercheckError(f"can't be read: {error.strerror or error}") from None
    order, elements, body = header_of_ply(content)
    vertices = [element for element in elements if element.name == "vertex"]
    if len(vertices) != 1 or not {*_AXES} <= {each.name for each in vertices[0].properties if not each.count}:
        raise PlannercheckError("a PLY file needs one element 'vertex' with x, y and z")
    if order == "" and not content.endswith((b"\n", b"\r")):
        raise PlannercheckError("is cut short: its last line has no end; if it is whole, add an end of line")
    rows = (_words if order == "" else _numbers)(content, body, order, elements)
    for name, indices in rows:
        if len(indices) and not (indices.min() >= 0 and indices.max() < vertices[0].rows):
            raise PlannercheckError(f"element {name!r} names a vertex that is not among the {vertices[0].rows}")
    return content, order, elements, body


def _words(
    content: bytes, body: int, order: str, elements: list[PlyElement]
) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """The indices of vertices in each element of a text; raises for incomplete rows."""
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
    if at < len(lines):
        raise PlannercheckError(f"{len(lines) - at} lines follow the rows that its header says")


def _indices_of_line(line: str, element: PlyElement) -> list[float]:
    """The indices of vertices in a row of text."""
    try:
        if "_" in line:  # Python reads 1_000
            raise ValueError(line)
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
    content: bytes, at: int, order: str, elements: list[PlyElement]
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
    if at < len(content):
        raise PlannercheckError(f"{len(content) - at} bytes follow the rows that its header says")


def _lengths(content: bytes, at: int, order: str, element: PlyElement) -> dict[int, int]:
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


def _least(element: PlyElement, each: PlyProperty) -> int:
    """Numbers that a list must have: a face needs three corners; a place of a scan has a vertex or none."""
    return _FEWEST_CORNERS if each.name in _INDICES and element.name != _SCAN else 0


def _row_type(order: str, element: PlyElement, lengths: dict[int, int]) -> np.dtype[np.void]:
    fields: list[tuple[str, str, tuple[int, ...]]] = []
    for k, each in enumerate(element.properties):
        if each.count is not None:
            fields.append((f"count {k}", order + each.count, ()))
        fields.append((each.name, order + each.kind, (lengths.get(k, 0),) if each.count is not None else ()))
    return np.dtype(fields)


def _cut_short(element: PlyElement) -> PlannercheckError:
    return PlannercheckError(f"is cut short: element {shortened(element.name)!r} must have {element.rows} rows")
