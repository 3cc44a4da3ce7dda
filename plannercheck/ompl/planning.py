"""Planning with OMPL: a checker as the judge of states and motions.

In: a checker. Out: `setup`, an OMPL SimpleSetup with the robot's joint space and validators, and `plan`,
which runs a planner from a start to a goal.

Bounded joints are real numbers, continuous joints of a planning group are angles (SO2), floating, planar and ball
joints are OMPL's SE(3), SE(2) and SO(3). Motions are proved free unless a resolution is given: see
motion_validators.py.
"""

from __future__ import annotations

import math
import time
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from ompl import base, geometric, util

from plannercheck.checking.protocols import AnyChecker, AnyRobot
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import Configuration, read_only
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.progress import is_heard, report
from plannercheck.common.real_numbers import positive_number
from plannercheck.common.silence import Silence
from plannercheck.common.whole_numbers import whole_number
from plannercheck.motions.certifier import DEFAULT_TOLERANCE
from plannercheck.motions.checker import Checker
from plannercheck.ompl.angle_checkers import angle_checker, angle_end, check_checker
from plannercheck.ompl.clearance import CLEARANCE_RESOLUTION, MaxMinClearance
from plannercheck.ompl.curved_space import sampled_curve
from plannercheck.ompl.goals import Goal, Goals, goals_of
from plannercheck.ompl.motion_validators import Space
from plannercheck.ompl.near_first import SAMPLINGS, Sampling
from plannercheck.ompl.planar_space import PlanarSpace
from plannercheck.ompl.plans import Plan, joint_length
from plannercheck.ompl.pose_space import PoseSpace
from plannercheck.ompl.prepared_spaces import PreparedSpace, borrowed_space, returned_space, space_information, space_of
from plannercheck.ompl.searches import AUTO, THREADED, Search, in_turns
from plannercheck.ompl.searches import made_planner as made_planner
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


def full_name(planner: str) -> str:
    """The name of a planner in `planner_names()`; RRT*, BIT* and PRM* are called RRTstar, BITstar and PRMstar there."""
    full = planner.replace("*", "star") if isinstance(planner, str) else planner
    if full not in planner_names():
        raise unknown_name("planner", planner, (AUTO, *planner_names()))
    return full


def _is_planner(item: Any) -> bool:
    return isinstance(item, type) and issubclass(item, base.Planner)


