"""Writes scene files of our own format, as scene_files.py reads them: the same doubles.

In: a scene and a path. Out: the file, and files beside it for shapes that were made in memory. A path that ends in
`.scene` gets MoveIt's text, by moveit_text.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from plannercheck.bodies.ellipsoids import ELLIPSOID_EXCESS, Ellipsoid
from plannercheck.bodies.half_spaces import HalfSpace
from plannercheck.bodies.objects import Part, SceneObject, unplaced
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.shapes import Box, Hull, Shape, checked_pose
from plannercheck.bodies.solids import Solid
from plannercheck.bodies.written_poses import node_of_pose
from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.checked_yaml import Node, error_context
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.written_yaml import yaml_of
from plannercheck.scenes import moveit_text
from plannercheck.scenes.contents import SceneContents
from plannercheck.scenes.declared_states import DeclaredStates
from plannercheck.scenes.files_beside import FilesBeside
from plannercheck.scenes.moving_nodes import node_of_moving
from plannercheck.scenes.scene_files import LINK_PAIRS, PAIRS, SIZED
from plannercheck.scenes.sensed_shapes import sensed_kind, sensed_node


def write_scene(scene: SceneContents, path: Path) -> None:
    """Writes a scene, as MoveIt's text if the path ends in `.scene`, else in our own format."""
    beside = FilesBeside(path)
    with error_context(f"scene file {str(path)!r}"):
        is_text = path.suffix.lower() == moveit_text.SUFFIX
        text = moveit_text.scene_text(scene) if is_text else _yaml_text(scene, beside)
    try:
        with beside.written():
            write_atomically(path, lambda aside: aside.write_text(text, encoding="utf-8"))
    except PlannercheckError as error:
        raise PlannercheckError(f"scene {error}") from None


def _yaml_text(scene: SceneContents, beside: FilesBeside) -> str:
    """A scene in our own format: reading it gives the same doubles."""
    document: Node = {"name": scene.name} if scene.name else {}
    document["objects"] = [_object_node(item, beside) for item in scene.objects]
    document |= {"attached": [_attached_node(item, beside) for item in scene.attached]} if scene.attached else {}
    document |= _allowed_nodes(scene)
    states = {robot: states_node(scene, robot, beside.folder) for robot in scene.states}
    document |= {"states": states} if states else {}
    return yaml_of(document)


def _object_node(item: SceneObject, beside: FilesBeside) -> Node:
    if item.pose_frame is not None:
        raise unplaced(item)
    place = node_of_pose(item.pose) if item.moving is None else node_of_moving(item.name, item.moving)
    if len(item.parts) == 1 and item.parts[0].pose is None:
        return {"name": item.name, **_shape_node(item.parts[0], item.name, beside), **place}
    nodes = [
        _shape_node(part, item.name, beside) | node_of_pose(checked_pose(part.pose, item.name)) for part in item.parts
    ]
    return {"name": item.name, **place, "parts": nodes}


def _attached_node(item: SceneObject, beside: FilesBeside) -> Node:
    touched = {"touch_links": list(item.touch_links)} if item.touch_links else {}
    return {**_object_node(item, beside), "link": item.link, **touched}


def _shape_node(part: Part, owner: str, beside: FilesBeside) -> Node:
    shape = part.shape
    if part.source is not None:
        return _file_node(shape, *part.source, beside.folder)
    if isinstance(shape, PartSet):
        return sensed_node(shape, owner, beside)
    if isinstance(shape, Solid):
        return {"solid": {"vertices": shape.vertices.tolist(), "triangles": shape.triangles.tolist(), **_open(shape)}}
    if isinstance(shape, Hull):
        return {"hull": {"vertices": shape.vertices.tolist()}}
    if isinstance(shape, Box):
        return {"box": {"size": list(shape.size)}}
    if isinstance(shape, Ellipsoid):
        excess = {} if shape.excess == ELLIPSOID_EXCESS else {"excess": shape.excess}
        return {"ellipsoid": {"radii": list(shape.radii), **excess}}
    if isinstance(shape, HalfSpace):
        return {"half_space": {"normal": list(shape.normal), "offset": shape.offset}}
    kind = type(shape).__name__.lower()
    return {kind: {key: getattr(shape, key) for key in SIZED[kind][1]}}


def _file_node(shape: Shape, file: Path, more: Mapping[str, Any], folder: Path) -> Node:
    """The mapping of a shape from a file, with its other keys."""
    kind = sensed_kind(shape) if isinstance(shape, PartSet) else "solid" if isinstance(shape, Solid) else "mesh"
    plain = {key: value if isinstance(value, str) else np.asarray(value).tolist() for key, value in more.items()}
    closure = _open(shape) if isinstance(shape, Solid) else {}
    return {kind: {"file": _relative(file, folder), **plain, **closure}}


def _open(solid: Solid) -> Node:
    """What an open mesh is taken as, unless that is the default."""
    return {} if solid.open == "cap" else {"open": solid.open}


def _allowed_nodes(scene: SceneContents) -> Node:
    """Allowed collisions; forbidden pairs matter only where a default would allow them: the SRDF's are of links."""
    known = {*scene.object_names, *(item.name for item in scene.attached)}
    said = {
        key: [
            sorted(pair) * (3 - len(pair))
            for pair, verdict in scene.allowed.pairs.items()
            if verdict is allowed and (key in LINK_PAIRS) == pair.isdisjoint(known)
        ]
        for key, allowed in PAIRS.items()
    }
    nodes: Node = {key: said[key] for key in said if said[key] and PAIRS[key]}
    if scene.allowed.geometries:
        nodes |= {"allowed_geometries": sorted(map(list, scene.allowed.geometries))}
    if scene.allowed.defaults:
        nodes |= {"allowed_by_default": dict(scene.allowed.defaults)}
    matter = [key for key in said if scene.allowed.defaults or key not in LINK_PAIRS]
    return nodes | {key: said[key] for key in matter if said[key] and not PAIRS[key]}


def states_node(scene: DeclaredStates, robot: str, folder: Path) -> Node:
    """The mapping that `read_states` reads."""
    states = scene.states[robot]
    node: Node = {}
    if states.start is not None:
        node["start"] = states.start.tolist()
    if states.goal is not None:
        node["goal"] = states.goal.tolist()
    if states.samples is not None:
        node["samples"] = _relative(states.samples, folder)
    return node


def _relative(file: Path, folder: Path) -> str:
    """A path relative to a folder, absolute if it is not below that folder."""
    absolute = file.resolve()
    return str(absolute.relative_to(folder)) if absolute.is_relative_to(folder) else str(absolute)
