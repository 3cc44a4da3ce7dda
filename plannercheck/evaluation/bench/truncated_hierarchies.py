"""Hierarchies cut off at a level: the bodies that a query would know if it stopped there.

In: a prepared body. Out: nested coarser bodies, one for each level. The hull of the vertices alive at a level of the
inner hierarchy is inside the body (it misses collisions). The facets alive at a level of the polar hierarchy bound a
body around it (it reports too many). Queries stop at 64 points, which they scan; here the hierarchies continue, by the
same rule, down to a tetrahedron.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.common.array_types import Floats, Ints64

# As in cpp/bodies/hierarchy.hpp: vertices of at most this degree are removed.
_REMOVED_DEGREE = 8
# Fewer points bound no body.
_FEWEST = 4
# Outer bodies are enlarged by this part, far above the rounding of their corners, so that they contain the body.
_GROWTH = 1e-12
# Outer bodies that reach out further than this times the body's radius are of no use.
_LONGEST = 2.0


def inner_levels(body: Polytope) -> list[Polytope]:
    """Coarser and coarser bodies within a body with volume, the finest first, the body itself left out."""
    return [Polytope(body.vertices[level]) for level in alive_levels(body)]


def alive_levels(body: Polytope) -> list[Ints64]:
    """Indices of a body's vertices that are alive at each level of its inner hierarchy, the finest level left out."""
    return _alive(body.vertices, np.asarray(body.core.levels(False)))


def outer_levels(body: Polytope) -> list[Polytope]:
    """Coarser and coarser bodies around a body with volume, the finest first, the body itself left out.

    The coarsest levels may be missing: their facets bound nothing, or nothing of use.
    """
    points = np.asarray(body.core.polar_points())
    if len(points) == 0:
        return []
    levels = []
    for level in _alive(points, np.asarray(body.core.levels(True))):
        outer = _bounded_by(points[level], body)
        if outer is None:
            break
        levels.append(outer)
    return levels


def _alive(points: Floats, level: Ints64) -> list[Ints64]:
    """Indices of the points alive at each level above 0: as the core has them, then by more rounds of removal."""
    levels = [np.flatnonzero(level >= k) for k in range(1, int(level.max()) + 1)]
    levels += _further(points, levels[-1] if levels else np.arange(len(points)))
    return levels


def _further(points: Floats, alive: Ints64) -> Iterator[Ints64]:
    while len(alive) > _FEWEST:
        hull = Polytope(points[alive])
        kept = _without_independent(hull)
        alive = alive[hull.source[kept]]
        if Polytope(points[alive]).dimension < 3:
            return
        yield alive


def _without_independent(hull: Polytope) -> Ints64:
    """The vertices left when independent ones of small degree are removed, the smallest degree first."""
    neighbours: list[set[int]] = [set() for _ in hull.vertices]
    for face in hull.faces.tolist():
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            neighbours[a].add(b)
            neighbours[b].add(a)
    blocked: set[int] = set()
    removed: list[int] = []
    for v in sorted(range(len(neighbours)), key=lambda v: len(neighbours[v])):
        if v in blocked or len(neighbours[v]) > _REMOVED_DEGREE or len(neighbours) - len(removed) == _FEWEST:
            continue
        removed.append(v)
        blocked |= neighbours[v]
    return np.setdiff1d(np.arange(len(neighbours)), removed, assume_unique=True)


def _bounded_by(polar_points: Floats, body: Polytope) -> Polytope | None:
    """The body {x: q·(x − centre) <= 1 for these polar points q}; None if it is unbounded, or so long as to be useless.

    Nearly equal facets make corners that doubles can't tell: they are computed in fractions.
    """
    dual = Polytope(polar_points)
    exact = np.array([[Fraction(x) for x in row] for row in dual.vertices.tolist()], dtype=object)
    a, b, c = (exact[dual.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    offsets = (normals * a).sum(axis=1)
    if offsets.min() <= 0:
        return None
    corners = np.array(normals / offsets[:, None], dtype=np.float64)
    if np.linalg.norm(corners, axis=1).max() > _LONGEST * body.core.radius:
        return None
    return Polytope(body.centre + corners * (1 + _GROWTH))
