"""The checker for planning with a robot without a group that has continuous joints: these are angles.

In: a checker. Out: `angle_checker`: the same checker for a group of all joints that follow no other joint, as the
command line has it; in a group, a continuous joint is one angle. `angle_end` brings a start or a goal to that group.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from plannercheck.checking.protocols import AnyChecker
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import Configuration
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.checker import Checker
from plannercheck.ompl.start_and_goal import checked_end
from plannercheck.planar.checker import Checker as PlanarChecker
from plannercheck.robots.configurations import is_continuous, joint_by_name
from plannercheck.robots.joint_values import own_joints
from plannercheck.robots.robot import Robot

Some = TypeVar("Some", bound=AnyChecker)

# Given followers may be off by so much, rad or m: rounding of cosines and sines.
_SAME = 1e-9

_MADE: WeakKeyDictionary[Checker, Checker] = WeakKeyDictionary()


def angle_checker(checker: Some) -> Some:
    """The checker itself, or the same one for a group in which continuous joints are angles; made once."""
    if not isinstance(checker, Checker) or not _has_pairs_of_numbers(checker.robot):
        return checker
    if checker not in _MADE:
        robot = checker.robot
        _MADE[checker] = checker.with_group(own_joints(robot.model, robot.mimics), "all joints")
    return _MADE[checker]  # type: ignore[return-value]  # a Checker, as the given one is


def check_checker(checker: object) -> None:
    """Raises an error unless something is a checker, in space or in the plane."""
    if not isinstance(checker, Checker | PlanarChecker):
        raise PlannercheckError(f"checker must be a pc.Checker or a pc.planar.Checker, not {checker!r:.80}")


def angle_end(checker: AnyChecker, planned: AnyChecker, q: Configuration, name: str) -> Floats:
    """A start or a goal, (nq,) of the checker that is planned by, or an error that uses its name.

    The configuration has one number for each joint, or is Pinocchio's, or values by names.

    Raises:
        PlannercheckError: If it is no configuration, or a joint that follows another one is not where that leads it.
    """
    if planned is checker or not isinstance(checker, Checker) or not isinstance(planned, Checker):
        return checked_end(planned, q, name)
    group = planned.robot
    if q.keys() == set(group.joint_names) if isinstance(q, Mapping) else np.shape(q) == (group.nq,):
        return checked_end(planned, q, name)
    whole = checker.robot
    row = checked_end(checker, q, name)
    angles = np.concatenate([_own_numbers(whole, name, row) for name in group.joint_names])
    off = np.abs(group.expand(angles) - row)
    if off.max(initial=0.0) > _SAME:
        raise PlannercheckError(
            f"{name}: the joints that follow others are off by {off.max():.3g}; give only those that follow none: "
            f"{', '.join(group.joint_names)}"
        )
    return angles


def _has_pairs_of_numbers(robot: Robot) -> bool:
    """Whether a continuous joint is cosine and sine."""
    if robot.group is not None:
        return False
    joints = (joint_by_name(robot.model, name) for name in robot.joint_names)
    return robot.remembered("pairs of numbers", lambda: any(map(is_continuous, joints)))


def _own_numbers(robot: Robot, name: str, row: Floats) -> Floats:
    """The numbers of a joint in a group, from a configuration (nq,) without one."""
    joint = joint_by_name(robot.model, name)
    own = row[joint.idx_q : joint.idx_q + joint.nq]
    return np.array([np.arctan2(own[1], own[0])]) if is_continuous(joint) else own
