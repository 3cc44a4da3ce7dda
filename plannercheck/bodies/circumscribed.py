"""Polytopes around circles and balls, which stand for curved shapes.

In: a radius and an excess, the part of the radius by which points may stick out. Out: points and faces of a polygon or
polytope that contains the circle or ball; faces of prisms and capsules made from these; and their flat forms if the
radius or the length is 0.

A circle gets a regular polygon whose edges touch it. A ball gets an octahedron whose edges are divided in equal steps
of angle. Its points are projected to a sphere, which is then enlarged until no face cuts the ball. Such triangles are
nearly regular, so the surface is convex with room to spare; the tests check it exactly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.arrays import distinct_values
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.real_numbers import positive_number

# Relative growth that covers the rounding of the points (under 8 units in the last place, 2^-49).
ROUNDING_MARGIN = 2.0**-48

# Corners (8, 3) of a cube from -1 to 1, as `prism_faces(4)` refers to them.
BOX_SIGNS = np.array([[x, y, z] for z in (-1.0, 1.0) for x, y in ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))])
BOX_SIGNS.setflags(write=False)

# The least excess of a ball: 500 divisions of an octahedron's edge, a million points, stick out by less.
LEAST_BALL_EXCESS = 4e-6


def checked_excess(excess: float) -> float:
    """An excess that can be met, or an error."""
    wanted = "excess must be within (0, 1], a part of the radius"
    if not 4 * ROUNDING_MARGIN < (number := positive_number(excess, wanted)) <= 1:
        raise PlannercheckError(f"{wanted}, not {excess}")
    return number


def check_ball_excess(excess: float) -> None:
    """Raises if a polytope around a ball can't stick out by so little."""
    if excess < LEAST_BALL_EXCESS:
        raise PlannercheckError(
            f"excess {excess:g} needs about a million points around a ball, or more: give {LEAST_BALL_EXCESS:g} or more"
        )


def segment(length: float) -> NDArray[np.float64]:
    """The ends of a segment along z about the origin: two points, or one of length 0."""
    return np.array([[0, 0, -length / 2], [0, 0, length / 2]]) if length else np.zeros((1, 3))


def without_volume(ring: NDArray[np.float64], length: float) -> NDArray[np.float64]:
    """The points of a cylinder or cone of radius 0 (a segment) or of length 0 (the polygon of this ring (k, 2))."""
    return np.column_stack([ring, np.zeros(len(ring))]) if ring.any() else segment(length)


def sphere_points(count: int) -> NDArray[np.float64]:
    """(count, 3) unit vectors spread evenly, on a spiral."""
    number = np.arange(count)
    height = 1 - (2 * number + 1) / count
    angle, radius = np.pi * (3 - np.sqrt(5)) * number, np.sqrt(1 - height**2)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])


def ring_around(radius: float, excess: float) -> NDArray[np.float64]:
    """Corners (k, 2) of a regular polygon around a circle, counter-clockwise, k a multiple of 4."""
    smallest = math.pi / math.acos((1 + 2 * ROUNDING_MARGIN) / (1 + excess))
    k = 4 * math.ceil(smallest / 4)
    angles = 2 * math.pi * np.arange(k) / k
    corner_radius = radius / math.cos(math.pi / k) * (1 + ROUNDING_MARGIN)
    return corner_radius * np.column_stack([np.cos(angles), np.sin(angles)])


@dataclass(frozen=True)
class Ball:
    """A polytope around the unit ball, its faces touching or just outside it.

    Attributes:
        lattice: (n, 3) integer coordinates on the octahedron |x| + |y| + |z| = divisions.
        points: (n, 3), all at the same distance from the centre.
        triangles: (8 divisions^2, 3) indices, counter-clockwise from outside.
    """

    lattice: NDArray[np.int64]
    points: NDArray[np.float64]
    triangles: NDArray[np.int64]


@lru_cache(maxsize=4)
def unit_ball(divisions: int) -> Ball:
    """An octahedron divided in equal steps of angle, blown up around the unit ball."""
    lattice, triangles = _unique_corners(_octahedron_corners(divisions), divisions)
    directions = np.sin(lattice * (math.pi / 2 / divisions))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    points = directions * ((1 + ROUNDING_MARGIN) / _inner_radius(directions, triangles))
    for array in (lattice, points, triangles):
        array.setflags(write=False)
    return Ball(lattice, points, triangles)


