"""Convex decomposition of concave links with CoACD, opt-in, and its repair.

In: a triangle mesh and options. Out: points of convex pieces whose union holds every triangle of the mesh, and figures.
CoACD works in single precision, and remeshes bodies that are not closed. So a mesh sticks out of its pieces by some
micrometres or more, and its triangles cross from one piece into another. The repair: a triangle whose corners are
within `slack` of one piece is added to that piece; any other triangle is cut into four, down to the depth `_DEEPEST`. A
piece with the corners of a triangle holds the triangle. So whatever touches the mesh touches a piece, up to the
rounding of middles of edges (one part in 1e15). Nothing is claimed about the space within the mesh. Results are cached
on disk by content, as prepared bodies are.
"""

from __future__ import annotations

import hashlib
import importlib.util
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plannercheck.bodies import polytope_files as body_files
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.isolated_process import run_isolated
from plannercheck.common.public_names import set_module

# How often a triangle is halved at most: from 1 m down to 4 mm; after that, a piece grows by more than the slack.
_DEEPEST = 8

# Corners this deep in a piece, as a part of its size, are inside whatever the rounding of planes.
_SURELY_INSIDE = 1e-12

# The version of cached results; raised when the repair changes.
_VERSION = 1


@set_module("plannercheck")
@dataclass(frozen=True)
class Decomposition:
    """Which links to decompose, and how.

    Attributes:
        links: Names of links; None for all whose hulls are more than 5 % larger than their meshes, or whose meshes are
            open.
        threshold: CoACD's measure of concavity that a piece may have, 0.01 to 1; small ones make many pieces.
        most_pieces: The most pieces of one mesh; None for any number.
        slack: How far a triangle may stick out of a piece and still be added to it, m. Pieces grow by about this much.
        seed: CoACD's seed.
    """

    links: tuple[str, ...] | None = None
    threshold: float = 0.05
    most_pieces: int | None = None
    slack: float = 0.001
    seed: int = 0

    def __post_init__(self) -> None:
        if not 0.01 <= self.threshold <= 1:
            raise PlannercheckError(f"threshold of a decomposition must be within 0.01 and 1, not {self.threshold!r}")
        if not 0 < self.slack < np.inf:
            raise PlannercheckError(f"slack of a decomposition must be a positive length in m, not {self.slack!r}")
        if self.most_pieces is not None and self.most_pieces < 1:
            raise PlannercheckError(f"most_pieces of a decomposition must be at least 1, not {self.most_pieces!r}")


@dataclass(frozen=True, eq=False)
class Pieces(OwnsArrays):
    """A decomposed mesh.

    Attributes:
        points: Points of each piece, (n, 3) m.
        excess: How far the mesh stuck out of CoACD's pieces at most, m: at corners of triangles, original and cut ones.
        growth: How far the repair made a piece grow at most, m.
        mesh_volume: The mesh's volume, m³; None unless the mesh is watertight.
        hull_volume: The volume of the mesh's hull, m³.
        volume: The sum of the volumes of all repaired pieces, m³; overlaps count several times.
    """

    points: tuple[Floats, ...]
    excess: float
    growth: float
    mesh_volume: float | None
    hull_volume: float
    volume: float


def pieces_of(mesh: TriangleMesh, options: Decomposition, name: str = "mesh") -> Pieces:
    """Decomposes a mesh, through the disk cache.

    Args:
        mesh: The mesh.
        options: How to decompose it.
        name: Its name in errors.

    Returns:
        The repaired pieces.

    Raises:
        PlannercheckError: If CoACD is not installed or fails.
    """
    cache = _cache_file(mesh, options)
    if cache is not None and (data := body_files.read_cached(cache)) is not None:
        return _unpacked(data)
    pieces = repaired(mesh, _coacd(mesh.outward, options, name), options.slack)
    if cache is not None:
        body_files.write_to_cache(cache, _packed(pieces))
    return pieces


