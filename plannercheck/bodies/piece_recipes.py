"""Recipes of convex pieces: which triangles of a mesh make a piece together, without any of the mesh's geometry.

In: a mesh, and a piece's number for each of its triangles. Out: the pieces, each the hull of the corners of its
triangles. So plannercheck can ship pieces for a robot whose meshes must not be changed or passed on: they are made of
the user's meshes.

Every triangle has a piece, and a hull holds a triangle if it holds its corners, which are doubles of the mesh as they
are. So the union of the pieces holds every triangle exactly, without rounding or a test. How far the pieces stick out
is proved when a recipe is made, and stays true: the mesh's hash says that it is the same mesh, and hulls are exact.
"""

from __future__ import annotations

import json

import numpy as np

from plannercheck.bodies.pieces import Pieces, hull_volume, mesh_hash, polytope_volume
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.protrusion import protrusion
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.common.array_types import Ints64
from plannercheck.common.arrays import distinct


def grouped(mesh: TriangleMesh, piece_of_triangle: Ints64) -> list[Polytope]:
    """The pieces of a mesh by the piece (m,) of each of its triangles, counted from 0; no number is left out."""
    of_piece = [mesh.triangles[piece_of_triangle == piece] for piece in range(int(piece_of_triangle.max()) + 1)]
    return [Polytope(mesh.points[distinct(triangles)]) for triangles in of_piece]


def recipe_text(mesh: TriangleMesh, piece_of_triangle: Ints64) -> str:
    """The content of a recipe's file, JSON, with the mesh's hash and the proved bound of how far pieces stick out."""
    bound = protrusion([piece.vertices for piece in grouped(mesh, piece_of_triangle)], mesh)
    recipe = {"mesh": mesh_hash(mesh).hex(), "protrusion": bound, "piece_of_triangle": piece_of_triangle.tolist()}
    return json.dumps(recipe)


def pieces_by_recipe(text: str, mesh: TriangleMesh, key: bytes) -> Pieces | None:
    """The pieces of a mesh with this hash by a recipe's file; None if the recipe is of another mesh."""
    recipe = json.loads(text)
    if recipe["mesh"] != key.hex():
        return None
    pieces = grouped(mesh, np.array(recipe["piece_of_triangle"], dtype=np.int64))
    points, volume = tuple(np.array(piece.vertices) for piece in pieces), sum(map(polytope_volume, pieces))
    hull = volume if len(pieces) == 1 else hull_volume(mesh.points)
    return Pieces(points, 0.0, 0.0, recipe["protrusion"], mesh.volume, hull, volume)
