"""The checker behind any recipe of the motion stress.

In: a recipe. Out: its `Subject`.
"""

from __future__ import annotations

from typing import Any

from plannercheck.evaluation.stress_motions.cell_subject import CellSubject
from plannercheck.evaluation.stress_motions.recipes import Recipe, is_curved
from plannercheck.evaluation.stress_motions.subjects import CurveSubject, PlaneSubject, SpaceSubject, Subject


def subject_of(recipe: Recipe, robot: Any = None) -> Subject:
    """A subject with a new checker; `robot` if it was built already."""
    if recipe["kind"] == "plane":
        return PlaneSubject(recipe, robot)
    if recipe["kind"] == "cell":
        return CellSubject(recipe, robot)
    return CurveSubject(recipe, robot) if is_curved(recipe) else SpaceSubject(recipe, robot)
