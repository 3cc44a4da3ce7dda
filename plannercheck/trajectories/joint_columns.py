"""Columns of trajectories by the names of joints.

In: joints that take one number each, names as a file has them. Out: the column of each joint.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.robots.robot import Robot


class Joints(Protocol):
    """Whose joints a trajectory has to have: a robot, or what is known of one."""

    @property
    def name(self) -> str:
        """For errors."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints, in the order of the columns."""


class NamedJoints(NamedTuple):
    """Joints of which names are all that is known."""

    name: str
    joint_names: tuple[str, ...]


def check_robot(robot: Robot) -> None:
    """Raises if this is no robot in space."""
    if not isinstance(robot, Robot):
        raise PlannercheckError(f"needs a pc.Robot, not {robot!r:.80}: pc.Robot.load reads one")


def check_plain_joints(robot: Robot) -> None:
    """Raises if a joint takes several numbers: a trajectory has one column a joint."""
    check_robot(robot)
    if len(robot.joint_names) != robot.nq:
        raise PlannercheckError(
            f"needs a robot whose joints take one number each: choose a group; {robot.name}'s"
            f" {robot.configuration_map.described_columns()}"
        )


def check_held(robot: Robot, held: Mapping[str, float]) -> None:
    """Raises if a robot holds one of these joints outside its group at another value."""
    if not held:
        return
    posed, q = robot.holding(held), robot.reference
    if not np.array_equal(posed.expand(q), robot.expand(q)):
        listed = ", ".join(f"{name!r}: {value!r}" for name, value in held.items())
        raise PlannercheckError(
            f"holds joints outside the planning group elsewhere than the robot: give robot.holding({{{listed}}})"
        )


def columns_of(names: Sequence[str], robot: Joints, may_hold: bool = False) -> list[int]:
    """The column of each of the robot's joints, in its order.

    Args:
        names: Those joints, each once.
        robot: Whose they are.
        may_hold: Whether there may be other names as well.
    """
    for name in names:
        if name not in robot.joint_names and not (may_hold and set(robot.joint_names) <= set(names)):
            error = unknown_name(f"joint of {robot.name}", name, robot.joint_names)
            raise PlannercheckError(f"{error}; leave other joints out, or choose a group that has them")
    twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
    missing = [name for name in robot.joint_names if name not in names]
    if twice or missing:
        fault = f"names {', '.join(twice)} more than once" if twice else f"lacks {', '.join(missing)}"
        raise PlannercheckError(f"{fault}: give each joint of {robot.name} once")
    return [names.index(name) for name in robot.joint_names]
