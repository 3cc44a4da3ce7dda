"""Shapes of a scene's meshes: hulls or solids.

In: a file's keys `mesh`, `hull` and `solid`, or triangles in MoveIt's messages. Out: `Hull` or `Solid`; of a mesh file
a part for each of its objects, named as in the file. If the meshes of a scene are read as solids, caps close open
meshes, or open meshes are their triangles alone; the key `open` decides for a `solid:` of a scene file. `Scene.load`
warns of open meshes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.given_shapes import hull_of_triangles
from plannercheck.bodies.hull_excess import hull_excess
from plannercheck.bodies.mesh_files import (
    MeshFile,
    MeshUnits,
    checked_units,
    named_file,
    read_mesh,
    warn_of_mesh,
)
from plannercheck.bodies.objects import Part
from plannercheck.bodies.shapes import Hull
from plannercheck.bodies.solids import OPEN_MESHES, OpenMesh, Solid
from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import BROKEN_FILE, Node, check_keys, number, numbers, required, sequence, text
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.scenes.scene_paths import FindFile, MeshKind

# What a scene file may say of a mesh file beside its name.
_MESH_KEYS = ("file", "scale", "object", "mesh_units")


def shape_of_triangles(points: Floats, triangles: NDArray[np.int64], meshes: MeshKind) -> Hull | Solid:
    """The shape of a mesh: points (n, 3), m, and triangles (k, 3), which a hull does not need."""
    if meshes == "hull" or not len(triangles):
        return hull_of_triangles(points, triangles)
    return Solid(points, triangles, OPEN_MESHES[meshes])


def mesh_parts(path: Path, keys: Mapping[str, Any], taken: OpenMesh | None) -> list[Part]:
    """The parts of a mesh file: one for each of its objects; hulls if an open mesh of a solid is taken as None.

    The keys are what a scene's file says beside its name: scale, object, mesh_units.

    Raises:
        PlannercheckError: If the file can't be read, or has no object of that name.
    """
    units: MeshUnits | None = keys.get("mesh_units")
    mesh = read_mesh(path, keys.get("scale", 1.0), checked_units(units) or "file")
    several = len(mesh.objects) > 1
    if "object" in keys:
        mesh = _one_object(mesh, keys["object"])
    large = [words for each in mesh.objects if taken is None and (words := hull_excess(each.points, each.triangles))]
    warn_of_mesh(mesh, units, [f"{words}: `solid` takes the mesh as it is" for words in large[:1]], stacklevel=4)
    parts = []
    for each in mesh.objects:
        with named_file(path):
            shape = Hull(each.points) if taken is None else Solid(each.points, each.triangles, taken)
        own = {"object": each.name} if several else {}
        parts.append(Part(shape, None, (path, {**keys, **own}), each.name if several else ""))
    return parts


def source_mesh(path: Path, keys: Mapping[str, Any]) -> MeshFile:
    """The mesh that a part of a scene is made of; arguments as of `mesh_parts`."""
    mesh = read_mesh(path, keys.get("scale", 1.0), checked_units(keys.get("mesh_units")) or "file")
    return _one_object(mesh, keys["object"]) if "object" in keys else mesh


def _one_object(mesh: MeshFile, name: str) -> MeshFile:
    chosen = tuple(each for each in mesh.objects if each.name == name)
    if not chosen:
        with named_file(mesh.path):
            raise unknown_name("object", name, [each.name for each in mesh.objects])
    return MeshFile(mesh.path, chosen, mesh.conversion)


def read_mesh_node(values: Node, find_file: FindFile) -> list[Part]:
    """The parts of the key `mesh`."""
    return mesh_parts(*_file_and_keys(values, find_file), OPEN_MESHES.get(find_file.meshes))


def read_solid_node(values: Node | str, find_file: FindFile) -> list[Part]:
    """The parts of the key `solid`: a file's name, its mapping, or vertices and triangles."""
    given = {"file": values} if isinstance(values, str) else values
    taken: Any = text(given.get("open", "cap"), "open")
    if "vertices" in given or "triangles" in given:
        check_keys(given, ("vertices", "triangles", "open"))
        points, corners = (sequence(required(given, key), f"'{key}'") for key in ("vertices", "triangles"))
        rows = [numbers(row, f"triangles row {k}", 3) for k, row in enumerate(corners)]
        if any(not corner.is_integer() for row in rows for corner in row):
            raise PlannercheckError("triangles must be whole numbers, indices of vertices")
        indices = np.array(rows, dtype=np.float64).reshape(-1, 3).astype(np.int64)
        return [Part(Solid(_rows(points), indices, taken))]
    return mesh_parts(*_file_and_keys(given, find_file, "open"), taken)


def read_hull(values: Node, find_file: FindFile) -> Hull:
    """The shape of the key `hull`: points, or a file of them."""
    check_keys(values, ("vertices", "file"))
    given = [key for key in ("vertices", "file") if key in values]
    if len(given) != 1:
        raise PlannercheckError(
            f"needs exactly one of the keys vertices, file; given are {' and '.join(given) or 'none'}"
        )
    if given == ["file"]:
        return _hull_file(find_file(text(required(values, "file"), "file")))
    return Hull(_rows(sequence(values["vertices"], "'vertices'")))


def _file_and_keys(values: Node, find_file: FindFile, *more: str) -> tuple[Path, dict[str, Any]]:
    """The path of a mesh file, and what is said beside its name."""
    check_keys(values, (*_MESH_KEYS, *more))
    keys: dict[str, Any] = {}
    if "scale" in values:
        scale = values["scale"]
        keys["scale"] = numbers(scale, "scale", 3) if isinstance(scale, list) else number(scale, "scale")
    if "object" in values:
        keys["object"] = text(values["object"], "object")
    units = checked_units(values.get("mesh_units", find_file.mesh_units))
    if units is not None:
        keys["mesh_units"] = units
    return find_file(text(required(values, "file"), "file")), keys


def _rows(rows: Sequence[Any]) -> Floats:
    """Points (n, 3) of a list of lists."""
    return np.array([numbers(row, f"vertices row {k}", 3) for k, row in enumerate(rows)]).reshape(-1, 3)


def _hull_file(path: Path) -> Hull:
    try:
        return Hull(np.load(path, allow_pickle=False))
    except PlannercheckError as error:
        raise PlannercheckError(f"file {str(path)!r}: {error}") from None
    except BROKEN_FILE as error:
        raise PlannercheckError(f"file {str(path)!r} can't be read as npy: {error!s:.200}") from None
