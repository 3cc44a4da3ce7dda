"""The campaign of motions: random draws, each judged by all rules that have to hold.

In: a seed, families. Out: a `MotionCampaign`, see `plannercheck.evaluation.campaign.campaign`.
"""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from plannercheck.evaluation.campaign.tallies import EXCEPTION, Column, Entry, Tally, table, total
from plannercheck.evaluation.stress_motions.cases import MotionCase, case_of, shrunk, subject_of
from plannercheck.evaluation.stress_motions.cell_draws import CELL_MOTIONS, CELL_WEIGHTS, cell_draw
from plannercheck.evaluation.stress_motions.curves import curved
from plannercheck.evaluation.stress_motions.draws import (
    FAMILIES,
    MOTIONS,
    STRAIGHT,
    Draw,
    shipped_draw,
    shipped_robot,
    tree_draw,
)
from plannercheck.evaluation.stress_motions.judges import judge
from plannercheck.evaluation.stress_motions.ompl_paths import OMPL_FAMILY, judge_ompl_paths
from plannercheck.evaluation.stress_motions.outcomes import FAULTS, Fault, Judged
from plannercheck.evaluation.stress_motions.planar_draws import PLANAR_FAMILIES, planar_draw
from plannercheck.evaluation.stress_motions.planned_draws import PLANNED, planned_draw
from plannercheck.evaluation.stress_motions.recipes import Recipe, cell_of, geometry_of, planar_robot_of, robot_of
from plannercheck.evaluation.stress_motions.solid_draws import SETTINGS, solid_draw
from plannercheck.evaluation.stress_motions.subjects import Subject
from plannercheck.evaluation.stress_motions.unposed_robots import UNPOSED, judge_unposed

# Families and how often they are drawn. Those of which a draw is costly, or small, are rarer.
WEIGHTS: dict[str, float] = {
    "tree": 0.2,
    "chain": 0.1,
    "turns": 0.1,
    "placed": 0.16,
    STRAIGHT: 0.12,
    "mimic": 0.08,
    "off unit": 0.04,
    "far ends": 0.06,
    "shipped": 0.04,
    "plane chain": 0.1,
    "plane swing": 0.04,
    "plane shipped": 0.03,
    "plane curves": 0.04,
    OMPL_FAMILY: 0.02,
    UNPOSED: 0.01,
}
FAMILY_NAMES = tuple(WEIGHTS)
# Families of solids, which are drawn by themselves.
SOLID_WEIGHTS: dict[str, float] = {**dict.fromkeys(SETTINGS, 0.9), **dict.fromkeys(PLANNED, 0.1)}
SOLID_NAMES = tuple(SOLID_WEIGHTS)
# Families of cells, which are drawn by themselves, too.
_ALL_WEIGHTS = WEIGHTS | SOLID_WEIGHTS | CELL_WEIGHTS
_SPECIAL: dict[str, Callable[[np.random.Generator], Judged]] = {
    OMPL_FAMILY: judge_ompl_paths,
    UNPOSED: judge_unposed,
}
# Random numbers of a draw: what it is, and how it is judged.
_DRAWN, _JUDGED = 0, 1
UNIT = "motions"
_COUNTED = {
    UNIT: "motions",
    "free": "free",
    "refused": "refused",
    "declined": "imprecise",
    "sharp": "sharp",
    "named off": "named off",
    "sampled states": "sampled",
    "verified": "verified",
    "no proof": "no proof",
}
_SHORT = dict(zip(FAULTS, ("passed", "unreasoned", "history", "astray", "unproved", "except."), strict=True))


@dataclass(frozen=True)
class MotionCampaign:
    """A campaign of motions.

    Attributes:
        seed: Seed of the random numbers.
        families: Some of FAMILY_NAMES, or of SOLID_NAMES.
        verified: Accepted motions of each draw to prove and verify.
        pieces: Whether to count what convex pieces refuse of a planner's motions among solids.
        curves: Whether to draw curves through the same states.
    """

    seed: int = 0
    families: tuple[str, ...] = FAMILY_NAMES
    verified: int = 0
    pieces: bool = False
    curves: bool = False
    name: str = UNIT
    unit: str = UNIT

    @property
    def is_of_one_use(self) -> bool:
        """Not of solids, which are shipped."""
        return not set(self.families) <= set(SOLID_NAMES)

    def judge(self, number: int, tally: Tally[MotionCase]) -> None:
        """Makes the `number`-th draw, and counts all that is found on it."""
        began = time.perf_counter()
        family = self.family_of(number)
        rng = np.random.default_rng([self.seed, number, _DRAWN, _JUDGED])
        warnings.simplefilter("ignore", RuntimeWarning)  # of bodies that touch for ever
        label = f"seed {self.seed}, draw {number}, {family}"
        if family in _SPECIAL:
            judged = _SPECIAL[family](rng)
            tally.broken.update(f"{label}: {fault.what}" for fault in judged.faults)
        else:
            drawn = curved(draw(family, rng), rng) if self.curves else draw(family, rng)
            judged = _judged(drawn, rng, self.verified, self.pieces)
            kinds = {fault.kind: fault for fault in reversed(judged.faults)}
            tally.cases += [case_of(f"{label}: {fault.kind}: {fault.what}", drawn, fault) for fault in kinds.values()]
        tally.judged += judged.counts[UNIT]
        for what, count in judged.counts.items():
            tally.counts[Entry(UNIT, what, family)] += count
        tally.faults.update(Entry(UNIT, fault.kind, family) for fault in judged.faults)
        tally.seconds[family] += time.perf_counter() - began

    def family_of(self, number: int) -> str:
        """The family of the `number`-th draw."""
        weights = np.array([_ALL_WEIGHTS[family] for family in self.families])
        rng = np.random.default_rng([self.seed, number, _DRAWN])
        return str(rng.choice(self.families, p=weights / weights.sum()))

    def lines(self, tally: Tally[MotionCase]) -> list[str]:
        """The table, and what its columns mean."""
        columns = [_column(head, tally.counts, what) for what, head in _COUNTED.items()]
        columns += [_column(head, tally.faults, kind) for kind, head in _SHORT.items()]
        out = [*table("family", lambda entry: entry.family, self.families, columns), ""]
        spent = sum(tally.seconds.values())
        rate = tally.judged / max(spent, 1e-9)
        out.append(f"{tally.draws} draws, {spent:.0f} s of processes' time, {rate:.0f} motions a second")
        out.append("slowest, ms a motion: " + ", ".join(_slowest(tally)))
        out += _of_solids(tally)
        out += [f"first {kind}: within {count} motions" for kind, count in tally.first.items()]
        return out + [f"broken: {message}" for message in tally.broken]

    def case_of(self, document: dict[str, Any]) -> MotionCase:
        """The case of a document."""
        return MotionCase.of(document)

    def faults(self, case: MotionCase) -> dict[str, str]:
        """What is wrong, by kind."""
        return case.faults()

    def shrunk(self, case: MotionCase) -> MotionCase:
        """A smaller case that still fails."""
        return shrunk(case)


