"""What a gate is told, once for all chunks.

In: a robot, numbers. Out: `GateSettings`, every number a row of the robot's joints.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.real_numbers import positive_number
from plannercheck.robots.robot import Robot
from plannercheck.trajectories.controllers import CONTROLLERS, Controller
from plannercheck.trajectories.joint_columns import check_plain_joints
from plannercheck.trajectories.joint_limits import largest_accelerations, largest_speeds

# Controllers that run positions without velocities.
OF_POSITIONS: tuple[Controller, ...] = tuple(name for name in CONTROLLERS if name != "motoros2")


@dataclass(frozen=True, eq=False)
class GateSettings(OwnsArrays):
    """The settings of a gate.

    Attributes:
        controller: Who runs the chunks.
        velocity: (nq,) largest speeds, rad/s and m/s.
        acceleration: (nq,) largest accelerations, rad/s² and m/s²; inf where there is no limit.
        tube: (nq,) by how much joints may be off, rad and m.
        margin: How far bodies have to stay apart, m.
        brake: (nq,) decelerations of a stop, rad/s² and m/s².
        tolerance: What comes nearer than this to the margin may be refused, m.
    """

    controller: Controller
    velocity: Floats
    acceleration: Floats
    tube: Floats
    margin: float
    brake: Floats
    tolerance: float

    def as_json(self) -> dict[str, Any]:
        """Numbers and lists; a joint without a largest acceleration has None."""
        rows = {name: getattr(self, name).tolist() for name in ("velocity", "acceleration", "tube", "brake")}
        rows["acceleration"] = [None if value == np.inf else value for value in rows["acceleration"]]
        return {"controller": self.controller, **rows, "margin": self.margin, "tolerance": self.tolerance}


def settings_of(
    robot: Robot,
    controller: Controller,
    velocity: ArrayLike | str | Path | None,
    acceleration: ArrayLike | str | Path | None,
    tube: Floats,
    margin: float,
    brake: ArrayLike | None,
    tolerance: float,
) -> GateSettings:
    """Settings from what a caller gives; the tube is checked already. Errors name what is missing."""
    check_plain_joints(robot)
    if controller not in OF_POSITIONS:
        if controller == "motoros2":
            raise PlannercheckError("motoros2 refuses points without velocities, and chunks have positions alone")
        raise unknown_name("controller", controller, OF_POSITIONS)
    margin = positive_number(margin, "margin must be a length of at least 0, m", or_zero=True)
    speeds = largest_speeds(robot, velocity)
    bends = np.full(robot.nq, np.inf) if acceleration is None else largest_accelerations(robot, acceleration)
    decelerations = bends if brake is None else largest_accelerations(robot, brake, "brake")
    _check_finite(robot, speeds, "no largest speed, by which jumps are told: give velocity=")
    _check_finite(robot, decelerations, "no deceleration of stops: give brake=")
    return GateSettings(controller, speeds, bends, tube, margin, decelerations, float(tolerance))


def _check_finite(robot: Robot, row: Floats, lacking: str) -> None:
    if not np.isfinite(row).all():
        raise PlannercheckError(f"joint {robot.joint_names[int(np.argmin(np.isfinite(row)))]!r} has {lacking}")
