"""Planning with OMPL: a checker as the judge of states and motions.

In: a checker. Out: `setup`, an OMPL SimpleSetup with the robot's joint space and validators, and `plan`,
which runs a planner from a start to a goal.

Bounded joints are real numbers, continuous joints of a planning group are angles (SO2), floating, planar and ball
joints are OMPL's SE(3), SE(2) and SO(3). Motions are proved free unless a resolution is given: see
motion_validators.py.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from ompl import base, geometric, util

from plannercheck.checking.protocols import AnyChecker, AnyRobot
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import Configuration, read_only
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.silence import Silence
from plannercheck.motions.certifier import DEFAULT_TOLERANCE
from plannercheck.motions.checker import Checker
from plannercheck.ompl.angle_checkers import angle_checker, angle_end
from plannercheck.ompl.clearance import CLEARANCE_RESOLUTION, MaxMinClearance
from plannercheck.ompl.joint_space import JointSpace
from plannercheck.ompl.motion_validators import Space
from plannercheck.ompl.near_first import NEAR_FIRST, SAMPLINGS, Sampling, solve_near_first
from plannercheck.ompl.planar_space import PlanarSpace, sampled_curve
from plannercheck.ompl.plans import Plan, joint_length
from plannercheck.ompl.pose_space import PoseSpace
from plannercheck.ompl.prepared_spaces import given_back, lent, space_information, space_of
from plannercheck.ompl.simple_setup import SimpleSetup
from plannercheck.ompl.start_and_goal import check_end_state
from plannercheck.planar.checker import Checker as PlanarChecker
from plannercheck.planar.curves import Curve

# A found path is shortened for about this long at most, s: most of the gain comes in the first half second.
SIMPLIFICATION_TIME = 1.0


# Longest motion that a planner tries at once, rad. OMPL's default, a fifth of the space's extent, is 2.6 rad
# for seven joints: most such motions collide, and checking them to a millimetre is wasted. Shorter ones give shorter
# paths, longer ones take less time (measured: docs/reference/performance.md).
LONGEST_MOTION = 0.7

# OMPL says nothing on the console while it plans: results and reasons are returned.
OMPL_SILENCE = Silence(util.getLogLevel, util.setLogLevel, util.LOG_NONE)


def setup(
    checker: AnyChecker,
    resolution: float | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    *,
    curve: Curve = "straight",
    turning_radius: float | None = None,
    bounds: ArrayLike | None = None,
) -> Any:
    """Makes an OMPL SimpleSetup for a checker's robot.

    OMPL's messages below warnings are switched off; `ompl.util.setLogLevel` brings them back.

    Args:
        checker: The checker that judges states and motions, in space or in the plane.
        resolution: None to prove motions free. Else they are sampled, and no point of the robot moves further than this
            between two checked states, m.
        tolerance: A motion that comes within this of a collision may be refused by the proof, m.
        curve: How a planar robot's root moves: "straight" (SE(2)), "dubins" (forwards) or "reeds_shepp" (either way).
        turning_radius: The turning radius of the two latter, m.
        bounds: (2, 3) the least and the largest position of floating and planar joints, m. None for the limits, or
            else a box around all obstacles in which the robot has room on all sides.

    Returns:
        An `ompl.geometric.SimpleSetup` with space, state and motion validators set. Its `simplifySolution` keeps the
        path that was found if OMPL's simpler one collides. `getPathSimplifier()` does not: for a path that collides it
        only returns False. Free bodies move as OMPL interpolates: positions on straight lines, turns by slerp, which is
        the path "slerp" of `Checker.check_motion`.

        AORRTC, BITstar, InformedRRTstar and SORRTstar serve bounded joints and planar robots without joints; OMPL's
        other planners serve every space.

    Raises:
        PlannercheckError: If a joint is neither bounded nor continuous, or takes several numbers that OMPL has no space
            for.
    """
    if util.getLogLevel().value < util.LOG_WARN.value:
        util.setLogLevel(util.LOG_WARN)
    space = space_of(checker, curve, turning_radius, (), bounds)
    information = space_information(checker, space, resolution, tolerance)
    return SimpleSetup(information, not space.is_straight, space.numbers.failure)


def clearance_objective(checker: AnyChecker, setup: Any, resolution: float = CLEARANCE_RESOLUTION) -> Any:
    """An objective for paths whose least clearance is as great as possible; see clearance.py.

    Args:
        checker: The checker that measures clearances, in space.
        setup: The result of `setup` for it; `setup.setOptimizationObjective(objective)` applies the objective.
        resolution: The step between states at which a motion's clearance is measured, in the space's distance (rad).

    Returns:
        An `ompl.base.OptimizationObjective`.

    Raises:
        PlannercheckError: If the checker is planar.
    """
    space = space_of(checker)
    if not isinstance(checker, Checker):
        raise PlannercheckError("clearances are measured in space only, not for planar robots")
    return MaxMinClearance(setup.getSpaceInformation(), checker, space, resolution)


@cache
def planner_names() -> tuple[str, ...]:
    """Names of the planners that OMPL's bindings offer."""
    found = [name for name in dir(geometric) if _is_planner(getattr(geometric, name))]
    return tuple(sorted(found))


