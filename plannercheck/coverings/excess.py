"""How far a cover sticks out of the bodies that it stands for.

In: the regions of a link and its primitives. Out: a proved bound of the distance of any point of the cover from the
regions, and the mean distance over the cover's surface, from points spread over it.

The bound is found by branch and bound over cubes: no point of a cube is further from the regions than its middle is,
plus half its diagonal. Cubes off the cover are left out; others are cut into eight until they can't be further out
than the furthest point that is known, plus a small tolerance.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from plannercheck.bodies.circumscribed import sphere_points
from plannercheck.common.array_types import Floats
from plannercheck.coverings.primitives import STEEPEST, Primitives
from plannercheck.coverings.regions import Region, posed

# The bound is at most this many times the furthest point that was found, or so many metres further, unless that takes
# more cubes than _MOST_CUBES: then it is proved, but looser.
_RELATIVE, _FINE = 1.03, 5e-4
_FIRST_CUBES, _MOST_CUBES = 8, 100_000
# Distances are off by at most this part of the coordinates.
_ROUNDING = 1e-9
# Points on each sphere, and on each side of a box along an edge.
_ON_SPHERE, _ALONG_EDGE = 200, 8
_DIAGONAL = float(np.sqrt(3.0)) * STEEPEST


def apart(regions: Sequence[Region], points: Floats) -> Floats:
    """(n,) m, distances of points (n, 3) from the nearest region, up to rounding."""
    return np.asarray(np.min([region.distances(points)[1] for region in regions], axis=0))


def greatest_excess(regions: Sequence[Region], cover: Primitives) -> float:
    """A proved bound, m, of the distance of any point of a cover from the regions."""
    points, _ = surface_points(cover)
    known = float(apart(regions, points).max(initial=0.0))
    low, high = points.min(axis=0), points.max(axis=0)
    scale = float(np.abs(points).max())
    half = float((high - low).max()) / (2 * _FIRST_CUBES - 2)
    steps = [np.arange(np.ceil(extent / (2 * half)) + 1) for extent in (high - low).tolist()]
    middles = low + 2 * half * np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
    bound = 0.0
    while len(middles):
        beyond = cover.values(middles).min(axis=1)
        is_near = beyond <= half * _DIAGONAL + cover.error(middles)
        middles, beyond = middles[is_near], beyond[is_near]
        distances = apart(regions, middles)
        known = max(known, float(distances.max(where=beyond <= 0, initial=0.0)))
        furthest = distances + half * _DIAGONAL
        goes_on = furthest > max(_RELATIVE * known, known + _FINE)
        if 8 * np.count_nonzero(goes_on) > _MOST_CUBES:
            goes_on[:] = False
        bound = max(bound, float(furthest.max(where=~goes_on, initial=0.0)))
        half /= 2
        middles = (middles[goes_on][:, None] + half * _CORNERS).reshape(-1, 3)
    return bound + _ROUNDING * scale


def mean_excess(regions: Sequence[Region], cover: Primitives) -> tuple[float, float]:
    """The mean distance, m, of a cover's surface from the regions, and the area of that surface, m², both estimated."""
    points, areas = surface_points(cover)
    distances = apart(regions, points)
    area = float(areas.sum())
    return (float(distances @ areas) / area if area else 0.0), area


_CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))


def surface_points(cover: Primitives, on_sphere: int = _ON_SPHERE) -> tuple[Floats, Floats]:
    """Points (n, 3) spread over the surface of a union, m, and the area (n,) that each stands for, m²."""
    directions = sphere_points(on_sphere)
    found: list[Floats] = []
    areas: list[Floats] = []
    owners: list[int] = []
    for k, ((a, b), radius) in enumerate(zip(cover.ends, cover.radii.tolist(), strict=True)):
        along = b - a
        length = float(np.linalg.norm(along))
        points = np.where((directions @ along > 0)[:, None], b, a) + radius * directions
        found.append(points)
        areas.append(np.full(len(points), 4 * np.pi * radius**2 / len(points)))
        if length:
            across = directions - np.outer(directions @ along, along) / length**2
            across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
            shares = (np.arange(len(directions)) * 0.618033988749895) % 1.0
            found.append(a + shares[:, None] * along + radius * across)
            areas.append(np.full(len(directions), 2 * np.pi * radius * length / len(directions)))
        owners += [k] * (sum(map(len, found)) - len(owners))
    for k, (frame, half) in enumerate(zip(cover.frames, cover.halves, strict=True)):
        points, area = _on_box(half)
        found.append(posed(points, frame))
        areas.append(area)
        owners += [len(cover.radii) + k] * len(points)
    points, weights, owner = np.concatenate(found), np.concatenate(areas), np.array(owners)
    values = cover.values(points)
    values[np.arange(len(points)), owner] = np.inf
    on_surface = values.min(axis=1) >= -cover.error(points)
    return points[on_surface], weights[on_surface]


def _on_box(half: Floats) -> tuple[Floats, Floats]:
    """Points on the sides of a box, and their areas."""
    steps = (2 * np.arange(_ALONG_EDGE) + 1) / _ALONG_EDGE - 1
    points, areas = [], []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        grid = np.array(list(product(steps, steps)))
        for side in (-1.0, 1.0):
            face = np.empty((len(grid), 3))
            face[:, axis], face[:, u], face[:, v] = side * half[axis], grid[:, 0] * half[u], grid[:, 1] * half[v]
            points.append(face)
            areas.append(np.full(len(grid), 4 * half[u] * half[v] / len(grid)))
    return np.concatenate(points), np.concatenate(areas)
