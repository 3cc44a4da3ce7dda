"""An addition to the tables of the campaign of pairs: the shares of wrong verdicts of other libraries.

In: a tally. Out: lines.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

from plannercheck.evaluation.campaign.posed_pairs import UNFIT
from plannercheck.evaluation.campaign.tallies import FAILURES, Tally, total
from plannercheck.evaluation.stress.oracle import BY_INTEGERS

# Columns of the tables by family and gap: every other magnitude keeps them on a page.
GAP_COLUMNS = ("1e-2", "1e-4", "1e-6", "1e-8", "1e-10", "1e-12", "1e-14", "1e-16", "1e-18", "1 ulp", "0")


def more_lines(tally: Tally[Any], peers: list[str]) -> list[str]:
    """Shares by family and size of the gap, and how many pairs Python's integers had to decide."""
    shares = [line for peer in peers for line in ("", *_shares(tally, peer))]
    return [*shares, "", f"decided by Python's integers: {total(tally.counts, outcome=BY_INTEGERS)}"]


def _shares(tally: Tally[Any], peer: str) -> Iterator[str]:
    """Wrong verdicts of a peer in percent."""
    asked, wrong = Counter[tuple[str, str]](), Counter[tuple[str, str]]()
    for entry, count in tally.counts.items():
        if entry.who == peer and entry.outcome != UNFIT:
            cell = entry.family, entry.offset.lstrip("+-")
            asked[cell] += count
            wrong[cell] += count * (entry.outcome in FAILURES)
    yield f"{peer}: wrong verdicts and exceptions in percent, by size of the gap over that of the smaller body"
    yield " " * 18 + "".join(f"{name:>8}" for name in GAP_COLUMNS)
    for family in sorted({family for family, _ in asked}):
        cells = ((family, name) for name in GAP_COLUMNS)
        yield f"{family:18}" + "".join(
            f"{100 * wrong[cell] / asked[cell]:8.1f}" if asked[cell] else f"{'-':>8}" for cell in cells
        )
