"""MoveIt's text format of scenes, `.scene`, which RViz exports and imports.

In: the file's content, a scene without objects. Out: the scene with them, and back.

The format is that of moveit_core: `PlanningScene::saveGeometryToStream` and `loadGeometryFromStream`
(planning_scene.cpp), with `shapes::saveAsText` and `constructShapeFromText` of geometric_shapes (shape_operations.cpp):

    name of the scene
    * id of an object                  the rest of the line
    x y z                              its pose; the older format has none, and no subframes
    qx qy qz qw
    1                                  number of shapes, each of which is
    cylinder                           sphere (radius), box (x y z), cylinder and cone (radius length), mesh (see _mesh)
    0.03 0.14
    x y z                              its pose on the object
    qx qy qz qw
    0 0 0 0                            its colour, which is not read
    1                                  number of subframes, each of which is a name and a pose on the object
    tip
    x y z
    qx qy qz qw
    .                                  the end

Line breaks matter for the name and the ids only; elsewhere any white space separates words. Poses are in the planning
frame.
"""

from __future__ import annotations

import dataclasses
import math
import re
import warnings
from collections.abc import Callable
from contextlib import AbstractContextManager

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.objects import Part, SceneObject, scene_object, unplaced
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import Box, Cone, Cylinder, Hull, Shape, Sphere, checked_pose
from plannercheck.bodies.solids import Solid
from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError, shortened, unknown_name
from plannercheck.common.transforms import pose_of, quaternion_of_rotation, rotation_of_quaternion
from plannercheck.scenes.contents import SceneContents
from plannercheck.scenes.moveit_messages import OCTOMAP
from plannercheck.scenes.scene_meshes import shape_of_triangles
from plannercheck.scenes.scene_paths import MeshKind

Matrix = NDArray[np.float64]

# Suffixes of file names, in lower case.
SUFFIX = ".scene"

_OBJECT, _END = "*", "."
_COLOUR = "0 0 0 0"  # none

# The white space of C++'s streams.
_SPACE = " \t\r\n\v\f"
_WORD = re.compile(rf"[^{_SPACE}]+")

# The largest number of digits of a plausible count.
_LONGEST_COUNT = 9

# By name: how many numbers a shape has, and how to make it; a mesh has a reader of its own.
_SIZED: dict[str, tuple[int, Callable[..., Shape]]] = {
    "sphere": (1, Sphere),
    "box": (3, lambda *size: Box(size)),
    "cylinder": (2, Cylinder),
    "cone": (2, Cone),
}
_MESH = "mesh"


def read_scene_text(scene: SceneContents, content: bytes, meshes: MeshKind = "hull") -> None:
    """Reads the content of a `.scene` file into a scene, meshes taken as said.

    Raises:
        PlannercheckError: If the file is faulty; the message names the object and the line.
    """
    words = _Words(_text(content))
    scene.name = words.rest_of_line()
    has_poses = words.objects_have_poses()
    while (marker := words.word(f"{_OBJECT!r} (an object) or {_END!r} (the end)")) != _END:
        if marker != _OBJECT:
            raise words.error(
                f"{_OBJECT!r} (an object) or {_END!r} (the end) must stand here, not {shortened(marker)!r}; "
                "planning scenes in YAML have the suffix .yaml"
            )
        with words.at_this_line():
            name = words.rest_of_line()
            if not name or name in scene.object_names:
                raise PlannercheckError(
                    f"object {shortened(name)!r} exists already" if name else "an object needs a name"
                )
        with error_context(f"object {shortened(name)!r}"):
            scene.put(_object(words, name, has_poses, meshes))
    words.end()


def _text(content: bytes) -> str:
    try:
        return content.decode()
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise PlannercheckError(f"line {line}: this is no text in UTF-8") from None


def _object(words: _Words, name: str, has_poses: bool, meshes: MeshKind) -> SceneObject:
    pose = _pose(words, "the object's") if has_poses else np.eye(4)
    count = words.count("the number of shapes")
    if not count:
        raise words.error("an object needs at least one shape")
    item = scene_object(name, [_part(words, meshes) for _ in range(count)], pose)
    return dataclasses.replace(item, subframes=_subframes(words)) if has_poses else item


