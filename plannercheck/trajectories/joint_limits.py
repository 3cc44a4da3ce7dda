"""Limits of speeds and accelerations: those of the URDF, and of MoveIt's joint_limits.yaml, which overrides them.

In: a robot, a file. Out: `JointLimits`, a number for each of the robot's joints, infinite where there is no limit.

The rules are MoveIt's (`RobotModelLoader`): has_velocity_limits: true takes max_velocity, false removes the URDF's
limit, and without this key the URDF's limit stays; likewise for accelerations, of which a URDF has none. A limit of 0
in a URDF is no limit. The scaling factors of the file are defaults of requests, not limits.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import OwnsArrays, named_numbers, shown_array
from plannercheck.common.checked_yaml import (
    Node,
    check_keys,
    error_context,
    mapping,
    number,
    parse_yaml,
    read_bytes,
    required,
)
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.robots.configurations import NO_LIMIT, joint_by_name
from plannercheck.robots.robot import Robot
from plannercheck.trajectories.joint_columns import check_plain_joints

# The keys between a file's top and its joints, as parameters of ROS nodes have them.
_WRAPPERS = ("/**", "ros__parameters", "robot_description_planning")

_KINDS = ("position", "velocity", "acceleration", "deceleration", "jerk", "effort")
_SOFT = ("has_soft_limits", "k_position", "k_velocity", "soft_lower_limit", "soft_upper_limit")
_LIMITS = (f"{part}_{kind}{end}" for kind in _KINDS for part, end in (("has", "_limits"), ("min", ""), ("max", "")))
_KEYS = (*_LIMITS, *_SOFT, "angle_wraparound")


@dataclass(frozen=True, eq=False)
class JointLimits(OwnsArrays):
    """Limits of a robot's joints.

    Attributes:
        velocity: (nq,) largest speeds, rad/s and m/s; inf where there is no limit.
        acceleration: (nq,) largest accelerations, rad/s² and m/s²; likewise.
    """

    velocity: Floats
    acceleration: Floats


def velocity_limits(robot: Robot) -> Floats:
    """(nq,) the URDF's largest speeds of a robot's joints, which take one number each; rad/s and m/s."""
    check_plain_joints(robot)
    joints = [joint_by_name(robot.model, name) for name in robot.joint_names]
    found = np.array([robot.model.velocityLimit[joint.idx_v] for joint in joints], dtype=np.float64)
    return np.where((found > 0) & (found < NO_LIMIT), found, np.inf)


def read(path: str | Path, robot: Robot) -> JointLimits:
    """Reads MoveIt's joint_limits.yaml.

    Args:
        path: The file. Its joints may be more or fewer than the robot's, but the URDF must have them.
        robot: Whose limits they are; its joints take one number each.

    Raises:
        PlannercheckError: If the file is malformed, or names a joint that the URDF has not.
    """
    velocity, acceleration = velocity_limits(robot), np.full(robot.nq, np.inf)
    with error_context(f"file {str(path)!r}"):
        joints = _joints(parse_yaml(read_bytes(Path(path))))
        for name, node in joints.items():
            if not robot.model.existJointName(name) and "/" not in name:  # e.g. "base/x", of MoveIt's virtual joints
                raise unknown_name("joint", name, list(robot.model.names)[1:])
            with error_context(f"joint {name!r}"):
                found = mapping(node, "it")
                check_keys(found, _KEYS)
                if name in robot.joint_names:
                    column = robot.joint_names.index(name)
                    velocity[column] = _limit(found, "velocity", velocity[column])
                    acceleration[column] = _limit(found, "acceleration", np.inf)
        _warn_of_positions(path, robot, joints)
    return JointLimits(velocity, acceleration)


def largest_speeds(robot: Robot, given: ArrayLike | str | Path | None) -> Floats:
    """(nq,) of numbers, one number or a joint_limits.yaml; the URDF's for None."""
    if given is None:
        return velocity_limits(robot)
    return read(given, robot).velocity if isinstance(given, str | Path) else positive_row(robot, given, "velocity")


def largest_accelerations(robot: Robot, given: ArrayLike | str | Path, name: str = "acceleration") -> Floats:
    """(nq,) of numbers, one number or a joint_limits.yaml; `name` is the argument's, for errors."""
    return read(given, robot).acceleration if isinstance(given, str | Path) else positive_row(robot, given, name)


def positive_row(robot: Robot, values: ArrayLike, name: str) -> Floats:
    """(nq,) of numbers, or of one number for all joints; an error unless all are more than 0."""
    row = named_numbers(values, name)
    if row.shape not in ((1,), (robot.nq,)) or not (row > 0).all():
        raise PlannercheckError(
            f"{name} must be a number more than 0, or {robot.nq}, one a joint, not {shown_array(values)}"
        )
    return np.broadcast_to(row, robot.nq)


def _joints(document: Node) -> Node:
    for key in _WRAPPERS:
        if key in document:
            document = mapping(document[key], repr(key))
    return mapping(required(document, "joint_limits"), "'joint_limits'")


def _limit(node: Node, kind: str, otherwise: float) -> float:
    """What a file says of a joint's largest speed or acceleration, or the URDF's if it says nothing."""
    has, most = f"has_{kind}_limits", f"max_{kind}"
    if has not in node:
        if most in node:
            raise PlannercheckError(f"has {most} without {has}, and MoveIt ignores it: add {has}: true")
        return otherwise
    if not isinstance(node[has], bool):
        raise PlannercheckError(f"{has!r} must be true or false, not {node[has]!r}")
    if not node[has]:
        return np.inf
    value = number(required(node, most), most)
    if value <= 0:
        raise PlannercheckError(f"{most!r} must be more than 0, not {value:g}")
    return value


def _warn_of_positions(path: str | Path, robot: Robot, joints: Node) -> None:
    keys = {"min_position", "max_position"}
    named = [name for name in joints if name in robot.joint_names and keys & {*mapping(joints[name], "it")}]
    if named:
        warnings.warn(
            f"file {str(path)!r}: its position limits ({', '.join(named)}) are not looked at: the URDF's count",
            stacklevel=3,
        )
