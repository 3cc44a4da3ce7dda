"""STL files, binary and text.

In: the content. Out: one object for each solid that has facets. Normals are not read: the order of corners says as
much. A file is binary if its length is the one that its count of facets demands; else it must begin with "solid".
"""

from __future__ import annotations

import re
from collections import defaultdict
from itertools import count

import numpy as np

from plannercheck.bodies.mesh_objects import RawObject
from plannercheck.bodies.text_numbers import first_bad, floats_of_words, shown
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import distinct_rows
from plannercheck.common.errors import PlannercheckError

_HEADER = 84  # bytes before the first facet: a text of 80, and the count
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])

# A facet's words by place; the others are numbers.
_WORDS = {0: b"facet", 1: b"normal", 5: b"outer", 6: b"loop", 19: b"endloop", 20: b"endfacet"}
_WORDS |= dict.fromkeys((7, 11, 15), b"vertex")
_NUMBERS = (8, 9, 10, 12, 13, 14, 16, 17, 18)
_LINES = {1: b"outer loop", 5: b"endloop", 6: b"endfacet"}  # of the seven that a facet mostly takes
_AFTER = b" ; "  # a corner: a word that is no number, so that none passes from one corner to the next
_LENGTH = 21  # words of a facet
_PIECE = 1 << 22  # bytes that are split into words at once

_BEGIN = re.compile(rb"\s*solid(?:[ \t]+([^\r\n]*))?[ \t]*(?:\r\n|\r|\n|\Z)", re.IGNORECASE)
_END = re.compile(rb"[ \t]*endsolid\b[^\n]*$", re.MULTILINE)
_REST = re.compile(rb"\s*\Z")


def objects_of_stl(content: bytes) -> list[RawObject]:
    """The solids of an STL file.

    Raises:
        PlannercheckError: If it is cut short, or has anything but facets of three finite corners.
    """
    facets = int.from_bytes(content[_HEADER - 4 : _HEADER], "little") if len(content) >= _HEADER else -1
    length = _HEADER + facets * _FACET.itemsize
    if facets >= 0 and len(content) == length:
        return [_merged("", _binary(content).reshape(-1, 3), np.arange(3 * facets).reshape(-1, 3))]
    if _BEGIN.match(content):
        return _texts(b"\n".join(content.splitlines()) if b"\r" in content else content)
    if facets < 0:
        raise PlannercheckError("is no STL file: it neither begins with 'solid' nor has 84 bytes of a header")
    raise PlannercheckError(
        f"its header says {facets} facets, which take {length} bytes, but it has {len(content)}: it is cut short, or"
        " has more after them"
    )


def _binary(content: bytes) -> Floats:
    corners = np.frombuffer(content, _FACET, offset=_HEADER)["corners"]
    finite = np.isfinite(corners).all(axis=(1, 2))
    if not finite.all():
        raise PlannercheckError(f"facet {int(np.argmin(finite)) + 1} has a corner that is not finite")
    return corners.astype(np.float64)


def _merged(name: str, points: Floats, triangles: Ints64) -> RawObject:
    """An object whose equal points become one."""
    distinct, places = distinct_rows(points)
    return RawObject(name, distinct, places[triangles])


def _texts(content: bytes) -> list[RawObject]:
    found, at, lower = [], 0, content.lower()
    while _REST.match(content, at) is None:
        begin = _BEGIN.match(content, at)
        if begin is None:
            raise PlannercheckError(f"line {_line(content, at)}: there must be 'solid', not {_next(content, at)}")
        end = _end(lower, begin.end())
        if end is None:
            raise PlannercheckError(f"is cut short: the solid of line {_line(content, at)} has no 'endsolid'")
        name = (begin.group(1) or b"").decode("utf-8", errors="replace").strip()
        if "endfacet" in name.lower():
            raise PlannercheckError(f"line {_line(content, at)}: facets must begin on a line after that of 'solid'")
        points, triangles = _facets(lower, content, begin.end(), end.start())
        if len(triangles):
            found.append(_merged(name, points, triangles))
        at = end.end()
    return found


def _end(lower: bytes, begin: int) -> re.Match[bytes] | None:
    """The first line from a place on that is an end of a solid."""
    at = lower.find(b"endsolid", begin)
    while at >= 0:
        line = _END.match(lower, lower.rfind(b"\n", 0, at) + 1)
        if line is not None and line.start() >= begin:
            return line
        at = lower.find(b"endsolid", at + 1)
    return None