def _subframes(words: _Words) -> dict[str, Matrix]:
    subframes: dict[str, Matrix] = {}
    for _ in range(words.count("the number of subframes")):
        name = words.word("a subframe's name")
        if name in subframes:
            raise words.error(f"subframe {shortened(name)!r} exists already")
        subframes[name] = _pose(words, "a subframe's")
    return subframes


def _part(words: _Words, meshes: MeshKind) -> Part:
    kind = words.word("a shape")
    if kind not in (*_SIZED, _MESH):
        with words.at_this_line():
            raise unknown_name("shape", kind, (*_SIZED, _MESH))
    shape = _mesh(words, meshes) if kind == _MESH else _sized(words, kind)
    pose = _pose(words, "the shape's")
    words.numbers(4, "the shape's colour")
    return Part(shape, pose)


def _sized(words: _Words, kind: str) -> Shape:
    count, make = _SIZED[kind]
    sizes = words.numbers(count, f"the size of a {kind}")
    with words.at_this_line():
        return make(*sizes)


def _mesh(words: _Words, meshes: MeshKind) -> Shape:
    """The shape of a mesh: numbers of vertices and of triangles, then the vertices, then three indices a triangle."""
    vertices, triangles = words.count("the number of vertices"), words.count("the number of triangles")
    points = words.numbers(3 * vertices, "a vertex")
    corners = [words.count("a triangle's corner") for _ in range(3 * triangles)]
    with words.at_this_line():
        indices = np.reshape(np.array(corners, dtype=np.int64), (-1, 3))
        return shape_of_triangles(np.reshape(np.array(points), (-1, 3)), indices, meshes)


def _pose(words: _Words, whose: str) -> Matrix:
    position = words.numbers(3, f"{whose} position")
    quaternion = words.numbers(4, f"{whose} quaternion x y z w")
    with words.at_this_line():
        return pose_of(position, rotation_of_quaternion(quaternion))


class _Words:
    """Reads a text word by word; errors name the line."""

    def __init__(self, text: str) -> None:
        self._lines = text.split("\n")
        self._row = self._column = 0

    def word(self, what: str) -> str:
        """The next word."""
        word = self._next()
        if word is None:
            raise PlannercheckError(f"line {len(self._lines)}: the file ends where {what} must stand")
        return word

    def end(self) -> None:
        """Raises if words are left."""
        word = self._next()
        if word is not None:
            raise self.error(
                f"{shortened(word)!r} stands after {_END!r} (the end), where MoveIt reads nothing: leave it out, or "
                "write the objects of several files before one end"
            )

    def _next(self) -> str | None:
        while self._row < len(self._lines):
            found = _WORD.search(self._lines[self._row], self._column)
            if found:
                self._column = found.end()
                return found[0]
            self._row, self._column = self._row + 1, 0
        return None

    def rest_of_line(self) -> str:
        """The rest of the line."""
        rest = self._lines[self._row][self._column :].strip(_SPACE)
        self._row, self._column = self._row + 1, 0
        return rest

    def numbers(self, count: int, what: str) -> list[float]:
        """The next words, as finite numbers."""
        return [self._number(self.word(what), what) for _ in range(count)]

    def _number(self, word: str, what: str) -> float:
        try:
            number = float(word) if word.isascii() and "_" not in word else math.nan
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise self.error(f"{what} must be a finite number, not {shortened(word)!r}")
        return number

    def count(self, what: str) -> int:
        """The next word, as a whole number."""
        word = self.word(what)
        if not (word.isascii() and word.isdecimal() and len(word) <= _LONGEST_COUNT):
            raise self.error(f"{what} must be a whole number, not {shortened(word)!r}")
        return int(word)

    def objects_have_poses(self) -> bool:
        """Whether objects have poses and subframes: as in MoveIt, the line after the first object's name decides."""
        for line, after in zip(self._lines[self._row :], self._lines[self._row + 1 :], strict=False):
            if line.startswith(_OBJECT):
                return len(_WORD.findall(after)) > 1
        return False

    def at_this_line(self) -> AbstractContextManager[None]:
        """A context that puts the number of the line before errors."""
        return error_context(f"line {self._row + 1}")

    def error(self, message: str) -> PlannercheckError:
        """The error for the last word."""
        return PlannercheckError(f"line {self._row + 1}: {message}")


