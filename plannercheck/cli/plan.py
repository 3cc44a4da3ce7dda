"""`plannercheck plan`: one problem, or the problem sets of MotionBenchMaker.

In: a robot with a scene, start and goal, or with problem sets. Out: plans, on the terminal and in files.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from plannercheck.checking.protocols import AnyChecker
from plannercheck.cli import plan_problem_sets as problem_sets
from plannercheck.cli import timed_plans
from plannercheck.cli.common import (
    add_checker_arguments,
    check_folder,
    load_checker,
    table,
    vector,
)
from plannercheck.cli.unused_options import check_used
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.checker import Checker
from plannercheck.ompl import LONGEST_MOTION, plan, planner_names
from plannercheck.ompl.near_first import SAMPLINGS
from plannercheck.ompl.plans import Plan, check_suffix
from plannercheck.ompl.searches import AUTO
from plannercheck.ompl.start_and_goal import check_end_state, checked_end
from plannercheck.planar.curves import CURVES
from plannercheck.planar.robot_files import is_planar
from plannercheck.robots.robot import Robot
from plannercheck.trajectories.written_messages import check_suffix as check_message_suffix
from plannercheck.validation.path_recheck import check_path

_EPILOG = """\
Every motion is proved free, not sampled, in space and in the plane; one that comes within 0.1 mm of a collision may be
refused.

Exit codes: 0 solved, 1 not (all) solved, or not proved as timed, 2 bad input, such as a start or a single goal that
collides (the pairs are named) or is beyond the limits; in a set, such problems count as not solved.

Examples:
  plannercheck plan --robot panda --scene bookshelf --output plan.csv
  plannercheck plan --robot ur5 --scene cell.yaml --start 0,-1.5,1.5,0,0,0 --goal 1,-1,1,0,0,0
  plannercheck plan --robot forklift --scene warehouse --curve reeds_shepp --turning-radius 1.5
  plannercheck plan --robot configs/puzzles/hook.yaml --scene configs/puzzles/ring.yaml --scene-meshes solid
  plannercheck plan --robot ur5 --scene cell.yaml --goal 1,-1,1,0,0,0 --goal 1,-1,1,0,0,3.1
  plannercheck plan --robot panda --problems cage_panda.tar.bz2 --output results.json
  plannercheck plan --robot panda --scene bookshelf --timed --acceleration joint_limits.yaml --output traj.yaml
