"""STL files, binary and text.

In: the content. Out: one object for each solid that has facets. Normals are not read: the order of corners says as
much. A file is binary if its length is the one that its count of facets demands; else it must begin with "solid".
"""

from __future__ import annotations

import re

import numpy as np

from plannercheck.bodies.mesh_objects import RawObject
from plannercheck.bodies.text_numbers import first_bad, floats_of, shown
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct_rows
from plannercheck.common.errors import PlannercheckError

_HEADER = 84  # bytes before the first facet: a text of 80, and the count
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])

# A facet's words by place; the others are numbers.
_WORDS = {0: b"facet", 1: b"normal", 5: b"outer", 6: b"loop", 19: b"endloop", 20: b"endfacet"}
_WORDS |= dict.fromkeys((7, 11, 15), b"vertex")
_NUMBERS = (8, 9, 10, 12, 13, 14, 16, 17, 18)
_LENGTH = 21  # words of a facet
_PIECE = 1 << 22  # bytes that are split into words at once

_BEGIN = re.compile(rb"\s*solid(?:[ \t]+([^\r\n]*))?[ \t]*(?:\r\n|\r|\n|\Z)", re.IGNORECASE)
_END = re.compile(rb"^[ \t]*endsolid\b[^\r\n]*$", re.IGNORECASE | re.MULTILINE)
_REST = re.compile(rb"\s*\Z")


def objects_of_stl(content: bytes) -> list[RawObject]:
    """The solids of an STL file.

    Raises:
        PlannercheckError: If it is cut short, or has anything but facets of three finite corners.
    """
    facets = int.from_bytes(content[_HEADER - 4 : _HEADER], "little") if len(content) >= _HEADER else -1
    length = _HEADER + facets * _FACET.itemsize
    if facets >= 0 and len(content) == length:
        return [_soup("", _binary(content))]
    if _BEGIN.match(content):
        return _texts(content.replace(b"\r\n", b"\n").replace(b"\r", b"\n"))
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


def _soup(name: str, corners: Floats) -> RawObject:
    """An object of facets (m, 3, 3), whose equal corners are one point."""
    points, places = distinct_rows(corners.reshape(-1, 3))
    return RawObject(name, points, places.reshape(-1, 3))


def _texts(content: bytes) -> list[RawObject]:
    found, at = [], 0
    while _REST.match(content, at) is None:
        begin = _BEGIN.match(content, at)
        if begin is None:
            raise PlannercheckError(f"line {_line(content, at)}: there must be 'solid', not {_next(content, at)}")
        end = _END.search(content, begin.end())
        if end is None:
            raise PlannercheckError(f"is cut short: the solid of line {_line(content, at)} has no 'endsolid'")
        name = (begin.group(1) or b"").decode("utf-8", errors="replace").strip()
        if "endfacet" in name.lower():
            raise PlannercheckError(f"line {_line(content, at)}: facets must begin on a line after that of 'solid'")
        corners = _facets(content, begin.end(), end.start())
        if len(corners):
            found.append(_soup(name, corners))
        at = end.end()
    return found


def _facets(content: bytes, begin: int, end: int) -> Floats:
    """The corners (m, 3, 3) of the facets between two places, read in pieces to spare memory."""
    found, lower = [np.zeros((0, 3, 3))], content[begin:end].lower()
    at = 0
    while at < len(lower):
        after = lower.find(_WORDS[20], at + _PIECE)
        next_at = len(lower) if after < 0 else after + len(_WORDS[20])
        words = lower[at:next_at].split()
        found.append(_corners(words, content, begin))
        at = next_at
    return np.concatenate(found)


def _corners(words: list[bytes], content: bytes, begin: int) -> Floats:
    """The corners (m, 3, 3) of facets given word by word."""
    count = -(-len(words) // _LENGTH)
    for place, word in _WORDS.items():
        if words[place::_LENGTH] != [word] * count:
            raise _bad_facet(content, begin, words)
    texts = [b" ".join(words[place::_LENGTH]) for place in _NUMBERS]
    numbers = [floats_of(text) for text in texts]
    if any(column is None or len(column) != count for column in numbers):
        raise _bad_facet(content, begin, words)
    return np.column_stack([np.zeros(0) if n is None else n for n in numbers]).reshape(-1, 3, 3)


def _bad_facet(content: bytes, begin: int, words: list[bytes]) -> PlannercheckError:
    """The error for the first facet that is none."""
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
