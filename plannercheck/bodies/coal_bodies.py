"""Prepared bodies in coal, which answers the same questions within a tolerance.

In: a `Polytope`. Out: coal's convex body.
"""

from __future__ import annotations

from typing import Any

from plannercheck.bodies.polytope import Polytope
from plannercheck.common.errors import PlannercheckError


def coal_hull(polytope: Polytope, name: str) -> Any:
    """A convex hull in coal."""
    import coal

    if polytope.dimension < 3:  # a segmentation fault in coal 3.0
        raise PlannercheckError(f"coal has no shape for {name}, which has no volume")
    points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    points.extend(list(polytope.vertices))
    triangles.extend([coal.Triangle(*face) for face in polytope.faces.tolist()])
    try:
        return coal.Convex(points, triangles)
    except RuntimeError as error:
        raise PlannercheckError(f"coal refuses {name}: {error}") from error
