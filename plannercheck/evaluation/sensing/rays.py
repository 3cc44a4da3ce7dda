"""Depth images by casting a ray through each pixel.

In: bodies (`GeometryObject`) with their poses, a camera and its pose. Out: how deep each pixel sees, m; what is nearer
hides what is behind. A ray enters a convex body through its last facet plane that faces the camera and leaves it by the
first that looks away. Balls have their equation, solids their triangles. A body is asked only about the pixels of the
rectangle that holds its image.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from plannercheck.bodies.polytope import prepared
from plannercheck.bodies.shapes import GeometryObject, Shape, Sphere
from plannercheck.bodies.solids import Solid
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct_rows
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.sensing.cameras import DepthCamera

# Curved shapes are seen as polytopes that stick out by this part of their radius.
_EXCESS = 5e-3
# A camera sees nothing nearer than this, m.
_NEAREST = 0.05
# Rays times facets that are computed at once: 16 MB of doubles.
_AT_ONCE = 2_000_000


def depth_image(bodies: Iterable[tuple[GeometryObject, Floats]], camera: DepthCamera, pose: Floats) -> Floats:
    """Depths (height, width), m, that a camera at a pose (4, 4) sees of bodies at their poses; 0 where no body is.

    Raises:
        PlannercheckError: If a body has no volume.
    """
    nearest = np.full((camera.height, camera.width), np.inf)
    directions = camera.directions
    to_camera = np.linalg.inv(pose)
    for body, placed in bodies:
        local = to_camera @ placed  # from the body's frame to the camera's
        corners = body.shape.vertices_and_faces(_EXCESS)[0] @ local[:3, :3].T + local[:3, 3]
        rows, columns = _window(corners, camera)
        rays = directions[rows, columns]
        if rays.size:
            found = _depths(body, local, rays.reshape(-1, 3)).reshape(rays.shape[:2])
            nearest[rows, columns] = np.minimum(nearest[rows, columns], found)
    nearest[~np.isfinite(nearest)] = 0.0
    return nearest


def _window(corners: Floats, camera: DepthCamera) -> tuple[slice, slice]:
    """The rows and columns that may see the hull of points (n, 3) in the camera's frame."""
    z = corners[:, 2]
    if z.max() <= _NEAREST:
        return slice(0, 0), slice(0, 0)
    if z.min() <= _NEAREST:
        return slice(0, camera.height), slice(0, camera.width)
    sides = ((camera.height, corners[:, 1] / z), (camera.width, corners[:, 0] / z))
    rows, columns = (_span(size, camera.focal_length * at + size / 2) for size, at in sides)
    return rows, columns


def _span(size: int, at: Floats) -> slice:
    """The pixels of a side of the image between the least and the largest place, one more at each end."""
    low, high = np.clip([np.floor(at.min()) - 1, np.ceil(at.max()) + 1], 0, size).astype(int).tolist()
    return slice(low, high)


def _depths(body: GeometryObject, local: Floats, rays: Floats) -> Floats:
    """(n,) how deep rays (n, 3) from the camera meet a body; infinite where they do not."""
    shape = body.shape
    if isinstance(shape, Sphere):
        return _of_ball(local[:3, 3], shape.radius, rays)
    if isinstance(shape, Solid):
        points, triangles = shape.used
        corners = (points @ local[:3, :3].T + local[:3, 3])[triangles]
        return _in_blocks(rays, len(triangles), lambda part: _of_triangles(corners, part))
    planes = _planes(shape, body.name)
    normals = planes[:, :3] @ local[:3, :3].T
    offsets = planes[:, 3] - normals @ local[:3, 3]
    return _in_blocks(rays, len(planes), lambda part: _of_planes(normals, offsets, part))


def _planes(shape: Shape, name: str) -> Floats:
    """Facet planes (m, 4) of a convex shape in its frame: n · x + d ≤ 0 inside."""
    hull = prepared(shape.vertices_and_faces(_EXCESS)[0], name=name)
    if hull.dimension < 3:
        raise PlannercheckError(f"body {name!r} has no volume that a camera could see")
    first, second, third = np.moveaxis(hull.vertices[hull.faces], 1, 0)
    normals = np.cross(second - first, third - first)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    planes = np.column_stack([normals, -np.einsum("ij,ij->i", normals, first)])
    return distinct_rows(np.round(planes, 12))[0]


def _in_blocks(rays: Floats, facets: int, depths: Callable[[Floats], Floats]) -> Floats:
    """Depths of rays (n, 3), so many at a time that all facets fit."""
    parts = np.array_split(rays, max(1, -(-len(rays) * facets // _AT_ONCE)))
    return np.concatenate([depths(part) for part in parts])


def _of_planes(normals: Floats, offsets: Floats, rays: Floats) -> Floats:
    slope = rays @ normals.T
    with np.errstate(divide="ignore", invalid="ignore"):
        at = -offsets / slope
    enters = np.where(slope < 0, at, -np.inf).max(axis=1)
    leaves = np.where(slope > 0, at, np.inf).min(axis=1)
    beside = ((slope == 0) & (offsets > 0)).any(axis=1)
    seen = (enters <= leaves) & (enters > _NEAREST) & ~beside
    return np.where(seen, enters, np.inf)


def _of_ball(centre: Floats, radius: float, rays: Floats) -> Floats:
    a, b = (rays * rays).sum(axis=1), rays @ centre
    inside = b * b - a * (centre @ centre - radius * radius)
    with np.errstate(invalid="ignore"):
        at = (b - np.sqrt(inside)) / a
    return np.where((inside >= 0) & (at > _NEAREST), at, np.inf)


def _of_triangles(corners: Floats, rays: Floats) -> Floats:
    """Of triangles (m, 3, 3), by Möller and Trumbore: the origin is the camera."""
    first, along, across = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(along, across)
    steepness = rays @ normal.T
    with np.errstate(divide="ignore", invalid="ignore"):
        u = rays @ np.cross(across, first).T / steepness
        v = rays @ np.cross(first, along).T / steepness
        at = (first * normal).sum(axis=1) / steepness
        hits = (u >= 0) & (v >= 0) & (u + v <= 1) & (at > _NEAREST)
    nearest: Floats = np.where(hits, at, np.inf).min(axis=1)
    return nearest
