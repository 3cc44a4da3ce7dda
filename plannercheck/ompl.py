"""Planning with OMPL: a checker as the judge of states and motions.

In: a checker. Out: `setup`, an OMPL SimpleSetup with the robot's joint space and validators, and `plan`,
which runs a planner from a start to a goal.

Bounded joints are real numbers, continuous joints of a planning group are angles (SO2). A motion is proved free by one
call of the checker.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from ompl import base, geometric, util

from plannercheck.certified_motions import DEFAULT_TOLERANCE
from plannercheck.checker import Checker
from plannercheck.end_states import checked_end, judged
from plannercheck.errors import PlannercheckError, unknown_name
from plannercheck.joint_space import JointSpace
from plannercheck.plans import Plan, joint_length
from plannercheck.robot import Robot

Floats = NDArray[np.float64]

# About this long is a found path shortened at most, s: most of the gain comes in the first half second.
SIMPLIFICATION_TIME = 1.0


class MotionValidator(base.MotionValidator):  # type: ignore[misc]  # OMPL's bindings are untyped
    """Judges a motion by one call of the checker.

    The counters are kept here: `SpaceInformation.getCheckedMotionCount` asks OMPL's own, which stay 0.
    """

    def __init__(
        self,
        information: Any,
        checker: Checker,
        space: JointSpace,
        resolution: float | None = None,
        tolerance: float = DEFAULT_TOLERANCE,
    ) -> None:
        """Holds the checker and the joint space, but not the SpaceInformation, which holds this.

        Args:
            information: OMPL's SpaceInformation.
            checker: Who judges motions.
            space: The checker's robot's.
            resolution: None to prove motions free; else to sample them, as for `Checker.check_motion`, m.
            tolerance: As for `Checker.check_motion`, m.
        """
        super().__init__(information)
        self._checker = checker
        self._space = space
        self._resolution = resolution
        self._tolerance = tolerance
        if resolution is None:
            self._is_free = checker.motion_certifier.is_free
        self.resetMotionCounter()

    def checkMotion(self, s1: Any, s2: Any) -> bool:  # noqa: N802  # OMPL's name
        """Whether the motion between two states is free, both ends included."""
        q0, q1 = self._ends(s1, s2)
        if self._resolution is None:
            free = self._is_free(q0, q1, self._tolerance)
        else:
            free = self._checker.check_motion(q0, q1, self._resolution)
        self._count(free)
        return free

    def checkMotionWithLastValid(self, s1: Any, s2: Any, last_valid: Any = None) -> tuple[bool, float]:  # noqa: N802
        """The same, and how far the motion is free.

        Args:
            s1: Start.
            s2: End.
            last_valid: A state that receives the last one known free, or, sampled, the last one before the first
                collision; None for none.

        Returns:
            Whether the motion is free, and the last valid state's place between 0 and 1 (0 also if the start
            collides).
        """
        q0, q1 = (np.array(q) for q in self._ends(s1, s2))
        if self._resolution is None:
            certifier = self._checker.motion_certifier
            passage = certifier.passage(q0, q1, self._tolerance)
            free, last = passage.free, passage.free_until
            state = certifier.states(q0, q1, np.array([last]))[0]
        else:
            free, last, state = self._last_sampled(q0, q1, self._resolution)
        if last_valid is not None:
            self._space.write(last_valid, state)
        self._count(free)
        return free, last

    def _last_sampled(self, q0: Floats, q1: Floats, resolution: float) -> tuple[bool, float, Floats]:
        """Whether all sampled states are valid, and the last one before the first that is not, with its place."""
        sampler = self._checker.motion_sampler
        steps = int(sampler.steps(q0[None], q1[None], resolution)[0])
        fractions = np.arange(steps + 1) / steps
        states = sampler.states(q0, q1, fractions)
        colliding = np.flatnonzero(~self._checker.check_states(states))
        last = steps if len(colliding) == 0 else max(int(colliding[0]) - 1, 0)
        return len(colliding) == 0, float(fractions[last]), states[last]

    def getValidMotionCount(self) -> int:  # noqa: N802
        """Motions found free since the counters were reset."""
        return self._valid

    def getInvalidMotionCount(self) -> int:  # noqa: N802
        """Motions found colliding since the counters were reset."""
        return self._invalid

    def getCheckedMotionCount(self) -> int:  # noqa: N802
        """All motions checked since the counters were reset."""
        return self._valid + self._invalid

    def getValidMotionFraction(self) -> float:  # noqa: N802
        """Free motions as a part of all; 0 if there were none."""
        return self._valid / max(self.getCheckedMotionCount(), 1)

    def resetMotionCounter(self) -> None:  # noqa: N802
        """Sets the counters to 0."""
        self._valid = self._invalid = 0

    def _ends(self, s1: Any, s2: Any) -> tuple[list[float], list[float]]:
        """Both ends; angles of the second on the short way from the first, as OMPL interpolates."""
        q0 = self._space.read(s1)
        return q0, self._space.end(q0, self._space.read(s2))

    def _count(self, free: bool) -> None:
        if free:
            self._valid += 1
        else:
            self._invalid += 1


# Longest motion that a planner tries at once, rad. OMPL's default, a fifth of the space's extent, is 2.6 rad
# for seven joints: most such motions collide, and finding out is wasted.
LONGEST_MOTION = 0.5


def setup(checker: Checker, resolution: float | None = None, tolerance: float = DEFAULT_TOLERANCE) -> Any:
    """Makes an OMPL SimpleSetup for a checker's robot.

    OMPL's messages below warnings are switched off; `ompl.util.setLogLevel` brings them back.

    Args:
        checker: Who judges states and motions.
        resolution: None to prove motions free. Else they are sampled, and no link point moves further than this
            between two checked states, m.
        tolerance: A motion that comes within this of a collision may be refused, m.

    Returns:
        An `ompl.geometric.SimpleSetup` with space, state and motion validators set.

    Raises:
        PlannercheckError: If a joint is neither bounded nor continuous, or takes several numbers.
    """
    if util.getLogLevel().value < util.LOG_WARN.value:
        util.setLogLevel(util.LOG_WARN)
    return _setup(checker, JointSpace(checker.robot), resolution, tolerance)


def _setup(checker: Checker, space: JointSpace, resolution: float | None, tolerance: float) -> Any:
    for name, length in (("resolution", resolution), ("tolerance", tolerance)):
        if length is not None and not (np.isfinite(length) and length > 0):
            raise PlannercheckError(f"{name} must be a positive length in m, not {length!r}")
    setup = geometric.SimpleSetup(space.ompl_space())
    read, is_valid = space.read, checker.is_valid
    setup.setStateValidityChecker(lambda state: is_valid(read(state)))
    information = setup.getSpaceInformation()
    information.setMotionValidator(MotionValidator(information, checker, space, resolution, tolerance))
    return setup


def planner_names() -> list[str]:
    """Names of the planners that OMPL's bindings offer."""
    found = [name for name in dir(geometric) if _is_planner(getattr(geometric, name))]
    return sorted(found)


