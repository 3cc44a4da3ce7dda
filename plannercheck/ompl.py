"""Planning with OMPL: a checker as the judge of states and motions.

In: a checker. Out: `setup`, an OMPL SimpleSetup with the robot's joint space and validators, and `plan`,
which runs a planner from a start to a goal.

Bounded joints are real numbers, continuous joints of a planning group are angles (SO2). A motion is checked
by one call of the checker, at states so close that no link point moves further than a resolution between.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from ompl import base, geometric, util

from plannercheck.checker import Checker
from plannercheck.end_states import checked_end, judged
from plannercheck.errors import PlannercheckError, unknown_name
from plannercheck.joint_space import JointSpace
from plannercheck.motion import coarse_to_fine
from plannercheck.planar.checker import Checker as PlanarChecker
from plannercheck.planar.ompl_space import Curve, PlanarSpace, sampled_curve
from plannercheck.plans import Plan, joint_length
from plannercheck.protocols import AnyChecker, AnyRobot

Floats = NDArray[np.float64]

# About this long is a found path shortened at most, s: most of the gain comes in the first half second.
SIMPLIFICATION_TIME = 1.0


# Either kind of space: reads and writes states, and says how they differ.
Space: TypeAlias = JointSpace | PlanarSpace

# A curved motion is checked coarse to fine, so that a collision is met early: first this many states, then twice as
# many each time.
_FIRST_STATES = 8


class MotionValidator(base.MotionValidator):  # type: ignore[misc]  # OMPL's bindings are untyped
    """Judges a motion by one call of the checker.

    The counters are kept here: `SpaceInformation.getCheckedMotionCount` asks OMPL's own, which stay 0.
    """

    def __init__(self, information: Any, checker: AnyChecker, space: Space, resolution: float | None) -> None:
        """Holds the checker and the joint space, but not the SpaceInformation, which holds this."""
        super().__init__(information)
        self._checker = checker
        self._space = space
        self._resolution = resolution
        self._sampler = checker.motion_sampler
        self.resetMotionCounter()

    def checkMotion(self, s1: Any, s2: Any) -> bool:  # noqa: N802  # OMPL's name
        """Whether the motion between two states is free, both ends included."""
        free = self._is_free(s1, s2)
        self._count(free)
        return free

    def checkMotionWithLastValid(self, s1: Any, s2: Any, last_valid: Any = None) -> tuple[bool, float]:  # noqa: N802
        """The same, and how far the motion is free.

        Args:
            s1: Start.
            s2: End.
            last_valid: A state that receives the last one before the first collision; None for none.

        Returns:
            Whether the motion is free, and the last valid state's place between 0 and 1 (0 also if the start
            collides).
        """
        states = self._states(s1, s2)
        colliding = np.flatnonzero(~self._checker.check_states(states))
        last = len(states) - 1 if len(colliding) == 0 else max(int(colliding[0]) - 1, 0)
        if last_valid is not None:
            self._space.write(last_valid, states[last])
        self._count(len(colliding) == 0)
        return len(colliding) == 0, last / (len(states) - 1)

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

    def _is_free(self, s1: Any, s2: Any) -> bool:
        if self._space.is_straight:
            return self._checker.check_motion(*self._ends(s1, s2), self._resolution)
        steps = self._space.curve_steps(s1, s2, self._sampler, self._resolution)
        parameters = coarse_to_fine(steps)
        done, size = 0, _FIRST_STATES
        while done < len(parameters):
            states = self._space.curve_states(s1, s2, parameters[done : done + size])
            if not self._checker.check_states(states).all():
                return False
            done, size = done + size, 2 * size
        return True

    def _states(self, s1: Any, s2: Any) -> Floats:
        """The sampled states (k, nq) of a motion, both ends included."""
        if not self._space.is_straight:
            return sampled_curve(self._space, s1, s2, self._sampler, self._resolution)
        q0, q1 = self._ends(s1, s2)
        steps = int(self._sampler.steps(q0[None], q1[None], self._resolution)[0])
        return np.asarray(self._sampler.states(q0, q1, np.arange(steps + 1) / steps))

    def _ends(self, s1: Any, s2: Any) -> tuple[Floats, Floats]:
        """Both ends; angles of the second on the short way from the first, as OMPL interpolates."""
        q0 = np.array(self._space.read(s1))
        return q0, q0 + self._space.differences(q0, np.array(self._space.read(s2)))

    def _count(self, free: bool) -> None:
        if free:
            self._valid += 1
        else:
            self._invalid += 1


# Longest motion that a planner tries at once, rad. OMPL's default, a fifth of the space's extent, is 2.6 rad
# for seven joints: most such motions collide, and checking them to a millimetre is wasted.
LONGEST_MOTION = 0.5


def setup(
    checker: AnyChecker,
    resolution: float | None = None,
    *,
    curve: Curve = "straight",
    turning_radius: float | None = None,
) -> Any:
    """Makes an OMPL SimpleSetup for a checker's robot.

    OMPL's messages below warnings are switched off; `ompl.util.setLogLevel` brings them back.

    Args:
        checker: Who judges states and motions, in space or in the plane.
        resolution: No point of the robot moves further than this between two checked states of a motion, m; default
            1 mm in space, 1 cm in the plane.
        curve: How a planar robot's root moves: "straight" (SE(2)), "dubins" (forwards) or "reeds_shepp" (either way).
        turning_radius: Of the two latter, m.

    Returns:
        An `ompl.geometric.SimpleSetup` with space, state and motion validators set.

    Raises:
        PlannercheckError: If a joint is neither bounded nor continuous, or takes several numbers.
    """
    if util.getLogLevel().value < util.LOG_WARN.value:
        util.setLogLevel(util.LOG_WARN)
    return _setup(checker, space_of(checker, curve, turning_radius), resolution)


def space_of(checker: AnyChecker, curve: Curve = "straight", turning_radius: float | None = None) -> Space:
    """The space in which a checker's robot is planned for; arguments as for `setup`."""
    if isinstance(checker, PlanarChecker):
        return PlanarSpace(checker.robot, curve, turning_radius)
    if curve != "straight" or turning_radius is not None:
        raise PlannercheckError("curves and turning radii are for planar robots")
    return JointSpace(checker.robot)  # type: ignore[arg-type]  # the other kind of checker


