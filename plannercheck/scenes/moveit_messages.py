"""Vectors, poses and headers as ROS messages have them in YAML.

In: parsed YAML; vectors are lists, or mappings of x, y, z (and w). Out: 4 x 4 matrices in m, frame names.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.checked_yaml import Node, check_keys, error_context, mapping, numbers, required, sequence, text
from plannercheck.common.errors import PlannercheckError, shortened
from plannercheck.common.transforms import identity, pose_of_quaternion

Matrix = NDArray[np.float64]

# The octomap's name among the objects, which no other object may have (`PlanningScene::OCTOMAP_NS`).
OCTOMAP = "<octomap>"

_NO_TURN = [0.0, 0.0, 0.0, 1.0]


def vector(value: Any, key: str, axes: str) -> list[float]:
    """A vector given as a list or as a mapping of its axes' names."""
    if isinstance(value, dict):
        check_keys(value, tuple(axes))
        value = [required(value, axis) for axis in axes]
    return numbers(value, key, len(axes))


def pose(node: Node, position: str = "position", orientation: str = "orientation") -> Matrix:
    """The pose (4, 4) of a position and a quaternion x, y, z, w, which is normalised; missing entries are zero."""
    check_keys(node, (position, orientation))
    shift, turn = _shift(node, position), _turn(node, orientation)
    return pose_of_quaternion(shift, turn)


def transform(node: Node) -> Matrix:
    """A geometry_msgs/Transform."""
    return pose(node, "translation", "rotation")


def is_all_zeros(node: Node) -> bool:
    """Whether a pose is ROS 1's unset one: everything zero, the quaternion as well."""
    return not any(_shift(node, "position")) and not any(_turn(node, "orientation"))


def _shift(node: Node, key: str) -> list[float]:
    return [0.0] * 3 if node.get(key) is None or node[key] == {} else vector(node[key], key, "xyz")


def _turn(node: Node, key: str) -> list[float]:
    return _NO_TURN if node.get(key) is None or node[key] == {} else vector(node[key], key, "xyzw")


def object_pose(node: Node) -> Matrix:
    """An object's own pose; all zeros means an unset pose, hence the identity, as with Eigen in MoveIt."""
    if not node:
        return identity()
    with error_context("pose"):
        return identity() if is_all_zeros(node) else pose(node)


def header_frame(node: Node) -> str:
    """The frame that a message's header names, without leading slashes; "" if none."""
    header = mapping(node.get("header"), "'header'")
    check_keys(header, ("seq", "stamp", "frame_id"))
    return "" if header.get("frame_id") is None else frame_name(header["frame_id"], "frame_id")


def frame_name(value: Any, key: str) -> str:
    """A frame's name without leading slashes, which MoveIt strips, too (`PlanningScene::getFrameTransform`)."""
    return text(value, key).lstrip("/")


def subframe_poses(node: Node) -> dict[str, Matrix]:
    """The poses of an object's subframes by name."""
    names = [text(name, "subframe_names") for name in sequence(node.get("subframe_names"), "'subframe_names'")]
    poses = [mapping(item, "a pose") for item in sequence(node.get("subframe_poses"), "'subframe_poses'")]
    if len(names) != len(poses):
        raise PlannercheckError(f"{len(names)} subframe_names, but {len(poses)} subframe_poses: each needs one")
    if len(set(names)) != len(names):
        raise PlannercheckError(f"subframe_names must differ, but are {shortened(', '.join(names))!r}")
    if not names:
        return {}
    with error_context("subframe_poses"):
        return {name: pose(item) for name, item in zip(names, poses, strict=True)}
