"""Planar robots and obstacles as flat prisms, so that they are drawn like any others.

In: a planar checker, configurations. Out: `Mesh`es about z = 0, and the common points of colliding pairs.
"""

from __future__ import annotations

import numpy as np

from plannercheck.bodies.circumscribed import prism_faces
from plannercheck.bodies.core_polytopes import fans
from plannercheck.common.array_types import Bools, Floats
from plannercheck.planar.certificates import SharedPoint
from plannercheck.planar.checker import Checker
from plannercheck.view.model import OBSTACLE_OPACITY, Mesh, Witness
from plannercheck.view.surfaces import Surface

# Height of the robot's prisms as a part of the size of its largest body; obstacles are a little lower.
_HEIGHT, _LOWER = 0.1, 0.8


def planar_meshes(checker: Checker, rows: Floats, hit: Bools) -> list[Mesh]:
    """A mesh for each polygon at configurations (n, nq), in which `hit` (n, bodies) collide."""
    poses = checker.body_poses(rows)
    names = checker.robot.link_names
    height = _HEIGHT * max(float(np.ptp(body.vertices, axis=0).max()) for body in checker.robot.bodies)
    drawn = []
    for k, body in enumerate(checker.bodies):
        is_link = body.link >= 0
        at = _in_space(poses[:, k] if is_link else poses[:1, k])
        surface = _prism(body.vertices, height if is_link else _LOWER * height)
        owner = names[body.link] if is_link else body.name
        opacity = 1.0 if is_link else OBSTACLE_OPACITY
        drawn.append(Mesh(body.name, owner, "hull" if is_link else "obstacle", *surface, at, hit[:, k], opacity))
    return drawn


def planar_witnesses(checker: Checker, rows: Floats, colliding: Bools) -> list[Witness]:
    """The common points of all colliding pairs of configurations (n, nq)."""
    points = []
    for frame in np.flatnonzero(colliding.any(axis=1)).tolist():
        for verdict in checker.explain(rows[frame]).collisions:
            assert isinstance(verdict.certificate, SharedPoint)
            points.append(Witness(frame, (verdict.first, verdict.second), np.append(verdict.certificate.point, 0.0)))
    return points


def _prism(polygon: Floats, height: float) -> Surface:
    """Over a convex polygon (n, 2) in either orientation, about z = 0."""
    x, y = polygon.T
    area = float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
    corners = polygon if area > 0 else polygon[::-1]
    low = np.column_stack([corners, np.full(len(corners), -height / 2)])
    points = np.vstack([low, low * (1.0, 1.0, -1.0)])
    return points, fans(prism_faces(len(corners)), len(points), "prism")


def _in_space(poses: Floats) -> Floats:
    """(n, 3, 3) poses in the plane as (n, 4, 4) in space."""
    out = np.tile(np.eye(4), (len(poses), 1, 1))
    out[:, :2, :2], out[:, :2, 3] = poses[:, :2, :2], poses[:, :2, 2]
    return out
