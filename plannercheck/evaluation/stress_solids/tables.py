"""The tally of the stress of solids as text: a table by family, one by offset.

In: a `SolidTally`. Out: lines.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from plannercheck.evaluation.stress_solids.draws import ANY_OFFSET, FAMILY_NAMES
from plannercheck.evaluation.stress_solids.judges import EXCEPTION, OURS, TIMEOUT, WRONG
from plannercheck.evaluation.stress_solids.placing import OFFSETS
from plannercheck.evaluation.stress_solids.run import Key, SolidTally

_FAILURES = (WRONG, EXCEPTION, TIMEOUT)

Belongs = Callable[[Key], bool]


def lines(tally: SolidTally, peers: Sequence[str]) -> list[str]:
    """All tables.

    Args:
        tally: The counts of a run.
        peers: Names of the peers that took part.

    Returns:
        Lines of text.
    """
    families = [name for name in FAMILY_NAMES if any(key[0] == name for key in tally.pairs)]
    offsets = [name for name in (*OFFSETS, ANY_OFFSET) if any(key[1] == name for key in tally.pairs)]
    total, sharing = tally.pairs.total(), _sum(tally.pairs, lambda key: key[2])
    out = [f"{total} pairs of {tally.draws} draws, {sharing} of them share a point; ours: {', '.join(OURS)}", ""]
    out += _table(tally, peers, "family", [(name, _of(0, name)) for name in families])
    out += ["", *_table(tally, peers, "offset", [(name, _of(1, name)) for name in offsets])]
    seconds = ", ".join(f"{what} {spent:.0f} s" for what, spent in tally.seconds.items())
    out += ["", f"time: {seconds}"]
    out += [f"broken: {message}" for message in tally.broken]
    return out


def _of(part: int, name: str) -> Belongs:
    return lambda key: key[part] == name


def _sum(counts: dict[Key, int], belongs: Belongs) -> int:
    return sum(count for key, count in counts.items() if belongs(key))


def _failed(tally: SolidTally, whose: Iterable[str], kinds: Iterable[str], belongs: Belongs) -> int:
    names, some = set(whose), set(kinds)
    return sum(n for (who, kind, key), n in tally.failures.items() if who in names and kind in some and belongs(key))


def _table(tally: SolidTally, peers: Sequence[str], what: str, rows: Sequence[tuple[str, Belongs]]) -> list[str]:
    """Pairs, our failures, and wrong verdicts of the peers' with how many they were asked."""
    head = f"{what:20} {'pairs':>9} {'sharing':>9} {'inside':>8} {'wrong':>6} {'except.':>7} {'timeouts':>8}"
    for peer in peers:
        head += f" {peer + ' missed':>12} {peer + ' false':>11} {peer + ' exc.':>10} {'asked':>9}"
    total: tuple[str, Belongs] = ("all", lambda key: True)
    return [head, *(_line(tally, peers, name, belongs) for name, belongs in [*rows, total])]


def _line(tally: SolidTally, peers: Sequence[str], name: str, belongs: Belongs) -> str:
    line = f"{name:20} {_sum(tally.pairs, belongs):9} {_sum(tally.pairs, lambda key: key[2] and belongs(key)):9}"
    line += f" {_sum(tally.inside, belongs):8}"
    for width, kind in zip((6, 7, 8), _FAILURES, strict=True):
        line += f" {_failed(tally, OURS, [kind], belongs):{width}}"
    for peer in peers:
        missed = _failed(tally, [peer], [WRONG], lambda key: key[2] and belongs(key))
        false = _failed(tally, [peer], [WRONG], lambda key: not key[2] and belongs(key))
        asked = sum(count for (who, key), count in tally.asked.items() if who == peer and belongs(key))
        line += f" {missed:12} {false:11} {_failed(tally, [peer], [EXCEPTION, TIMEOUT], belongs):10} {asked:9}"
    return line
