"""Contact by construction: a state is chosen first, then a body is placed where it touches the robot at that state.

In: a posed robot, a shape, a depth. Out: a pose of the shape at which it overlaps a body of the robot at that state by
the depth, or misses it by as much; and the contact's point and normal, so that motions can go along the contact as well
as across it.

A vertex of one body, moved towards the middle of the other by the depth, is a point of both, by convexity. A gap is
kept along the normal that supports both.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from plannercheck.bodies.shapes import Shape, inflated_hull
from plannercheck.common.array_types import Floats
from plannercheck.evaluation.stress.contact_poses import random_directions, turns_onto
from plannercheck.evaluation.stress_motions.recipes import shape_of

# Widths of gaps, m, as powers of ten.
_GAPS = (-3.9, -0.5)
# Vertices of a facet are level, corners equally far away, up to this part.
_FLAT = 1e-12
# Shapes: this many in six touch, the others miss.
_TOUCHING = 4 / 6


class Closeness(NamedTuple):
    """How bodies are laid upon each other.

    Attributes:
        depths: Depths of contacts, m, least and largest power of ten.
        on_facets: Share of contacts on a facet of a box.
        at_corners: Share of contacts at corners that are as far out as the bodies reach, where the balls around both
            only just meet. All others are at any vertex.
    """

    depths: tuple[float, float]
    on_facets: float
    at_corners: float


USUAL = Closeness((-6.0, -2.0), 0.3, 0.15)
# For lengths off unit, which are worth less than a micrometre each and show where bodies reach furthest.
SHARP = Closeness((-9.0, -6.0), 0.1, 0.8)


@dataclass(frozen=True, eq=False)
class Extent:
    """A shape as all that is within the inflation radius of the hull of vertices (n, 3), m."""

    vertices: Floats
    inflation_radius: float

    def furthest(self, direction: Floats, rng: np.random.Generator | None = None) -> Floats:
        """The vertex (3,) that is furthest along a unit direction; any point of a facet, if one is."""
        along = self.vertices @ direction
        vertex = self.vertices[int(np.argmax(along))]
        if rng is not None:
            facet = self.vertices[along >= along.max() - _FLAT * (1 + np.abs(along).max())]
            vertex = rng.dirichlet(np.ones(len(facet))) @ facet
        return np.asarray(vertex)

    def outward(self, rng: np.random.Generator) -> Floats:
        """A unit direction (3,) from the middle of the box around it to a vertex as far away as any; any of a ball."""
        rays = self.vertices - (self.vertices.min(axis=0) + self.vertices.max(axis=0)) / 2
        lengths = np.linalg.norm(rays, axis=1)
        if lengths.max() == 0:
            return np.asarray(random_directions(1, rng)[0])
        k = int(rng.choice(np.flatnonzero(lengths >= lengths.max() * (1 - _FLAT))))
        return np.asarray(rays[k] / lengths[k])


def extent_of(shape: Shape) -> Extent:
    """The extent of a shape as checkers take it."""
    vertices, _, inflation_radius = inflated_hull(shape)
    return Extent(np.asarray(vertices), float(inflation_radius))


def random_shape(rng: np.random.Generator, large: bool = False) -> list[Any]:
    """A shape's recipe: boxes, balls, thin walls, needles, bodies of 1 mm, hulls; or large boxes."""
    if large:
        return ["box", [_size(rng, -1, 1) for _ in range(3)]]
    kind = rng.integers(8)
    if kind == 0:
        return ["sphere", _size(rng, -3, -0.7)]
    if kind == 1:
        return ["capsule", _size(rng, -3, -1), _size(rng, -2, 0)]
    if kind == 2:
        return ["hull", (rng.normal(size=(int(rng.integers(4, 12)), 3)) * _size(rng, -3, -0.7)).tolist()]
    if kind == 3:
        return ["box", [1e-3, 1e-3, 1e-3]]
    if kind == 4:
        return ["box", [_size(rng, -4, -3), _size(rng, -4, -3), _size(rng, -1, 0)]]
    if kind == 5:
        return ["box", [_size(rng, -4.5, -2), *rng.uniform(0.05, 1.0, 2).tolist()]]
    return ["box", [_size(rng, -2.5, -0.5) for _ in range(3)]]


def _size(rng: np.random.Generator, least: float, largest: float) -> float:
    return float(10.0 ** rng.uniform(least, largest))


@dataclass(frozen=True, eq=False)
class Contact:
    """Where a shape touches a body of the robot, or just misses it.

    Attributes:
        pose: (4, 4) of the shape in the world at the chosen state, m.
        foot: (3,) the vertex of the shape, in its own frame, whose ball is laid upon the body.
        point: (3,) of the body, in the world.
        normal: (3,) out of the body there.
        touches: Whether they share a point.
    """

    pose: Floats
    foot: Floats
    point: Floats
    normal: Floats
    touches: bool

    def pose_on(self, link: Floats) -> Floats:
        """(4, 4) of the shape on a link at a pose (4, 4), which may be a little off rigid: the foot stays put."""
        foot = self.pose[:3, :3] @ self.foot + self.pose[:3, 3]  # in the world
        apart = np.linalg.solve(link[:3, :3], np.column_stack([self.pose[:3, :3], foot - link[:3, 3]]))
        left, _, right = np.linalg.svd(apart[:, :3])
        pose = np.eye(4)
        pose[:3, :3] = left @ right
        pose[:3, 3] = apart[:, 3] - pose[:3, :3] @ self.foot
        return pose


def random_contact(
    body: Extent,
    pose: Floats,
    shape: list[Any],
    rng: np.random.Generator,
    closeness: Closeness = USUAL,
) -> Contact:
    """A shape laid upon a body at a pose (4, 4)."""
    other = extent_of(shape_of(shape))
    kind = rng.random()
    direction, turned = random_directions(2, rng)
    if kind < closeness.on_facets:
        direction = rng.choice([-1.0, 1.0]) * np.eye(3)[int(rng.integers(3))]
    elif kind < closeness.on_facets + closeness.at_corners:
        direction, turned = body.outward(rng), other.outward(rng)
    normal = np.linalg.inv(pose[:3, :3]).T @ direction  # of a pose that may be a little off rigid
    normal /= np.linalg.norm(normal)
    turn = turns_onto(turned[None], -normal[None], rng)[0]
    # Poses off rigid stretch what vertices span, not the balls around them.
    point = pose[:3, :3] @ body.furthest(direction, rng) + pose[:3, 3] + body.inflation_radius * normal
    local = other.furthest(turn.T @ -normal)
    foot = turn @ local - other.inflation_radius * normal
    placed = np.eye(4)
    placed[:3, :3] = turn
    touches = bool(rng.random() < _TOUCHING)
    if touches:
        middle = pose[:3, :3] @ body.vertices.mean(axis=0) + pose[:3, 3]
        inward = middle - point
        depth = min(10.0 ** rng.uniform(*closeness.depths), 0.5 * float(np.linalg.norm(inward)))
        placed[:3, 3] = point + depth * inward / max(float(np.linalg.norm(inward)), 1e-300) - foot
    else:
        placed[:3, 3] = point + 10.0 ** rng.uniform(*_GAPS) * normal - foot
    return Contact(placed, local, point, normal, touches)
