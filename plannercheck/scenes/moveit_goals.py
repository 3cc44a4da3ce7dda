"""Goals of MoveIt's motion-plan requests: values of joints, or the pose of a link.

In: parsed `moveit_msgs/Constraints`, and for poses an inverse kinematics given by the user. Out: values by joint name.

A pose is what MoveIt's `constructGoalConstraints(link_name, pose)` writes (moveit_core, kinematic_constraints,
utils.cpp): one position constraint with a sphere or box about the position, one orientation constraint of the same
link. As in `PositionConstraint::decide`, the point with this position is `target_point_offset` in the link's frame.
Tolerances of all constraints are ignored: the goal is the middle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.objects import SceneFrames
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.checked_yaml import Node, check_keys, error_context, mapping, number, required, sequence, text
from plannercheck.common.errors import PlannercheckError, shortened
from plannercheck.common.transforms import pose_of, rotation_of_quaternion
from plannercheck.scenes.moveit_messages import header_frame, pose, vector

Matrix = NDArray[np.float64]
Values: TypeAlias = dict[str, float]

_GOAL_KEYS = ("name", "joint_constraints", "position_constraints", "orientation_constraints", "visibility_constraints")
_POSITION_KEYS = ("header", "link_name", "target_point_offset", "constraint_region", "weight")
_REGION_KEYS = ("primitives", "primitive_poses", "meshes", "mesh_poses")
_ORIENTATION_KEYS = (
    *("header", "orientation", "link_name", "parameterization", "weight"),
    *(f"absolute_{axis}_axis_tolerance" for axis in "xyz"),
)
_POSES = ("position_constraints", "orientation_constraints")

# If a quaternion's length differs from 1 by this or more, MoveIt's `OrientationConstraint::configure` takes the
# identity.
_LARGEST_EXCESS_OF_LENGTH = 1e-3


@dataclass(frozen=True)
class PoseGoal(OwnsArrays):
    """The pose of a link that a goal asks for.

    Attributes:
        link: The link's name.
        pose: (4, 4) of the link's frame in `frame`, m.
        frame: The frame that the constraints' headers name, "" if none; a fixed frame of a problem set's scene is
            replaced by the planning frame.
        group: The planning group's name, as in the request.
        start: The start state, values by joint name, rad or m.
    """

    link: str
    pose: Matrix
    frame: str
    group: str
    start: Mapping[str, float]


# A function from a goal to values of the group's joints by name that reach it, to several of these, or to None.
InverseKinematics: TypeAlias = Callable[[PoseGoal], Mapping[str, float] | Iterable[Mapping[str, float]] | None]


@dataclass(frozen=True)
class GoalReader:
    """Reads the goals of a request.

    Attributes:
        group: The planning group's name.
        start: The start state.
        ik: Solves goals that are poses; None refuses them.
        frames: The scene's frames, if they are known.
    """

    group: str
    start: Values
    ik: InverseKinematics | None = None
    frames: SceneFrames | None = None

    def read(self, node: Node, index: int) -> list[Values]:
        """The joint values of one goal; several if the inverse kinematics finds several."""
        with error_context(f"goal_constraints {index}"):
            check_keys(node, _GOAL_KEYS)
            if sequence(node.get("visibility_constraints"), "'visibility_constraints'"):
                raise PlannercheckError("visibility_constraints are not supported, goals are joint_constraints")
            given = [key for key in _POSES if sequence(node.get(key), repr(key))]
            return self._solved(node, given[0]) if given else [_joint_goal(node)]

    def _solved(self, node: Node, key: str) -> list[Values]:
        if self.ik is None:
            raise PlannercheckError(
                f"{key} are not supported without an inverse kinematics, which Python can be given: "
                "read_request(path, ik=function), load_problems(path, ik=function); else goals are joint_constraints"
            )
        goal = self._pose_goal(node)
        solutions = _solutions(self.ik(goal))
        if not solutions:
            raise PlannercheckError(f"the inverse kinematics finds no joint values for link {goal.link!r}")
        return solutions

    def _pose_goal(self, node: Node) -> PoseGoal:
        if sequence(node.get("joint_constraints"), "'joint_constraints'"):
            raise PlannercheckError("a goal is either joint_constraints or a link's pose, not both")
        position, orientation = (_only_one(node, key) for key in _POSES)
        with error_context("position_constraints"):
            check_keys(position, _POSITION_KEYS)
            link, frame = text(required(position, "link_name"), "link_name"), header_frame(position)
            offset = vector(position.get("target_point_offset") or [0.0] * 3, "target_point_offset", "xyz")
            middle = _middle(mapping(required(position, "constraint_region"), "'constraint_region'"))
        with error_context("orientation_constraints"):
            check_keys(orientation, _ORIENTATION_KEYS)
            other = text(required(orientation, "link_name"), "link_name"), header_frame(orientation)
            rotation = _rotation(orientation)
        if other != (link, frame):
            raise PlannercheckError(
                f"the position is of link {link!r} in frame {frame!r}, the orientation of link {other[0]!r} in frame "
                f"{other[1]!r}: both must be of one link in one frame"
            )
        placed, frame = self._in_planning_frame(pose_of((middle - rotation @ offset).tolist(), rotation), frame)
        return PoseGoal(link, placed, frame, self.group, self.start)

    def _in_planning_frame(self, pose: Matrix, frame: str) -> tuple[Matrix, str]:
        """Takes a pose from a fixed frame of the scene to the planning frame; other poses stay as they are."""
        if self.frames is None or frame not in self.frames.fixed:
            return pose, frame
        return self.frames.fixed[frame] @ pose, self.frames.planning


def _joint_goal(node: Node) -> Values:
    constraints = [mapping(c, "a constraint") for c in sequence(node.get("joint_constraints"), "they")]
    goal = {text(required(c, "joint_name"), "joint_name"): number(c.get("position"), "position") for c in constraints}
    if not goal or len(goal) != len(constraints):
        raise PlannercheckError(
            f"joint_constraints must name each joint once; given are {', '.join(map(shortened, goal)) or 'none'}"
        )
    return goal


def _only_one(node: Node, key: str) -> Node:
    items = sequence(node.get(key), repr(key))
    if len(items) != 1:
        raise PlannercheckError(
            f"the pose of a link is one of position_constraints and one of orientation_constraints; of {key} there "
            f"are {len(items)}"
        )
    return mapping(items[0], f"an entry of {key!r}")


def _middle(region: Node) -> Matrix:
    """The middle (3,) of a constraint's region, i.e. of its only primitive."""
    with error_context("constraint_region"):
        check_keys(region, _REGION_KEYS)
        shapes = [len(sequence(region.get(key), repr(key))) for key in ("primitives", "primitive_poses", "meshes")]
        if shapes != [1, 1, 0]:
            raise PlannercheckError(
                "it must be one of primitives with one of primitive_poses, whose position is the goal's; given are "
                f"{shapes[0]} primitives, {shapes[1]} primitive_poses, {shapes[2]} meshes"
            )
        placed = mapping(region["primitive_poses"][0], "a pose")
        return pose({"position": placed.get("position")})[:3, 3]


def _rotation(node: Node) -> Matrix:
    quaternion = vector(required(node, "orientation"), "orientation", "xyzw")
    length = math.hypot(*quaternion)
    if not abs(length - 1) <= _LARGEST_EXCESS_OF_LENGTH:
        raise PlannercheckError(
            f"'orientation' must be a quaternion of length 1, not {length:.6g}: MoveIt takes the identity for it"
        )
    return rotation_of_quaternion(quaternion)


def _solutions(found: object) -> list[Values]:
    """The solutions of an inverse kinematics, checked."""
    several = [found] if isinstance(found, Mapping) else [] if found is None else found
    if not isinstance(several, Iterable):
        raise _no_solution(several)
    return [_solution(each) for each in several]


def _solution(found: object) -> Values:
    if not isinstance(found, Mapping) or not found:
        raise _no_solution(found)
    return {text(name, "joint name"): number(value, str(name)) for name, value in found.items()}


def _no_solution(found: object) -> PlannercheckError:
    return PlannercheckError(
        "the inverse kinematics must return values by joint name, several such mappings, or None, not "
        f"{shortened(repr(found))}"
    )
