"""Tables of a stress run: pairs, our failures, and those of other libraries, by what the rows have in common.

In: counts of pairs and of failures. Out: lines.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple, Protocol

WRONG, EXCEPTION, TIMEOUT = "wrong", "exception", "timeout"
FAILURES = (WRONG, EXCEPTION, TIMEOUT)

Key = tuple[str, str, bool]  # family, distance by name, whether the bodies share a point
Belongs = Callable[[Key], bool]


class Counts(Protocol):
    """The results of a run, as tables need them."""

    pairs: Counter[Key]
    failures: Counter[tuple[str, str, Key]]

    def times_asked(self, peer: str, belongs: Belongs) -> int:
        """How many pairs a peer was asked."""
        ...


class Column(NamedTuple):
    """A column of numbers between those of the pairs and of the failures."""

    head: str
    counts: Counter[Key]


def of(part: int, name: str) -> Belongs:
    """Keys of which a part is this name."""
    return lambda key: key[part] == name


def total(counts: Counter[Key], belongs: Belongs) -> int:
    """How many there are of some keys."""
    return sum(count for key, count in counts.items() if belongs(key))


def failed(counts: Counts, whose: Iterable[str], kinds: Iterable[str], belongs: Belongs) -> int:
    """Failures of these kinds."""
    names, some = set(whose), set(kinds)
    return sum(n for (who, kind, key), n in counts.failures.items() if who in names and kind in some and belongs(key))


def table(
    counts: Counts,
    ours: Sequence[str],
    peers: Sequence[str],
    what: str,
    rows: Sequence[tuple[str, Belongs]],
    more: Sequence[Column] = (),
) -> list[str]:
    """Pairs, our failures, and wrong verdicts of the peers' with how many they were asked."""
    head = f"{what:20} {'pairs':>9} {'sharing':>9}" + "".join(f" {column.head:>8}" for column in more)
    head += f" {'wrong':>6} {'except.':>7} {'timeouts':>8}"
    for peer in peers:
        head += f" {peer + ' missed':>12} {peer + ' false':>11} {peer + ' exc.':>10} {'asked':>9}"
    every: tuple[str, Belongs] = ("all", lambda key: True)
    return [head, *(_line(counts, ours, peers, *row, more) for row in [*rows, every])]


def _line(
    counts: Counts, ours: Sequence[str], peers: Sequence[str], name: str, belongs: Belongs, more: Sequence[Column]
) -> str:
    sharing = total(counts.pairs, lambda key: key[2] and belongs(key))
    line = f"{name:20} {total(counts.pairs, belongs):9} {sharing:9}"
    line += "".join(f" {total(column.counts, belongs):8}" for column in more)
    for width, kind in zip((6, 7, 8), FAILURES, strict=True):
        line += f" {failed(counts, ours, [kind], belongs):{width}}"
    for peer in peers:
        missed = failed(counts, [peer], [WRONG], lambda key: key[2] and belongs(key))
        false = failed(counts, [peer], [WRONG], lambda key: not key[2] and belongs(key))
        thrown = failed(counts, [peer], [EXCEPTION, TIMEOUT], belongs)
        line += f" {missed:12} {false:11} {thrown:10} {counts.times_asked(peer, belongs):9}"
    return line
