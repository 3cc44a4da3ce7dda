"""Self-collision of a robot by coal on convex hulls: an oracle for validity shares, within coal's 1e-6 m.

In: a robot and pairs of its bodies. Out: which of them collide, configuration by configuration.
"""

import coal
import numpy as np
import pinocchio as pin
from pinocchio_geometry import pinocchio_geometry

from plannercheck.robots.description import find_description, read_description


class CoalHulls:
    """A robot's hulls in coal.

    Attributes:
        robot: The robot.
        pairs: (k, 2) pairs of its bodies that are tested.
    """

    def __init__(self, robot, pairs):
        self.robot, self.pairs = robot, pairs
        description = read_description(find_description(robot.name))
        self._geometry = pinocchio_geometry(robot.model, description.urdf, description.package_dirs)
        _replace_meshes_by_hulls(self._geometry)
        for a, b in pairs.tolist():
            self._geometry.addCollisionPair(pin.CollisionPair(a, b))
        self._data, self._geometry_data = robot.model.createData(), self._geometry.createData()

    def colliding(self, full):
        """bool (n, k) for Pinocchio's full configurations (n, full nq)."""
        return np.array([self._colliding(q) for q in full]).reshape(len(full), len(self.pairs))

    def _colliding(self, q):
        pin.computeCollisions(self.robot.model, self._data, self._geometry, self._geometry_data, q, False)
        return [result.isCollision() for result in self._geometry_data.collisionResults]


def _replace_meshes_by_hulls(geometry):
    hulls = {}  # a mesh that several links use is one hull
    for body in geometry.geometryObjects:
        key = (body.meshPath, *body.meshScale)
        if isinstance(body.geometry, coal.BVHModelBase):
            if key not in hulls:
                assert np.linalg.matrix_rank(np.ptp(body.geometry.vertices(), axis=0)[None]) == 1
                body.geometry.buildConvexHull(True, "Qt")
                hulls[key] = body.geometry.convex
            body.geometry = hulls[key]
