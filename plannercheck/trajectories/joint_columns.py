"""Columns of trajectories by the names of joints.

In: joints that take one number each, names as a file has them. Out: the column of each joint.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from plannercheck.common.errors import PlannercheckError, shortened
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
    if len(robot.joint_names) != robot.nq:
        raise PlannercheckError(
            f"needs a robot whose joints take one number each: choose a group; {robot.name}'s"
            f" {robot.configuration_map.described_columns()}"
        )


def columns_of(names: Sequence[str], robot: Joints) -> list[int]:
    """The column of each of the robot's joints, in its order; the names must be its joints, each once."""
    for name in names:
        if name not in robot.joint_names:
            known = ", ".join(robot.joint_names)
            raise PlannercheckError(f"has joint {shortened(name)!r}, which {robot.name} has not: {known}")
    missing = [name for name in robot.joint_names if name not in names]
    if missing or len(set(names)) != len(names):
        raise PlannercheckError(f"must have each joint of {robot.name} once: {', '.join(missing or names)}")
    return [names.index(name) for name in robot.joint_names]
