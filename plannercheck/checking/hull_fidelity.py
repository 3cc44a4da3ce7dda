"""How far hulls are from the meshes they stand for, and how many states only their filling refuses.

In: a checker, the meshes of its bodies as they are in their files. Out: for each body the volumes and the largest
distance; of random states, how many collide as hulls but not as meshes. Meshes are coal's triangles against triangles,
without a proof: surfaces that intersect. A mesh that lies wholly within another one does not count as a collision.
Solids fill nothing: a pair counts only if the hull of a mesh is in it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import coal
import numpy as np

from plannercheck.bodies.coal_bodies import coal_mesh
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import Box, Capsule, GeometryObject, Hull, Sphere
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.checking.state_checker import StateChecker
from plannercheck.common.array_types import Bools, Floats

Meshes = Mapping[str, TriangleMesh]

# Points of a hull's surface whose distance from the mesh is measured.
_SURFACE_POINTS = 300

# States whose colliding pairs and poses are held at once.
_BLOCK = 256


@dataclass(frozen=True)
class FillingCount:
    """What hulls refuse of a set of states.

    Attributes:
        states: Number of configurations that were judged.
        refused: Those in which some hulls collide.
        only_filling: Those of them in which no meshes intersect.
    """

    states: int
    refused: int
    only_filling: int


def refused_by_filling(checker: StateChecker, meshes: Meshes, q: Floats) -> FillingCount:
    """Counts the states that only the hulls' filling refuses.

    Args:
        checker: Its verdicts are of hulls.
        meshes: Meshes of bodies as they are in their files, by the body's name; other bodies are what they are.
        q: (n, nq) rad and m.
    """
    refused = q[~checker.check_states(q)]
    shapes = _Shapes(checker, meshes)
    filling = 0
    for first in range(0, len(refused), _BLOCK):
        rows = refused[first : first + _BLOCK]
        colliding, poses = checker.colliding_pairs(rows), checker.body_poses(rows)
        filling += sum(not shapes.meet(*state) for state in zip(colliding, poses, strict=True))
    return FillingCount(len(q), len(refused), filling)


class _Shapes:
    """The bodies of a checker for coal, made when they are first met."""

    def __init__(self, checker: StateChecker, meshes: Meshes) -> None:
        self._checker, self._meshes = checker, meshes
        self._made: dict[int, coal.CollisionGeometry] = {}

    def meet(self, colliding: Bools, poses: Floats) -> bool:
        """Whether the surfaces of any of the pairs (k,) intersect at poses (bodies, 4, 4)."""
        pairs = self._checker.pairs[colliding].tolist()
        return any(
            not (self._is_filled(a) or self._is_filled(b))
            or _intersect(self._shape(a), poses[a], self._shape(b), poses[b])
            for a, b in pairs
        )

    def _is_filled(self, index: int) -> bool:
        """Whether a body is the hull of a mesh."""
        body = self._checker.bodies[index]
        return body.name in self._meshes and isinstance(body.shape, Hull)

    def _shape(self, index: int) -> coal.CollisionGeometry:
        if index not in self._made:
            body = self._checker.bodies[index]
            mesh = self._meshes.get(body.name)
            if mesh is None:
                self._made[index] = _own_shape(body, self._checker.polytopes[index])
            else:
                self._made[index] = coal_mesh(mesh.points, mesh.triangles)
        return self._made[index]


def _own_shape(body: GeometryObject, polytope: Polytope | None) -> coal.CollisionGeometry:
    """A body that is no mesh; round ones as coal has them, all others by the triangles of their hull."""
    match body.shape:
        case Box():
            return coal.Box(*body.shape.size)
        case Sphere():
            return coal.Sphere(body.shape.radius)
        case Capsule():
            return coal.Capsule(body.shape.radius, body.shape.length)
    assert polytope is not None  # a pair of it collides
    return coal_mesh(polytope.vertices, polytope.faces)


def _intersect(a: coal.CollisionGeometry, pose_a: Floats, b: coal.CollisionGeometry, pose_b: Floats) -> bool:
    transforms = [coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in (pose_a, pose_b)]
    return bool(coal.collide(a, transforms[0], b, transforms[1], coal.CollisionRequest(), coal.CollisionResult()))


def largest_filling(polytope: Polytope, mesh: TriangleMesh, seed: int = 0) -> float:
    """How far a hull's surface is from the mesh at most, m, as far as points spread evenly over it show.

    Args:
        polytope: The hull.
        mesh: In the hull's frame.
        seed: Seed of the points.
    """
    corners = polytope.vertices[np.asarray(polytope.faces)]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    generator = np.random.default_rng(seed)
    chosen = corners[generator.choice(len(corners), _SURFACE_POINTS, p=areas / areas.sum())]
    weights = generator.dirichlet(np.ones(3), _SURFACE_POINTS)
    model = coal_mesh(mesh.points, mesh.triangles)
    point, here = coal.Sphere(0.0), coal.Transform3s()
    points = np.einsum("nk,nki->ni", weights, chosen)
    places = (coal.Transform3s(np.eye(3), each) for each in points)
    request = coal.DistanceRequest()
    return max(float(coal.distance(model, here, point, place, request, coal.DistanceResult())) for place in places)
