"""The one family of errors that plannercheck raises for bad input."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from plannercheck.common.public_names import set_module

# How many names an error suggests.
_SUGGESTED = 3

# Most characters of a name that an error repeats: it may come from a file made to do harm.
_LONGEST_NAME = 100


@set_module("plannercheck")
class PlannercheckError(ValueError):
    """Bad input: the message names the input, what is wrong with it, and what would be right."""


def unknown_name(kind: str, name: str, valid: Iterable[str]) -> PlannercheckError:
    """The error for a name that is none of a kind, e.g. "link": it lists the closest and then all valid names."""
    names = [shortened(valid_name) for valid_name in dict.fromkeys(valid)]
    name = shortened(name)
    close = get_close_matches(name, names, n=_SUGGESTED) or [each for each in names if name and name in each]
    close = close[:_SUGGESTED]
    hint = f"did you mean {' or '.join(repr(c) for c in close)}? " if close else ""
    return PlannercheckError(f"unknown {kind} {name!r}: {hint}valid are {', '.join(names) or 'none'}")


def with_article(noun: str) -> str:
    """A noun after "a" or "an", by its first letter."""
    return f"{'an' if noun[:1].lower() in tuple('aeiou') else 'a'} {noun}"


def shortened(name: object) -> str:
    """A name for an error, cut if it is absurdly long; a name read from a file may be anything."""
    words = str(name)
    return words if len(words) <= _LONGEST_NAME else words[: _LONGEST_NAME - 3] + "..."
