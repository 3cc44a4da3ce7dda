"""Failing motions in files, with robot and scene, to be judged again; a case is made smaller before it is kept.

In and out: JSON with the recipe of the checker, the motion, and the motions that were judged before it, where that
matters.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from plannercheck.common.checked_yaml import BROKEN_FILE
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.file_kinds import kind_of
from plannercheck.evaluation.stress_motions.aims import Motions
from plannercheck.evaluation.stress_motions.draws import Draw
from plannercheck.evaluation.stress_motions.judges import judge
from plannercheck.evaluation.stress_motions.outcomes import Fault
from plannercheck.evaluation.stress_motions.recipes import Recipe
from plannercheck.evaluation.stress_motions.subjects import subject_of


@dataclass(frozen=True, eq=False)
class MotionCase:
    """Motions of one checker, one of which failed.

    Attributes:
        name: Name of the motion, and what was wrong with its verdict.
        kind: Kind of the fault.
        recipe: Robot and scene; None for a failure without a draw.
        motions: The one that failed comes first.
        tolerance: Tolerance of the verdict, m.
    """

    name: str
    kind: str
    recipe: Recipe | None
    motions: Motions | None
    tolerance: float

    def save(self, path: Path) -> None:
        """Writes the case as JSON; doubles are read back as the same bits."""
        motions = None if self.motions is None else {k: v.tolist() for k, v in self.motions._asdict().items()}
        content = {"name": self.name, "kind": self.kind, "recipe": self.recipe, "motions": motions}
        path.write_text(json.dumps({**content, "tolerance": self.tolerance}))

    @staticmethod
    def load(path: Path) -> MotionCase:
        """Reads a case."""
        try:
            return MotionCase._of_document(json.loads(path.read_text(encoding="utf-8")))
        except (*BROKEN_FILE, AttributeError) as error:  # the last for motions that are no mapping
            told = f"{error!s:.200}" if isinstance(error, OSError | ValueError) else "`stress --cases` writes them"
            reason = kind_of(path) or told
            raise PlannercheckError(f"file {str(path)!r} is no case of a motion: {reason}") from None

    @staticmethod
    def _of_document(content: dict[str, Any]) -> MotionCase:
        motions = content["motions"]
        if motions is not None:
            motions = Motions(**{k: np.array(v) for k, v in motions.items()})
        return MotionCase(content["name"], content["kind"], content["recipe"], motions, content["tolerance"])

    def fails(self, seeds: int = 3) -> bool:
        """Whether a fault of the same kind is found again, by new checkers and one of some orders."""
        return any(self.kind in self.faults(seed) for seed in range(seeds))

    def faults(self, seed: int = 0) -> dict[str, str]:
        """What is wrong, by kind."""
        if self.recipe is None or self.motions is None:
            return {}
        recipe = self.recipe
        draw = Draw("case", recipe, self.motions, self.tolerance)
        try:
            judged = judge(draw, lambda: subject_of(recipe), np.random.default_rng(seed))
        except Exception as error:
            return {"exception": repr(error)}
        return {fault.kind: fault.what for fault in judged.faults}


def case_of(name: str, draw: Draw | None, fault: Fault) -> MotionCase:
    """The case of a fault, its motion first."""
    if draw is None:
        return MotionCase(name, fault.kind, None, None, 0.0)
    row = max(fault.row, 0)
    order = np.array([row, *range(row), *range(row + 1, len(draw.motions.at))])
    return MotionCase(name, fault.kind, draw.recipe, draw.motions.of(order), draw.tolerance)


def shrunk(case: MotionCase) -> MotionCase:
    """A case that still fails with as few motions and obstacles as it can do with.

    Without an obstacle nothing is in contact with it by construction: so obstacles are dropped only where the case
    fails by what is seen, not by what was built.
    """
    if case.motions is None or not case.fails():
        return case
    motions = case.motions
    seen = replace(case, motions=motions._replace(touching=np.zeros_like(motions.touching)))
    if not seen.fails():
        return _with_fewer_motions(case)
    return _with_fewer_obstacles(_with_fewer_motions(seen))


def _with_fewer_motions(case: MotionCase) -> MotionCase:
    assert case.motions is not None
    motions = case.motions
    kept = _fewer(
        len(motions.at), lambda rows: replace(case, motions=motions.of(np.array(rows, dtype=np.int64))).fails()
    )
    return replace(case, motions=motions.of(np.array(kept, dtype=np.int64)))


def _with_fewer_obstacles(case: MotionCase) -> MotionCase:
    assert case.recipe is not None
    recipe: Any = case.recipe
    obstacles = recipe["obstacles"]

    def with_some(rows: list[int]) -> MotionCase:
        smaller: Any = {**recipe, "obstacles": [obstacles[k] for k in rows]}
        return replace(case, recipe=smaller)

    # The first motion may need none at all.
    if with_some([]).fails():
        return with_some([])
    return with_some(_fewer(len(obstacles), lambda rows: with_some(rows).fails()))


def _fewer(count: int, fails: Callable[[list[int]], bool]) -> list[int]:
    """Numbers below a count, as few as still fail: runs of them are dropped, half of them at first."""
    kept = list(range(count))
    size = count
    while size >= 1:
        first = 0
        while first < len(kept):
            fewer = kept[:first] + kept[first + size :]
            if fewer and fails(fewer):
                kept = fewer
            else:
                first += size
        size //= 2
    return kept
