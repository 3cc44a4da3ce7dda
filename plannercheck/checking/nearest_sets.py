"""All nearest points of two convex parts that are apart: where faces or edges are parallel, more than one is nearest.

In: a place where two bodies are nearest: a part of each, one pair of nearest points, the normal. Out: corners of the
set of the first part's nearest ones. Idea: the set is where the first part's face against the normal meets the second
part's along it, moved by the nearest difference: the intersection of two convex polygons (or edges, or points) in a
plane. Its corners are corners of one that lie in the other, and crossings of edges.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from plannercheck.common.array_types import Floats

# Vertices this near to a supporting plane lie on it, and points this near to a polygon in it: a part of the size.
_ON_PLANE = 1e-9


class NearestPlace(NamedTuple):
    """Two convex parts, or hulls, that are as near as their bodies, in the world.

    Attributes:
        vertices_p: (n, 3) of the first body's part, m; none of a half-space.
        vertices_r: (n, 3) of the second one's.
        points: (2, 3) one pair of nearest points, m, on the inflated parts.
        normal: (3,) from the second to the first, of length 1.
        turn: How far the normals of nearest points are from it at most; infinite where rounding leaves them open.
    """

    vertices_p: Floats
    vertices_r: Floats
    points: Floats
    normal: Floats
    turn: float


def nearest_points_of(place: NearestPlace) -> Floats:
    """Corners (n, 3), in the world, m, of the set of all nearest points of the first part.

    The given one is among them.
    """
    points, normal = place.points, place.normal
    face_p, face_r = _face(place.vertices_p, normal, points[0]), _face(place.vertices_r, -normal, points[1])
    if not len(face_p) or not len(face_r):
        return np.asarray(points[0] + _on_plane(np.concatenate([points[:1], face_p, face_r]) - points[0], normal))
    axes = _axes(normal)
    room = _ON_PLANE * min(_size(place.vertices_p), _size(place.vertices_r))
    a, b = (_polygon((face - points[0]) @ axes.T, room) for face in (face_p, face_r))
    inside = [x for x in a if _holds(b, x, room)] + [x for x in b if _holds(a, x, room)]
    corners = np.array([np.zeros(2), *inside, *_crossings(a, b)])
    return np.asarray(points[0] + corners @ axes)


def _size(vertices: Floats) -> float:
    return float(np.linalg.norm(np.ptp(vertices, axis=0)))


def _face(vertices: Floats, normal: Floats, nearest: Floats) -> Floats:
    """(m, 3) the vertices lowest along the normal, through the nearest point."""
    if not len(vertices):
        return vertices
    heights = vertices @ normal
    lowest = vertices[heights <= heights.min() + _ON_PLANE * _size(vertices)]
    return np.asarray(nearest + _on_plane(lowest - nearest, normal))


def _on_plane(vectors: Floats, normal: Floats) -> Floats:
    return np.asarray(vectors - (vectors @ normal)[:, None] * normal)


def _axes(normal: Floats) -> Floats:
    """(2, 3) unit vectors at right angles to the normal and to each other."""
    first = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal, first)])


def _polygon(points: Floats, room: float) -> Floats:
    """(m, 2) the points around their middle, counter-clockwise; of points on a line its ends, of equal ones one."""
    around = points - points.mean(axis=0)
    _, spreads, axes = np.linalg.svd(around, full_matrices=False)
    if spreads[0] <= room:
        return points[:1]
    if spreads[-1] <= room or len(points) == 2:
        along = around @ axes[0]
        return points[[along.argmin(), along.argmax()]]
    return np.asarray(points[np.argsort(np.arctan2(around[:, 1], around[:, 0]))])


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
