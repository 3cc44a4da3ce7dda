"""Solids: bodies that are their meshes, not the hulls of these.

In: vertices in m and triangles, or a mesh file. Out: `Solid`, immutable, one of the shapes of links and obstacles. The
body is a closed set: the triangles and, if the mesh is closed, all points about which it winds. Caps close an open mesh
first (caps.py), unless its triangles alone or its hull are asked for; a surface is the triangles of any mesh. So meshes
that cross themselves, nested shells, inverted orientations, holes and T-junctions all have a meaning
(docs/explanation/solids.md).
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.bodies.caps import Caps, closing, open_edges
from plannercheck.bodies.core_polytopes import core_polytope
from plannercheck.bodies.hull_equality import is_hull
from plannercheck.bodies.kinds import Kind
from plannercheck.bodies.mesh_files import MeshUnits, checked_units, named_file, read_mesh, warn_of_mesh
from plannercheck.bodies.mesh_objects import RawObject
from plannercheck.common.array_types import Faces, Floats, Ints, Ints64
from plannercheck.common.arrays import (
    distinct_rows,
    read_only,
    read_only_copy,
    real_numbers,
    shown_array,
    unmasked,
)
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.public_names import set_module

# What an open mesh is taken as: closed by caps, its triangles alone, or its convex hull. As a surface, a closed mesh is
# its triangles alone, too.
OpenMesh: TypeAlias = Literal["cap", "triangles", "hull", "surface"]
# The same, by the kinds of geometry of robots and scenes that make solids.
OPEN_MESHES: dict[str, OpenMesh] = {"solid": "cap", "triangles": "triangles"}


@set_module("plannercheck")
@dataclass(frozen=True, eq=False, repr=False)
class Solid:
    """A mesh as it is: its triangles, and what they enclose.

    The set of a closed mesh is its triangles and all points whose winding number is not 0. Degenerate triangles are
    segments or points of it. Vertices that no triangle uses do not belong to it. Of an open mesh, `open` says the set:

    - "cap": triangles between given vertices are added until the mesh is closed. The set holds all given triangles, and
      their hull holds the set.
    - "triangles": the given triangles alone; a body inside does not collide.
    - "hull": the convex hull of the given triangles.
    - "surface": the given triangles alone, of a closed mesh as well; a body inside does not collide.

    A mesh of a library, as a trimesh.Trimesh, may be given alone: `pc.Solid(mesh)` has its vertices and faces.

    Attributes:
        vertices: (n, 3) in m as given, read-only.
        triangles: (k, 3) indices of vertices as given, without caps, read-only.
        open: What an open mesh is taken as; only "surface" changes anything about a closed one.
    """

    body_kind: ClassVar[Kind] = "solid"

    vertices: Floats
    triangles: NDArray[np.integer[Any]] = None  # type: ignore[assignment]  # of a mesh, its faces
    open: OpenMesh = "cap"

    def __post_init__(self) -> None:
        points, faces = (self.vertices, self.triangles) if self.triangles is not None else _of_mesh(self.vertices)
        vertices = _checked_vertices(points)
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "triangles", _checked_triangles(faces, len(vertices)))
        if not isinstance(self.open, str) or self.open not in get_args(OpenMesh):
            raise unknown_name("way to take an open mesh", str(self.open), get_args(OpenMesh))

    @classmethod
    def load(
        cls,
        path: str | Path,
        scale: float | Sequence[float] = 1.0,
        open: OpenMesh = "cap",
        mesh_units: MeshUnits | None = None,
    ) -> Solid:
        """Loads a mesh file (stl, dae, obj, ply, off, gltf, glb), with all its objects; equal points become one.

        Args:
            path: The file.
            scale: One factor, or one along each axis, from the file's unit to m.
            open: What an open mesh is taken as, see the class.
            mesh_units: "file" converts to metres, z up, as the format says (the default, with a warning where it
                converts); "metre" takes the numbers as MoveIt's planning scene does.

        Returns:
            The solid; a warning says so if the mesh is open.

        Raises:
            PlannercheckError: If the file is missing or no mesh, or has no triangles.
        """
        units = checked_units(mesh_units)
        mesh = read_mesh(path, scale, units or "file")
        with named_file(path):
            solid = cls(*_merged(mesh.points, mesh.triangles), open)
        words = [open_meshes({"the mesh": solid})] if solid.is_open and open != "surface" else []
        warn_of_mesh(mesh, units, words, stacklevel=2)
        return solid

    @cached_property
    def used(self) -> tuple[Floats, Ints]:
        """The mesh of the set, which caps or the hull may have closed: points (m, 3) in m, and triangles.

        Equal vertices are merged, unused ones left out; given triangles come first, in their order. A flat hull, whose
        triangles are not known, has the given ones. A closed mesh taken as its surface has one triangle twice: the same
        points, and edges that do not cancel, so that it is open and has no inside for all who read these triangles.
        """
        points, triangles = self._mesh
        if self.open == "surface" and not self.is_open:
            triangles = np.concatenate([triangles, triangles[:1]])
        if self.open == "cap" and self._closing is not None:
            triangles = np.concatenate([triangles, self._closing[0]])
        elif self.open == "hull" and self.is_open:
            hull = core_polytope(points)
            if hull.dimension == _SPACE:
                points, triangles = _merged(points, hull.source()[hull.triangles()])
        return read_only(points), read_only(triangles)

    @property
    def is_open(self) -> bool:
        """Whether the given mesh is open: some directed edge occurs more often than its reverse.

        Vertices with equal coordinates are one vertex (-0 is 0).
        """
        return len(self._open_edges) > 0

    @property
    def is_closed(self) -> bool:
        """Whether the set has an inside: unless an open mesh, or any as a surface, is its triangles alone."""
        return self.kind in ("closed", "capped", "hull")

    @property
    def kind(self) -> Literal["closed", "capped", "hull", "open", "surface"]:
        """What the set is: a closed mesh; an open one with caps, as its hull, or its triangles alone; or a surface."""
        return _KINDS[self.open] if self.is_open or self.open == "surface" else "closed"

    @property
    def caps(self) -> Caps | None:
        """What the given mesh lacks to be closed: loops of open edges, and the size of their caps; None if nothing."""
        return None if self._closing is None else self._closing[1]

    @cached_property
    def _mesh(self) -> tuple[Floats, Ints]:
        """The given mesh without unused vertices, equal ones merged."""
        points, triangles = _merged(self.vertices, self.triangles)
        return read_only(points), read_only(triangles)

    @cached_property
    def _open_edges(self) -> Ints64:
        return open_edges(self._mesh[1])

    @cached_property
    def _closing(self) -> tuple[Ints, Caps] | None:
        """The triangles that close an open mesh, and what they close."""
        return closing(self._mesh[0], self._open_edges) if self.is_open else None

    @cached_property
    def equals_hull(self) -> bool:
        """Whether the solid is its convex hull, decided exactly; it is then tested as its hull, which is faster.

        Of solids without volume, only those of which one triangle holds all count as their hulls.
        """
        return self.kind == "hull" or is_hull(*self.used, self.is_closed)

    @cached_property
    def core(self) -> Any:
        """The compiled solid with its tree of triangles, for the rest of the library."""
        return core.Solid(*self.used)

    @cached_property
    def digest(self) -> bytes:
        """A hash of the set: equal for solids of the same triangles, caps included."""
        points, triangles = self.used
        kind = b"hull" if self.kind == "hull" else b""
        return hashlib.sha256(points.tobytes() + triangles.tobytes() + kind).digest()

    def vertices_and_faces(self, excess: float = 0.0) -> tuple[Floats, Faces | None]:
        """The points (m, 3) in m of its hull, exact whatever the excess; the hull's faces have to be computed."""
        return self.used[0], None

    def __reduce__(self) -> tuple[Any, ...]:
        return Solid, (self.vertices, self.triangles, self.open)

    def __repr__(self) -> str:
        return f"Solid({len(self.vertices)} vertices, {len(self.triangles)} triangles, {self.kind})"


