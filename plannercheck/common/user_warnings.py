"""Warnings about a user's input that name the user's line.

In: a sentence. Out: a `RuntimeWarning` at the innermost line outside of plannercheck, however deep the call is.
"""

from __future__ import annotations

import sys
import warnings


def warn(sentence: str) -> None:
    """Warns, and blames the line that called plannercheck."""
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "plannercheck":
        frame, level = frame.f_back, level + 1
    warnings.warn(sentence, RuntimeWarning, stacklevel=level)
