"""glTF 2.0 files, as JSON with buffers beside it and as GLB: the meshes of their scene.

In: a path and its content. Out: one object for each node with a mesh, posed by the nodes above it, with y up.
Compressed meshes, skeletons, instancing by extensions and morphed meshes are refused.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plannercheck.bodies.gltf_buffers import Buffers
from plannercheck.bodies.gltf_json import Table, root_of
from plannercheck.bodies.mesh_objects import RawObject, check_indices, fan_triangles, strip_triangles
from plannercheck.bodies.mesh_poses import composed, facing_as_before, transformed
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.errors import PlannercheckError, shortened

# What a viewer must understand, and what only concerns how surfaces look; the first one is read.
_UNDERSTOOD = ("KHR_mesh_quantization",)
_LOOKS = (
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_lights_",
    "KHR_xmp",
    "ADOBE_materials_",
)

_POINTS, _LINES, _TRIANGLES, _STRIP, _FAN = 0, (1, 2, 3), 4, 5, 6

# How far the squared length of a rotation may be off, which an exporter may have rounded to two digits.
_UNIT = 0.02

# From glTF's axes (y up, z forward; specification 2.0, section 3.4) to z up.
Y_UP = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])


@dataclass(frozen=True, eq=False)
class GltfScene:
    """A scene's objects, in m with y up, and how another reading of the root node differs.

    Attributes:
        objects: With all transforms.
        without_root: The same with the identity in place of the transform of the only root node.
        root: The transform (4, 4) of the only root node; the identity if there are several.
    """

    objects: list[RawObject]
    without_root: list[RawObject]
    root: Floats


def scene_of_gltf(path: Path, content: bytes) -> GltfScene:
    """The meshes of a file's scene.

    Raises:
        PlannercheckError: If the file is not whole, or has what is not read.
    """
    text, binary = _chunks(content) if content.startswith(b"glTF") else (content, None)
    root = root_of(text)
    _check_version(root)
    buffers = Buffers(root, path.parent, binary)
    roots = _roots(root)
    only = roots[0] if len(roots) == 1 else None
    pose = _pose(only) if only is not None else np.eye(4)
    meshes: dict[int, tuple[Floats, Ints64]] = {}
    objects = _walk(roots, None, buffers, meshes)
    return GltfScene(objects, _walk(roots, only, buffers, meshes), pose)


def _chunks(content: bytes) -> tuple[bytes, bytes | None]:
    """The JSON of a GLB file, and its binary chunk."""
    version, length = (int.from_bytes(content[k : k + 4], "little") for k in (4, 8))
    if len(content) < 20 or version != 2:
        raise PlannercheckError(f"must be a GLB file of version 2, not {version}")
    if length != len(content):
        raise PlannercheckError(f"says that it has {length} bytes, but has {len(content)}")
    chunks, at = [], 12
    while at < length:
        size, kind = int.from_bytes(content[at : at + 4], "little"), content[at + 4 : at + 8]
        if at + 8 + size > length:
            raise PlannercheckError("is cut short: a chunk ends beyond the file")
        chunks.append((kind, content[at + 8 : at + 8 + size]))
        at += 8 + size
    if chunks[0][0] != b"JSON":
        raise PlannercheckError("must begin with a chunk JSON")
    return chunks[0][1], next((data for kind, data in chunks[1:2] if kind == b"BIN\0"), None)


def _check_version(root: Table) -> None:
    asset = root.table("asset")
    version, least = asset.text("version"), asset.text("minVersion", "2.0")
    if version.partition(".")[0] != "2" or least != "2.0":
        raise PlannercheckError(f"must be of glTF 2.0, not {shortened(version if least == '2.0' else least)!r}")
    for name in root.texts("extensionsRequired"):
        if name not in _UNDERSTOOD and not name.startswith(_LOOKS):
            raise PlannercheckError(f"needs the extension {shortened(name)!r}, which is not read: export without it")


def _roots(root: Table) -> list[Table]:
    scenes = root.tables("scenes")
    if not scenes or ("scene" not in root.items and len(scenes) > 1):
        raise PlannercheckError(f"must say which of its {len(scenes)} scenes is meant ('scene')")
    scene = root.pick("scenes", root.integer("scene", 0))
    return [root.pick("nodes", index) for index in scene.integers("nodes")]


def _walk(
    roots: list[Table], without: Table | None, buffers: Buffers, meshes: dict[int, tuple[Floats, Ints64]]
) -> list[RawObject]:
    """The objects below some nodes; `without` is the node whose transform is left out."""
    found, seen = [], set()
    stack = [(node, np.eye(4)) for node in reversed(roots)]
    while stack:
        node, outer = stack.pop()
        if node.name in seen:
            raise PlannercheckError(f"{node.name} has two parents, or is below itself")
        seen.add(node.name)
        pose = outer if without is not None and node.name == without.name else composed(outer, _pose(node))
        if "mesh" in node.items:
            found += _object(node, pose, buffers, meshes)
        stack += [(node.root().pick("nodes", k), pose) for k in reversed(node.integers("children"))]
    return found


def _pose(node: Table) -> Floats:
    """A node's transform (4, 4)."""
    if "matrix" in node.items:
        pose = node.floats("matrix", 16).reshape(4, 4).T
        if pose[3].tolist() != [0, 0, 0, 1] or any(key in node.items for key in ("translation", "rotation", "scale")):
            raise PlannercheckError(f"{node.name}: its matrix must end in 0 0 0 1, and stand alone")
        return pose
    pose = np.eye(4)
    x, y, z, w = rotation = node.floats("rotation", 4, [0.0, 0.0, 0.0, 1.0])
    square = float(rotation @ rotation)
    if not abs(square - 1) < _UNIT:
        raise PlannercheckError(f"{node.name}: its rotation must be a quaternion of length 1, not {square**0.5:.6g}")
    turn = [
        [x * x + w * w - y * y - z * z, 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), y * y + w * w - x * x - z * z, 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), z * z + w * w - x * x - y * y],
    ]
    pose[:3, :3] = np.array(turn) / square * node.floats("scale", 3, [1.0, 1.0, 1.0])
    pose[:3, 3] = node.floats("translation", 3, [0.0, 0.0, 0.0])
    return pose


