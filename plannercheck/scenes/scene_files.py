"""Reads scene files of our own format, which scene.py documents; written_scenes.py writes them.

In: a file and an empty scene. Out: the filled scene. YAML with the keys of MoveIt's messages is read by
moveit_scene.py, a file that ends in `.scene` by moveit_text.py, an MJCF file by mjcf_scene.py.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.ellipsoids import ELLIPSOID_EXCESS, Ellipsoid
from plannercheck.bodies.half_spaces import HalfSpace
from plannercheck.bodies.mesh_files import MESH_SUFFIXES, MeshUnits
from plannercheck.bodies.objects import Part
from plannercheck.bodies.octomap_files import OCTREE_SUFFIXES
from plannercheck.bodies.shapes import Box, Capsule, Cone, Cylinder, Shape, Sphere
from plannercheck.bodies.written_poses import POSE_KEYS, pose_of_node
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
from plannercheck.common.file_kinds import is_mjcf
from plannercheck.common.package_data import is_file, why_no_file
from plannercheck.scenes import moveit_scene as moveit
from plannercheck.scenes import moveit_text
from plannercheck.scenes.contents import SceneContents
from plannercheck.scenes.declared_states import DeclaredStates
from plannercheck.scenes.mjcf_scene import read_mjcf_scene
from plannercheck.scenes.moving_nodes import MOVING, moving_of_node
from plannercheck.scenes.scene_meshes import read_hull, read_mesh_node, read_solid_node
from plannercheck.scenes.scene_paths import FindFile, MeshKind
from plannercheck.scenes.sensed_shapes import SENSED_KEYS, SensedSource, read_sensed

# Keys of pairs, and whether the pairs may touch. Pairs of links have keys of their own, so that a misspelt object does
# not pass for a link.
LINK_PAIRS = ("allowed_links", "forbidden_links")
PAIRS = {"allowed": True, "forbidden": False, "allowed_links": True, "forbidden_links": False}
_SCENE_KEYS = ("name", "objects", "attached", *PAIRS, "allowed_geometries", "allowed_by_default", "states")
_STATE_KEYS = ("start", "goal", "samples")

# The keys of a shape's mapping, by the shape's key in a file; meshes, hulls and sensed shapes have their own readers.
SIZED: dict[str, tuple[Callable[..., Shape], tuple[str, ...]]] = {
    "sphere": (Sphere, ("radius",)),
    "cylinder": (Cylinder, ("radius", "length")),
    "capsule": (Capsule, ("radius", "length")),
    "cone": (Cone, ("radius", "length")),
}
_SHAPE_KEYS = ("box", *SIZED, "ellipsoid", "half_space", "mesh", "hull", "solid", *SENSED_KEYS)

# Shapes that may be the name of their file alone.
_NAMED = ("solid", *SENSED_KEYS)

# Suffixes of files that are the geometry of one object, and how a scene names such a file. Arrays may be anything.
_GEOMETRY = {"mesh": MESH_SUFFIXES, "cloud": (".ply", ".pcd", ".xyz", ".pts"), "octree": OCTREE_SUFFIXES}
_AS_OBJECT = {
    "mesh": "objects: [{{name: {name}, mesh: {{file: {file}}}}}] (its hull; solid: in place of mesh: as it is)",
    "cloud": "objects: [{{name: {name}, cloud: {{file: {file}, radius: 0.01}}}}] (radius of the points, m)",
    "octree": "objects: [{{name: {name}, octree: {{file: {file}}}}}]",
}


def read_scene(
    scene: SceneContents,
    path: Path,
    package_dirs: Sequence[Path] = (),
    meshes: MeshKind = "hull",
    mesh_units: MeshUnits | None = None,
) -> None:
    """Reads a scene of any format.

    Args:
        scene: The scene to fill; it is named after the file if that gives no name.
        path: The file.
        package_dirs: Folders in which `package://` meshes are searched, before the folders above the file.
        meshes: What meshes are taken as.
        mesh_units: How mesh files are read, as for `Scene.load`.
    """
    if not is_file(path):
        raise PlannercheckError(f"scene file {str(path)!r} {why_no_file(path)}")
    with error_context(f"scene file {str(path)!r}"):
        _refuse_geometry(path)
        content = read_bytes(path)
        if path.suffix.lower() == moveit_text.SUFFIX:
            moveit_text.read_scene_text(scene, content, meshes)
        elif is_mjcf(content):
            read_mjcf_scene(scene, path, meshes)
        else:
            _read_yaml(scene, content, FindFile(path.parent, package_dirs, meshes, mesh_units))
    scene.name = scene.name or path.stem


def _refuse_geometry(path: Path) -> None:
    """Raises for the file of a mesh or a sensed shape, which a scene file names."""
    suffix = path.suffix.lower()
    keys = [key for key, suffixes in _GEOMETRY.items() if suffix in suffixes]
    if keys:
        named = ", or ".join(_AS_OBJECT[key].format(name=path.stem, file=path.name) for key in keys)
        raise PlannercheckError(f"is geometry, not a scene: write a YAML file beside it with {named}")


def _read_yaml(scene: SceneContents, content: bytes, find_file: FindFile) -> None:
    document = parse_yaml(content)
    message = moveit.as_planning_scene(document)
    if message is None:
        _read(scene, document, find_file)
    else:
        moveit.read_planning_scene(scene, message, find_file)


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
        check_keys(node, ("name", "parts", *_SHAPE_KEYS, *POSE_KEYS, MOVING))
        parts, place = _parts(node, find_file), moving_of_node(node) if MOVING in node else pose_of_node(node)
    scene.add(name, parts, place)


def _attach_object(scene: SceneContents, node: Node, index: int, find_file: FindFile) -> None:
    with error_context(f"attached object {index}"):
        name = text(required(node, "name"), "name")
    with error_context(f"attached object {name!r}"):
        check_keys(node, ("name", "link", "touch_links", "parts", *_SHAPE_KEYS, *POSE_KEYS))
        link = text(required(node, "link"), "link")
        touched = [text(item, "touch_links") for item in sequence(node.get("touch_links"), "'touch_links'")]
        parts, pose = _parts(node, find_file), pose_of_node(node)
    scene.attach(name, link, pose, touched, parts)


def _parts(node: Node, find_file: FindFile) -> list[Part]:
    """The parts of an object, posed in its frame."""
    if "parts" not in node:
        return _parts_of_shape(node, find_file, None)
    _one_of(node, ("parts", *_SHAPE_KEYS))
    parts = []
    for k, item in enumerate(sequence(node["parts"], "'parts'")):
        with error_context(f"part {k}"):
            part = mapping(item, "it")
            check_keys(part, (*_SHAPE_KEYS, *POSE_KEYS))
            parts += _parts_of_shape(part, find_file, pose_of_node(part))
    return parts


def _parts_of_shape(node: Node, find_file: FindFile, pose: NDArray[np.float64] | None) -> list[Part]:
    """The shape that a mapping describes, posed in an object's frame; a mesh file may hold several."""
    kind = _one_of(node, _SHAPE_KEYS)
    with error_context(kind):
        is_name = kind in _NAMED and isinstance(node[kind], str)
        values = node[kind] if is_name else mapping(node[kind], "it")
        if kind == "mesh":
            parts = read_mesh_node(values, find_file)
        elif kind == "solid":
            parts = read_solid_node(values, find_file)
        else:
            parts = [Part(*_shape(kind, values, find_file))]
    return parts if pose is None else [replace(part, pose=pose) for part in parts]


