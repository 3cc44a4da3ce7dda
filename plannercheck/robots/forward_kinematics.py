"""Forward kinematics of a planning group: the compiled kernel where Pinocchio agrees with it, else Pinocchio.

In: a Pinocchio model, the sources of the numbers in its q, the frames of the links. Out: `ForwardKinematics`, which
poses all links at a batch of configurations and bounds how far its rounding can move a point. The kernel is compared
with Pinocchio once, when it is built.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np
import pinocchio as pin

from plannercheck.bodies.shapes import GeometryObject
from plannercheck.common.array_types import Floats
from plannercheck.common.core import core
from plannercheck.common.user_warnings import warn
from plannercheck.robots.configurations import ConfigurationMap
from plannercheck.robots.kinematic_error import KinematicRounding
from plannercheck.robots.kinematics import (
    AGREEMENT,
    JointTable,
    compiled_kinematics,
    disagreement,
    joint_table,
    pinocchio_poses,
)


class ForwardKinematics:
    """Poses the links of a robot.

    Attributes:
        kernel: The compiled kinematics; None if Pinocchio itself poses the robot.
    """

    def __init__(self, model: pin.Model, configurations: ConfigurationMap, frames: Sequence[int], robot: str) -> None:
        self._model, self._map, self._frames = model, configurations, frames
        self.kernel = self._checked_kernel(robot)

    @cached_property
    def table(self) -> JointTable | None:
        """The kernel's table; None if it does not know some joint."""
        return joint_table(self._model, self._map, self._frames)

    def poses(self, rows: Floats) -> Floats:
        """World poses (n, links, 4, 4) of all links at checked configurations (n, nq); m."""
        if self.kernel is None:
            return self.pinocchio_poses(rows)
        return np.asarray(self.kernel.link_poses(rows, np.ones(len(self._frames), dtype=np.uint8)))

    def pinocchio_poses(self, rows: Floats) -> Floats:
        """The same by Pinocchio itself."""
        return pinocchio_poses(self._model, self._map, self._frames, rows)

    def rounding(self, bodies: Sequence[GeometryObject], links: Mapping[str, int]) -> KinematicRounding | None:
        """The bound on how far rounding moves points of bodies on links; None if Pinocchio itself poses the robot."""
        if self.table is None or self.kernel is None:
            return None
        moving = [body for body in bodies if body.link is not None]
        return KinematicRounding(self.table, moving, [links[str(body.link)] for body in moving])

    def _checked_kernel(self, robot: str) -> core.Kinematics | None:
        """The compiled kinematics if Pinocchio agrees with it."""
        kernel = compiled_kinematics(self._model, self._map, self._frames)
        if kernel is None:
            return None
        difference = disagreement(kernel, self._model, self._map, self._frames)
        if difference <= AGREEMENT:
            return kernel
        warn(
            f"robot {robot!r}: the compiled kinematics differs from Pinocchio by {difference:.3g}; "
            "posing with Pinocchio instead, which is slower"
        )
        return None
