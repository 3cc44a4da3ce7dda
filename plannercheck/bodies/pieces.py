"""Convex pieces of a mesh: their vertices, figures of what they cover and add, and their bytes in files.

In: vertices of pieces and figures. Out: `Pieces`, and the same as bytes. A piece is the hull of its vertices.
"""

from __future__ import annotations

import hashlib
import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import OwnsArrays


@dataclass(frozen=True, eq=False)
class Pieces(OwnsArrays):
    """A decomposed mesh. Every triangle of it lies in the union of the pieces, exactly.

    Attributes:
        points: Vertices of each piece, (n, 3) m.
        excess: How far the mesh stuck out of CoACD's pieces at most, m: at corners of triangles, original and cut ones;
            0 for pieces by a recipe.
        growth: How far the repair made a piece grow at most, m; 0 for pieces by a recipe.
        protrusion: How far the pieces stick out of the mesh and what it encloses at most, m: a proved bound. The holes
            of an open mesh are filled for it.
        mesh_volume: The mesh's volume, m³; None unless the mesh is watertight.
        hull_volume: The volume of the mesh's hull, m³.
        volume: The sum of the volumes of all repaired pieces, m³; overlaps count several times.
    """

    points: tuple[Floats, ...]
    excess: float
    growth: float
    protrusion: float
    mesh_volume: float | None
    hull_volume: float
    volume: float


def hull_volume(points: Floats) -> float:
    """The volume of the convex hull of points (n, 3), m³."""
    return polytope_volume(Polytope(points))


def polytope_volume(polytope: Polytope) -> float:
    """The volume of a prepared body's hull, without its inflation radius, m³."""
    middle = polytope.vertices.mean(axis=0)
    a, b, c = (polytope.vertices[polytope.faces[:, k]] - middle for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def mesh_hash(mesh: TriangleMesh) -> bytes:
    """A hash of a mesh's content, the same on all machines."""
    points, triangles = mesh.points.astype("<f8") + 0.0, mesh.triangles.astype("<i8")
    return hashlib.sha256(points.tobytes() + triangles.tobytes()).digest()


def packed(pieces: Pieces, key: bytes = b"") -> bytes:
    """The content of a file of pieces, an npz, with the hash of their mesh."""
    volume = np.nan if pieces.mesh_volume is None else pieces.mesh_volume
    figures = [pieces.excess, pieces.growth, pieces.protrusion, volume, pieces.hull_volume, pieces.volume]
    content = io.BytesIO()
    np.savez_compressed(
        content,
        figures=np.array(figures, dtype="<f8"),
        counts=np.array([len(points) for points in pieces.points], dtype="<i8"),
        points=np.concatenate(pieces.points).astype("<f8"),
        mesh=np.frombuffer(key, dtype=np.uint8),
    )
    return content.getvalue()


def unpacked(data: bytes, key: bytes = b"") -> Pieces | None:
    """The pieces of a file's content; None if they are of another mesh."""
    with np.load(io.BytesIO(data)) as found:
        if found["mesh"].tobytes() != key:
            return None
        figures, counts = found["figures"].tolist(), found["counts"]
        points = np.split(found["points"].astype(np.float64), np.cumsum(counts)[:-1])
    excess, growth, protrusion, volume, hull, total = figures
    return Pieces(tuple(points), excess, growth, protrusion, None if np.isnan(volume) else volume, hull, total)


def extreme(points: Sequence[Floats]) -> Floats:
    """The vertices of the hull of points (n, 3), given in parts."""
    return np.array(Polytope(np.concatenate(points)).vertices)
