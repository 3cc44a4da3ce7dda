"""The tally of a campaign of pairs as text: a table by family, and one by offset.

In: a tally. Out: lines.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from plannercheck.evaluation.campaign.posed_pairs import UNFIT
from plannercheck.evaluation.campaign.tallies import EXCEPTION, FAILURES, TIMEOUT, WRONG, Column, Entry, Tally, table

# Who decides the truth. Its outcomes are ASKED or what it notes, INSIDE: a part of one body is inside the other.
TRUTH, ASKED, INSIDE = "truth", "asked", "inside"
RIGHT = "right"


def pair_lines(
    tally: Tally[Any], families: Sequence[str], offsets: Sequence[str], peers: Sequence[str], more: Sequence[str]
) -> list[str]:
    """All tables of a run's counts as lines of text: of these families, offsets and peers, and then `more` lines."""
    asked = [entry for entry in tally.counts if entry.who == TRUTH]
    pairs, sharing = (sum(tally.counts[e] for e in asked if e.shared or not only) for only in (False, True))
    each = Counter[str]()
    for entry, count in tally.counts.items():
        each[entry.who] += count * (entry.outcome != UNFIT)
    ours = [f"{who} {each[who]}" for who in tally.seconds if each[who] and who not in (TRUTH, *peers)]
    columns = _columns(tally, peers)
    out = [f"{pairs} pairs of {tally.draws} draws, {sharing} of them share a point; ours: {', '.join(ours)}", ""]
    out += table("family", lambda entry: entry.family, families, columns)
    out += ["", *table("offset", lambda entry: entry.offset, offsets, columns), *more]
    out += ["", "time: " + ", ".join(f"{what} {spent:.0f} s" for what, spent in tally.seconds.items())]
    return out + [f"broken: {message}" for message in tally.broken]


def _columns(tally: Tally[Any], peers: Sequence[str]) -> list[Column]:
    """Pairs, our failures, and wrong verdicts of the peers with how many they were asked."""
    counts = tally.counts
    found = [
        Column("pairs", counts, lambda entry: entry.who == TRUTH),
        Column("sharing", counts, lambda entry: entry.who == TRUTH and entry.shared),
    ]
    if any(entry.outcome == INSIDE for entry in counts):
        found.append(Column("inside", counts, lambda entry: entry.outcome == INSIDE))
    for head, kind in zip(("wrong", "except.", "timeouts"), FAILURES, strict=True):
        found.append(Column(head, tally.faults, lambda entry, kind=kind: entry.outcome == kind))  # type: ignore[misc]
    for peer in peers:
        found += _of_peer(tally, peer)
    return found


def _of_peer(tally: Tally[Any], peer: str) -> list[Column]:
    def is_wrong(entry: Entry) -> bool:
        return entry.who == peer and entry.outcome == WRONG

    return [
        Column(f"{peer} missed", tally.counts, lambda entry: is_wrong(entry) and entry.shared),
        Column(f"{peer} false", tally.counts, lambda entry: is_wrong(entry) and not entry.shared),
        Column(f"{peer} exc.", tally.counts, lambda e: e.who == peer and e.outcome in (EXCEPTION, TIMEOUT)),
        Column("asked", tally.counts, lambda entry: entry.who == peer and entry.outcome != UNFIT),
    ]
