"""Triangles to draw: of the checked bodies, of the collision meshes, and of the visual meshes.

In: shapes, or a robot's name or file. Out: vertices (n, 3) in m and triangles (m, 3), in the body's frame. Curved
shapes are drawn coarser than they are checked.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.core_polytopes import fans
from plannercheck.bodies.half_spaces import HalfSpace
from plannercheck.bodies.height_fields import HeightField
from plannercheck.bodies.mesh_files import MeshFile
from plannercheck.bodies.polytope import prepared
from plannercheck.bodies.shapes import Hull, Shape
from plannercheck.bodies.solids import Solid
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.description import RobotDescription, description_of
from plannercheck.robots.link_bodies import read_bodies
from plannercheck.robots.loading import collision_meshes
from plannercheck.robots.urdf import read_model
from plannercheck.robots.urdf_file import MJCF_ROOT

Surface: TypeAlias = tuple[NDArray[np.float64], NDArray[np.int32]]

# How far drawn polytopes of curved shapes stick out, as a part of the radius: a circle has 32 corners.
_DRAWN_EXCESS = 5e-3
# Points of a height field that are drawn along each side, at most: 6 MB in a page.
_MOST_ALONG = 320


# A half-space is drawn as a square of twice this edge, m.
_HALF_PLATE = 2.0


def surface_of(shape: Shape, name: str) -> Surface:
    """The surface of a body.

    Of a hull the hull, of a solid its triangles, of a height field its upper side, of a half-space part of its plane.
    """
    if isinstance(shape, Solid):
        return shape.used
    if isinstance(shape, HeightField):
        return _ground(shape)
    if isinstance(shape, HalfSpace):
        plate = shape.plate(_HALF_PLATE)
        return plate, _sheet(plate)
    points, faces = shape.vertices_and_faces(_DRAWN_EXCESS)
    if isinstance(shape, Hull) or faces is None:
        hull = prepared(points, name=name)
        return hull.vertices, hull.faces if hull.dimension == 3 else _sheet(hull.vertices)
    return points, fans(faces, len(points), name)


def _ground(field: HeightField) -> Surface:
    """The upper side, every so-many-th point of it, so that it is not too large for a page; without holes."""
    every = -(-max(field.heights.shape) // _MOST_ALONG)
    i, j = (np.append(np.arange(0, n - 1, every), n - 1) for n in field.heights.shape)
    x, y = (start + step * at for start, step, at in zip(field.origin, field.resolution, (i, j), strict=True))
    heights = field.heights[np.ix_(i, j)]
    points = np.column_stack([np.repeat(x, len(j)), np.tile(y, len(i)), heights.ravel()])
    corner = (np.arange(len(i) - 1)[:, None] * len(j) + np.arange(len(j) - 1)).ravel()
    across = corner + len(j) + 1
    below = np.column_stack([corner, corner + len(j), across])
    above = np.column_stack([corner, across, corner + 1])
    triangles = np.concatenate([below, above]).astype(np.int32)
    is_there = np.isfinite(heights.ravel())
    return np.where(np.isfinite(points), points, field.base), triangles[is_there[triangles].all(axis=1)]


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
    """Triangles by name of the body of a robot's collision meshes as they were delivered, concave as they may be.

    The robot is as for `Robot.load`, or its description; bodies that are no meshes are left out.

    Raises:
        PlannercheckError: If the robot is planar, or one of its files can't be read.
    """
    description = description_of(robot)
    meshes = collision_meshes(description)
    if not meshes:
        raise PlannercheckError(
            f"robot {description.name or description.urdf.stem!r} has no collision meshes: its bodies are simple shapes"
        )
    return {name: _surface(mesh) for name, mesh in meshes.items()}


@dataclass(frozen=True, eq=False)
class Visual:
    """What a link looks like: one <visual> of the URDF.

    Attributes:
        name: Pinocchio's.
        link: The link that it is fixed to.
        pose: (4, 4) on the link, m.
        surface: Its triangles.
    """

    name: str
    link: str
    pose: NDArray[np.float64]
    surface: Surface


def visual_meshes(robot: str | Path | RobotDescription) -> tuple[Visual, ...]:
    """What a robot's links look like, by the <visual> elements of its URDF; the robot as for `delivered_meshes`.

    None, with a warning, if a mesh does not load, since no verdict depends on them.

    Raises:
        PlannercheckError: If the robot is planar, or its description can't be read.
    """
    description = description_of(robot)
    if description.robots:
        shown_of = {name: visual_meshes(description.of_robot(name)) for name in description.robots}
        return tuple(
            replace(each, name=f"{name}/{each.name}", link=f"{name}/{each.link}")
            for name, of_robot in shown_of.items()
            for each in of_robot
        )
    file = description.file
    if file.kind == MJCF_ROOT:
        warnings.warn(f"MJCF {file.path}: geoms that do not collide are not drawn", RuntimeWarning, stacklevel=2)
        return ()
    model = read_model(file, description.floating)
    try:
        shown = read_bodies(model, file, description.package_dirs, description.mesh_units, "visual")
    except PlannercheckError as error:
        warnings.warn(f"what its links look like is left out: {error!s:.200}", RuntimeWarning, stacklevel=2)
        return ()
    return tuple(
        Visual(
            body.name,
            str(body.link),
            body.pose,
            surface_of(body.shape, body.name) if mesh is None else _surface(mesh),
        )
        for body, mesh in zip(shown.bodies, shown.meshes, strict=True)
    )


def _surface(mesh: MeshFile) -> Surface:
    return mesh.points, mesh.triangles.astype(np.int32)