def _facets(lower: bytes, content: bytes, begin: int, end: int) -> tuple[Floats, Ints64]:
    """Points (k, 3) and triangles (m, 3) of the facets between two places, read in pieces to spare memory."""
    points, triangles, known, at = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)], 0, begin
    while at < end:
        after = lower.find(_WORDS[20], at + _PIECE, end)
        next_at = end if after < 0 else after + len(_WORDS[20])
        corners, facets = _corners(lower[at:next_at], content, begin)
        points.append(corners)
        triangles.append(facets + known)
        known, at = known + len(corners), next_at
    return np.concatenate(points), np.concatenate(triangles)


def _corners(piece: bytes, content: bytes, begin: int) -> tuple[Floats, Ints64]:
    """Points (k, 3) and triangles (m, 3) of facets."""
    found = _parsed(_corners_of_lines(piece))
    if found is None:  # facets on any lines, or wrong ones
        words = piece.split()
        found = _parsed(_corners_of_words(words, content, begin))
        if found is None:
            raise _bad_facet(content, begin, words)
    return found


def _parsed(corners: list[bytes] | None) -> tuple[Floats, Ints64] | None:
    """Points (k, 3) and triangles (m, 3) of the texts of corners; None if one is not 'vertex' and three numbers.

    Corners of equal text are one point: neighbouring facets share corners, so most corners need no parsing.
    """
    if corners is None:
        return None
    places: defaultdict[bytes, int] = defaultdict(count().__next__)
    triangles = np.fromiter(map(places.__getitem__, corners), np.int64, len(corners)).reshape(3, -1).T
    words = _AFTER.join([*places, b""]).split()
    vertices = words[::5]
    del words[4::5], words[::4]
    numbers = floats_of_words(words)
    if vertices != [_WORDS[7]] * len(places) or numbers is None or len(numbers) != 3 * len(places):
        return None
    return numbers.reshape(-1, 3), triangles


def _corners_of_lines(piece: bytes) -> list[bytes] | None:
    """The texts of first, second and third corners, if each facet takes seven lines, as programs write them."""
    lines = piece.strip().split(b"\n")
    heads = b" ".join(lines[::7]).split()
    usual = (
        len(heads) * 7 == len(lines) * 5
        and set(heads[::5]) == {_WORDS[0]}
        and set(heads[1::5]) == {_WORDS[1]}
        and all({found.strip() for found in set(lines[k::7])} == {line} for k, line in _LINES.items())
    )
    return lines[2::7] + lines[3::7] + lines[4::7] if usual else None


def _corners_of_words(words: list[bytes], content: bytes, begin: int) -> list[bytes]:
    """The same of facets given word by word, on any lines."""
    facets = -(-len(words) // _LENGTH)
    for place, word in _WORDS.items():
        if words[place::_LENGTH] != [word] * facets:
            raise _bad_facet(content, begin, words)
    return [b" ".join(c) for k in (7, 11, 15) for c in zip(*(words[k + n :: _LENGTH] for n in range(4)), strict=True)]


def _bad_facet(content: bytes, begin: int, words: list[bytes]) -> PlannercheckError:
    for number, at in enumerate(range(0, len(words), _LENGTH)):
        facet = words[at : at + _LENGTH]
        numbers = [facet[place] for place in _NUMBERS if place < len(facet)]
        whole = len(facet) == _LENGTH and all(facet[place] == word for place, word in _WORDS.items())
        if whole and first_bad(numbers) < 0:
            continue
        bad = shown(b" ".join(facet if not whole else [facet[_NUMBERS[first_bad(numbers)]]]))
        line = _line(content, begin)
        return PlannercheckError(
            f"facet {number + 1} of the solid that begins before line {line} must be 'facet normal', 'outer loop',"
            f" three times 'vertex' with three finite numbers, 'endloop', 'endfacet', not {bad}"
        )
    return PlannercheckError("has facets with numbers that are run together")


def _next(content: bytes, at: int) -> str:
    return shown(content[at : at + 300].strip().split(b"\n")[0])


def _line(content: bytes, at: int) -> int:
    while content[at : at + 1].isspace():
        at += 1
    return content.count(b"\n", 0, at) + 1
