"""Shapes as users give them: our own, arrays of points, and objects of trimesh, coal and python-fcl.

In: any of these. Out: one of our shapes with its pose. Boxes, spheres, capsules, cylinders and cones stay what they
are, trimesh's primitives included. Meshes, convex polytopes and points become their convex hulls, as mesh files do. No
library is imported for this: the user of such an object has imported its library.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import PurePath
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.ellipsoids import Ellipsoid
from plannercheck.bodies.half_spaces import HalfSpace
from plannercheck.bodies.shapes import (
    Box,
    Capsule,
    Cone,
    Cylinder,
    Hull,
    Shape,
    Sphere,
    checked_pose,
    inflated_hull,
)
from plannercheck.bodies.triangle_meshes import triangles_of_coal
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import distinct, unmasked
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError, shortened
from plannercheck.common.transforms import is_identity

# A trimesh.Trimesh, or a geometry or collision object of coal or python-fcl.
GeometryObject: TypeAlias = Any
GivenShape: TypeAlias = Shape | ArrayLike | GeometryObject
PlacedShape: TypeAlias = tuple[Shape, Floats | None]

_KNOWN = (
    "a shape such as Box, points (n, 3) in m, a trimesh.Trimesh, or a box, sphere, capsule, cylinder, cone, convex or "
    "mesh of coal or python-fcl"
)


def is_geometry(value: object) -> bool:
    """Whether a value is one of our shapes or an object of another library that may be one; arrays are not."""
    return isinstance(value, Shape) or _library(value) is not None


def given_shape(value: GivenShape, what: str) -> PlacedShape:
    """One of our shapes for a body as users give it, and its pose (4, 4) in the given frame, m; None for the identity.

    `what` is its name in errors, e.g. "object 'can'".

    Raises:
        PlannercheckError: If it is no body, or one whose points its library does not give.
    """
    if isinstance(value, Shape):
        return value, None
    library = _library(value)
    with error_context(what):
        return (Hull(points_given(value)), None) if library is None else _READERS[library](value)


def points_of_geometry(value: GivenShape, what: str) -> tuple[Floats, float]:
    """The points (n, 3) whose hull a body of another library is, in m, and how far around it the body reaches, m.

    Raises:
        PlannercheckError: If it is no body, or one with a pose of its own.
    """
    shape, pose = given_shape(value, what)
    if pose is not None and not is_identity(pose):
        raise PlannercheckError(f"{what} has a pose of its own, and a Polytope has none: give its geometry")
    points, _, inflation_radius = inflated_hull(shape)
    return points, inflation_radius


def in_frame(frame: Floats, pose: ArrayLike | None, what: str) -> Floats:
    """The product of two poses; of an identity with a pose, exactly that pose."""
    if pose is None or is_identity(frame):
        return frame if pose is None else checked_pose(pose, what)
    local = checked_pose(pose, what)
    if is_identity(local):
        return frame
    posed = core.placed_on_links(np.ascontiguousarray(frame)[None], np.ascontiguousarray(local)[None])[0]
    return checked_pose(posed, what)  # the C++ library's edits have these bits


def _library(value: object) -> str | None:
    """The library that defines an object's class or one of its base classes; arrays of a library are arrays."""
    if isinstance(value, np.ndarray):
        return None
    modules = {each.__module__.partition(".")[0] for each in type(value).__mro__}
    return next((name for name in _READERS if name in modules), None)


def points_given(value: GivenShape) -> Floats:
    """Points (n, 3) in m."""
    try:
        given = np.asarray(unmasked(value))
        points = np.asarray(given, dtype=np.float64) if given.dtype.kind in "fiu" else None
    except (TypeError, ValueError, OverflowError):
        points = None
    if points is None:
        hint = "; pc.Solid.load and Scene.add_mesh read files" if isinstance(value, str | PurePath) else ""
        raise PlannercheckError(f"a body must be {_KNOWN}, not {type(value).__name__} {shortened(repr(value))}{hint}")
    if points.ndim != 2 or points.shape[1] != 3:
        raise PlannercheckError(f"points of a body must have shape (n, 3), not {points.shape}")
    return points


def _of_trimesh(value: Any) -> PlacedShape:
    """The shape of a mesh, or of a primitive, which keeps its exact size."""
    kind, primitive = type(value).__name__, getattr(value, "primitive", None)
    if primitive is not None and kind in _PRIMITIVES:
        return _PRIMITIVES[kind](primitive), checked_pose(primitive.transform, f"trimesh's {kind}")
    if not hasattr(value, "vertices"):
        raise PlannercheckError(f"of trimesh, meshes are known, not {kind}: give each mesh, as scene.dump() lists them")
    faces = np.asarray(getattr(value, "faces", ()), dtype=np.int64)
    return hull_of_triangles(points_given(value.vertices), faces), None


