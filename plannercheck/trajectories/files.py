"""Files of trajectories: messages, tables, and bags.

In: a path, a robot. Out: `Points` in the order of the robot's joints; errors name the file.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from plannercheck.common.angles import are_degrees, share_within
from plannercheck.common.checked_yaml import Node, error_context, sequence
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.package_data import why_no_file
from plannercheck.robots.robot import Robot
from plannercheck.trajectories.bags import read_bag
from plannercheck.trajectories.controllers import Points
from plannercheck.trajectories.joint_columns import Joints, check_held, check_plain_joints
from plannercheck.trajectories.messages import joint_trajectories, points_of, read_document, warn_of_start
from plannercheck.trajectories.tables import read_csv, read_npz

_MESSAGES = (".yaml", ".yml", ".json")
_BAGS = (".db3", ".mcap", ".bag")

# Messages that an error lists.
_MOST_LISTED = 20


def read_points(path: str | Path, robot: Robot, message: int | None = None) -> Points:
    """Reads the points of one trajectory.

    Args:
        path: A file, or the folder of a bag.
        robot: Its joints, which take one number each; the file must have them all. A message may have joints outside
            the group, too, which stand still where the robot holds them.
        message: Which JointTrajectory of several, counted from 0; None: the file must hold one.
    """
    with error_context(f"trajectory file {str(path)!r}"):
        check_plain_joints(robot)
    points = read_points_of(path, robot, message)  # which names the file itself
    with error_context(f"trajectory file {str(path)!r}"):
        check_held(robot, points.held)
        limits = robot.lower, robot.upper
        if share_within(points.positions, *limits) < 0.5 and are_degrees(points.positions, *limits):
            raise PlannercheckError(
                "most points are beyond the limits, and as degrees they would not be: angles are in rad, convert them"
                " by numpy.radians"
            )
    return points


def read_points_of(file: str | Path, robot: Joints, message: int | None = None) -> Points:
    """`read_points` for joints that are known to take one number each."""
    if not isinstance(file, str | Path):
        raise PlannercheckError(f"path must be a file, not {file!r:.80}")
    if message is not None and not isinstance(message, int):
        raise PlannercheckError(f"message must be a whole number, not {message!r:.80}")
    path = Path(file)
    suffix = path.suffix.lower()
    with error_context(f"trajectory file {str(path)!r}"):
        if not path.exists():
            raise PlannercheckError(why_no_file(path))
        if path.is_dir() or suffix in _BAGS:
            return points_of(_chosen(read_bag(path), message), robot)
        if suffix in _MESSAGES:
            document = read_document(path)
            warn_of_start(path, document)
            return points_of(_chosen([("", found) for found in joint_trajectories(document)], message), robot)
        if message is not None:
            raise PlannercheckError("holds one trajectory: leave message= out")
        if suffix == ".csv":
            return read_csv(path, robot)
        if suffix == ".npz":
            return read_npz(path, robot)
        known = ", ".join((*_MESSAGES, ".csv", ".npz", *_BAGS))
        raise PlannercheckError(f"must be one of {known}, or the folder of a bag")


def _chosen(found: Sequence[tuple[str, Node]], message: int | None) -> Node:
    """The message that is asked for, of messages with the topics they came by."""
    if message is None and len(found) == 1:
        return found[0][1]
    if message is not None and 0 <= message < len(found):
        return found[message][1]
    if not found:
        raise PlannercheckError("holds no JointTrajectory: one has joint_names and points")
    listed = "; ".join(f"{k}: {_described(topic, node)}" for k, (topic, node) in enumerate(found[:_MOST_LISTED]))
    listed += f"; and {len(found) - _MOST_LISTED} more" if len(found) > _MOST_LISTED else ""
    raise PlannercheckError(
        f"holds {len(found)} JointTrajectory messages: choose one by message= (--message): {listed}"
    )


def _described(topic: str, message: Node) -> str:
    points = sequence(message.get("points"), "'points'")
    joints = sequence(message.get("joint_names"), "'joint_names'")
    return f"{topic and f'{topic}, '}{len(joints)} joints, {len(points)} points"
