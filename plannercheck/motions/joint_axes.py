"""Axes of joints, and the tree that joints and links form, at the configuration at which chains of joints are measured.

In: Pinocchio's model, the configurations' columns, the compiled kinematics' table. Out: `JointTree`, in which moving
joints are at rest and the others where they are held.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from plannercheck.common.array_types import Floats
from plannercheck.common.motion_paths import MotionPath
from plannercheck.motions.joint_drives import split_joints
from plannercheck.robots.configurations import ConfigurationMap
from plannercheck.robots.joints import KINDS
from plannercheck.robots.kinematics import JointTable, joint_placements


class JointAxis(NamedTuple):
    """The axis about which a joint turns, at one configuration.

    Attributes:
        origin: (3,) m.
        direction: (3,) unit vector; None for a joint that turns about its origin.
    """

    origin: Floats
    direction: Floats | None

    def feet(self, points: Floats) -> Floats:
        """(n, 3) the axis's points nearest to others (n, 3), m."""
        if self.direction is None:
            return np.tile(self.origin, (len(points), 1))
        along = (points - self.origin) @ self.direction
        return np.asarray(self.origin + along[:, None] * self.direction)

    def distance(self, points: Floats) -> Floats:
        """(n,) of points (n, 3) from the axis, m."""
        offsets = points - self.origin
        if self.direction is None:
            return np.asarray(np.linalg.norm(offsets, axis=1))
        (x, y, z), (u, v, w) = offsets.T, self.direction.tolist()
        a, b, c = y * w - z * v, z * u - x * w, x * v - y * u  # as np.cross has them, in a quarter of its time
        return np.asarray(np.sqrt((a * a + b * b) + c * c))


class JointTree:
    """Joints and links at one configuration: moving joints at rest, the others where they are held.

    On the path "slerp", the child of a planar or floating joint is at T(x(t)) R(t) in the joint's placement: x moves
    linearly, and R turns about a fixed axis at constant speed. So the joint is a chain of simple ones, for which the
    bounds of cpp/motions/motion_bounds.hpp are proved: a slide for each number of x, then a ball joint (or a turn) that
    keeps the joint's index. The slides come after all joints of the table; no link is on them.
    """

    def __init__(
        self,
        model: pin.Model,
        configurations: ConfigurationMap,
        table: JointTable,
        frames: Sequence[int],
        path: MotionPath = "screw",
    ) -> None:
        joints = joint_placements(model, _at_rest(model, configurations, table))
        links = [model.frames[frame] for frame in frames]
        self.table = table
        self.parents: list[int] = table.parents.tolist()
        self.moves: list[bool] = [bool(row.any()) for row in table.columns >= 0]
        kinds = [KINDS[k] for k in table.kinds.tolist()]
        self.slides = [moves and kind.lengths > 0 for moves, kind in zip(self.moves, kinds, strict=True)]
        self.turns = [moves and kind.turn != "" for moves, kind in zip(self.moves, kinds, strict=True)]
        self.axes = [_axis(table, j, joints[j + 1]) for j in range(len(self.parents))]
        for joint, slides in split_joints(table, path):
            self._split(joint, slides)
        self.origins = np.array([axis.origin for axis in self.axes]).reshape(-1, 3)
        self.link_poses = np.reshape(
            [(joints[link.parentJoint] * link.placement).homogeneous for link in links], (-1, 4, 4)
        )
        self.link_joints = table.link_joints.tolist()
        self.link_on = {joint: link for link, joint in reversed(list(enumerate(self.link_joints)))}
        self.link_on[-1] = -1

    def _split(self, joint: int, slides: int) -> None:
        """Puts so many slides above a joint, which only turns from now on."""
        self.slides[joint] = False
        for _ in range(slides):
            self.parents.append(self.parents[joint])
            self.parents[joint] = len(self.parents) - 1
            self.moves.append(True)
            self.slides.append(True)
            self.turns.append(False)
            self.axes.append(self.axes[joint])

    def joint_path(self, start: int, end: int) -> tuple[list[int], list[int]]:
        """The moving joints between links on two joints, and for each of them the joint that the link before it is on.

        The second list has one more: the joint of the link after the last. -1 is the world.
        """
        up, down = self._ancestors(start), self._ancestors(end)
        while up and down and up[-1] == down[-1]:
            up.pop()
            down.pop()
        up_path = [(joint, self.parents[joint]) for joint in up if self.moves[joint]]
        down_path = [(joint, joint) for joint in reversed(down) if self.moves[joint]]
        joints = [joint for joint, _ in up_path + down_path]
        return joints, [start] + [after for _, after in up_path + down_path]

    def carries(self, joint: int, last: int) -> bool:
        """Whether joint `last` hangs on a joint, or is that joint."""
        return joint in self._ancestors(last)

    def _ancestors(self, joint: int) -> list[int]:
        found = []
        while joint >= 0:
            found.append(joint)
            joint = self.parents[joint]
        return found


def _at_rest(model: pin.Model, configurations: ConfigurationMap, table: JointTable) -> Floats:
    """Pinocchio's configuration with moving joints at 0 and held joints where they are held."""
    q, neutral = configurations.expand(np.zeros((1, configurations.width)))[0], pin.neutral(model)
    for i, columns in enumerate(table.columns, start=1):
        if (columns >= 0).any():
            entries = slice(model.idx_qs[i], model.idx_qs[i] + model.nqs[i])
            q[entries] = neutral[entries]
    return np.asarray(q)


def _axis(table: JointTable, joint: int, pose: pin.SE3) -> JointAxis:
    if not KINDS[table.kinds[joint]].has_axis:
        return JointAxis(pose.translation.copy(), None)
    direction = pose.rotation @ table.axes[joint]
    return JointAxis(pose.translation.copy(), direction / np.linalg.norm(direction))