def scene_text(scene: SceneContents) -> str:
    """The obstacles as a `.scene` file, hulls and solids as meshes; a warning names what the format can't hold.

    Reading the file gives the same sizes and positions; rotations, written as quaternions, are rounded.

    Raises:
        PlannercheckError: For a capsule, a flat hull, a cloud or a map, which MoveIt does not have, and for names that
            can't be read back.
    """
    lines = [_single_line(scene.name, "the scene's name")]
    for item in scene.objects:
        if item.name == OCTOMAP:  # MoveIt leaves it out, too
            continue
        with error_context(f"object {item.name!r}"):
            lines += _object_lines(item)
    _warn_of_the_rest(scene)
    return "\n".join([*lines, _END, ""])


def _object_lines(item: SceneObject) -> list[str]:
    if item.pose_frame is not None:
        raise unplaced(item)
    if item.moving is not None:
        raise PlannercheckError(f"it moves, which a {SUFFIX} file can't hold: save the scene as .yaml")
    lines = [f"{_OBJECT} {_single_line(item.name, 'its name')}", *_pose_lines(item.pose), str(len(item.parts))]
    for part in item.parts:
        lines += [*_shape_lines(part.shape), *_pose_lines(checked_pose(part.pose, item.name)), _COLOUR]
    lines.append(str(len(item.subframes)))
    for name, pose in item.subframes.items():
        if _WORD.fullmatch(name) is None:
            raise PlannercheckError(f"the name of a subframe must be one word in a {SUFFIX} file, not {name!r}")
        lines += [name, *_pose_lines(pose)]
    return lines


def _shape_lines(shape: Shape) -> list[str]:
    match shape:
        case Sphere():
            return ["sphere", _row([shape.radius])]
        case Box():
            return ["box", _row(shape.size)]
        case Cylinder() | Cone():
            return [type(shape).__name__.lower(), _row([shape.radius, shape.length])]
        case Hull():
            hull = Polytope(shape.vertices)
            return _mesh_lines(hull.vertices, hull.faces)
        case Solid():
            return _mesh_lines(*shape.used)
    kind = type(shape).__name__ if isinstance(shape, PartSet) else type(shape).__name__.lower()
    raise PlannercheckError(f"MoveIt has no {kind}: a {SUFFIX} file can't hold it")


def _mesh_lines(points: Floats, triangles: Ints) -> list[str]:
    if not len(triangles):
        raise PlannercheckError(f"a hull without volume has no triangles: a {SUFFIX} file can't hold it")
    sizes = f"{len(points)} {len(triangles)}"
    return [_MESH, sizes, *map(_row, points), *(" ".join(map(str, corners)) for corners in triangles.tolist())]


def _pose_lines(pose: Matrix) -> list[str]:
    return [_row(pose[:3, 3]), _row(quaternion_of_rotation(pose[:3, :3]))]


def _row(numbers: object) -> str:
    """Numbers as text; reading it gives the same doubles."""
    return " ".join(repr(float(number)) for number in np.asarray(numbers, dtype=np.float64))


def _single_line(name: str, what: str) -> str:
    if "\n" in name or name != name.strip(_SPACE):
        raise PlannercheckError(f"{what} must be one line without spaces around it in a {SUFFIX} file, not {name!r}")
    return name


def _warn_of_the_rest(scene: SceneContents) -> None:
    held = {
        "octomap": OCTOMAP in scene.object_names,
        "attached objects": scene.attached,
        "allowed collisions": scene.allowed.pairs or scene.allowed.defaults or scene.allowed.geometries,
        "states": scene.states,
    }
    missing = [what for what, given in held.items() if given]
    if missing:
        warnings.warn(
            f"a {SUFFIX} file holds obstacles alone: the scene's {', '.join(missing)} are not in it", stacklevel=4
        )