def _is_planner(item: Any) -> bool:
    return isinstance(item, type) and issubclass(item, base.Planner)


def plan(
    checker: Checker,
    start: ArrayLike,
    goal: ArrayLike,
    planner: str = "RRTConnect",
    time_limit: float = 10.0,
    simplify: bool = True,
    seed: int | None = None,
    resolution: float | None = None,
    longest_motion: float = LONGEST_MOTION,
) -> Plan:
    """Plans from one configuration to another.

    Args:
        checker: Who judges states and motions.
        start: (nq,) rad and m.
        goal: (nq,) rad and m.
        planner: One of `planner_names()`.
        time_limit: For the search, s; shortening comes on top, about `SIMPLIFICATION_TIME`.
        simplify: Whether to shorten the path.
        seed: Of OMPL's random numbers, 1 or more, for a search that can be repeated; None for a different one
            each time.
        resolution: As for `setup`.
        longest_motion: How far a planner with a range extends at once, rad; 0 leaves it to OMPL.

    Returns:
        The plan. If start or goal collide or are beyond the limits, it is unsolved and `reason` says why.
    """
    if planner not in planner_names():
        raise unknown_name("planner", planner, planner_names())
    if not (np.isfinite(time_limit) and time_limit > 0):
        raise PlannercheckError(f"time_limit must be a positive time in s, not {time_limit!r}")
    if not (np.isfinite(longest_motion) and longest_motion >= 0):
        raise PlannercheckError(f"longest_motion must be a length in rad or 0, not {longest_motion!r}")
    ends = {name: checked_end(checker, q, name) for name, q in (("start", start), ("goal", goal))}
    reasons = [judged(checker, q).reason(name) for name, q in ends.items()]
    if any(reasons):
        return _unsolved(checker.robot, planner, 0.0, "; ".join(filter(None, reasons)))
    space = JointSpace(checker.robot)
    with _quiet():
        _seed(seed)
        setup = _setup(checker, space, resolution, DEFAULT_TOLERANCE)
        information = setup.getSpaceInformation()
        setup.setStartAndGoalStates(*(space.state(information, q) for q in ends.values()))
        setup.setPlanner(_planner(planner, information, longest_motion))
        return _search(setup, space, checker.robot, planner, time_limit, simplify)


