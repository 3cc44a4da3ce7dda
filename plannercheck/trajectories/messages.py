"""Messages of trajectories: JointTrajectory, also within a RobotTrajectory, a DisplayTrajectory or a goal.

In: a message as plain data, e.g. of a .yaml or .json file as `ros2 topic echo` prints it. Out: `Points` in the order of
a robot's joints.
"""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import (
    Node,
    check_keys,
    error_context,
    mapping,
    number,
    numbers,
    parse_yaml,
    read_bytes,
    required,
    sequence,
    text,
)
from plannercheck.common.errors import PlannercheckError, shortened
from plannercheck.common.unique_keys import object_of
from plannercheck.scenes.moveit_messages import transform
from plannercheck.trajectories.controllers import Points
from plannercheck.trajectories.joint_columns import Joints, columns_of, moved_outside, without_followers

TRAJECTORY_KEYS = ("header", "joint_names", "points")
POINT_KEYS = ("positions", "velocities", "accelerations", "effort", "time_from_start")

# Names of a Duration's parts.
_MOST_STAMP = 2**32


def read_document(path: Path) -> Node:
    """The message in a .yaml or .json file, as plain data."""
    content = read_bytes(path)
    if path.suffix.lower() in (".yaml", ".yml"):
        return mapping(parse_yaml(content), "it")
    try:
        return mapping(json.loads(content, object_pairs_hook=object_of), "it")
    except (ValueError, RecursionError) as error:
        raise PlannercheckError(f"is no JSON: {error!s:.200}") from None


def warn_of_start(path: Path, document: Node) -> None:
    """Warns if a message says where the robot starts: nothing looks at it."""
    if document.get("trajectory_start"):
        warnings.warn(
            f"trajectory file {str(path)!r}: trajectory_start is not looked at: give start=, and hold other joints"
            " by robot.holding",
            stacklevel=4,
        )


def joint_trajectories(document: Node) -> list[Node]:
    """The JointTrajectory messages in a document, in order; none if it has neither points nor trajectories.

    Raises:
        PlannercheckError: If a trajectory that it has is none, or something moves that joints do not.
    """
    if "points" in document:
        return [document]
    for key in ("multi_dof_joint_trajectory", "multi_dof_trajectory"):  # of MoveIt, and of control_msgs' goals
        with error_context(key):
            _check_base(mapping(document.get(key), repr(key)))
    keys = [key for key in ("joint_trajectory", "trajectory") if key in document]
    if len(keys) > 1:
        raise PlannercheckError("has both 'joint_trajectory' and 'trajectory': leave one out")
    found: list[Node] = []
    for key in keys:
        inner = document[key]
        for k, item in enumerate(inner if isinstance(inner, list) else [inner]):
            with error_context(f"{key} {k}" if isinstance(inner, list) else key):
                found += _in_entry(mapping(item, "it"))
    return found


def _in_entry(node: Node) -> list[Node]:
    """The messages in a trajectory of a document; at least one."""
    found = joint_trajectories(node)
    if not found:
        held = ", ".join(map(shortened, node)) or "nothing"
        raise PlannercheckError(f"must have 'points', or a 'joint_trajectory' that has them; it has {held}")
    return found


def _check_base(node: Node) -> None:
    """Raises if a joint of several degrees of freedom, such as a mobile base, leaves the identity."""
    for point in sequence(node.get("points"), "'points'"):
        for item in sequence(mapping(point, "a point").get("transforms"), "'transforms'"):
            if not np.array_equal(transform(mapping(item, "a transform")), np.eye(4)):
                moved = ", ".join(map(str, node.get("joint_names") or ())) or "a joint"
                raise PlannercheckError(f"moves {moved}: only joint_trajectory is supported")


def points_of(message: Node, robot: Joints) -> Points:
    """The points of a JointTrajectory in the order of a robot's joints; other joints have to stand still."""
    check_keys(message, TRAJECTORY_KEYS)
    names = [text(name, "joint_names") for name in sequence(required(message, "joint_names"), "'joint_names'")]
    order = columns_of(names, robot, may_hold=True)
    if not sequence(required(message, "points"), "'points'"):
        raise PlannercheckError("has no points")
    times: list[float] = []
    rows: dict[str, list[Any]] = {"positions": [], "velocities": [], "accelerations": []}
    for k, item in enumerate(sequence(required(message, "points"), "'points'")):
        with error_context(f"point {k}"):
            point = mapping(item, "it")
            check_keys(point, POINT_KEYS)
            if not point.get("positions"):
                raise PlannercheckError("has no positions: a controller would integrate velocities, which is refused")
            times.append(seconds(required(point, "time_from_start")))
            for key, found in rows.items():
                given = sequence(point.get(key), repr(key))
                found.append(numbers(given, key, len(names)) if given else [np.nan] * len(names))
    tables = {key: np.array(found, dtype=np.float64).reshape(len(found), -1) for key, found in rows.items()}
    held = _held(names, tables, robot)
    columns = {key: found[:, order] for key, found in tables.items()}
    return Points(np.array(times), joint_names=robot.joint_names, held=held, **columns)


def _held(names: list[str], tables: dict[str, Floats], robot: Joints) -> dict[str, float]:
    """Where the joints outside the planning group stand still."""
    others = [k for k in without_followers(names, tables, robot) if names[k] not in robot.joint_names]
    positions, *derivatives = (found[:, others] for found in tables.values())
    moves = (positions != positions[0]).any(axis=0)
    for found in derivatives:
        moves |= (np.nan_to_num(found) != 0).any(axis=0)
    if moves.any():
        raise moved_outside([names[others[k]] for k in np.flatnonzero(moves).tolist()], robot)
    return {names[k]: float(value) for k, value in zip(others, positions[0].tolist(), strict=True)}


def seconds(duration: Any) -> float:
    """Seconds of a Duration message, or of a number."""
    if not isinstance(duration, dict):
        return number(duration, "time_from_start")
    check_keys(duration, ("sec", "nanosec") if "sec" in duration or "nanosec" in duration else ("secs", "nsecs"))
    whole, parts = (
        _whole(next((duration[key] for key in keys if key in duration), 0), keys[0])
        for keys in (("sec", "secs"), ("nanosec", "nsecs"))
    )
    return (whole * 10**9 + parts) / 10**9


def _whole(value: Any, key: str) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or abs(value) >= _MOST_STAMP:
        raise PlannercheckError(f"{key!r} must be a whole number of at most 32 bits, not {value!s:.60}")
    return value
