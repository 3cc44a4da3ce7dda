"""What a campaign counts, and tables of it.

In: outcomes, a draw at a time. Out: a `Tally`; a table as lines.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Generic, NamedTuple, TypeVar

if TYPE_CHECKING:
    from typing import Self

WRONG, EXCEPTION, TIMEOUT = "wrong", "exception", "timeout"
FAILURES = (WRONG, EXCEPTION, TIMEOUT)
# Failures that are kept; more of the same say nothing new.
KEPT = 20

Case = TypeVar("Case")


class Entry(NamedTuple):
    """A kind of outcome.

    Attributes:
        who: The contestant.
        outcome: What it said, or how it failed.
        family: Family of the draw.
        offset: How far a pair is from a contact, by name.
        shared: Whether the bodies of a pair share a point.
    """

    who: str
    outcome: str
    family: str
    offset: str = ""
    shared: bool = False


@dataclass
class Tally(Generic[Case]):
    """The results of a run.

    Attributes:
        counts: How often each outcome was found.
        faults: Those that are failures of ours.
        cases: The first failures.
        first: For each kind of fault, how many were judged when it was found first.
        broken: Draws that could not be made or judged, by message.
        seconds: Time by what was done, s.
        draws: Number of draws.
        judged: Number of pairs or motions; a broken draw counts as one.
    """

    counts: Counter[Entry] = field(default_factory=Counter)
    faults: Counter[Entry] = field(default_factory=Counter)
    cases: list[Case] = field(default_factory=list)
    first: dict[str, int] = field(default_factory=dict)
    broken: Counter[str] = field(default_factory=Counter)
    seconds: defaultdict[str, float] = field(default_factory=lambda: defaultdict(float))
    draws: int = 0
    judged: int = 0

    def merge(self, other: Self) -> None:
        """Adds what was found after this."""
        self.counts.update(other.counts)
        self.faults.update(other.faults)
        self.broken.update(other.broken)
        self.cases += other.cases[: max(0, KEPT - len(self.cases))]
        self.draws += other.draws
        self.judged += other.judged
        for what, spent in other.seconds.items():
            self.seconds[what] += spent
        for entry in other.faults:
            self.first.setdefault(entry.outcome, self.judged)

    @property
    def failures(self) -> int:
        """All faults and broken draws."""
        return self.faults.total() + self.broken.total()


def total(counts: Counter[Entry], **those: str | bool) -> int:
    """How many there are with these attributes."""
    return sum(n for entry, n in counts.items() if all(getattr(entry, name) == value for name, value in those.items()))


class Column(NamedTuple):
    """A column of numbers: those of the counts that belong to it."""

    head: str
    counts: Counter[Entry]
    belongs: Callable[[Entry], bool]


def table(what: str, row_of: Callable[[Entry], str], rows: Sequence[str], columns: Sequence[Column]) -> list[str]:
    """Lines of text: one for each of the rows, under the head `what`, that has any outcomes, and one of all."""
    sums = [Counter[str]() for _ in columns]
    for column, found in zip(columns, sums, strict=True):
        for entry, count in column.counts.items():
            if column.belongs(entry):
                found[row_of(entry)] += count
    widths = [max(8, len(column.head)) for column in columns]

    def line(name: str, cells: Sequence[str | int]) -> str:
        return f"{name:20}" + "".join(f" {cell:>{width}}" for cell, width in zip(cells, widths, strict=True))

    there = [name for name in rows if any(found[name] for found in sums)]
    out = [line(what, [column.head for column in columns])]
    out += [line(name, [found[name] for found in sums]) for name in there]
    return [*out, line("all", [found.total() for found in sums])]
