"""Triangles of polygons with any number of corners.

In: points, and the polygons' corners. Out: triangles in the polygons' order. A convex polygon becomes a fan about its
first corner. A concave polygon is cut ear by ear, because a fan would cover points outside of it.
"""

from __future__ import annotations

import numpy as np

from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import distinct
from plannercheck.common.errors import PlannercheckError

# Most corners of a polygon that is cut ear by ear: the time grows with their square.
_MOST_EARS = 2000

# A part of a polygon's area, or of its extent's square, that triangles may be wrong by: rounded corners that lie on a
# line, or on a circle, turn both ways.
_NEGLIGIBLE = 1e-6


def triangles_of_polygons(points: Floats, counts: Ints64, corners: Ints64) -> Ints64:
    """Cuts polygons of counts (m,) >= 3 corners into triangles (sum of counts - 2 m, 3) of indices of points.

    Corners (sum of counts,) are indices of points (n, 3), one polygon after the other.

    Raises:
        PlannercheckError: If a polygon crosses itself, or is concave and has too many corners.
    """
    if (counts == 3).all():
        return np.asarray(corners.reshape(-1, 3))
    starts = np.cumsum(counts) - counts
    triangles = counts - 2
    first = np.repeat(starts, triangles)
    step = np.arange(triangles.sum()) - np.repeat(np.cumsum(triangles) - triangles, triangles)
    found = corners[np.column_stack([first, first + step + 1, first + step + 2])]
    ends = np.cumsum(triangles)
    for k in _concave(points, counts, corners):
        polygon = corners[starts[k] : starts[k] + counts[k]]
        if len(polygon) > _MOST_EARS:
            _check_fan(points[polygon])
        else:
            found[ends[k] - triangles[k] : ends[k]] = polygon[_ears(points[polygon])]
    return np.asarray(found)


def _concave(points: Floats, counts: Ints64, corners: Ints64) -> list[int]:
    """The polygons with more than three corners that turn both ways."""
    found: list[int] = []
    starts = np.cumsum(counts) - counts
    for count in distinct(counts[counts > 3]).tolist():
        which = np.flatnonzero(counts == count)
        corner = points[corners[starts[which][:, None] + np.arange(count)]]
        with np.errstate(over="ignore", invalid="ignore"):
            edges = _edges(corner)
            turns = np.cross(np.roll(edges, 1, axis=1), edges)
            normal = np.cross(corner - corner[:, :1], np.roll(corner, -1, axis=1) - corner[:, :1]).sum(axis=1)
            ways = np.einsum("ijk,ik->ij", turns, normal)
            found += which[(ways < 0).any(axis=1)].tolist()
    return found


def _edges(corner: Floats) -> Floats:
    """From each corner of n polygons (n, k, 3) to the next one that lies elsewhere."""
    edges = np.roll(corner, -1, axis=1) - corner
    is_none, count = ~edges.any(axis=2), corner.shape[1]
    if not is_none.any():
        return edges
    places = np.where(is_none, 2 * count, np.arange(count))
    twice = np.concatenate([places, places + count], axis=1)
    following = np.minimum.accumulate(twice[:, ::-1], axis=1)[:, : count - 1 : -1] % count
    return np.take_along_axis(edges, following[..., None], axis=1)


def _check_fan(corners: Floats) -> None:
    """Raises if the fan of a polygon (n, 3) covers points outside of it: then some of its triangles turn otherwise."""
    areas = np.cross(corners[1:-1] - corners[0], corners[2:] - corners[0])
    total = areas.sum(axis=0)
    if np.minimum(areas @ total, 0).sum() < -_NEGLIGIBLE * (total @ total):
        raise PlannercheckError(
            f"has a concave polygon of {len(corners)} corners, the first at {corners[0].tolist()}: more than "
            f"{_MOST_EARS} are not cut, write triangles"
        )


def _ears(corners: Floats) -> Ints64:
    """The triangles (n - 2, 3) of one polygon (n, 3), cut off ear by ear; indices of its corners."""
    normal = np.cross(corners - corners[0], np.roll(corners, -1, axis=0) - corners[0]).sum(axis=0)
    flat = np.delete(corners, int(np.argmax(np.abs(normal))), axis=1)  # seen along an axis: turns keep their signs
    left, found = list(range(len(corners))), []
    sense = np.sign(_areas(flat[:-1], flat[1:], flat[0]).sum())
    while len(left) > 3:
        at = next((k for k in range(len(left)) if _is_ear(flat, left, k, sense)), -1)
        if at < 0:
            at = _least_corner(flat[left])
        found.append([left[at - 1], left[at], left[(at + 1) % len(left)]])
        del left[at]
    return np.array([*found, left], dtype=np.int64)


def _least_corner(flat: Floats) -> int:
    """The corner of a polygon without ears that cuts off next to nothing."""
    areas = np.abs(_areas(np.roll(flat, 1, axis=0), flat, np.roll(flat, -1, axis=0)))
    at = int(np.argmin(areas))
    if areas[at] > _NEGLIGIBLE * np.ptp(flat, axis=0).max() ** 2:
        raise PlannercheckError(f"has a polygon that crosses itself near {flat[at].tolist()}: write triangles")
    return at


def _is_ear(flat: Floats, left: list[int], at: int, sense: float) -> bool:
    """Whether a corner turns as the polygon does, and its triangle holds no other corner."""
    a, b, c = (flat[left[k % len(left)]] for k in (at - 1, at, at + 1))
    if sense * _areas(a, b, c) <= 0:
        return False
    around = {left[k % len(left)] for k in (at - 1, at, at + 1)}
    others = flat[[k for k in left if k not in around]]
    others = others[~((others == a).all(axis=1) | (others == b).all(axis=1) | (others == c).all(axis=1))]
    inside = [sense * _areas(start, end, others) >= 0 for start, end in ((a, b), (b, c), (c, a))]
    return not np.logical_and.reduce(inside).any()


def _areas(a: Floats, b: Floats, c: Floats) -> Floats:
    """Twice the signed areas of triangles in the plane."""
    u, v = b - a, c - a
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])
