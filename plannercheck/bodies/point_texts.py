"""Points in texts, a line each, as scanners, spreadsheets and point cloud programs write them.

In: the content. Out: points (n, 3). A line has the same number of columns as all others, x, y and z first, unless a
heading names them elsewhere. A heading is the first line, or a comment before the points; comments begin with # or //.
A whole number alone on a line is the count of the points after it (PTS), which must be right.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError, shortened

_AXES = ("x", "y", "z")
_COMMENTS = ("#", "//")
_COMMENT_LETTERS = ("#", "/")
_UNIT = re.compile(r"\s*[\[(]m[\])]", re.IGNORECASE)  # after a column's name
_OTHER_UNIT = re.compile(r"[\[(]\s*(?:[cdkmnu]m|in|inch|ft|feet|(?:milli|centi)met(?:er|re)s?)\s*[\])]", re.IGNORECASE)
# A number with a decimal comma, which would be read as two.
_DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+")


@dataclass
class _Table:
    """What has been read so far.

    Attributes:
        points: The points.
        columns: Where x, y and z are; None as long as nothing says so.
        comment: The names of columns that a comment gives, if x, y and z are among them.
        width: Columns of a line; 0 as long as there is none.
        missing: Points that are still to come by the last count; None without a count.
    """

    points: list[list[float]] = field(default_factory=list)
    columns: tuple[int, ...] | None = None
    comment: list[str] = field(default_factory=list)
    width: int = 0
    missing: int | None = None


def points_of_text(content: bytes) -> Floats:
    """The points (n, 3) of a text.

    Raises:
        PlannercheckError: If a line is no point, lines differ in length, or the count is wrong.
    """
    table = _Table()
    for number, line in enumerate(content.removeprefix(b"\xef\xbb\xbf").decode("latin-1").splitlines(), 1):
        try:
            _read_line(table, line)
        except PlannercheckError as error:
            raise PlannercheckError(f"line {number} {error}") from None
    if table.missing:
        raise PlannercheckError(f"is cut short: its count says {table.missing} more points")
    return np.array(table.points, dtype=np.float64).reshape(-1, 3)


def _read_line(table: _Table, line: str) -> None:
    text = line.strip()
    if text[:1] in _COMMENT_LETTERS and text.startswith(_COMMENTS):
        if not table.points:
            text = text.lstrip("#/ ")
            names = _names(text)
            if _columns(names) is None and _columns(_names(_OTHER_UNIT.sub("", text))):
                raise PlannercheckError(f"is {shortened(text)!r}: points must be in m, and a heading must say so")
            table.comment = names if _columns(names) else table.comment
        return
    text = text.partition("#")[0]
    words = text.replace(",", " ").replace(";", " ").split()
    if not words:
        return
    if len(words) == 1 and words[0].isdecimal() and not table.missing and (table.missing == 0 or not table.points):
        table.missing = int(words[0])
        return
    if not table.width and not any(map(_is_number, words)):
        names = _names(text)
        table.columns, table.width = _columns(names), len(names)
        if table.columns is None:
            raise PlannercheckError(
                f"is {shortened(text)!r}, it must begin with x, y and z, or name each of them once, as a heading in m"
            )
        return
    _add_point(table, text, words)


def _add_point(table: _Table, text: str, words: Sequence[str]) -> None:
    if "," in text and _has_decimal_comma(text):
        raise PlannercheckError(f"is {shortened(text)!r}: decimal commas are not read, write points")
    if table.width and len(words) != table.width:
        raise PlannercheckError(f"has {len(words)} columns, the lines before have {table.width}")
    table.width = len(words)
    if table.columns is None:
        is_heading = len(table.comment) == table.width  # else it is a comment like others
        table.columns = (_columns(table.comment) if is_heading else None) or (0, 1, 2)
    try:
        if "_" in text:  # Python reads 1_000
            raise ValueError
        numbers = list(map(float, words))
        table.points.append([numbers[k] for k in table.columns])
    except (ValueError, IndexError):
        raise PlannercheckError(
            f"is {shortened(text)!r}, it must be numbers, with x, y and z first or where a heading says"
        ) from None
    if table.missing == 0:
        raise PlannercheckError("is one point more than the count says")
    if table.missing is not None:
        table.missing -= 1


def _has_decimal_comma(text: str) -> bool:
    """Whether blanks or semicolons separate a line's numbers, one of which has a comma inside."""
    fields = re.split(r"[\s;]+", text.strip())
    is_list = any(field.startswith(",") or field.endswith(",") for field in fields)
    return len(fields) > 1 and not is_list and any(map(_DECIMAL_COMMA.fullmatch, fields))


def _columns(names: Sequence[str]) -> tuple[int, ...] | None:
    """Where x, y and z are; None if they are not among the names, each once."""
    return tuple(map(names.index, _AXES)) if all(names.count(axis) == 1 for axis in _AXES) else None


def _names(text: str) -> list[str]:
    """The names of columns in a heading, without quotes and the unit m."""
    text = re.sub(r"\s+(?=[\[(])", "", _UNIT.sub("", text))
    words = re.split(r"[,;]", text) if re.search(r"[,;]", text) else text.split()
    return [word.strip().strip("\"'").lower() for word in words]


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
