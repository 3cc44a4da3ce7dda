"""Motions of solids at states in between, by coal on the meshes: an oracle that shares nothing with the core.

In: a checker of solids, motions. Out: whether surfaces meet or come near at states on them. Pinocchio poses, Pinocchio
or a slerp of Python interpolates, coal tests triangles. coal's bodies are surfaces, so coal does not find a body wholly
inside another.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.motion_paths import MotionPath
from plannercheck.evaluation.bench.other_libraries import (
    CoalQuery,
    coal_geometry_data,
    coal_geometry_model,
    coal_shape,
)
from plannercheck.motions.checker import Checker

# coal's tolerance for bodies that are no meshes, m.
_COAL_TOLERANCE = 1e-6
# Surfaces nearer than this have no normal that could be relied on, m.
_NO_NORMAL = 1e-12
# Turns with a smaller sine are alike, and interpolated linearly.
_ALIKE = 1e-8


class MeshStates:
    """A checker's bodies as coal's meshes, in states of its robot."""

    def __init__(self, checker: Checker) -> None:
        """Makes coal's bodies."""
        self._checker, self._query = checker, CoalQuery(checker, _COAL_TOLERANCE)
        self._model = checker.robot.model

    def collide(self, full: Floats) -> Bools:
        """(n,) whether surfaces meet at rows of Pinocchio's own numbers (n, nq of the model)."""
        return np.array([self._query.ask(row, True) for row in full], dtype=bool)

    def come_near(self, full: Floats, distance: float) -> bool:
        """Whether surfaces come within a distance, m, of each other at a row of Pinocchio's own numbers."""
        geometry, data = self._near
        for request in data.collisionRequests:
            request.security_margin = distance
        return bool(pin.computeCollisions(self._model, self._model.createData(), geometry, data, full, True))

    @cached_property
    def _near(self) -> tuple[Any, Any]:
        geometry = coal_geometry_model(self._checker)
        return geometry, coal_geometry_data(geometry, _COAL_TOLERANCE)

    def between(self, q0: Floats, q1: Floats, parameters: Floats, path: MotionPath) -> Floats:
        """(k, nq of the model) states of a motion between configurations (nq,), as Pinocchio has them."""
        start, end = self._checker.robot.expand(np.stack([q0, q1]))
        if path == "slerp":
            return np.stack([_straight(start, end, t) for t in parameters.tolist()])
        return np.stack([pin.interpolate(self._model, start, end, t) for t in parameters.tolist()])

    def contact(self, state: Floats, before: Floats) -> tuple[int, int, Floats, Floats] | None:
        """Where two bodies meet.

        Args:
            state: (nq,) at which they do.
            before: (nq,) near it, at which they do not.

        Returns:
            Index of a link that meets something; of the other one, or -1 for the world; a point (3,) there, m; the
            direction (3,) from the link to the other body. None if these surfaces do not show it.
        """
        checker = self._checker
        row = int(np.argmax(checker.colliding_pairs(state[None])[0]))
        a, b = sorted(checker.pairs[row].tolist(), key=lambda k: checker.bodies[k].link is None)
        poses, robot = checker.body_poses(before[None])[0], checker.robot
        shapes = [_shape(checker, k) for k in (a, b)]
        ends = [coal.Transform3s(poses[k][:3, :3], poses[k][:3, 3]) for k in (a, b)]
        request, result = coal.DistanceRequest(True), coal.DistanceResult()
        apart = coal.distance(shapes[0], ends[0], shapes[1], ends[1], request, result)
        first, second = np.array(result.getNearestPoint1()), np.array(result.getNearestPoint2())
        if not apart > _NO_NORMAL or not np.isfinite(first).all():
            return None
        link, other = checker.bodies[a].link, checker.bodies[b].link
        assert link is not None
        index = -1 if other is None else robot.link_index(other)
        return robot.link_index(link), index, first, (second - first) / np.linalg.norm(second - first)


def _shape(checker: Checker, k: int) -> Any:
    polytope = checker.polytopes[k]
    assert polytope is not None
    return coal_shape(checker.bodies[k], polytope)


def _straight(start: Floats, end: Floats, t: float) -> Floats:
    """A free body (7,): its position on a straight line, its turn the short way at constant speed."""
    a, b = start[3:], end[3:]
    cosine = float(a @ b)
    b, cosine = (-b, -cosine) if cosine < 0 else (b, cosine)
    angle = np.arctan2(float(np.linalg.norm(b - cosine * a)), cosine)
    if np.sin(angle) < _ALIKE:
        turn = (1 - t) * a + t * b
    else:
        turn = (np.sin((1 - t) * angle) * a + np.sin(t * angle) * b) / np.sin(angle)
    position = (1 - t) * start[:3] + t * end[:3]
    return np.concatenate([position, turn / np.linalg.norm(turn)])
