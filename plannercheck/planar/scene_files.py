"""Reads and writes planar scene files, which planar/scene.py documents."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

from plannercheck.common.checked_yaml import (
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
from plannercheck.common.errors import PlannercheckError
from plannercheck.planar.polygons import checked_poses
from plannercheck.planar.robot_files import outline, planar_document, planar_file
from plannercheck.planar.scene import Obstacle, Scene, pose_of
from plannercheck.scenes.scene_files import read_states, states_node

_SHAPES = ("box", "polygon", "polygons")
_KEYS = ("kind", "name", "bounds", "objects", "states")
_OBJECT_KEYS = ("name", *_SHAPES, "position", "angle", "matrix")


def read_scene(name_or_path: str | Path) -> Scene:
    """Reads a planar scene, named after its file if it has no name of its own."""
    path = planar_file(name_or_path, "configs")
    with within(f"scene file {str(path)!r}"):
        content = planar_document(path, _KEYS)
        bounds = content.get("bounds")
        scene = Scene(
            text(content.get("name", path.stem), "name"), None if bounds is None else outline(bounds, "bounds")
        )
        for k, item in enumerate(sequence(content.get("objects"), "'objects'")):
            _add_object(scene, mapping(item, f"object {k}"), k)
        for robot, item in mapping(content.get("states"), "'states'").items():
            with within(f"states of {robot!r}"):
                read_states(scene, robot, mapping(item, "they"), path.parent)
    return scene


def _add_object(scene: Scene, node: Node, index: int) -> None:
    with within(f"object {index}"):
        name = text(required(node, "name"), "name")
    with within(f"object {name!r}"):
        check_keys(node, _OBJECT_KEYS)
        given = [key for key in _SHAPES if key in node]
        if len(given) != 1:
            raise PlannercheckError(f"needs exactly one of the keys {', '.join(_SHAPES)}, not {given}")
        pose = _pose(node)
        if given[0] == "box":
            values = mapping(node["box"], "'box'")
            check_keys(values, ("size",))
            scene.add_box(name, numbers(required(values, "size"), "size", 2), pose)
        else:
            polygons = [node["polygon"]] if given[0] == "polygon" else sequence(node["polygons"], "'polygons'")
            scene.add(name, [outline(polygon, "polygon") for polygon in polygons], pose)


def _pose(node: Node) -> NDArray[np.float64]:
    if "matrix" in node:
        if "position" in node or "angle" in node:
            raise PlannercheckError("'matrix' stands alone: leave out position and angle")
        rows = [numbers(row, "matrix row", 3) for row in sequence(node["matrix"], "'matrix'")]
        return np.asarray(checked_poses(rows, "matrix")[0])
    return pose_of(numbers(node.get("position", [0, 0]), "position", 2), number(node.get("angle", 0), "angle"))


def write_scene(scene: Scene, path: Path) -> None:
    """Writes a scene so that reading it gives the same doubles."""
    document: Node = {"kind": "planar", "name": scene.name}
    if scene.bounds is not None:
        document["bounds"] = scene.bounds.tolist()
    document["objects"] = [_object_node(name, obstacle) for name, obstacle in scene.obstacles.items()]
    states = {robot: states_node(scene, robot, path.resolve().parent) for robot in scene.states}
    document |= {"states": states} if states else {}
    try:
        path.write_text(yaml.dump(document, sort_keys=False, default_flow_style=None, width=110), encoding="utf-8")
    except OSError as error:
        raise PlannercheckError(f"scene file {str(path)!r} can't be written: {error.strerror}") from None


def _object_node(name: str, obstacle: Obstacle) -> Node:
    node: Node = {"name": name, "polygons": [polygon.tolist() for polygon in obstacle.outlines]}
    if not np.array_equal(obstacle.pose, np.eye(3)):
        node["matrix"] = obstacle.pose.tolist()
    return node
