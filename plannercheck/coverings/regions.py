"""What a cover has to hold: the bodies of a link, each as a region in the link's frame.

In: the bodies of a link. Out: for each a `Region`: its triangles, if it has any, bounds of the distance of points from
it, points that are certainly in it, and exact membership. Meshes, hulls and boxes are solids, whose distances and
verdicts are the core's; spheres, capsules and cylinders have closed forms. Cones and ellipsoids are the polytopes
around them, which stick out by at most 1e-4 of their size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Protocol

import numpy as np

from plannercheck.bodies.ellipsoids import Ellipsoid
from plannercheck.bodies.integers import cross, dot
from plannercheck.bodies.intersection import intersects
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import Box, Capsule, Cone, Cylinder, GeometryObject, Hull, Sphere
from plannercheck.bodies.solids import Solid
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.transforms import at_places
from plannercheck.coverings.curved_cells import Cells, CylinderCells, capsule_cells
from plannercheck.coverings.primitives import Point, Primitives, square_from_segment

# Points are moved into curved regions by this part of their size, far more than rounding moves them.
_INSET = 1e-12
# Poses of bodies are rigid up to 3.6e-6: so much may distances in a body's frame be too large.
_RIGID = 1e-5
_SPACE = 3
# Vertices of a body that are held against one primitive by fractions; a bound on time alone.
_MOST_EXACT = 2000


def _no_triangles() -> Floats:
    return np.zeros((0, 3, 3))


class Region(Protocol):
    """A body of a link."""

    @property
    def triangles(self) -> Floats:
        """(m, 3, 3) m, its surface in the body's frame; none of curved regions."""

    @property
    def pose(self) -> Floats:
        """(4, 4) of the body on the link, m."""

    @property
    def has_inside(self) -> bool:
        """Whether it is more than its triangles."""

    def distances(self, points: Floats) -> tuple[Floats, Floats]:
        """Proved lower bounds, and distances up to rounding, (n,) m, of points (n, 3) in the link's frame."""

    def near(self, points: Floats) -> tuple[Bools, Floats]:
        """For which points (n, 3) a point of the region is known, and these points (n, 3)."""

    def holds(self, point: Point) -> bool:
        """Whether it holds an exact point whose coordinates are doubles, exactly."""

    def is_in_one_of(self, cover: Primitives) -> bool:
        """Whether it is known to lie in one primitive, exactly."""

    def cells(self) -> Sequence[Cells]:
        """Cells that together hold it; none of bodies with triangles."""


def regions_of(bodies: Sequence[GeometryObject]) -> list[Region]:
    """The regions of a link's bodies.

    Raises:
        PlannercheckError: If a body is no shape of a link.
    """
    return [_region(body) for body in bodies]


def _region(body: GeometryObject) -> Region:
    shape, pose = body.shape, np.asarray(body.pose)
    if isinstance(shape, Sphere | Capsule):
        half = shape.length / 2 if isinstance(shape, Capsule) else 0.0
        return RoundRegion.of(pose, half, shape.radius)
    if isinstance(shape, Cylinder):
        return CylinderRegion(pose, shape.radius, shape.length / 2)
    if isinstance(shape, Solid):
        return SolidRegion(shape, pose)
    if isinstance(shape, Box | Hull | Cone | Ellipsoid):
        return SolidRegion(_solid_of(shape), pose)
    raise PlannercheckError(f"body {body.name!r} is a {type(shape).__name__}, which no sphere model can cover")


def _solid_of(shape: Box | Hull | Cone | Ellipsoid) -> Solid:
    hull = Polytope(*shape.vertices_and_faces())
    points = np.asarray(hull.vertices)
    if hull.dimension == _SPACE:
        return Solid(points, np.asarray(hull.faces))
    # All triangles with one vertex: their union is a polygon, segment or point, whatever the order of its vertices.
    i, j = np.triu_indices(max(2, len(points)), 0)
    triangles = np.minimum(np.stack([np.zeros_like(i), i, j], axis=1), len(points) - 1)
    return Solid(points, triangles, "triangles")


