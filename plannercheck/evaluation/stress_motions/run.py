"""The motion stress: random draws, each judged by itself, in any number of processes.

In: how many motions, a seed. Out: a `MotionTally` by family, and the failures as cases. Every draw has random numbers
of its own, so the results do not depend on the number of processes.
"""

from __future__ import annotations

import contextlib
import itertools
import time
import warnings
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from plannercheck.common.cache import uncached
from plannercheck.evaluation.stress_motions.cases import MotionCase, case_of
from plannercheck.evaluation.stress_motions.draws import (
    FAMILIES,
    MOTIONS,
    OFF_UNIT_MOTIONS,
    STRAIGHT,
    Draw,
    shipped_draw,
    shipped_robot,
    tree_draw,
)
from plannercheck.evaluation.stress_motions.judges import judge
from plannercheck.evaluation.stress_motions.ompl_paths import OMPL_FAMILY, judge_ompl_paths
from plannercheck.evaluation.stress_motions.outcomes import EXCEPTION, Fault, Judged
from plannercheck.evaluation.stress_motions.planar_draws import CURVES, PLANAR_FAMILIES, planar_draw
from plannercheck.evaluation.stress_motions.planned_draws import PLANNED, PLANNED_MOTIONS, planned_draw
from plannercheck.evaluation.stress_motions.recipes import Recipe, geometry_of, planar_robot_of, robot_of
from plannercheck.evaluation.stress_motions.solid_draws import SETTINGS, SOLID_MOTIONS, solid_draw
from plannercheck.evaluation.stress_motions.subjects import Subject, subject_of
from plannercheck.evaluation.stress_motions.unposed_robots import UNPOSED, judge_unposed
from plannercheck.evaluation.worker_processes import workers

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
_ALL_WEIGHTS = WEIGHTS | SOLID_WEIGHTS
_SPECIAL: dict[str, Callable[[np.random.Generator], Judged]] = {
    OMPL_FAMILY: judge_ompl_paths,
    UNPOSED: judge_unposed,
}
# About how many motions a draw has; those of other families have MOTIONS.
_SIZES = {
    "off unit": OFF_UNIT_MOTIONS,
    "plane curves": CURVES,
    OMPL_FAMILY: 80,
    UNPOSED: 10,
    **dict.fromkeys(SETTINGS, SOLID_MOTIONS),
    **dict.fromkeys(PLANNED, PLANNED_MOTIONS),
}
# Failures that are kept; more of the same say nothing new.
KEPT = 20
# Random numbers of a draw: what it is, and how it is judged.
_DRAWN, _JUDGED = 0, 1


@dataclass
class MotionTally:
    """The results of a run.

    Attributes:
        counts: Counts by family and by what was counted: motions, free, refused, declined, sharp, sampled states,
            verified.
        faults: Faults by family and kind.
        cases: The first failures.
        first: For each kind of fault, after how many motions it was found first.
        draws: Number of draws that were judged.
        seconds: Process time by family, s.
    """

    counts: dict[str, Counter[str]] = field(default_factory=lambda: defaultdict(Counter))
    faults: dict[str, Counter[str]] = field(default_factory=lambda: defaultdict(Counter))
    cases: list[MotionCase] = field(default_factory=list)
    first: dict[str, int] = field(default_factory=dict)
    draws: int = 0
    seconds: dict[str, float] = field(default_factory=lambda: defaultdict(float))

    @property
    def motions(self) -> int:
        """All that were judged."""
        return sum(count["motions"] for count in self.counts.values())

    @property
    def failures(self) -> int:
        """All faults."""
        return sum(count.total() for count in self.faults.values())

    def add(self, outcome: Outcome) -> None:
        """Adds a draw's."""
        self.draws += 1
        self.counts[outcome.family].update(outcome.counts)
        self.faults[outcome.family].update(outcome.faults)
        self.seconds[outcome.family] += outcome.seconds
        self.cases += outcome.cases[: KEPT - len(self.cases)]
        for kind in outcome.faults:
            self.first.setdefault(kind, self.motions)


class Outcome(NamedTuple):
    """What a draw found, as it goes from process to process."""

    number: int
    family: str
    counts: Counter[str]
    faults: Counter[str]
    cases: list[MotionCase]
    seconds: float


class Task(NamedTuple):
    """A draw to be made and judged."""

    seed: int
    number: int
    family: str
    verified: int
    pieces: bool


def run(
    motions: int,
    seed: int,
    verified: int = 0,
    processes: int = 1,
    families: tuple[str, ...] = FAMILY_NAMES,
    progress: Callable[[MotionTally], object] | None = None,
    pieces: bool = False,
) -> MotionTally:
    """Runs the suite.

    Args:
        motions: Least number of motions to judge.
        seed: Seed of the random numbers.
        verified: Approximate number of accepted motions to prove and verify.
        processes: Number of processes that share the work; what is found does not depend on it.
        families: Some of FAMILY_NAMES, or of SOLID_NAMES.
        progress: Called after each draw.
        pieces: Whether to count what convex pieces refuse of a planner's motions among solids.

    Returns:
        The tally.
    """
    tally = MotionTally()
    each = 0 if verified == 0 else -(-verified * MOTIONS // motions)
    # No one will meet the millions of bodies of these again.
    are_of_one_use = not set(families) <= set(SOLID_NAMES)
    with uncached() if are_of_one_use else contextlib.nullcontext(), workers(processes) as some:
        for outcome in some.results(outcome_of, tasks(motions, seed, each, families, pieces)):
            tally.add(outcome)
            if progress is not None:
                progress(tally)
    return tally


def tasks(motions: int, seed: int, verified: int, families: tuple[str, ...], pieces: bool = False) -> Iterator[Task]:
    """Draws that have about so many motions together."""
    weights = np.array([_ALL_WEIGHTS[family] for family in families])
    planned = 0
    for number in itertools.count():
        if planned >= motions:
            break
        family = str(np.random.default_rng([seed, number, _DRAWN]).choice(families, p=weights / weights.sum()))
        planned += _SIZES.get(family, MOTIONS)
        yield Task(seed, number, family, verified, pieces)


def outcome_of(task: Task) -> Outcome:
    """Makes and judges a draw; an exception is a fault, too."""
    began = time.process_time()
    rng = np.random.default_rng([task.seed, task.number, _DRAWN, _JUDGED])
    drawn: Draw | None = None
    try:
        warnings.simplefilter("ignore", RuntimeWarning)  # of bodies that touch for ever
        if task.family in _SPECIAL:
            judged = _SPECIAL[task.family](rng)
        else:
            drawn = draw(task.family, rng)
            judged = judge(drawn, _builder(drawn.recipe), rng, task.verified, task.pieces)
    except Exception as error:
        judged = Judged(faults=[Fault(EXCEPTION, -1, repr(error))])
    kinds: dict[str, Fault] = {}
    for fault in judged.faults:
        kinds.setdefault(fault.kind, fault)
    label = f"seed {task.seed}, draw {task.number}, {task.family}"
    cases = [case_of(f"{label}: {fault.what}", drawn, fault) for fault in kinds.values()]
    faults = Counter(fault.kind for fault in judged.faults)
    return Outcome(task.number, task.family, judged.counts, faults, cases, time.process_time() - began)


def draw(family: str, rng: np.random.Generator) -> Draw:
    """A random draw of a family."""
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
    elif recipe["shipped"]:
        robot = shipped_robot(recipe["shipped"], recipe["whole"], geometry_of(recipe))
    else:
        robot = robot_of(recipe)
    return lambda: subject_of(recipe, robot)
