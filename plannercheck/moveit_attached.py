"""Objects that a MoveIt robot state attaches to links.

In: `attached_collision_objects` of a parsed robot state, and the scene it belongs to. Out: the scene with them.

As MoveIt has it: an object without shapes is the one of that name in the world, attached where it stands; one with
shapes takes the place of an object of that name. Its pose is relative to the frame that its header names: the link
itself, as MoveIt writes it, another link, or a fixed frame; then it is known once there is a robot to pose, at the
state's joint values.
"""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plannercheck.errors import PlannercheckError, unknown_name
from plannercheck.reading import Node, check_keys, mapping, numbers, required, sequence, text, within
from plannercheck.scene import Scene
from plannercheck.scene_objects import Anchor, Part, SceneObject, scene_object

Matrix = NDArray[np.float64]

# Reads the name, the parts and the pose in the header's frame of a collision object's mapping.
ReadObject = Callable[[Node, Callable[[str], Path]], tuple[str, list[Part], Matrix]]

_KEYS = ("link_name", "object", "touch_links", "detach_posture", "weight")


def attach_objects(
    scene: Scene, state: Node, read: ReadObject, frames: dict[str, Matrix], find_mesh: Callable[[str], Path]
) -> None:
    """Attaches what a robot state says; objects that the scene has attached already stay as they are.

    Args:
        scene: Changed in place.
        state: A robot state.
        read: Reads a collision object.
        frames: Fixed frames' transforms to the world.
        find_mesh: Turns a mesh's resource into a path.
    """
    items = sequence(state.get("attached_collision_objects"), "'attached_collision_objects'")
    joints = _joint_values(mapping(state.get("joint_state"), "'joint_state'")) if items else {}
    for k, item in enumerate(items):
        with within(f"attached object {k}"):
            node = mapping(item, "it")
            check_keys(node, _KEYS)
            _attach(scene, node, joints, read, frames, find_mesh)


def _attach(
    scene: Scene,
    node: Node,
    joints: dict[str, float],
    read: ReadObject,
    frames: dict[str, Matrix],
    find_mesh: Callable[[str], Path],
) -> None:
    link = text(required(node, "link_name"), "link_name")
    touched = [text(name, "touch_links") for name in sequence(node.get("touch_links"), "'touch_links'")]
    inner = mapping(required(node, "object"), "'object'")
    name, parts, pose = read(inner, find_mesh)
    if name in {item.name for item in scene.attached}:
        return
    if not parts:
        if name not in scene.object_names:
            raise unknown_name("object to attach, without shapes of its own,", name, scene.object_names)
        item = scene.object(name)
        anchor: Anchor | None = Anchor("", joints)
    else:
        anchor, pose = _anchor(inner, name, link, joints, frames, pose)
        item = scene_object(name, parts, pose)
    if name in scene.object_names:
        scene.remove(name)
    scene.put_attached(_anchored(item.attached(link, item.pose, touched), anchor))


def _anchored(item: SceneObject, anchor: Anchor | None) -> SceneObject:
    return item if anchor is None else dataclasses.replace(item, anchor=anchor)


def _anchor(
    node: Node, name: str, link: str, joints: dict[str, float], frames: dict[str, Matrix], pose: Matrix
) -> tuple[Anchor | None, Matrix]:
    """Where the object's pose is given, and the pose there; None for its own link."""
    frame = text(mapping(node.get("header"), "'header'").get("frame_id") or "", "frame_id").lstrip("/")
    if not frame:
        warnings.warn(f"attached object {name!r} names no frame, its pose is taken as on link {link!r}", stacklevel=2)
    if not frame or frame == link:
        return None, pose
    if frame in frames:
        return Anchor("", joints), frames[frame] @ pose
    return Anchor(frame, joints), pose


def _joint_values(node: Node) -> dict[str, float]:
    names = [text(n, "name") for n in sequence(node.get("name"), "'name'")]
    values = numbers(node.get("position") or [], "position", len(names)) if names else []
    if len(set(names)) != len(names):
        raise PlannercheckError(f"joint_state names a joint twice: {', '.join(names)}")
    return dict(zip(names, values, strict=True))
