"""The tally of the stress of solids as text: a table by family, one by offset.

In: a `SolidTally`. Out: lines.
"""

from __future__ import annotations

from collections.abc import Sequence

from plannercheck.evaluation.stress.failure_tables import Column, of, table, total
from plannercheck.evaluation.stress.posed_pairs import ANY_OFFSET
from plannercheck.evaluation.stress_solids.draws import FAMILY_NAMES
from plannercheck.evaluation.stress_solids.judges import OURS
from plannercheck.evaluation.stress_solids.placing import OFFSETS
from plannercheck.evaluation.stress_solids.run import SolidTally
from plannercheck.robots.description import shipped_robots


def lines(tally: SolidTally, peers: Sequence[str]) -> list[str]:
    """All tables.

    Args:
        tally: The counts of a run.
        peers: Names of the peers that took part.

    Returns:
        Lines of text.
    """
    families = [name for name in (*FAMILY_NAMES, *shipped_robots()) if any(key[0] == name for key in tally.pairs)]
    offsets = [name for name in (*OFFSETS, ANY_OFFSET) if any(key[1] == name for key in tally.pairs)]
    sharing = total(tally.pairs, lambda key: key[2])
    head = f"{tally.pairs.total()} pairs of {tally.draws} draws, {sharing} of them share a point; "
    out = [head + f"ours: {', '.join(OURS)}", ""]
    inside = [Column("inside", tally.inside)]
    out += table(tally, OURS, peers, "family", [(name, of(0, name)) for name in families], inside)
    out += ["", *table(tally, OURS, peers, "offset", [(name, of(1, name)) for name in offsets], inside)]
    seconds = ", ".join(f"{what} {spent:.0f} s" for what, spent in tally.seconds.items())
    out += ["", f"time: {seconds}"]
    out += [f"broken: {message}" for message in tally.broken]
    return out