def _planner(name: str, information: Any, longest_motion: float) -> Any:
    planner = getattr(geometric, name)(information)
    if longest_motion and hasattr(planner, "setRange"):
        planner.setRange(longest_motion)
    return planner


def _search(setup: Any, space: JointSpace, robot: Robot, planner: str, time_limit: float, simplify: bool) -> Plan:
    began = time.perf_counter()
    status = setup.solve(base.timedPlannerTerminationCondition(time_limit))
    found = time.perf_counter()
    if not setup.haveExactSolutionPath():
        reason = f"{planner} found no path in {found - began:.1f} s: {status.asString()}"
        return _unsolved(robot, planner, found - began, reason)
    solution = _shortened(setup) if simplify else setup.getSolutionPath()  # it owns its states
    path = np.array([space.read(state) for state in solution.getStates()])
    return Plan(
        solved=True,
        path=path,
        length=joint_length(path, space.differences),
        time=found - began,
        simplification_time=time.perf_counter() - found,
        planner=planner,
        joint_names=robot.joint_names,
    )


def _shortened(setup: Any) -> Any:
    """The found path, shortened; as it was found if OMPL calls the shorter one invalid."""
    found = setup.getSolutionPath()
    shorter = geometric.PathGeometric(found)
    limit = base.timedPlannerTerminationCondition(SIMPLIFICATION_TIME)
    # The flag would have every step of the simplification run at least once, however long that takes.
    kept = setup.getPathSimplifier().simplify(shorter, limit, atLeastOnce=False)
    return shorter if kept else found


def _unsolved(robot: Robot, planner: str, spent: float, reason: str) -> Plan:
    return Plan(False, np.empty((0, robot.nq)), 0.0, spent, 0.0, planner, reason, robot.joint_names)


def _seed(seed: int | None) -> None:
    """Seeds OMPL's random numbers; it warns, wrongly for a fresh planner, if there have been some already."""
    if seed is None:
        return
    if seed < 1:
        raise PlannercheckError(f"seed must be at least 1, not {seed}")
    util.RNG.setSeed(seed)


@contextmanager
def _quiet() -> Iterator[None]:
    """OMPL says nothing on the console: results and reasons are returned."""
    level = util.getLogLevel()
    util.setLogLevel(util.LOG_NONE)
    try:
        yield
    finally:
        util.setLogLevel(level)
