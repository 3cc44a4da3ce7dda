"""Robot states of MoveIt in YAML.

In: a parsed `moveit_msgs/RobotState`. Out: the joints that it gives, for poses of links; an error if it moves the
robot's base.
"""

from __future__ import annotations

from plannercheck.bodies.objects import SceneFrames, StatedJoints
from plannercheck.common.checked_yaml import Node, check_keys, error_context, mapping, numbers, sequence, text
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.transforms import is_identity
from plannercheck.scenes.moveit_messages import header_frame, transform

_STATE_KEYS = ("joint_state", "multi_dof_joint_state", "attached_collision_objects", "is_diff")
_JOINT_KEYS = ("header", "name", "position", "velocity", "effort")
_MULTI_DOF_KEYS = ("header", "joint_names", "transforms", "twist", "wrench")


def check_robot_state(state: Node, what: str, frames: SceneFrames | None = None) -> None:
    """Raises if a joint of several degrees of freedom, such as the virtual joint, is not at the identity.

    The state is named for errors. Without the scene's frames, the joints' frame is not checked.
    """
    check_keys(state, _STATE_KEYS)
    joints = mapping(state.get("multi_dof_joint_state"), "'multi_dof_joint_state'")
    check_keys(joints, _MULTI_DOF_KEYS)
    names = sequence(joints.get("joint_names"), "'joint_names'")
    transforms = sequence(joints.get("transforms"), "'transforms'")
    for k, item in enumerate(transforms):
        if not is_identity(transform(mapping(item, "a transform"))):
            name = names[k] if k < len(names) else k
            raise PlannercheckError(
                f"the {what}'s virtual joint {name!r} moves the robot: only the identity is supported"
            )
    if len(names) != len(transforms):
        raise PlannercheckError(f"multi_dof_joint_state: {len(names)} joint_names, but {len(transforms)} transforms")
    if frames is not None and names:
        _check_frame(header_frame(joints), frames)


def _check_frame(name: str, frames: SceneFrames) -> None:
    """Raises if transforms are given in a frame other than the planning frame, where identities mean other poses."""
    at_identity = name in frames.fixed and is_identity(frames.fixed[name])
    if name and frames.planning not in ("", name) and not at_identity:
        raise PlannercheckError(
            f"multi_dof_joint_state is in frame {name!r}: only the planning frame {frames.planning!r} is supported"
        )


def stated_joints(state: Node) -> StatedJoints:
    """The joints that a state gives, whose multi_dof_joint_state has been checked."""
    node = mapping(state.get("joint_state"), "'joint_state'")
    multi_dof = mapping(state.get("multi_dof_joint_state"), "'multi_dof_joint_state'")
    identities = frozenset(text(n, "joint_names") for n in sequence(multi_dof.get("joint_names"), "'joint_names'"))
    return StatedJoints(joint_values(node), identities)


def joint_values(node: Node) -> dict[str, float]:
    """Values by joint name of a `sensor_msgs/JointState`, rad or m; none if it is empty."""
    with error_context("joint_state"):
        check_keys(node, _JOINT_KEYS)
        names = [text(n, "name") for n in sequence(node.get("name"), "'name'")]
        values = numbers(node.get("position"), "position", len(names))
        if len(set(names)) != len(names):
            raise PlannercheckError(f"joint_state names a joint twice: {', '.join(names)}")
        return dict(zip(names, values, strict=True))
