"""Columns of trajectories by the names of joints.

In: joints that take one number each, names as a file has them. Out: the column of each joint.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.model_comparisons import Followers
from plannercheck.robots.configurations import followed
from plannercheck.robots.description import RobotDescription, description_of
from plannercheck.robots.robot import Robot
from plannercheck.robots.urdf import Mimic
from plannercheck.trajectories.controllers import Points

# How far a file's value of a joint that follows another one may be off what the leader gives: rounding.
_ROUNDING = 1e-9


class Joints(Protocol):
    """Whose joints a trajectory has to have: a robot, or what is known of one."""

    @property
    def name(self) -> str:
        """For errors."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints, in the order of the columns."""

    @property
    def mimics(self) -> Mapping[str, Mimic] | None:
        """The joints that follow others, by name; None if they are not known."""


class NamedJoints(NamedTuple):
    """Joints of which names are all that is known."""

    name: str
    joint_names: tuple[str, ...]
    mimics: Mapping[str, Mimic] | None = None


def joints_of_robot(given: str | Path | RobotDescription) -> tuple[tuple[str, ...], int, Followers]:
    """The names of a robot's joints, the numbers of its configurations, and the joints that follow these."""
    robot = Robot.from_description(description_of(given))
    every = {name: followed(name, robot.mimics, robot.joint_names) for name in robot.mimics}
    return robot.joint_names, robot.nq, {name: each for name, each in every.items() if name != each[0]}


def joints_of_proof(names: Sequence[str], followers: Followers | None) -> NamedJoints:
    """A proof's joints, and those that follow them if the robot is known."""
    mimics = None if followers is None else {name: Mimic(*each) for name, each in followers.items()}
    return NamedJoints("the proof", tuple(names), mimics)


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


def check_order(robot: Robot, points: Points | None, prefix: str = "") -> None:
    """Raises if the names of a trajectory's columns have a joint of the robot in another joint's column.

    A cell puts a prefix before its names. Without points or names, nothing is known of the columns.
    """
    if points is None or points.joint_names == robot.joint_names:
        return
    names = [name.removeprefix(prefix) for name in points.joint_names]
    if len(names) != len(robot.joint_names) or len(names) != robot.nq:
        return
    for k, (name, own) in enumerate(zip(names, robot.joint_names, strict=True)):
        if name != own and name in robot.joint_names:
            raise PlannercheckError(
                f"column {k} is joint {name!r} by the trajectory's joint_names, but {own!r} of {robot.name!r}: give "
                f"the columns in the robot's order, {', '.join(robot.joint_names)}"
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
        names: The joints, each once.
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


def without_followers(names: Sequence[str], tables: Mapping[str, Floats], robot: Joints) -> list[int]:
    """The columns but those of joints that follow the robot's.

    Args:
        names: Joints of the columns, the robot's among them.
        tables: (n, names) by quantity: "positions", and what else the file has.
        robot: Whose joints others follow.

    Raises:
        PlannercheckError: If a follower is elsewhere than its leader takes it.
    """
    kept = []
    for k, name in enumerate(names):
        leader, multiplier, offset = followed(name, robot.mimics or {}, robot.joint_names)
        if name == leader or leader not in robot.joint_names:
            kept.append(k)
            continue
        for quantity, table in tables.items():
            right = multiplier * table[:, names.index(leader)] + (offset if quantity == "positions" else 0.0)
            wrong = ~np.isclose(table[:, k], right, rtol=_ROUNDING, atol=_ROUNDING, equal_nan=True)
            if wrong.any():
                point = int(np.argmax(wrong))
                raise PlannercheckError(
                    f"point {point}: joint {name!r} follows {leader!r}, which makes its {quantity}"
                    f" {right[point]:.9g}, not {table[point, k]:.9g}: correct them, or leave {name!r} out"
                )
    return kept


def moved_outside(moving: Sequence[str], robot: Joints) -> PlannercheckError:
    """The error of joints that move though a group has not got them; those that follow others are in no group."""
    leaders = dict.fromkeys(followed(name, robot.mimics or {}, ())[0] for name in moving)
    unknown = ", or leave out those that follow its joints, which the robot tells (--robot, robot=)"
    hint = unknown if robot.mimics is None else ""
    return PlannercheckError(
        f"moves {', '.join(moving)}, outside the planning group: choose a group with {', '.join(leaders)}{hint}"
    )
