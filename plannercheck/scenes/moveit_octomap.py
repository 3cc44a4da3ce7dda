"""MoveIt's octomap in YAML, as an obstacle.

In: a parsed `octomap_msgs/OctomapWithPose`. Out: `ObjectMessage` of one octree, or None without data.

As in MoveIt (`PlanningScene::processOctomapMsg`, planning_scene.cpp; `createOctomap` there, and `readTree` of
octomap_msgs, conversions.h): the object is named `<octomap>`, an id that no other object may have; entries of allowed
collision matrices and paddings know it by that name. Its pose is `origin` in the frame of the outer header; the inner
header is not read. The tree's `id` must be "OcTree". `binary` tells the data of a .bt from that of a .ot file, each
without its header. Cells are occupied from a probability of 0.5 on (OctoMap's default, which the message does not
give), and unknown space is free.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from plannercheck.bodies.objects import Part
from plannercheck.bodies.octrees import Octree
from plannercheck.common.checked_yaml import Node, check_keys, mapping, number, required, text_or_empty
from plannercheck.common.errors import PlannercheckError, shortened
from plannercheck.common.yaml_loader import WrittenInt
from plannercheck.scenes.moveit_messages import OCTOMAP, header_frame, object_pose
from plannercheck.scenes.moveit_objects import ObjectMessage

_KIND = "OcTree"

_WHOLE = frozenset({int, WrittenInt})


def read_octomap_message(node: Node) -> ObjectMessage | None:
    """The octomap of a planning scene's world."""
    check_keys(node, ("header", "origin", "octomap"))
    tree = mapping(node.get("octomap"), "'octomap'")
    check_keys(tree, ("header", "binary", "id", "resolution", "data"))
    data = _bytes(tree.get("data"))
    if not data:
        return None
    kind = text_or_empty(tree, "id")
    if kind != _KIND:
        raise PlannercheckError(f"id must be {_KIND!r}, the only type that MoveIt takes, not {shortened(kind)!r}")
    resolution = number(required(tree, "resolution"), "resolution")
    shape = Octree.from_message(data, kind, _flag(tree.get("binary")), resolution)
    pose = object_pose(mapping(node.get("origin"), "'origin'"))
    return ObjectMessage(OCTOMAP, (Part(shape),), pose, header_frame(node), {})


def _flag(value: Any) -> bool:
    if value not in (None, False, True):
        raise PlannercheckError(f"'binary' must be true or false, not {shortened(value)}")
    return bool(value)


def _bytes(value: Any) -> bytes:
    """The data: bytes, or a list of them as whole numbers, which ROS writes with a sign (int8)."""
    if value is None or isinstance(value, bytes):
        return value or b""
    if not isinstance(value, list):
        raise PlannercheckError(f"'data' must be a list of bytes, not {shortened(value)}")
    numbers = np.array(value) if _WHOLE.issuperset(map(type, value)) else np.zeros(0)
    if value and not (numbers.size and numbers.min() >= -128 and numbers.max() <= 255):
        place = next(k for k, each in enumerate(value) if type(each) not in _WHOLE or not -128 <= each <= 255)
        raise PlannercheckError(f"'data' must be bytes, but entry {place} is {shortened(value[place])!r}")
    return numbers.astype(np.int64).astype(np.uint8).tobytes()
