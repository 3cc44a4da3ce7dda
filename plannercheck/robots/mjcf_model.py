"""Pinocchio's model of a compiled MJCF file.

In: a compiled file. Out: a model whose poses are those of `mj_kinematics`, and the joints' initial values. Each joint
of MuJoCo's is one of Pinocchio's, in the same order, so that q is MuJoCo's qpos, but for quaternions, which are x, y,
z, w. Of several joints on one body all but the last move a link of their own, "body/joint", without geometry.

MuJoCo moves a body by its joints one after the other: a hinge turns it about its anchor by qpos - ref, a slide moves it
by that along its axis, a ball turns it by its quaternion, and a free joint's numbers are the pose in the world. The
anchor and ref are part of the placements, so that Pinocchio's joints take the numbers of qpos.
"""

from __future__ import annotations

from collections.abc import Container
from typing import Any

import numpy as np
import pinocchio as pin

from plannercheck.bodies.mjcf_files import BALL, FREE, HINGE, SLIDE, MjcfFile
from plannercheck.common.array_types import Floats

# Axes for which Pinocchio has joints of their own.
_LETTERS = {(1.0, 0.0, 0.0): "X", (0.0, 1.0, 0.0): "Y", (0.0, 0.0, 1.0): "Z"}


def pinocchio_model(file: MjcfFile) -> pin.Model:
    """The model of a file's links; its frames are as Pinocchio has those of a URDF."""
    model = pin.Model()
    model.name = file.name
    tree = _Tree(file, model)
    for body in np.flatnonzero(file.is_of_robot).tolist():
        tree.add(body)
    lower, upper = model.lowerPositionLimit.copy(), model.upperPositionLimit.copy()
    _check_ranges(file)
    for joint in np.flatnonzero((file.jnt_limited != 0) & np.isin(file.jnt_type, (HINGE, SLIDE))).tolist():
        column = model.joints[joint + 1].idx_q
        lower[column], upper[column] = file.jnt_range[joint].tolist()
    model.lowerPositionLimit, model.upperPositionLimit = lower, upper
    return model


def initial_values(file: MjcfFile, following: Container[str]) -> dict[str, Floats]:
    """The initial values of joints that follow no other one, by MuJoCo's qpos0, within their limits."""
    values = {}
    for joint, (name, kind) in enumerate(zip(file.names["joint"], file.jnt_type.tolist(), strict=True)):
        first = int(file.jnt_qposadr[joint])
        own = file.qpos0[first : first + {FREE: 7, BALL: 4}.get(kind, 1)]
        if kind in (FREE, BALL):
            own = np.concatenate([own[:-4], own[-3:], own[-4:-3]])  # w comes last
        elif file.jnt_limited[joint]:
            own = np.clip(own, *file.jnt_range[joint])
        if name not in following:
            values[name] = own
    return values


def _check_ranges(file: MjcfFile) -> None:
    """Raises for a range that MuJoCo takes for none, as its first number is not the smaller one."""
    low, high = file.jnt_range.reshape(-1, 2).T
    wrong = np.flatnonzero((file.jnt_limited == 0) & ((low > high) | ((low == high) & (low != 0))))
    if len(wrong):
        joint = int(wrong[0])
        given = file.jnt_range[joint].tolist()
        raise file.refused("joint", joint, f"has the range {given}, which MuJoCo ignores: lower must be first")


class _Tree:
    """Links and joints as they are added to a model, parents first."""

    def __init__(self, file: MjcfFile, model: pin.Model) -> None:
        self._file, self._model = file, model
        self._taken = {*file.names["body"], *file.names["joint"]}
        world = model.addFrame(pin.Frame(file.names["body"][0], 0, 0, pin.SE3.Identity(), pin.FrameType.BODY))
        self._frames = {0: world}

    def add(self, body: int) -> None:
        """Adds a body with its joints."""
        file, model = self._file, self._model
        frame = self._frames[int(file.body_parentid[body])]
        joint, placement = model.frames[frame].parentJoint, model.frames[frame].placement
        placement = placement * pin.SE3(file.body_pose(body))
        name, first = file.names["body"][body], int(file.body_jntadr[body])
        own = range(first, first + int(file.body_jntnum[body]))
        if not own:
            fixed = self._new_name(f"{name}/fixed")
            frame = self._frame(fixed, joint, frame, placement, pin.FrameType.FIXED_JOINT)
        for number in own:
            kind, before, placement = self._joint(number, placement)
            joint = model.addJoint(joint, kind, before, file.names["joint"][number])
            frame = model.addJointFrame(joint, frame)
            if number != own[-1]:
                link = self._new_name(f"{name}/{file.names['joint'][number]}")
                frame = self._frame(link, joint, frame, placement, pin.FrameType.BODY)
        self._frames[body] = self._frame(name, joint, frame, placement, pin.FrameType.BODY)

    def _frame(self, name: str, joint: int, above: int, placement: pin.SE3, kind: pin.FrameType) -> int:
        return int(self._model.addFrame(pin.Frame(name, joint, above, placement, kind)))

    def _new_name(self, name: str) -> str:
        while name in self._taken:
            name += "'"
        self._taken.add(name)
        return name

    def _joint(self, number: int, body: pin.SE3) -> tuple[Any, pin.SE3, pin.SE3]:
        """A joint, its placement, and the placement on it of the body that is at a placement before it moves."""
        file, kind = self._file, int(self._file.jnt_type[number])
        axis, anchor = file.jnt_axis[number], pin.SE3(np.eye(3), file.jnt_pos[number])
        reference = float(file.qpos0[file.jnt_qposadr[number]])
        if kind == FREE:
            return pin.JointModelFreeFlyer(), pin.SE3.Identity(), pin.SE3.Identity()
        if kind == BALL:
            return pin.JointModelSpherical(), body * anchor, anchor.inverse()
        if kind == SLIDE:
            back = pin.SE3(np.eye(3), -reference * axis)
            return _along(axis, "P", pin.JointModelPrismaticUnaligned), body * back, pin.SE3.Identity()
        turned = pin.SE3(pin.AngleAxis(-reference, axis).toRotationMatrix() if reference else np.eye(3), np.zeros(3))
        return _along(axis, "R", pin.JointModelRevoluteUnaligned), body * anchor * turned, anchor.inverse()


def _along(axis: Floats, letter: str, unaligned: Any) -> Any:
    """Pinocchio's joint of one number along or about an axis of length 1."""
    x, y, z = axis.tolist()
    aligned = _LETTERS.get((x, y, z))
    return unaligned(x, y, z) if aligned is None else getattr(pin, f"JointModel{letter}{aligned}")()
