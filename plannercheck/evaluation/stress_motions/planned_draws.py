"""Motions of RRT-Connect among solids, and how many of them hulls or convex pieces would have refused.

In: a family's name, a random generator; or a draw with its answers. Out: a `Draw` of motions that the planner's checker
called free; counts. A problem is between two valid states, or the scene's own. The planner stops after a number of
rounds, not of seconds, so that every run gives the same motions.
"""

from __future__ import annotations

import itertools
from functools import lru_cache

import numpy as np
from ompl import base, geometric

from plannercheck.common.array_types import Floats
from plannercheck.evaluation.stress_motions.aims import Motions
from plannercheck.evaluation.stress_motions.draws import Draw, shipped_robot
from plannercheck.evaluation.stress_motions.outcomes import FREE, Answers, Judged
from plannercheck.evaluation.stress_motions.recipes import space_checker
from plannercheck.evaluation.stress_motions.solid_draws import (
    SETTINGS,
    SOLID_MOTIONS,
    SolidStage,
    free_states,
    stage_of,
)
from plannercheck.motions.certifier import DEFAULT_TOLERANCE
from plannercheck.motions.checker import Checker
from plannercheck.ompl import setup as ompl_setup
from plannercheck.ompl import space_of
from plannercheck.ompl.planning import OMPL_SILENCE, seed_ompl
from plannercheck.ompl.pose_bounds import default_bounds
from plannercheck.ompl.pose_parts import has_free_bodies
from plannercheck.robots.link_geometry import GeometryKind

PREFIX = "planned "
PLANNED = tuple(PREFIX + setting for setting in SETTINGS)
# Rounds of a search, and problems of a draw; a tree in a narrow place grows for all of the rounds.
_ROUNDS, _PROBLEMS = 300, 12
# The planner's longest motion in a puzzle: longer ones seldom get through.
_NARROW_RANGE = 0.3
_SEEDS = 2**31


def planned_draw(family: str, rng: np.random.Generator) -> Draw:
    """Motions of the trees of some searches in a setting; the family is PREFIX and its name."""
    setting = family.removeprefix(PREFIX)
    stage = stage_of(setting, SETTINGS[setting].paths[-1])
    found = np.concatenate([_motions(stage, rng) for _ in range(_PROBLEMS)])
    chosen = found[rng.permutation(len(found))[:SOLID_MOTIONS]]
    q0, q1, n = chosen[:, 0], chosen[:, 1], len(chosen)
    motions = Motions(q0, q1, np.zeros(n), q0, np.zeros(n, dtype=bool))
    return Draw(family, stage.recipe, motions, DEFAULT_TOLERANCE)


def refused_by_others(draw: Draw, answers: Answers, judged: Judged, pieces: bool = False) -> None:
    """Counts free motions of a planner, and of them those that hulls refuse, and on request convex pieces."""
    free = answers == FREE
    q0, q1 = draw.motions.q0[free], draw.motions.q1[free]
    judged.counts["planned"] += int(free.sum())
    assert draw.recipe["kind"] == "space"
    kinds: tuple[GeometryKind, ...] = ("hull", "pieces") if pieces else ("hull",)
    for kind in kinds:
        checker = _other(draw.family.removeprefix(PREFIX), kind)
        passed = checker.check_motions(q0, q1, tolerance=draw.tolerance, path=draw.recipe["path"])
        judged.counts[f"refused by {kind}"] += int((~passed).sum())


@lru_cache
def _other(setting: str, kind: GeometryKind) -> Checker:
    """A setting with another geometry, built once."""
    recipe = stage_of(setting, SETTINGS[setting].paths[-1]).recipe.copy()
    recipe["geometry"] = kind
    return space_checker(recipe, shipped_robot(recipe["shipped"], False, kind))


def _motions(stage: SolidStage, rng: np.random.Generator) -> Floats:
    """(k, 2, nq) motions of both trees of a search."""
    checker = stage.checker
    ends = stage.near if len(stage.near) else free_states(stage, rng)[:2]
    bounds = default_bounds(checker, list(ends)) if has_free_bodies(checker.robot) else None
    setup = ompl_setup(checker, tolerance=DEFAULT_TOLERANCE, bounds=bounds)
    space, information = space_of(checker, bounds=bounds), setup.getSpaceInformation()
    given = [space.state(information, q) for q in ends]
    with OMPL_SILENCE():
        seed_ompl(1 + int(rng.integers(_SEEDS)))
        planner = geometric.RRTConnect(information)
        planner.setRange(_NARROW_RANGE if len(stage.near) else 0.0)  # 0 is OMPL's own default
        setup.setPlanner(planner)
        setup.setStartAndGoalStates(*given)
        rounds = itertools.count()
        setup.solve(base.PlannerTerminationCondition(lambda: next(rounds) >= _ROUNDS))
        data = base.PlannerData(information)
        planner.getPlannerData(data)
    nodes = np.array([space.read(data.getVertex(k).getState()) for k in range(data.numVertices())])
    edges = [(k, other) for k in range(data.numVertices()) for other in data.getEdges(k)]
    return nodes[np.array(edges, dtype=np.int64).reshape(-1, 2)]
