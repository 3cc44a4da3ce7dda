"""The cost of a robot's meshes as solids: the same work with its hulls and with its solids, by turns.

In: a robot's name, a number of random states. Out: a row for each kind of work: states in a batch, one by one, with a
padding, and motions. Where meshes are convex up to shallow dents, both should take the same time.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.evaluation.bench.timing import Contender, measured
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot

# m.
_PADDING = 0.005
# rad; a planner's range.
_LENGTH = 0.5
_HULLS, _SOLIDS = "hulls", "solids"


@dataclass(frozen=True)
class SolidCostRow:
    """One kind of work with one robot.

    Attributes:
        robot: Its name.
        work: What is timed.
        count: How many states or motions.
        of_hulls: µs each by the robot's hulls.
        of_solids: µs each by its solids.
        ratio: The second over the first.
        noise: How many times longer the same code took when it ran twice: a smaller ratio says nothing.
        differ: Verdicts that differ: what only the filling of hulls refuses.
        dented: Solids that are their hulls but for shallow dents.
        concave: Other solids that are not their hulls.
        deepest: The deepest of the shallow dents, as a part of the distance from the hull's centre.
    """

    robot: str
    work: str
    count: int
    of_hulls: float
    of_solids: float
    ratio: float
    noise: float
    differ: int
    dented: int
    concave: int
    deepest: float


def measure(name: str, states: int, seed: int, rounds: int) -> list[SolidCostRow]:
    """Times a robot's hulls and its solids: a row for each kind of work, random states and a sixth as many motions."""
    robots = _robots(name)
    checkers = {geometry: Checker(robot) for geometry, robot in robots.items()}
    padded = {geometry: Checker(robot, padding=_PADDING) for geometry, robot in robots.items()}
    q = robots[_HULLS].random_configurations(states, seed)
    starts, ends = _motions(checkers[_HULLS], q, max(1, states // 6), seed)
    works: dict[str, tuple[dict[str, Checker], int, Callable[[Checker], Bools]]] = {
        "states, in a batch": (checkers, len(q), lambda checker: checker.check_states(q)),
        "states, one by one": (checkers, len(q), lambda checker: np.array([checker.is_valid(row) for row in q])),
        f"states, padding {_PADDING:g} m": (padded, len(q), lambda checker: checker.check_states(q)),
        f"motions, {_LENGTH:g} rad": (checkers, len(starts), lambda checker: checker.check_motions(starts, ends)),
    }
    dents = [p.core.dent for p in checkers[_SOLIDS].polytopes if p is not None and p.solid is not None]
    known = [dent for dent in dents if dent < np.inf]
    rows = []
    for work, (contenders, count, judge) in works.items():
        verdicts = {geometry: judge(checker) for geometry, checker in contenders.items()}
        timed = {geometry: Contender([partial(judge, checker)], count) for geometry, checker in contenders.items()}
        times = measured(timed, rounds)
        of_hulls, of_solids = (1e6 * times.seconds[geometry] for geometry in (_HULLS, _SOLIDS))
        spent = of_hulls, of_solids, of_solids / of_hulls, times.noise(_HULLS, _SOLIDS)
        differ = int((verdicts[_HULLS] != verdicts[_SOLIDS]).sum())
        found = (len(known), len(dents) - len(known), max(known, default=0.0))
        rows.append(SolidCostRow(robots[_HULLS].name, work, count, *spent, differ, *found))
    return rows


def _robots(name: str) -> dict[str, Robot]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of open meshes
        return {_HULLS: Robot.load(name), _SOLIDS: Robot.load(name, geometry="solid")}


def _motions(checker: Checker, q: Floats, count: int, seed: int) -> tuple[Floats, Floats]:
    """From valid states in random directions, within the limits."""
    starts = q[checker.check_states(q)][:count]
    ways = np.random.default_rng(seed).normal(size=starts.shape)
    ways *= _LENGTH / np.linalg.norm(ways, axis=1)[:, None]
    return starts, np.clip(starts + ways, checker.robot.lower, checker.robot.upper)
