"""Escapes text of files and robots for each kind of output, since names may hold anything.

In: text. Out: the same text, escaped by the rules of a terminal, of csv, or of a script inside HTML.
"""

from __future__ import annotations

import json
import re
from typing import Any, TextIO

# All control characters but tab and newline, and those that turn the direction of writing.
_CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\u2028\u2029]")
# What spreadsheets take for a formula where a cell begins with it.
_FORMULA = ("=", "+", "-", "@", "\t", "\r")
_QUOTED = re.compile('[,"\r\n\x00]')


def on_terminal(text: str) -> str:
    """Text without characters that move the cursor, colour the screen or ring the bell: they are shown as escapes."""
    return _CONTROLS.sub(lambda match: match[0].encode("unicode_escape").decode(), text)


class TerminalText:
    """A text stream whose texts are written as `on_terminal` has them; all else is the stream's own."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Writes text; the number of characters that were given."""
        self._stream.write(on_terminal(text))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def csv_cell(text: str) -> str:
    """A name as a cell of csv (RFC 4180): quoted where it has to be, and never a formula.

    What a spreadsheet would take for a formula gets an apostrophe in front, which it shows as text.
    """
    safe = f"'{text}" if text.startswith(_FORMULA) else text
    return '"' + safe.replace('"', '""') + '"' if _QUOTED.search(safe) else safe


def json_in_script(value: Any) -> str:
    """JSON within an HTML script element: no character of it can end the element or begin another."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text
