"""Simple bodies around convex ones: a ball, a capsule, a box. They contain the body, so they miss no collision.

In: a prepared body. Out: a ball, capsule or box and its pose in the body's frame, m. Boxes and capsules lie along the
frame's axes or the principal ones, whichever takes less volume.
"""

from __future__ import annotations

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import Box, Capsule, Sphere
from plannercheck.common.array_types import Floats
from plannercheck.common.transforms import pose_of

# Steps towards the furthest point: the ball is within some per cent of the least (Badoiu and Clarkson).
_STEPS = 32
# All volumes are enlarged by this part, far above rounding.
_GROWTH = 1e-9
_SMALLEST = 1e-9  # m; a box needs some thickness


def ball_around(body: Polytope) -> tuple[Sphere, Floats]:
    """A ball and its pose (4, 4) in the body's frame."""
    ball = _ball(body.vertices, body.inflation_radius)
    return Sphere(float(ball[3])), pose_of(ball[:3])


def _ball(points: Floats, inflation_radius: float) -> Floats:
    """A ball (4,) about as small as any around points."""
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    best, least = centre, np.inf
    for step in range(1, _STEPS + 1):
        squares = ((points - centre) ** 2).sum(axis=1)
        if squares.max() < least:
            best, least = centre, squares.max()
        centre = centre + (points[int(squares.argmax())] - centre) / (step + 1)
    return np.append(best, (np.sqrt(least) + inflation_radius) * (1 + _GROWTH) + 1e-12)


def box_around(body: Polytope) -> tuple[Box, Floats]:
    """A box and its pose (4, 4) in the body's frame."""
    return min((_box_along(body, axes) for axes in _frames(body)), key=lambda found: np.prod(found[0].size))


def _box_along(body: Polytope, axes: Floats) -> tuple[Box, Floats]:
    along = body.vertices @ axes
    low, high = along.min(axis=0) - body.inflation_radius, along.max(axis=0) + body.inflation_radius
    size = (high - low) * (1 + _GROWTH) + _SMALLEST
    return Box(tuple(size.tolist())), pose_of(axes @ (low + high) / 2, axes)


def capsule_around(body: Polytope) -> tuple[Capsule, Floats]:
    """A capsule and its pose (4, 4) in the body's frame."""
    turned = (np.roll(axes, k, axis=1) for axes in _frames(body) for k in range(3))
    return min((_capsule_along(body, axes) for axes in turned), key=lambda found: _volume(found[0]))


def _capsule_along(body: Polytope, axes: Floats) -> tuple[Capsule, Floats]:
    """Along the third axis: a ball around the points seen along it gives axis and radius; the ends move inwards."""
    along = body.vertices @ axes
    seen = _ball(along * [1, 1, 0], 0.0)
    reach = np.sqrt(np.maximum(seen[3] ** 2 - ((along[:, :2] - seen[:2]) ** 2).sum(axis=1), 0))
    low, high = (along[:, 2] + reach).min(), (along[:, 2] - reach).max()
    low, high = min(low, (low + high) / 2), max(high, (low + high) / 2)  # a ball would do: any point between
    radius = (seen[3] + body.inflation_radius) * (1 + _GROWTH) + _SMALLEST
    return Capsule(radius, high - low + _SMALLEST), pose_of(axes @ np.array([seen[0], seen[1], (low + high) / 2]), axes)


def _volume(capsule: Capsule) -> float:
    return np.pi * capsule.radius**2 * (capsule.length + 4 / 3 * capsule.radius)


def _frames(body: Polytope) -> list[Floats]:
    return [np.eye(3), _principal_axes(body.vertices)]


def _principal_axes(points: Floats) -> Floats:
    """A rotation (3, 3) whose columns are the principal axes of points, the longest first."""
    axes = np.linalg.eigh(np.cov(points.T) if len(points) > 1 else np.eye(3))[1][:, ::-1]
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return np.asarray(axes)
