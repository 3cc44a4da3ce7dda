"""Searches for a path: a planner of OMPL on a problem, and two planners that take turns.

In: a space that is ready, start and goals. Out: `Search`, which goes on where it has stopped, and `in_turns`.

RRTConnect finds most paths within some hundred iterations, but may miss a narrow passage for long if one tree has to
leave a pocket; LBKPIECE1, which searches along coarse cells and checks motions late, often leaves the pocket at once.
So they take turns, which grow longer. Turns are counted in iterations, not seconds, so that a seed gives one path. A
path that RRTConnect finds in its first turn is found as fast as without turns; a path that only one planner finds takes
at most a few times that planner's time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ompl import base, geometric

from plannercheck.common.array_types import Floats
from plannercheck.common.core import core
from plannercheck.ompl.joint_space import JointSpace
from plannercheck.ompl.near_first import NEAR_FIRST, NearFirst
from plannercheck.ompl.prepared_spaces import PreparedSpace
from plannercheck.ompl.simple_setup import SimpleSetup

# The name of planners that take turns.
AUTO = "auto"

# Who takes turns, and how many iterations for each of the first one's: an iteration of RRTConnect takes 6 to 40 µs, one
# of LBKPIECE1 about 2 µs (MotionBenchMaker's sets for the panda), so both get about the same time.
TURNS = (("RRTConnect", 1), ("LBKPIECE1", 5))

# Iterations of RRTConnect's first turn, within which it finds nine of ten paths of most sets (with 500, paths of the
# set "cage" took twice as long); each later turn takes twice as many, up to the longest one, some tenths of a second.
FIRST_TURN, LONGEST_TURN = 1000, 16000


# These planners have a thread of their own that asks the goal and the termination condition while the planner's caller
# holds Python's lock: whatever it asks must not be Python, nor judge states or motions, or both would wait for ever.
THREADED = ("PRM", "PRMstar")


class Search:
    """A planner at work on a problem in its space, by OMPL's SimpleSetup."""

    def __init__(
        self,
        planner: str,
        prepared: PreparedSpace,
        ends: Sequence[Floats],
        longest_motion: float,
        is_near_first: bool,
    ) -> None:
        """Takes the planner's name, a space, start and goals (nq,) each, the planner's range, and where it samples."""
        self.planner, self.prepared = planner, prepared
        space, information = prepared.space, prepared.information
        self.setup = SimpleSetup(information, not space.is_straight, space.numbers.failure)
        start, *goals = prepared.end_states(ends)
        if len(goals) == 1:
            self.setup.setStartAndGoalStates(start, goals[0])
        else:
            several = base.GoalStates(information)
            for state in goals:
                several.addState(state)
            self.setup.addStartState(start)
            self.setup.setGoal(several)
        self.setup.setPlanner(made_planner(planner, information, longest_motion))
        is_near_first = is_near_first and planner in NEAR_FIRST
        self._goals_ahead = len(goals) - 1 if planner in THREADED else 0
        self._near = NearFirst(space, ends) if is_near_first and isinstance(space, JointSpace) else None

    def go_on(self, condition: Any, iterations: int | None = None) -> Any:
        """Searches until OMPL's condition holds, for some iterations at most; returns OMPL's status."""
        self._take_goals(condition)
        if self._near is not None:
            return self._near.go_on(self.setup, condition, iterations)
        if iterations is not None:
            limit = base.PlannerTerminationCondition(core.call_limit(iterations))
            condition = base.plannerOrTerminationCondition(limit, condition)
        return self.setup.solve(condition)

    def _take_goals(self, condition: Any) -> None:
        """Has a planner with a thread of its own take all goals but one: each search takes one before it begins.

        The search proper takes the last one, so that its thread finds none left that it would judge and connect.
        """
        while self._goals_ahead and not condition.eval():
            self.setup.solve(base.timedPlannerTerminationCondition(0.0))
            self.setup.getProblemDefinition().clearSolutionPaths()  # paths towards a goal
            self._goals_ahead -= 1

    @property
    def has_found(self) -> bool:
        """Whether there is a path."""
        return bool(self.setup.haveExactSolutionPath())


def in_turns(made: Callable[[str], Search], condition: Any) -> tuple[Search, Any]:
    """Has the planners of `TURNS` take turns until one has found a path, or OMPL's termination condition holds.

    `made` makes the search of a planner when its first turn comes. Returns the search that was on last, and its status.
    """
    searches: dict[str, Search] = {}
    turn = FIRST_TURN
    while True:
        for name, factor in TURNS:
            if name not in searches:
                searches[name] = made(name)
            status = searches[name].go_on(condition, factor * turn)
            if searches[name].has_found or condition.eval():
                return searches[name], status
        turn = min(2 * turn, LONGEST_TURN)


def made_planner(name: str, information: Any, longest_motion: float) -> Any:
    """One of `planner_names()`, with a range if it has one."""
    planner = getattr(geometric, name)(information)
    if longest_motion and hasattr(planner, "setRange"):
        planner.setRange(longest_motion)
    return planner
