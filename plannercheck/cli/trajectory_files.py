"""Trajectories for commands: which controller runs them, and the file that holds one.

In: options, a file. Out: a `Trajectory`.
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import cast

from plannercheck.checking.protocols import AnyRobot
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.robot import Robot
from plannercheck.trajectories import CONTROLLERS, Controller, Trajectory

_DEFAULT: Controller = "jtc"


def add_controller_argument(parser: argparse._ActionsContainer, what: str) -> None:
    """Adds --controller; `what` begins its help."""
    parser.add_argument(
        "--controller",
        choices=CONTROLLERS,
        help=f"{what} what this controller runs between the points of --path; a message with velocities is taken so "
        "anyway; default: jtc, ros2_control's joint_trajectory_controller",
    )


def add_start_time_argument(parser: argparse._ActionsContainer) -> None:
    """Adds --start-time."""
    parser.add_argument(
        "--start-time",
        type=float,
        metavar="S",
        help="with --controller: the scene's clock where the trajectory begins, if something in the scene moves; "
        "default: 0",
    )


def listed_numbers(text: str) -> tuple[float, ...]:
    """The numbers of an option's text, with commas between them."""
    try:
        return tuple(float(word) for word in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be numbers separated by commas, not {text!r:.80}") from None


def trajectory_of(
    path: Path,
    robot: AnyRobot,
    controller: str | None,
    start: Sequence[float] | None = None,
    message: int | None = None,
) -> Trajectory:
    """The trajectory in a file, one of several messages, as a controller runs it; None is "jtc".

    The caller takes joints that the file holds from the robot. It begins where the robot stands (nq,); None: at the
    first point.
    """
    if not isinstance(robot, Robot):
        raise PlannercheckError(f"{robot.name!r} is planar, and trajectories are of robots in space")
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*trajectory_start is not looked at")
        given = None if start is None else list(start)
        return Trajectory.load(path, robot, cast("Controller", controller or _DEFAULT), given, message)
