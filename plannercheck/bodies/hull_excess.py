"""How much larger than its mesh a hull is, for fast warnings about hulls that were taken by default.

In: a mesh. Out: a sentence if the hull is more than twice as large as the closed mesh, or fills the room between
objects that are apart; else nothing. The hull of the farthest points along some directions is inside the hull,
so that its volume is a lower bound. Or the largest distance of the hull's surface from the mesh and its inside, at
points spread evenly over the surface.
"""

from __future__ import annotations

import numpy as np

from plannercheck.bodies.circumscribed import sphere_points
from plannercheck.bodies.core_polytopes import core_polytope
from plannercheck.bodies.distance import distance
from plannercheck.bodies.mesh_files import MeshFile
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.solids import Solid
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import distinct

# A hull is worth a warning from this multiple of its mesh's volume on: then more than half of it is free room.
LARGE = 2.0

# Directions along which farthest points are taken: the bound of a ball's volume is 9 % low then.
_DIRECTIONS = 64

_SPACE = 3  # dimensions of a body that has volume

# Points of a hull's surface whose distance from the mesh is measured.
_SURFACE_POINTS = 300


def excess_words(mesh: MeshFile) -> str:
    """Words on the hull of a mesh that holds much more than the mesh; empty if it does not."""
    return hull_between(mesh) or hull_excess(mesh.points, mesh.triangles)


def hull_excess(points: Floats, triangles: Ints64) -> str:
    """Words on the hull of points (n, 3), m, that is much larger than their closed mesh; empty if it is not."""
    volume = _enclosed(points, triangles)
    if np.prod(np.ptp(points, axis=0)) <= LARGE * volume:
        return ""
    hull = _least_hull_volume(points)
    if hull <= LARGE * volume or not volume or not TriangleMesh.of(points, triangles).volume:
        return ""
    return f"the hull is {hull / volume:.1f} times as large as the mesh"


def hull_between(mesh: MeshFile) -> str:
    """Words on objects of a file that are apart, whose common hull fills the room between them; empty if they meet."""
    if len(mesh.objects) < 2 or not _are_apart([each.points for each in mesh.objects]):
        return ""
    names = ", ".join(repr(each.name) for each in mesh.objects[:3])
    return f"its {len(mesh.objects)} objects ({names}) are apart, and the hull fills the room between them"


def _enclosed(points: Floats, triangles: Ints64) -> float:
    """The volume, m³, that the triangles enclose if they are closed."""
    a, b, c = (points[triangles[:, k]] - points[0] for k in range(3))
    return abs(float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum())) / 6


def _least_hull_volume(points: Floats) -> float:
    """A lower bound of the hull's volume, m³."""
    farthest = points[distinct((points @ sphere_points(_DIRECTIONS).T).argmax(axis=0))]
    hull = core_polytope(farthest)
    return _enclosed(farthest, hull.source()[hull.triangles()].astype(np.int64)) if hull.dimension == _SPACE else 0.0


def _are_apart(objects: list[Floats]) -> bool:
    """Whether the objects' boxes do not all hang together."""
    low, high = (np.array([side(each, axis=0) for each in objects]) for side in (np.min, np.max))
    meet = np.all((low[:, None] <= high[None]) & (low[None] <= high[:, None]), axis=2)
    reached = meet[0]
    for _ in objects:
        reached = np.any(meet[reached], axis=0)
    return not reached.all()


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
