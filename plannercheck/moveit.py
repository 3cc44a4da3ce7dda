"""MoveIt planning scenes in YAML, as ROS, MoveIt and MotionBenchMaker write them.

In: parsed YAML. Out: a Scene.

An object may have a pose of its own: its primitives' and meshes' poses are relative to it, and it to the
frame that its header names, if the scene gives that frame's transform. Vectors are lists or mappings of
x, y, z (, w). Of a mesh, the hull is taken. The robot's model name, its state and identity virtual joints are
ignored; what would change verdicts and is not supported is an error (planes, octomaps, moved virtual joints)
or a warning that names it (frames without a transform, link scales). Of the state, attached objects are taken. Link
padding is kept as `scene.link_padding`, for `Checker(padding=)`.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.errors import PlannercheckError, unknown_name
from plannercheck.meshes import load_mesh
from plannercheck.moveit_attached import attach_objects
from plannercheck.poses import pose_of, rotation_of_quaternion
from plannercheck.reading import (
    Node,
    check_keys,
    mapping,
    number,
    numbers,
    required,
    sequence,
    text,
    within,
)
from plannercheck.scene import AllowedCollisions, Scene
from plannercheck.scene_objects import Part
from plannercheck.shapes import Box, Cone, Cylinder, Hull, Shape, Sphere

Matrix = NDArray[np.float64]

# The fields of moveit_msgs/PlanningScene; the ones that no verdict depends on are accepted and not read.
_SCENE_KEYS = (
    *("name", "robot_state", "robot_model_name", "fixed_frame_transforms", "allowed_collision_matrix"),
    *("link_padding", "link_scale", "object_colors", "world", "is_diff"),
)
_TELLING_KEYS = frozenset({"world", "robot_state", "robot_model_name", "allowed_collision_matrix"})
_WORLD_KEYS = ("collision_objects", "octomap")
_OBJECT_KEYS = (
    *("header", "pose", "id", "type", "primitives", "primitive_poses", "meshes", "mesh_poses"),
    *("planes", "plane_poses", "subframe_names", "subframe_poses", "operation"),
)

# Names and codes of the operation that puts an object into a scene.
_ADD = (None, 0, "0", "add", "ADD")


def _box(size: Sequence[float]) -> Shape:
    return Box((size[0], size[1], size[2]))


# shape_msgs/SolidPrimitive: code, number of dimensions, shape (cylinders and cones: height, radius).
_PRIMITIVES: dict[str, tuple[int, int, Callable[[Sequence[float]], Shape]]] = {
    "box": (1, 3, _box),
    "sphere": (2, 1, lambda size: Sphere(size[0])),
    "cylinder": (3, 2, lambda size: Cylinder(size[1], size[0])),
    "cone": (4, 2, lambda size: Cone(size[1], size[0])),
}


def is_planning_scene(document: Node) -> bool:
    """Whether a parsed YAML document is a MoveIt planning scene, by its keys."""
    return not _TELLING_KEYS.isdisjoint(document)


def planning_scene(document: Node, folder: Path, package_dirs: Sequence[Path] = ()) -> Scene:
    """Makes a Scene of a parsed planning scene.

    Args:
        document: The YAML document.
        folder: Where relative paths of meshes start.
        package_dirs: Where `package://` meshes are looked for.

    Returns:
        The scene: its objects, what the robot's state attaches, and its allowed collision matrix.
    """
    check_keys(document, _SCENE_KEYS)
    state = mapping(document.get("robot_state"), "'robot_state'")
    check_robot_state(state, "scene")
    scene = Scene(text(document.get("name") or "", "name"))
    scene.link_padding = _link_padding(document)
    _warn_of_scale(document)
    world = mapping(document.get("world"), "'world'")
    check_keys(world, _WORLD_KEYS)
    _refuse_octomap(mapping(world.get("octomap"), "'octomap'"))
    frames = _fixed_frames(document)
    for k, item in enumerate(sequence(world.get("collision_objects"), "'collision_objects'")):
        _add_object(scene, mapping(item, f"collision object {k}"), k, frames, _mesh_finder(folder, package_dirs))
    with within("robot_state"):
        attach_objects(scene, state, _object, frames, _mesh_finder(folder, package_dirs))
    with within("allowed_collision_matrix"):
        scene.allowed = _allowed(mapping(document.get("allowed_collision_matrix"), "it"))
    return scene


def check_robot_state(state: Node, what: str) -> None:
    """Raises if a virtual joint moves the robot's base."""
    joints = mapping(state.get("multi_dof_joint_state"), "'multi_dof_joint_state'")
    names = sequence(joints.get("joint_names"), "'joint_names'")
    for k, item in enumerate(sequence(joints.get("transforms"), "'transforms'")):
        if not np.array_equal(_transform(mapping(item, "a transform")), np.eye(4)):
            name = names[k] if k < len(names) else k
            raise PlannercheckError(
                f"the {what}'s virtual joint {name!r} moves the robot: only the identity is supported"
            )


