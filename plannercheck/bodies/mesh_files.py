"""Mesh files: STL, OBJ, PLY, OFF, Collada and glTF, in doubles, with all objects where the file's scene puts them.

In: a path, a scale, and whether the file's own unit and axes count. Out: `MeshFile`. A file is read as its format
defines it, or refused with the faulty place: a skipped face would be a hole in a body. The objects of large files are
cached by their content (`mesh_cache.py`).
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import astuple, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

import numpy as np

from plannercheck.bodies.collada_files import ColladaAxes, objects_of_collada
from plannercheck.bodies.gltf_files import Y_UP, scene_of_gltf
from plannercheck.bodies.mesh_cache import known_objects
from plannercheck.bodies.mesh_objects import NO_FACES, RawObject
from plannercheck.bodies.mesh_poses import turned
from plannercheck.bodies.obj_files import objects_of_obj
from plannercheck.bodies.off_files import objects_of_off
from plannercheck.bodies.ply_meshes import objects_of_ply
from plannercheck.bodies.stl_files import objects_of_stl
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.package_data import is_file, why_no_file
from plannercheck.common.progress import reported

MeshUnits: TypeAlias = Literal["file", "metre"]

# Formats whose numbers have neither a unit nor axes of their own.
_PLAIN = {".stl": objects_of_stl, ".obj": objects_of_obj, ".ply": objects_of_ply, ".off": objects_of_off}
_WITH_AXES = (".dae", ".gltf", ".glb")
MESH_SUFFIXES = (*_PLAIN, *_WITH_AXES)

# No link or object is as large as this, m; meshes in millimetres are, from 2 cm on.
_LARGEST_USUAL_MESH = 20.0

# Roots are written in single precision: one that turns z up to y up does so within it.
_NO_TURN = 1e-6

# What Git keeps in place of a large file.
_LFS_POINTER = b"version https://git-lfs"


@dataclass(frozen=True, eq=False)
class MeshObject:
    """One object of a mesh file.

    Attributes:
        name: Its name in the file, made unique within the file; "" where the file names none.
        points: (n, 3) m, scaled, posed by the file's scene graph.
        triangles: (m, 3) indices of points, in the file's order, degenerate ones included.
    """

    name: str
    points: Floats
    triangles: Ints64


@dataclass(frozen=True, eq=False)
class MeshFile:
    """What a mesh file holds.

    Attributes:
        path: The file.
        objects: At least one, each with at least one triangle.
        conversion: How the readings "file" and "metre" differ, in words; "" if they are the same, but for roundings of
            a glTF root that turns z up to y up.
    """

    path: Path
    objects: tuple[MeshObject, ...]
    conversion: str

    @cached_property
    def points(self) -> Floats:
        """The points (n, 3) of all objects, m."""
        return self.objects[0].points if len(self.objects) == 1 else np.concatenate([o.points for o in self.objects])

    @cached_property
    def triangles(self) -> Ints64:
        """The triangles (m, 3) of all objects, as indices of `points`."""
        counts = [len(each.points) for each in self.objects]
        shifts = np.cumsum([0, *counts[:-1]])
        return np.concatenate([each.triangles + shift for each, shift in zip(self.objects, shifts, strict=True)])


def read_mesh(path: str | Path, scale: float | Sequence[float] = 1.0, units: MeshUnits = "file") -> MeshFile:
    """Reads a mesh file.

    Args:
        path: The file; its ending tells the format.
        scale: One factor, or one along each axis of the result.
        units: "file" for metres with z up by what the file says of its unit and axes; "metre" for its numbers as metres
            along x, y and z and without the transform of the scene's root, as MoveIt's planning scene has it.

    Raises:
        PlannercheckError: If the file is missing, is not of its format, or has no triangles.
    """
    factors = _checked_scale(scale)
    if units not in ("file", "metre"):
        raise PlannercheckError(f"units of a mesh must be 'file' or 'metre', not {units!r}")
    with named_file(path), reported(f"reading mesh {Path(path).name}"):
        objects, conversion = _read(Path(path), units)
        if not objects:
            raise PlannercheckError(NO_FACES)
        names = _unique([each.name for each in objects])
        return MeshFile(
            Path(path),
            tuple(
                MeshObject(name, _scaled(each.points, factors), each.triangles)
                for name, each in zip(names, objects, strict=True)
            ),
            conversion,
        )


def checked_units(value: object) -> MeshUnits | None:
    """What is asked for as `mesh_units`; None for nothing."""
    for units in get_args(MeshUnits):
        if value == units:
            return units  # type: ignore[no-any-return]
    if value is None:
        return None
    raise unknown_name("kind of mesh_units", str(value), get_args(MeshUnits))


@contextmanager
def named_file(path: str | Path) -> Iterator[None]:
    """Errors inside say which mesh file they are about; a file that is not there is one."""
    if not is_file(Path(path)):
        raise PlannercheckError(f"mesh file {str(path)!r} {why_no_file(Path(path))}")
    try:
        yield
    except PlannercheckError as error:
        raise PlannercheckError(f"mesh file {str(path)!r}: {error}") from None


def mesh_hint(points: Floats) -> str:
    """A sentence about points (n, 3) in m that are unusually far apart; empty if they are not."""
    size = float(np.ptp(points, axis=0).max(initial=0))
    if size <= _LARGEST_USUAL_MESH:
        return ""
    return f"is {size:.4g} m large: if it is in millimetres, scale it by 0.001"


def warn_of_mesh(mesh: MeshFile, units: MeshUnits | None, more: Sequence[str] = (), stacklevel: int = 1) -> None:
    """Warns of a mesh that is unusually large, or whose unit or axes nobody has asked to convert.

    `more` are other words about it; `stacklevel` says who is warned.
    """
    said = [hint] if (hint := mesh_hint(mesh.points)) else []
    if mesh.conversion and units is None:
        said.append(
            f"is converted to metres, z up, as its format says: {mesh.conversion}; MoveIt's planning scene would take "
            'its numbers as metres: mesh_units="metre" does so, mesh_units="file" says that converting is meant'
        )
    for words in (*said, *more):
        warnings.warn(f"mesh file {str(mesh.path)!r}: {words}", RuntimeWarning, stacklevel=stacklevel + 1)


def _read(path: Path, units: MeshUnits) -> tuple[list[RawObject], str]:
    """The objects of a file, in m, and how the units differ."""
    ending = path.suffix.lower()
    content = _content(path)
    if ending in _PLAIN:
        return known_objects(ending, content, lambda content: (_PLAIN[ending](content), []))[0], ""
    if ending == ".dae":
        objects, numbers = known_objects(ending, content, _collada)
        axes = ColladaAxes(*numbers)
        return objects if units == "metre" else _in_metres(objects, axes.turn, axes.metres), axes.words
    if ending in _WITH_AXES:
        scene = scene_of_gltf(path, content)
        conversion = _gltf_conversion(scene.root)
        return scene.without_root if units == "metre" else _in_metres(scene.objects, Y_UP, 1.0), conversion
    raise PlannercheckError(
        f"is of a format that is not read ({ending or 'no ending'}): convert it to one of {', '.join(MESH_SUFFIXES)}"
    )


def _collada(content: bytes) -> tuple[list[RawObject], list[Any]]:
    objects, axes = objects_of_collada(content)
    return objects, list(astuple(axes))


def _gltf_conversion(root: Floats) -> str:
    """How a scene with a root differs from its numbers; exporters for robots often turn y up in the root."""
    if np.abs(np.vstack([turned(Y_UP, root[:3].T).T, root[3:]]) - np.eye(4)).max() < _NO_TURN:
        return ""
    return f"{'its root node has a transform and ' if (root != np.eye(4)).any() else ''}its y axis is up"


def _content(path: Path) -> bytes:
    try:
        content = path.read_bytes()
    except OSError as error:
        raise PlannercheckError(f"can't be read: {error.strerror or error}") from None
    if content.startswith(_LFS_POINTER):
        raise PlannercheckError("is a Git LFS pointer, not the mesh itself: `git lfs pull` fetches it")
    return content


def _in_metres(objects: list[RawObject], turn: Floats, metres: float) -> list[RawObject]:
    """Objects turned to z up and then scaled from their unit to m."""
    same = (turn == np.eye(3)).all()
    return [
        RawObject(
            each.name, _scaled(each.points if same else turned(turn, each.points), np.full(3, metres)), each.triangles
        )
        for each in objects
    ]


def _scaled(points: Floats, factors: Floats) -> Floats:
    if (factors == 1).all():
        return points
    with np.errstate(over="ignore"):
        scaled = points * factors
    if not np.isfinite(scaled).all():
        raise PlannercheckError("has points that its scale moves beyond all doubles")
    return scaled


def _unique(names: list[str]) -> list[str]:
    """Names with a number after those that come again; nameless objects stay so."""
    taken, found = set(names), []
    seen: set[str] = set()
    counts: dict[str, int] = {}
    for name in names:
        unique = name
        while (name and unique in seen) or (unique != name and unique in taken):
            counts[name] = counts.get(name, 1) + 1
            unique = f"{name}_{counts[name]}"
        seen.add(unique)
        found.append(unique)
    return found


def _checked_scale(scale: float | Sequence[float]) -> Floats:
    """Three factors, finite and not zero (a negative one mirrors the mesh)."""
    try:
        factors = np.broadcast_to(np.asarray(scale, dtype=np.float64), (3,))
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"mesh scale must be one or three numbers, not {scale!r}") from None
    if not (np.isfinite(factors).all() and factors.all()):
        raise PlannercheckError(f"mesh scale must be finite and not zero, not {scale!r}")
    return factors
