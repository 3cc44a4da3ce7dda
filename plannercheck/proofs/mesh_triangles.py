"""The verifier's own small reader of meshes: STL, OBJ, and Collada whose objects stand where their numbers say.

In: a file. Out: the corners of its triangles in doubles, in the file's numbers. It shares no function with
`plannercheck.bodies`, and reads only the elements that robots' meshes have: anything else is a `NotReadError`, which
says why.
"""

from __future__ import annotations

import struct
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from plannercheck.common.array_types import Floats

# Bytes of a binary STL before its triangles, and of each of these.
_STL_HEAD, _STL_TRIANGLE = 84, 50


class NotReadError(ValueError):
    """The verifier does not read this file; the message says why."""


def mesh_triangles(path: Path) -> Floats:
    """The triangles (n, 3, 3) of a mesh file, whose suffix tells the format.

    Raises:
        NotReadError: If it is of another format, or holds what this reader does not know.
    """
    suffix = path.suffix.lower()
    if suffix not in _READERS:
        raise NotReadError(f"the verifier reads no {suffix or 'files without a suffix'}")
    try:
        found = _READERS[suffix](path.read_bytes())
    except (OSError, ValueError, IndexError, KeyError, struct.error, ElementTree.ParseError) as error:
        raise NotReadError(str(error) or type(error).__name__) from None
    if not len(found) or not np.isfinite(found).all():
        raise NotReadError("it has no triangles, or numbers that are not finite")
    return found


def _stl(content: bytes) -> Floats:
    if len(content) >= _STL_HEAD:
        (count,) = struct.unpack_from("<I", content, _STL_HEAD - 4)
        if len(content) == _STL_HEAD + _STL_TRIANGLE * count:
            rows = np.frombuffer(content, dtype=np.uint8, offset=_STL_HEAD).reshape(count, _STL_TRIANGLE)
            corners = np.ascontiguousarray(rows[:, 12:48]).view("<f4").astype(np.float64)
            return corners.reshape(count, 3, 3)
    words = content.decode("ascii").split()
    if not words or words[0] != "solid":
        raise NotReadError("it is neither a binary STL of as many triangles as it says, nor one in words")
    at = [k for k, word in enumerate(words) if word == "vertex"]
    if len(at) % 3 or len(at) != 3 * words.count("outer") or words.count("facet") != len(at) // 3:
        raise NotReadError("its facets have other corners than three")
    return np.array([[float(word) for word in words[k + 1 : k + 4]] for k in at]).reshape(-1, 3, 3)


def _obj(content: bytes) -> Floats:
    text = content.decode("utf-8")
    if "\\\n" in text:
        raise NotReadError("it has lines that go on in the next one")
    points, triangles = list[list[float]](), list[list[int]]()
    for line in text.splitlines():
        word, *rest = line.split("#")[0].split() or [""]
        if word == "v":
            points.append([float(x) for x in rest[:3]])
        elif word == "f":
            corners = [int(each.split("/")[0]) for each in rest]
            whole = [k - 1 if k > 0 else len(points) + k for k in corners]
            triangles += _fan(whole)
    return np.array(points)[np.array(triangles, dtype=np.int64).reshape(-1, 3)]


def _fan(corners: Sequence[int]) -> list[list[int]]:
    """The triangles of a polygon from its first corner."""
    if min(corners, default=-1) < 0 or len(corners) < 3:
        raise NotReadError("a face has fewer corners than three, or one that there is not")
    return [[corners[0], corners[k], corners[k + 1]] for k in range(1, len(corners) - 1)]


def _dae(content: bytes) -> Floats:
    root = ElementTree.fromstring(content)
    for element in root.iter():
        element.tag = str(element.tag).rpartition("}")[2]
    nodes = root.findall("library_visual_scenes//node")
    if root.find("library_nodes") is not None or root.find(".//instance_controller") is not None:
        raise NotReadError("it has nodes of a library, or skins")
    if any(not _stands(node) for node in nodes):
        raise NotReadError("its nodes are moved, turned or scaled")
    used = [each.get("url", "")[1:] for node in nodes for each in node.findall("instance_geometry")]
    meshes = {each.get("id", ""): each.find("mesh") for each in root.findall("library_geometries/geometry")}
    found = [triangles for name in used for triangles in _dae_mesh(meshes[name])]
    return np.concatenate(found) if found else np.zeros((0, 3, 3))


def _stands(node: Element) -> bool:
    """Whether a node leaves its objects where they are."""
    for part in node:
        values = np.array([float(word) for word in (part.text or "").split()]) if part.tag in _STILL else None
        if part.tag in ("lookat", "skew") or (values is not None and not _STILL[part.tag](values)):
            return False
    return True


_STILL: dict[str, Callable[[Floats], bool]] = {
    "matrix": lambda values: np.array_equal(values, np.eye(4).ravel()),
    "translate": lambda values: not values.any(),
    "rotate": lambda values: not values[3:].any(),
    "scale": lambda values: bool((values == 1).all()),
}


def _dae_mesh(mesh: Element | None) -> Iterator[Floats]:
    if mesh is None:
        raise NotReadError("a geometry is no mesh")
    for kind in ("lines", "linestrips", "trifans", "tristrips", "polygons"):
        if mesh.find(kind) is not None:
            raise NotReadError(f"it has <{kind}>")
    for part in (*mesh.findall("triangles"), *mesh.findall("polylist")):
        inputs = part.findall("input")
        width = 1 + max(int(each.get("offset", "0")) for each in inputs)
        place = next(each for each in inputs if each.get("semantic") == "VERTEX")
        indices = np.array((part.findtext("p") or "").split(), dtype=np.int64).reshape(-1, width)
        corners = indices[:, int(place.get("offset", "0"))].tolist()
        if part.tag == "polylist":
            counts = [int(word) for word in (part.findtext("vcount") or "").split()]
        else:
            counts = [3] * (len(corners) // 3)
        ends = np.cumsum([0, *counts]).tolist()
        if ends[-1] != len(corners):
            raise NotReadError("its faces have other numbers of corners than it says")
        faces = [face for k in range(len(counts)) for face in _fan(corners[ends[k] : ends[k + 1]])]
        yield _dae_points(mesh, place.get("source", ""))[np.array(faces, dtype=np.int64).reshape(-1, 3)]


_AXES = ["X", "Y", "Z"]


def _dae_points(mesh: Element, address: str) -> Floats:
    vertices = next(each for each in mesh.findall("vertices") if each.get("id") == address[1:])
    place = next(each for each in vertices.findall("input") if each.get("semantic") == "POSITION")
    source = next(each for each in mesh.findall("source") if each.get("id") == place.get("source", "")[1:])
    accessor = source.find("technique_common/accessor")
    names = [] if accessor is None else [each.get("name") for each in accessor.findall("param")]
    if accessor is None or (accessor.get("stride"), accessor.get("offset", "0")) != ("3", "0") or names != _AXES:
        raise NotReadError("its points are not three numbers each, X, Y and Z")
    return np.array((source.findtext("float_array") or "").split(), dtype=np.float64).reshape(-1, 3)


_READERS: dict[str, Callable[[bytes], Floats]] = {".stl": _stl, ".obj": _obj, ".dae": _dae}
