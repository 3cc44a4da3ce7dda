"""Wavefront OBJ files: their polygons.

In: the content. Out: one object for each `o` statement with faces; in a file without `o`, one for each name of `g`, and
one without a name for faces that belong to neither. Materials, normals and texture places do not matter here; points
and lines are no surface. Free-form surfaces, and statements that the format does not have, are refused.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from plannercheck.bodies.mesh_objects import RawObject, check_indices
from plannercheck.bodies.polygons import triangles_of_polygons
from plannercheck.bodies.text_numbers import first_bad, floats_of, integers_of, shown, word_counts
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.errors import PlannercheckError

# Statements that say nothing about a polygon's place: attributes, names, materials, points and lines.
_PASSED_OVER = frozenset(
    b"vn vt vp s mg usemtl mtllib usemap maplib p l bevel c_interp d_interp lod shadow_obj trace_obj".split()
)
_SURFACES = frozenset(
    b"surf curv curv2 cstype deg bmat step parm trim hole scrv sp end con bzp bsp cdc cdp res".split()
)

_JOINED = re.compile(rb"(?:[^\n]*\\\n)+[^\n]*")
_COMMENT = re.compile(rb"#[^\n]*")
_HIDDEN = re.compile(rb"#[^\n]*\\\n")
_ATTRIBUTES = re.compile(rb"/[0-9/-]*")  # of a corner: what follows its vertex
_LEAST = 2  # corners of a face; one with two, which some programs write, is a triangle of no area

# Numbers after `v`: x y z, with a weight, with a colour, with both.
_COLUMNS = (3, 4, 6, 7)


@dataclass
class _Statements:
    """What a file says, in its order."""

    vertices: list[bytes] = field(default_factory=list)
    vertex_lines: list[int] = field(default_factory=list)
    faces: list[bytes] = field(default_factory=list)
    face_lines: list[int] = field(default_factory=list)
    before: list[int] = field(default_factory=list)  # vertices before each face
    names: list[tuple[int, bytes, bytes]] = field(default_factory=list)  # faces before it, "o" or "g", the name


def objects_of_obj(content: bytes) -> list[RawObject]:
    """The objects of an OBJ file.

    Raises:
        PlannercheckError: If a statement is unknown, or a vertex or a face is not what the format demands.
    """
    said = _statements(content)
    points = _points(said)
    counts, corners = _faces(said, len(points))
    triangles = triangles_of_polygons(points, counts, corners)
    ends = np.concatenate([[0], np.cumsum(counts - 2)])
    return [
        RawObject.of(name, points, np.concatenate([triangles[ends[a] : ends[b]] for a, b in parts]))
        for name, parts in _parts(said)
    ]


def _statements(content: bytes) -> _Statements:
    content = content.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if b"\\\n" in content:
        hidden = _HIDDEN.search(content)
        if hidden is not None:
            number = content.count(b"\n", 0, hidden.start()) + 1
            raise PlannercheckError(f"line {number}: a comment ends in a backslash, which would hide the next line")
        content = _JOINED.sub(_joined, content)
    if b"#" in content:
        content = _COMMENT.sub(b"", content)
    said = _Statements()
    lines: list[bytes] = content.split(b"\n")
    for number, line in enumerate(lines, 1):
        words = line.split(None, 1)
        if not words:
            continue
        key, rest = words[0], words[1] if len(words) > 1 else b""
        if key == b"v":
            said.vertices.append(rest)
            said.vertex_lines.append(number)
        elif key in (b"f", b"fo"):  # the latter is an older word for it
            said.faces.append(rest)
            said.face_lines.append(number)
            said.before.append(len(said.vertices))
        elif key in (b"o", b"g"):
            said.names.append((len(said.faces), key, rest.strip()))
        elif key in _SURFACES:
            raise PlannercheckError(f"line {number}: {shown(key)} belongs to free-form surfaces, which are not read")
        elif key not in _PASSED_OVER:
            raise PlannercheckError(f"line {number}: an OBJ file has no statement {shown(line)}")
    return said


def _joined(lines: re.Match[bytes]) -> bytes:
    """One line of several that end in backslashes, and empty lines, so that lines keep their numbers."""
    return lines[0].replace(b"\\\n", b" ") + b"\n" * lines[0].count(b"\\\n")


def _points(said: _Statements) -> Floats:
    """The vertices (n, 3)."""
    columns = word_counts(said.vertices)
    numbers = floats_of(b"\n".join(said.vertices))
    if numbers is None:
        k = max(first_bad(said.vertices), 0)
        raise PlannercheckError(
            f"line {said.vertex_lines[k]}: vertex {shown(said.vertices[k])} is no list of finite numbers"
        )
    wrong = ~np.isin(columns, _COLUMNS)
    if wrong.any():
        k = int(np.argmax(wrong))
        raise PlannercheckError(
            f"line {said.vertex_lines[k]}: a vertex must have 3 numbers, and may have a weight (1) and a colour (3)"
            f" after them, not {shown(said.vertices[k])}"
        )
    starts = np.cumsum(columns) - columns
    weighted = np.flatnonzero((columns == 4) | (columns == 7))
    unequal = numbers[starts[weighted] + 3] != 1
    if unequal.any():
        k = int(weighted[int(np.argmax(unequal))])
        raise PlannercheckError(f"line {said.vertex_lines[k]}: a vertex of a polygon must have weight 1, or none")
    return np.asarray(numbers[starts[:, None] + np.arange(3)])


def _faces(said: _Statements, points: int) -> tuple[Ints64, Ints64]:
    """How many corners each face has, and its vertices, from 0 on."""
    counts = word_counts(said.faces)
    text = b"\n".join(said.faces)
    corners = integers_of(_ATTRIBUTES.sub(b"", text) if b"/" in text else text)
    if corners is None or len(corners) != counts.sum() or (counts < _LEAST).any():
        raise _bad_face(said)
    before = np.repeat(np.array(said.before, dtype=np.int64), counts)
    relative = corners < 0
    corners = np.where(relative, before + corners, corners - 1)
    wrong = (corners < 0) | (corners >= points)
    if wrong.any():
        which = int(np.argmax(wrong))
        line = said.face_lines[int(np.searchsorted(np.cumsum(counts), which, side="right"))]
        check_indices(corners[which : which + 1], points, f"line {line}: a face", 1)
    twice = np.ones(len(corners), dtype=np.int64)
    twice[np.cumsum(counts)[counts == _LEAST] - 1] = 2
    return np.maximum(counts, 3), np.repeat(corners, twice)


def _bad_face(said: _Statements) -> PlannercheckError:
    for line, rest in zip(said.face_lines, said.faces, strict=True):
        corners = integers_of(_ATTRIBUTES.sub(b"", rest))
        if corners is None or len(corners) != len(rest.split()) or len(corners) < _LEAST:
            return PlannercheckError(
                f"line {line}: a face must have corners v, v/vt, v//vn or v/vt/vn, three or more, not {shown(rest)}"
            )
    return PlannercheckError("has faces with corners that are run together")


def _parts(said: _Statements) -> list[tuple[str, list[tuple[int, int]]]]:
    """Each object's name, and its runs of faces; objects with the same `g` are one, with the same `o` they are not."""
    key = b"o" if any(kind == b"o" for _, kind, _ in said.names) else b"g"
    starts = [(0, b""), *((at, name) for at, kind, name in said.names if kind == key)]
    ends = [at for at, _ in starts[1:]] + [len(said.faces)]
    runs = [(name.decode("utf-8", errors="replace"), at, end) for (at, name), end in zip(starts, ends, strict=True)]
    found: list[tuple[str, list[tuple[int, int]]]] = []
    known: dict[str, list[tuple[int, int]]] = {}
    for name, at, end in runs:
        if at == end:
            continue
        if key == b"g" and name in known:
            known[name].append((at, end))
            continue
        known[name] = [(at, end)]
        found.append((name, known[name]))
    return found
