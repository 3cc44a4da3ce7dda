"""Closed meshes that are torn open, as files have them: holes, seams, T-junctions, turned and missing triangles.

In: about how many triangles, a random generator. Out: a `Surface` about 1 m across, of one or two components.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from plannercheck.evaluation.stress_solids.solid_families import LARGE_FAMILIES, SOLID_FAMILIES
from plannercheck.evaluation.stress_solids.surfaces import Surface, joined, merged, surface

# Distances of vertices that were one, as parts of the size: within 1e-6 of it they are joined, else not.
_APART = (1e-16, 1e-12, 1e-9, 1e-7, 0.9e-6, 1.1e-6, 1e-5, 1e-3)
# Radii of holes, and shares of triangles that are missing or turned.
_HOLES, _SHARES = (0.05, 0.2, 0.5), (0.02, 0.1, 0.4)


def torn(n: int, rng: np.random.Generator) -> Surface:
    """A body of any family, or two of them, with one to three tears each."""
    parts = [_torn_body(n, rng) for _ in range(int(rng.choice([1, 2], p=[0.8, 0.2])))]
    shifted = [part.moved(np.eye(3), rng.choice([0.0, 0.3, 2.0], 3)) for part in parts[1:]]
    return joined([parts[0], *shifted])


def _torn_body(n: int, rng: np.random.Generator) -> Surface:
    names = [name for name in SOLID_FAMILIES if name not in LARGE_FAMILIES]
    found = merged(SOLID_FAMILIES[str(rng.choice(names))](n, rng))
    for name in rng.choice(list(TEARS), int(rng.integers(1, 4))):
        found = TEARS[str(name)](found, rng)
    return found


def _hole(given: Surface, rng: np.random.Generator) -> Surface:
    """Without the triangles about a corner."""
    middles = given.points[given.triangles].mean(axis=1)
    distance = np.linalg.norm(middles - middles[rng.integers(len(middles))], axis=1)
    return _with(given, distance > rng.choice(_HOLES))


def _ragged_hole(given: Surface, rng: np.random.Generator) -> Surface:
    """With a hole, and without some of the triangles at its rim."""
    opened = _hole(given, rng)
    gone = given.triangles[~np.isin(given.triangles, opened.triangles)]
    beside = given.triangles[np.isin(given.triangles, gone).any(axis=1)]
    is_beside = np.isin(opened.triangles, beside).any(axis=1)
    return _with(opened, ~is_beside | (rng.random(len(opened.triangles)) < 0.5))


def _without_some(given: Surface, rng: np.random.Generator) -> Surface:
    return _with(given, rng.random(len(given.triangles)) > rng.choice(_SHARES))


def _turned(given: Surface, rng: np.random.Generator) -> Surface:
    """With some triangles inside out."""
    turned = rng.random(len(given.triangles)) < rng.choice(_SHARES)
    return surface(given.points, np.where(turned[:, None], given.triangles[:, ::-1], given.triangles))


def _seams(given: Surface, rng: np.random.Generator) -> Surface:
    """Some corners with vertices of their own, which are a little off."""
    corners = given.triangles.copy()
    own = rng.random(corners.shape) < rng.choice([0.05, 0.5, 1.0])
    points = given.points[corners[own]] + rng.choice(_APART) * rng.normal(size=(int(own.sum()), 3)) / 2
    corners[own] = len(given.points) + np.arange(len(points))
    return surface(np.vstack([given.points, points]), corners)


def _gaps(given: Surface, rng: np.random.Generator) -> Surface:
    """Edges split on one side, at a point near the edge."""
    points, triangles = list(given.points), given.triangles.tolist()
    apart = rng.choice((0.0, *_APART))
    for _ in range(int(rng.integers(1, 12))):
        at = int(rng.integers(len(triangles)))
        a, b, c = np.roll(triangles[at], int(rng.integers(3))).tolist()
        points.append(points[a] + rng.uniform(0, 1) * (points[b] - points[a]) + apart * rng.normal(size=3))
        triangles[at] = [a, len(points) - 1, c]
        triangles.append([len(points) - 1, b, c])
    return surface(np.array(points), triangles)


def _with(given: Surface, kept: np.ndarray) -> Surface:
    """Some of the triangles, at least one."""
    kept[0] |= not kept.any()
    return surface(given.points, given.triangles[kept])


TEARS: dict[str, Callable[[Surface, np.random.Generator], Surface]] = {
    "hole": _hole,
    "ragged hole": _ragged_hole,
    "without some": _without_some,
    "turned": _turned,
    "seams": _seams,
    "gaps": _gaps,
}