def _octahedron_corners(divisions: int) -> NDArray[np.int64]:
    """Integer corners (8 divisions^2, 3, 3) of a divided octahedron, counter-clockwise from outside."""
    i, j = np.meshgrid(np.arange(divisions), np.arange(divisions), indexing="ij")
    upright = np.column_stack([i[i + j < divisions], j[i + j < divisions]])
    inverted = np.column_stack([i[i + j < divisions - 1], j[i + j < divisions - 1]])
    cells = np.concatenate([upright[:, None] + [[1, 0], [0, 1], [0, 0]], inverted[:, None] + [[1, 0], [1, 1], [0, 1]]])
    octant = np.concatenate([cells, divisions - cells.sum(axis=2, keepdims=True)], axis=2)
    signs = [np.array([x, y, z]) for x in (1, -1) for y in (1, -1) for z in (1, -1)]
    return np.concatenate([(octant if s.prod() > 0 else octant[:, ::-1]) * s for s in signs])


def _unique_corners(corners: NDArray[np.int64], divisions: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Different corners (n, 3), in lexicographic order, and which of them each triangle (m, 3) has.

    Each is compared as one number: a million rows take six times as long.
    """
    span = 2 * divisions + 1
    digits = corners.reshape(-1, 3) + divisions
    numbers, inverse = distinct_values((digits[:, 0] * span + digits[:, 1]) * span + digits[:, 2])
    lattice = np.column_stack([numbers // span**2, numbers // span % span, numbers % span]) - divisions
    return lattice, inverse.reshape(-1, 3).astype(np.int64)


def _inner_radius(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> float:
    """Distance from the origin to the nearest triangle's plane."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    distances = np.einsum("ij,ij->i", normals, a) / np.linalg.norm(normals, axis=1)
    return float(distances.min())


@lru_cache(maxsize=16)
def ball_around(excess: float) -> Ball:
    """The polytope of fewest points around the unit ball that sticks out by at most `excess`."""
    check_ball_excess(excess)
    # The widest triangles, amid an octant, have a circumradius of nearly pi / (divisions * sqrt(6)) rad.
    divisions = max(1, math.floor(math.pi / math.sqrt(6) / math.acos(1 / (1 + excess))) - 1)
    while True:
        ball = unit_ball(divisions)
        if np.linalg.norm(ball.points, axis=1).max() <= 1 + excess:
            return ball
        divisions += 1


def capsule_faces(ball: Ball, upper: NDArray[np.int64], lower: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """A ball's triangles, renumbered for points [upper, lower], with a quadrilateral at each equator edge."""
    top, bottom = np.full(len(ball.points), -1), np.full(len(ball.points), -1)
    top[upper], bottom[lower] = np.arange(len(upper)), len(upper) + np.arange(len(lower))
    is_upper = (ball.lattice[ball.triangles, 2] >= 0).all(axis=1)
    caps = [*top[ball.triangles[is_upper]], *bottom[ball.triangles[~is_upper]]]
    equator = np.flatnonzero(ball.lattice[:, 2] == 0)
    ring = equator[np.argsort(np.arctan2(ball.points[equator, 1], ball.points[equator, 0]))]
    after = np.roll(ring, -1)
    return [*caps, *np.column_stack([bottom[ring], bottom[after], top[after], top[ring]])]


def prism_faces(k: int) -> list[NDArray[np.int64]]:
    """Faces of a prism: points 0 to k - 1 are the lower polygon, counter-clockwise from above."""
    return list(_read_only_prism_faces(k))


@lru_cache(maxsize=16)
def _read_only_prism_faces(k: int) -> tuple[NDArray[np.int64], ...]:
    low = np.arange(k)
    following = np.roll(low, -1)
    faces = low[::-1].copy(), low + k, *np.column_stack([low, following, following + k, low + k])
    for face in faces:
        face.setflags(write=False)
    return faces
