"""Objects that move in scene files of our own format.

In: an object's mapping, or a `Moving`. Out: the `Moving`, or the mapping that is read back as the same doubles.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from plannercheck.bodies.moving import Moving
from plannercheck.bodies.written_poses import POSE_KEYS, node_of_pose, pose_of_node
from plannercheck.common.checked_yaml import Node, check_keys, error_context, mapping, number, required, sequence, text
from plannercheck.common.errors import PlannercheckError

MOVING = "moving"
_DEFAULTS = {"path": "slerp", "outside": "refuse"}


def moving_of_node(node: Node) -> Moving:
    """How an object moves, as its mapping says."""
    if any(key in node for key in POSE_KEYS):
        raise PlannercheckError("'moving' says where it is: leave out position, quaternion, rpy and matrix")
    with error_context(MOVING):
        values = mapping(node[MOVING], "it")
        check_keys(values, ("times", "poses", *_DEFAULTS))
        poses = []
        for k, item in enumerate(sequence(required(values, "poses"), "'poses'")):
            with error_context(f"pose {k}"):
                if item is None:
                    raise PlannercheckError("it is empty: write {} for the identity")
                pose = mapping(item, "it")
                check_keys(pose, POSE_KEYS)
                poses.append(pose_of_node(pose))
        words: dict[str, Any] = {key: text(values[key], key) for key in _DEFAULTS if key in values}
        times = [number(item, "times") for item in sequence(required(values, "times"), "'times'")]
        return Moving(times, np.array(poses).reshape(-1, 4, 4), **words)


def node_of_moving(name: str, moving: Moving) -> Node:
    """The mapping of an object's `Moving`."""
    if moving.ride is not None:
        raise PlannercheckError(f"object {name!r} rides on a robot's link, which no scene file says: leave it out")
    words = {key: getattr(moving, key) for key, usual in _DEFAULTS.items() if getattr(moving, key) != usual}
    return {MOVING: {"times": moving.times.tolist(), "poses": [node_of_pose(pose) for pose in moving.poses], **words}}
