"""Which states only hulls refuse, and whether verdicts of solids agree with coal's meshes.

In: a robot's name, a number of random states. Out: shares of valid states by hulls and by meshes, and every pair in
every state on which ours and coal differ, sorted by reason. coal's meshes are surfaces, so coal calls a body inside
another one free; such pairs are counted separately, as are pairs nearer to contact than `NEAR`, because coal computes
in doubles.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np

from plannercheck.bodies.distance import distance
from plannercheck.bodies.solids import Solid
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.progress import report, reported
from plannercheck.evaluation.bench.coal_loop import CoalLoop, Variant
from plannercheck.evaluation.bench.other_libraries import coal_shape
from plannercheck.evaluation.bench.solid_checkers import (
    checker_of_meshes,
    checker_of_triangles,
    has_solids,
    is_nested,
    posed_pair,
    with_hulls,
)
from plannercheck.motions.checker import Checker

# m.
NEAR = 1e-4
# How coal is asked: plain GJK, a fixed guess, and boxes along the world's axes first.
_VARIANT = Variant(0, 0, 1)
# States whose poses are held at once.
_BLOCK = 1024

# What open meshes are taken as; closed ones are what they are.
CAPPED, TRIANGLES, HULLS = "open ones capped", "open ones as triangles", "open ones as hulls"


@dataclass(frozen=True)
class FidelityRow:
    """What hulls and meshes say of random states of one robot.

    Attributes:
        robot: Its name.
        geometry: What open meshes are taken as: `CAPPED`, as geometry="solid" loads them, `TRIANGLES` or `HULLS`.
        solids: Bodies that are not tested as hulls.
        open_meshes: Bodies whose meshes are open.
        states: Number of states.
        valid_hulls: Part of them that is valid by hulls.
        valid: Part of them that is valid by meshes.
        filling: Part of them that hulls refuse, and meshes do not.
        inside: Pairs in states in which one body is inside the other.
        refused_apart: Pairs that we refuse, although coal's surfaces are further apart than `NEAR` and no body is
            inside the other.
        missed: Pairs that we call free, although coal's surfaces meet and ours are further apart than `NEAR`.
        near: Pairs on which we differ otherwise: nearer than `NEAR` to contact.
        refused_by_both: Pairs in states that ours and coal refuse.
    """

    robot: str
    geometry: str
    solids: int
    open_meshes: int
    states: int
    valid_hulls: float
    valid: float
    filling: float
    inside: int
    refused_apart: int
    missed: int
    near: int
    refused_by_both: int


def measure(robot: str, states: int, seed: int) -> list[FidelityRow]:
    """Judges random states of a robot, by name or file, by its hulls, its meshes, and coal.

    A row for meshes as solids; if some are open, one more for each other way to take these.

    Raises:
        PlannercheckError: If there is no compiler for the loop around coal.
    """
    with reported(f"preparing the meshes of {robot}"):
        checker = checker_of_meshes(robot)
        q = checker.robot.random_configurations(states, seed)
        by_hulls = with_hulls(checker).check_states(q)
    rows = [_row(checker, CAPPED, q, by_hulls)]
    if has_solids(checker, open_only=True):
        rows.append(_row(checker_of_triangles(robot), TRIANGLES, q, by_hulls))
        rows.append(_row(with_hulls(checker, open_only=True), HULLS, q, by_hulls))
    return rows


def _row(checker: Checker, geometry: str, q: Floats, by_hulls: Bools) -> FidelityRow:
    valid, counted = checker.check_states(q), _held_against_coal(checker, q)
    shapes = [body.shape for body in checker.bodies]
    return FidelityRow(
        checker.robot.name,
        geometry,
        sum(polytope is not None and polytope.solid is not None for polytope in checker.polytopes),
        sum(isinstance(shape, Solid) and shape.is_open for shape in shapes),
        len(q),
        float(by_hulls.mean()),
        float(valid.mean()),
        float((valid & ~by_hulls).mean()),
        counted["inside"],
        counted["refused apart"],
        counted["missed"],
        counted["near"],
        counted["both"],
    )


def _held_against_coal(checker: Checker, q: Floats) -> Counter[str]:
    """Pairs in states by what we and coal say of them, where one of both refuses them."""
    loop, counted, shapes = CoalLoop.of_checker(checker), Counter[str](), dict[int, Any]()
    what = f"states of {checker.robot.name} against coal"
    for number, block in enumerate(np.array_split(q, range(_BLOCK, len(q), _BLOCK))):
        report(number * _BLOCK, len(q), what)
        ours, poses = checker.colliding_pairs(block), checker.body_poses(block)
        coals = loop.check_pairs(loop.states(block), _VARIANT)
        counted["both"] += int((ours & coals).sum())
        for state, pair in np.argwhere(ours != coals).tolist():
            counted[_reason(checker, pair, poses[state], bool(ours[state, pair]), shapes)] += 1
    report(len(q), len(q), what)
    return counted


def _reason(checker: Checker, pair: int, poses: Floats, we_refuse: bool, shapes: dict[int, Any]) -> str:
    posed = posed_pair(checker, pair, poses)
    if not we_refuse:
        return "near" if distance(*posed).distance <= NEAR else "missed"
    if is_nested(*posed):
        return "inside"
    return "near" if _coals_distance(checker, pair, poses, shapes) <= NEAR else "refused apart"


def _coals_distance(checker: Checker, pair: int, poses: Floats, shapes: dict[int, Any]) -> float:
    """How far coal's surfaces are apart, m."""
    import coal

    given = []
    for k in checker.pairs[pair].tolist():
        if k not in shapes:
            polytope = checker.polytopes[k]
            assert polytope is not None
            shapes[k] = coal_shape(checker.bodies[k], polytope)
        given += [shapes[k], coal.Transform3s(poses[k][:3, :3], poses[k][:3, 3])]
    return float(coal.distance(*given, coal.DistanceRequest(), coal.DistanceResult()))
