"""How often two links collide as meshes, not as hulls, by coal's test of triangles.

In: a robot's description, pairs of links, configurations. Out: in how many of them the surfaces intersect. The test is
not exact, and it misses a mesh that lies wholly within another one. It shows whether two hulls collide because they are
larger than their meshes.
"""

from __future__ import annotations

import coal

from plannercheck.common.array_types import Floats
from plannercheck.robots.description import RobotDescription
from plannercheck.robots.robot import Robot
from plannercheck.robots.urdf import bodies_of, read_geometry


class LinkMeshes:
    """The collision meshes of a robot's links, as their files have them."""

    def __init__(self, robot: Robot, description: RobotDescription) -> None:
        """Loads the meshes; `description` is the robot's."""
        geometry = read_geometry(robot.model, description.file, description.package_dirs)
        self._robot = robot
        self._bodies: dict[str, list[tuple[coal.CollisionGeometry, Floats]]] = {}
        for body, each in zip(bodies_of(robot.model, geometry), geometry.geometryObjects, strict=True):
            self._bodies.setdefault(str(body.link), []).append((each.geometry, body.pose))

    def collisions(self, link_a: str, link_b: str, q: Floats) -> int:
        """The number of configurations (n, nq) in which the surfaces of two links intersect."""
        poses = self._robot.link_poses(q)
        ends = [poses[:, self._robot.link_index(link)] for link in (link_a, link_b)]
        return sum(self._collide(link_a, link_b, a, b) for a, b in zip(*ends, strict=True))

    def _collide(self, link_a: str, link_b: str, pose_a: Floats, pose_b: Floats) -> bool:
        return any(
            _intersect(first, pose_a @ on_a, second, pose_b @ on_b)
            for first, on_a in self._bodies[link_a]
            for second, on_b in self._bodies[link_b]
        )


def _intersect(a: coal.CollisionGeometry, pose_a: Floats, b: coal.CollisionGeometry, pose_b: Floats) -> bool:
    transforms = [coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in (pose_a, pose_b)]
    return bool(coal.collide(a, transforms[0], b, transforms[1], coal.CollisionRequest(), coal.CollisionResult()))
