"""The default bounds for planning with free bodies: a box around all obstacles that they may have to go around.

In: a checker, configurations that the box has to include. Out: `default_bounds`, (2, 3) m.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plannercheck.bodies.shapes import GeometryObject, inflated_hull
from plannercheck.common.array_types import Floats
from plannercheck.motions.checker import Checker
from plannercheck.robots.joints import JointKind, kind_of

# So many times as far as the robot reaches, it has room on each side of the obstacles: it gets past them.
_ROOM = 2.0


def default_bounds(checker: Checker, held: Sequence[Floats]) -> Floats | None:
    """A box (2, 3), m, of positions of the root, if that is a floating or planar joint on the world without limits.

    It includes the configurations held. None for other robots, and if there is nothing to be around.
    """
    robot = checker.robot
    kind = kind_of(robot.model.joints[1])
    if kind is None or not kind.is_pose or robot.joint_names[0] != robot.model.names[1]:
        return None
    to_joint = robot.model.jointPlacements[1].inverse().homogeneous
    obstacles = checker.bodies[len(robot.bodies) :]
    points = [_corners(body, body.pose, checker.excess) for body in obstacles]
    inside = [rows @ to_joint[:3, :3].T + to_joint[:3, 3] for rows in points]
    inside += [_position(kind, q)[None] for q in held]
    if not inside:
        return None
    around = np.concatenate(inside)
    room = _ROOM * _size(checker)
    return np.stack([around.min(axis=0) - room, around.max(axis=0) + room])


def _size(checker: Checker) -> float:
    """How far bodies reach from the root's origin at the reference, m."""
    robot = checker.robot
    poses = robot.link_poses(robot.reference)
    origin = _root(checker, robot.reference)
    far = 0.0
    for body in robot.bodies:
        if body.link is not None:
            corners = _corners(body, poses[robot.link_index(body.link)] @ body.pose, checker.excess)
            far = max(far, float(np.linalg.norm(corners - origin, axis=1).max()))
    return far


def _root(checker: Checker, q: Floats) -> Floats:
    """(3,) where the root's origin is, m."""
    robot = checker.robot
    kind = kind_of(robot.model.joints[1])
    assert kind is not None
    placed = robot.model.jointPlacements[1]
    return np.asarray(placed.rotation @ _position(kind, q) + placed.translation)


def _position(kind: JointKind, q: Floats) -> Floats:
    """(3,) of a root in its placement, m."""
    return np.array([*q[: kind.lengths], *[0.0] * (3 - kind.lengths)])


def _corners(body: GeometryObject, pose: Floats, excess: float) -> Floats:
    """(2, 3) the least and the largest corner of the box around a body at a pose, m."""
    hull, _, radius = inflated_hull(body.shape, excess)
    points = hull @ pose[:3, :3].T + pose[:3, 3]
    return np.stack([points.min(axis=0) - radius, points.max(axis=0) + radius])
