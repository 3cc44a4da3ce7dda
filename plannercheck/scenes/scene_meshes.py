"""Shapes of a scene's meshes: their hulls, or the solids that they are.

In: a file's keys `mesh`, `hull` and `solid`, or triangles in MoveIt's messages. Out: `Hull` or `Solid`. Where a whole
scene is read with its meshes as solids, those that are not closed keep their hulls, with a warning, since a body inside
them would not collide; `solid:` in a scene file takes any mesh.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.mesh_files import corners_of_file
from plannercheck.bodies.meshes import hull_of_triangles, load_mesh
from plannercheck.bodies.shapes import Hull
from plannercheck.bodies.solids import Solid
from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import BROKEN_FILE, Node, check_keys, number, numbers, required, sequence, text
from plannercheck.common.errors import PlannercheckError
from plannercheck.scenes.scene_paths import FindFile, MeshKind

Source = tuple[Path, Any]


def shape_of_triangles(points: Floats, triangles: NDArray[np.int64], meshes: MeshKind) -> Hull | Solid:
    """The shape of a mesh: points (n, 3), m, and triangles (k, 3), which a hull does not need."""
    hull = hull_of_triangles(points, triangles)
    if meshes == "hull" or not len(triangles):
        return hull
    return _closed_or_hull(Solid(points, triangles), hull, "a mesh of the scene")


def shape_of_file(path: Path, scale: float | Sequence[float], meshes: MeshKind) -> Hull | Solid:
    """The shape of a mesh file; `scale` takes its unit to m."""
    if meshes == "hull":
        return load_mesh(path, scale)
    solid = Solid(*corners_of_file(path, scale))
    return solid if solid.is_closed else _closed_or_hull(solid, Hull(solid.vertices), f"mesh file {str(path)!r}")


def _closed_or_hull(solid: Solid, hull: Hull, what: str) -> Hull | Solid:
    if solid.is_closed:
        return solid
    warnings.warn(f"{what} is not closed, so it keeps its hull", RuntimeWarning, stacklevel=2)
    return hull


def read_mesh(values: Node, find_file: FindFile) -> tuple[Hull | Solid, Source]:
    """The shape of the key `mesh`, with its file and scale."""
    path, factors = _file_and_scale(values, find_file)
    return shape_of_file(path, factors, find_file.meshes), (path, factors)


def read_solid(values: Node | str, find_file: FindFile) -> tuple[Solid, Source | None]:
    """The shape of the key `solid`: a file's name, its mapping, or vertices and triangles."""
    given = {"file": values} if isinstance(values, str) else values
    if "vertices" in given or "triangles" in given:
        check_keys(given, ("vertices", "triangles"))
        points, corners = (sequence(required(given, key), f"'{key}'") for key in ("vertices", "triangles"))
        rows = [numbers(row, f"triangles row {k}", 3) for k, row in enumerate(corners)]
        if any(not corner.is_integer() for row in rows for corner in row):
            raise PlannercheckError("triangles must be whole numbers, indices of vertices")
        return Solid(_rows(points), np.array(rows, dtype=np.float64).reshape(-1, 3).astype(np.int64)), None
    path, factors = _file_and_scale(given, find_file)
    return Solid.load(path, factors), (path, factors)


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


def _file_and_scale(values: Node, find_file: FindFile) -> Source:
    check_keys(values, ("file", "scale"))
    scale = values.get("scale", 1.0)
    factors = numbers(scale, "scale", 3) if isinstance(scale, list) else number(scale, "scale")
    return find_file(text(required(values, "file"), "file")), factors


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