_KINDS: dict[OpenMesh, Literal["capped", "open", "hull", "surface"]] = {
    "cap": "capped",
    "triangles": "open",
    "hull": "hull",
    "surface": "surface",
}
_CLOSURES = {
    "capped": "caps close open meshes",
    "hull": "open meshes are their hulls",
    "open": "open meshes are their triangles alone, and a body inside does not collide",
}
_SPACE = 3


def open_meshes(solids: Mapping[str, Solid]) -> str:
    """What is done about open meshes of solids by name, with the sizes of their caps; empty if all are closed."""
    words = []
    for kind, closure in _CLOSURES.items():
        found = [f"{name} ({solid.caps})" for name, solid in solids.items() if solid.kind == kind]
        words += [f"{closure}: {', '.join(found)}"] if found else []
    return "; ".join(words)


def _merged(points: Floats, triangles: NDArray[Any]) -> tuple[Floats, Ints]:
    """The points that triangles use, each once and without -0, and the triangles with their new indices."""
    used = RawObject.of("", points, triangles)
    distinct, index = distinct_rows(used.points + 0.0)
    return distinct, index.astype(np.int32)[used.triangles]


def _of_mesh(mesh: Any) -> tuple[Any, Any]:
    """The vertices and faces of a library's mesh object."""
    try:
        return mesh.vertices, mesh.faces
    except AttributeError:
        raise PlannercheckError(
            "a solid needs vertices and triangles, or a mesh that has vertices and faces, such as a trimesh.Trimesh "
            f"(of a trimesh.Scene, each mesh in turn), not {type(mesh).__name__} alone; pc.Hull takes points alone"
        ) from None


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
    unmasked(values)
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
