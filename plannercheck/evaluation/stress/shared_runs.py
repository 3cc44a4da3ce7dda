"""What the stress of solids and of sets of parts share: how tallies are gathered, and of what kind a file's case is.

In: tallies of draws, as processes find them; a file. Out: one tally; the kind that the file names.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Protocol, TypeVar

from plannercheck.common.checked_yaml import BROKEN_FILE


class Tally(Protocol):
    """Counts of pairs, to which others can be added."""

    pairs: Counter[Any]

    def merge(self, other: Any) -> None:
        """Adds another tally."""


_T = TypeVar("_T", bound=Tally)


def gathered(tally: _T, found: Iterable[_T], pairs: int, progress: Callable[[_T], object] | None) -> _T:
    """Adds what is found to a tally until it has at least so many pairs, and tells `progress` after each."""
    for more in found:
        tally.merge(more)
        if progress is not None:
            progress(tally)
        if tally.pairs.total() >= pairs:
            break
    return tally


def is_case_of(kind: str, path: Path) -> bool:
    """Whether a file says that it holds a case of a kind."""
    try:
        return bool(json.loads(path.read_text(encoding="utf-8")).get("kind") == kind)
    except (*BROKEN_FILE, AttributeError):
        return False
