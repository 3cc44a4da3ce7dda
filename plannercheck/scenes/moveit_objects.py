"""MoveIt's collision objects in YAML.

In: a parsed `moveit_msgs/CollisionObject`. Out: `ObjectMessage`: shapes posed in the object's frame, its pose in the
frame that its header names, its subframes. A mesh becomes its hull, or a solid where that is asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.objects import Part
from plannercheck.bodies.shapes import Box, Cone, Cylinder, Shape, Sphere, checked_pose
from plannercheck.bodies.solids import OPEN_MESHES
from plannercheck.common.checked_yaml import Node, check_keys, error_context, mapping, numbers, required, sequence, text
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.transforms import identity, is_identity
from plannercheck.scenes.moveit_messages import (
    OCTOMAP,
    header_frame,
    is_all_zeros,
    object_pose,
    pose,
    subframe_poses,
    vector,
)
from plannercheck.scenes.scene_meshes import mesh_parts, shape_of_triangles
from plannercheck.scenes.scene_paths import FindFile

Matrix = NDArray[np.float64]

# The fields of moveit_msgs/CollisionObject; `type`, an entry of a database, is accepted and not read.
_OBJECT_KEYS = dict.fromkeys(
    (
        *("header", "pose", "id", "type", "primitives", "primitive_poses", "meshes", "mesh_poses"),
        *("planes", "plane_poses", "subframe_names", "subframe_poses", "operation"),
    )
)

# More vertices than any mesh has; whole numbers up to here are exact doubles.
_MOST_VERTICES = 2**53

# Names and codes of the operation that puts an object into a scene; ROS 2 writes a byte.
_ADD = (None, 0, "0", "add", "ADD", b"\0", "\0")


def _box(size: Sequence[float]) -> Shape:
    return Box((size[0], size[1], size[2]))


# shape_msgs/SolidPrimitive: code, number of dimensions, shape (cylinders and cones: height, radius, as in MoveIt's
# `constructShapeFromMsg`). Code 5, the prism of ROS 2, MoveIt does not construct either.
_PRIMITIVES: dict[str, tuple[int, int, Callable[[Sequence[float]], Shape]]] = {
    "box": (1, 3, _box),
    "sphere": (2, 1, lambda size: Sphere(size[0])),
    "cylinder": (3, 2, lambda size: Cylinder(size[1], size[0])),
    "cone": (4, 2, lambda size: Cone(size[1], size[0])),
}

_KINDS = {name: kind for kind, (code, _, _) in _PRIMITIVES.items() for name in (kind, str(code))}


@dataclass(frozen=True)
class ObjectMessage:
    """A collision object as in a message.

    Attributes:
        name: Its id.
        parts: Its shapes, posed in its frame.
        pose: (4, 4) of its frame in the header's frame, m.
        frame: The name of the header's frame, without leading slashes; "" if it names none.
        subframes: (4, 4) by name in its frame, m.
    """

    name: str
    parts: tuple[Part, ...]
    pose: Matrix
    frame: str
    subframes: dict[str, Matrix]


def read_object(node: Node, find_file: FindFile) -> ObjectMessage:
    """Reads a collision object.

    As in MoveIt (`PlanningScene::shapesAndPosesFromCollisionObjectMessage`), an object of one shape whose own pose is
    missing or the identity takes the pose of its shape.
    """
    name = text(required(node, "id"), "id")
    with error_context(f"collision object {name!r}"):
        check_keys(node, _OBJECT_KEYS)
        if name == OCTOMAP:
            raise PlannercheckError("this id is the octomap's, and refused by MoveIt, too: choose another name")
        for key in ("planes", "plane_poses"):
            if sequence(node.get(key), f"'{key}'"):
                raise PlannercheckError("planes are not supported: give a box as thick as the robot's reach instead")
        if node.get("operation") not in _ADD:
            raise PlannercheckError(f"operation must be 0 (add) in a whole scene, not {node['operation']!r}")
        own = mapping(node.get("pose"), "'pose'")
        subframes = subframe_poses(node)
        placed = object_pose(own)
        posed = [Part(_primitive(p), q) for p, q in _posed(node, "primitives", "primitive_poses")]
        for mesh, placed_at in _posed(node, "meshes", "mesh_poses"):
            posed += [replace(part, pose=placed_at) for part in _meshes(mesh, find_file)]
        frame = header_frame(node)
    if len(posed) == 1 and (not own or (is_identity(placed) and not is_all_zeros(own))):
        return ObjectMessage(name, (replace(posed[0], pose=None),), checked_pose(posed[0].pose, name), frame, subframes)
    return ObjectMessage(name, tuple(posed), placed, frame, subframes)


def _posed(node: Node, shapes: str, poses: str) -> list[tuple[Node, Matrix]]:
    """Pairs of a shape's mapping and its pose (4, 4) on the object; at its origin if there are none."""
    items = [mapping(item, f"an entry of {shapes!r}") for item in sequence(node.get(shapes), repr(shapes))]
    given = [mapping(item, f"an entry of {poses!r}") for item in sequence(node.get(poses), repr(poses))]
    if given and len(given) != len(items):
        raise PlannercheckError(f"{len(items)} {shapes}, but {len(given)} {poses}: one pose for each is needed")
    if not given:
        return [(item, identity()) for item in items]
    with error_context(poses):
        matrices = [pose(item) for item in given]
    return list(zip(items, matrices, strict=True))