def _object(node: Table, pose: Floats, buffers: Buffers, meshes: dict[int, tuple[Floats, Ints64]]) -> list[RawObject]:
    index = node.integer("mesh")
    mesh = node.root().pick("meshes", index)
    if "skin" in node.items:
        raise PlannercheckError(f"{node.name} has a skeleton (skin), which is not read")
    if "EXT_mesh_gpu_instancing" in node.table("extensions", {}).items:
        raise PlannercheckError(f"{node.name} has the extension 'EXT_mesh_gpu_instancing', which is not read")
    if any(weights for each in (node, mesh) for weights in each.floats("weights", None, [])):
        raise PlannercheckError(f"{node.name} has a morphed mesh (weights), which is not read")
    if index not in meshes:
        meshes[index] = _mesh(mesh, buffers)
    points, triangles = meshes[index]
    name = node.text("name", "") or mesh.text("name", "")
    return [RawObject.of(name, transformed(pose, points), facing_as_before(pose, triangles))] if len(triangles) else []


def _mesh(mesh: Table, buffers: Buffers) -> tuple[Floats, Ints64]:
    """The points and triangles of a mesh's surfaces."""
    points, triangles, count = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)], 0
    for primitive in mesh.tables("primitives"):
        mode = primitive.integer("mode", _TRIANGLES)
        if mode == _POINTS or mode in _LINES:
            continue
        if mode not in (_TRIANGLES, _STRIP, _FAN):
            raise PlannercheckError(f"{primitive.name} has mode {mode}, which glTF does not have")
        attributes = primitive.table("attributes")
        if "POSITION" not in attributes.items:
            raise PlannercheckError(f"{primitive.name} has no POSITION")
        points.append(buffers.places(attributes.integer("POSITION")))
        size = len(points[-1])
        if "indices" in primitive.items:
            indices = buffers.indices(primitive.integer("indices"))
            check_indices(indices, size, primitive.name)
        else:
            indices = np.arange(size)
        if len(indices) < 3 or (mode == _TRIANGLES and len(indices) % 3):
            raise PlannercheckError(f"{primitive.name} has {len(indices)} corners, which make no whole triangles")
        cut = {_STRIP: strip_triangles, _FAN: fan_triangles}.get(mode, _as_they_are)
        triangles.append(cut(indices) + count)
        count += size
    return np.concatenate(points), np.concatenate(triangles)


def _as_they_are(indices: Ints64) -> Ints64:
    return indices.reshape(-1, 3)
