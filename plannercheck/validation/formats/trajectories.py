"""MoveIt's trajectories in files: their positions, and whether a controller leaves the straight motions between them.

In: a parsed JointTrajectory, a RobotTrajectory, or a DisplayTrajectory with one of them or several in a row. Out:
`Trajectory`.

A controller moves straight in joint space from point to point only if the trajectory has positions only, or velocities
and accelerations that are all zero: then the splines of all joints pass the same fractions of their ways at the same
times. With other velocities it runs cubic splines, with accelerations as well quintic ones
(joint_trajectory_controller, `Trajectory::interpolate_between_points`). Times and efforts change when the robot passes
a point, not where it passes. Positions are interpolated as they are: a continuous joint goes from 3 to -3 rad through
0. Whole turns are taken off only on the way from the state before a message to its first point (`wraparound_joint`).
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.checked_yaml import Node, check_keys, error_context, mapping, numbers, required, sequence, text
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.shown_times import shown_seconds
from plannercheck.scenes.moveit_states import check_robot_state, joint_values
from plannercheck.trajectories.messages import POINT_KEYS, TRAJECTORY_KEYS, joint_trajectories, seconds

# The fields that bend the way between two points.
_BENDING = ("velocities", "accelerations")


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Trajectories in a row, as one.

    Attributes:
        joint_names: Joint names of the columns.
        positions: (k, joints) rad and m.
        held: The start state's values, by name, of joints that do not move; rad and m.
        bent_by: Which of "velocities" and "accelerations" are not zero: the paths between points are then not straight.
        as_given: (k - 1,) whether continuous joints turn through the numbers as given on the way to the next point:
            within a message, not from one message to the next.
    """

    joint_names: list[str]
    positions: Floats
    held: dict[str, float]
    bent_by: tuple[str, ...]
    as_given: Bools


def read_trajectory(document: Node) -> Trajectory | None:
    """Reads the trajectory of a parsed document; None if there is none.

    Raises:
        PlannercheckError: If its parts name different joints, times fall, or something moves that joints do not.
    """
    nodes = joint_trajectories(document)
    if not nodes:
        return None
    names = _names(nodes[0])
    rows: list[list[float]] = []
    firsts: list[int] = []
    bent: set[str] = set()
    for node in nodes:
        firsts.append(len(rows))
        check_keys(node, TRAJECTORY_KEYS)
        if _names(node) != names:
            raise PlannercheckError(f"its trajectories name different joints: {', '.join(_names(node))}")
        last = -np.inf
        for k, item in enumerate(sequence(required(node, "points"), "'points'")):
            with error_context(f"point {k}"):
                point = mapping(item, "it")
                check_keys(point, POINT_KEYS)
                rows.append(numbers(required(point, "positions"), "positions", len(names)))
                bent.update(key for key in _BENDING if _is_set(point, key, len(names)))
                given = point.get("time_from_start")
                time = last if given is None else seconds(given)
                if time < last:
                    raise PlannercheckError(
                        f"is at {shown_seconds(time)} s, before the point before it: give points in time order"
                    )
                last = time
    held = _held(mapping(document.get("trajectory_start"), "'trajectory_start'"), names)
    positions = np.array(rows, dtype=np.float64).reshape(-1, len(names))
    as_given = np.ones(max(len(rows) - 1, 0), dtype=bool)
    as_given[[first - 1 for first in firsts if 0 < first < len(rows)]] = False
    return Trajectory(names, positions, held, tuple(key for key in _BENDING if key in bent), as_given)


def _names(node: Node) -> list[str]:
    return [text(name, "joint_names") for name in sequence(required(node, "joint_names"), "'joint_names'")]


def _is_set(point: Node, key: str, count: int) -> bool:
    """Whether a point has such numbers that are not all zero."""
    given = sequence(point.get(key), repr(key))
    return any(numbers(given, key, count)) if given else False


def _held(state: Node, moving: list[str]) -> dict[str, float]:
    """Values of the joints that a start state has besides those that move; what it attaches is warned of."""
    with error_context("trajectory_start"):
        check_robot_state(state, "trajectory")
        attached = sequence(state.get("attached_collision_objects"), "'attached_collision_objects'")
        if attached:
            names = [str(mapping(mapping(a, "it").get("object"), "'object'").get("id")) for a in attached]
            warnings.warn(
                f"trajectory_start attaches {', '.join(names)}, which is not looked at: attach it in the scene",
                stacklevel=2,
            )
        values = joint_values(mapping(state.get("joint_state"), "'joint_state'"))
        return {name: value for name, value in values.items() if name not in moving}
