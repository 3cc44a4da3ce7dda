"""A robot's joint space as an OMPL state space.

In: a robot. Out: `JointSpace`: an OMPL state space, and conversions between its states and configurations.

If all joints are bounded, the space is a RealVectorStateSpace. Continuous joints of a planning group are SO2 spaces;
then the space is a compound with one part for each joint, weighted equally. If another joint follows a continuous joint
at half the speed, or as a slide, a whole turn changes the robot's pose. Such a joint is a real number between bounds of
our own, and moves as the certifier judges it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from ompl import base

from plannercheck.common.angles import nearest_turn, nearest_turns, wrapped
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.ompl.projections import register_projection
from plannercheck.ompl.state_numbers import NumberedSpace
from plannercheck.robots.configurations import PLAIN, ConfigurationMap, is_continuous
from plannercheck.robots.robot import Robot


class JointSpace(NumberedSpace):
    """The joint space of a robot.

    Attributes:
        continuous: (nq,) which columns are angles that a whole turn does not change.
        is_straight: True: motions are straight, joint by joint.
        lower: (nq,) the least value of each column, rad or m; of angles there is none.
        upper: (nq,) the largest one.
        depends_on_ends: Whether the bounds of some joint depend on the configurations that they have to include.
    """

    is_straight: Literal[True] = True

    def __init__(self, robot: Robot, *held: Floats) -> None:
        """Reads the joints.

        Args:
            robot: The robot.
            held: Configurations (nq,) that the bounds of joints without limits of their own have to include.

        Raises:
            PlannercheckError: If a joint takes several numbers, or has no limits and is no angle.
        """
        # Kept, since questions to Pinocchio would take a tenth of a short plan's time.
        found = robot.remembered(("joint space", robot.group), lambda: _columns(robot))
        self.continuous, self.lower, self.upper, self._free = found
        if self._free:
            self.lower, self.upper = self.lower.copy(), self.upper.copy()
            self.lower[self._free] = np.min([self.lower, *held], axis=0)[self._free]
            self.upper[self._free] = np.max([self.upper, *held], axis=0)[self._free]
        self.depends_on_ends = bool(self._free)
        self._names = robot.joint_names
        self._turns: list[bool] = self.continuous.tolist()
        self._turning = any(self._turns)
        self._width = robot.nq

    def ompl_space(self) -> Any:
        """A new OMPL state space."""
        space = self._compound() if self._turning else bounded_space(self.lower, self.upper)
        return self._numbered(space, self._width)

    def _compound(self) -> Any:
        space = base.CompoundStateSpace()
        for k, turning in enumerate(self.continuous.tolist()):
            part = base.SO2StateSpace() if turning else bounded_space(self.lower[k : k + 1], self.upper[k : k + 1])
            space.addSubspace(part, 1.0)
        register_projection(space)
        return space

    def bound(self, space: Any, lower: Floats, upper: Floats) -> None:
        """Sets the bounds (nq,) of one of these spaces, within which its samples are; angles have none."""
        if not self._turning:
            space.setBounds(bounds_of(lower, upper))
            return
        for k in np.flatnonzero(~self.continuous).tolist():
            space.getSubspace(k).setBounds(bounds_of(lower[k : k + 1], upper[k : k + 1]))

    def write(self, state: Any, q: Sequence[float] | Floats) -> None:
        """Sets an OMPL state to a configuration (nq,); angles are brought to [-pi, pi).

        Raises:
            PlannercheckError: If a joint without limits that is no SO2 part is beyond the space's bounds.
        """
        for k in self._free:
            if not self.lower[k] <= q[k] <= self.upper[k]:
                raise PlannercheckError(
                    f"joint {self._names[k]!r} is {q[k]:g}, the space reaches from {self.lower[k]:g} to "
                    f"{self.upper[k]:g}: another joint follows it, so that whole turns count; plan() makes the space "
                    "as large as its start and goal need"
                )
        if not self._turning:
            state[0 : self._width] = np.asarray(q, dtype=np.float64).tolist()
            return
        for k, turning in enumerate(self.continuous.tolist()):
            if turning:
                state[k].value = float(wrapped(np.asarray(q[k])))
            else:
                state[k][0] = float(q[k])

    def differences(self, q0: Floats, q1: Floats) -> Floats:
        """Differences from configurations (…, nq) to others, joint by joint; angles take the short way."""
        return (np.where(self.continuous, nearest_turns(q0, q1), q1) if self._turning else q1) - q0

    def end(self, q0: list[float], q1: list[float]) -> list[float]:
        """The end of a motion from q0 to q1 on which angles take the short way."""
        if not self._turning:
            return q1
        return [nearest_turn(a, b) if turns else b for a, b, turns in zip(q0, q1, self._turns, strict=True)]


def bounded_space(lower: Floats, upper: Floats) -> Any:
    """An OMPL space of real numbers between bounds (k,)."""
    space = base.RealVectorStateSpace(len(lower))
    space.setBounds(bounds_of(lower, upper))
    return space


def bounds_of(lower: Floats, upper: Floats) -> Any:
    """OMPL's bounds (k,) each."""
    bounds = base.RealVectorBounds(len(lower))
    bounds.low, bounds.high = lower.tolist(), upper.tolist()
    return bounds


def _columns(robot: Robot) -> tuple[NDArray[np.bool_], Floats, Floats, list[int]]:
    """(nq,) columns whose whole turns change no pose, bounds, and columns with bounds of our own."""
    if not robot.nq:
        raise PlannercheckError(f"robot {robot.name!r} has no joint that moves: there is nothing to plan")
    model = robot.model
    joints = [model.joints[model.getJointId(name)] for name in robot.joint_names]
    angles = [robot.group is not None and is_continuous(joint) for joint in joints]
    for name, joint, angle in zip(robot.joint_names, joints, angles, strict=True):
        if joint.nq != 1 and not angle:
            raise PlannercheckError(
                f"joint {name!r} of {robot.name} takes {joint.nq} numbers, a space of joints has one for each: "
                "choose a planning group (robot.with_group), in which a continuous joint is one angle"
            )
    for name, angle, low, high in zip(robot.joint_names, angles, robot.lower, robot.upper, strict=True):
        if not angle and not (np.isfinite(low) and np.isfinite(high)):
            raise PlannercheckError(
                f"joint {name!r} of {robot.name} has limits {low:g} to {high:g}: planning needs both"
            )
    columns = robot.configuration_map.turning_columns()
    lower, upper = robot.lower, robot.upper
    free: list[int] = np.flatnonzero(np.array(angles, dtype=bool) & ~columns).tolist()
    for k in free:
        upper[k] = free_range(robot.configuration_map, k)
        lower[k] = -upper[k]
    for shared in (columns, lower, upper):
        shared.flags.writeable = False
    return columns, lower, upper, free


def free_range(used: ConfigurationMap, column: int) -> float:
    """The bound of an angle without limits in planning, rad: a whole turn of its own and of each follower."""
    followers = (used.columns == column) & (used.roles != PLAIN) & (used.multipliers != 0)
    return float(np.pi * (1 / np.abs(used.multipliers[followers])).max(initial=1.0))