def campaign(
    seed: int,
    families: tuple[str, ...] = FAMILY_NAMES,
    verified: float = 0.0,
    pieces: bool = False,
    curves: bool = False,
) -> MotionCampaign:
    """The campaign of a seed.

    Args:
        seed: Seed of the random numbers.
        families: Some of FAMILY_NAMES, or of SOLID_NAMES.
        verified: About which part of the motions to prove and verify.
        pieces: Whether to count what convex pieces refuse of a planner's motions among solids.
        curves: Whether to draw curves through the same states; the families are then some of `families_of`.

    Returns:
        The campaign.
    """
    size = CELL_MOTIONS if set(families) <= set(CELL_WEIGHTS) else MOTIONS
    return MotionCampaign(seed, families, math.ceil(verified * size), pieces, curves)


def families_of(solids: bool, curves: bool, cells: bool = False) -> tuple[str, ...]:
    """The families that may be drawn: of solids, of curves, of cells."""
    if cells:
        return tuple(CELL_WEIGHTS)
    if curves:
        return tuple(SETTINGS) if solids else (*FAMILIES, "shipped")
    return SOLID_NAMES if solids else FAMILY_NAMES


def _judged(drawn: Draw, rng: np.random.Generator, verified: int, pieces: bool) -> Judged:
    """An exception is a fault, too."""
    try:
        return judge(drawn, _builder(drawn.recipe), rng, verified, pieces)
    except Exception as error:
        return Judged(faults=[Fault(EXCEPTION, -1, repr(error))])


def draw(family: str, rng: np.random.Generator) -> Draw:
    """A random draw of a family."""
    if family in CELL_WEIGHTS:
        return cell_draw(family, rng)
    if family in PLANNED:
        return planned_draw(family, rng)
    if family in SETTINGS:
        return solid_draw(family, rng)
    if family in PLANAR_FAMILIES:
        return planar_draw(family, rng)
    return tree_draw(family, rng) if family in FAMILIES else shipped_draw(family, rng)


def _builder(recipe: Recipe) -> Callable[[], Subject]:
    """Makes new checkers of one robot."""
    robot: object
    if recipe["kind"] == "plane":
        robot = planar_robot_of(recipe)
    elif recipe["kind"] == "cell":
        robot = cell_of(recipe)
    elif recipe["shipped"]:
        robot = shipped_robot(recipe["shipped"], recipe["whole"], geometry_of(recipe))
    else:
        robot = robot_of(recipe)
    return lambda: subject_of(recipe, robot)


def _column(head: str, counts: Any, outcome: str) -> Column:
    return Column(head, counts, lambda entry: entry.outcome == outcome)


def _slowest(tally: Tally[MotionCase]) -> list[str]:
    motions = {family: total(tally.counts, outcome=UNIT, family=family) for family in tally.seconds}
    each = {family: 1e3 * spent / max(motions[family], 1) for family, spent in tally.seconds.items()}
    return [f"{name} {each[name]:.2f}" for name in sorted(each, key=lambda name: -each[name])[:4]]


def _of_solids(tally: Tally[MotionCase]) -> list[str]:
    """What was asked about meshes, and the motions of planners that other geometry would have refused."""
    states, refused = (total(tally.counts, outcome=what) for what in ("mesh states", "refused by meshes"))
    out = [f"by coal's meshes: {states} states of free motions, {refused} refused ones"] if states else []
    for family in tally.seconds:
        own = {entry.outcome: count for entry, count in tally.counts.items() if entry.family == family}
        shares = [
            f"{kind} refuse {100 * own[key] / own['planned']:.1f} %"
            for kind, key in (("hulls", "refused by hull"), ("convex pieces", "refused by pieces"))
            if key in own
        ]
        out += [f"{family}: {own['planned']} motions of RRT-Connect: {', '.join(shares)}"] if "planned" in own else []
    return out
