"""A robot as balls against the obstacles of a scene, judged by the core in floats, eight states at once.

In: a checker and balls around its robot's bodies. Out: a judge of configurations that misses none of the checker's
collisions. Obstacles are boxes, balls, capsules and cylinders in closed form; others are given by the planes of their
facets (near an edge a little too large). Balls are enlarged by the error of floats.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import Box, Capsule, Cylinder, GeometryObject, Sphere
from plannercheck.common.array_types import Floats
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench.hausdorff import planes
from plannercheck.motions.checker import Checker

# Of an obstacle, as in cpp/evaluation/sphere_model.hpp.
_ROUNDED_BOX, _CYLINDER, _PLANES = range(3)
# The error of floats, as a part of the largest coordinates: some twenty roundings of 2^-24 each.
_FLOAT_ERROR = 2.0**-19


class SphereModel:
    """Judges configurations of a robot made of balls.

    Attributes:
        covers: The balls (k, 4) of each body, as given.
        margin: Length by which the balls grow, m.
    """

    def __init__(self, checker: Checker, covers: Mapping[int, Floats]) -> None:
        """Hands balls and obstacles to the core.

        Args:
            checker: Whose pairs are judged, those that can meet within the limits.
            covers: Balls (k, 4), centre and radius in m, in the frame of each of the robot's bodies that a pair needs.

        Raises:
            PlannercheckError: If Pinocchio itself has to pose the robot.
        """
        if checker.robot.kinematics is None:
            raise PlannercheckError(f"only the compiled kinematics poses spheres, and {checker.robot.name} has none")
        self.covers = covers
        self._kinematics = checker.robot.kinematics
        self.margin = _FLOAT_ERROR * _largest_coordinate(checker)
        own = sorted(covers)
        links = [checker.robot.link_index(str(checker.bodies[k].link)) for k in own]
        balls = [_with_bound(_on_link(covers[k], checker.bodies[k].pose), self.margin) for k in own]
        pairs = checker.pairs[~checker.unreachable]  # as the checker: others can't meet within the limits
        used = sorted({int(k) for k in pairs.ravel() if checker.bodies[k].link is None})
        place = {body: k for k, body in enumerate([*own, *used])}
        obstacles = [_obstacle(checker.bodies[k], checker.polytopes[k], checker.excess) for k in used]
        sides = [plane for _, _, plane in obstacles]
        self._core = core.SphereModel(
            np.array(links, dtype=np.int32),
            np.concatenate([*balls, np.zeros((0, 4))]),
            _starts(balls),
            np.array([kind for kind, _, _ in obstacles], dtype=np.int32),
            np.array([np.linalg.inv(checker.bodies[k].pose) for k in used]).reshape(-1, 4, 4),
            np.array([size for _, size, _ in obstacles], dtype=np.float64).reshape(-1, 4),
            np.concatenate([*sides, np.zeros((0, 4))]),
            _starts(sides),
            np.array([[place[a], place[b]] for a, b in pairs.tolist()], dtype=np.int32).reshape(-1, 2),
            len(checker.robot.link_names),
        )

    def check_states(self, q: Floats) -> NDArray[np.bool_]:
        """Whether no balls meet, for configurations (n, nq); (n,)."""
        return np.asarray(self._core.check_states(self._kinematics, q)).view(bool)

    @property
    def nbytes(self) -> int:
        """Memory of balls and obstacles in bytes."""
        return int(self._core.bytes())


def _largest_coordinate(checker: Checker) -> float:
    """Bounds coordinates at random configurations, and sizes of bodies and obstacles, generously; m."""
    poses = checker.body_poses(checker.robot.random_configurations(64, 0))
    far = float(np.nanmax(np.abs(poses[..., :3, 3]))) if poses.size else 0.0
    reach = max(
        (float(p.core.origin_radius + p.inflation_radius) for p in checker.polytopes if p is not None), default=0.0
    )
    return 2 * far + 2 * reach + 1


def _with_bound(balls: Floats, margin: float) -> Floats:
    """A ball around all, and then the balls."""
    balls = np.column_stack([balls[:, :3], balls[:, 3] + margin])
    centre = np.average(balls[:, :3], axis=0, weights=balls[:, 3])
    radius = (np.linalg.norm(balls[:, :3] - centre, axis=1) + balls[:, 3]).max()
    return np.vstack([np.append(centre, radius + margin), balls])


def _on_link(balls: Floats, pose: Floats) -> Floats:
    return np.column_stack([balls[:, :3] @ pose[:3, :3].T + pose[:3, 3], balls[:, 3]])


def _obstacle(body: GeometryObject, polytope: Polytope | None, excess: float) -> tuple[int, tuple[float, ...], Floats]:
    """Kind, half sizes with the rounding, and planes (k, 4) of an obstacle in its own frame."""
    none = np.zeros((0, 4))
    match body.shape:
        case Box(size=(x, y, z)):
            return _ROUNDED_BOX, (x / 2, y / 2, z / 2, 0.0), none
        case Sphere(radius=radius):
            return _ROUNDED_BOX, (0.0, 0.0, 0.0, radius), none
        case Capsule(radius=radius, length=length):
            return _ROUNDED_BOX, (0.0, 0.0, length / 2, radius), none
        case Cylinder(radius=radius, length=length):
            return _CYLINDER, (radius * (1 + excess), 0.0, length / 2, 0.0), none
    assert polytope is not None
    return _PLANES, (0.0, 0.0, 0.0, 0.0), _planes(polytope)


def _planes(polytope: Polytope) -> Floats:
    """Facets' planes (k, 4), equal ones once; of a flat body those of a box around it."""
    if len(polytope.faces) == 0:
        low, high = polytope.vertices.min(axis=0), polytope.vertices.max(axis=0)
        return np.column_stack([np.vstack([np.eye(3), -np.eye(3)]), np.concatenate([high, -low])])
    return np.unique(np.column_stack(planes(polytope)).round(12), axis=0)


def _starts(parts: list[Any]) -> NDArray[np.int32]:
    return np.concatenate([[0], np.cumsum([len(part) for part in parts])]).astype(np.int32)
