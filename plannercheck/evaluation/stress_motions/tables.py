"""The tally of the motion stress as text: one line for each family.

In: a `MotionTally`. Out: lines.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from plannercheck.evaluation.stress_motions.outcomes import FAULTS
from plannercheck.evaluation.stress_motions.run import FAMILY_NAMES, SOLID_NAMES, MotionTally

_COUNTED = ("motions", "free", "refused", "declined", "sharp", "named off", "sampled states", "verified", "no proof")
_HEADS = ("motions", "free", "refused", "imprecise", "sharp", "named off", "sampled", "verified", "no proof")
_SHORT = {
    "collision passed": "passed",
    "refused without reason": "unreasoned",
    "depends on history": "history",
    "goes another way": "astray",
    "proof refused": "unproved",
    "exception": "except.",
}


def lines(tally: MotionTally) -> list[str]:
    """The table, and what its columns mean."""
    families = [
        family for family in (*FAMILY_NAMES, *SOLID_NAMES) if tally.counts[family]["motions"] or tally.faults[family]
    ]
    head = f"{'family':14}" + "".join(f"{name:>11}" for name in (*_HEADS, *(_SHORT[kind] for kind in FAULTS)))
    rows = [(family, tally.counts[family], tally.faults[family]) for family in families]
    rows.append(("all", *_sums(tally, families)))
    out = [head, *(_row(*row) for row in rows), ""]
    spent = sum(tally.seconds.values())
    rate = tally.motions / max(spent, 1e-9)
    out.append(f"{tally.draws} draws, {spent:.0f} s of processes' time, {rate:.0f} motions a second")
    out.append("slowest, ms a motion: " + ", ".join(_slowest(tally, families)))
    out += _of_solids(tally, families)
    out += [f"first {kind}: within {count} motions" for kind, count in tally.first.items()]
    return out


def _of_solids(tally: MotionTally, families: Sequence[str]) -> list[str]:
    """What was asked about meshes, and the motions of planners that other geometry would have refused."""
    counts, _ = _sums(tally, families)
    if not counts["mesh states"]:
        return []
    out = [
        f"by coal's meshes: {counts['mesh states']} states of free motions, {counts['refused by meshes']} refused ones"
    ]
    for name in families:
        own = tally.counts[name]
        refused = [
            f"{kind} refuse {100 * own[key] / own['planned']:.1f} %"
            for kind, key in (("hulls", "refused by hull"), ("convex pieces", "refused by pieces"))
            if key in own
        ]
        out += [f"{name}: {own['planned']} motions of RRT-Connect: {', '.join(refused)}"] if own["planned"] else []
    return out


def _sums(tally: MotionTally, families: Sequence[str]) -> tuple[Counter[str], Counter[str]]:
    counts, faults = Counter[str](), Counter[str]()
    for family in families:
        counts.update(tally.counts[family])
        faults.update(tally.faults[family])
    return counts, faults


def _row(name: str, counts: Counter[str], faults: Counter[str]) -> str:
    numbers = [*(counts[key] for key in _COUNTED), *(faults[kind] for kind in FAULTS)]
    return f"{name:14}" + "".join(f"{number:11}" for number in numbers)


def _slowest(tally: MotionTally, families: Sequence[str]) -> list[str]:
    each = {name: 1e3 * tally.seconds[name] / max(tally.counts[name]["motions"], 1) for name in families}
    return [f"{name} {each[name]:.2f}" for name in sorted(each, key=lambda name: -each[name])[:4]]
