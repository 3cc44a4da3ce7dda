"""OFF files, as text: OFF, and with colours, normals or texture places at the vertices (COFF, NOFF, STOFF).

In: the content. Out: one object. A row is a line; comments (from "#" on) and blank lines may stand anywhere.
"""

from __future__ import annotations

import re

import numpy as np

from plannercheck.bodies.mesh_objects import RawObject
from plannercheck.bodies.polygons import triangles_of_polygons
from plannercheck.bodies.text_numbers import (
    filled_lines,
    first_bad,
    floats_of,
    integers_of,
    pieces_of,
    shown,
    word_counts,
)
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.errors import PlannercheckError

_KEY = re.compile(rb"(ST)?(C)?(N)?OFF$")
_COMMENT = re.compile(rb"#[^\r\n]*")
_COLOURS = (0, 1, 3, 4)  # numbers of a face's colour: none, an index, or components
_LEAST = 3  # corners of a face


def objects_of_off(content: bytes) -> list[RawObject]:
    """The object of an OFF file.

    Raises:
        PlannercheckError: If its rows are not those that its counts say.
    """
    lines, numbers = filled_lines(_COMMENT.sub(b"", content))
    words = lines[0].split() if lines else []
    key = _KEY.match(words[0]) if words else None
    if key is None:
        raise PlannercheckError("is no OFF file: it must begin with OFF, COFF, NOFF, STOFF or a mix of these")
    begin = 1 if len(words) > 1 else 2  # the counts may stand on the first line
    said = b" ".join(words[1:]) if begin == 1 else b"".join(lines[1:2])
    counts = integers_of(said)
    if counts is None or len(counts) not in (2, 3) or (counts < 0).any():
        raise PlannercheckError(f"there must be the counts of vertices, faces and edges, not {shown(said)}")
    vertices, faces = int(counts[0]), int(counts[1])
    if len(lines) - begin != vertices + faces:
        raise PlannercheckError(f"has {len(lines) - begin} rows, but must have {vertices} vertices and {faces} faces")
    more = [2 * bool(key[1]) + 3 * bool(key[3]) + colour for colour in ((3, 4) if key[2] else (0,))]
    split = begin + vertices
    points = _points(lines[begin:split], numbers[begin:split], more)
    lengths, corners = _faces(lines[split:], numbers[split:], vertices)
    return [RawObject.of("", points, triangles_of_polygons(points, lengths, corners))]


def _points(lines: list[bytes], numbers: list[int], more: list[int]) -> Floats:
    """The places (n, 3) of vertices with one of some counts of further numbers."""
    counts = word_counts(lines)
    wrong = ~np.isin(counts - 3, more)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise PlannercheckError(f"line {numbers[row]}: a vertex must have {3 + more[0]} numbers, not {counts[row]}")
    values = floats_of(b"\n".join(lines))
    if values is None:
        row = max(first_bad(lines), 0)
        raise PlannercheckError(f"line {numbers[row]}: vertex {shown(lines[row])} is no list of finite numbers")
    return pieces_of(values, np.cumsum(counts) - counts, np.full(len(counts), 3)).reshape(-1, 3)


def _faces(lines: list[bytes], numbers: list[int], vertices: int) -> tuple[Ints64, Ints64]:
    """How many corners each face has, and the corners, one face after the other."""
    counts = word_counts(lines)
    values = floats_of(b"\n".join(lines))  # a face's colour may have a point
    if values is None:
        row = max(first_bad(lines), 0)
        raise PlannercheckError(f"line {numbers[row]}: face {shown(lines[row])} is no list of numbers")
    starts = np.cumsum(counts) - counts
    lengths = values[starts]
    wrong = (lengths < _LEAST) | ~np.isin(counts - 1 - lengths, _COLOURS)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise PlannercheckError(f"line {numbers[row]}: face {shown(lines[row])} must be a count, and so many corners")
    lengths = lengths.astype(np.int64)
    corners = pieces_of(values, starts + 1, lengths)
    wrong = (corners != np.floor(corners)) | (corners < 0) | (corners >= vertices)
    if wrong.any():
        row = int(np.searchsorted(np.cumsum(lengths), int(np.argmax(wrong)), side="right"))
        raise PlannercheckError(
            f"line {numbers[row]}: face {shown(lines[row])} must name vertices from 0 to {vertices - 1}"
        )
    return lengths, corners.astype(np.int64)
