"""Motions to measure with: random ones of one length, and those that OMPL's RRTConnect asks for.

In: checkers; problems. Out: `MotionSet`s. Random motions begin at a valid state and go in a random direction. Recorded
motions are a planner's queries: most are as long as its range, and many end in an obstacle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from ompl import base, geometric

from plannercheck.common.array_types import Floats
from plannercheck.evaluation.bench.problems import Task
from plannercheck.motions.checker import Checker
from plannercheck.ompl import setup as ompl_setup
from plannercheck.ompl.joint_space import JointSpace
from plannercheck.ompl.planning import OMPL_SILENCE, seed_ompl

# Draws for random motions, of as many as are wanted each, until a set is given up: in a near-empty scene few collide.
_MOST_DRAWS = 40
# Searches of a problem, each with another seed, until enough motions are recorded.
_MOST_SEARCHES = 20
# Seconds that a recorded search may take.
_LIMIT = 10.0
# States of each motion that `along_motions` makes, about as far apart as a planner's.
_STATES_A_MOTION = 64


class MotionCase(NamedTuple):
    """Motions of one robot in one scene, from starts (n, nq) to ends (n, nq), rad; the checker is the exact one."""

    checker: Checker
    starts: Floats
    ends: Floats

    def first(self, n: int) -> MotionCase:
        """At most so many of the motions."""
        return MotionCase(self.checker, self.starts[:n], self.ends[:n])


@dataclass(frozen=True)
class MotionSet:
    """Motions of one kind, e.g. "0.4 rad, free", in a scene or a problem set, scene by scene."""

    where: str
    kind: str
    cases: Sequence[MotionCase]

    def first(self, n: int) -> Sequence[MotionCase]:
        """The cases with at most about so many motions in all, as many of each."""
        return [case.first(-(-n // len(self.cases))) for case in self.cases]


def along_motions(random: Floats) -> Floats:
    """As many states on straight motions between random ones (n, nq)."""
    motions = max(1, len(random) // _STATES_A_MOTION)
    t = np.linspace(0, 1, _STATES_A_MOTION)[:, None]
    ends = zip(random[:motions], random[::-1][:motions], strict=True)
    return np.concatenate([(1 - t) * start + t * end for start, end in ends])[: len(random)]


def random_sets(checker: Checker, where: str, length: float, n: int, seed: int) -> list[MotionSet]:
    """Random motions of one length, rad, free ones and colliding ones apart; n of each, fewer where they are rare."""
    rng = np.random.default_rng(seed)
    found: dict[bool, list[tuple[Floats, Floats]]] = {True: [], False: []}
    for _ in range(_MOST_DRAWS):
        starts, ends = random_motions(checker, length, n, rng)
        free = checker.check_motions(starts, ends)
        for verdict, parts in found.items():
            parts.append((starts[free == verdict], ends[free == verdict]))
        if all(sum(len(part[0]) for part in parts) >= n for parts in found.values()):
            break
    names = {True: "free", False: "colliding"}
    sets = []
    for verdict, parts in found.items():
        case = MotionCase(checker, *(np.concatenate(arrays)[:n] for arrays in zip(*parts, strict=True)))
        if len(case.starts):
            sets.append(MotionSet(where, f"{length:g} rad, {names[verdict]}", [case]))
    return sets


def random_motions(checker: Checker, length: float, n: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """At most n random motions of a length, rad, from valid states to states within the limits: (k, nq) each."""
    robot = checker.robot
    starts = robot.random_configurations(n, rng)
    starts = starts[checker.check_states(starts)]
    way = rng.normal(size=starts.shape)
    ends = starts + length * way / np.linalg.norm(way, axis=1)[:, None]
    inside = ((ends >= robot.lower) & (ends <= robot.upper)).all(axis=1)
    return starts[inside], ends[inside]


def recorded_set(where: str, tasks: Sequence[Task], longest: float, n: int) -> MotionSet:
    """The motions that RRTConnect asks for on the problems of a set, at least one, with a range of `longest`, rad.

    They are `n` in all, as many of each problem, which is searched with several seeds for that.
    """
    each = -(-n // len(tasks))
    cases = []
    for task in tasks:
        asked: list[tuple[list[float], list[float]]] = []
        for seed in range(1, 1 + _MOST_SEARCHES):
            asked += _asked(task, longest, seed)
            if len(asked) >= each:
                break
        starts, ends = (np.array([motion[k] for motion in asked[:each]]) for k in (0, 1))
        cases.append(MotionCase(task.checker, starts, ends))
    return MotionSet(where, f"RRTConnect, range {longest:g} rad", cases)


def _asked(task: Task, longest: float, seed: int) -> list[tuple[list[float], list[float]]]:
    """Both ends of each motion, in the order in which a search asks for them."""
    checker, space = task.checker, JointSpace(task.checker.robot)
    with OMPL_SILENCE():
        seed_ompl(seed)
        setup = ompl_setup(checker)
        information = setup.getSpaceInformation()
        recorder = _Recorder(information, checker, space)
        information.setMotionValidator(recorder)
        planner = geometric.RRTConnect(information)
        planner.setRange(longest)
        setup.setPlanner(planner)
        setup.setStartAndGoalStates(*(space.state(information, q) for q in (task.start, task.goal)))
        setup.solve(base.timedPlannerTerminationCondition(_LIMIT))
    return recorder.asked


class _Recorder(base.MotionValidator):  # type: ignore[misc]  # OMPL's bindings are untyped
    """Proves motions as `plannercheck.ompl.setup` does, and keeps what was asked."""

    def __init__(self, information: Any, checker: Checker, space: JointSpace) -> None:
        super().__init__(information)
        self._checker, self._space = checker, space
        self.asked: list[tuple[list[float], list[float]]] = []

    def checkMotion(self, s1: Any, s2: Any) -> bool:  # noqa: N802  # OMPL's name
        """Whether the motion between two states is free."""
        start, end = self._space.read(s1), self._space.read(s2)
        self.asked.append((start, end))
        return self._checker.check_motion(start, end)