def _is_planner(item: Any) -> bool:
    return isinstance(item, type) and issubclass(item, base.Planner)


def plan(
    checker: AnyChecker,
    start: Configuration,
    goal: Configuration,
    planner: str = "RRTConnect",
    time_limit: float = 10.0,
    simplify: bool = True,
    seed: int | None = None,
    resolution: float | None = None,
    longest_motion: float | None = None,
    curve: Curve = "straight",
    turning_radius: float | None = None,
    bounds: ArrayLike | None = None,
    sampling: Sampling = "near",
) -> Plan:
    """Plans from one configuration to another.

    Args:
        checker: The checker that judges states and motions.
        start: (nq,) rad and m, or each joint's value by its name.
        goal: (nq,) rad and m, or by names.
        planner: One of `planner_names()`.
        time_limit: The time limit of the search, s; shortening takes up to about `SIMPLIFICATION_TIME` more.
        simplify: Whether to shorten the path.
        seed: Seed of OMPL's random numbers, 1 or more, for a search that can be repeated; None for a different search
            each time.
        resolution: As for `setup`.
        longest_motion: How far a planner with a range extends at once, in the space's distance (rad); 0 leaves it to
            OMPL, as None does in the plane; None is `LONGEST_MOTION` in space.
        curve: As for `setup`.
        turning_radius: As for `setup`.
        bounds: As for `setup`; the box around all obstacles is also around start and goal.
        sampling: "near" has RRTConnect sample bounded joints near start and goal first, and ever further from them the
            longer the search takes (near_first.py); "everywhere" samples the whole space from the beginning, as all
            other planners and other joints do.

    Returns:
        The plan. Free bodies move as on the path "slerp" of `Checker.check_motion`. Curved motions are given as states
        between which no point moves further than 1 cm, or the resolution.
        If the start or the goal collides or is beyond the limits, the plan is unsolved and `reason` says why.
    """
    if planner not in planner_names():
        raise unknown_name("planner", planner, planner_names())
    if not (isfinite(time_limit) and time_limit > 0):
        raise PlannercheckError(f"time_limit must be a positive time in s, not {time_limit!r}")
    if sampling not in SAMPLINGS:
        raise unknown_name("sampling", sampling, SAMPLINGS)
    if longest_motion is None:
        longest_motion = 0 if isinstance(checker, PlanarChecker) else LONGEST_MOTION
    if not (isfinite(longest_motion) and longest_motion >= 0):
        raise PlannercheckError(f"longest_motion must be a length in rad or 0, not {longest_motion!r}")
    given, checker = checker, angle_checker(checker)
    ends = {name: angle_end(given, checker, q, name) for name, q in (("start", start), ("goal", goal))}
    reasons = [check_end_state(checker, q).reason(name) for name, q in ends.items()]
    if any(reasons):
        return _unsolved(checker.robot, planner, 0.0, "; ".join(filter(None, reasons)))
    with OMPL_SILENCE():
        prepared = lent(checker, planner, resolution, curve, turning_radius, tuple(ends.values()), bounds)
        seed_ompl(seed)
        space = prepared.space
        setup = SimpleSetup(prepared.information, not space.is_straight, space.numbers.failure)
        setup.setStartAndGoalStates(*prepared.end_states(tuple(ends.values())))
        setup.setPlanner(made_planner(planner, prepared.information, longest_motion))
        if seed is not None:
            prepared.draw_seeds()
        near = tuple(ends.values()) if sampling == "near" else ()
        found = _search(setup, space, checker, planner, time_limit, simplify, resolution, near)
        given_back(prepared)
        return found


