"""Poses as scene files and cells write them: position, and quaternion or rpy; or a matrix.

In: a mapping of YAML. Out: a matrix (4, 4), m; and the mapping that is read back as the same doubles.
"""

from __future__ import annotations

import numpy as np

from plannercheck.bodies.shapes import checked_pose
from plannercheck.common.angles import LARGEST_USUAL_ANGLE
from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import Node, numbers, sequence, warn_here
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.transforms import pose_of, quaternion_of_rotation, rotation_of_quaternion, rotation_of_rpy

POSE_KEYS = ("position", "quaternion", "rpy", "matrix")


def pose_of_node(node: Node) -> Floats:
    """The pose (4, 4) that a mapping's pose keys give, by default the identity."""
    if "matrix" in node:
        if any(key in node for key in POSE_KEYS[:-1]):
            raise PlannercheckError("'matrix' stands alone: leave out position, quaternion and rpy")
        return checked_pose([numbers(row, "matrix row", 4) for row in sequence(node["matrix"], "'matrix'")], "matrix")
    position = numbers(node["position"], "position", 3) if "position" in node else [0.0, 0.0, 0.0]
    if "quaternion" in node and "rpy" in node:
        raise PlannercheckError("'quaternion' and 'rpy' say the same: leave one out")
    if "quaternion" in node:
        return pose_of(position, rotation_of_quaternion(numbers(node["quaternion"], "quaternion", 4)))
    if "rpy" in node:
        rpy = numbers(node["rpy"], "rpy", 3)
        if max(map(abs, rpy)) > LARGEST_USUAL_ANGLE:
            warn_here(f"rpy {rpy} looks like degrees: rpy is in rad")
        return pose_of(position, rotation_of_rpy(rpy))
    return pose_of(position)


def node_of_pose(pose: Floats) -> Node:
    """Position and quaternion where they give the same doubles, else the matrix itself."""
    position = pose[:3, 3].tolist()
    if np.array_equal(pose[:3, :3], np.eye(3)):
        return {"position": position} if any(position) else {}
    quaternion = quaternion_of_rotation(pose[:3, :3])
    if np.array_equal(rotation_of_quaternion(quaternion), pose[:3, :3]):
        return {"position": position, "quaternion": quaternion}
    return {"matrix": pose.tolist()}
