"""Mesh files, through coal's loader (stl, dae, obj, ply and whatever else assimp reads).

In: a path and a scale. Out: the mesh's points in m, and its triangles.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.ply_files import check_ply
from plannercheck.bodies.triangle_meshes import TriangleMesh, corners_of_coal, triangles_of_coal
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.package_data import is_file

# No link or object is as large as this, m; meshes in millimetres are, from 2 cm on.
_LARGEST_USUAL_MESH = 20.0

# Formats that may write vertices as text, one a line, and a vertex that is no number.
_WITH_LINES = (".obj", ".stl")
_NO_NUMBER = re.compile(rb"^[ \t]*(v(?:ertex)?[ \t][^\r\n]*\bnan\b[^\r\n]*)", re.IGNORECASE | re.MULTILINE)

_NO_FACES = "it has no faces: a cloud of points is no mesh"

# What Git keeps in place of a large file.
_LFS_POINTER = b"version https://git-lfs"


def checked_units(value: object) -> MeshUnits | None:
    """What is asked for as `mesh_units`; None for nothing."""
    for units in get_args(MeshUnits):
        if value == units:
            return units  # type: ignore[no-any-return]
    if value is None:
        return None
    raise unknown_name("kind of mesh_units", str(value), get_args(MeshUnits))


def load_triangles(path: str | Path, scale: float | Sequence[float] = 1.0) -> TriangleMesh | None:
    """The triangles of a mesh file that `load_mesh` reads, scaled to m."""
    import coal  # slow to import, and only meshes need it

    check_mesh(Path(path))
    mesh = triangles_of_coal(coal.MeshLoader().load(str(path), np.ones(3)))
    return None if mesh is None else TriangleMesh.of(mesh.points * _checked_scale(scale), mesh.triangles)


def points_of_file(path: str | Path, scale: float | Sequence[float] = 1.0) -> Floats:
    """The points (n, 3) of a mesh file, scaled to m.

    Raises:
        PlannercheckError: If the file is missing or is no mesh.
    """
    factors = _checked_scale(scale)
    with named_file(path):
        return np.array(_loaded(Path(path)).vertices(), dtype=np.float64) * factors


def corners_of_file(path: str | Path, scale: float | Sequence[float] = 1.0) -> tuple[Floats, Ints64]:
    """The points (n, 3), scaled to m, and the triangles (m, 3) of a mesh file, degenerate ones included.

    Raises:
        PlannercheckError: If the file is missing, is no mesh, or has no triangles.
    """
    factors = _checked_scale(scale)
    with named_file(path):
        found = corners_of_coal(_loaded(Path(path)))
        if found is None or not len(found[1]):
            raise PlannercheckError(_NO_FACES)
    return found[0] * factors, found[1]


@contextmanager
def named_file(path: str | Path) -> Iterator[None]:
    """Errors inside say which mesh file they are about; a file that is not there is one."""
    if not is_file(Path(path)):
        raise PlannercheckError(f"mesh file {str(path)!r} does not exist")
    try:
        yield
    except PlannercheckError as error:
        raise PlannercheckError(f"mesh file {str(path)!r}: {error}") from None


def warn_of_size(path: str | Path, points: Floats, stacklevel: int) -> None:
    """Warns of a mesh that is unusually large."""
    hint = mesh_hint(points)
    if hint:
        warnings.warn(f"mesh file {str(path)!r} {hint}", RuntimeWarning, stacklevel=stacklevel + 1)


def check_mesh(path: Path) -> None:
    """Raises for a file that would crash the libraries that read it, or that is a pointer of Git LFS."""
    try:
        with path.open("rb") as file:
            start = file.read(len(_LFS_POINTER))
    except OSError:
        return  # the reader will say why
    if start == _LFS_POINTER:
        raise PlannercheckError("is a Git LFS pointer, not the mesh itself: `git lfs pull` fetches it")
    if path.suffix.lower() == ".ply":
        check_ply(path)
    if path.suffix.lower() in _WITH_LINES:
        _check_numbers(path)


def _check_numbers(path: Path) -> None:
    """Raises for a vertex in words: coal builds a box about it, and complains on the terminal."""
    content = path.read_bytes()
    if not any(word in content for word in (b"nan", b"NaN", b"NAN")):
        return
    found = _NO_NUMBER.search(content)
    if found is not None:
        line = content.count(b"\n", 0, found.start()) + 1
        raise PlannercheckError(f"line {line}: vertex {found.group(1).decode(errors='replace')!r:.80} is no number")


def mesh_hint(points: NDArray[np.float64]) -> str:
    """A sentence about points (n, 3) in m that are unusually far apart; empty if they are not."""
    size = float(np.ptp(points, axis=0).max(initial=0))
    if size <= _LARGEST_USUAL_MESH:
        return ""
    return f"is {size:.4g} m large: if it is in millimetres, scale it by 0.001"


def _checked_scale(scale: float | Sequence[float]) -> NDArray[np.float64]:
    """Three factors, finite and not zero (a negative one mirrors the mesh)."""
    try:
        factors = np.broadcast_to(np.asarray(scale, dtype=np.float64), (3,))
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"mesh scale must be one or three numbers, not {scale!r}") from None
    if not (np.isfinite(factors).all() and factors.all()):
        raise PlannercheckError(f"mesh scale must be finite and not zero, not {scale!r}")
    return factors


def _loaded(path: Path) -> Any:
    """Coal's mesh of a file."""
    import coal  # slow to import, and only meshes need it

    check_mesh(path)
    try:
        return coal.MeshLoader().load(str(path), np.ones(3))
    except Exception as error:  # coal raises several unrelated types
        reason = " ".join(str(error).partition("message:")[2].split()) or str(error)
        if "No meshes remain" in reason:
            reason = _NO_FACES
        raise PlannercheckError(f"can't be read as a mesh: {reason:.400}") from None


# TEMPORARY until the reader is merged
from dataclasses import dataclass  # noqa: E402
from typing import Literal, TypeAlias, get_args, get_args  # noqa: E402

from plannercheck.common.errors import unknown_name  # noqa: E402

MeshUnits: TypeAlias = Literal["file", "metre"]


def checked_units(value: Any) -> MeshUnits | None:
    """What is asked for as `mesh_units`; None for nothing."""
    for units in get_args(MeshUnits):
        if value == units:
            return units  # type: ignore[no-any-return]
    if value is None:
        return None
    raise unknown_name("kind of mesh_units", str(value), get_args(MeshUnits))


@dataclass(frozen=True, eq=False)
class MeshObject:
    name: str
    points: Floats
    triangles: Ints64


@dataclass(frozen=True, eq=False)
class MeshFile:
    path: Path
    objects: tuple[MeshObject, ...]
    conversion: str

    @property
    def points(self) -> Floats:
        return self.objects[0].points

    @property
    def triangles(self) -> Ints64:
        return self.objects[0].triangles


def read_mesh(path: str | Path, scale: float | Sequence[float] = 1.0, units: MeshUnits = "file") -> MeshFile:
    points, triangles = corners_of_file(path, scale)
    return MeshFile(Path(path), (MeshObject("", points, triangles),), "")
