"""Reads and writes scene files of our own format, which scene.py documents.

In: a file and an empty scene. Out: the filled scene; and the other way round. YAML with the keys of MoveIt's messages
is read by moveit_scene.py, a file that ends in `.scene` by moveit_text.py.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from plannercheck.bodies.ellipsoids import ELLIPSOID_EXCESS, Ellipsoid
from plannercheck.bodies.half_spaces import HalfSpace
from plannercheck.bodies.objects import Part, SceneObject, unplaced
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.shapes import Box, Capsule, Cone, Cylinder, Hull, Shape, Sphere, checked_pose
from plannercheck.bodies.solids import Solid
from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.checked_yaml import (
    Node,
    check_keys,
    error_context,
    mapping,
    number,
    numbers,
    parse_yaml,
    read_bytes,
    required,
    sequence,
    text,
)
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.package_data import is_file, is_folder
from plannercheck.common.transforms import pose_of, quaternion_of_rotation, rotation_of_quaternion, rotation_of_rpy
from plannercheck.scenes import moveit_scene as moveit
from plannercheck.scenes import moveit_text
from plannercheck.scenes.contents import SceneContents
from plannercheck.scenes.declared_states import DeclaredStates
from plannercheck.scenes.files_beside import FilesBeside
from plannercheck.scenes.moveit_messages import single_document
from plannercheck.scenes.scene_meshes import Source, read_hull, read_mesh, read_solid
from plannercheck.scenes.scene_paths import FindFile, MeshKind
from plannercheck.scenes.sensed_shapes import SENSED_KEYS, SensedSource, read_sensed, sensed_kind, sensed_node

# Keys of pairs, and whether the pairs may touch. Pairs of links have keys of their own, so that a misspelt object does
# not pass for a link.
_LINK_PAIRS = ("allowed_links", "forbidden_links")
_PAIRS = {"allowed": True, "forbidden": False, "allowed_links": True, "forbidden_links": False}
_SCENE_KEYS = ("name", "objects", "attached", *_PAIRS, "allowed_by_default", "states")
_STATE_KEYS = ("start", "goal", "samples")
_POSE_KEYS = ("position", "quaternion", "rpy", "matrix")

# The keys of a shape's mapping, by the shape's key in a file; meshes, hulls and sensed shapes have their own readers.
_SIZED: dict[str, tuple[Callable[..., Shape], tuple[str, ...]]] = {
    "sphere": (Sphere, ("radius",)),
    "cylinder": (Cylinder, ("radius", "length")),
    "capsule": (Capsule, ("radius", "length")),
    "cone": (Cone, ("radius", "length")),
}
_SHAPE_KEYS = ("box", *_SIZED, "ellipsoid", "half_space", "mesh", "hull", "solid", *SENSED_KEYS)

# Shapes that may be the name of their file alone.
_NAMED = ("solid", *SENSED_KEYS)


def read_scene(scene: SceneContents, path: Path, package_dirs: Sequence[Path] = (), meshes: MeshKind = "hull") -> None:
    """Reads a scene of any format.

    Args:
        scene: The scene to fill; it is named after the file if that gives no name.
        path: The file.
        package_dirs: Folders in which `package://` meshes are searched, before the folders above the file.
        meshes: What meshes are taken as.
    """
    if not is_file(path):
        raise PlannercheckError(f"scene file {str(path)!r} {'is a folder' if is_folder(path) else 'does not exist'}")
    with error_context(f"scene file {str(path)!r}"):
        content = read_bytes(path)
        if path.suffix.lower() == moveit_text.SUFFIX:
            moveit_text.read_scene_text(scene, content, meshes)
        else:
            _read_yaml(scene, content, FindFile(path.parent, package_dirs, meshes))
    scene.name = scene.name or path.stem


def _read_yaml(scene: SceneContents, content: bytes, find_file: FindFile) -> None:
    document = parse_yaml(single_document(content))
    message = moveit.as_planning_scene(document)
    if message is None:
        _read(scene, document, find_file)
    else:
        moveit.read_planning_scene(scene, message, find_file.folder, find_file.package_dirs, find_file.meshes)


def _read(scene: SceneContents, document: Node, find_file: FindFile) -> None:
    if "urdf" in document:
        raise PlannercheckError("is a robot, not a scene")
    check_keys(document, _SCENE_KEYS)
    scene.name = text(document.get("name", ""), "name")
    for k, item in enumerate(sequence(required(document, "objects"), "'objects'")):
        _add_object(scene, mapping(item, f"object {k}"), k, find_file)
    for k, item in enumerate(sequence(document.get("attached"), "'attached'")):
        _attach_object(scene, mapping(item, f"attached object {k}"), k, find_file)
    _read_allowed(scene, document)
    for robot, item in mapping(document.get("states"), "'states'").items():
        with error_context(f"states of {robot!r}"):
            read_states(scene, robot, mapping(item, "they"), find_file.folder)


def _add_object(scene: SceneContents, node: Node, index: int, find_file: FindFile) -> None:
    with error_context(f"object {index}"):
        name = text(required(node, "name"), "name")
    with error_context(f"object {name!r}"):
        check_keys(node, ("name", "parts", *_SHAPE_KEYS, *_POSE_KEYS))
        parts, pose = _parts(node, find_file), _pose(node)
    scene.add(name, parts, pose)


def _attach_object(scene: SceneContents, node: Node, index: int, find_file: FindFile) -> None:
    with error_context(f"attached object {index}"):
        name = text(required(node, "name"), "name")
    with error_context(f"attached object {name!r}"):
        check_keys(node, ("name", "link", "touch_links", "parts", *_SHAPE_KEYS, *_POSE_KEYS))
        link = text(required(node, "link"), "link")
        touched = [text(item, "touch_links") for item in sequence(node.get("touch_links"), "'touch_links'")]
        parts, pose = _parts(node, find_file), _pose(node)
    scene.attach(name, link, pose, touched, parts)


def _parts(node: Node, find_file: FindFile) -> list[Part]:
    """The parts of an object, posed in its frame."""
    if "parts" not in node:
        return [_part(node, find_file, None)]
    _one_of(node, ("parts", *_SHAPE_KEYS))
    parts = []
    for k, item in enumerate(sequence(node["parts"], "'parts'")):
        with error_context(f"part {k}"):
            part = mapping(item, "it")
            check_keys(part, (*_SHAPE_KEYS, *_POSE_KEYS))
            parts.append(_part(part, find_file, _pose(part)))
    return parts


def _part(node: Node, find_file: FindFile, pose: NDArray[np.float64] | None) -> Part:
    """The shape that a mapping describes, posed in an object's frame."""
    kind = _one_of(node, _SHAPE_KEYS)
    with error_context(kind):
        is_name = kind in _NAMED and isinstance(node[kind], str)
        values = node[kind] if is_name else mapping(node[kind], "it")
        shape, source = _shape(kind, values, find_file)
    return Part(shape, pose, source)


