"""OFF files, as text: OFF, and with colours, normals or texture places at the vertices (COFF, NOFF, STOFF).

In: the content. Out: one object. A row is a line; comments (from "#" on) and blank lines may stand anywhere.
"""

from __future__ import annotations

import re

import numpy as np

from plannercheck.bodies.mesh_objects import RawObject, check_indices
from plannercheck.bodies.polygons import triangles_of_polygons
from plannercheck.bodies.text_numbers import floats_of, integers_of, shown
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
    lines = [(k + 1, line.split()) for k, line in enumerate(_COMMENT.sub(b"", content).splitlines()) if line.strip()]
    key = _KEY.match(lines[0][1][0]) if lines else None
    if key is None:
        raise PlannercheckError("is no OFF file: it must begin with OFF, COFF, NOFF, STOFF or a mix of these")
    lines[0] = (lines[0][0], lines[0][1][1:])
    counts_line, counts_words = lines[0] if lines[0][1] else lines[1] if len(lines) > 1 else (0, [])
    counts = integers_of(b" ".join(counts_words))
    if counts is None or len(counts) not in (2, 3) or (counts < 0).any():
        raise PlannercheckError(f"line {counts_line}: there must be the counts of vertices, faces and edges")
    rows = lines[1:] if lines[0][1] else lines[2:]
    vertices, faces = int(counts[0]), int(counts[1])
    if len(rows) != vertices + faces:
        raise PlannercheckError(f"has {len(rows)} rows, but must have {vertices} vertices and {faces} faces")
    points = _points(rows[:vertices], [2 * bool(key[1]) + 3 * bool(key[3]) + c for c in ((3, 4) if key[2] else (0,))])
    counts, corners = _faces(rows[vertices:], vertices)
    return [RawObject.of("", points, triangles_of_polygons(points, counts, corners))]


def _points(rows: list[tuple[int, list[bytes]]], more: list[int]) -> Floats:
    """The places (n, 3) of vertices with one of some counts of further numbers."""
    for line, words in rows:
        if len(words) - 3 not in more:
            raise PlannercheckError(f"line {line}: a vertex must have {3 + more[0]} numbers, not {len(words)}")
    points = floats_of(b" ".join([word for _, words in rows for word in words[:3]]))
    if points is None:
        line, words = next(row for row in rows if floats_of(b" ".join(row[1][:3])) is None)
        raise PlannercheckError(f"line {line}: vertex {shown(b' '.join(words))} is not three finite numbers")
    return points.reshape(-1, 3)


def _faces(rows: list[tuple[int, list[bytes]]], vertices: int) -> tuple[Ints64, Ints64]:
    """How many corners each face has, and the corners, one face after the other."""
    counts: list[int] = []
    corners: list[bytes] = []
    for line, words in rows:
        count = int(words[0]) if words[0].isdigit() and len(words[0]) < 10 else -1
        if count < _LEAST or len(words) - 1 - count not in _COLOURS:
            raise PlannercheckError(f"line {line}: face {shown(b' '.join(words))} must be a count and so many corners")
        counts.append(count)
        corners += words[1 : count + 1]
    indices = integers_of(b" ".join(corners))
    if indices is None:
        line = next(n for n, w in rows if integers_of(b" ".join(w[1 : int(w[0]) + 1])) is None)
        raise PlannercheckError(f"line {line}: corners of a face must be whole numbers")
    if len(indices) and not (indices.min() >= 0 and indices.max() < vertices):
        which = int(np.argmax((indices < 0) | (indices >= vertices)))
        row = int(np.searchsorted(np.cumsum(counts), which, side="right"))
        check_indices(indices[which : which + 1], vertices, f"line {rows[row][0]}: a face")
    return np.array(counts, dtype=np.int64), indices
