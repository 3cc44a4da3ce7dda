"""Triangles to draw: of the bodies that verdicts are about, and of the meshes as they were delivered.

In: shapes, or a robot's name or file. Out: vertices (n, 3) in m and triangles (m, 3), in the body's frame. Curved
shapes are drawn coarser than they are checked.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.polytope import fans, prepared
from plannercheck.bodies.shapes import Hull, Shape
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.description import RobotDescription, description_of
from plannercheck.robots.urdf import read_geometry, read_model

Surface: TypeAlias = tuple[NDArray[np.float64], NDArray[np.int32]]

# How far drawn polytopes of curved shapes stick out, as a part of the radius: a circle has 32 corners.
_DRAWN_EXCESS = 5e-3


def surface_of(shape: Shape, name: str) -> Surface:
    """The surface of a body: of a hull, the hull."""
    points, faces = shape.vertices_and_faces(_DRAWN_EXCESS)
    if isinstance(shape, Hull) or faces is None:
        hull = prepared(points, name=name)
        return hull.vertices, hull.faces if hull.dimension == 3 else _sheet(hull.vertices)
    return points, fans(faces, len(points), name)


def _sheet(corners: NDArray[np.float64]) -> NDArray[np.int32]:
    """Triangles of both sides of a convex polygon (n, 3) in any order; none of a segment or a point."""
    if len(corners) < 3:
        return np.zeros((0, 3), dtype=np.int32)
    centred = corners - corners.mean(axis=0)
    x, y, _ = (centred @ np.linalg.svd(centred, full_matrices=True)[2].T).T
    ring = np.argsort(np.arctan2(y, x)).astype(np.int32)
    above = np.column_stack([np.full(len(ring) - 2, ring[0]), ring[1:-1], ring[2:]])
    return np.concatenate([above, above[:, ::-1]])


def delivered_meshes(robot: str | Path | RobotDescription) -> dict[str, Surface]:
    """The collision meshes of a robot as they were delivered, concave as they may be.

    Args:
        robot: As for `Robot.load`, or its description.

    Returns:
        Triangles by name of the body; bodies that are no meshes are left out.

    Raises:
        PlannercheckError: If the robot is planar, or one of its files can't be read.
    """
    description = description_of(robot)
    model = read_model(description.file, description.floating)
    geometry = read_geometry(model, description.file, description.package_dirs)
    meshes = {each.name: each.geometry for each in geometry.geometryObjects if hasattr(each.geometry, "tri_indices")}
    if not meshes:
        raise PlannercheckError(
            f"robot {description.name or description.urdf.stem!r} has no collision meshes: its bodies are simple shapes"
        )
    return {name: _triangles(mesh) for name, mesh in meshes.items()}


def _triangles(mesh: Any) -> Surface:
    """Of coal's mesh, its scale applied."""
    rows = [[t[0], t[1], t[2]] for t in (mesh.tri_indices(k) for k in range(mesh.num_tris))]
    return np.array(mesh.vertices(), dtype=np.float64), np.array(rows, dtype=np.int32).reshape(-1, 3)
