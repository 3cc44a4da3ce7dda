"""MoveIt motion-plan requests in YAML: the start of a plan, and its goals in joint space.

In: `moveit_msgs/MotionPlanRequest`, as ROS, MoveIt and MotionBenchMaker write it; for goals that are poses (see
moveit_goals.py) an inverse kinematics. Out: a MotionRequest.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from pathlib import Path

from plannercheck.bodies.objects import SceneFrames
from plannercheck.common.checked_yaml import (
    Node,
    error_context,
    mapping,
    parse_yaml,
    read_bytes,
    required,
    sequence,
    text_or_empty,
)
from plannercheck.common.errors import PlannercheckError
from plannercheck.scenes.moveit_goals import GoalReader, InverseKinematics
from plannercheck.scenes.moveit_states import check_robot_state, joint_values


@dataclass(frozen=True)
class MotionRequest:
    """The start and the goals of a motion-plan request.

    Attributes:
        group: The planning group's name, as given.
        start: Values by joint name, rad or m, of all joints that the start state gives.
        goals: For each goal the values of the joints that it constrains; for a pose, the values from the IK.
        state: The start state as it was read, e.g. for what it attaches to links.
    """

    group: str
    start: dict[str, float]
    goals: tuple[dict[str, float], ...]
    state: Node = field(default_factory=dict, repr=False, compare=False)


def read_request(path: str | Path, ik: InverseKinematics | None = None) -> MotionRequest:
    """Reads a motion-plan request, `moveit_msgs/MotionPlanRequest` in YAML.

    Args:
        path: The file.
        ik: Finds joint values for goals that are poses: `ik(PoseGoal)` returns one mapping of joint names to rad or m,
            several, or None if there is no solution. Without it, such goals are refused.

    Raises:
        PlannercheckError: If the file is no request, or a goal has no joint values.
    """
    with error_context(f"request file {str(path)!r}"):
        return motion_request(parse_yaml(read_bytes(Path(path))), ik)


def motion_request(
    document: Node, ik: InverseKinematics | None = None, frames: SceneFrames | None = None
) -> MotionRequest:
    """Takes the start and the goals from a parsed motion-plan request; `ik` is as for `read_request`.

    `frames` are those of the request's scene: `ik` gets poses in its fixed frames in the planning frame.
    """
    start = mapping(required(document, "start_state"), "'start_state'")
    check_robot_state(start, "request")
    for key in ("path_constraints", "trajectory_constraints"):
        if _has_constraints(mapping(document.get(key), repr(key))):
            warnings.warn(f"the request's {key} are ignored", stacklevel=2)
    goals = sequence(required(document, "goal_constraints"), "'goal_constraints'")
    if not goals:
        raise PlannercheckError("'goal_constraints' is empty: one goal with joint_constraints is needed")
    with error_context("start_state"):
        joints = joint_values(mapping(required(start, "joint_state"), "'joint_state'"))
    group = text_or_empty(document, "group_name")
    reader = GoalReader(group, joints, ik, frames)
    constrained = tuple(values for k, g in enumerate(goals) for values in reader.read(mapping(g, "a goal"), k))
    return MotionRequest(group, joints, constrained, start)


def _has_constraints(node: Node) -> bool:
    return any(isinstance(value, list) and value for value in node.values())
