"""The stress tally as text: a table by family, one by gap, and the shares of wrong verdicts of other libraries.

In: a `StressTally`. Out: lines.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from plannercheck.evaluation.stress.random_cases import FAMILY_NAMES, GAPS
from plannercheck.evaluation.stress.run import EXCEPTION, FAILURES, OURS, WRONG, Key, StressTally

# Columns of the tables by family and gap: every other magnitude keeps them on a page.
GAP_COLUMNS = ("1e-2", "1e-4", "1e-6", "1e-8", "1e-10", "1e-12", "1e-14", "1e-16", "1e-18", "1 ulp", "0")

Belongs = Callable[[Key], bool]


def lines(tally: StressTally, peers: Sequence[str]) -> list[str]:
    """All tables.

    Args:
        tally: The counts of a run.
        peers: Names of the peers that took part.

    Returns:
        Lines of text.
    """
    families = [family for family in FAMILY_NAMES if any(key[0] == family for key in tally.pairs)]
    sharing = _sum(tally, lambda key: key[2])
    out = [f"{tally.pairs.total()} pairs, {sharing} of them share a point; ours: {', '.join(OURS)}", ""]
    out += _counts(tally, peers, "family", [(name, _of_family(name)) for name in families])
    out += ["", *_counts(tally, peers, "gap", [(name, _of_gap(name)) for name in GAPS])]
    for peer in peers:
        out += ["", *_shares(tally, peer, families)]
    seconds = ", ".join(f"{who} {spent:.0f} s" for who, spent in tally.seconds.items())
    out += ["", f"time: {seconds}", f"decided by Python's integers: {tally.by_integers}"]
    out += [f"refused {count} bodies: {message}" for message, count in tally.refused.items()]
    return out


def _of_family(name: str) -> Belongs:
    return lambda key: key[0] == name


def _of_gap(name: str) -> Belongs:
    return lambda key: key[1] == name


def _sum(tally: StressTally, belongs: Belongs) -> int:
    return sum(count for key, count in tally.pairs.items() if belongs(key))


def _failed(tally: StressTally, whose: Iterable[str], kind: str, belongs: Belongs) -> int:
    names = set(whose)
    return sum(
        count for (who, what, key), count in tally.failures.items() if who in names and what == kind and belongs(key)
    )


def _asked(tally: StressTally, peer: str, belongs: Belongs) -> int:
    unfit = sum(count for (who, key), count in tally.unfit.items() if who == peer and belongs(key))
    return _sum(tally, belongs) - unfit


def _counts(tally: StressTally, peers: Sequence[str], what: str, rows: Sequence[tuple[str, Belongs]]) -> list[str]:
    """Pairs, our failures, and wrong verdicts of the peers' with how many they were asked."""
    head = f"{what:18} {'pairs':>8} {'sharing':>8} {'wrong':>6} {'except.':>7} {'timeouts':>8}"
    for peer in peers:
        head += f" {peer + ' missed':>12} {peer + ' false':>11} {peer + ' exc.':>10} {'asked':>8}"
    total: tuple[str, Belongs] = ("all", lambda key: True)
    return [head, *(_count_line(tally, peers, name, belongs) for name, belongs in [*rows, total])]


def _count_line(tally: StressTally, peers: Sequence[str], name: str, belongs: Belongs) -> str:
    ours = [_failed(tally, OURS, kind, belongs) for kind in FAILURES]
    sharing = _sum(tally, lambda key: key[2] and belongs(key))
    line = f"{name:18} {_sum(tally, belongs):8} {sharing:8} {ours[0]:6} {ours[1]:7} {ours[2]:8}"
    for peer in peers:
        missed = _failed(tally, [peer], WRONG, lambda key: key[2] and belongs(key))
        false = _failed(tally, [peer], WRONG, lambda key: not key[2] and belongs(key))
        thrown = _failed(tally, [peer], EXCEPTION, belongs)
        line += f" {missed:12} {false:11} {thrown:10} {_asked(tally, peer, belongs):8}"
    return line


def _shares(tally: StressTally, peer: str, families: Sequence[str]) -> list[str]:
    """Wrong verdicts of a peer in percent, by family and size of the gap."""
    out = [f"{peer}: wrong verdicts and exceptions in percent, by size of the gap over that of the smaller body"]
    out.append(" " * 18 + "".join(f"{name:>8}" for name in GAP_COLUMNS))
    return [*out, *(f"{family:18}" + "".join(_cells(tally, peer, family)) for family in families)]


def _cells(tally: StressTally, peer: str, family: str) -> Iterable[str]:
    for column in GAP_COLUMNS:

        def belongs(key: Key, column: str = column) -> bool:
            return key[0] == family and key[1].lstrip("+-") == column

        asked = _asked(tally, peer, belongs)
        wrong = sum(_failed(tally, [peer], kind, belongs) for kind in FAILURES)
        yield f"{100 * wrong / asked:8.1f}" if asked else f"{'-':>8}"
