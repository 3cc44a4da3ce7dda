"""The planners of `bench plans`: RRTConnect on proved motions, RRTConnect on coal's samples, and VAMP's RRT-Connect.

In: a task. Out: `Planner`s, made once a task, that search with a seed. The first two are RRTConnect of the same OMPL on
the same space with the same range and the same samples (near_first.py):

- plannercheck: `pc.ompl.setup(checker)`, every motion proved free; and all of `pc.ompl.plan`, from arguments to plan,
  with its default planner, whose first turn is the same search;
- Pinocchio + coal: a validity checker in Python that calls Pinocchio's computeCollisions with coal's dynamic AABB tree
  over the same hulls and pairs, stopping at the first collision; OMPL's own DiscreteMotionValidator at its default
  resolution of 1 % of the space's extent.

VAMP's RRT-Connect is its own, in C++ and floats, with its own range, and samples 32 states a rad of its balls.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from ompl import base, geometric

from plannercheck.common.array_types import Floats
from plannercheck.evaluation.bench.other_libraries import CoalQuery
from plannercheck.evaluation.bench.problems import Task
from plannercheck.evaluation.bench.vamp_model import VampModel
from plannercheck.motions.checker import Checker
from plannercheck.ompl import plan as ompl_plan
from plannercheck.ompl import setup as ompl_setup
from plannercheck.ompl.joint_space import JointSpace
from plannercheck.ompl.near_first import solve_near_first
from plannercheck.ompl.planning import OMPL_SILENCE, seed_ompl


class Settings(NamedTuple):
    """How planners of OMPL search: the longest motion of a tree, and the time limit of a search, s."""

    longest: float
    limit: float


class Found(NamedTuple):
    """What a search found.

    Attributes:
        search: Seconds of processor time of the search alone; VAMP's by its own clock.
        call: Seconds of all that a user calls; None where that is timed by another planner.
        path: (k, nq) rad; None if it found none.
    """

    search: float
    call: float | None
    path: Floats | None


Planner = Callable[[int], Found]


class CoalTree:
    """Whether a state is free, by Pinocchio and coal, with as little Python as there can be."""

    def __init__(self, checker: Checker) -> None:
        """Makes the tree."""
        robot, self._query = checker.robot, CoalQuery(checker)
        self._full = np.array(robot.expand(np.zeros(robot.nq)))
        moved = [np.flatnonzero(np.array(robot.expand(row)) != self._full) for row in np.eye(robot.nq)]
        assert all(len(entries) == 1 for entries in moved)  # one number a joint, none that follows another
        self._columns = np.concatenate(moved)
        self._nq = robot.nq

    def __call__(self, state: Any) -> bool:
        """The verdict on an OMPL state."""
        self._full[self._columns] = [state[k] for k in range(self._nq)]
        return not self._query.ask(self._full, True)


def _plannercheck(task: Task, settings: Settings) -> Planner:
    """The search and the whole call are runs of their own: both begin from the same seed."""
    checker, space = task.checker, JointSpace(task.checker.robot)

    def search(seed: int) -> Found:
        found = _searched(ompl_setup(checker), space, task, settings, seed)
        began = time.process_time()
        ompl_plan(
            checker,
            task.start,
            task.goal,
            time_limit=settings.limit,
            simplify=False,
            seed=seed,
            longest_motion=settings.longest,
        )
        return found._replace(call=time.process_time() - began)

    return search


def _coal(task: Task, settings: Settings) -> Planner:
    judge, space = CoalTree(task.checker), JointSpace(task.checker.robot)

    def search(seed: int) -> Found:
        setup = geometric.SimpleSetup(space.ompl_space())
        setup.setStateValidityChecker(judge)
        return _searched(setup, space, task, settings, seed)

    return search


def _searched(setup: Any, space: JointSpace, task: Task, settings: Settings, seed: int) -> Found:
    information = setup.getSpaceInformation()
    with OMPL_SILENCE():
        seed_ompl(seed)
        setup.setStartAndGoalStates(space.state(information, task.start), space.state(information, task.goal))
        planner = geometric.RRTConnect(information)
        planner.setRange(settings.longest)
        setup.setPlanner(planner)
        condition = base.timedPlannerTerminationCondition(settings.limit)
        setup.setup()  # once a space and planner, as `plan` has it: a search begins with it otherwise
        began = time.process_time()
        solve_near_first(setup, space, (task.start, task.goal), condition)
        spent = time.process_time() - began
    if not setup.haveExactSolutionPath():
        return Found(spent, None, None)
    return Found(spent, None, np.array([space.read(state) for state in setup.getSolutionPath().getStates()]))


def _vamp(task: Task, settings: Settings) -> Planner:
    model = VampModel(task.checker)

    def search(seed: int) -> Found:
        plan = model.search(task.start, task.goal, seed)
        began = time.process_time()
        found = plan()
        return Found(found.seconds, time.process_time() - began, found.path)

    return search


OURS = "plannercheck"
PLANNERS: Sequence[tuple[str, Callable[[Task, Settings], Planner]]] = (
    (OURS, _plannercheck),
    ("Pinocchio + coal", _coal),
    ("VAMP", _vamp),
)
