"""Shapes of a scene's meshes: their hulls, or the solids that they are.

In: a file's keys `mesh`, `hull` and `solid`, or triangles in MoveIt's messages. Out: `Hull` or `Solid`. Caps
close open meshes of a scene that is read with its meshes as solids, or these are their triangles alone; a `solid:` of a
scene file says which by its key `open`. `Scene.load` warns of open meshes.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.mesh_files import warn_of_size
from plannercheck.bodies.meshes import hull_of_triangles, load_mesh
from plannercheck.bodies.shapes import Hull
from plannercheck.bodies.solids import OPEN_MESHES, Solid, solid_of_file
from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import BROKEN_FILE, Node, check_keys, number, numbers, required, sequence, text
from plannercheck.common.errors import PlannercheckError
from plannercheck.scenes.scene_paths import FindFile, MeshKind

Source = tuple[Path, Any]


def shape_of_triangles(points: Floats, triangles: NDArray[np.int64], meshes: MeshKind) -> Hull | Solid:
    """The shape of a mesh: points (n, 3), m, and triangles (k, 3), which a hull does not need."""
    if meshes == "hull" or not len(triangles):
        return hull_of_triangles(points, triangles)
    return Solid(points, triangles, OPEN_MESHES[meshes])


def shape_of_file(path: Path, scale: float | Sequence[float], meshes: MeshKind) -> Hull | Solid:
    """The shape of a mesh file; `scale` takes its unit to m."""
    if meshes == "hull":
        return load_mesh(path, scale)
    solid = solid_of_file(path, scale, OPEN_MESHES[meshes])
    warn_of_size(path, solid.vertices, stacklevel=2)
    return solid


def read_mesh(values: Node, find_file: FindFile) -> tuple[Hull | Solid, Source]:
    """The shape of the key `mesh`, with its file and scale."""
    path, factors = _file_and_scale(values, find_file)
    return shape_of_file(path, factors, find_file.meshes), (path, factors)


def read_solid(values: Node | str, find_file: FindFile) -> tuple[Solid, Source | None]:
    """The shape of the key `solid`: a file's name, its mapping, or vertices and triangles."""
    given = {"file": values} if isinstance(values, str) else values
    taken: Any = text(given.get("open", "cap"), "open")
    if "vertices" in given or "triangles" in given:
        check_keys(given, ("vertices", "triangles", "open"))
        points, corners = (sequence(required(given, key), f"'{key}'") for key in ("vertices", "triangles"))
        rows = [numbers(row, f"triangles row {k}", 3) for k, row in enumerate(corners)]
        if any(not corner.is_integer() for row in rows for corner in row):
            raise PlannercheckError("triangles must be whole numbers, indices of vertices")
        indices = np.array(rows, dtype=np.float64).reshape(-1, 3).astype(np.int64)
        return Solid(_rows(points), indices, taken), None
    path, factors = _file_and_scale(given, find_file, "open")
    solid = solid_of_file(path, factors, taken)
    warn_of_size(path, solid.vertices, stacklevel=2)
    return solid, (path, factors)


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


def _file_and_scale(values: Node, find_file: FindFile, *more: str) -> Source:
    check_keys(values, ("file", "scale", *more))
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