def plan(
    checker: AnyChecker,
    start: Configuration,
    goal: Goal,
    planner: str = AUTO,
    time_limit: float = 10.0,
    simplify: bool = True,
    seed: int | None = None,
    resolution: float | None = None,
    longest_motion: float | None = None,
    curve: Curve = "straight",
    turning_radius: float | None = None,
    bounds: ArrayLike | None = None,
    sampling: Sampling = "near",
    *,
    start_time: float | None = None,
    latest: float | None = None,
) -> Plan:
    """Plans from one configuration to another.

    Args:
        checker: The checker that judges states and motions.
        start: (nq,) rad and m, or each joint's value by its name.
        goal: (nq,) rad and m, or by names; several of these, such as (k, nq), of which the plan may reach any; or a
            function without arguments that yields them, such as inverse kinematics. The function is asked before the
            search: for 16 free goals at most, and after the first one for at most a tenth of the time limit.
        planner: One of `planner_names()`, where * may stand for "star"; "auto" has RRTConnect and LBKPIECE1 take turns
            (searches.py).
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
        start_time: For plans in space and time, of which OMPL's bindings have no planner: an error says so.
        latest: Likewise.

    Returns:
        The plan; its `goal` says which goal was reached. Free bodies move as on the path "slerp" of
        `Checker.check_motion`. Curved motions are given as states between which no point moves further than 1 cm, or
        the resolution. If the start collides or is beyond the limits, or all goals do or are, the plan is unsolved and
        `reason` says why. What is beyond a limit by at most 1e-6 is taken at the limit, with a warning.
    """
    check_checker(checker)
    if (start_time, latest) != (None, None) or getattr(checker, "clock", None) is not None:
        raise PlannercheckError(
            "there are no plans in space and time: OMPL's Python bindings have no such planner (STRRTstar); plan"
            " without a clock, and pc.least_delay says how long to wait"
        )
    planner = planner if planner == AUTO else full_name(planner)
    time_limit = positive_number(time_limit, "time_limit must be a positive time in s")
    if resolution is not None:
        resolution = positive_number(resolution, "resolution must be a positive length in m")
    if sampling not in SAMPLINGS:
        raise unknown_name("sampling", sampling, SAMPLINGS)
    if longest_motion is None:
        longest_motion = 0 if isinstance(checker, PlanarChecker) else LONGEST_MOTION
    longest_motion = positive_number(longest_motion, "longest_motion must be a length in rad or 0", or_zero=True)
    given, checker = checker, angle_checker(checker)
    robot, began = checker.robot, time.perf_counter()
    first = angle_end(given, checker, start, "start")
    goals = goals_of(given, checker, goal, time_limit)
    reasons = [check_end_state(checker, first).reason("start"), goals.reason]
    spent = time.perf_counter() - began if callable(goal) else 0.0
    if any(reasons):
        return _unsolved(robot, planner, spent, "; ".join(filter(None, reasons)))
    ends, used = (first, *goals.rows), list[PreparedSpace]()

    def search_by(name: str) -> Search:
        prepared = borrowed_space(checker, name, resolution, curve, turning_radius, ends, bounds)
        used.append(prepared)
        if len(used) == 1:
            seed_ompl(seed)
        made = Search(name, prepared, ends, longest_motion, sampling == "near")
        if seed is not None:
            prepared.draw_seeds()
        return made

    with OMPL_SILENCE():
        condition = _timed(max(time_limit - spent, 0.0), planner)
        search = None if planner == AUTO else search_by(planner)
        began = time.perf_counter()
        if search is None:
            search, status = in_turns(search_by, condition)
        else:
            status = search.go_on(condition)
        spent += time.perf_counter() - began
        report(1, 1, "searched")
        if search.has_found:
            found = _found(search, checker, spent, goals, simplify, resolution)
        else:
            found = _unsolved(robot, planner, spent, why_not(planner, search.setup, status, spent))
        for prepared in used:
            returned_space(prepared)
        return found


def _timed(time_limit: float, planner: str) -> Any:
    """OMPL's condition that ends a search after some seconds, which tells a listener how many have gone.

    For planners whose own thread asks the condition it is no Python, so the listener hears of the beginning alone.
    """
    timed = base.timedPlannerTerminationCondition(time_limit)
    if not is_heard():
        return timed
    if planner in THREADED:
        report(0, math.ceil(time_limit), f"{planner} searches, s")
        return timed
    began, told = time.monotonic(), -1

    def tells() -> bool:
        nonlocal told
        spent = int(time.monotonic() - began)
        if spent > told:
            report(spent, math.ceil(time_limit), f"{planner} searches, s")
            told = spent
        return False

    return base.plannerOrTerminationCondition(timed, base.PlannerTerminationCondition(tells))


def why_not(planner: str, setup: Any, status: Any, spent: float) -> str:
    """Why a search has no path."""
    if setup.refused_path:
        what = "does not begin at the start, or has a curve that collides the way it is gone"
        return f"{planner} found a path that {what}; try another seed"
    has_timed_out = str(status.asString()) in ("Timeout", "Approximate solution")  # there is nothing of use
    return f"{planner} found no path in {spent:.1f} s" + ("" if has_timed_out else f": {status.asString()}")


def _found(
    search: Search, checker: AnyChecker, spent: float, goals: Goals, simplify: bool, resolution: float | None
) -> Plan:
    """The plan of a search that has found a path."""
    setup, space, began = search.setup, search.prepared.space, time.perf_counter()
    solution = shortened(setup) if simplify else setup.getSolutionPath()  # it owns its states
    shortening = time.perf_counter() - began
    path = read_only(_configurations(space, list(solution.getStates()), checker, resolution))
    return Plan(
        solved=True,
        path=path,
        length=joint_length(path, space.differences),
        time=spent,
        simplification_time=shortening,
        planner=search.planner,
        joint_names=checker.robot.joint_names,
        motion_path="slerp" if isinstance(space, PoseSpace) else "screw",
        goal=goals.reached(path[-1], space.differences),
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
    wanted = "seed must be a whole number from 1 to 2**64 - 1"
    if whole_number(seed, wanted) >= 2**64:
        raise PlannercheckError(f"{wanted}, not {seed:.3g}")
    util.RNG.setSeed(int(seed))
