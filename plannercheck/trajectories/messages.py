"""Messages of trajectories: JointTrajectory, also within a RobotTrajectory, a DisplayTrajectory or a goal.

In: a .yaml or .json file, as `ros2 topic echo` prints it. Out: `Points` in the order of a robot's joints.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Sequence
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
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.robot import Robot
from plannercheck.scenes.moveit_messages import transform
from plannercheck.trajectories.controllers import Points

TRAJECTORY_KEYS = ("header", "joint_names", "points")
POINT_KEYS = ("positions", "velocities", "accelerations", "effort", "time_from_start")


def read_points(path: Path, robot: Robot) -> Points:
    """Reads the points of one message.

    Args:
        path: The file.
        robot: Its joints, which take one number each; the message must have them all and no others.
    """
    with error_context(f"trajectory file {str(path)!r}"):
        if len(robot.joint_names) != robot.nq:
            raise PlannercheckError(
                f"needs a robot whose joints take one number each: choose a group; {robot.name}'s"
                f" {robot.configuration_map.described_columns()}"
            )
    return read_named_points(path, robot.joint_names, robot.name)


def read_named_points(path: str | Path, joint_names: Sequence[str], owner: str = "the proof") -> Points:
    """Reads the points of one message.

    Args:
        path: The file.
        joint_names: The joints, in the order of the columns; the message must have them all and no others.
        owner: Whose joints these are, for errors.
    """
    path = Path(path)
    with error_context(f"trajectory file {str(path)!r}"):
        document = _document(path)
        if document.get("trajectory_start"):
            warnings.warn(
                f"trajectory file {str(path)!r}: trajectory_start is not looked at: give start=, and hold other joints"
                " by robot.holding",
                stacklevel=4,
            )
        found = joint_trajectories(document)
        if len(found) != 1:
            raise PlannercheckError(f"holds {len(found)} JointTrajectory messages, and must hold one")
        return _points(found[0], joint_names, owner)


def _document(path: Path) -> Node:
    content = read_bytes(path)
    if path.suffix.lower() in (".yaml", ".yml"):
        return mapping(parse_yaml(content), "it")
    if path.suffix.lower() != ".json":
        raise PlannercheckError("must be a .yaml or a .json file")
    try:
        return mapping(json.loads(content), "it")
    except (ValueError, RecursionError) as error:
        raise PlannercheckError(f"is no JSON: {error!s:.200}") from None


def joint_trajectories(document: Node) -> list[Node]:
    """The JointTrajectory messages in a document, in order."""
    if "points" in document:
        return [document]
    for key in ("multi_dof_joint_trajectory", "multi_dof_trajectory"):  # of MoveIt, and of control_msgs' goals
        with error_context(key):
            _check_base(mapping(document.get(key), repr(key)))
    inner = document.get("joint_trajectory", document.get("trajectory", []))
    items = inner if isinstance(inner, list) else [inner]
    return [found for item in items if isinstance(item, dict) for found in joint_trajectories(mapping(item, "it"))]


def _check_base(node: Node) -> None:
    """Raises if a joint of several degrees of freedom, such as a mobile base, leaves the identity."""
    for point in sequence(node.get("points"), "'points'"):
        for item in sequence(mapping(point, "a point").get("transforms"), "'transforms'"):
            if not np.array_equal(transform(mapping(item, "a transform")), np.eye(4)):
                moved = ", ".join(map(str, node.get("joint_names") or ())) or "a joint"
                raise PlannercheckError(f"moves {moved}: only joint_trajectory is supported")


def _points(message: Node, joint_names: Sequence[str], owner: str) -> Points:
    check_keys(message, TRAJECTORY_KEYS)
    names = [text(name, "joint_names") for name in sequence(required(message, "joint_names"), "'joint_names'")]
    for name in names:
        if name not in joint_names:
            raise PlannercheckError(f"has joint {name!r}, which {owner} has not: {', '.join(joint_names)}")
    missing = [name for name in joint_names if name not in names]
    if missing or len(set(names)) != len(names):
        raise PlannercheckError(f"must have each joint of {owner} once: {', '.join(missing or names)}")
    order = [names.index(name) for name in joint_names]
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
            times.append(_seconds(required(point, "time_from_start")))
            for key, found in rows.items():
                found.append(numbers(point[key], key, len(names)) if point.get(key) else [np.nan] * len(names))
    columns = {key: _ordered(found, order) for key, found in rows.items()}
    return Points(np.array(times), **columns)


def _ordered(rows: list[list[float]], order: list[int]) -> Floats:
    return np.array(rows, dtype=np.float64).reshape(-1, len(order))[:, order]


def _seconds(duration: Any) -> float:
    """Seconds of a Duration message, or of a number."""
    if not isinstance(duration, dict):
        return number(duration, "time_from_start")
    check_keys(duration, ("sec", "nanosec", "secs", "nsecs"))
    whole, parts = (
        number(next((duration[key] for key in keys if key in duration), 0), keys[0])
        for keys in (("sec", "secs"), ("nanosec", "nsecs"))
    )
    return (whole * 10**9 + parts) / 10**9
