"""Convex bodies as python-fcl objects, to be posed and tested in pairs.

In: hull vertices and outward triangles of each body, then poses. Out: FCL's verdicts, and which pairs can
meet at all by boxes along the world's axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.errors import PlannercheckError

Array = NDArray[np.float64]
Indices = NDArray[Any]
Flags = NDArray[np.bool_]

# World boxes are widened by this part of their distance from the origin and size, far above a pose's
# rounding.
_BOX_SLACK = 1e-12
# Stands for the vertices of a body that no pair needs.
_UNUSED = np.zeros((1, 3))


class FclBodies:
    """Convex bodies as FCL collision objects.

    Attributes:
        vertices: Of each body, (n, 3), m.
    """

    def __init__(self, bodies: Sequence[tuple[Array, Indices] | None]) -> None:
        """Hands the bodies to FCL.

        Args:
            bodies: Hull vertices (n, 3), m, and triangles (m, 3), counter-clockwise seen from outside, of
            each.

        Raises:
            PlannercheckError: If python-fcl is not installed.
        """
        self._fcl = _load_fcl()
        self._request = self._fcl.CollisionRequest(num_max_contacts=1, enable_contact=False)
        self.vertices = [_UNUSED if body is None else np.asarray(body[0], dtype=np.float64) for body in bodies]
        self._objects: list[Any] = [None if body is None else self._convex(*body) for body in bodies]
        lows = np.array([vertices.min(axis=0) for vertices in self.vertices])
        highs = np.array([vertices.max(axis=0) for vertices in self.vertices])
        self._centres, self._halves = (lows + highs) / 2, (highs - lows) / 2

    def place(self, body: int, pose: Array) -> None:
        """Puts a body at a pose (4, 4), m."""
        self._objects[body].setTransform(self._fcl.Transform(pose[:3, :3], pose[:3, 3]))

    def collides(self, p: int, r: int) -> bool:
        """FCL's verdict on two placed bodies."""
        result = self._fcl.CollisionResult()
        return bool(self._fcl.collide(self._objects[p], self._objects[r], self._request, result))

    def collide_all(self, poses: Array, pairs: Indices) -> list[bool]:
        """FCL's verdicts on pairs (k, 2) of bodies at poses (bodies, 4, 4)."""
        for body in np.unique(pairs).tolist():
            self.place(body, poses[body])
        return [self.collides(p, r) for p, r in pairs.tolist()]

    def boxes_meet(self, poses: Array, pairs: Indices) -> Flags:
        """Which pairs (k, 2) may meet at poses (n, bodies, 4, 4), by boxes along the world's axes; (n, k)."""
        turns = poses[..., :3, :3]
        centres = np.einsum("nbij,bj->nbi", turns, self._centres) + poses[..., :3, 3]
        halves = np.einsum("nbij,bj->nbi", np.abs(turns), self._halves)
        halves += _BOX_SLACK * (np.abs(poses[..., :3, 3]) + np.abs(self._centres) + halves)
        p, r = pairs[:, 0], pairs[:, 1]
        near: Flags = np.all(np.abs(centres[:, p] - centres[:, r]) <= halves[:, p] + halves[:, r], axis=2)
        return near

    def _convex(self, vertices: Array, faces: Indices) -> Any:
        # FCL wants one flat list: for each face its number of corners, then the corners.
        flat = np.column_stack([np.full(len(faces), 3), faces]).ravel().tolist()
        return self._fcl.CollisionObject(self._fcl.Convex(vertices, len(faces), flat))


def _load_fcl() -> Any:
    try:
        import fcl
    except ImportError as error:
        raise PlannercheckError(
            "comparing with FCL needs python-fcl, which is not installed: pip install 'plannercheck[fcl]'"
        ) from error
    return fcl
