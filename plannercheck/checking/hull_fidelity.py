"""How far a hull is from its mesh.

In: a hull and its mesh. Out: the largest distance of the hull's surface from the mesh and its inside, at points spread
evenly over the surface.
"""

from __future__ import annotations

import numpy as np

from plannercheck.bodies.distance import distance
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.solids import Solid
from plannercheck.bodies.triangle_meshes import TriangleMesh

# Points of a hull's surface whose distance from the mesh is measured.
_SURFACE_POINTS = 300


def largest_filling(polytope: Polytope, mesh: TriangleMesh, seed: int = 0) -> float:
    """How far a hull's surface is from a mesh, or the triangles of an open one, at most, m, as random points show."""
    corners = polytope.vertices[np.asarray(polytope.faces)]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    generator = np.random.default_rng(seed)
    chosen = corners[generator.choice(len(corners), _SURFACE_POINTS, p=areas / areas.sum())]
    weights = generator.dirichlet(np.ones(3), _SURFACE_POINTS)
    solid = Polytope(mesh.points).of_solid(Solid(mesh.points, mesh.triangles, "triangles"))
    points = np.einsum("nk,nki->ni", weights, chosen)
    return max(distance(Polytope(each[None]), solid).distance for each in points)
