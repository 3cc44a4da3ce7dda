"""Collision shapes of links and obstacles, before any hull is built.

In: sizes in metres (as URDF and coal give them) or points. Out: `Shape` dataclasses, each of which gives its vertices
and faces as a convex polytope, and `GeometryObject`, a named shape with a rigid pose on a link or in the world.

Shapes are centred at their frame's origin and lie along z; a cone's apex is at +length/2. Boxes and hulls are exact;
concave bodies are in solids.py, ellipsoids in ellipsoids.py, half-spaces in half_spaces.py. Curved shapes become
polytopes that contain them and stick out by at most `excess` times the radius: cylinders and cones are the prism and
pyramid over a polygon around the circle, a capsule is a sphere's polytope, cut along its ring of points at z = 0 and
pulled apart. Faces with more than three corners are flat exactly. A size of zero makes a plate, a segment or a point,
which is a body like any other.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.bodies.circumscribed import (
    BOX_SIGNS,
    ball_around,
    capsule_faces,
    checked_excess,
    prism_faces,
    ring_around,
    segment,
    without_volume,
)
from plannercheck.bodies.ellipsoids import Ellipsoid
from plannercheck.bodies.half_spaces import HalfSpace, check_stands_still
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.sizes import array_of, length, numbers
from plannercheck.bodies.solids import Solid
from plannercheck.common.array_types import Faces
from plannercheck.common.arrays import read_only
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module
from plannercheck.common.transforms import identity

Points: TypeAlias = NDArray[np.float64]

# How far the polytope of a cylinder or cone sticks out, as a part of its radius: 5 µm for a link of 5 cm.
DEFAULT_EXCESS = 1e-4

# The longest capsule, in radii, whose rounded end caps are surely convex, facet by facet.
_MAX_CAPSULE_RATIO = 1e6

# The largest Frobenius norm of M^T M - 1 that counts as the rounding of a rotation (the project's contract).
RIGID_TOLERANCE = 1e-6

# The same for a body on a link, whose pose may itself be not exactly rigid (robots/unit_lengths.py).
POSED_TOLERANCE = 3.6e-6


@set_module("plannercheck")
@dataclass(frozen=True)
class Box:
    """A box about its centre.

    Attributes:
        size: Full edge lengths along x, y, z in m.
    """

    size: tuple[float, float, float]

    def __post_init__(self) -> None:
        size = numbers(self.size, "box size")
        if len(size) != 3:
            raise PlannercheckError(f"box size needs 3 edge lengths in m, not {len(size)}: {list(size)}")
        if not (0 < size[0] < math.inf and 0 < size[1] < math.inf and 0 < size[2] < math.inf):  # few; texts take time
            size = tuple(length(s, f"box size {c}") for s, c in zip(size, "xyz", strict=True))
        object.__setattr__(self, "size", size)

    def vertices_and_faces(self, excess: float = DEFAULT_EXCESS) -> tuple[Points, Faces | None]:
        """The eight corners (8, 3) in m and six quadrilaterals, exact whatever the excess."""
        if min(self.size) / 2 == 0:  # so is half of the smallest double
            corners = itertools.product(*({-edge / 2, edge / 2} for edge in self.size))
            return np.array(list(corners)) + 0.0, None
        return BOX_SIGNS * (np.array(self.size) / 2), prism_faces(4)


@set_module("plannercheck")
@dataclass(frozen=True)
class Sphere:
    """A sphere about its centre.

    Attributes:
        radius: In m.
    """

    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", length(self.radius, "sphere radius"))

    def vertices_and_faces(self, excess: float = DEFAULT_EXCESS) -> tuple[Points, Faces | None]:
        """A polytope (n, 3) in m around the sphere and its triangles."""
        ball = ball_around(checked_excess(excess))
        if self.radius == 0:
            return np.zeros((1, 3)), None
        return self.radius * ball.points, list(ball.triangles)


@dataclass(frozen=True)
class _AlongZ:
    """A radius and a length along z, in m."""

    radius: float
    length: float

    def __post_init__(self) -> None:
        kind = type(self).__name__.lower()
        object.__setattr__(self, "radius", length(self.radius, f"{kind} radius"))
        object.__setattr__(self, "length", length(self.length, f"{kind} length"))


@set_module("plannercheck")
@dataclass(frozen=True)
class Cylinder(_AlongZ):
    """A cylinder along z about its centre.

    Attributes:
        radius: In m.
        length: Full length in m.
    """

    def vertices_and_faces(self, excess: float = DEFAULT_EXCESS) -> tuple[Points, Faces | None]:
        """A prism (2 k, 3) in m over a polygon around the circle, and its faces."""
        ring = ring_around(self.radius, checked_excess(excess))
        if self.radius == 0 or self.length == 0:
            return without_volume(ring, self.length), None
        low = np.column_stack([ring, np.full(len(ring), -self.length / 2)])
        return np.vstack([low, low * (1.0, 1.0, -1.0)]), prism_faces(len(ring))


@set_module("plannercheck")
@dataclass(frozen=True)
class Cone(_AlongZ):
    """A cone along z, its apex at z = +length/2 and its base at z = -length/2.

    Attributes:
        radius: Radius of the base, in m.
        length: Full length in m.
    """

    def vertices_and_faces(self, excess: float = DEFAULT_EXCESS) -> tuple[Points, Faces | None]:
        """A pyramid (k + 1, 3) in m over a polygon around the base circle, and its faces."""
        ring = ring_around(self.radius, checked_excess(excess))
        if self.radius == 0 or self.length == 0:
            return without_volume(ring, self.length), None
        base = np.column_stack([ring, np.full(len(ring), -self.length / 2)])
        k = np.arange(len(ring))
        sides = np.column_stack([k, np.roll(k, -1), np.full(len(k), len(k))])
        return np.vstack([base, [0.0, 0.0, self.length / 2]]), [k[::-1].copy(), *sides]


@set_module("plannercheck")
@dataclass(frozen=True)
class Capsule(_AlongZ):
    """All points within a radius of a segment along z.

    Attributes:
        radius: In m.
        length: Length of the segment (the cylindrical part), in m.
    """

    def vertices_and_faces(self, excess: float = DEFAULT_EXCESS) -> tuple[Points, Faces | None]:
        """A polytope (n, 3) in m around the capsule; faces are None only for lengths over a million radii."""
        ball = ball_around(checked_excess(excess))
        if self.radius == 0:
            return segment(self.length), None
        if self.length == 0:
            return self.radius * ball.points, list(ball.triangles)
        height = ball.lattice[:, 2]
        upper, lower = np.flatnonzero(height >= 0), np.flatnonzero(height <= 0)
        points = self.radius * ball.points[np.concatenate([upper, lower])]
        shift = np.repeat([self.length / 2, -self.length / 2], [len(upper), len(lower)])
        points[:, 2] = np.nextafter(points[:, 2] + shift, shift * np.inf)  # rounded away from the centre: contains
        known = self.length <= _MAX_CAPSULE_RATIO * self.radius
        return points, capsule_faces(ball, upper, lower) if known else None


@set_module("plannercheck")
@dataclass(frozen=True, eq=False, repr=False)
class Hull:
    """The convex hull of points; meshes end up here, with their scale applied.

    Attributes:
        vertices: (n, 3) in m, read-only; points inside the hull and repeated points are allowed.
    """

    vertices: Points

    def __post_init__(self) -> None:
        vertices = array_of(self.vertices, "hull vertices")
        if vertices.ndim != 2 or vertices.shape[1] != 3:
            raise PlannercheckError(f"hull vertices must have shape (n, 3), not {vertices.shape}")
        if len(vertices) < 4:
            raise PlannercheckError(f"hull vertices: a body needs at least 4 points, here are {len(vertices)}")
        bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
        if len(bad):
            row = int(bad[0])
            raise PlannercheckError(f"hull vertices: row {row} is {vertices[row].tolist()}, coordinates must be finite")
        object.__setattr__(self, "vertices", read_only(vertices))

    def vertices_and_faces(self, excess: float = DEFAULT_EXCESS) -> tuple[Points, Faces | None]:
        """The points (n, 3) in m as given; faces are None, since the hull has to be computed."""
        return self.vertices, None

    def __repr__(self) -> str:
        return f"Hull({len(self.vertices)} points)"


InflatedHull: TypeAlias = tuple[Points, Faces | None, float]
Shape: TypeAlias = Box | Sphere | Cylinder | Cone | Capsule | Ellipsoid | Hull | Solid | PartSet | HalfSpace


def inflated_hull(shape: Shape, excess: float = DEFAULT_EXCESS) -> InflatedHull:
    """The input of the pair test: a hull, and how far around it the body reaches.

    Spheres and capsules are exact: a point and a segment, inflated by the radius. Cylinders and cones become the
    polytopes around them.

    Args:
        shape: The shape.
        excess: For cylinders and cones, how far the polytope may stick out, as a part of the radius.

    Returns:
        Points (n, 3) in m, their hull's faces if known, and the inflation radius in m.
    """
    if isinstance(shape, Sphere):
        return np.zeros((1, 3)), None, shape.radius
    if isinstance(shape, Capsule):
        return segment(shape.length), None, shape.radius
    return *shape.vertices_and_faces(excess), 0.0


@dataclass(frozen=True, eq=False, slots=True)
class GeometryObject:
    """A collision body: a shape, posed on its link, or in the world.

    Attributes:
        name: The name of the collision geometry or object, unique in its robot or scene.
        link: The link that it moves with; None for obstacles.
        pose: (4, 4) rigid transform in m from the shape's frame to the link's or the world's, read-only.
        shape: The shape.
        carried: The name of the carried object that this is a part of; None for the link's own bodies.
    """

    name: str
    link: str | None
    pose: Points = field(repr=False)
    shape: Shape
    carried: str | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "pose", checked_pose(self.pose, f"body {self.name!r}"))
        check_stands_still(self.name, self.link, [self.shape])

    @property
    def label(self) -> str:
        """Its name in reports: that of the carried object, else of the link, else its own."""
        return self.carried or self.link or self.name


def checked_pose(pose: ArrayLike | None, what: str, tolerance: float = RIGID_TOLERANCE) -> Points:
    """A read-only float64 copy of a rigid transform (4, 4), m, whose doubles do not change; None is the identity.

    `what` is posed, e.g. "body 'shelf'", for errors; `tolerance` is the largest ||M^T M - 1|| of its rotation.
    """
    if pose is None:
        return read_only(identity())
    if core.is_surely_rigid(pose, tolerance):  # most of all, and no subclass of arrays; what follows takes 10 µs
        return read_only(np.array(pose, dtype=np.float64))
    return read_only(_checked_matrix(pose, what, tolerance))


def _checked_matrix(pose: ArrayLike, what: str, tolerance: float) -> Points:
    """The same without the core: converts, and says what is wrong."""
    matrix = array_of(pose, f"pose of {what}")
    if matrix.shape != (4, 4):
        raise PlannercheckError(
            f"pose of {what} must be a homogeneous matrix of shape (4, 4), not {matrix.shape}: the rotation is "
            "[:3, :3], the position [:3, 3]"
        )
    if not np.isfinite(matrix).all():
        raise PlannercheckError(f"pose of {what} has values that are not finite: {matrix.tolist()}")
    if matrix[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        turned = "; it looks transposed" if matrix[:, 3].tolist() == [0.0, 0.0, 0.0, 1.0] else ""
        raise PlannercheckError(f"pose of {what}: last row must be 0 0 0 1, not {matrix[3].tolist()}{turned}")
    _check_rotation(matrix[:3, :3], what, tolerance)
    return matrix


def checked_poses(poses: ArrayLike, what: str) -> Points:
    """A float64 copy of rigid transforms (n, 4, 4), m, as of `checked_pose`; errors name the first wrong row."""
    rows = [checked_pose(row, f"{what}[{i}]") for i, row in enumerate(array_of(poses, f"poses of {what}"))]
    return np.array(rows, dtype=np.float64, order="C").reshape(-1, 4, 4)


def _check_rotation(rotation: Points, what: str, tolerance: float) -> None:
    """Raises if a 3 x 3 matrix is no rotation up to rounding."""
    error = float(np.linalg.norm(rotation.T @ rotation - np.eye(3)))
    if not error <= tolerance:
        error = math.inf if math.isnan(error) else error  # infinite products may be of either sign
        raise PlannercheckError(f"pose of {what} is not rigid: |M^T M - 1| is {error:.3g}, accepted is {tolerance:g}")
    if np.linalg.det(rotation) < 0:
        raise PlannercheckError(f"pose of {what} is a reflection: det M is -1, a rotation has +1")