def _one_of(node: Node, keys: Sequence[str]) -> str:
    """The one key of several that a mapping has."""
    given = [key for key in keys if key in node]
    if len(given) != 1:
        found = " and ".join(given) or "none"
        raise PlannercheckError(f"needs exactly one of the keys {', '.join(keys)}; given are {found}")
    return given[0]


def _shape(kind: str, values: Node, find_file: FindFile) -> tuple[Shape, Source | SensedSource | None]:
    """A shape from its key and values, and where it is from: a file, with the scale of a mesh or with further keys."""
    if kind == "mesh":
        return read_mesh(values, find_file)
    if kind == "solid":
        return read_solid(values, find_file)
    if kind in SENSED_KEYS:
        return read_sensed(kind, values, find_file)
    if kind == "hull":
        return read_hull(values, find_file), None
    if kind == "box":
        check_keys(values, ("size",))
        return Box(_three(values, "size")), None
    if kind == "ellipsoid":
        check_keys(values, ("radii", "excess"))
        return Ellipsoid(_three(values, "radii"), number(values.get("excess", ELLIPSOID_EXCESS), "excess")), None
    if kind == "half_space":
        check_keys(values, ("normal", "offset"))
        return HalfSpace(_three(values, "normal"), number(values.get("offset", 0.0), "offset")), None
    make, keys = _SIZED[kind]
    check_keys(values, keys)
    return make(*(number(required(values, key), key) for key in keys)), None


def _three(values: Node, key: str) -> tuple[float, float, float]:
    x, y, z = numbers(required(values, key), key, 3)
    return x, y, z


def _pose(node: Node) -> NDArray[np.float64]:
    """The pose (4, 4) that a mapping's pose keys give, by default the identity."""
    if "matrix" in node:
        if any(key in node for key in _POSE_KEYS[:-1]):
            raise PlannercheckError("'matrix' stands alone: leave out position, quaternion and rpy")
        return checked_pose([numbers(row, "matrix row", 4) for row in sequence(node["matrix"], "'matrix'")], "matrix")
    position = numbers(node["position"], "position", 3) if "position" in node else [0.0, 0.0, 0.0]
    if "quaternion" in node and "rpy" in node:
        raise PlannercheckError("'quaternion' and 'rpy' say the same: leave one out")
    if "quaternion" in node:
        return pose_of(position, rotation_of_quaternion(numbers(node["quaternion"], "quaternion", 4)))
    if "rpy" in node:
        return pose_of(position, rotation_of_rpy(numbers(node["rpy"], "rpy", 3)))
    return pose_of(position)