def attach_from_state(scene: Scene, state: Node, folder: Path) -> None:
    """Attaches what a robot state says, e.g. the start of a motion request, to links; see moveit_attached.py."""
    attach_objects(scene, state, _object, {"": np.eye(4), "world": np.eye(4)}, _mesh_finder(folder, ()))


def _link_padding(document: Node) -> dict[str, float]:
    """Lengths by link, m; says how they are put to use."""
    nodes = [mapping(n, "link_padding") for n in sequence(document.get("link_padding"), "'link_padding'")]
    given = {text(required(n, "link_name"), "link_name"): number(n.get("padding", 0.0), "padding") for n in nodes}
    padding = {link: length for link, length in given.items() if length}
    if padding:
        warnings.warn(
            f"the scene's link_padding, for {', '.join(padding)}, is used if asked for: Checker(..., "
            "padding=scene.link_padding), or --padding scene; then from other links, too, not only from obstacles",
            stacklevel=2,
        )
    return padding


def _warn_of_scale(document: Node) -> None:
    """Warns if the scene asks for links of another size than they are."""
    nodes = [mapping(n, "link_scale") for n in sequence(document.get("link_scale"), "'link_scale'")]
    links = [str(n.get("link_name")) for n in nodes if number(n.get("scale", 1.0), "scale") != 1.0]
    if links:
        warnings.warn(f"the scene's link_scale is ignored, for {', '.join(links)}", stacklevel=2)


def _refuse_octomap(node: Node) -> None:
    data = mapping(node.get("octomap"), "'octomap'").get("data")
    if data:
        raise PlannercheckError("world: octomaps are not supported, only collision_objects")


def _fixed_frames(document: Node) -> dict[str, Matrix]:
    """Transforms to the world, by frame name; the world itself has no name or one of the usual ones."""
    frames = {"": np.eye(4), "world": np.eye(4)}
    for item in sequence(document.get("fixed_frame_transforms"), "'fixed_frame_transforms'"):
        node = mapping(item, "a fixed frame transform")
        name = text(required(node, "child_frame_id"), "child_frame_id")
        with within(f"fixed_frame_transforms {name!r}"):
            frames[name] = _transform(mapping(required(node, "transform"), "'transform'"))
    return frames


def _add_object(
    scene: Scene, node: Node, index: int, frames: dict[str, Matrix], find_mesh: Callable[[str], Path]
) -> None:
    with within(f"collision object {index}"):
        text(required(node, "id"), "id")
    name, parts, pose = _object(node, find_mesh)
    with within(f"collision object {name!r}"):
        if not parts:
            raise PlannercheckError("has neither primitives nor meshes")
        frame = _frame_of(node, frames)
    scene.add(name, parts, frame @ pose)


