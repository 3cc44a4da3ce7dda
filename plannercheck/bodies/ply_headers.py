"""Headers of PLY files: the elements that follow, and the types of their numbers.

In: the content of a file. Out: its byte order, its elements with their properties, and where they begin.
"""

from __future__ import annotations

from dataclasses import dataclass

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


@dataclass(frozen=True)
class PlyProperty:
    """A property: a number, or, with a type of its count, a list."""

    name: str
    kind: str
    count: str | None = None


@dataclass(frozen=True)
class PlyElement:
    """Rows of one kind; `properties` in the order of a row."""

    name: str
    rows: int
    properties: list[PlyProperty]


def header_of_ply(content: bytes) -> tuple[str, list[PlyElement], int]:
    """The byte order ("" for text), the elements, and where they begin."""
    end = content.find(b"end_header", 0, _LONGEST_HEADER)
    after = content.find(b"\n", end)
    if not content.startswith(b"ply") or end < 0 or after < 0 or content[end + 10 : after].strip():
        raise PlannercheckError("is no PLY file: it must have a header from 'ply' to 'end_header'")
    lines = [line.decode("latin-1").split() for line in content[:end].splitlines()[1:]]
    lines = [words for words in lines if words and words[0] not in ("comment", "obj_info")]
    if not lines or lines[0][0] != "format" or lines[0][1:] not in [[order, "1.0"] for order in _ORDERS]:
        raise PlannercheckError(f"a PLY file must say its format, {', '.join(_ORDERS)}, and version 1.0")
    elements: list[PlyElement] = []
    for words in lines[1:]:
        if words[0] == "element" and len(words) == 3 and words[2].isdecimal() and len(words[2]) < 16:
            elements.append(PlyElement(words[1], int(words[2]), []))
        elif words[0] == "property" and elements:
            elements[-1].properties.append(_property(words[1:]))
        else:
            raise PlannercheckError(f"its PLY header has a line {shortened(' '.join(words))!r}")
    names = [(element.name, each.name) for element in elements for each in element.properties]
    if len(set(names)) < len(names) or len({element.name for element in elements}) < len(elements):
        raise PlannercheckError("its PLY header has an element or a property twice")
    return _ORDERS[lines[0][1]], elements, after + 1


def _property(words: list[str]) -> PlyProperty:
    if len(words) == 2 and words[0] in _TYPES:
        return PlyProperty(words[1], _TYPES[words[0]])
    if len(words) == 4 and words[0] == "list" and words[1] in _TYPES and words[2] in _TYPES:
        return PlyProperty(words[3], _TYPES[words[2]], _TYPES[words[1]])
    raise PlannercheckError(f"its PLY header has a property {shortened(' '.join(words))!r}")
