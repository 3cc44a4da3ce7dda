"""A planar robot's configuration space as an OMPL state space.

In: a planar robot, and how its root moves. Out: `PlanarSpace`: an OMPL state space, and conversions between its states
and configurations. The root is an SE2, Dubins or Reeds-Shepp space; with joints, the space is a compound of the root
and one part for each joint.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from ompl import base

from plannercheck.common.angles import nearest_turns, wrapped
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.ompl.curved_space import CurvedSpace
from plannercheck.ompl.joint_space import bounded_space, bounds_of
from plannercheck.ompl.projections import register_projection
from plannercheck.planar.curves import Curve, Curves, check_curve
from plannercheck.planar.motion_sampling import MotionSampler
from plannercheck.planar.robot import Robot


class PlanarSpace(CurvedSpace):
    """The configuration space of a planar robot.

    Attributes:
        continuous: (nq,) which numbers are angles without limits.
        is_straight: Whether motions are straight, number by number; else the root follows curves.
        curves: These curves, taken apart; None if motions are straight.
    """

    def __init__(self, robot: Robot, curve: Curve = "straight", turning_radius: float | None = None) -> None:
        """Reads the robot, which has limits of x and y if its root is free, and how the root moves."""
        _check(robot, curve, turning_radius)
        self._curve, self._radius = curve, turning_radius
        self.is_straight = curve == "straight"
        self.curves = Curves(curve, turning_radius) if turning_radius is not None else None
        self._free = robot.is_free
        self._lower, self._upper = robot.lower, robot.upper
        self._width = robot.nq
        self._first = 3 if robot.is_free else 0  # number of the first joint
        self._is_root_alone = robot.is_free and robot.nq == 3
        self.continuous = robot.angles

    def ompl_space(self) -> Any:
        """A new OMPL state space."""
        return self._numbered(self._root() if self._is_root_alone else self._compound(), self._width)

    def _root(self) -> Any:
        made = {
            "straight": base.SE2StateSpace,
            "dubins": lambda: base.DubinsStateSpace(self._radius),
            "reeds_shepp": lambda: base.ReedsSheppStateSpace(self._radius),
        }
        root = made[self._curve]()
        root.setBounds(bounds_of(self._lower[:2], self._upper[:2]))
        return root

    def _compound(self) -> Any:
        space = base.CompoundStateSpace()
        if self._free:
            space.addSubspace(self._root(), 1.0)
        for k in range(self._first, self._width):
            limits = self._lower[k : k + 1], self._upper[k : k + 1]
            space.addSubspace(base.SO2StateSpace() if self.continuous[k] else bounded_space(*limits), 1.0)
        register_projection(space)
        return space

    def write(self, state: Any, q: Sequence[float] | Floats) -> None:
        """Sets an OMPL state to a configuration (nq,); free angles are brought to [-pi, pi)."""
        if self._free:
            root = state if self._is_root_alone else state[0]
            root.setX(float(q[0]))
            root.setY(float(q[1]))
            root.setYaw(float(wrapped(np.asarray(q[2]))))
        for k in range(self._first, self._width):
            part = state[k - self._first + self._free]
            if self.continuous[k]:
                part.value = float(wrapped(np.asarray(q[k])))
            else:
                part[0] = float(q[k])

    def differences(self, q0: Floats, q1: Floats) -> Floats:
        """Differences from configurations (…, nq) to others, number by number; free angles take the short way."""
        return np.where(self.continuous, nearest_turns(q0, q1), q1) - q0

    def curve_steps(self, s1: Any, s2: Any, sampler: MotionSampler, resolution: float | None) -> int:
        """How many steps a curved motion needs: no point moves over `resolution` m in one."""
        assert self.curves is not None
        q0 = np.array(self.read(s1))
        way = self.curves.way(q0, q0 + self.differences(q0, np.array(self.read(s2))), sampler)
        return int(sampler.steps_of_way(np.array([way]), resolution)[0])


def _check(robot: Robot, curve: Curve, turning_radius: float | None) -> None:
    check_curve(robot, curve, turning_radius)
    if robot.is_free and not np.isfinite([*robot.lower[:2], *robot.upper[:2]]).all():
        raise PlannercheckError(
            f"x and y of {robot.name!r} have no limits, planning needs them: give the scene bounds, "
            "or the robot (robot.within)"
        )
    for name, low, high in zip(robot.joint_names, robot.lower, robot.upper, strict=True):
        if np.isinf(low) != np.isinf(high):
            raise PlannercheckError(f"joint {name!r} of {robot.name!r} needs both limits or none")