class SolidRegion:
    """A mesh, hull or box."""

    def __init__(self, solid: Solid, pose: Floats) -> None:
        points, triangles = solid.used
        self.pose, self.triangles = pose, points[triangles]
        self.has_inside = solid.is_closed
        self._points, self._body = points, Polytope(points).of_solid(solid)
        self._point = Polytope(np.zeros((1, 3)))

    def box(self) -> tuple[Floats, Floats]:
        """The lowest and highest coordinates (3,) in the link's frame, m, about."""
        corners = self._body_points()
        return corners.min(axis=0), corners.max(axis=0)

    def distances(self, points: Floats) -> tuple[Floats, Floats]:
        """See `Region`."""
        if not len(points):
            return np.zeros(0), np.zeros(0)
        touching, upper, lower, *_ = core.distance_batch(
            self._point.core, at_places(points), self._body.core, self.pose[None]
        )
        is_in = np.asarray(touching) != 0
        return np.where(is_in, 0.0, np.maximum(lower, 0.0)), np.where(is_in, 0.0, upper)

    def near(self, points: Floats) -> tuple[Bools, Floats]:
        """See `Region`."""
        return self._holds(points), points

    def holds(self, point: Point) -> bool:
        """See `Region`."""
        return bool(self._holds(np.array([[float(x) for x in point]]))[0])

    def is_in_one_of(self, cover: Primitives) -> bool:
        """See `Region`."""
        points = self._body_points()
        values, error = cover.values(points).max(axis=0), cover.error(points)
        if (values < -error).any():
            return True
        if len(points) > _MOST_EXACT:
            return False
        exact = [posed_exactly(point, self.pose) for point in self._points.tolist()]
        return any(all(cover.holds(int(k), point) for point in exact) for k in np.flatnonzero(values <= error))

    def cells(self) -> Sequence[Cells]:
        """See `Region`."""
        return ()

    def _body_points(self) -> Floats:
        return posed(self._points, self.pose)

    def _holds(self, points: Floats) -> Bools:
        if not len(points):
            return np.zeros(0, dtype=bool)
        return np.asarray(intersects(self._point, self._body, at_places(points), self.pose))


@dataclass(frozen=True, eq=False)
class RoundRegion:
    """A sphere or capsule: its ends are mapped, its radius is in metres of the link."""

    pose: Floats
    ends: Floats
    radius: float
    exact_ends: tuple[Point, Point]
    triangles: Floats = field(default_factory=_no_triangles)
    has_inside: bool = True

    @classmethod
    def of(cls, pose: Floats, half: float, radius: float) -> RoundRegion:
        """A segment along z of half a length, m, and the radius around it."""
        rows = [[Fraction(x) for x in row] for row in pose[:3].tolist()]
        low, high = (tuple(row[3] + row[2] * z for row in rows) for z in (-Fraction(half), Fraction(half)))
        return cls(pose, np.array([low, high], dtype=np.float64), radius, (low, high))  # type: ignore[arg-type]

    def distances(self, points: Floats) -> tuple[Floats, Floats]:
        """See `Region`."""
        own = self._own(self.radius)
        beyond = own.values(points)[:, 0]
        return np.maximum(beyond - own.error(points), 0.0), np.maximum(beyond, 0.0)

    def near(self, points: Floats) -> tuple[Bools, Floats]:
        """See `Region`."""
        a, b = self.ends
        along = b - a
        shares = np.clip((points - a) @ along / max(float(along @ along), np.finfo(float).tiny), 0.0, 1.0)
        feet = a + shares[:, None] * along
        off = points - feet
        lengths = np.linalg.norm(off, axis=1, keepdims=True)
        size = self.radius + float(np.abs(self.ends).max())
        keep = np.minimum(1.0, max(0.0, self.radius - _INSET * size) / np.maximum(lengths, 1e-300))
        return np.ones(len(points), dtype=bool), feet + keep * off

    def holds(self, point: Point) -> bool:
        """See `Region`."""
        return square_from_segment(*self.exact_ends, point) <= Fraction(self.radius) ** 2

    def is_in_one_of(self, cover: Primitives) -> bool:
        """See `Region`."""
        return any(all(cover.holds(k, end, self.radius) for end in self.exact_ends) for k in range(len(cover.radii)))

    def cells(self) -> Sequence[Cells]:
        """See `Region`."""
        return capsule_cells(self.ends[0], self.ends[1], self.radius)

    def _own(self, radius: float) -> Primitives:
        return Primitives.of(capsules=[(self.ends[0].tolist(), self.ends[1].tolist(), radius)])