"""


# Configurations of a path that are printed.
_MOST_ROWS = 60


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    parser.epilog = _EPILOG
    add_checker_arguments(parser)
    parser.add_argument("--start", metavar="A,B,...", help="start, rad and m; default: the scene file's")
    parser.add_argument(
        "--goal",
        action="append",
        metavar="A,B,...",
        help="goal, rad and m; given several times, the plan ends at one of them; default: the scene file's",
    )
    parser.add_argument(
        "--problems",
        nargs="+",
        type=Path,
        metavar="SET",
        help="folders or tar archives of MotionBenchMaker problems, instead of scene, start and goal",
    )
    parser.add_argument("--first", type=int, metavar="N", help="plan only the first N problems of each set")
    parser.add_argument("--each", action="store_true", help="print a line for each problem of a set")
    parser.add_argument(
        "--planner",
        default=AUTO,
        help=f"{AUTO}: RRTConnect and LBKPIECE1 take turns; or one of {', '.join(planner_names())} (RRT* is RRTstar); "
        f"default: {AUTO}",
    )
    parser.add_argument("--time", type=float, default=10.0, metavar="S", help="time of each search, s; default: 10")
    parser.add_argument(
        "--range",
        type=float,
        metavar="RAD",
        help=f"longest motion the planner tries at once; 0: OMPL's choice; default: {LONGEST_MOTION} rad in space, "
        "OMPL's choice in the plane",
    )
    parser.add_argument(
        "--sampling",
        choices=SAMPLINGS,
        default="near",
        help="where RRTConnect samples: near start and goal first, or everywhere from the beginning; default: near",
    )
    parser.add_argument(
        "--curve", choices=CURVES, default="straight", help="curve that a planar robot's root drives; default: straight"
    )
    parser.add_argument(
        "--turning-radius", type=float, metavar="M", help="turning radius of dubins and reeds_shepp curves, m"
    )
    parser.add_argument(
        "--bounds",
        metavar="X,Y,Z,X,Y,Z",
        help="least and largest position of floating and planar joints, m; default: room around all obstacles",
    )
    parser.add_argument("--no-simplify", action="store_true", help="leave paths as the planner found them")
    parser.add_argument("--seed", type=int, help="seed of at least 1: the same seed gives the same search")
    parser.add_argument(
        "--verify",
        choices=("fcl",),
        help="check every sampled state of a path by FCL, and count collisions between the samples (slow)",
    )
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE",
        help="write the plan as json, npy or csv; the results of sets as json",
    )
    timed_plans.add_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    check_folder(options.output)
    if options.problems:
        return problem_sets.run(options)
    check_used(options, ("--first", "--each"), "with --problems")
    timed_plans.check_arguments(options)
    if options.scene is None and (options.start is None or options.goal is None):
        raise PlannercheckError("has no start or no goal: needs --scene, or --problems, or both --start and --goal")
    if options.output is not None:
        (check_message_suffix if options.timed else check_suffix)(options.output)
    if options.verify and is_planar(options.robot, "robots"):
        raise PlannercheckError("--verify fcl is for robots in space: FCL knows no polygons")
    return _run_one(options)


def _run_one(options: argparse.Namespace) -> int:
    checker = load_checker(options, own_joints=True)
    robot, scene = checker.robot.name, checker.scene
    start = scene.start(robot) if options.start is None else vector(options.start, "--start")
    goals = [scene.goal(robot)] if options.goal is None else [vector(text, "--goal") for text in options.goal]
    if len(goals) == 1:
        start, goals[0] = _checked_ends(checker, start=start, goal=goals[0])
    else:  # `plan` leaves out those that can't be planned to
        (start,) = _checked_ends(checker, start=start)
    found = plan(
        checker,
        start,
        goals[0] if len(goals) == 1 else goals,
        planner=options.planner,
        time_limit=options.time,
        simplify=not options.no_simplify,
        seed=options.seed,
        longest_motion=options.range,
        curve=options.curve,
        turning_radius=options.turning_radius,
        bounds=None if options.bounds is None else _box(options.bounds),
        sampling=options.sampling,
    )
    reached = f", to goal {found.goal}" if len(goals) > 1 else ""
    _show(found, _columns(checker), "rad" if isinstance(checker, Checker) else "in m and rad", reached)
    if found.solved and options.timed:
        made = timed_plans.timed_plan(checker, found, options)
        if made is None:
            return 1
        if options.output is not None:
            made.save(options.output)
    elif found.solved and options.output is not None:
        found.save(options.output)
    if found.solved and options.output is not None:
        print(f"written to {options.output}")
    if not found.solved or not options.verify:
        return 0 if found.solved else 1
    assert isinstance(checker, Checker)  # `run`
    check = check_path(checker, found.path)
    problem_sets.show_checks([check])
    return 0 if check.passed else 1


def _box(text: str) -> Floats:
    """(2, 3) least and largest position, m."""
    numbers = vector(text, "--bounds")
    if numbers.shape != (6,):
        raise PlannercheckError(f"--bounds takes six numbers, the least and the largest x, y, z, not {text!r:.80}")
    return numbers.reshape(2, 3)


def _checked_ends(checker: AnyChecker, **ends: Floats) -> tuple[Floats, ...]:
    """The ends (nq,), or an error if a search could not even begin."""
    checked = {name: checked_end(checker, q, name) for name, q in ends.items()}
    reason = "; ".join(filter(None, (check_end_state(checker, q).reason(name) for name, q in checked.items())))
    if reason:
        raise PlannercheckError(f"not planned: {reason}")
    return tuple(checked.values())


def _shown_rows(found: Plan) -> list[tuple[int, list[float]]]:
    """The path's configurations with their numbers; of curved paths, which hold every checked state, some."""
    stride = -(-len(found.path) // _MOST_ROWS)
    shown = sorted({*range(0, len(found.path), stride), len(found.path) - 1})
    return [(k, found.path[k].tolist()) for k in shown]


def _columns(checker: AnyChecker) -> list[str]:
    """A name for each column: of a joint that takes several, it is over the first one."""
    robot = checker.robot
    names = list(robot.joint_names)
    if len(names) == robot.nq or not isinstance(robot, Robot):
        return names
    out = [""] * robot.nq
    for name, start in zip(names, robot.configuration_map.starts, strict=True):
        out[start] = name
    return out


def _show(found: Plan, names: list[str], unit: str, reached: str) -> None:
    if not found.solved:
        print(f"not solved: {found.reason}")
        return
    print(
        table(
            ("", *names),
            [(k, *(f"{value:.4f}" for value in row)) for k, row in _shown_rows(found)],
        )
    )
    print(
        f"\n{found.planner} found a path in {1e3 * found.time:.1f} ms, "
        f"shortened in {1e3 * found.simplification_time:.1f} ms: "
        f"{len(found.path)} configurations, length {found.length:.3f} {unit}" + reached
    )
