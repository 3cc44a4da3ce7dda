"""Planar scenes: convex polygons in the world, by name, and where planning starts and ends.

In: `add_...` calls or a scene file. Out: `bodies`, each a convex polygon posed in the world. A scene file is YAML, in m
and rad, paths relative to the file:

    kind: planar
    name: parking                              # optional, else the file's name
    bounds: [[0, 0], [20, 15]]                 # optional: least and largest x and y of a robot's root
    objects:
      - name: wall
        box: {size: [10.0, 0.2]}               # full edge lengths, about its centre
        position: [5.0, 7.4]                   # optional, as is the angle
        angle: 0.1
      - name: pillar
        polygon: [[0, 0], [1, 0], [1, 2]]      # in order, either way round; concave ones are split
      - name: shelf                            # several
        polygons: [[[0, 0], [1, 0], [1, 1]], [[2, 0], [3, 0], [3, 1]]]
    states:                                    # optional, by robot, as in scenes in space
      forklift: {start: [1, 1, 0], goal: [18, 12, 1.57], samples: parking_forklift.npy}
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import OwnsArrays, named_numbers, read_only, read_only_copy
from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.checked_yaml import (
    Node,
    check_keys,
    error_context,
    mapping,
    number,
    numbers,
    required,
    sequence,
    text,
)
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.html_tables import html_table
from plannercheck.common.public_names import set_module
from plannercheck.common.written_yaml import yaml_of
from plannercheck.planar.links import GeometryObject
from plannercheck.planar.pieces import convex_pieces
from plannercheck.planar.polygons import checked_poses
from plannercheck.planar.robot_files import outline, planar_document, planar_file
from plannercheck.scenes.declared_states import DeclaredStates
from plannercheck.scenes.scene_files import read_states
from plannercheck.scenes.written_scenes import states_node

_SHAPES = ("box", "polygon", "polygons")
_KEYS = ("kind", "name", "bounds", "objects", "states")
_OBJECT_KEYS = ("name", *_SHAPES, "position", "angle", "matrix")


@dataclass(frozen=True, eq=False)
class Obstacle(OwnsArrays):
    """A named obstacle.

    Attributes:
        outlines: The polygons as they were added, (n, 2) each in the obstacle's frame, m.
        pose: (3, 3) in the world, m.
        bodies: Its convex pieces.
    """

    outlines: tuple[Floats, ...]
    pose: Floats
    bodies: tuple[GeometryObject, ...]


@set_module("plannercheck.planar")
class Scene(DeclaredStates):
    """Named convex polygons, posed in the world.

    Attributes:
        name: The name that reports use.
        bounds: Least and largest x and y (2, 2) of a robot's root, m; None if the scene does not say.
        states: Start, goal and samples by robot name.
    """

    def __init__(self, name: str = "", bounds: ArrayLike | None = None) -> None:
        """Makes an empty scene."""
        super().__init__(name)
        self.bounds = None if bounds is None else _checked_bounds(bounds)
        self._obstacles: dict[str, Obstacle] = {}

    def copy(self) -> Scene:
        """A copy that can be changed by itself; both share the obstacles, which never change."""
        other = Scene(self.name, self.bounds)
        other.states, other._obstacles = dict(self.states), dict(self._obstacles)
        return other

    @staticmethod
    def load(path: str | Path) -> Scene:
        """Loads a scene file, or a shipped scene by its bare name, e.g. "warehouse"."""
        return _read(path)

    def save(self, path: str | Path) -> None:
        """Writes the scene; reading it gives the same doubles."""
        _write(self, Path(path))

    def add(self, name: str, outlines: Sequence[ArrayLike], pose: ArrayLike | None = None) -> None:
        """Adds an obstacle.

        Args:
            name: Unique in the scene.
            outlines: Simple polygons (n, 2) in order, m; concave ones are split into convex pieces.
            pose: (3, 3) in the world, m; None is the identity.
        """
        if not name or name in self._obstacles:
            raise PlannercheckError(f"object {name!r} needs a name that no other object has")
        if not isinstance(outlines, Sequence | np.ndarray) or not len(outlines):
            raise PlannercheckError(f"object {name!r} needs at least one polygon")
        matrix = read_only_copy(checked_poses(pose, f"pose of object {name!r}")[0])
        pieces = [piece for outline in outlines for piece in convex_pieces(outline, f"object {name!r}")]
        names = [name] if len(pieces) == 1 else [f"{name}/{k}" for k in range(len(pieces))]
        bodies = tuple(GeometryObject(n, -1, piece, matrix) for n, piece in zip(names, pieces, strict=True))
        arrays = tuple(read_only_copy(outline) for outline in outlines)
        self._obstacles[name] = Obstacle(arrays, matrix, bodies)

    def add_polygon(self, name: str, outline: ArrayLike, pose: ArrayLike | None = None) -> None:
        """Adds one simple polygon (n, 2), m; a concave one is split."""
        self.add(name, [outline], pose)

    def add_box(self, name: str, size: Sequence[float], pose: ArrayLike | None = None) -> None:
        """Adds a rectangle of full edge lengths (2,) about its centre, m."""
        halves = 0.5 * named_numbers(size, f"object {name!r}: size")
        if halves.shape != (2,) or not (halves > 0).all() or not math.isfinite(halves.sum()):
            raise PlannercheckError(f"object {name!r}: size must be two positive lengths, not {size!r:.80}")
        x, y = halves.tolist()
        self.add(name, [[[-x, -y], [x, -y], [x, y], [-x, y]]], pose)

    def remove(self, name: str) -> None:
        """Removes an obstacle."""
        if name not in self._obstacles:
            raise unknown_name("object", name, self._obstacles)
        del self._obstacles[name]

    @property
    def obstacles(self) -> dict[str, Obstacle]:
        """The obstacles by name, in the order in which they were added."""
        return dict(self._obstacles)

    @property
    def object_names(self) -> tuple[str, ...]:
        """Names of the obstacles."""
        return tuple(self._obstacles)

    @property
    def bodies(self) -> tuple[GeometryObject, ...]:
        """All convex pieces of all obstacles."""
        return tuple(body for obstacle in self._obstacles.values() for body in obstacle.bodies)

    @property
    def body_objects(self) -> tuple[str, ...]:
        """For each of `bodies`, the name of its obstacle."""
        return tuple(name for name, obstacle in self._obstacles.items() for _ in obstacle.bodies)

    def __repr__(self) -> str:
        return f"Scene({self.name!r}, {len(self._obstacles)} objects, {len(self.bodies)} bodies)"

    def _repr_html_(self) -> str:
        rows = [
            (name, len(each.bodies), ", ".join(f"{value:.4g}" for value in each.pose[:2, 2]))
            for name, each in self._obstacles.items()
        ]
        return html_table(repr(self), ("object", "convex pieces", "position, m"), rows)


@set_module("plannercheck.planar")
def pose_of(position: Sequence[float] = (0.0, 0.0), angle: float = 0.0) -> Floats:
    """A pose (3, 3) from a position in m and an angle in rad."""
    place, turn = named_numbers(position, "position"), named_numbers(angle, "angle")
    if (place.shape, turn.shape) != ((2,), (1,)) or not np.isfinite([*place, *turn]).all():
        raise PlannercheckError(f"a pose needs x and y and an angle, all finite, not {position!r} and {angle!r}")
    cos, sin = math.cos(turn[0]), math.sin(turn[0])
    return np.array([[cos, -sin, place[0]], [sin, cos, place[1]], [0.0, 0.0, 1.0]])


def _checked_bounds(bounds: ArrayLike) -> Floats:
    array = named_numbers(bounds, "bounds").copy()
    if array.shape != (2, 2) or not np.isfinite(array).all() or not (array[0] < array[1]).all():
        raise PlannercheckError(f"bounds must be the least and the largest x and y, not {array.tolist()}")
    return read_only(array)


def _read(name_or_path: str | Path) -> Scene:
    """Reads a planar scene, named after its file if it has no name of its own."""
    path = planar_file(name_or_path, "configs")
    with error_context(f"scene file {str(path)!r}"):
        content = planar_document(path, _KEYS)
        bounds = content.get("bounds")
        scene = Scene(
            text(content.get("name", path.stem), "name"), None if bounds is None else outline(bounds, "bounds")
        )
        for k, item in enumerate(sequence(content.get("objects"), "'objects'")):
            _add_object(scene, mapping(item, f"object {k}"), k)
        for robot, item in mapping(content.get("states"), "'states'").items():
            with error_context(f"states of {robot!r}"):
                read_states(scene, robot, mapping(item, "they"), path.parent)
    return scene


def _add_object(scene: Scene, node: Node, index: int) -> None:
    with error_context(f"object {index}"):
        name = text(required(node, "name"), "name")
    with error_context(f"object {name!r}"):
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


def _pose(node: Node) -> Floats:
    if "matrix" in node:
        if "position" in node or "angle" in node:
            raise PlannercheckError("'matrix' stands alone: leave out position and angle")
        rows = [numbers(row, "matrix row", 3) for row in sequence(node["matrix"], "'matrix'")]
        return np.asarray(checked_poses(rows, "matrix")[0])
    return pose_of(numbers(node.get("position", [0, 0]), "position", 2), number(node.get("angle", 0), "angle"))


def _write(scene: Scene, path: Path) -> None:
    """Writes a scene so that reading it gives the same doubles."""
    document: Node = {"kind": "planar", "name": scene.name}
    if scene.bounds is not None:
        document["bounds"] = scene.bounds.tolist()
    document["objects"] = [_object_node(name, obstacle) for name, obstacle in scene.obstacles.items()]
    states = {robot: states_node(scene, robot, path.resolve().parent) for robot in scene.states}
    document |= {"states": states} if states else {}
    text = yaml_of(document)
    write_atomically(path, lambda aside: aside.write_text(text, encoding="utf-8"))


def _object_node(name: str, obstacle: Obstacle) -> Node:
    node: Node = {"name": name, "polygons": [polygon.tolist() for polygon in obstacle.outlines]}
    if not np.array_equal(obstacle.pose, np.eye(3)):
        node["matrix"] = obstacle.pose.tolist()
    return node
