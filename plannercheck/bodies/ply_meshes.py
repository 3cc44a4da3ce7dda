"""PLY files as meshes: text and bytes of either order.

In: the content. Out: one object. Faces are lists `vertex_indices` or `vertex_index` of the element `face`; the element
`tristrips`, whose strips end at -1, is read as well. Other elements are left out. In texts, a row is a line that is not
blank, and places are read as doubles, whatever the type of the property.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.mesh_objects import NO_FACES, RawObject, check_indices, strip_triangles
from plannercheck.bodies.ply_headers import PlyElement, PlyProperty, header_of_ply
from plannercheck.bodies.polygons import triangles_of_polygons
from plannercheck.bodies.text_numbers import filled_lines, first_bad, floats_of, pieces_of, shown, word_counts
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.errors import PlannercheckError, shortened

_INDICES = ("vertex_indices", "vertex_index")
_AXES = ("x", "y", "z")
_WITH_FACES = ("face", "tristrips")
_LEAST = 3  # corners of a face
_SCAN = "range_grid"  # which vertex each place of a scan has: no faces
_LARGEST = 2.0**53  # whole numbers below it are exact doubles


@dataclass(frozen=True, eq=False)
class _Lists:
    """One list for each row: its length (n,), and all items (sum of lengths,)."""

    counts: Ints64
    items: Ints64


def objects_of_ply(content: bytes) -> list[RawObject]:
    """The object of a PLY file.

    Raises:
        PlannercheckError: If its rows are not those that its header says, or name vertices that it does not have.
    """
    order, elements, body = header_of_ply(content)
    names = [element.name for element in elements]
    if "vertex" not in names or not any(name in names for name in _WITH_FACES):
        raise PlannercheckError(NO_FACES if "vertex" in names else "a PLY file needs one element 'vertex'")
    vertex = elements[names.index("vertex")]
    if not {*_AXES} <= {each.name for each in vertex.properties if not each.count}:
        raise PlannercheckError("a PLY file needs one element 'vertex' with x, y and z")
    for element in elements:
        if element.name in _WITH_FACES:
            _list_of(element)
        elif element.name != _SCAN and any(each.name in _INDICES for each in element.properties):
            raise PlannercheckError(f"element {shortened(element.name)!r} has faces: its name must be 'face'")
    points, lists = (_of_bytes if order else _of_text)(content, order, elements, body)
    found = [np.zeros((0, 3), dtype=np.int64)]
    for name, each in lists.items():
        found += _triangles(name, each, points)
    return [RawObject.of("", points, np.concatenate(found))]


def _list_of(element: PlyElement) -> PlyProperty:
    """The list of an element's vertices."""
    found = [each for each in element.properties if each.name in _INDICES]
    if len(found) != 1 or not found[0].count:
        raise PlannercheckError(f"element {element.name!r} must have one list {' or '.join(_INDICES)}")
    for each in element.properties:
        if each.count is not None and each.count[0] == "f":
            raise PlannercheckError(f"list {each.name!r} must have its length in a type of whole numbers")
    return found[0]


def _triangles(name: str, lists: _Lists, points: Floats) -> list[Ints64]:
    if name == "face":
        if (lists.counts < _LEAST).any():
            row = int(np.argmax(lists.counts < _LEAST))
            raise PlannercheckError(f"face {row} has {lists.counts[row]} corners, but must have three or more")
        check_indices(lists.items, len(points), "element 'face'")
        return [triangles_of_polygons(points, lists.counts, lists.items)]
    found = []
    for strips_of_row in np.split(lists.items, np.cumsum(lists.counts)[:-1]):
        strips = np.split(strips_of_row, np.flatnonzero(strips_of_row == -1))
        for strip in (part[part != -1] for part in strips):
            check_indices(strip, len(points), f"element {name!r}")
            if 0 < len(strip) < _LEAST:
                raise PlannercheckError(f"element {name!r} has a strip of {len(strip)} vertices; three are the fewest")
            if len(strip):
                found.append(strip_triangles(strip))
    return found