def _read_allowed(scene: SceneContents, document: Node) -> None:
    """Reads which pairs may touch."""
    known = [*scene.object_names, *(item.name for item in scene.attached)]
    for key, allowed in _PAIRS.items():
        for pair in sequence(document.get(key), repr(key)):
            names = [text(name, key) for name in sequence(pair, f"an entry of {key!r}")]
            if len(names) != 2:
                raise PlannercheckError(f"an entry of {key!r} must be two names, not {names}")
            if key not in _LINK_PAIRS and not set(names) & set(known):
                raise PlannercheckError(
                    f"{key!r} names {' and '.join(names)}, none of which is an object: objects are "
                    f"{', '.join(known) or 'none'}"
                )
            scene.allow(names[0], names[1], allowed)
    for name, allowed in mapping(document.get("allowed_by_default"), "'allowed_by_default'").items():
        if not isinstance(allowed, bool):
            raise PlannercheckError(f"'allowed_by_default' of {name!r} must be true or false, not {allowed!r}")
        scene.allowed.defaults[name] = allowed


def read_states(scene: DeclaredStates, robot: str, node: Node, folder: Path) -> None:
    """Declares the states of a robot that a file's mapping gives."""
    check_keys(node, _STATE_KEYS)
    start, goal = (numbers(node[key], key) if key in node else None for key in ("start", "goal"))
    samples = folder / text(node["samples"], "samples") if "samples" in node else None
    scene.set_states(robot, start, goal, samples)


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
    return str(yaml.dump(document, sort_keys=False, default_flow_style=None, width=110, allow_unicode=True))


def _object_node(item: SceneObject, beside: FilesBeside) -> Node:
    if item.pose_frame is not None:
        raise unplaced(item)
    if len(item.parts) == 1 and item.parts[0].pose is None:
        return {"name": item.name, **_shape_node(item.parts[0], item.name, beside), **_pose_node(item.pose)}
    nodes = [
        _shape_node(part, item.name, beside) | _pose_node(checked_pose(part.pose, item.name)) for part in item.parts
    ]
    return {"name": item.name, **_pose_node(item.pose), "parts": nodes}


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
        return {"solid": {"vertices": shape.vertices.tolist(), "triangles": shape.triangles.tolist()}}
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
    return {kind: {key: getattr(shape, key) for key in _SIZED[kind][1]}}


def _file_node(shape: Shape, file: Path, more: float | Sequence[float] | Mapping[str, Any], folder: Path) -> Node:
    """The mapping of a shape from a file: of a mesh with its scale, of a sensed shape with its other keys."""
    name = _relative(file, folder)
    if isinstance(shape, PartSet):
        assert isinstance(more, Mapping)
        return {sensed_kind(shape): {"file": name, **more}}
    kind = "solid" if isinstance(shape, Solid) else "mesh"
    return {kind: {"file": name, "scale": np.asarray(more).tolist()}}


def _pose_node(pose: NDArray[np.float64]) -> Node:
    """Position and quaternion where they give the same doubles, else the matrix itself."""
    position = pose[:3, 3].tolist()
    if np.array_equal(pose[:3, :3], np.eye(3)):
        return {"position": position} if any(position) else {}
    quaternion = quaternion_of_rotation(pose[:3, :3])
    if np.array_equal(rotation_of_quaternion(quaternion), pose[:3, :3]):
        return {"position": position, "quaternion": quaternion}
    return {"matrix": pose.tolist()}


def _allowed_nodes(scene: SceneContents) -> Node:
    """Allowed collisions; forbidden pairs matter only where a default would allow them."""
    known = {*scene.object_names, *(item.name for item in scene.attached)}
    said = {
        key: [
            sorted(pair) * (3 - len(pair))
            for pair, verdict in scene.allowed.pairs.items()
            if verdict is allowed and (key in _LINK_PAIRS) == pair.isdisjoint(known)
        ]
        for key, allowed in _PAIRS.items()
    }
    nodes: Node = {key: said[key] for key in said if said[key] and _PAIRS[key]}
    if scene.allowed.defaults:
        nodes |= {"allowed_by_default": dict(scene.allowed.defaults)}
        nodes |= {key: said[key] for key in said if said[key] and not _PAIRS[key]}
    return nodes


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
