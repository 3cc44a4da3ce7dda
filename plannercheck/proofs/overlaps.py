"""How deep two bodies are in each other, by a closed surface around 0, or by a point (`link_pairs.py` has the claim).

In: maps of both bodies, an overlap. Out: whether the hulls are deeper in each other than a length. Let a surface's
triangles be such that each directed edge has its opposite once, and 0 is behind each triangle's plane. Then the solid
angles that triangles have as seen from 0 are positive and add up to a multiple of a whole sphere, so that a ray in any
direction meets a triangle, beyond its plane's distance. All corners are differences of points of the hulls, so the hull
of all differences holds a ball around 0 of the least distance. Bodies with radii have all differences of their hulls,
and the ball of both radii around each: so does the ball around 0, and the one around a mean of corners holds a smaller
one around 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from flint import arb, arb_mat

from plannercheck.common.array_types import Floats
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.link_pairs import Overlap


def is_deeper(
    overlap: Overlap,
    first: tuple[Floats, Any],
    second: tuple[Floats, Any],
    depth: float,
    radii: tuple[float, float] = (0.0, 0.0),
) -> bool:
    """Whether an overlap shows that bodies are deeper in each other than a length, m, at least 0.

    Bodies are vertices (n, 3) with a map, 4 x 4; radii are how far each reaches around its vertices' hull, m.

    Raises:
        UnprovedError: If the surface is not closed, or has corners that there are not, or weights are none.
    """
    if overlap.weights:
        _check_weights(overlap)
    else:
        _check_closed(overlap)
    moved = [
        _moved(*side, [point[k] for point in overlap.points], what)
        for k, (side, what) in enumerate(((first, "first"), (second, "second")))
    ]
    corners = [[a - b for a, b in zip(*both, strict=True)] for both in zip(*moved, strict=True)]
    left = arb(depth) - radii[0] - radii[1]  # what the hulls themselves have to be deep
    if overlap.weights:
        return _is_near(corners, overlap.weights, -left)
    return all(_is_behind([corners[k] for k in facet], left) for facet in overlap.facets)


def _check_weights(overlap: Overlap) -> None:
    weights = overlap.weights
    if overlap.facets or len(weights) != len(overlap.points) or not all(0 < w < math.inf for w in weights):
        raise UnprovedError("the weights of an overlap are not one positive number a corner, without facets")


def _check_closed(overlap: Overlap) -> None:
    edges = [edge for a, b, c in overlap.facets for edge in ((a, b), (b, c), (c, a))]
    known = set(edges)
    if not edges or len(known) < len(edges) or any((b, a) not in known for a, b in edges):
        raise UnprovedError("the surface of an overlap is not closed")
    if not all(0 <= k < len(overlap.points) for edge in edges for k in edge):
        raise UnprovedError("the surface of an overlap has a corner that there is not")


def _moved(vertices: Floats, matrix: Any, rows: Sequence[int], what: str) -> list[list[Any]]:
    """Some vertices, mapped."""
    if not all(0 <= row < len(vertices) for row in rows):
        raise UnprovedError(f"an overlap names a vertex that the {what} body has not")
    points = (matrix * arb_mat(4, 1, [*vertices[row].tolist(), 1]) for row in rows)
    return [point.entries()[:3] for point in points]


def _is_near(corners: Sequence[Sequence[Any]], weights: Sequence[float], distance: Any) -> bool:
    """Whether the mean of corners is nearer to 0 than a distance."""
    total = sum((arb(w) for w in weights), arb(0))
    axes = zip(*corners, strict=True)
    sums = [sum((arb(w) * x for w, x in zip(weights, axis, strict=True)), arb(0)) for axis in axes]
    length = sum((x * x for x in sums), arb(0)).nonnegative_part().sqrt()
    return bool(length < distance * total)


def _is_behind(facet: Sequence[Sequence[Any]], depth: Any) -> bool:
    """Whether 0 is behind a triangle's plane, further than a length, which may be negative."""
    u, v, w = facet
    (x0, y0, z0), (x1, y1, z1) = ([b - a for a, b in zip(u, end, strict=True)] for end in (v, w))
    normal = (y0 * z1 - z0 * y1, z0 * x1 - x0 * z1, x0 * y1 - y0 * x1)
    length = sum((x * x for x in normal), arb(0)).nonnegative_part().sqrt()
    height = sum((x * y for x, y in zip(normal, u, strict=True)), arb(0))
    return bool(height > 0) and bool(height > depth * length)