def _primitive(node: Node) -> Shape:
    with error_context("primitives"):
        check_keys(node, ("type", "dimensions", "polygon"))
        kind = _primitive_kind(required(node, "type"))
        _, count, make = _PRIMITIVES[kind]
        return make(numbers(required(node, "dimensions"), f"dimensions of a {kind}", count))


def _primitive_kind(value: Any) -> str:
    """The name of a primitive's type, given as its name or code."""
    kind = _KINDS.get(str(value).lower())
    if kind is not None:
        return kind
    raise unknown_name("primitive type", str(value), [f"{code} ({kind})" for kind, (code, _, _) in _PRIMITIVES.items()])


def _meshes(node: Node, find_file: FindFile) -> list[Part]:
    """The parts of a mesh, given in the file itself or as another file with a scale along each axis.

    MoveIt reads such a file in metres, its axes as they stand (geometric_shapes' `createMeshFromResource`).
    """
    with error_context("meshes"):
        check_keys(node, ("vertices", "triangles", "resource", "dimensions"))
        if "resource" in node:
            keys = {"scale": numbers(node["dimensions"], "dimensions", 3)} if node.get("dimensions") else {}
            units = {"mesh_units": find_file.mesh_units or "metre"}
            return mesh_parts(
                find_file(text(node["resource"], "resource")), keys | units, OPEN_MESHES.get(find_file.meshes)
            )
        rows = sequence(required(node, "vertices"), "'vertices'")
        vertices = np.array([vector(row, "vertices", "xyz") for row in rows]).reshape(-1, 3)
        return [Part(shape_of_triangles(vertices, _triangles(node), find_file.meshes))]


def _triangles(node: Node) -> NDArray[np.int64]:
    """Indices of vertices (m, 3), bare or in messages; absurd ones become indices beyond all vertices."""
    rows = sequence(node.get("triangles"), "'triangles'")
    rows = [row.get("vertex_indices") if isinstance(row, dict) else row for row in rows]
    corners = np.array([numbers(row, "triangles", 3) for row in rows]).reshape(-1, 3)
    if (corners % 1 != 0).any():
        raise PlannercheckError(f"triangles need whole numbers, not {corners[corners % 1 != 0][0]:.9g}")
    return np.asarray(np.clip(corners, -1, _MOST_VERTICES), dtype=np.int64)
