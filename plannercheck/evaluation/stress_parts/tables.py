"""The tally of the stress of sets of parts as text: a table by family, one by offset, one of motions.

In: a `PartTally`. Out: lines.
"""

from __future__ import annotations

from plannercheck.evaluation.stress.failure_tables import of, table, total
from plannercheck.evaluation.stress_parts.draws import FAMILY_NAMES, OFFSET_NAMES
from plannercheck.evaluation.stress_parts.judges import OURS
from plannercheck.evaluation.stress_parts.motions import OUTCOMES
from plannercheck.evaluation.stress_parts.run import PartTally


def lines(tally: PartTally) -> list[str]:
    """All tables."""
    families = [name for name in FAMILY_NAMES if any(key[0] == name for key in tally.pairs)]
    offsets = [name for name in OFFSET_NAMES if any(key[1] == name for key in tally.pairs)]
    sharing = total(tally.pairs, lambda key: key[2])
    asked = ", ".join(f"{who} {tally.times_asked(who, lambda key: True)}" for who in OURS)
    out = [f"{tally.pairs.total()} pairs of {tally.draws} draws, {sharing} of them share a point; ours: {asked}", ""]
    out += table(tally, OURS, [], "family", [(name, of(0, name)) for name in families])
    out += ["", *table(tally, OURS, [], "offset", [(name, of(1, name)) for name in offsets])]
    out += ["", *_motions(tally)]
    seconds = ", ".join(f"{what} {spent:.0f} s" for what, spent in tally.seconds.items())
    out += ["", f"time: {seconds}"]
    out += [f"broken: {message}" for message in tally.broken]
    return out


def _motions(tally: PartTally) -> list[str]:
    """By what they go past."""
    families = [name for name in FAMILY_NAMES if any(key[0] == name for key in tally.motions)]
    rows = [(name, [tally.motions[name, outcome] for outcome in OUTCOMES]) for name in families]
    rows.append(("all", [sum(counts) for counts in zip(*(counts for _, counts in rows), strict=True)]))
    head = f"{'motions before':20}" + "".join(f" {outcome:>12}" for outcome in OUTCOMES)
    return [head, *(f"{name:20}" + "".join(f" {count:12}" for count in counts) for name, counts in rows)]
