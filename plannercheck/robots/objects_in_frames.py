"""Places objects whose pose is given in a link's frame, and carried objects whose pose is given in the world.

In: a robot, and objects with pose frames. Out: the same objects in the world, or on their links. As in MoveIt
(`PlanningScene::processCollisionObjectAdd` and `processAttachedCollisionObjectMsg`, which ask `getFrameTransform` of
the scene's current state), this happens once, at the state that came with the object: an obstacle posed in a hand's
frame does not move with the hand. The state has to give every joint on which the place depends; no value is assumed for
a missing joint. The robot's root is at the identity, since moved virtual joints are refused.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
import pinocchio as pin

from plannercheck.bodies.objects import PoseFrame, SceneObject, StatedJoints
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.transforms import inverse
from plannercheck.robots.configurations import followed, joint_width
from plannercheck.robots.urdf import Mimic


class PoseableRobot(Protocol):
    """What a place depends on, for which a `Robot` is given; see there."""

    model: Any
    reference: Floats

    @property
    def link_names(self) -> tuple[str, ...]:
        """Names of the links."""

    @property
    def frames(self) -> Sequence[int]:
        """Pinocchio's frames of the links."""

    @property
    def mimics(self) -> Mapping[str, Mimic]:
        """The joints that follow others, by name."""

    def link_index(self, name: str) -> int:
        """Index into link_names."""

    def holding(self, values: Mapping[str, float | Sequence[float]]) -> PoseableRobot:
        """The same robot with joints held at other values."""

    def link_poses(self, q: Floats) -> Floats:
        """World poses of all links, m."""


def placed(robot: PoseableRobot, items: Iterable[SceneObject]) -> tuple[SceneObject, ...]:
    """The objects in the world or on their links; objects without pose frames are returned as they are."""
    states = _States(robot)
    return tuple(item if item.pose_frame is None else _placed(robot, item, item.pose_frame, states) for item in items)


def _placed(robot: PoseableRobot, item: SceneObject, pose_frame: PoseFrame, states: _States) -> SceneObject:
    if item.link is not None and item.link not in robot.link_names:
        raise unknown_name(f"link that carries {item.name!r}", item.link, robot.link_names)
    if pose_frame.frame and pose_frame.frame not in robot.link_names:
        raise unknown_name(f"frame of object {item.name!r}", pose_frame.frame, (*pose_frame.known, *robot.link_names))
    _check_state(robot, item, pose_frame)
    pose = states.pose(pose_frame.frame, pose_frame.state) @ item.pose
    if item.link is not None:
        pose = inverse(states.pose(item.link, pose_frame.state)) @ pose
    return item.moved(pose)


class _States:
    """Poses of links at states; the robot is posed once for each."""

    def __init__(self, robot: PoseableRobot) -> None:
        self._robot = robot
        self._poses: list[tuple[StatedJoints, Floats]] = []

    def pose(self, frame: str, state: StatedJoints) -> Floats:
        """(4, 4) of a link in the world, m; the identity for the world itself."""
        if not frame:
            return np.eye(4)
        known = [poses for other, poses in self._poses if other == state]
        if not known:
            known = [_link_poses(self._robot, state)]
            self._poses.append((state, known[0]))
        return np.asarray(known[0][self._robot.link_index(frame)])


def _link_poses(robot: PoseableRobot, state: StatedJoints) -> Floats:
    """(links, 4, 4) at a state, m; other joints are as the robot holds them, and the root is at the identity."""
    model, neutral = robot.model, pin.neutral(robot.model)
    values: dict[str, float | list[float]] = {}
    for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True):
        if joint_width(joint) > 1 and _is_at_identity(robot, name, state):
            values[name] = neutral[joint.idx_q : joint.idx_q + joint.nq].tolist()
        elif joint_width(joint) == 1 and name in state.values:
            values[name] = state.values[name]
    posed = robot.holding(values)
    return posed.link_poses(posed.reference)


def _is_at_identity(robot: PoseableRobot, joint: str, state: StatedJoints) -> bool:
    """Whether a joint of several degrees of freedom is at the identity: by the state, or as the robot's root."""
    return joint in state.identities or robot.model.parents[robot.model.getJointId(joint)] == 0


def _check_state(robot: PoseableRobot, item: SceneObject, pose_frame: PoseFrame) -> None:
    """Raises if the place depends on a joint that the state does not give."""
    moving = set(_joints_of(robot, pose_frame.frame)) ^ set(_joints_of(robot, item.link))
    lacking = [
        name for name in list(robot.model.names)[1:] if name in moving and not _is_given(robot, name, pose_frame)
    ]
    if lacking:
        where = f"frame {pose_frame.frame!r}" if pose_frame.frame else "the planning frame"
        carrier = "" if item.link is None else f" and carried by {item.link!r}"
        raise PlannercheckError(
            f"object {item.name!r} is posed in {where}{carrier}, and the robot_state gives no value for "
            f"{', '.join(lacking)}, which says where that is: give it in joint_state, or pose the object in "
            f"{'the planning frame' if item.link is None else f'the frame of {item.link!r}'}"
        )


def _joints_of(robot: PoseableRobot, link: str | None) -> list[str]:
    """The joints between the world and a link; none for the world itself."""
    if not link:
        return []
    model, found = robot.model, []
    joint = model.frames[robot.frames[robot.link_index(link)]].parentJoint
    while joint:
        found.append(str(model.names[joint]))
        joint = model.parents[joint]
    return found


def _is_given(robot: PoseableRobot, joint: str, pose_frame: PoseFrame) -> bool:
    if joint_width(robot.model.joints[robot.model.getJointId(joint)]) > 1:
        return _is_at_identity(robot, joint, pose_frame.state)
    return followed(joint, robot.mimics, pose_frame.state.values)[0] in pose_frame.state.values