def _setup(checker: AnyChecker, space: Space, resolution: float | None) -> Any:
    if resolution is not None and not (np.isfinite(resolution) and resolution > 0):
        raise PlannercheckError(f"resolution must be a positive length in m, not {resolution!r}")
    setup = geometric.SimpleSetup(space.ompl_space())
    setup.setStateValidityChecker(_state_validity(checker, space))
    information = setup.getSpaceInformation()
    information.setMotionValidator(MotionValidator(information, checker, space, resolution))
    return setup


def _state_validity(checker: AnyChecker, space: Space) -> Callable[[Any], bool]:
    """The compiled function where states are plain numbers; else one that reads them in Python."""
    compiled = checker.state_validity() if isinstance(checker, Checker) and not space.continuous.any() else None
    read, is_valid = space.read, checker.is_valid
    return compiled or (lambda state: is_valid(np.array(read(state))))


def planner_names() -> list[str]:
    """Names of the planners that OMPL's bindings offer."""
    found = [name for name in dir(geometric) if _is_planner(getattr(geometric, name))]
    return sorted(found)


def _is_planner(item: Any) -> bool:
    return isinstance(item, type) and issubclass(item, base.Planner)


def plan(
    checker: AnyChecker,
    start: ArrayLike,
    goal: ArrayLike,
    planner: str = "RRTConnect",
    time_limit: float = 10.0,
    simplify: bool = True,
    seed: int | None = None,
    resolution: float | None = None,
    longest_motion: float | None = None,
    curve: Curve = "straight",
    turning_radius: float | None = None,
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
        longest_motion: How far a planner with a range extends at once, in the space's distance (rad); 0 leaves it to
            OMPL, as None does in the plane; None is `LONGEST_MOTION` in space.
        curve: As for `setup`.
        turning_radius: As for `setup`.

    Returns:
        The plan; curved motions are given as all their checked states. If start or goal collide or are beyond the
        limits, it is unsolved and `reason` says why.
    """
    if planner not in planner_names():
        raise unknown_name("planner", planner, planner_names())
    if not (np.isfinite(time_limit) and time_limit > 0):
        raise PlannercheckError(f"time_limit must be a positive time in s, not {time_limit!r}")
    if longest_motion is None:
        longest_motion = 0 if isinstance(checker, PlanarChecker) else LONGEST_MOTION
    if not (np.isfinite(longest_motion) and longest_motion >= 0):
        raise PlannercheckError(f"longest_motion must be a length in rad or 0, not {longest_motion!r}")
    ends = {name: checked_end(checker, q, name) for name, q in (("start", start), ("goal", goal))}
    reasons = [judged(checker, q).reason(name) for name, q in ends.items()]
    if any(reasons):
        return _unsolved(checker.robot, planner, 0.0, "; ".join(filter(None, reasons)))
    space = space_of(checker, curve, turning_radius)
    with _quiet():
        _seed(seed)
        setup = _setup(checker, space, resolution)
        information = setup.getSpaceInformation()
        setup.setStartAndGoalStates(*(space.state(information, q) for q in ends.values()))
        setup.setPlanner(_planner(planner, information, longest_motion))
        return _search(setup, space, checker, planner, time_limit, simplify, resolution)


def _planner(name: str, information: Any, longest_motion: float) -> Any:
    planner = getattr(geometric, name)(information)
    if longest_motion and hasattr(planner, "setRange"):
        planner.setRange(longest_motion)
    return planner


def _search(
    setup: Any,
    space: Space,
    checker: AnyChecker,
    planner: str,
    time_limit: float,
    simplify: bool,
    resolution: float | None,
) -> Plan:
    robot = checker.robot
    began = time.perf_counter()
    status = setup.solve(base.timedPlannerTerminationCondition(time_limit))
    found = time.perf_counter()
    if not setup.haveExactSolutionPath():
        reason = f"{planner} found no path in {found - began:.1f} s: {status.asString()}"
        return _unsolved(robot, planner, found - began, reason)
    solution = _shortened(setup) if simplify else setup.getSolutionPath()  # it owns its states
    spent = time.perf_counter() - found
    path = _configurations(space, list(solution.getStates()), checker, resolution)
    return Plan(
        solved=True,
        path=path,
        length=joint_length(path, space.differences),
        time=found - began,
        simplification_time=spent,
        planner=planner,
        joint_names=robot.joint_names,
    )


def _configurations(space: Space, states: list[Any], checker: AnyChecker, resolution: float | None) -> Floats:
    """The path (k, nq) along OMPL states; between them all that was checked, where motions are curved."""
    if space.is_straight:
        return np.array([space.read(state) for state in states])
    curves = (sampled_curve(space, a, b, checker.motion_sampler, resolution) for a, b in pairwise(states))
    return np.concatenate([[space.read(states[0])], *(curve[1:] for curve in curves)])


def _shortened(setup: Any) -> Any:
    """The found path, shortened; as it was found if OMPL calls the shorter one invalid."""
    found = setup.getSolutionPath()
    shorter = geometric.PathGeometric(found)
    limit = base.timedPlannerTerminationCondition(SIMPLIFICATION_TIME)
    # The flag would have every step of the simplification run at least once, however long that takes.
    kept = setup.getPathSimplifier().simplify(shorter, limit, atLeastOnce=False)
    return shorter if kept else found


def _unsolved(robot: AnyRobot, planner: str, spent: float, reason: str) -> Plan:
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
