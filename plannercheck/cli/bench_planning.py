"""`plannercheck bench motions`, `setup` and `plans`: what planners and their users wait for.

In: options. Out: tables on the terminal and, with --output, CSV and JSON in a folder.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence

from plannercheck.cli.bench_options import (
    Subcommand,
    add_problems,
    add_robot,
    add_scenes,
    add_seed,
    checker_in,
    keep,
    note,
    positive,
    positive_number,
    ratio_of,
    show,
    show_how,
)
from plannercheck.cli.robot_options import robot_of
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench import distances, from_files, many_boxes, motions, plans, set_up, trajectories
from plannercheck.evaluation.bench.distances import DistanceRow
from plannercheck.evaluation.bench.from_files import FromFilesRow
from plannercheck.evaluation.bench.many_boxes import BoxesRow
from plannercheck.evaluation.bench.motion_sets import MotionSet, random_sets, recorded_set
from plannercheck.evaluation.bench.motions import MotionRow
from plannercheck.evaluation.bench.planners import Settings
from plannercheck.evaluation.bench.plans import PlanRow, Tally
from plannercheck.evaluation.bench.problems import name_of_set, tasks
from plannercheck.evaluation.bench.set_up import SetUpRow
from plannercheck.evaluation.bench.tables import number
from plannercheck.evaluation.bench.trajectories import TrajectoryRow
from plannercheck.ompl import LONGEST_MOTION
from plannercheck.robots.robot import Robot

# Lengths of random motions, and ranges of recorded searches, rad.
_LENGTHS = (0.4, 1.0)
_RANGES = (0.5, 1.0)


def _add_motions(parser: argparse.ArgumentParser) -> None:
    add_robot(parser)
    add_scenes(parser)
    add_problems(parser, ", whose RRTConnect searches are recorded")
    parser.add_argument(
        "--motions", type=positive, default=400, help="number of motions of each kind (default: %(default)s)"
    )
    _add_lengths(parser, "--lengths", _LENGTHS, "lengths of random motions, rad")
    _add_lengths(parser, "--ranges", _RANGES, "ranges of recorded searches, rad")
    add_seed(parser)


def _add_lengths(parser: argparse.ArgumentParser, name: str, default: Sequence[float], what: str) -> None:
    listed = " ".join(f"{value:g}" for value in default)
    parser.add_argument(
        name, type=positive_number, nargs="+", default=default, metavar="RAD", help=f"{what} (default: {listed})"
    )


def _add_setup(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--robot", default="panda", help="name or file (default: %(default)s)")
    parser.add_argument(
        "--scene", nargs="+", default=["bookshelf"], help="names or files; none for no obstacles (default: bookshelf)"
    )
    add_problems(parser, ", done from scene file and request to a path")
    parser.add_argument(
        "--boxes", type=positive, nargs="+", default=[], metavar="N", help="also scenes of N boxes, e.g. 1000 100000"
    )
    _add_limit(parser)
    add_seed(parser)


def _add_plans(parser: argparse.ArgumentParser) -> None:
    add_robot(parser)
    add_problems(parser, "", required=True)
    parser.add_argument("--seeds", type=positive, nargs="+", default=[1], help="seeds of each problem (default: 1)")
    parser.add_argument(
        "--range",
        type=positive_number,
        default=LONGEST_MOTION,
        metavar="RAD",
        help="longest motion that planners of OMPL try at once (default: %(default)s)",
    )
    _add_limit(parser)


def _add_limit(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--time", type=positive_number, default=10.0, metavar="S", help="time limit of each search, s (default: 10)"
    )


def _run_motions(options: argparse.Namespace) -> None:
    robot = robot_of(options)
    if robot.nq != len(robot.joint_names):
        raise PlannercheckError(
            f"{robot.name} has joints of several numbers: random motions need one each; choose a planning group"
        )
    rows: list[MotionRow] = []
    for motion_set in _motion_sets(robot, options):
        found = motions.measure(motion_set, options.rounds, note)
        _print_motions(found)
        rows += found
    keep(options.output, "motions", rows)


def _motion_sets(robot: Robot, options: argparse.Namespace) -> Iterator[MotionSet]:
    for scene in options.scene:
        checker = checker_in(robot, scene)
        for length in options.lengths:
            yield from random_sets(checker, checker.scene.name, length, options.motions, options.seed)
    for path in options.problems:
        ready = list(tasks(path, robot, options.every, options.first))
        if not ready:
            note(f"{name_of_set(path)} is left out: no start and goal of its problems are free")
            continue
        for longest in options.ranges:
            yield recorded_set(name_of_set(path), ready, longest, options.motions)


def _print_motions(rows: Sequence[MotionRow]) -> None:
    first = rows[0]
    print(f"\n{first.robot}, {first.where}, {first.kind}: {first.motions} motions, {first.free:.0%} free")
    columns: dict[str, Callable[[MotionRow], object]] = {
        "method": lambda row: row.method,
        "µs a motion": lambda row: f"{row.microseconds:.2f}",
        "x": ratio_of,
        "false free %": lambda row: f"{100 * row.false_free:.2f}",
        "false coll. %": lambda row: f"{100 * row.false_collision:.2f}",
        "motions": lambda row: row.motions,
    }
    show(rows, columns)
    show_how(rows)


def _run_setup(options: argparse.Namespace) -> None:
    rows: list[SetUpRow] = []
    for scene in options.scene:
        found = set_up.measure(options.robot, None if scene == "none" else scene, options.rounds, options.seed, note)
        _print_setup(found)
        rows += found
    keep(options.output, "setup", rows)
    if options.problems:
        robot = Robot.load(options.robot)
        sets = [
            from_files.measure(path, robot, options.every, options.first, options.time) for path in options.problems
        ]
        solved = [each.row() for each in (*sets, *([from_files.together(sets)] if len(sets) > 1 else []))]
        columns: dict[str, Callable[[FromFilesRow], object]] = {
            "from files to a path": lambda row: row.set,
            "solved": lambda row: f"{row.solved} of {row.problems}",
            "read ms": lambda row: number(row.read),
            "checker ms": lambda row: number(row.checker),
            "plan ms": lambda row: number(row.plan),
            "median ms": lambda row: number(row.total),
            "mean ms": lambda row: number(row.total_mean),
        }
        print()
        show(solved, columns)
        keep(options.output, "from_files", solved)
    if options.boxes:
        _run_boxes(options)


def _run_boxes(options: argparse.Namespace) -> None:
    rows = [
        many_boxes.measure(options.robot, count, are_near, options.seed)
        for count in options.boxes
        for are_near in (False, True)
    ]
    columns: dict[str, Callable[[BoxesRow], object]] = {
        "boxes": lambda row: row.boxes,
        "where": lambda row: row.where,
        "scene s": lambda row: number(row.scene),
        "checker s": lambda row: number(row.checker),
        "first motion ms": lambda row: number(row.first_motion),
        "MB: scene": lambda row: number(row.scene_mb),
        "and checker": lambda row: number(row.checker_mb),
        "and motion": lambda row: number(row.motion_mb),
    }
    print()
    show(rows, columns)
    keep(options.output, "boxes", rows)


def _print_setup(rows: Sequence[SetUpRow]) -> None:
    first = rows[0]
    print(f"\n{first.robot} in {first.scene}: {first.pairs} pairs")
    columns: dict[str, Callable[[SetUpRow], object]] = {
        "step": lambda row: row.what,
        "ms": lambda row: number(row.milliseconds),
        "first verdict ms": lambda row: number(row.first_verdict),
        "first motion ms": lambda row: number(row.first_motion),
        "prepared again": lambda row: "-" if row.prepared is None else row.prepared,
    }
    show(rows, columns)


def _run_plans(options: argparse.Namespace) -> None:
    robot, settings = robot_of(options), Settings(options.range, options.time)
    rows: list[PlanRow] = []
    everything: dict[str, Tally] = {}
    for path in options.problems:
        ready = tasks(path, robot, options.every, options.first)
        tallies = plans.measure(ready, options.seeds, settings, options.rounds, note)
        if not tallies:
            note(f"{name_of_set(path)} is left out: no start and goal of its problems are free")
        found = [tally.row(name_of_set(path), planner) for planner, tally in tallies.items()]
        _print_plans(found)
        rows += found
        for planner, tally in tallies.items():
            everything.setdefault(planner, Tally()).merge(tally)
    if len(options.problems) > 1:
        found = [tally.row("all", planner) for planner, tally in everything.items()]
        _print_plans(found)
        rows += found
    keep(options.output, "plans", rows)


def _print_plans(rows: Sequence[PlanRow]) -> None:
    columns: dict[str, Callable[[PlanRow], object]] = {
        "set": lambda row: row.set,
        "planner": lambda row: row.planner,
        "solved": lambda row: f"{row.solved} of {row.tried}",
        "median ms": lambda row: number(row.median_ms),
        "mean ms": lambda row: number(row.mean_ms),
        "95 % ms": lambda row: number(row.p95_ms),
        "whole call ms": lambda row: number(row.call_median_ms),
        "refused": lambda row: row.refused,
        "colliding": lambda row: row.colliding,
        "deepest mm: median": lambda row: number(row.deepest_median_mm),
        "most": lambda row: number(row.deepest_mm),
    }
    if rows:
        print()
        show(rows, columns)


def _add_trajectories(parser: argparse.ArgumentParser) -> None:
    add_robot(parser)
    add_scenes(parser)
    parser.add_argument("--trajectories", type=positive, default=40, help="of 3 s each (default: %(default)s)")
    add_seed(parser)


def _run_trajectories(options: argparse.Namespace) -> None:
    rows: list[TrajectoryRow] = []
    for scene in options.scene:
        checker = checker_in(robot_of(options), scene)
        found = trajectories.measure(checker, options.trajectories, options.rounds, options.seed, note)
        print(f"\n{checker.robot.name} in {checker.scene.name}: trajectories of 3 s, 30 quintic pieces, all free")
        columns: dict[str, Callable[[TrajectoryRow], object]] = {
            "method": lambda row: row.method,
            "µs a trajectory": lambda row: f"{row.microseconds:.1f}",
            "x": ratio_of,
            "refused": lambda row: row.refused,
            "of": lambda row: row.trajectories,
        }
        show(found, columns)
        rows += found
    keep(options.output, "trajectories", rows)


def _add_distances(parser: argparse.ArgumentParser) -> None:
    add_robot(parser)
    add_scenes(parser)
    parser.add_argument("--states", type=positive, default=2000, help="free ones (default: %(default)s)")
    add_seed(parser)


def _run_distances(options: argparse.Namespace) -> None:
    rows: list[DistanceRow] = []
    for scene in options.scene:
        checker = checker_in(robot_of(options), scene)
        found = distances.measure(checker, options.states, options.rounds, options.seed, note)
        print(f"\n{checker.robot.name} in {checker.scene.name}: pairs within {distances.LIMIT} m, points and gradients")
        columns: dict[str, Callable[[DistanceRow], object]] = {
            "states": lambda row: row.states,
            "method": lambda row: row.method,
            "µs a state": lambda row: f"{row.microseconds:.2f}",
            "x": ratio_of,
            "near pairs": lambda row: f"{row.near:.1f}",
            "error, m": lambda row: "–" if row.error is None else f"{row.error:.0e}",
        }
        show(found, columns)
        rows += found
    keep(options.output, "distances", rows)


SUBCOMMANDS = {
    "distances": Subcommand("distances of near pairs beside other libraries", _add_distances, _run_distances),
    "motions": Subcommand("proved motions beside motions that others sample", _add_motions, _run_motions),
    "setup": Subcommand("loading, building a checker, changing its scene", _add_setup, _run_setup),
    "trajectories": Subcommand("proved trajectories beside samples at 1 kHz", _add_trajectories, _run_trajectories),
    "plans": Subcommand("searches and whole plans on MotionBenchMaker problems", _add_plans, _run_plans, 3),
}