def _one_of(node: Node, keys: Sequence[str]) -> str:
    """The one key of several that a mapping has."""
    given = [key for key in keys if key in node]
    if len(given) != 1:
        found = " and ".join(given) or "none"
        raise PlannercheckError(f"needs exactly one of the keys {', '.join(keys)}; given are {found}")
    return given[0]


def _shape(kind: str, values: Node, find_file: FindFile) -> tuple[Shape, None, SensedSource | None]:
    """A shape from its key and values, without a pose, and the file that it is from, with further keys."""
    if kind in SENSED_KEYS:
        shape, source = read_sensed(kind, values, find_file)
        return shape, None, source
    if kind == "hull":
        return read_hull(values, find_file), None, None
    if kind == "box":
        check_keys(values, ("size",))
        return Box(_three(values, "size")), None, None
    if kind == "ellipsoid":
        check_keys(values, ("radii", "excess"))
        return Ellipsoid(_three(values, "radii"), number(values.get("excess", ELLIPSOID_EXCESS), "excess")), None, None
    if kind == "half_space":
        check_keys(values, ("normal", "offset"))
        return HalfSpace(_three(values, "normal"), number(values.get("offset", 0.0), "offset")), None, None
    make, keys = SIZED[kind]
    check_keys(values, keys)
    return make(*(number(required(values, key), key) for key in keys)), None, None


def _three(values: Node, key: str) -> tuple[float, float, float]:
    x, y, z = numbers(required(values, key), key, 3)
    return x, y, z


def _read_allowed(scene: SceneContents, document: Node) -> None:
    """Reads which pairs may touch."""
    known = [*scene.object_names, *(item.name for item in scene.attached)]
    for key, allowed in PAIRS.items():
        for pair in sequence(document.get(key), repr(key)):
            names = [text(name, key) for name in sequence(pair, f"an entry of {key!r}")]
            if len(names) != 2:
                raise PlannercheckError(f"an entry of {key!r} must be two names, not {names}")
            if key not in LINK_PAIRS and not set(names) & set(known):
                raise PlannercheckError(
                    f"{key!r} names {' and '.join(names)}, none of which is an object: objects are "
                    f"{', '.join(known) or 'none'}"
                )
            if scene.allowed.pairs.get(frozenset(names), allowed) != allowed:
                raise PlannercheckError(
                    f"{key!r} names {' and '.join(names)}, of whom another entry says the opposite: keep one of the two"
                )
            scene.allow(names[0], names[1], allowed)
    for triple in sequence(document.get("allowed_geometries"), "'allowed_geometries'"):
        names = [text(name, "allowed_geometries") for name in sequence(triple, "an entry of 'allowed_geometries'")]
        if len(names) != 3 or names[2] not in known:
            raise PlannercheckError(f"'allowed_geometries' needs a link, a geometry and an object, not {names}")
        scene.allowed.geometries.add((names[0], names[1], names[2]))
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
