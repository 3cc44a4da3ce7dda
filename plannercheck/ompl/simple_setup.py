"""OMPL's SimpleSetup, which also checks simplified paths and refuses planners that do not fit the space.

In: an OMPL space. Out: `SimpleSetup`, used as OMPL's own.

An instance of a user's class, such as a goal, may refer to the program's variables, the set-up among them. The set-up
refers to the goal through C++, which Python's garbage collector does not see, so none of them would ever be freed. So
at the end of the program, set-ups drop all objects that may be of a user's class.
"""

from __future__ import annotations

import atexit
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any
from weakref import WeakSet

from ompl import base, geometric, util

from plannercheck.common.errors import PlannercheckError

# These planners sample where a shorter path may be, which OMPL's PathLengthDirectInfSampler can't do in all spaces; its
# error for such a space begins like this.
INFORMED_PLANNERS = ("AORRTC", "BITstar", "InformedRRTstar", "SORRTstar")
_NO_SAMPLER = "PathLengthDirectInfSampler only supports"

# Compound spaces that it supports.
_SERVED = (base.SE2StateSpace, base.SE3StateSpace)


class SimpleSetup(geometric.SimpleSetup):  # type: ignore[misc]  # OMPL's bindings are untyped
    """OMPL's SimpleSetup; only the differences are documented here."""

    def __init__(self, information: Any, checks_found_paths: bool = False, failure: Any = None) -> None:
        """Takes OMPL's SpaceInformation, and whether a motion that is free may collide the other way round.

        `failure` is the core's PlannerFailure of the validators; without it, exceptions pass through the planner.
        """
        super().__init__(information)
        self._failure = failure
        self.checks_found_paths = checks_found_paths
        self.refused_path = False  # that was found last
        _MADE.add(self)

    def solve(self, *arguments: Any, **named: Any) -> Any:
        """Solves the problem; a path that begins elsewhere, or of curves with a motion that collides, is none.

        Planners that grow from both ends, or keep roadmaps, check a curve one way and go it the other way, where a
        Reeds-Shepp curve may be another one. Where the start sees a goal, some of `INFORMED_PLANNERS` (OMPL 2.0.1)
        never return, raise an error or lose the start; they get the motion to that goal, than which none is shorter.

        Raises:
            PlannercheckError: If the planner can't plan in this space.
        """
        space = self.getStateSpace()
        if isinstance(self.getPlanner(), geometric.AORRTC) and not space.hasSymmetricDistance():
            self.setup()  # its destructor needs that
            raise PlannercheckError(
                "AORRTC can't plan where the way back has another length, as on Dubins curves: OMPL's own code crashes "
                "there; RRTstar and BITstar look for short paths as well"
            )
        self.refused_path, problem = False, self.getProblemDefinition()
        try:
            seen = self._seen_goal()
            if seen is not None:
                problem.addSolutionPath(seen)
                return base.PlannerStatus(base.PlannerStatus.EXACT_SOLUTION)
            status = self._solved(*arguments, **named)
            if self.haveExactSolutionPath() and not (
                problem.hasStartState(self.getSolutionPath().getState(0), 0)
                and (not self.checks_found_paths or self.getSolutionPath().check())
            ):
                problem.clearSolutionPaths()
                self.refused_path = True
                return base.PlannerStatus(base.PlannerStatus.TIMEOUT)
            return status
        except RuntimeError as error:  # once the planner is set up: AORRTC's destructor needs that
            if not str(error).startswith(_NO_SAMPLER):
                raise
        raise PlannercheckError(
            f"{type(self.getPlanner()).__name__} can't plan in this space: of OMPL's planners "
            f"{', '.join(INFORMED_PLANNERS)} serve bounded joints and planar robots without joints, "
            "all others serve every space (RRTstar and PRMstar look for short paths, too)"
        )

    def _seen_goal(self) -> Any:
        """The motion to a goal that the start sees, if an informed planner looks for the shortest path; else None."""
        space = self.getStateSpace()
        is_served = isinstance(space, _SERVED) or not isinstance(space, base.CompoundStateSpace)
        if type(self.getPlanner()).__name__ not in INFORMED_PLANNERS or not is_served:
            return None
        self.setup()
        problem = self.getProblemDefinition()
        is_length = isinstance(problem.getOptimizationObjective(), base.PathLengthOptimizationObjective)
        return problem.isStraightLinePathValid() if is_length else None

    def _solved(self, *arguments: Any, **named: Any) -> Any:
        """OMPL's `solve`, ended by the first exception of a validator, which is raised when the planner has ended."""
        if self._failure is None:
            return super().solve(*arguments, **named)
        condition: Any = next(iter((*arguments, *named.values())), 1.0)  # OMPL's default, s
        if not isinstance(condition, base.PlannerTerminationCondition):
            condition = base.timedPlannerTerminationCondition(float(condition))
        self._failure.arm(condition.terminate)
        try:
            status = super().solve(condition)
        finally:
            error = self._failure.disarm()
        if error is not None:
            raise error
        return status

    @contextmanager
    def remembered_motions(self) -> Iterator[None]:
        """A context within which the answers on motions are remembered: what shortens a path asks for many again."""
        if self._failure is None:
            yield
            return
        self._failure.remember()
        try:
            yield
        finally:
            self._failure.forget()

    def simplifySolution(self, *arguments: Any, **named: Any) -> None:  # noqa: N802  # OMPL's name
        """Simplifies the found path; keeps it unchanged if a motion of the simpler one collides."""
        if not self.haveSolutionPath():
            super().simplifySolution(*arguments, **named)
            return
        path = self.getSolutionPath()
        found = geometric.PathGeometric(path)
        with self.remembered_motions():
            super().simplifySolution(*arguments, **named)
            if not path.check():  # OMPL only warns
                path.assign(found)


_MADE: WeakSet[SimpleSetup] = WeakSet()


class _NoMotions(base.MotionValidator):  # type: ignore[misc]  # OMPL's bindings are untyped
    """Takes the place of the program's own validator."""


@atexit.register
def _let_go() -> None:
    """Puts OMPL's own goals, validators, samplers and objectives in place of the program's own."""
    util.setLogLevel(util.LOG_NONE)  # planners that are set up twice would print warnings
    for setup in list(_MADE):
        information = setup.getSpaceInformation()
        setup.getProblemDefinition().clearSolutionPaths()
        setup.setGoal(base.GoalStates(information))
        setup.setOptimizationObjective(base.PathLengthOptimizationObjective(information))
        setup.setStateValidityChecker(base.AllValidStateValidityChecker(information))
        information.setMotionValidator(_NoMotions(information))
        information.setValidStateSamplerAllocator(base.UniformValidStateSampler)
        _renew(setup.getPlanner())


def _renew(planner: Any) -> None:
    """Makes a planner of OMPL's forget the objective and the samplers that it took at its last search."""
    if planner is not None and type(planner).__module__.startswith("ompl."):
        planner.clear()
        with suppress(RuntimeError):  # some need a goal first
            planner.setup()
