"""Prepared bodies in coal, which answers the same questions within a tolerance.

In: a `Polytope`, or a mesh. Out: coal's convex body, or coal's tree of boxes around triangles, which is a surface.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.polytope import Polytope
from plannercheck.common.array_types import Floats
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


def coal_mesh(points: Floats, triangles: NDArray[np.integer[Any]]) -> Any:
    """Triangles (m, 3) of points (n, 3), m, in coal: a surface, of the kind that Pinocchio makes of mesh files."""
    import coal

    vertices, corners = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    vertices.extend(list(points))
    corners.extend([coal.Triangle(*each) for each in triangles.tolist()])
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(triangles), len(points))
    model.addSubModel(vertices, corners)
    model.endModel()
    return model
