"""Failing motions in files, with robot and scene, to be judged again; a case is shrunk before it is written.

In and out: a document with the recipe of the checker, the motion, and the motions that were judged before it, where
that matters.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plannercheck.evaluation.campaign.cases import shrink
from plannercheck.evaluation.stress_motions.aims import Motions
from plannercheck.evaluation.stress_motions.cell_subject import CellSubject
from plannercheck.evaluation.stress_motions.draws import Draw
from plannercheck.evaluation.stress_motions.judges import judge
from plannercheck.evaluation.stress_motions.outcomes import Fault
from plannercheck.evaluation.stress_motions.recipes import Recipe, is_curved
from plannercheck.evaluation.stress_motions.subjects import CurveSubject, PlaneSubject, SpaceSubject, Subject


@dataclass(frozen=True, eq=False)
class MotionCase:
    """Motions of one checker, one of which failed.

    Attributes:
        name: Name of the motion, and what was wrong with its verdict.
        kind: Kind of the fault.
        recipe: Robot and scene.
        motions: The one that failed comes first.
        tolerance: Tolerance of the verdict, m.
    """

    name: str
    kind: str
    recipe: Recipe
    motions: Motions
    tolerance: float

    def document(self) -> dict[str, Any]:
        """What is kept."""
        return {**vars(self), "motions": self.motions._asdict()}

    @staticmethod
    def of(document: dict[str, Any]) -> MotionCase:
        """The case of a document."""
        motions = Motions(**{name: np.array(given) for name, given in document["motions"].items()})
        name, kind, recipe, tolerance = (document[key] for key in ("name", "kind", "recipe", "tolerance"))
        return MotionCase(name, kind, recipe, motions, tolerance)

    def fails(self, seeds: int = 3) -> bool:
        """Whether a fault of the same kind is found again, by new checkers and one of some orders."""
        return any(self.kind in self.faults(seed) for seed in range(seeds))

    def faults(self, seed: int = 0) -> dict[str, str]:
        """What is wrong, by kind."""
        draw = Draw("case", self.recipe, self.motions, self.tolerance)
        try:
            judged = judge(draw, lambda: subject_of(self.recipe), np.random.default_rng(seed))
        except Exception as error:
            return {"exception": repr(error)}
        return {fault.kind: fault.what for fault in judged.faults}


def subject_of(recipe: Recipe, robot: Any = None) -> Subject:
    """The checker behind any recipe, a new one; `robot` if it was built already."""
    if recipe["kind"] == "plane":
        return PlaneSubject(recipe, robot)
    if recipe["kind"] == "cell":
        return CellSubject(recipe, robot)
    return CurveSubject(recipe, robot) if is_curved(recipe) else SpaceSubject(recipe, robot)


def case_of(name: str, draw: Draw, fault: Fault) -> MotionCase:
    """The case of a fault, its motion first."""
    row = max(fault.row, 0)
    order = np.array([row, *range(row), *range(row + 1, len(draw.motions.at))])
    return MotionCase(name, fault.kind, draw.recipe, draw.motions.of(order), draw.tolerance)


def shrunk(case: MotionCase) -> MotionCase:
    """A case that still fails with as few motions and obstacles as it can do with.

    Without an obstacle nothing is in contact with it by construction: so obstacles are dropped only where the case
    fails by what is seen, not by what was built.
    """
    if not case.fails():
        return case
    motions = case.motions
    seen = replace(case, motions=motions._replace(touching=np.zeros_like(motions.touching)))
    if not seen.fails():
        return _with_fewer_motions(case)
    return _with_fewer_obstacles(_with_fewer_motions(seen))


def _with_fewer_motions(case: MotionCase) -> MotionCase:
    def some(rows: list[int]) -> MotionCase:
        return replace(case, motions=case.motions.of(np.array(rows, dtype=np.int64)))

    return some(shrink(range(len(case.motions.at)), lambda rows: some(rows).fails()))


def _with_fewer_obstacles(case: MotionCase) -> MotionCase:
    recipe: Any = case.recipe

    def some(obstacles: list[Any]) -> MotionCase:
        smaller: Any = {**recipe, "obstacles": obstacles}
        return replace(case, recipe=smaller)

    # The first motion may need none at all.
    if some([]).fails():
        return some([])
    return some(shrink(recipe["obstacles"], lambda obstacles: some(obstacles).fails()))
