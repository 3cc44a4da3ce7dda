"""A robot's joint space as OMPL has it.

In: a robot. Out: `JointSpace`: an OMPL state space, and how its states become configurations and back.

With bounded joints alone the space is a RealVectorStateSpace. Continuous joints of a planning group are SO2
spaces; then the space is a compound of one part a joint, weighted equally.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from ompl import base

from plannercheck.angles import short_way, wrapped
from plannercheck.configurations import is_continuous
from plannercheck.errors import PlannercheckError
from plannercheck.robot import Robot

Floats = NDArray[np.float64]


# Columns that are angles, of robots that have been planned for: asking Pinocchio takes a tenth of a short plan's time.
_CONTINUOUS: WeakKeyDictionary[Robot, NDArray[np.bool_]] = WeakKeyDictionary()


class JointSpace:
    """The joint space of a robot.

    Attributes:
        continuous: (nq,) which columns are angles without limits.
        is_straight: Motions are straight, joint by joint.
    """

    is_straight: Literal[True] = True

    def __init__(self, robot: Robot) -> None:
        """Looks at the joints.

        Raises:
            PlannercheckError: For a joint that takes several numbers, or that has no limits and is no angle.
        """
        self._lower, self._upper = robot.lower, robot.upper
        if robot not in _CONTINUOUS:
            _CONTINUOUS[robot] = _continuous_columns(robot)
        self.continuous = _CONTINUOUS[robot]
        self._turning = bool(self.continuous.any())
        self._columns = range(robot.nq)

    def ompl_space(self) -> Any:
        """A new OMPL state space."""
        if not self._turning:
            return bounded_space(self._lower, self._upper)
        space = base.CompoundStateSpace()
        for k, turning in enumerate(self.continuous.tolist()):
            part = base.SO2StateSpace() if turning else bounded_space(self._lower[k : k + 1], self._upper[k : k + 1])
            space.addSubspace(part, 1.0)
        return space

    def read(self, state: Any) -> list[float]:
        """The configuration of an OMPL state, nq numbers."""
        if not self._turning:
            return [state[k] for k in self._columns]  # twice as fast as a slice (measured)
        return [state[k].value if turning else state[k][0] for k, turning in enumerate(self.continuous.tolist())]

    def write(self, state: Any, q: Sequence[float] | Floats) -> None:
        """Sets an OMPL state to a configuration (nq,); angles are brought to [-pi, pi)."""
        if not self._turning:
            state[0 : len(self._columns)] = [float(value) for value in q]
            return
        for k, turning in enumerate(self.continuous.tolist()):
            if turning:
                state[k].value = float(wrapped(np.asarray(q[k])))
            else:
                state[k][0] = float(q[k])

    def differences(self, q0: Floats, q1: Floats) -> Floats:
        """From configurations (…, nq) to others, joint by joint; angles take the short way."""
        differences = q1 - q0
        return np.where(self.continuous, short_way(differences), differences) if self._turning else differences

    def end(self, q0: list[float], q1: list[float]) -> list[float]:
        """The end of a motion from q0 to q1 on which angles take the short way."""
        if not self._turning:
            return q1
        way = self.differences(np.array(q0), np.array(q1))
        return [a + d if turns else b for a, b, d, turns in zip(q0, q1, way.tolist(), self.continuous, strict=True)]

    def state(self, information: Any, q: Sequence[float] | Floats) -> Any:
        """A new OMPL state of a configuration (nq,); it frees itself, which states of the space do not."""
        state = information.allocState()
        self.write(state, q)
        return state


def bounded_space(lower: Floats, upper: Floats) -> Any:
    """An OMPL space of real numbers between bounds (k,)."""
    bounds = base.RealVectorBounds(len(lower))
    for k, (low, high) in enumerate(zip(lower.tolist(), upper.tolist(), strict=True)):
        bounds.setLow(k, low)
        bounds.setHigh(k, high)
    space = base.RealVectorStateSpace(len(lower))
    space.setBounds(bounds)
    return space


def _continuous_columns(robot: Robot) -> NDArray[np.bool_]:
    model = robot.model
    joints = [model.joints[model.getJointId(name)] for name in robot.joint_names]
    turning = [robot.group is not None and is_continuous(joint) for joint in joints]
    for name, joint, free in zip(robot.joint_names, joints, turning, strict=True):
        if joint.nq != 1 and not free:
            raise PlannercheckError(
                f"joint {name!r} of {robot.name} takes {joint.nq} numbers, planning needs one each: choose "
                "a planning group without it (robot.with_group), in which continuous joints are angles"
            )
    for name, free, low, high in zip(robot.joint_names, turning, robot.lower, robot.upper, strict=True):
        if not free and not (np.isfinite(low) and np.isfinite(high)):
            raise PlannercheckError(
                f"joint {name!r} of {robot.name} has limits {low:g} to {high:g}: planning needs both"
            )
    columns = np.array(turning, dtype=bool)
    columns.flags.writeable = False
    return columns