def repaired(mesh: TriangleMesh, pieces: Sequence[Floats], slack: float) -> Pieces:
    """Pieces grown until they hold every triangle of the mesh.

    Args:
        mesh: The mesh.
        pieces: Points (n, 3) of each piece, m.
        slack: See `Decomposition`.

    Returns:
        The grown pieces.
    """
    planes = [_planes(Polytope(points)) for points in pieces]
    added: list[list[Floats]] = [[] for _ in pieces]
    excess = growth = 0.0
    triangles = mesh.points[mesh.triangles]
    for depth in range(_DEEPEST + 1):
        outside = np.stack([_beyond(triangles, each) for each in planes], axis=2)  # (m, 3, pieces)
        excess = max(excess, float(outside.min(axis=2).max(initial=0.0)))
        whole = outside.max(axis=1)
        best = whole.argmin(axis=1)
        least = whole[np.arange(len(whole)), best]
        held = (least <= slack) | (depth == _DEEPEST)
        growth = max(growth, float(least[held].max(initial=0.0)))
        for k, (normals, _) in enumerate(planes):
            mine = held & (best == k)
            size = float(np.abs(pieces[k]).max(initial=1e-3)) if len(normals) else 0.0
            added[k].append(triangles[mine][outside[mine, :, k] > -_SURELY_INSIDE * size])
        triangles = _quartered(triangles[~held])
        if not len(triangles):
            break
    grown = tuple(_extreme(np.concatenate([points, *more])) for points, more in zip(pieces, added, strict=True))
    return Pieces(
        grown, excess, growth, mesh.volume, hull_volume(mesh.points), sum(hull_volume(points) for points in grown)
    )


def hull_volume(points: Floats) -> float:
    """The volume of the convex hull of points (n, 3), m³."""
    return polytope_volume(Polytope(points))


def polytope_volume(polytope: Polytope) -> float:
    """The volume of a prepared body's hull, without its inflation radius, m³."""
    middle = polytope.vertices.mean(axis=0)
    a, b, c = (polytope.vertices[polytope.faces[:, k]] - middle for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def _planes(polytope: Polytope) -> tuple[Floats, Floats]:
    """Outward unit normals (f, 3) and offsets (f,), m, of a hull's triangles; none without volume."""
    a, b, c = (polytope.vertices[polytope.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    kept = lengths[:, 0] > 0
    normals = normals[kept] / lengths[kept]
    return normals, np.einsum("ij,ij->i", normals, a[kept])


def _beyond(triangles: Floats, planes: tuple[Floats, Floats]) -> Floats:
    """(m, 3) how far corners (m, 3, 3) are beyond the furthest plane, negative inside; at most their distance, m."""
    normals, offsets = planes
    if not len(normals):
        return np.full(triangles.shape[:2], np.inf)
    points, index = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    return np.asarray((points @ normals.T - offsets).max(axis=1)[index.reshape(-1)].reshape(-1, 3))


def _quartered(triangles: Floats) -> Floats:
    """Each triangle (m, 3, 3) cut at the middles of its edges: (4 m, 3, 3)."""
    a, b, c = (triangles[:, k] for k in range(3))
    ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
    return np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])


def _extreme(points: Floats) -> Floats:
    """The extreme points of a hull."""
    return np.array(Polytope(points).vertices)


def _coacd(mesh: TriangleMesh, options: Decomposition, name: str) -> list[Floats]:
    """CoACD's pieces, from a process of its own, see coacd_worker.py."""
    if importlib.util.find_spec("coacd") is None:
        raise PlannercheckError("convex decomposition needs CoACD: pip install 'plannercheck[coacd]'")
    given = io.BytesIO()
    np.savez(
        given,
        points=mesh.points,
        triangles=mesh.triangles,
        threshold=options.threshold,
        most_pieces=options.most_pieces or -1,
        seed=options.seed,
        preprocess="off" if mesh.is_watertight else "auto",
    )
    ran = run_isolated("plannercheck.bodies.coacd_worker", content=given.getvalue())
    if ran.returncode:
        last = " ".join(ran.stderr.decode(errors="replace").split())[-300:]
        raise PlannercheckError(f"{name}: CoACD fails ({ran.returncode}): {last}")
    with np.load(io.BytesIO(ran.stdout)) as found:
        return [np.asarray(found[key], dtype=np.float64) for key in found.files]


def _cache_file(mesh: TriangleMesh, options: Decomposition) -> Path | None:
    folder = body_files.cache_folder()
    if folder is None:
        return None
    how = f"pieces {_VERSION} {options.threshold!r} {options.most_pieces} {options.slack!r} {options.seed}"
    key = hashlib.sha256(how.encode() + mesh.points.tobytes() + mesh.triangles.tobytes())
    return folder / f"{key.hexdigest()}.pieces"


def _packed(pieces: Pieces) -> bytes:
    volume = np.nan if pieces.mesh_volume is None else pieces.mesh_volume
    figures = np.array([pieces.excess, pieces.growth, volume, pieces.hull_volume, pieces.volume])
    content = io.BytesIO()
    np.savez(content, figures, *pieces.points)
    return content.getvalue()


def _unpacked(data: bytes) -> Pieces:
    with np.load(io.BytesIO(data)) as found:
        figures, *points = (found[key] for key in found.files)
    excess, growth, volume, hull, total = figures.tolist()
    return Pieces(tuple(points), excess, growth, None if np.isnan(volume) else volume, hull, total)
