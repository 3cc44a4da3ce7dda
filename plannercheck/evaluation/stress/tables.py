"""The stress tally as text: a table by family, one by gap, and the shares of wrong verdicts of other libraries.

In: a `StressTally`. Out: lines.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from plannercheck.evaluation.stress.failure_tables import FAILURES, Key, failed, of, table, total
from plannercheck.evaluation.stress.random_cases import FAMILY_NAMES, GAPS
from plannercheck.evaluation.stress.run import OURS, StressTally

# Columns of the tables by family and gap: every other magnitude keeps them on a page.
GAP_COLUMNS = ("1e-2", "1e-4", "1e-6", "1e-8", "1e-10", "1e-12", "1e-14", "1e-16", "1e-18", "1 ulp", "0")


def lines(tally: StressTally, peers: Sequence[str]) -> list[str]:
    """All tables.

    Args:
        tally: The counts of a run.
        peers: Names of the peers that took part.

    Returns:
        Lines of text.
    """
    families = [family for family in FAMILY_NAMES if any(key[0] == family for key in tally.pairs)]
    sharing = total(tally.pairs, lambda key: key[2])
    out = [f"{tally.pairs.total()} pairs, {sharing} of them share a point; ours: {', '.join(OURS)}", ""]
    out += table(tally, OURS, peers, "family", [(name, of(0, name)) for name in families])
    out += ["", *table(tally, OURS, peers, "gap", [(name, of(1, name)) for name in GAPS])]
    for peer in peers:
        out += ["", *_shares(tally, peer, families)]
    seconds = ", ".join(f"{who} {spent:.0f} s" for who, spent in tally.seconds.items())
    out += ["", f"time: {seconds}", f"decided by Python's integers: {tally.by_integers}"]
    out += [f"refused {count} bodies: {message}" for message, count in tally.refused.items()]
    return out


def _shares(tally: StressTally, peer: str, families: Sequence[str]) -> list[str]:
    """Wrong verdicts of a peer in percent, by family and size of the gap."""
    out = [f"{peer}: wrong verdicts and exceptions in percent, by size of the gap over that of the smaller body"]
    out.append(" " * 18 + "".join(f"{name:>8}" for name in GAP_COLUMNS))
    return [*out, *(f"{family:18}" + "".join(_cells(tally, peer, family)) for family in families)]


def _cells(tally: StressTally, peer: str, family: str) -> Iterable[str]:
    for column in GAP_COLUMNS:

        def belongs(key: Key, column: str = column) -> bool:
            return key[0] == family and key[1].lstrip("+-") == column

        asked = tally.times_asked(peer, belongs)
        wrong = failed(tally, [peer], FAILURES, belongs)
        yield f"{100 * wrong / asked:8.1f}" if asked else f"{'-':>8}"
