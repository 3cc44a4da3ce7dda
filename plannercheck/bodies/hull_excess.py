"""How much larger than its mesh a hull is, for fast warnings about hulls that were taken by default.

In: a mesh. Out: a sentence if the hull is more than twice as large as the closed mesh, or fills the room between
objects that are apart; else nothing. The hull of the farthest points along some directions is inside the hull,
so that its volume is a lower bound.
"""

from __future__ import annotations

import numpy as np

from plannercheck.bodies.core_polytopes import core_polytope
from plannercheck.bodies.mesh_files import MeshFile
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import distinct

# A hull is worth a warning from this multiple of its mesh's volume on: then more than half of it is free room.
LARGE = 2.0

# Directions along which farthest points are taken: the bound of a ball's volume is 9 % low then.
_DIRECTIONS = 64

_SPACE = 3  # dimensions of a body that has volume


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
    number = np.arange(_DIRECTIONS)
    height = 1 - (2 * number + 1) / _DIRECTIONS
    angle, radius = np.pi * (3 - np.sqrt(5)) * number, np.sqrt(1 - height**2)
    directions = np.stack([radius * np.cos(angle), radius * np.sin(angle), height])
    farthest = points[distinct((points @ directions).argmax(axis=0))]
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
