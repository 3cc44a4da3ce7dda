"""Hulls of meshes: of files, and of points with triangles.

In: a path and a scale, or arrays. Out: the hull in m.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from plannercheck.bodies.mesh_files import named_file, points_of_file, warn_of_size
from plannercheck.bodies.shapes import Hull
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.errors import PlannercheckError


def load_mesh(path: str | Path, scale: float | Sequence[float] = 1.0) -> Hull:
    """Loads the points of a mesh.

    Args:
        path: The file.
        scale: One factor, or one along each axis, from the file's unit to m.

    Returns:
        The hull of the scaled points.
    """
    points = points_of_file(path, scale)
    with named_file(path):
        hull = Hull(points)
    warn_of_size(path, points, stacklevel=3)
    return hull


def hull_of_triangles(points: Floats, triangles: Ints64) -> Hull:
    """The hull of the points that a mesh's triangles use, or of all points if there are no triangles.

    Args:
        points: (n, 3) m.
        triangles: (m, 3) indices of points.

    Raises:
        PlannercheckError: If an index is beyond the points, or there is no hull.
    """
    used = np.unique(triangles)
    if len(used) and not (used[0] >= 0 and used[-1] < len(points)):
        raise PlannercheckError(f"triangles use vertices {used[0]} to {used[-1]}, but there are {len(points)} vertices")
    return Hull(points[used] if len(used) else points)
