"""The progress of a run: one line that changes on a terminal, a line from time to time elsewhere.

In: rows done, and the part of the files that has been read. Out: text on a stream: part, rows, rate, remaining time.
"""

from __future__ import annotations

import sys
import time
from typing import Literal, TextIO

Style = Literal["auto", "bar", "lines", "none"]

# s between two texts: on a terminal, and as lines, where short runs print none.
_BAR_PERIOD, _LINE_PERIOD = 0.2, 10.0

_BAR_WIDTH = 24


class Progress:
    """Tells how far a run is."""

    def __init__(self, style: Style = "auto", stream: TextIO | None = None) -> None:
        """Starts the clock of a bar, lines, or nothing; "auto" is a bar on a terminal, else lines.

        It is written to the stream; None is standard error.
        """
        self._stream = sys.stderr if stream is None else stream
        self._style = ("bar" if self._stream.isatty() else "lines") if style == "auto" else style
        self._began = self._reported = time.monotonic()
        self._rows = self._skipped = 0
        self._first_part: float | None = None
        self._width = 0

    def skip(self, rows: int, part: float | None) -> None:
        """Rows that an earlier run has judged: they are done, but say nothing about the rate."""
        self._skipped += rows
        self._first_part = part
        self._began = time.monotonic()

    def advance(self, rows: int, part: float | None) -> None:
        """Rows that have been judged, and what part of all that is."""
        self._rows += rows
        now = time.monotonic()
        if self._style == "none" or now - self._reported < (_BAR_PERIOD if self._style == "bar" else _LINE_PERIOD):
            return
        self._reported = now
        text = self.text(now - self._began, part)
        if self._style == "lines":
            print(f"plannercheck: {text}", file=self._stream, flush=True)
        else:
            shown = _bar(part) + text
            print(f"\r{shown:<{self._width}}", end="", file=self._stream, flush=True)
            self._width = len(shown)

    def text(self, seconds: float, part: float | None) -> str:
        """Part, rows, rate, and the time that remains."""
        rate = self._rows / seconds if seconds > 0 else 0.0
        words = f"{self._skipped + self._rows:,} rows, {rate:,.0f} a second"
        if part is None:
            return words
        before = self._first_part or 0.0
        left = seconds * (1 - part) / (part - before) if part > before else None
        return f"{part:4.0%}, {words}" + ("" if left is None else f", {duration(left)} left")

    def close(self) -> None:
        """Clears the line of a terminal."""
        if self._width:
            print("\r" + " " * self._width + "\r", end="", file=self._stream, flush=True)
            self._width = 0


def _bar(part: float | None) -> str:
    if part is None:
        return ""
    filled = round(_BAR_WIDTH * part)
    return f"[{'#' * filled}{'.' * (_BAR_WIDTH - filled)}] "


def duration(seconds: float) -> str:
    """A time as 12 s, 3:05 min or 2:03 h."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60}:{whole % 60:02} min"
    return f"{whole // 3600}:{whole % 3600 // 60:02} h"
