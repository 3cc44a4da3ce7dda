"""Simple bodies around convex ones: balls, a capsule, a box. They contain the body, so they miss no collision.

In: a prepared body. Out: balls (k, 4) of centre and radius, a posed capsule or a posed box, in the body's frame, m.
Balls: the body is cut in two across its longest extent; then the part whose ball sticks out furthest is cut, and so on.
The parts make up the body, so their balls cover it. Boxes and capsules lie along the frame's axes or the principal
ones, whichever takes less volume.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import Box, Capsule
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench.hausdorff import heights

# Steps towards the furthest point: the ball is within some per cent of the least (Badoiu and Clarkson).
_STEPS = 32
# All volumes are enlarged by this part, far above rounding.
_GROWTH = 1e-9
_SMALLEST = 1e-9  # m; a box needs some thickness


def balls_around(body: Polytope, counts: Sequence[int]) -> dict[int, Floats]:
    """Covers of a body by several numbers of balls.

    Args:
        body: A body of any dimension; its inflation radius is covered as well.
        counts: How many balls, each at least 1.

    Returns:
        Balls (count, 4) by count: centre and radius, m. Fewer where a body can't be cut further.
    """
    covers: dict[int, Floats] = {}
    for balls in _refined(body, max(counts)):
        covers.update({count: balls for count in counts if len(balls) <= count})
    return covers


def _refined(body: Polytope, most: int) -> Iterator[Floats]:
    cells = [body]
    balls = [_ball(body.vertices, body.inflation_radius)]
    excess = [_excess(body, balls[0])]
    yield np.array(balls)
    while len(cells) < most:
        worst = int(np.argmax(excess))
        parts = _halves(cells[worst])
        if parts is None:
            return
        within = slice(worst, worst + 1)
        cells[within] = parts
        balls[within] = [_ball(part.vertices, body.inflation_radius) for part in parts]
        excess[within] = [_excess(body, ball) for ball in balls[worst : worst + len(parts)]]
        yield np.array(balls)


def _excess(body: Polytope, ball: Floats) -> float:
    """How far a ball sticks out of a body, up to its inflation radius; of a flat body the radius will do."""
    return float(ball[3] + (heights(ball[None, :3], body)[0] if len(body.faces) else 0.0))


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


def _halves(cell: Polytope) -> list[Polytope] | None:
    """Two parts of a body, cut in the middle of its longest extent; None if it has none."""
    axis = _principal_axes(cell.vertices)[:, 0]
    along = cell.vertices @ axis
    middle = (along.min() + along.max()) / 2
    if along.min() >= middle or along.max() <= middle:
        return None
    rim = _cut(cell, along - middle)
    try:
        return [Polytope(np.concatenate([cell.vertices[side], rim])) for side in (along <= middle, along >= middle)]
    except PlannercheckError:
        return None


def _cut(cell: Polytope, side: Floats) -> Floats:
    """Where the edges of a body meet a plane, (k, 3); `side` (n,) is each vertex's signed distance from it."""
    if len(cell.faces):
        edges = np.concatenate([cell.faces[:, [0, 1]], cell.faces[:, [1, 2]], cell.faces[:, [2, 0]]])
    else:  # of a flat body all diagonals will do: their cuts lie between those of the edges
        edges = np.stack(np.triu_indices(len(cell.vertices), 1), axis=1)
    crossing = edges[
        (side[edges[:, 0]] < 0) & (side[edges[:, 1]] > 0) | (side[edges[:, 0]] > 0) & (side[edges[:, 1]] < 0)
    ]
    a, b = crossing.T
    part = (side[a] / (side[a] - side[b]))[:, None]
    return np.asarray(cell.vertices[a] + part * (cell.vertices[b] - cell.vertices[a]))


def box_around(body: Polytope) -> tuple[Box, Floats]:
    """A box and its pose (4, 4) in the body's frame."""
    return min((_box_along(body, axes) for axes in _frames(body)), key=lambda found: np.prod(found[0].size))


def _box_along(body: Polytope, axes: Floats) -> tuple[Box, Floats]:
    along = body.vertices @ axes
    low, high = along.min(axis=0) - body.inflation_radius, along.max(axis=0) + body.inflation_radius
    size = (high - low) * (1 + _GROWTH) + _SMALLEST
    return Box(tuple(size.tolist())), _pose(axes, axes @ (low + high) / 2)


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
    return Capsule(radius, high - low + _SMALLEST), _pose(axes, axes @ np.array([seen[0], seen[1], (low + high) / 2]))


def _volume(capsule: Capsule) -> float:
    return np.pi * capsule.radius**2 * (capsule.length + 4 / 3 * capsule.radius)


def _frames(body: Polytope) -> list[Floats]:
    return [np.eye(3), _principal_axes(body.vertices)]


def _principal_axes(points: Floats) -> Floats:
    """A rotation (3, 3) whose columns are the principal axes of points, the longest first."""
    axes = np.linalg.eigh(np.cov(points.T) if len(points) > 1 else np.eye(3))[1][:, ::-1]
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return np.asarray(axes)


def _pose(axes: Floats, centre: Floats) -> Floats:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = axes, centre
    return pose