def made_planner(name: str, information: Any, longest_motion: float) -> Any:
    """One of `planner_names()`, with a range if it has one."""
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
    near: Sequence[Floats],
) -> Plan:
    """Searches, first near some configurations if they are given."""
    robot = checker.robot
    began = time.perf_counter()
    condition = base.timedPlannerTerminationCondition(time_limit)
    if near and planner in NEAR_FIRST and isinstance(space, JointSpace):
        status = solve_near_first(setup, space, near, condition)
    else:
        status = setup.solve(condition)
    found = time.perf_counter()
    if not setup.haveExactSolutionPath():
        reason = f"{planner} found no path in {found - began:.1f} s: {status.asString()}"
        if setup.refused_path:
            reason = f"{planner} found a path with a curve that collides the way it is gone; try another seed"
        return _unsolved(robot, planner, found - began, reason)
    solution = shortened(setup) if simplify else setup.getSolutionPath()  # it owns its states
    spent = time.perf_counter() - found
    path = read_only(_configurations(space, list(solution.getStates()), checker, resolution))
    return Plan(
        solved=True,
        path=path,
        length=joint_length(path, space.differences),
        time=found - began,
        simplification_time=spent,
        planner=planner,
        joint_names=robot.joint_names,
        motion_path="slerp" if isinstance(space, PoseSpace) else "screw",
    )


def _configurations(space: Space, states: list[Any], checker: AnyChecker, resolution: float | None) -> Floats:
    """The path (k, nq) along OMPL states; where motions are curved, with states between them."""
    if not isinstance(space, PlanarSpace) or space.is_straight:
        return space.rows(states)
    curves = (sampled_curve(space, a, b, checker.motion_sampler, resolution) for a, b in pairwise(states))
    return np.concatenate([[space.read(states[0])], *(curve[1:] for curve in curves)])


def shortened(setup: Any) -> Any:
    """The found path, shortened; as it was found if a motion of the shorter one collides."""
    found = setup.getSolutionPath()
    shorter = geometric.PathGeometric(found)
    limit = base.timedPlannerTerminationCondition(SIMPLIFICATION_TIME)
    with setup.remembered_motions():
        # With the flag, every step of the simplification would run at least once, however long that takes.
        kept = setup.getPathSimplifier().simplify(shorter, limit, atLeastOnce=False)
        return shorter if kept and shorter.check() else found


def _unsolved(robot: AnyRobot, planner: str, spent: float, reason: str) -> Plan:
    return Plan(False, np.empty((0, robot.nq)), 0.0, spent, 0.0, planner, reason, robot.joint_names)


def seed_ompl(seed: int | None) -> None:
    """Seeds OMPL's random numbers; it warns, wrongly for a fresh planner, if there have been some already."""
    if seed is None:
        return
    if seed < 1:
        raise PlannercheckError(f"seed must be at least 1, not {seed}")
    util.RNG.setSeed(seed)
