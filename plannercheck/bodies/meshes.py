"""The hull of a mesh that is given as points with triangles."""

from __future__ import annotations

from plannercheck.bodies.shapes import Hull
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import distinct
from plannercheck.common.errors import PlannercheckError


def hull_of_triangles(points: Floats, triangles: Ints64) -> Hull:
    """The hull of the points (n, 3), m, that triangles (m, 3) use, or of all points if there are no triangles.

    Raises:
        PlannercheckError: If an index is beyond the points, or there is no hull.
    """
    used = distinct(triangles)
    if len(used) and not (used[0] >= 0 and used[-1] < len(points)):
        raise PlannercheckError(f"triangles use vertices {used[0]} to {used[-1]}, but there are {len(points)} vertices")
    return Hull(points[used] if len(used) else points)