def _object(node: Node, find_mesh: Callable[[str], Path]) -> tuple[str, list[Part], Matrix]:
    """The name, the parts and the pose, in the frame that the header names, of a collision object.

    A pose that is unset is that of its only shape, if it has just one, as in MoveIt.
    """
    name = text(required(node, "id"), "id")
    with within(f"collision object {name!r}"):
        check_keys(node, _OBJECT_KEYS)
        if sequence(node.get("planes"), "'planes'"):
            raise PlannercheckError("planes are not supported: give a box as thick as the robot's reach instead")
        if node.get("operation") not in _ADD:
            raise PlannercheckError(f"operation must be 0 (add) in a whole scene, not {node['operation']!r}")
        pose = _object_pose(mapping(node.get("pose"), "'pose'"))
        posed = [(_primitive(p), q) for p, q in _posed(node, "primitives", "primitive_poses")]
        posed += [(_mesh(m, find_mesh), q) for m, q in _posed(node, "meshes", "mesh_poses")]
    if len(posed) == 1 and np.array_equal(pose, np.eye(4)):
        return name, [Part(posed[0][0])], posed[0][1]
    return name, [Part(shape, q) for shape, q in posed], pose


def _frame_of(node: Node, frames: dict[str, Matrix]) -> Matrix:
    """The transform of the frame that an object's header names."""
    frame = text(mapping(node.get("header"), "'header'").get("frame_id") or "", "frame_id").lstrip("/")
    if frame not in frames:
        warnings.warn(
            f"frame {frame!r} of object {node['id']!r} has no fixed_frame_transform, taken as the world",
            stacklevel=2,
        )
    return frames.get(frame, np.eye(4))


def _posed(node: Node, shapes: str, poses: str) -> list[tuple[Node, Matrix]]:
    """Pairs of a shape's mapping and its pose (4, 4) on the object; at its origin if there are none."""
    items = [mapping(item, f"an entry of {shapes!r}") for item in sequence(node.get(shapes), repr(shapes))]
    given = [mapping(item, f"an entry of {poses!r}") for item in sequence(node.get(poses), repr(poses))]
    if given and len(given) != len(items):
        raise PlannercheckError(f"{len(items)} {shapes}, but {len(given)} {poses}: one pose for each is needed")
    with within(poses):
        matrices = [_pose(item) for item in given] or [np.eye(4)] * len(items)
    return list(zip(items, matrices, strict=True))


def _primitive(node: Node) -> Shape:
    with within("primitives"):
        check_keys(node, ("type", "dimensions", "polygon"))
        kind = _primitive_kind(required(node, "type"))
        _, count, make = _PRIMITIVES[kind]
        return make(numbers(required(node, "dimensions"), f"dimensions of a {kind}", count))


def _primitive_kind(value: Any) -> str:
    """The name of a primitive's type, given as its name or code."""
    for kind, (code, _, _) in _PRIMITIVES.items():
        if str(value).lower() in (kind, str(code)):
            return kind
    raise unknown_name("primitive type", str(value), [f"{code} ({kind})" for kind, (code, _, _) in _PRIMITIVES.items()])


def _mesh(node: Node, find_mesh: Callable[[str], Path]) -> Hull:
    """The hull of a mesh, given in the file itself or as another file with a scale along each axis."""
    with within("meshes"):
        check_keys(node, ("vertices", "triangles", "resource", "dimensions"))
        if "resource" in node:
            scale = numbers(node["dimensions"], "dimensions", 3) if node.get("dimensions") else 1.0
            return load_mesh(find_mesh(text(node["resource"], "resource")), scale)
        rows = sequence(required(node, "vertices"), "'vertices'")
        vertices = np.array([_vector(row, "vertices", "xyz") for row in rows]).reshape(-1, 3)
        return Hull(vertices[_used(node, len(vertices))])


def _used(node: Node, count: int) -> NDArray[np.int64]:
    """Indices of the vertices that a mesh's triangles use; all, if it has none."""
    rows = sequence(node.get("triangles"), "'triangles'")
    rows = [row.get("vertex_indices") if isinstance(row, dict) else row for row in rows]
    used = sorted({int(i) for row in rows for i in numbers(row, "triangles", 3)})
    if used and not (used[0] >= 0 and used[-1] < count):
        raise PlannercheckError(f"triangles use vertices {used[0]} to {used[-1]}, but there are {count} vertices")
    return np.array(used or range(count), dtype=np.int64)


