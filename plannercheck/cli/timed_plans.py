"""`plannercheck plan --timed`: a plan as a trajectory that is proved as the controller will run it.

In: a plan that was found, options. Out: a JointTrajectory in a file, and a line on the terminal; nothing if it is not
proved.
"""

from __future__ import annotations

import argparse

import numpy as np

from plannercheck.checking.protocols import AnyChecker
from plannercheck.cli.common import limits_of, numbers_of
from plannercheck.cli.unused_options import check_used
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.checker import Checker
from plannercheck.ompl.plans import Plan
from plannercheck.planar.robot_files import is_planar
from plannercheck.timing.time_path import UnprovedPathError, time_path
from plannercheck.trajectories.trajectory import Trajectory

# What counts with --timed alone.
OPTIONS = ("--velocity", "--acceleration", "--blend", "--tube")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options."""
    parser.add_argument(
        "--timed",
        action="store_true",
        help="round the plan's corners, time it by TOPP-RA and write a JointTrajectory (yaml or json) that is "
        "proved as joint_trajectory_controller runs it",
    )
    parser.add_argument(
        "--velocity",
        metavar="A,B,...",
        help="with --timed: largest speeds, rad/s and m/s, one number or one a joint, or MoveIt's joint_limits.yaml; "
        "default: the URDF's",
    )
    parser.add_argument(
        "--acceleration", metavar="A,B,...", help="with --timed: largest accelerations, rad/s² and m/s², likewise"
    )
    parser.add_argument(
        "--blend",
        type=float,
        default=0.1,
        metavar="RAD",
        help="with --timed: how far from a corner its blend may pass, rad; 0: stop at each; default: 0.1",
    )
    parser.add_argument(
        "--tube",
        default="0",
        metavar="A,B,...",
        help="with --timed: how far joints may be off the trajectory in the proof, rad and m; the plan's --padding is "
        "room for it and is not asked for as well; default: 0",
    )


def check_arguments(options: argparse.Namespace) -> None:
    """Raises for options that are missing, or count for nothing."""
    if not options.timed:
        check_used(options, OPTIONS, "with --timed")
    elif is_planar(options.robot, "robots"):
        raise PlannercheckError("--timed is for robots in space: trajectories have one column a joint")
    elif options.acceleration is None:
        raise PlannercheckError("--timed needs --acceleration: numbers, or MoveIt's joint_limits.yaml")


def timed_plan(checker: AnyChecker, found: Plan, options: argparse.Namespace) -> Trajectory | None:
    """The trajectory, described on the terminal; None if it is not proved."""
    assert isinstance(checker, Checker)  # `check_arguments`
    tube = numbers_of(options.tube, "--tube")
    if np.any(tube):
        checker = Checker(checker.robot, checker.scene, self_collision=not options.no_self_collision)
    velocity, acceleration = (
        None if text is None else limits_of(text, name)
        for text, name in ((options.velocity, "--velocity"), (options.acceleration, "--acceleration"))
    )
    assert acceleration is not None
    try:
        made = time_path(checker, found, velocity, acceleration, options.blend, tube)
    except UnprovedPathError as error:
        print(f"not timed: {error}")
        return None
    timing = made.timing
    assert timing is not None
    print(
        f"timed: {made.duration:.3f} s, {timing.saved:.3f} s less than stopping at each corner; of {timing.corners} "
        f"corners {timing.cut} had to be cut closer and {timing.stops} are stopped at; proved as "
        f"joint_trajectory_controller runs it, within a tube of {options.tube}, "
        f"with a tolerance of {timing.tolerance:g} m"
    )
    return made
