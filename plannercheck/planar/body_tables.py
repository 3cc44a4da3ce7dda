"""The core's input for a planar checker: arrays of links and bodies, circles and boxes around these, and pairs.

In: a robot, convex polygons on its links and in the world. Out: arrays. Circles and boxes have room for their own
rounding and that of poses, so that they contain the polygons of the exact test.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.core import core
from plannercheck.planar.links import GeometryObject
from plannercheck.planar.robot import Robot

# Room for rounding in circles and boxes, as a part of the coordinates' size; the rounding is below 1e-14 of it.
_ROOM = 1e-12

# The least room, m: squares of lengths not far above 1e-162 have too few bits for comparisons.
_LEAST_ROOM = 1e-150


def core_model(robot: Robot, bodies: Sequence[GeometryObject], pairs: Ints) -> Any:
    """What the core's PlanarChecker and PlanarCertifier take (planar_arrays.hpp)."""
    return core.PlanarModel(
        *robot.core_links(),
        [body.vertices for body in bodies],
        np.array([body.link for body in bodies], dtype=np.int32),
        np.array([body.pose for body in bodies]).reshape(-1, 3, 3),
        np.array([_circle(body.vertices) for body in bodies]).reshape(-1, 3),
        np.array([_box(body) for body in bodies]).reshape(-1, 4),
        pairs,
    )


def pair_table(robot: Robot, bodies: int, self_collision: bool) -> Ints:
    """(k, 2) indices into all `bodies` bodies: the robot's, then the scene's."""
    own = robot.self_pairs() if self_collision else []
    fixed = _fixed_links(robot)
    others = range(len(robot.bodies), bodies)
    moving = [k for k, body in enumerate(robot.bodies) if body.link not in fixed]
    return np.array([*own, *((a, b) for a in moving for b in others)], dtype=np.int32).reshape(-1, 2)


def _fixed_links(robot: Robot) -> set[int]:
    """Links that no joint moves; as in space, they are not tested against the scene."""
    fixed: set[int] = set()
    for k, link in enumerate(robot.links):
        if link.joint == "fixed" and (k == 0 or robot.parent_index(k) in fixed):
            fixed.add(k)
    return fixed


def _circle(vertices: Floats) -> tuple[float, float, float]:
    """A circle around vertices: centre and radius, with room for its rounding and that of its pose."""
    x, y = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    radius = float(np.hypot(vertices[:, 0] - x, vertices[:, 1] - y).max())
    return float(x), float(y), radius + _ROOM * (radius + abs(float(x)) + abs(float(y))) + _LEAST_ROOM


def _box(body: GeometryObject) -> tuple[float, float, float, float]:
    """A box in the world around a posed polygon, with room for rounding."""
    posed = body.vertices @ body.pose[:2, :2].T + body.pose[:2, 2]
    room = (
        _ROOM * (float(np.abs(body.vertices).sum(axis=1).max()) + float(np.abs(body.pose[:2, 2]).sum())) + _LEAST_ROOM
    )
    (x0, y0), (x1, y1) = posed.min(axis=0) - room, posed.max(axis=0) + room
    return float(x0), float(y0), float(x1), float(y1)