_PRIMITIVES: dict[str, Callable[[Any], Shape]] = {
    "Box": lambda primitive: _box(primitive.extents),
    "Sphere": lambda primitive: Sphere(primitive.radius),
    "Cylinder": lambda primitive: Cylinder(primitive.radius, primitive.height),
    "Capsule": lambda primitive: Capsule(primitive.radius, primitive.height),
}


def _of_coal(value: Any) -> PlacedShape:
    import coal  # imported already, since it has made the value

    if isinstance(value, coal.CollisionObject):
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = value.getRotation(), value.getTranslation()
        return shape_of_coal(value.collisionGeometry()), checked_pose(pose, "coal's CollisionObject")
    return shape_of_coal(value), None


def shape_of_coal(value: Any) -> Shape:
    """Our shape for one of coal's; meshes and convex polytopes become hulls.

    Raises:
        PlannercheckError: For other shapes, and for a swept sphere radius around anything but spheres and capsules.
    """
    import coal

    radius = float(value.getSweptSphereRadius()) if hasattr(value, "getSweptSphereRadius") else 0.0
    shape = sized_shape_of_coal(value, radius)
    if radius and not isinstance(shape, Sphere | Capsule):
        raise PlannercheckError(f"coal's swept_sphere_radius {radius} is not supported: give the checker a padding")
    if shape is not None:
        return shape
    match value:
        case coal.ConvexBase():
            return Hull(np.array(value.points(), dtype=np.float64))
        case coal.TriangleP():
            return Hull(np.array([value.a, value.b, value.c], dtype=np.float64))
    mesh = triangles_of_coal(value)
    if mesh is None:
        raise PlannercheckError(f"a body must be {_KNOWN}, not coal's {type(value).__name__}")
    return hull_of_triangles(mesh.points, mesh.triangles)


def sized_shape_of_coal(value: Any, radius: float = 0.0) -> Shape | None:
    """Our shape for one of coal's that sizes describe, spheres and capsules larger by a radius, m; None for others."""
    import coal

    match value:
        case coal.Box():
            return _box(2 * np.asarray(value.halfSide))
        case coal.Sphere():
            return Sphere(value.radius + radius)
        case coal.Cylinder():
            return Cylinder(value.radius, 2 * value.halfLength)
        case coal.Capsule():
            return Capsule(value.radius + radius, 2 * value.halfLength)
        case coal.Cone():
            return Cone(value.radius, 2 * value.halfLength)
        case coal.Ellipsoid():
            return _ellipsoid(value.radii)
        case coal.Halfspace():
            return _half_space(value.n, value.d)
    return None


def _of_fcl(value: Any) -> PlacedShape:
    kind = type(value).__name__
    if kind in _FCL_SHAPES:
        return _FCL_SHAPES[kind](value), None
    if kind == "CollisionObject":
        raise PlannercheckError("python-fcl does not tell what a CollisionObject holds: give its geometry and pose")
    if kind in ("Convex", "BVHModel"):
        raise PlannercheckError(f"python-fcl does not tell the points of a {kind}: give the points themselves")
    raise PlannercheckError(f"a body must be {_KNOWN}, not python-fcl's {kind}")


_FCL_SHAPES: dict[str, Callable[[Any], Shape]] = {
    "Box": lambda shape: _box(shape.side),
    "Sphere": lambda shape: Sphere(shape.radius),
    "Capsule": lambda shape: Capsule(shape.radius, shape.lz),
    "Cylinder": lambda shape: Cylinder(shape.radius, shape.lz),
    "Cone": lambda shape: Cone(shape.radius, shape.lz),
    "Ellipsoid": lambda shape: _ellipsoid(shape.radii),
    "Halfspace": lambda shape: _half_space(shape.n, shape.d),
    "TriangleP": lambda shape: Hull(np.array([shape.a, shape.b, shape.c], dtype=np.float64)),
}


def _ellipsoid(radii: ArrayLike) -> Ellipsoid:
    x, y, z = np.asarray(radii, dtype=np.float64).tolist()
    return Ellipsoid((x, y, z))


def _half_space(normal: ArrayLike, offset: float) -> HalfSpace:
    x, y, z = np.asarray(normal, dtype=np.float64).tolist()
    return HalfSpace((x, y, z), offset)


def _box(size: ArrayLike) -> Box:
    x, y, z = np.asarray(size, dtype=np.float64).tolist()
    return Box((x, y, z))


_READERS: dict[str, Callable[[Any], PlacedShape]] = {"trimesh": _of_trimesh, "coal": _of_coal, "fcl": _of_fcl}


def hull_of_triangles(points: Floats, triangles: Ints64) -> Hull:
    """The hull of the points (n, 3), m, that triangles (m, 3) use, or of all points if there are no triangles.

    Raises:
        PlannercheckError: If an index is beyond the points, or there is no hull.
    """
    used = distinct(triangles)
    if len(used) and not (used[0] >= 0 and used[-1] < len(points)):
        raise PlannercheckError(f"triangles use vertices {used[0]} to {used[-1]}, but there are {len(points)} vertices")
    return Hull(points[used] if len(used) else points)
