"""Convex bodies as python-fcl objects, to be posed and tested in pairs.

In: hull vertices, outward triangles and inflation radius of each body, then poses. Out: FCL's verdicts, and the pairs
whose boxes along the world's axes meet. Inflated points and segments become FCL's spheres and capsules. Flat hulls and
other inflated bodies are left out, since FCL has no form that handles them well.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.arrays import distinct
from plannercheck.common.errors import PlannercheckError

Indices = NDArray[Any]

# World boxes are widened by this part of their size and distance from the origin, far above a pose's rounding.
_BOX_SLACK = 1e-12
# Vertices of a segment.
_ENDS = 2
# Stands for the vertices of a body that no pair needs.
_UNUSED = np.zeros((1, 3))


class FclBodies:
    """Convex bodies as FCL collision objects.

    Attributes:
        vertices: The vertices of each body, (n, 3), m.
        inflation_radii: The inflation radius of each body, m.
        known: (bodies,) whether FCL has each body.
    """

    def __init__(
        self,
        bodies: Sequence[tuple[Floats, Indices] | None],
        inflation_radii: Sequence[float] | None = None,
        made: Mapping[int, Any] | None = None,
    ) -> None:
        """Hands the bodies to FCL.

        Args:
            bodies: Hull vertices (n, 3), m, and triangles (m, 3), counter-clockwise seen from outside, of
                each; no triangles if the hull has no volume.
            inflation_radii: Distance around each hull that belongs to the body, m; none if None.
            made: Geometries of FCL that stand for bodies, by index; the hulls hold them.

        Raises:
            PlannercheckError: If python-fcl is not installed.
        """
        self._fcl = load_fcl()
        self._request = self._fcl.CollisionRequest(num_max_contacts=1, enable_contact=False)
        self.vertices = [_UNUSED if body is None else np.asarray(body[0], dtype=np.float64) for body in bodies]
        self.inflation_radii = (
            [0.0] * len(bodies) if inflation_radii is None else [float(radius) for radius in inflation_radii]
        )
        forms = [
            None if body is None else self._form(*body, radius)
            for body, radius in zip(bodies, self.inflation_radii, strict=True)
        ]
        for k, geometry in (made or {}).items():
            forms[k] = self._fcl.CollisionObject(geometry), np.eye(4)
        self._objects: list[Any] = [None if form is None else form[0] for form in forms]
        self._placements = [np.eye(4) if form is None else form[1] for form in forms]
        self.known: Bools = np.array([form is not None for form in forms])
        lows = np.array([vertices.min(axis=0) for vertices in self.vertices])
        highs = np.array([vertices.max(axis=0) for vertices in self.vertices])
        self._centres, self._halves = (lows + highs) / 2, (highs - lows) / 2

    def place(self, body: int, pose: Floats) -> None:
        """Puts a body at a pose (4, 4), m."""
        placed = pose @ self._placements[body]
        self._objects[body].setTransform(self._fcl.Transform(placed[:3, :3], placed[:3, 3]))

    def collides(self, p: int, r: int) -> bool:
        """FCL's verdict on two placed bodies."""
        result = self._fcl.CollisionResult()
        return bool(self._fcl.collide(self._objects[p], self._objects[r], self._request, result))

    def collide_all(self, poses: Floats, pairs: Indices) -> list[bool]:
        """FCL's verdicts on pairs (k, 2) of bodies at poses (bodies, 4, 4)."""
        for body in distinct(pairs).tolist():
            self.place(body, poses[body])
        return [self.collides(p, r) for p, r in pairs.tolist()]

    def boxes_meet(self, poses: Floats, pairs: Indices) -> Bools:
        """Which pairs (k, 2) may meet at poses (n, bodies, 4, 4), by boxes along the world's axes; (n, k)."""
        turns = poses[..., :3, :3]
        centres = np.einsum("nbij,bj->nbi", turns, self._centres) + poses[..., :3, 3]
        halves = np.einsum("nbij,bj->nbi", np.abs(turns), self._halves) + np.array(self.inflation_radii)[:, None]
        halves += _BOX_SLACK * (np.abs(poses[..., :3, 3]) + np.abs(self._centres) + halves)
        p, r = pairs[:, 0], pairs[:, 1]
        near: Bools = np.all(np.abs(centres[:, p] - centres[:, r]) <= halves[:, p] + halves[:, r], axis=2)
        return near

    def _form(self, vertices: Floats, faces: Indices, inflation_radius: float) -> tuple[Any, Floats] | None:
        """The object and its placement (4, 4) in the body's frame; None if FCL has no fitting one."""
        if inflation_radius == 0:
            return (self._fcl.CollisionObject(fcl_hull(vertices, faces)), np.eye(4)) if len(faces) else None
        if len(vertices) > _ENDS:
            return None
        placement, length = _along_z(vertices[0], vertices[-1])
        shape = self._fcl.Capsule(inflation_radius, length) if length else self._fcl.Sphere(inflation_radius)
        return self._fcl.CollisionObject(shape), placement


def fcl_hull(vertices: Floats, faces: Indices) -> Any:
    """A convex hull in FCL, of vertices (n, 3), m, and outward triangles (m, 3)."""
    # FCL wants one flat list: for each face its number of corners, then the corners.
    flat = np.column_stack([np.full(len(faces), 3), faces]).ravel().tolist()
    return load_fcl().Convex(vertices, len(faces), flat)


def _along_z(start: Floats, end: Floats) -> tuple[Floats, float]:
    """The frame (4, 4) in the middle of a segment whose z-axis lies along it, and the segment's length."""
    placement, length = np.eye(4), float(np.linalg.norm(end - start))
    placement[:3, 3] = (start + end) / 2
    if length:
        frame, _ = np.linalg.qr(np.column_stack([(end - start) / length, np.eye(3)]))
        z, x = frame[:, 0], frame[:, 1]
        placement[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    return placement, length


def load_fcl() -> Any:
    """The module of python-fcl, or an error that says what to install."""
    try:
        import fcl
    except ImportError as error:
        raise PlannercheckError(
            "comparing with FCL needs python-fcl, which is not installed: pip install 'plannercheck[fcl]'"
        ) from error
    return fcl
