"""What the stress of solids and of sets of parts share: tallies and how they are gathered, the kind of a file's case.

In: tallies of draws, as processes find them; a file. Out: one tally; the kind that the file names.
"""

from __future__ import annotations

import json
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from plannercheck.common.checked_yaml import BROKEN_FILE
from plannercheck.evaluation.stress.failure_tables import Belongs, Key

if TYPE_CHECKING:
    from typing import Self


# Failures that are kept; more of the same say nothing new.
KEPT = 20

_Case = TypeVar("_Case")


@dataclass
class Tally(Generic[_Case]):
    """The results of a run.

    Attributes:
        pairs: Pairs by family, offset and truth.
        failures: Failures by contestant, kind of failure, family, offset and truth.
        asked: Pairs that a contestant was asked, by family, offset and truth.
        cases: The first failures, smaller where they fail alone.
        broken: Draws that could not be made or judged, by message.
        seconds: Process time by what was done, s.
        draws: Number of draws.
    """

    pairs: Counter[Key] = field(default_factory=Counter)
    failures: Counter[tuple[str, str, Key]] = field(default_factory=Counter)
    asked: Counter[tuple[str, Key]] = field(default_factory=Counter)
    cases: list[_Case] = field(default_factory=list)
    broken: Counter[str] = field(default_factory=Counter)
    seconds: defaultdict[str, float] = field(default_factory=lambda: defaultdict(float))
    draws: int = 0

    def merge(self, other: Self) -> None:
        """Adds what was found after this."""
        self.pairs.update(other.pairs)
        self.failures.update(other.failures)
        self.asked.update(other.asked)
        self.broken.update(other.broken)
        self.cases += other.cases[: max(0, KEPT - len(self.cases))]
        for what, spent in other.seconds.items():
            self.seconds[what] += spent
        self.draws += other.draws

    def times_asked(self, peer: str, belongs: Belongs) -> int:
        """How many pairs a contestant was asked."""
        return sum(count for (who, key), count in self.asked.items() if who == peer and belongs(key))


_T = TypeVar("_T", bound=Tally[Any])


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
