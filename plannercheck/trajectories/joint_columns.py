"""Columns of trajectories by the names of joints.

In: joints that take one number each, names as a file has them. Out: the column of each joint.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

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


def check_plain_joints(robot: Robot) -> None:
    """Raises if a joint takes several numbers: a trajectory has one column a joint."""
    if not isinstance(robot, Robot):
        raise PlannercheckError(f"needs a pc.Robot, not {robot!r:.80}: pc.Robot.load reads one")
    if len(robot.joint_names) != robot.nq:
        raise PlannercheckError(
            f"needs a robot whose joints take one number each: choose a group; {robot.name}'s"
            f" {robot.configuration_map.described_columns()}"
        )


def columns_of(names: Sequence[str], robot: Joints) -> list[int]:
    """The column of each of the robot's joints, in its order; the names must be its joints, each once."""
    for name in names:
        if name not in robot.joint_names:
            error = unknown_name(f"joint of {robot.name}", name, robot.joint_names)
            raise PlannercheckError(f"{error}; leave other joints out, or choose a group that has them")
    twice = [name for name in robot.joint_names if names.count(name) > 1]
    missing = [name for name in robot.joint_names if name not in names]
    if twice or missing:
        fault = f"names {', '.join(twice)} more than once" if twice else f"lacks {', '.join(missing)}"
        raise PlannercheckError(f"{fault}: give each joint of {robot.name} once")
    return [names.index(name) for name in robot.joint_names]
