"""Bodies for tests of the pair test: families of vertex sets and robots' meshes.

In: a family's name, a number of vertices, a seed. Out: points (n, 3) in metres, about 1 m across, whose
convex hull is the body. The families are those on which intersection tests differ: round and random ones,
flat and long ones, ones with few normals, ones with a vertex of large degree, and the hulls of real links.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.arrays import distinct_rows
from plannercheck.common.package_data import example_robot_data

Points = NDArray[np.float64]
Faces = NDArray[np.int64]

# Thickness over width of the flat family and over length of the needles.
FLATNESS = 1e-3
# Part of the distance to the hub that a vertex of the degree-doubling polyhedron keeps from one level to the
# next: small enough for convexity, large enough that the sagitta of the last level is far above rounding.
DOUBLING_SHRINK = 0.6


def round_body(n: int, rng: np.random.Generator) -> Points:
    """N points on a sphere, every one of them a vertex."""
    points = rng.normal(size=(n, 3))
    return np.asarray(0.5 * points / np.linalg.norm(points, axis=1)[:, None])


def cloud(n: int, rng: np.random.Generator) -> Points:
    """N points in a ball, of which a small part are vertices."""
    return round_body(n, rng) * rng.uniform(0, 1, size=(n, 1)) ** (1 / 3)


def box(n: int, rng: np.random.Generator) -> Points:
    """A box of random edges; n is always 8."""
    return rng.uniform(0.2, 1.0, 3) * (np.indices((2, 2, 2)).reshape(3, 8).T - 0.5)


def flat(n: int, rng: np.random.Generator) -> Points:
    """A round body pressed to a sheet."""
    return round_body(n, rng) * [1.0, 1.0, FLATNESS]


def needle(n: int, rng: np.random.Generator) -> Points:
    """A round body drawn to a needle."""
    return round_body(n, rng) * [1.0, FLATNESS, FLATNESS]


def prism(n: int, rng: np.random.Generator) -> Points:
    """A long prism over an n/2-gon: two facets of large degree."""
    rim = rim_points(n // 2, rng.uniform(0, 1)) * 0.1
    return np.concatenate([_raised(rim, -0.5), _raised(rim, 0.5)])


def cone(n: int, rng: np.random.Generator) -> Points:
    """A cone: an apex of degree n - 1 over one large facet."""
    return np.concatenate([_raised(0.5 * rim_points(n - 1, rng.uniform(0, 1)), -0.5), [[0.0, 0.0, 0.5]]])


def fan(n: int, rng: np.random.Generator) -> Points:
    """A hub joined to a bent arc of n - 1 points: large degree in a narrow solid angle."""
    angles = np.linspace(-0.5, 0.5, n - 1)
    arc = np.stack([np.cos(angles), np.sin(angles), 0.3 * angles**2], axis=1)
    return np.concatenate([arc - [0.5, 0, 0], [[-0.5, 0.0, 0.0]]])


def doubling(n: int, rng: np.random.Generator) -> Points:
    """The polyhedron of the paper whose hub doubles its degree from level to level, of at most n vertices."""
    return degree_doubling(int(np.log2(max(1, (n - 1) // 3))))[0]


def degree_doubling(levels: int) -> tuple[Points, Faces]:
    """The degree-doubling polyhedron with its faces (paper, section "Polyhedra in 3D space").

    A tetrahedron with the hub at the origin; each level adds a vertex slightly above each face at the hub.
    The neighbours of the hub lie on a circular cone, so a new one in the middle of two is always beyond
    their face.

    Args:
        levels: How often the hub's degree doubles; there are 1 + 3 · 2^levels vertices.

    Returns:
        Vertices (n, 3), the hub first, and outward triangles (m, 3).
    """
    ring = np.arange(1, 4)
    angles, distances = np.arange(3) / 3, np.ones(3)
    vertices = [np.zeros((1, 3)), _on_cone(angles, distances)]
    faces = [np.array([[1, 2, 3]])]
    for level in range(levels):
        new = np.arange(len(ring)) + 1 + len(ring)
        middle = angles + 0.5 / len(ring)
        vertices.append(_on_cone(middle, np.full(len(ring), DOUBLING_SHRINK ** (level + 1))))
        faces.append(np.stack([ring, new, np.roll(ring, -1)], axis=1))
        ring = np.stack([ring, new], axis=1).ravel()
        angles = np.stack([angles, middle], axis=1).ravel()
    faces.append(np.stack([np.zeros_like(ring), np.roll(ring, -1), ring], axis=1))
    return np.concatenate(vertices), np.concatenate(faces)


def lattice(n: int, rng: np.random.Generator) -> Points:
    """Points of a small lattice in a ball: many exactly coplanar, all coordinates short."""
    steps = 8 if n < 100 else 64
    points = np.round(round_body(n, rng) * steps) / steps
    return np.concatenate([distinct_rows(points)[0], [[0.5, 0, 0], [0, 0.5, 0], [0, 0, 0.5], [-0.5, 0, 0]]])


def rim_points(n: int, phase: float) -> Points:
    """N points on the unit circle, (n, 2), turned by `phase` of a step."""
    angles = 2 * np.pi * (np.arange(n) + phase) / n
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _on_cone(turns: Points, distances: Points) -> Points:
    angles = 2 * np.pi * turns
    return np.asarray(distances[:, None] * np.stack([np.cos(angles), np.sin(angles), np.ones_like(angles)], axis=1))


def _raised(plane: Points, height: float) -> Points:
    return np.column_stack([plane, np.full(len(plane), height)])


FAMILIES: dict[str, Callable[[int, np.random.Generator], Points]] = {
    "round": round_body,
    "cloud": cloud,
    "box": box,
    "flat": flat,
    "needle": needle,
    "prism": prism,
    "cone": cone,
    "fan": fan,
    "doubling": doubling,
    "lattice": lattice,
}


def plate(n: int, rng: np.random.Generator) -> Points:
    """A polygon of at most n corners in the plane z = 0: no volume."""
    return np.asarray(round_body(n, rng) * [1.0, rng.choice([1.0, FLATNESS]), 0.0])


def tilted_plate(n: int, rng: np.random.Generator) -> Points:
    """A polygon in the plane x + y + z = 0, exactly: all coordinates are short."""
    plane = np.round(rng.uniform(-0.5, 0.5, size=(n, 2)) * 64) / 64
    return np.column_stack([plane, -plane.sum(axis=1)])


def sliver(n: int, rng: np.random.Generator) -> Points:
    """A polygon in a random plane, as doubles round it: as thin as a body with volume can be."""
    first, second = round_body(2, rng)
    return np.asarray(rng.uniform(-1, 1, size=(n, 2)) @ np.stack([first, second]))


def segment(n: int, rng: np.random.Generator) -> Points:
    """A segment along z, or of random direction."""
    half = np.array([0, 0, 0.5]) if rng.integers(2) else round_body(1, rng)[0]
    return np.stack([-half, half])


def point(n: int, rng: np.random.Generator) -> Points:
    """A single point, at the origin or anywhere."""
    return np.asarray(rng.integers(2) * rng.uniform(-0.5, 0.5, size=(1, 3)))


# Without volume, or nearly; one that is inflated is a sphere, a capsule or a rounded plate.
THIN_FAMILIES: dict[str, Callable[[int, np.random.Generator], Points]] = {
    "plate": plate,
    "tilted plate": tilted_plate,
    "sliver": sliver,
    "segment": segment,
    "point": point,
}

# Links of three makers, as the collision meshes are shipped.
MESHES = (
    "panda_description/meshes/collision/link1.stl",
    "panda_description/meshes/collision/hand.stl",
    "panda_description/meshes/collision/finger.stl",
    "ur_description/meshes/ur5/collision/upperarm.stl",
    "ur_description/meshes/ur5/collision/wrist1.stl",
    "talos_data/meshes/gripper/fingertip_collision.STL",
)


def family(name: str, n: int, seed: int) -> Points:
    """The points (about n, 3) of a family in FAMILIES, about 1 m across; n is at least 8."""
    return FAMILIES[name](n, np.random.default_rng(seed))


@lru_cache
def mesh_points(name: str) -> Points:
    """The vertices (n, 3) of a robot's collision mesh, one of MESHES, as shipped, m."""
    import coal

    path = example_robot_data() / "example-robot-data" / "robots" / name
    return np.array(coal.MeshLoader().load(str(path), np.ones(3)).vertices())
