"""Configurations with one number a joint, or by names of joints, in space or in the plane.

In: a robot, rows or a mapping of joint names to values. Out: configurations in the robot's order.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.checking.protocols import AnyRobot
from plannercheck.robots.joint_values import row_of_named
from plannercheck.robots.robot import Robot


def given_configurations(robot: AnyRobot, q: ArrayLike) -> NDArray[np.float64]:
    """Configurations (n, nq) of (nq,) or (n, nq); of a robot without a group also of one number for each joint."""
    return robot.joint_values.configurations(q) if isinstance(robot, Robot) else robot.check_configurations(q)


def named_configuration(robot: AnyRobot, values: Mapping[str, ArrayLike]) -> NDArray[np.float64]:
    """A robot's configuration as a row (1, nq), from the values of each joint by its name, rad or m.

    Raises:
        PlannercheckError: If a joint is missing or not one of the robot's, or a value is no number.
    """
    if isinstance(robot, Robot):
        return robot.joint_values.named(values)
    return row_of_named(values, robot.joint_names, [1] * len(robot.joint_names))[None]
