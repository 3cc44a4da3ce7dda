"""Solids: bodies that are their meshes, not the hulls of these.

In: vertices in m and triangles, or a mesh file. Out: `Solid`, immutable, one of the shapes of links and obstacles. The
body is a closed set: the triangles and, if the mesh is closed, all points about which it winds. So meshes that cross
themselves, nested shells, inverted orientations and T-junctions all have a meaning (docs/explanation/solids.md).
"""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.bodies.hull_equality import is_hull
from plannercheck.bodies.mesh_files import corners_of_file, named_file, warn_of_size
from plannercheck.common.array_types import Faces, Floats, Ints
from plannercheck.common.arrays import read_only, read_only_copy, real_numbers, shown_array
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module


@set_module("plannercheck")
@dataclass(frozen=True, eq=False, repr=False)
class Solid:
    """A mesh as it is: its triangles, and what they enclose.

    The set is the triangles and, if the mesh is closed, all points whose winding number is not 0; else the triangles
    alone. Degenerate triangles are segments or points of it. Vertices that no triangle uses do not belong to it.

    Attributes:
        vertices: (n, 3) in m, read-only.
        triangles: (k, 3) indices of vertices, read-only.
    """

    vertices: Floats
    triangles: NDArray[np.integer[Any]]

    def __post_init__(self) -> None:
        vertices = _checked_vertices(self.vertices)
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "triangles", _checked_triangles(self.triangles, len(vertices)))

    @classmethod
    def load(cls, path: str | Path, scale: float | Sequence[float] = 1.0) -> Solid:
        """Loads a mesh file (stl, dae, obj, ply and whatever else coal reads); equal points become one.

        Args:
            path: The file.
            scale: One factor, or one along each axis, from the file's unit to m.

        Returns:
            The solid; a warning says so if it is not closed.

        Raises:
            PlannercheckError: If the file is missing or no mesh, or has no triangles.
        """
        points, triangles = corners_of_file(path, scale)
        with named_file(path):
            solid = cls(*_merged(points, triangles))
        warn_of_size(path, points, stacklevel=2)
        if not solid.is_closed:
            warnings.warn(f"mesh file {str(path)!r} {OPEN_WORDS}", RuntimeWarning, stacklevel=2)
        return solid

    @cached_property
    def used(self) -> tuple[Floats, Ints]:
        """The mesh without unused vertices, equal ones merged: points (m, 3) in m, and the triangles in their order."""
        points, triangles = _merged(self.vertices, self.triangles)
        return read_only(points), read_only(triangles)

    @cached_property
    def is_closed(self) -> bool:
        """Whether the directed edges cancel, each one occurring as often as its reverse.

        Vertices with equal coordinates are one vertex (-0 is 0).
        """
        points, triangles = self.used
        a, b = triangles.astype(np.int64)[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).T
        forth, back = a * len(points) + b, b * len(points) + a
        return np.array_equal(np.sort(forth), np.sort(back))

    @cached_property
    def equals_hull(self) -> bool:
        """Whether the solid is its convex hull, decided exactly; it is then tested as its hull, which is faster.

        Of solids without volume, only those of which one triangle holds all count as their hulls.
        """
        return is_hull(*self.used, self.is_closed)

    @cached_property
    def core(self) -> Any:
        """The compiled solid with its tree of triangles, for the rest of the library."""
        return core.Solid(*self.used)

    @cached_property
    def digest(self) -> bytes:
        """A hash of the set: equal for solids of the same triangles."""
        points, triangles = self.used
        return hashlib.sha256(points.tobytes() + triangles.tobytes()).digest()

    def vertices_and_faces(self, excess: float = 0.0) -> tuple[Floats, Faces | None]:
        """The points (m, 3) in m of its hull, exact whatever the excess; the hull's faces have to be computed."""
        return self.used[0], None

    def __reduce__(self) -> tuple[Any, ...]:
        return Solid, (self.vertices, self.triangles)

    def __repr__(self) -> str:
        kind = "closed" if self.is_closed else "open"
        return f"Solid({len(self.vertices)} vertices, {len(self.triangles)} triangles, {kind})"


# What warnings say of a mesh that is not closed.
OPEN_WORDS = "is not closed: it is taken as its triangles alone, and a body inside it does not collide"


def _merged(points: Floats, triangles: NDArray[Any]) -> tuple[Floats, Ints]:
    """The points that triangles use, each once and without -0, and the triangles with their new indices."""
    used, corners = np.unique(triangles, return_inverse=True)
    distinct, index = np.unique(points[used] + 0.0, axis=0, return_inverse=True)
    return distinct, index.reshape(-1)[corners.reshape(-1)].reshape(-1, 3).astype(np.int32)


def _checked_vertices(values: ArrayLike) -> Floats:
    try:
        vertices = read_only_copy(real_numbers(values))
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(
            f"vertices of a solid must be numbers of shape (n, 3), not {shown_array(values)}"
        ) from None
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise PlannercheckError(f"vertices of a solid must have shape (n, 3), not {vertices.shape}")
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if len(bad):
        row = int(bad[0])
        raise PlannercheckError(
            f"vertices of a solid: row {row} is {vertices[row].tolist()}, coordinates must be finite"
        )
    return vertices


def _checked_triangles(values: ArrayLike, count: int) -> Ints:
    try:
        triangles = np.array(values)
    except (TypeError, ValueError, OverflowError):
        triangles = np.zeros((0, 0), dtype=np.bool_)
    if not triangles.size:
        raise PlannercheckError("a solid needs at least one triangle; pc.Hull takes points alone")
    if triangles.ndim != 2 or triangles.shape[1] != 3 or triangles.dtype.kind not in "iu":
        raise PlannercheckError(
            f"triangles of a solid must be whole numbers of shape (k, 3), three indices of vertices each, not "
            f"{shown_array(values)} of shape {triangles.shape}"
        )
    bad = np.flatnonzero(((triangles < 0) | (triangles >= count)).any(axis=1))
    if len(bad):
        row = int(bad[0])
        raise PlannercheckError(
            f"triangles of a solid: row {row} is {triangles[row].tolist()}, but there are {count} vertices, 0 to "
            f"{count - 1}"
        )
    return read_only(np.ascontiguousarray(triangles, dtype=np.int32))
