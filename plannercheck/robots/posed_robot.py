"""The poses of a robot, their error bounds, and results that are stored with it.

In: the parts of a robot. Out: `PosedRobot`, the half of `Robot` for poses: its links by name, random configurations,
poses of links, the proved bounds of their rounding, and results that are computed once a robot.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.shapes import GeometryObject
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import Configuration, read_only
from plannercheck.common.core import core
from plannercheck.common.errors import unknown_name
from plannercheck.robots.configurations import ConfigurationMap
from plannercheck.robots.forward_kinematics import ForwardKinematics
from plannercheck.robots.joint_values import JointValues
from plannercheck.robots.kinematic_error import KinematicRounding
from plannercheck.robots.kinematics import JointTable
from plannercheck.robots.loading import RobotParts

Result = TypeVar("Result")

_SAMPLES = 32  # configurations of `sampled_link_poses`: four of the blocks of eight that are judged at a time


class PosedRobot:
    """The half of `Robot` that poses links; `Robot` sets what it declares."""

    bodies: tuple[GeometryObject, ...]
    reference: Floats
    _parts: RobotParts
    _map: ConfigurationMap
    _forward: ForwardKinematics

    @property
    def link_names(self) -> tuple[str, ...]:
        """The URDF's links in the order of Pinocchio's body frames."""
        return self._parts.tree.names

    def parts_of_files(self) -> RobotParts:
        """What the robot is made of, as its files say it; for robots that are made of it, which must not change it."""
        return self._parts

    def link_index(self, name: str) -> int:
        """Index into link_names."""
        if not isinstance(name, str) or name not in self._link_indices:
            raise unknown_name("link", name, self.link_names)
        return self._link_indices[name]

    def random_configurations(self, n: int, seed: int | np.random.Generator | None = None) -> Floats:
        """Samples uniformly within the limits.

        Args:
            n: Number of configurations.
            seed: A seed, or a generator.

        Returns:
            (n, nq), rad and m. Continuous joints are in [-pi, pi), unlimited positions within 1 m of zero.
        """
        return self.joint_values.random(n, seed)

    @cached_property
    def joint_values(self) -> JointValues:
        """Configurations of a robot without a group, by one number for each joint."""
        return JointValues(self._map, self._parts.model, self._parts.mimics, self._parts.group is None)

    def link_poses(self, q: Configuration) -> Floats:
        """World poses of all links.

        Args:
            q: (nq,) or (n, nq) configurations of the group, or each joint's value of one by its name. Of a robot
                without a group also one number for each joint, a continuous joint as one angle.

        Returns:
            (links, 4, 4) or (n, links, 4, 4), m, in the order of link_names. A configuration gets the same doubles
            alone and in a batch, on every instruction set.
        """
        if isinstance(q, Mapping):
            return self.link_poses(self.joint_values.named(q)[0])
        rows = self.joint_values.configurations(q)
        poses = self._forward.poses(rows)
        return poses[0] if np.ndim(q) == 1 else poses

    def pinocchio_link_poses(self, q: ArrayLike) -> Floats:
        """World poses of all links by Pinocchio itself; arguments and result as of link_poses."""
        poses = self._forward.pinocchio_poses(self.joint_values.configurations(q))
        return poses[0] if np.ndim(q) == 1 else poses

    @property
    def sampled_link_poses(self) -> Floats:
        """(k, links, 4, 4) at a few random configurations, m: poses used to choose the groups of the broad phase."""
        return self.remembered("samples", lambda: read_only(self.link_poses(self.random_configurations(_SAMPLES, 0))))

    @property
    def kinematic_error(self) -> float:
        """A proved bound, m: rounding of forward kinematics moves no point of a body further than this.

        It holds for configurations within the limits (where there are none, within the range that is sampled). It is
        infinite if Pinocchio itself poses the robot, since then nothing is proved.
        """
        return self.remembered("error", lambda: self.kinematic_error_within(*self._map.sampled_range()))

    def kinematic_error_at(self, q: ArrayLike) -> float:
        """The same bound at one configuration (nq,), which may be beyond the limits; m."""
        row = self._map.checked(q)[0]
        return self.kinematic_error_within(row, row)

    def kinematic_error_within(self, lower: Floats, upper: Floats) -> float:
        """The same bound for all configurations from `lower` to `upper`, (nq,) each; m."""
        return float("inf") if self._rounding is None else self._rounding.bound(lower, upper)

    @property
    def kinematics(self) -> core.Kinematics | None:
        """The compiled kinematics; None if Pinocchio itself poses the robot."""
        return self._forward.kernel

    @property
    def joint_table(self) -> JointTable | None:
        """The compiled kinematics' joint table; None if it does not support some joint."""
        return self._forward.table

    def remembered(self, what: Hashable, compute: Callable[[], Result]) -> Result:
        """A result about this robot without any scene, computed once for all its checkers (see robot_memory.py).

        Args:
            what: Names the result, and says all that it depends on besides the robot's bodies and kinematics.
            compute: A function that computes it; the result must be immutable.
        """
        return self._recall(what, self.bodies, compute)

    def _recall(self, what: Hashable, bodies: tuple[GeometryObject, ...], compute: Callable[[], Result]) -> Result:
        return self._parts.memory.recall((what, self._forward, bodies, self.reference.tobytes()), compute)

    @property
    def _rounding(self) -> KinematicRounding | None:
        return self.remembered("rounding", self._read_rounding)

    def _read_rounding(self) -> KinematicRounding | None:
        """What the robot alone has is read once, whatever it carries."""
        carried = [body for body in self.bodies if body.carried is not None]
        own = self.bodies[: len(self.bodies) - len(carried)]
        alone = self._recall("rounding", own, lambda: self._forward.rounding(own, self._link_indices))
        if alone is None or not carried:
            return alone
        return alone.with_bodies(carried, [self._link_indices[str(body.link)] for body in carried])

    @cached_property
    def _link_indices(self) -> dict[str, int]:
        return {name: index for index, name in enumerate(self.link_names)}