def _mesh_finder(folder: Path, package_dirs: Sequence[Path]) -> Callable[[str], Path]:
    """A function that turns a mesh's resource, a path or a file:// or package:// address, into a path."""

    def find(resource: str) -> Path:
        if not resource.startswith("package://"):
            return folder / resource.removeprefix("file://")
        relative = resource.removeprefix("package://")
        found = [d / relative for d in package_dirs if (d / relative).is_file()]
        if not found:
            looked = ", ".join(str(d) for d in package_dirs) or "none were given"
            raise PlannercheckError(f"mesh {resource!r} is in none of the package_dirs ({looked})")
        return found[0]

    return find


def _vector(value: Any, key: str, axes: str) -> list[float]:
    """A vector given as a list or as a mapping of its axes' names."""
    if isinstance(value, dict):
        check_keys(value, tuple(axes))
        value = [required(value, axis) for axis in axes]
    return numbers(value, key, len(axes))


def _pose(node: Node, position: str = "position", orientation: str = "orientation") -> Matrix:
    """The pose (4, 4) of a position and an x, y, z, w quaternion; what is left out is zero."""
    check_keys(node, (position, orientation))
    shift = _vector(node.get(position) or [0.0] * 3, position, "xyz")
    turn = _vector(node.get(orientation) or [0.0, 0.0, 0.0, 1.0], orientation, "xyzw")
    return pose_of(shift, rotation_of_quaternion(turn))


def _object_pose(node: Node) -> Matrix:
    """An object's own pose; all zeros is a message's unset pose, hence the identity."""
    unset = node and not any(_vector(node.get("position") or [0.0] * 3, "position", "xyz"))
    unset = unset and not any(_vector(node.get("orientation") or [0.0] * 3 + [1.0], "orientation", "xyzw"))
    with within("pose"):
        return np.eye(4) if unset else _pose(node)


def _transform(node: Node) -> Matrix:
    """A geometry_msgs/Transform."""
    return _pose(node, "translation", "rotation")


def _allowed(node: Node) -> AllowedCollisions:
    """The allowed collision matrix: an entry for each pair of names, defaults for pairs without one."""
    check_keys(node, ("entry_names", "entry_values", "default_entry_names", "default_entry_values"))
    names = [text(n, "entry_names") for n in sequence(node.get("entry_names"), "'entry_names'")]
    rows = [_flags(row) for row in sequence(node.get("entry_values"), "'entry_values'")]
    if len(set(names)) != len(names) or [len(r) for r in rows] != [len(names)] * len(names):
        raise PlannercheckError(f"entry_values must be one row and column for each of {len(names)} different names")
    pairs = [(i, j) for i in range(len(names)) for j in range(i)]
    for a, b in ((names[i], names[j]) for i, j in pairs if rows[i][j] != rows[j][i]):
        raise PlannercheckError(f"entry_values of {a!r} with {b!r} and of {b!r} with {a!r} differ")
    known = [text(n, "default_entry_names") for n in sequence(node.get("default_entry_names"), "they")]
    defaults = _flags(node.get("default_entry_values"))
    if len(defaults) != len(known):
        raise PlannercheckError(f"{len(known)} default_entry_names, but {len(defaults)} default_entry_values")
    entries = {frozenset((names[i], names[j])): rows[i][j] for i, j in pairs}
    return AllowedCollisions(entries, dict(zip(known, defaults, strict=True)))


def _flags(value: Any) -> list[bool]:
    """A row of booleans, bare or in a message's `enabled` field."""
    row = sequence(value.get("enabled") if isinstance(value, dict) else value, "a row of values")
    if not all(flag in (True, False) for flag in row):
        raise PlannercheckError(f"values must be true or false, not {row}")
    return [bool(flag) for flag in row]
