"""Proofs that two bodies share a point; at least one body is a solid.

In: two posed bodies, and the point or triangles that they share by the core. Out: the common point of two of their
triangles, as for convex bodies, or an `Enclosure`: a vertex of one around which the other one winds. Both are verified
exactly, without the core: the first from the corners of the triangles, the second by counting signed crossings of a
ray.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.certificates import SharedPoint, mixed_point
from plannercheck.bodies.exact_planes import Point, PosedBody
from plannercheck.bodies.integers import IntegerHull, in_common_unit
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.tuning import pair_options
from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.core import core
from plannercheck.common.exact_numbers import rounded
from plannercheck.common.public_names import set_module

Surface: TypeAlias = tuple[Floats, Ints]  # points (n, 3), m, and triangles (k, 3)

# Directions of rays, tried in order; a ray through an edge or a vertex decides nothing.
_DIRECTIONS = tuple((a, b, c) for a in (1009, -857, 613) for b in (907, -751, 521) for c in (811, -643, 433))


@dataclass(frozen=True, eq=False)
class PosedSurface(OwnsArrays):
    """The triangles of a body that a certificate is about.

    Attributes:
        points: (n, 3) in the body's frame, m.
        triangles: (k, 3) indices of points.
        pose: (4, 4) in the world, m.
    """

    points: Floats
    triangles: Ints
    pose: Floats


@set_module("plannercheck")
@dataclass(frozen=True, eq=False)
class Enclosure(OwnsArrays):
    """A point of one body around which the other one winds.

    Attributes:
        point: (3,) in the world, in m, rounded.
        winding_number: How often the outer body winds around it; not 0.
        first_is_inside: Whether it is a point of the first body, inside the second; else the other way round.
        inner: The point as the vertex of a body.
        outer: The triangles around it, which are closed.
    """

    point: Floats
    winding_number: int
    first_is_inside: bool
    inner: PosedBody = field(repr=False)
    outer: PosedSurface = field(repr=False)

    def verify(self) -> bool:
        """Whether the outer triangles are closed and wind around the point so often, proved in exact arithmetic."""
        exact = [rounded(x) for x in _place(self.inner)]
        is_around = self.winding_number != 0 and winding_about(self.inner, self.outer) == self.winding_number
        return exact == self.point.tolist() and is_around and edges_cancel(self.outer.triangles)


def contact_certificate(p: Polytope, r: Polytope, pose_p: Floats, pose_r: Floats) -> SharedPoint | Enclosure | None:
    """What proves that two posed bodies share a point of which at least one is a solid; None if they share none."""
    kind, on_p, on_r, _ = core.solids_contact(p.core, pose_p, r.core, pose_r)
    if kind == "apart":
        return None
    if kind == "triangles":
        return _of_triangles(
            *(
                PosedBody(*each)
                for each in (
                    (_corners(p, on_p), pose_p, p.inflation_radius),
                    (_corners(r, on_r), pose_r, r.inflation_radius),
                )
            )
        )
    first_is_inside = kind == "a in b"
    inner = (p, on_p, pose_p) if first_is_inside else (r, on_r, pose_r)
    outer = (r, pose_r) if first_is_inside else (p, pose_p)
    return _enclosure(first_is_inside, inner, outer)


def _of_triangles(*triangles: PosedBody) -> SharedPoint | None:
    """A common point of two triangles, which are the bodies of the certificate."""
    bodies = [Polytope(each.vertices, inflation_radius=each.inflation_radius) for each in triangles]
    p, r = bodies
    pose_p, pose_r = (each.pose for each in triangles)
    found = core.certify_pair(p.core, pose_p, r.core, pose_r, pair_options(), True)
    if not found["shared"]:
        return None
    for side, body, triangle in zip(("vertices_a", "vertices_b"), bodies, triangles, strict=True):
        corners = (triangle.vertices == body.vertices[found[side]][:, None]).all(
            axis=2
        )  # a body has an order of its own
        found[side] = corners.argmax(axis=1)
    first, second = triangles
    return mixed_point(found, (first, second))


def _enclosure(first_is_inside: bool, inner: tuple[Polytope, int, Floats], outer: tuple[Polytope, Floats]) -> Enclosure:
    body, vertex, pose = inner
    # All of a convex body is inside, if one of its points is and no triangles meet.
    vertices = body.vertices[:1] if body.traits.fills_hull else body.core.shape.points()[vertex : vertex + 1]
    point, around = PosedBody(vertices, pose), PosedSurface(*_surface(outer[0]), outer[1])
    place = np.array([rounded(x) for x in _place(point)])
    return Enclosure(place, winding_about(point, around) or 0, first_is_inside, point, around)


def _surface(body: Polytope) -> Surface:
    """The triangles of a solid, or of a hull."""
    if body.traits.fills_hull:
        return body.vertices, body.faces
    return body.core.shape.points(), body.core.shape.triangles()


def _corners(body: Polytope, triangle: int) -> Floats:
    """The corners (3, 3) of a triangle that the core names; of a flat hull, those of its fan of triangles."""
    points, triangles = _surface(body)
    if len(triangles):
        return np.asarray(points[triangles[triangle]])
    last = len(points) - 1
    fan = [0, triangle + 1, triangle + 2] if body.dimension == 2 else [0, last, last]
    return np.asarray(points[fan])


def _place(body: PosedBody) -> Point:
    """A body's only vertex in the world, exactly, m."""
    posed = IntegerHull(body.vertices, body.pose)
    x, y, z = (Fraction(coordinate) * Fraction(2) ** posed.unit for coordinate in posed.point(0))
    return x, y, z


def winding_about(point: PosedBody, around: PosedSurface) -> int | None:
    """How often closed triangles wind around a point, exactly; None if it is on one of them."""
    surface, inner = in_common_unit(IntegerHull(around.points, around.pose), IntegerHull(point.vertices, point.pose))
    posed = np.array([surface.point(k) for k in range(len(around.points))], dtype=object)
    return winding_number(posed - np.array(inner.point(0), dtype=object), around.triangles)


def winding_number(points: NDArray[np.object_], triangles: Ints) -> int | None:
    """How often closed triangles (k, 3) of points (n, 3) of integers wind around the origin; None if it is on one."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    is_flat = ~_cross(b - a, c - a).astype(bool).any(axis=1)  # a segment or a point: nothing crosses its inside
    a, b, c = a[~is_flat], b[~is_flat], c[~is_flat]
    height = _dot(a, _cross(b, c))
    for direction in _DIRECTIONS:
        d = np.array([direction], dtype=object)
        sides = np.stack([_dot(d, _cross(*edge)) for edge in ((a, b), (b, c), (c, a))])
        up, down = (sides > 0).all(axis=0), (sides < 0).all(axis=0)
        on_line = (sides >= 0).all(axis=0) | (sides <= 0).all(axis=0)
        if (height[up | down] == 0).any():
            return None
        if not (on_line & ~up & ~down).any():
            return int((up & (height > 0)).sum()) - int((down & (height < 0)).sum())
    return None


def _cross(a: NDArray[np.object_], b: NDArray[np.object_]) -> NDArray[np.object_]:
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=1)


def _dot(a: NDArray[np.object_], b: NDArray[np.object_]) -> NDArray[np.object_]:
    return np.asarray((a * b).sum(axis=1))


def edges_cancel(triangles: Ints) -> bool:
    """Whether each directed edge of triangles (k, 3) occurs as often as its reverse."""
    a, b = np.asarray(triangles, dtype=np.int64)[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).T
    count = int(triangles.max()) + 1
    return np.array_equal(np.sort(a * count + b), np.sort(b * count + a))