def _of_text(content: bytes, order: str, elements: list[PlyElement], body: int) -> tuple[Floats, dict[str, _Lists]]:
    lines, numbers = filled_lines(content[body:], content.count(b"\n", 0, body) + 1)
    rows = sum(element.rows for element in elements)
    if len(lines) != rows:
        raise PlannercheckError(f"has {len(lines)} rows, but its header says {rows}: it is cut short, or has more")
    points, lists, at = np.zeros((0, 3)), {}, 0
    for element in elements:
        these = slice(at, at + element.rows)
        at += element.rows
        if element.name == "vertex":
            points = _points_of_lines(element, lines[these], numbers[these])
        elif element.name in _WITH_FACES:
            lists[element.name] = _lists_of_lines(element, lines[these], numbers[these])
    return points, lists


def _points_of_lines(element: PlyElement, lines: list[bytes], numbers: list[int]) -> Floats:
    if any(each.count for each in element.properties):
        raise PlannercheckError("element 'vertex' must have no lists")
    count, counts = len(element.properties), word_counts(lines)
    if (counts != count).any():
        row = int(np.argmax(counts != count))
        raise PlannercheckError(f"line {numbers[row]}: a vertex must have {count} numbers, not {counts[row]}")
    names = [each.name for each in element.properties]
    columns = [names.index(axis) for axis in _AXES]
    values = floats_of(b"\n".join(lines))
    if values is None:  # perhaps only a normal is none
        values = floats_of(b"\n".join([b" ".join([words[k] for k in columns]) for words in map(bytes.split, lines)]))
        count, columns = len(_AXES), list(range(len(_AXES)))
    if values is None:
        row = max(first_bad(lines), 0)
        raise PlannercheckError(f"line {numbers[row]}: vertex {shown(lines[row])} is not finite in x, y and z")
    return values.reshape(-1, count)[:, columns]


def _lists_of_lines(element: PlyElement, lines: list[bytes], numbers: list[int]) -> _Lists:
    """The lists of vertices, property by property, all rows at once."""
    words = word_counts(lines)
    values = floats_of(b"\n".join(lines))
    if values is None:
        raise _bad_row(element, lines, numbers, max(first_bad(lines), 0))
    ends = np.cumsum(words)
    at = ends - words
    wanted, found = _list_of(element), _Lists(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64))
    for each in element.properties:
        lengths = np.ones(len(lines), dtype=np.int64)
        if each.count is not None:
            _check_rows(at < ends, element, lines, numbers)
            said = values[at]
            _check_rows((said == np.floor(said)) & (said >= 0) & (said < ends - at), element, lines, numbers)
            lengths, at = said.astype(np.int64), at + 1
        _check_rows(at + lengths <= ends, element, lines, numbers)
        if each is wanted:
            items = pieces_of(values, at, lengths)
            whole = (items == np.floor(items)) & (np.abs(items) < _LARGEST)
            row = np.repeat(np.arange(len(lines)), lengths)
            _check_rows(np.bincount(row[~whole], minlength=len(lines)) == 0, element, lines, numbers)
            found = _Lists(lengths, items.astype(np.int64))
        at = at + lengths
    _check_rows(at == ends, element, lines, numbers)
    return found


def _check_rows(right: NDArray[np.bool_], element: PlyElement, lines: list[bytes], numbers: list[int]) -> None:
    if not right.all():
        raise _bad_row(element, lines, numbers, int(np.argmin(right)))


def _bad_row(element: PlyElement, lines: list[bytes], numbers: list[int], row: int) -> PlannercheckError:
    names = " ".join(f"count {each.name}" if each.count else each.name for each in element.properties)
    return PlannercheckError(
        f"line {numbers[row]}: element {element.name!r} must be {names!r} with whole indices, not {shown(lines[row])}"
    )


def _of_bytes(content: bytes, order: str, elements: list[PlyElement], body: int) -> tuple[Floats, dict[str, _Lists]]:
    points, lists, at = np.zeros((0, 3)), {}, body
    for element in elements:
        starts, counts, at = _layout(content, at, order, element)
        if element.name == "vertex":
            columns = [_scalars(content, order, starts[axis], element, axis) for axis in _AXES]
            with np.errstate(invalid="ignore"):  # of signalling NaNs
                points = np.column_stack([column.astype(np.float64) for column in columns])
            if not np.isfinite(points).all():
                row = int(np.argmin(np.isfinite(points).all(axis=1)))
                raise PlannercheckError(f"vertex {row} is not finite")
        elif element.name in _WITH_FACES:
            wanted = _list_of(element)
            lists[element.name] = _items(content, order, starts[wanted.name], counts[wanted.name], wanted, element)
    if at != len(content):
        raise PlannercheckError(f"{len(content) - at} bytes follow the rows that its header says")
    return points, lists


