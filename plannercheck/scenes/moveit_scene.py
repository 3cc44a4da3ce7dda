"""MoveIt planning scenes in YAML, as ROS, MoveIt and MotionBenchMaker write them, or their worlds or objects alone.

In: parsed YAML, a scene without objects. Out: the scene as MoveIt would have it.

Objects are posed in the frame that their header names (moveit_frames.py), and their primitives and meshes relative to
the object (moveit_objects.py). docs/reference/moveit.md lists for every field of the messages whether it is used,
refused or ignored. Unsupported fields that would change verdicts raise an error (planes, moved virtual joints) or a
warning (link scales, scenes that are diffs). Two things are used of the robot's state: attached objects,
and the poses of links in whose frames objects are posed. Link padding is kept as `scene.link_padding`, for
`Checker(padding=)`.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from plannercheck.bodies.objects import StatedJoints, scene_object
from plannercheck.common.checked_yaml import (
    Node,
    check_keys,
    error_context,
    mapping,
    number,
    required,
    sequence,
    text,
    text_or_empty,
)
from plannercheck.common.errors import PlannercheckError, shortened
from plannercheck.scenes.contents import AllowedCollisions, SceneContents
from plannercheck.scenes.moveit_attached import attach_from_world, attach_with_shapes, read_attached
from plannercheck.scenes.moveit_frames import find_frame, scene_frames
from plannercheck.scenes.moveit_objects import ObjectMessage, read_object
from plannercheck.scenes.moveit_octomap import read_octomap_message
from plannercheck.scenes.moveit_states import check_robot_state, stated_joints
from plannercheck.scenes.scene_paths import FindFile

# The fields of moveit_msgs/PlanningScene; fields that no verdict depends on are accepted and ignored.
_SCENE_KEYS = (
    *("name", "robot_state", "robot_model_name", "fixed_frame_transforms", "allowed_collision_matrix"),
    *("link_padding", "link_scale", "object_colors", "world", "is_diff"),
)
_TELLING_KEYS = frozenset({"world", "robot_state", "robot_model_name", "allowed_collision_matrix"})

# The fields of moveit_msgs/PlanningSceneWorld, and those that identify a moveit_msgs/CollisionObject.
_WORLD_KEYS = ("collision_objects", "octomap")
_OBJECT_TELLING_KEYS = frozenset({"id", "primitives", "meshes", "planes"})

_FLAGS = frozenset({bool})


def as_planning_scene(document: Node) -> Node | None:
    """The planning scene that a parsed YAML document is, or is the world or an object of, by its keys; None if none."""
    if not _TELLING_KEYS.isdisjoint(document):
        return document
    if not set(_WORLD_KEYS).isdisjoint(document):
        return {"world": document}
    if not _OBJECT_TELLING_KEYS.isdisjoint(document):
        return {"world": {"collision_objects": [document]}}
    return None


def read_planning_scene(
    scene: SceneContents,
    document: Node,
    find_file: FindFile,
) -> None:
    """Reads a parsed planning scene into a scene: its objects, attached objects, and allowed collision matrix."""
    check_keys(document, _SCENE_KEYS)
    scene.name = text_or_empty(document, "name")
    scene.frames = scene_frames(document)
    state = mapping(document.get("robot_state"), "'robot_state'")
    with error_context("robot_state"):
        check_robot_state(state, "scene", scene.frames)
    scene.link_padding = _link_padding(document)
    _warn_of_scale(document)
    _warn_of_diff(document)
    world = mapping(document.get("world"), "'world'")
    check_keys(world, _WORLD_KEYS)
    obstacles = []
    for k, item in enumerate(sequence(world.get("collision_objects"), "'collision_objects'")):
        with error_context(f"collision object {k}"):
            node = mapping(item, "it")
            required(node, "id")
        obstacles.append(read_object(node, find_file))
    with error_context("world: octomap"):
        octomap = read_octomap_message(mapping(world.get("octomap"), "it"))
    obstacles += [] if octomap is None else [octomap]
    _add_objects(scene, state, obstacles, find_file)
    with error_context("allowed_collision_matrix"):
        scene.allowed = _allowed_collisions(mapping(document.get("allowed_collision_matrix"), "it"))


def _add_objects(scene: SceneContents, state: Node, obstacles: Sequence[ObjectMessage], find_file: FindFile) -> None:
    """Adds attached objects and obstacles in MoveIt's order, since each may be posed in an earlier one's frame."""
    with error_context("robot_state"):
        joints = stated_joints(state)
        attached = read_attached(state, joints, find_file)
        attach_with_shapes(scene, attached)
    replaced = {item.name for item in scene.attached}
    names = [read.name for read in obstacles]
    for k, read in enumerate(obstacles):
        if read.name not in replaced:
            _add_obstacle(scene, read, joints, names[k + 1 :])
    with error_context("robot_state"):
        attach_from_world(scene, attached)


def _add_obstacle(scene: SceneContents, read: ObjectMessage, joints: StatedJoints, later: Sequence[str]) -> None:
    with error_context(f"collision object {read.name!r}"):
        if not read.parts:
            raise PlannercheckError("has neither primitives nor meshes")
        frame = find_frame(scene, read.frame, joints, later)
    scene.put(frame.holds(scene_object(read.name, read.parts, read.pose, read.subframes)))


def attach_from_state(scene: SceneContents, state: Node, folder: Path) -> None:
    """Attaches the objects of a robot state, e.g. of a motion request's start, to links; see moveit_attached.py.

    Objects with shapes replace the scene's objects of the same name, attached or not.
    """
    check_robot_state(state, "request", scene.frames)
    attached = read_attached(state, stated_joints(state), FindFile(folder))
    attach_with_shapes(scene, attached)
    attach_from_world(scene, attached)


def _link_padding(document: Node) -> dict[str, float]:
    """Lengths by link, m; a warning says how to use them."""
    nodes = _of_links(document, "padding")
    given = {text(required(n, "link_name"), "link_name"): number(n.get("padding", 0.0), "padding") for n in nodes}
    padding = {link: length for link, length in given.items() if length}
    if padding:
        warnings.warn(
            f"the scene's link_padding, for {', '.join(padding)}, is used if asked for: Checker(..., "
            "padding=scene.link_padding), or --padding scene; then from other links, too, not only from obstacles",
            stacklevel=2,
        )
    return padding


def _of_links(document: Node, what: str) -> list[Node]:
    """The entries of link_padding or link_scale."""
    key = f"link_{what}"
    nodes = [mapping(node, key) for node in sequence(document.get(key), repr(key))]
    with error_context(key):
        for node in nodes:
            check_keys(node, ("link_name", what))
    return nodes


def _warn_of_scale(document: Node) -> None:
    """Warns if the scene asks for links of another size than they are."""
    nodes = _of_links(document, "scale")
    links = [text(required(n, "link_name"), "link_name") for n in nodes if number(n.get("scale", 1.0), "scale") != 1.0]
    if links:
        warnings.warn(f"the scene's link_scale is ignored, for {', '.join(links)}", stacklevel=2)


def _warn_of_diff(document: Node) -> None:
    """Warns if the scene is only what changes in another one."""
    if document.get("is_diff") not in (None, False, 0):
        warnings.warn("the scene is a diff (is_diff): what it changes is not in it, and taken as empty", stacklevel=2)


def _allowed_collisions(node: Node) -> AllowedCollisions:
    """The allowed collision matrix: an entry for each pair of names, defaults for pairs without one."""
    check_keys(node, ("entry_names", "entry_values", "default_entry_names", "default_entry_values"))
    names = [text(n, "entry_names") for n in sequence(node.get("entry_names"), "'entry_names'")]
    rows = [_flags(row) for row in sequence(node.get("entry_values"), "'entry_values'")]
    if len(set(names)) != len(names) or [len(r) for r in rows] != [len(names)] * len(names):
        raise PlannercheckError(f"entry_values must be one row and column for each of {len(names)} different names")
    for i, (row, column) in enumerate(zip(rows, zip(*rows, strict=True), strict=True)):
        if row[:i] != list(column[:i]):
            a, b = names[i], next(name for name, one, other in zip(names, row, column, strict=True) if one != other)
            raise PlannercheckError(f"entry_values of {a!r} with {b!r} and of {b!r} with {a!r} differ")
    known = [text(n, "default_entry_names") for n in sequence(node.get("default_entry_names"), "they")]
    defaults = _flags(node.get("default_entry_values"))
    if len(defaults) != len(known):
        raise PlannercheckError(f"{len(known)} default_entry_names, but {len(defaults)} default_entry_values")
    if len(set(known)) != len(known):
        raise PlannercheckError(f"default_entry_names must differ, but are {shortened(', '.join(known))!r}")
    entries = {
        frozenset((name, earlier)): flag
        for i, name in enumerate(names)
        for earlier, flag in zip(names[:i], rows[i], strict=False)
    }
    return AllowedCollisions(entries, dict(zip(known, defaults, strict=True)))


def _flags(value: Any) -> list[bool]:
    """A row of booleans, bare or in a message's `enabled` field."""
    row = sequence(value.get("enabled") if isinstance(value, dict) else value, "a row of values")
    if _FLAGS.issuperset(map(type, row)):
        return row
    if not all(flag in (True, False) for flag in row):
        raise PlannercheckError(f"values must be true or false, not {row}")
    return [bool(flag) for flag in row]