@dataclass(frozen=True, eq=False)
class CylinderRegion:
    """A cylinder along z of the body's frame, as its pose maps it."""

    pose: Floats
    radius: float
    half: float
    triangles: Floats = field(default_factory=_no_triangles)
    has_inside: bool = True

    def distances(self, points: Floats) -> tuple[Floats, Floats]:
        """See `Region`."""
        own = self._own(points)
        beyond = np.hypot(
            np.maximum(np.hypot(own[:, 0], own[:, 1]) - self.radius, 0.0),
            np.maximum(np.abs(own[:, 2]) - self.half, 0.0),
        )
        rounding = _INSET * (np.abs(points).max(initial=0.0) + np.abs(self.pose).max() + self.radius + self.half)
        return np.maximum(beyond * (1 - _RIGID) - rounding, 0.0), beyond

    def near(self, points: Floats) -> tuple[Bools, Floats]:
        """See `Region`."""
        own = self._own(points)
        off = np.hypot(own[:, 0], own[:, 1])
        inset = _INSET * (self.radius + self.half + float(np.abs(self.pose[:3, 3]).max()))
        own[:, :2] *= np.minimum(1.0, max(0.0, self.radius - inset) / np.maximum(off, 1e-300))[:, None]
        limit = max(0.0, self.half - inset)
        own[:, 2] = np.clip(own[:, 2], -limit, limit)
        return np.ones(len(points), dtype=bool), posed(own, self.pose)

    def holds(self, point: Point) -> bool:
        """See `Region`."""
        rows = [[Fraction(x) for x in row] for row in self.pose[:3].tolist()]
        from_middle = [x - row[3] for x, row in zip(point, rows, strict=True)]
        u, v, w = ([row[k] for row in rows] for k in range(3))
        whole = dot(u, cross(v, w))
        x, y, z = dot(from_middle, cross(v, w)), dot(u, cross(from_middle, w)), dot(u, cross(v, from_middle))
        return x * x + y * y <= (Fraction(self.radius) * whole) ** 2 and z * z <= (Fraction(self.half) * whole) ** 2

    def is_in_one_of(self, cover: Primitives) -> bool:
        """See `Region`: of a pose that turns exactly, in a sphere about a point of its axis or a capsule along it."""
        rows = [[Fraction(x) for x in row] for row in self.pose[:3].tolist()]
        u, v, w = ([row[k] for row in rows] for k in range(3))
        if any(dot(column, column) != 1 for column in (u, v)) or any(dot(a, b) for a, b in ((u, v), (u, w), (v, w))):
            return False
        ends = [tuple(row[3] + z * row[2] for row in rows) for z in (-Fraction(self.half), Fraction(self.half))]
        return any(_rims_are_in(cover, k, ends, w, self.radius) for k in range(len(cover.radii)))  # type: ignore[arg-type]

    def cells(self) -> Sequence[Cells]:
        """See `Region`."""
        return [CylinderCells.of(self.pose, self.radius, self.half)]

    def _own(self, points: Floats) -> Floats:
        """Points in the body's frame."""
        return np.asarray((points - self.pose[:3, 3]) @ np.linalg.inv(self.pose[:3, :3]).T)


def _rims_are_in(cover: Primitives, index: int, ends: Sequence[Point], axis: Sequence[Fraction], radius: float) -> bool:
    """Whether discs about both ends, across an axis, are in a capsule that holds the ends, or a sphere on the axis."""
    a, b = ([Fraction(x) for x in end] for end in cover.ends[index].tolist())
    greatest, square = Fraction(float(cover.radii[index])), Fraction(radius) ** 2
    if a != b:
        thin = Primitives(cover.ends[index : index + 1], np.zeros(1), np.zeros((0, 4, 4)), np.zeros((0, 3)))
        return radius <= cover.radii[index] and all(thin.holds(0, end) for end in ends)
    for end in ends:
        apart = [x - y for x, y in zip(a, end, strict=True)]
        along, length = dot(apart, axis), dot(axis, axis)
        if any(length * x != along * y for x, y in zip(apart, axis, strict=True)):
            return False
        if dot(apart, apart) + square > greatest**2:
            return False
    return True


def posed(points: Floats, pose: Floats) -> Floats:
    """Points (..., 3) of a body in the link's frame."""
    return np.asarray(points @ pose[:3, :3].T + pose[:3, 3])


def posed_exactly(own: Sequence[float | Fraction], pose: Floats) -> Point:
    """A point of a body in the link's frame."""
    x, y, z = (
        sum((Fraction(a) * Fraction(b) for a, b in zip(row[:3], own, strict=True)), Fraction(row[3]))
        for row in pose[:3].tolist()
    )
    return x, y, z
