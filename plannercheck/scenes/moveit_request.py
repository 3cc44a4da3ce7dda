"""MoveIt motion-plan requests in YAML: where a plan starts, and its goals in joint space.

In: `moveit_msgs/MotionPlanRequest`, as ROS, MoveIt and MotionBenchMaker write it. Out: a MotionRequest.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from pathlib import Path

from plannercheck.common.checked_yaml import (
    Node,
    mapping,
    number,
    parse_yaml,
    read_bytes,
    required,
    sequence,
    text,
    within,
)
from plannercheck.common.errors import PlannercheckError, shortened
from plannercheck.scenes.moveit_states import check_robot_state, joint_values


@dataclass(frozen=True)
class MotionRequest:
    """What a motion-plan request asks for.

    Attributes:
        group: The planning group's name, as given.
        start: Value by joint name, rad or m: all joints that the start state gives.
        goals: The same for each goal, with the joints that it constrains.
        state: The start state as it was read, e.g. for what it attaches to links.
    """

    group: str
    start: dict[str, float]
    goals: tuple[dict[str, float], ...]
    state: Node = field(default_factory=dict, repr=False, compare=False)


def read_request(path: str | Path) -> MotionRequest:
    """Reads a motion-plan request, `moveit_msgs/MotionPlanRequest` in YAML."""
    with within(f"request file {str(path)!r}"):
        return motion_request(parse_yaml(read_bytes(Path(path))))


def motion_request(document: Node) -> MotionRequest:
    """Takes the start and the joint goals from a parsed motion-plan request."""
    start = mapping(required(document, "start_state"), "'start_state'")
    check_robot_state(start, "request")
    if _has_constraints(mapping(document.get("path_constraints"), "'path_constraints'")):
        warnings.warn("the request's path_constraints are ignored", stacklevel=2)
    goals = sequence(required(document, "goal_constraints"), "'goal_constraints'")
    if not goals:
        raise PlannercheckError("'goal_constraints' is empty: one goal with joint_constraints is needed")
    with within("start_state"):
        joints = joint_values(mapping(required(start, "joint_state"), "'joint_state'"))
    group = text(document.get("group_name") or "", "group_name")
    constrained = tuple(_joint_goal(mapping(g, "a goal"), k) for k, g in enumerate(goals))
    return MotionRequest(group, joints, constrained, start)


def _joint_goal(node: Node, index: int) -> dict[str, float]:
    """Joint values of one goal; tolerances are left out, the goal is the state itself."""
    with within(f"goal_constraints {index}"):
        for key in ("position_constraints", "orientation_constraints", "visibility_constraints"):
            if sequence(node.get(key), repr(key)):
                raise PlannercheckError(f"{key} are not supported, goals are joint_constraints")
        constraints = [mapping(c, "a constraint") for c in sequence(node.get("joint_constraints"), "they")]
        goal = {
            text(required(c, "joint_name"), "joint_name"): number(c.get("position"), "position") for c in constraints
        }
        if not goal or len(goal) != len(constraints):
            raise PlannercheckError(
                f"joint_constraints must name each joint once; given are {', '.join(map(shortened, goal)) or 'none'}"
            )
        return goal


def _has_constraints(node: Node) -> bool:
    return any(isinstance(value, list) and value for value in node.values())
