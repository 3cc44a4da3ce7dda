"""Poses that put two convex bodies at a given gap, a feature of one over a feature of the other.

In: two bodies with outward triangles, a number of poses, gaps in metres. Out: poses (k, 4, 4) for both.

The idea: choose a vertex, edge or facet of each with a direction in its normal cone, turn the bodies so that
the two directions are opposite, spin about them at random, and lay a point of one feature over a point of
the other. Then the plane between the features separates the bodies exactly by the gap (up to the rounding of
the pose); below zero they overlap by at most that much.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
Faces = NDArray[np.int64]

VERTEX, EDGE, FACET = range(3)


@dataclass(frozen=True, eq=False)
class Solid:
    """A convex body whose features can be laid upon each other.

    Attributes:
        name: Name of the body, e.g. "cone 100".
        vertices: Hull vertices, (n, 3), m.
        faces: Outward triangles, (m, 3) indices.
    """

    name: str
    vertices: Points
    faces: Faces

    @cached_property
    def normals(self) -> Points:
        """Unit outward normals of the triangles, (m, 3)."""
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        lengths = np.linalg.norm(normals, axis=1)[:, None]
        return np.asarray(np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0))

    @cached_property
    def across(self) -> Faces:
        """The triangle beyond each triangle's edge from corner k to corner k + 1, (m, 3)."""
        n = len(self.vertices)
        forward = self.faces * n + np.roll(self.faces, -1, axis=1)
        backward = np.roll(self.faces, -1, axis=1) * n + self.faces
        order = np.argsort(forward.ravel())
        found = order[np.searchsorted(forward.ravel(), backward.ravel(), sorter=order)]
        return found.reshape(-1, 3) // 3

    @cached_property
    def vertex_normals(self) -> Points:
        """A direction strictly inside each vertex's normal cone, (n, 3), not normalised."""
        sums = np.zeros_like(self.vertices)
        np.add.at(sums, self.faces.ravel(), np.repeat(self.normals, 3, axis=0))
        return sums

    @cached_property
    def size(self) -> float:
        """The longest edge of the axis-aligned box, m."""
        return float(np.ptp(self.vertices, axis=0).max())


def contact_poses(p: Solid, r: Solid, gaps: Points, rng: np.random.Generator) -> tuple[Points, Points]:
    """Poses (k, 4, 4) of p and of r at gaps (k,), m, of random features and directions; below 0 the bodies overlap.

    The second body is up to 1 m away from the origin.
    """
    k = len(gaps)
    point_p, normal_p = random_features(p, k, rng)
    point_r, normal_r = random_features(r, k, rng)
    direction = random_directions(k, rng)
    pose_p, pose_r = identities(k), identities(k)
    pose_p[:, :3, :3] = turns_onto(normal_p, -direction, rng)
    pose_r[:, :3, :3] = turns_onto(normal_r, direction, rng)
    pose_r[:, :3, 3] = rng.uniform(-1, 1, size=(k, 3))
    touch = pose_r[:, :3, 3] + turned(pose_r, point_r)
    pose_p[:, :3, 3] = touch + gaps[:, None] * direction - turned(pose_p, point_p)
    return pose_p, pose_r


def quarter_turns(k: int, rng: np.random.Generator) -> Points:
    """Rotations (k, 3, 3) that permute the axes."""
    turns = np.eye(3)[rng.permuted(np.tile(np.arange(3), (k, 1)), axis=1)] * rng.choice([-1, 1], (k, 3, 1))
    turns[np.linalg.det(turns) < 0, 0] *= -1
    return np.asarray(turns)


def random_features(solid: Solid, k: int, rng: np.random.Generator) -> tuple[Points, Points]:
    """Points (k, 3) on random vertices, edges and facets; unit directions (k, 3) in their normal cones."""
    face = rng.choice(np.flatnonzero(np.any(solid.normals != 0, axis=1)), k)
    kind = rng.integers(0, 3, k)
    weights = rng.dirichlet(np.ones(3), k)
    weights[kind == VERTEX] = [1, 0, 0]
    weights[kind == EDGE, 2] = 0
    weights /= weights.sum(axis=1)[:, None]
    corners = solid.faces[face]
    points = np.einsum("kc,kcx->kx", weights, solid.vertices[corners])
    lean = rng.uniform(0, 1, size=(k, 1))
    at_vertex = lean * solid.normals[face] + (1 - lean) * unit(solid.vertex_normals[corners[:, 0]])
    at_edge = lean * solid.normals[face] + (1 - lean) * solid.normals[solid.across[face, 0]]
    by_kind = np.stack([at_vertex, at_edge, solid.normals[face]])
    return points, unit(by_kind[kind, np.arange(k)])


def random_directions(k: int, rng: np.random.Generator) -> Points:
    """Unit vectors, (k, 3)."""
    return unit(rng.normal(size=(k, 3)))


def turns_onto(source: Points, target: Points, rng: np.random.Generator) -> Points:
    """Rotations (k, 3, 3) that take unit vectors (k, 3) to others, spun at random about the target."""
    spin = rng.uniform(0, 2 * np.pi, len(source))
    cos, sin, zero, one = np.cos(spin), np.sin(spin), np.zeros_like(spin), np.ones_like(spin)
    about = np.stack([cos, -sin, zero, sin, cos, zero, zero, zero, one], axis=1).reshape(-1, 3, 3)
    turns: Points = frames(target) @ about @ np.swapaxes(frames(source), 1, 2)
    return turns


def frames(axis: Points) -> Points:
    """Rotations (k, 3, 3) whose third column is a unit vector."""
    away = np.eye(3)[np.argmin(np.abs(axis), axis=1)]
    first = unit(np.cross(away, axis))
    return np.stack([first, np.cross(axis, first), axis], axis=2)


def identities(k: int) -> Points:
    """K identity poses, (k, 4, 4)."""
    return np.tile(np.eye(4), (k, 1, 1))


def turned(poses: Points, points: Points) -> Points:
    """Points (k, 3) or (3,) under the rotations of poses."""
    return np.asarray(np.einsum("kij,kj->ki", poses[:, :3, :3], np.broadcast_to(points, (len(poses), 3))))


def unit(vectors: Points) -> Points:
    """Vectors (k, 3) of length 1."""
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1)[:, None])
