"""All nearest points of two hulls that are apart: where faces or edges are parallel, more than one pair is nearest.

In: two posed bodies, one pair of nearest points, the normal. Out: corners of the set of the first body's nearest ones.
Idea: the set is where the first body's face against the normal meets the second body's along it, moved by the nearest
difference: the intersection of two convex polygons (or edges, or points) in a plane. Its corners are corners of one
that lie in the other, and crossings of edges.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError

# Vertices this near to a supporting plane lie on it, and points this near to a polygon in it: a part of the radius.
_ON_PLANE = 1e-9


def nearest_points_of(
    p: Polytope, pose_p: Floats, r: Polytope, pose_r: Floats, points: Floats, normal: Floats
) -> Floats:
    """Corners (n, 3), in the world, m, of the set of all nearest points of the first of two hulls or half-spaces.

    `points` (2, 3) are one pair of nearest points, the first of which is among the corners; the normal (3,) is from r
    to p, of length 1.

    Raises:
        PlannercheckError: If one of the bodies is a solid or a set of parts.
    """
    for body in (p, r):
        if body.kind not in ("hull", "half_space"):
            raise PlannercheckError(
                "derivatives along directions are of hulls: a solid, cloud or map has several nearest places"
            )
    face_p = _face(p, pose_p, normal, points[0])
    face_r = _face(r, pose_r, -normal, points[1])
    if face_p is None or face_r is None:
        found = [points[:1], *(face for face in (face_p, face_r) if face is not None)]
        return np.asarray(points[0] + _on_plane(np.concatenate(found) - points[0], normal))
    axes = _axes(normal)
    a, b = (_polygon((face - points[0]) @ axes.T) for face in (face_p, face_r))
    room = _ON_PLANE * min(p.core.radius, r.core.radius)
    inside = [x for x in a if _holds(b, x, room)] + [x for x in b if _holds(a, x, room)]
    corners = np.array([np.zeros(2), *inside, *_crossings(a, b)])
    return np.asarray(points[0] + corners @ axes)


def _face(body: Polytope, pose: Floats, normal: Floats, nearest: Floats) -> Floats | None:
    """(m, 3) the vertices lowest along the normal, through the nearest point; None for a half-space."""
    if not body.traits.is_bounded:
        return None
    vertices = body.vertices @ pose[:3, :3].T + pose[:3, 3]
    heights = vertices @ normal
    lowest = vertices[heights <= heights.min() + _ON_PLANE * body.core.radius]
    return np.asarray(nearest + _on_plane(lowest - nearest, normal))


def _on_plane(vectors: Floats, normal: Floats) -> Floats:
    return np.asarray(vectors - (vectors @ normal)[:, None] * normal)


def _axes(normal: Floats) -> Floats:
    """(2, 3) unit vectors at right angles to the normal and to each other."""
    first = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal, first)])


def _polygon(points: Floats) -> Floats:
    """(m, 2) the points around their middle, counter-clockwise; they are corners of a convex polygon, or two or one."""
    around = points - points.mean(axis=0)
    return np.asarray(points[np.argsort(np.arctan2(around[:, 1], around[:, 0]))] if len(points) > 2 else points)


def _edges(polygon: Floats) -> list[tuple[Floats, Floats]]:
    following = np.roll(polygon, -1, axis=0)
    count = len(polygon) if len(polygon) > 2 else len(polygon) - 1
    return [(polygon[k], following[k]) for k in range(count)]


def _cross(a: Floats, b: Floats) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def _holds(polygon: Floats, x: Floats, room: float) -> bool:
    """Whether a point is in a polygon, on a segment or at a point, up to the room."""
    if len(polygon) > 2:
        return all(
            _cross(end - start, x - start) >= -room * float(np.linalg.norm(end - start))
            for start, end in _edges(polygon)
        )
    if len(polygon) == 1:
        return float(np.linalg.norm(x - polygon[0])) <= room
    start, end = polygon
    along = end - start
    part = float(np.clip((x - start) @ along / max(float(along @ along), np.finfo(float).tiny), 0, 1))
    return float(np.linalg.norm(x - start - part * along)) <= room


def _crossings(a: Floats, b: Floats) -> list[Floats]:
    found = []
    for (start, end), (other, other_end) in product(_edges(a), _edges(b)):
        along, across = end - start, other_end - other
        size = _cross(along, across)
        if abs(size) <= _ON_PLANE * float(np.linalg.norm(along) * np.linalg.norm(across)):
            continue  # parallel: their ends are corners
        t, s = _cross(other - start, across) / size, _cross(other - start, along) / size
        if 0 <= t <= 1 and 0 <= s <= 1:
            found.append(start + t * along)
    return found
