"""Solids that are nearly their hulls: convex bodies with shallow dents, with a hollow inside or without.

In: about how many triangles, a random generator. Out: a `Surface` about 1 m across.

Corners of a convex body, and points within its triangles, are pushed in by a part of their distance from the middle: by
about a rounding, up to the core's limit of shallow dents, or deeper.
"""

from __future__ import annotations

import numpy as np

from plannercheck.evaluation.stress_solids.surfaces import Surface, ball, joined, octahedron, surface

# Parts of the distance from the middle; the core takes dents below 1/16 for shallow.
_DEPTHS = (0.0, 2.0**-50, 2.0**-30, 1e-7, 1e-4, 1e-3, 1e-2, 0.05, 0.07, 0.3)
# How much longer a body may be along an axis.
_STRETCHES = (1.0, 1.0, 3.0, 20.0)
# Of the points: those pushed in.
_SHARES = (0.05, 0.3, 1.0)
# Shells about the middle, as parts of the body: about it once more, or a hollow.
_SHELLS = (0.001, 0.3, 0.9)


def dented(n: int, rng: np.random.Generator) -> Surface:
    """A ball or an octahedron, stretched, with dents."""
    convex = ball(max(8, n // 3)) if rng.integers(2) else octahedron()
    points, triangles = _split(convex) if rng.integers(3) else (convex.points.copy(), convex.triangles)
    pushed = rng.random(len(points)) < rng.choice(_SHARES)
    points[pushed] *= 1 - rng.choice(_DEPTHS) * rng.random((int(pushed.sum()), 1))
    found = surface(points, triangles)
    if rng.random() < 0.3:
        shell = octahedron().scaled(float(rng.choice(_SHELLS)) / 2)
        found = joined([found, shell.inverted if rng.integers(2) else shell])
    return found.moved(np.diag(rng.choice(_STRETCHES, 3)) / max(_STRETCHES), np.zeros(3)).scaled(max(_STRETCHES) / 3)


def _split(convex: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles with one more point in the middle of each triangle."""
    a, b, c = convex.triangles.T
    middle = len(convex.points) + np.arange(len(convex.triangles))
    points = np.vstack([convex.points, convex.points[convex.triangles].mean(axis=1)])
    return points, np.vstack(
        [np.stack(corners, axis=1) for corners in ((a, b, middle), (b, c, middle), (c, a, middle))]
    )