def _layout(
    content: bytes, at: int, order: str, element: PlyElement
) -> tuple[dict[str, Ints64], dict[str, Ints64], int]:
    """Where each property's numbers begin in each row, how long its lists are, and where the element ends."""
    rows = element.rows
    if not element.properties or not rows:  # takes no bytes, however many rows it has
        nothing = {each.name: np.zeros(0, dtype=np.int64) for each in element.properties}
        if element.name in ("vertex", *_WITH_FACES) and rows:
            raise PlannercheckError(f"element {element.name!r} has no properties")
        return nothing, nothing, at
    if rows > len(content):
        raise _cut_short(element)
    # Most files have lists of one length, like those of triangles: rows are alike, and one look tells.
    starts, counts, size = _row(content, at, order, element)
    if at + size * rows <= len(content):
        steps = np.arange(rows, dtype=np.int64) * size
        alike = all(
            (_counts_at(content, order, each, starts, steps) == counts[each.name]).all()
            for each in element.properties
            if each.count is not None
        )
        if alike:
            return (
                {name: start + steps for name, start in starts.items()},
                {name: np.full(rows, count) for name, count in counts.items()},
                at + size * rows,
            )
    found = []
    for _ in range(rows):
        found.append(_row(content, at, order, element))
        at += found[-1][2]
    return (
        {name: np.array([row[0][name] for row in found], dtype=np.int64) for name in starts},
        {name: np.array([row[1][name] for row in found], dtype=np.int64) for name in counts},
        at,
    )


def _counts_at(
    content: bytes, order: str, each: PlyProperty, starts: dict[str, int], steps: Ints64
) -> NDArray[np.generic]:
    """The lengths of a list in rows of one size: each stands before its list."""
    kind = each.count or each.kind
    return _gathered(content, order, kind, starts[each.name] + steps - int(kind[1]))


def _row(content: bytes, at: int, order: str, element: PlyElement) -> tuple[dict[str, int], dict[str, int], int]:
    """The same of one row, and its bytes."""
    starts, counts, begin = {}, {}, at
    for each in element.properties:
        length = 1
        if each.count is not None:
            size = int(each.count[1])
            word = content[at : at + size]
            length = int.from_bytes(word, "big" if order == ">" else "little", signed=each.count[0] == "i")
            if each.count[0] == "f" or len(word) < size:
                raise _cut_short(element) if len(word) < size else PlannercheckError("lists need whole lengths")
            if length < 0:
                raise PlannercheckError(f"element {element.name!r} has a list of {length} numbers")
            at += size
            counts[each.name] = length
        starts[each.name] = at
        at += length * int(each.kind[1])
        if at > len(content):
            raise _cut_short(element)
    return starts, counts, at - begin


def _scalars(content: bytes, order: str, starts: Ints64, element: PlyElement, name: str) -> NDArray[np.generic]:
    each = next(each for each in element.properties if each.name == name)
    return _gathered(content, order, each.kind, starts)


def _items(
    content: bytes, order: str, starts: Ints64, counts: Ints64, wanted: PlyProperty, element: PlyElement
) -> _Lists:
    if wanted.kind[0] == "f":
        raise PlannercheckError(f"element {element.name!r} must have indices of a type of whole numbers")
    steps = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    places = np.repeat(starts, counts) + steps * np.dtype(wanted.kind).itemsize
    return _Lists(counts, _gathered(content, order, wanted.kind, places).astype(np.int64))


def _gathered(content: bytes, order: str, kind: str, places: Ints64) -> NDArray[np.generic]:
    """The numbers that begin at some places."""
    one = np.dtype(order + kind)
    octets = np.frombuffer(content, dtype=np.uint8)
    return np.asarray(octets[places[:, None] + np.arange(one.itemsize)].reshape(-1).view(one))


def _cut_short(element: PlyElement) -> PlannercheckError:
    return PlannercheckError(f"is cut short: element {element.name!r} must have {element.rows} rows")
