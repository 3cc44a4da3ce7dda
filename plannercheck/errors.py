"""The one family of errors that plannercheck raises for bad input."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


class PlannercheckError(ValueError):
    """Bad input: the message names the input, what is wrong with it, and what would be right."""


def unknown_name(kind: str, name: str, valid: Iterable[str]) -> PlannercheckError:
    """Builds the error for a name that does not exist.

    Args:
        kind: What the name should be, e.g. "link".
        name: The name as given.
        valid: The names that exist.

    Returns:
        An error that lists the closest and then all valid names.
    """
    names = list(valid)
    close = get_close_matches(str(name), names, n=3)  # a name read from a file may be anything
    hint = f"did you mean {' or '.join(repr(c) for c in close)}? " if close else ""
    return PlannercheckError(f"unknown {kind} {name!r}: {hint}valid are {', '.join(names) or 'none'}")
