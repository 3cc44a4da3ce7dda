"""Times as sentences show them: microseconds are kept, however late the clock is.

In: seconds. Out: digits.
"""

from __future__ import annotations


def shown_seconds(time: float) -> str:
    """A time with six significant digits or more, to the microsecond or finer, without trailing zeros."""
    return f"{time:.6g}" if abs(time) < 1 else f"{time:.6f}".rstrip("0").rstrip(".")


def shown_span(begin: float, end: float) -> str:
    """From when to when, with the unit."""
    return f"{shown_seconds(begin)} to {shown_seconds(end)} s"
