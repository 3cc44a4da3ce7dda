"""Recipes of convex pieces: which triangles of a mesh make a piece together, without any of the mesh's geometry.

In: a mesh, and a piece's number for each of its triangles. Out: the pieces, each the hull of the corners of its
triangles. So a robot whose meshes must not be changed or passed on can come with pieces, which are made of the meshes
that the user has.

Every triangle has a piece, and a hull holds a triangle if it holds its corners, which are doubles of the mesh as they
are. So the union of the pieces holds every triangle exactly: nothing is rounded, and nothing is left to be tested. As
for any other pieces, nothing is claimed about what the mesh encloses.
"""

from __future__ import annotations

import json

import numpy as np

from plannercheck.bodies.pieces import Pieces, extreme, hull_volume
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.common.array_types import Floats, Ints64


def grouped(mesh: TriangleMesh, piece_of_triangle: Ints64) -> tuple[Floats, ...]:
    """The vertices of each piece, (n, 3) m.

    Args:
        mesh: The mesh.
        piece_of_triangle: (m,) the piece of each triangle, counted from 0; no number is left out.
    """
    corners = [mesh.triangles[piece_of_triangle == piece] for piece in range(int(piece_of_triangle.max()) + 1)]
    return tuple(extreme([mesh.points[np.unique(each)]]) for each in corners)


def recipe_text(piece_of_triangle: Ints64, protrusion: float, key: bytes) -> str:
    """The content of a recipe's file, JSON.

    Args:
        piece_of_triangle: As for `grouped`.
        protrusion: How far the pieces stick out of the mesh and what it encloses at most, m: a proved bound.
        key: The mesh's hash.
    """
    return json.dumps(
        {"mesh": key.hex(), "protrusion": protrusion, "piece_of_triangle": piece_of_triangle.tolist()}, indent=None
    )


def pieces_by_recipe(text: str, mesh: TriangleMesh, key: bytes) -> Pieces | None:
    """The pieces of a mesh with this hash by a recipe's file; None if the recipe is of another mesh."""
    recipe = json.loads(text)
    if recipe["mesh"] != key.hex():
        return None
    points = grouped(mesh, np.array(recipe["piece_of_triangle"], dtype=np.int64))
    volume = sum(map(hull_volume, points))
    return Pieces(points, 0.0, 0.0, recipe["protrusion"], mesh.volume, hull_volume(mesh.points), volume)
