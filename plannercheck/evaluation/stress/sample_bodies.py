"""Prepared bodies to be put in contact, with points on their boundary and outward directions there.

In: a family, a number of vertices, a size, an inflation radius. Out: a `Specimen`, of any dimension.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.polytope import Polytope
from plannercheck.evaluation.stress.body_families import FAMILIES, MESHES, THIN_FAMILIES, mesh_points
from plannercheck.evaluation.stress.contact_poses import Points, random_directions, unit

Indices = NDArray[np.int64]

# Families of hulls, and inflated ones: the family that is inflated, and the inflation radius over the size.
HULLS = (*FAMILIES, "mesh", *THIN_FAMILIES)
INFLATED: dict[str, tuple[str, float]] = {
    "sphere": ("point", 0.5),
    "capsule": ("segment", 0.1),
    "rounded plate": ("plate", 0.01),
    "rounded box": ("box", 0.1),
    "rounded hull": ("round", 1e-6),
}
# How a feature is chosen: the vertex extreme along a random direction, or a corner, an edge or the inside of a facet.
_EXTREME, _CORNER, _EDGE = range(3)
_KINDS = 4


@dataclass(frozen=True, eq=False)
class Specimen:
    """A body.

    Attributes:
        family: One of HULLS or INFLATED, or what else it is.
        points: Points of which it is the hull, (n, 3), m.
        inflation_radius: All points within this distance of the hull belong to the body, m.
    """

    family: str
    points: Points
    inflation_radius: float = 0.0

    @cached_property
    def polytope(self) -> Polytope:
        """The body prepared for queries."""
        return Polytope(self.points, inflation_radius=self.inflation_radius, name=self.family)

    @cached_property
    def size(self) -> float:
        """Its greatest extent along an axis, inflation radius included, m; of a point 1."""
        extent = float(np.ptp(self.vertices, axis=0).max()) + 2 * self.inflation_radius
        return extent if extent > 0 else 1.0

    @property
    def parts(self) -> int:
        """Points, of which a smaller body has some."""
        return len(self.points)

    def some(self, rows: list[int]) -> Specimen:
        """The hull of some of the points."""
        return replace(self, points=self.points[rows])

    def document(self) -> dict[str, Any]:
        """Its numbers."""
        return {"family": self.family, "points": self.points, "inflation_radius": self.inflation_radius}

    @property
    def vertices(self) -> Points:
        """Of the hull, (n, 3), m."""
        return self.polytope.vertices

    def support(self, directions: Points) -> Points:
        """The hull's vertex that is about furthest along each direction (k, 3); (k, 3), m."""
        return np.asarray(self.vertices[np.argmax(directions @ self.vertices.T, axis=1)])

    def features(self, k: int, rng: np.random.Generator) -> tuple[Points, Points]:
        """Points (k, 3) of the hull's border, m, and unit directions (k, 3) along which they are about extreme."""
        directions = random_directions(k, rng)
        points = self.support(directions)
        kinds = rng.integers(0, _KINDS, k)
        facing = np.flatnonzero(kinds != _EXTREME)
        if self.polytope.dimension > 0 and len(facing):
            weights = _weights(kinds[facing], rng)
            corners, normals = self._facets(len(facing), rng)
            points[facing] = np.einsum("kc,kcx->kx", weights, corners)
            directions[facing] = normals
        return points, directions

    def _facets(self, k: int, rng: np.random.Generator) -> tuple[Points, Points]:
        """Corners (k, 3, 3) of random facets, and their unit outward normals (k, 3)."""
        if self.polytope.dimension == 3:
            corners = self.vertices[self._sound_faces[rng.integers(0, len(self._sound_faces), k)]]
            return corners, unit(_normals(corners))
        chosen = rng.permuted(np.tile(np.arange(len(self.vertices)), (k, 1)), axis=1)
        if self.polytope.dimension == 1:
            along = self.vertices[1] - self.vertices[0]
            return self.vertices[np.pad(chosen, ((0, 0), (0, 1)), mode="edge")], unit(
                np.cross(along / np.abs(along).max(), random_directions(k, rng))
            )
        return self.vertices[chosen[:, :3]], rng.choice([-1.0, 1.0], (k, 1)) * self._plane_normal

    @cached_property
    def _sound_faces(self) -> NDArray[np.int32]:
        """Triangles that doubles can tell a normal of."""
        faces = self.polytope.faces
        sound = faces[np.any(_normals(self.vertices[faces]) != 0, axis=1)]
        return sound if len(sound) else faces[:1]

    @cached_property
    def _plane_normal(self) -> Points:
        arms = (self.vertices - self.vertices[0]) / self.size
        return np.asarray(np.linalg.svd(arms)[2][2])


def _normals(corners: Points) -> Points:
    """Normals (k, 3) of triangles (k, 3, 3), not normalised but of a size that does not underflow."""
    arms = corners[:, 1:] - corners[:, :1]
    longest = np.abs(arms).max(axis=(1, 2), keepdims=True)
    arms = arms / np.where(longest > 0, longest, 1)
    normals = np.cross(arms[:, 0], arms[:, 1])
    largest = np.abs(normals).max(axis=1, keepdims=True)
    return np.asarray(normals / np.where(largest > 0, largest, 1))


def _weights(kinds: Indices, rng: np.random.Generator) -> Points:
    weights = rng.dirichlet(np.ones(3), len(kinds))
    weights[kinds == _CORNER] = [1, 0, 0]
    weights[kinds == _EDGE, 2] = 0
    return np.asarray(weights / weights.sum(axis=1)[:, None])


def specimen(family: str, n: int, size: float, rng: np.random.Generator) -> Specimen:
    """A random body of a family in HULLS or INFLATED: of about n points, at least 8, and about this size, m."""
    base, inflation_radius = INFLATED.get(family, (family, 0.0))
    return prepared(family, base_points(base, n, rng) * size, inflation_radius * size)


def base_points(family: str, n: int, rng: np.random.Generator) -> Points:
    """Points (about n, 3) of one of HULLS, about 1 m across."""
    if family == "mesh":
        return mesh_hull(MESHES[int(rng.integers(len(MESHES)))])
    return (FAMILIES.get(family) or THIN_FAMILIES[family])(n, rng)


def prepared(family: str, points: Points, inflation_radius: float = 0.0) -> Specimen:
    """The specimen of points (n, 3), m; PlannercheckError if they are no body."""
    found = Specimen(family, points, inflation_radius)
    _ = found.polytope
    return found


def specimen_of(document: dict[str, Any]) -> Specimen:
    """The body of a document."""
    points = np.array(document["points"], dtype=np.float64).reshape(-1, 3)
    return Specimen(str(document["family"]), points, float(document["inflation_radius"]))


@lru_cache
def mesh_hull(name: str) -> Points:
    """The hull vertices of a robot's mesh, about 1 m across."""
    points = mesh_points(name)
    return np.asarray(Polytope(points / np.ptp(points, axis=0).max()).vertices)
