"""Convex pieces of polygons, by shapely's constrained triangulation.

In: simple polygons as vertices (n, 2) in order. Out: convex polygons that cover the same points. A convex polygon stays
as it is. The pieces of a concave one are triangles of its own vertices, so nothing is rounded.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import read_only_copy
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module
from plannercheck.planar.convexity import convexity_fault
from plannercheck.planar.polygons import checked_polygon


@set_module("plannercheck.planar")
def convex_pieces(outline: ArrayLike, name: str = "polygon") -> tuple[Floats, ...]:
    """The convex pieces of a simple polygon.

    Args:
        outline: Vertices (n, 2) in order, either way round, m.
        name: For errors.

    Returns:
        Read-only arrays (k, 2): the polygon itself if it is convex, else triangles.

    Raises:
        PlannercheckError: If the outline crosses or repeats itself, or if it is concave and shapely is not installed.
    """
    vertices = checked_polygon(outline, name)
    if not np.isfinite(vertices).all():
        raise PlannercheckError(f"{name} has vertices that are not finite")
    pieces = [vertices] if convexity_fault(vertices) is None else _triangles(vertices, name)
    return tuple(read_only_copy(piece) for piece in pieces)


def _triangles(vertices: Floats, name: str) -> list[Floats]:
    try:
        import shapely
    except ImportError:
        raise PlannercheckError(
            f"{name} is concave, and splitting it needs shapely: pip install 'plannercheck[planar]'"
        ) from None
    polygon = shapely.Polygon(vertices)
    if not polygon.is_valid:
        raise PlannercheckError(f"{name} is no simple polygon: {shapely.is_valid_reason(polygon)}")
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    return [shapely.get_coordinates(triangle)[:3] for triangle in triangles]
