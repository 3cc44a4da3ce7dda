"""Points in the world against the bodies of a robot's links.

In: a robot's bodies, poses of its links, points in m. Out: `LinkPoints`, which tells points that are within a radius of
some body, exactly, and measures how far points are from each link (cpp/checking/points_near_bodies). Bodies are
prepared when points are first asked for.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.ellipsoids import Ellipsoid
from plannercheck.bodies.polytope import Polytope, prepared
from plannercheck.bodies.shapes import (
    DEFAULT_EXCESS,
    Box,
    Capsule,
    Cone,
    Cylinder,
    GeometryObject,
    Hull,
    Sphere,
    inflated_hull,
)
from plannercheck.bodies.solids import Solid
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.arrays import contiguous, shown_array
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError

# What points are tested against: hulls, and solids.
_KNOWN = (Box, Sphere, Cylinder, Cone, Capsule, Ellipsoid, Hull, Solid)


class LinkPoints:
    """The bodies of a robot's links, ready for points."""

    def __init__(self, bodies: Sequence[GeometryObject], links: Sequence[int], excess: float = DEFAULT_EXCESS) -> None:
        """Prepares the bodies.

        Args:
            bodies: Bodies on links.
            links: The index of each body's link.
            excess: How far polytopes of curved shapes may stick out, as a part of the radius.

        Raises:
            PlannercheckError: If a body is neither a hull nor a solid.
        """
        for body in bodies:
            if not isinstance(body.shape, _KNOWN):
                kind = type(body.shape).__name__
                raise PlannercheckError(
                    f"points can't be tested against link {body.link!r}, which has a {kind}: test it in a scene instead"
                )
        self._links = np.array(links, dtype=np.int32)
        self._placements = np.array([body.pose for body in bodies], dtype=np.float64).reshape(-1, 4, 4)
        self._bodies = [_prepared(body, excess).core for body in bodies]

    def near(self, link_poses: Floats, points: ArrayLike, radius: ArrayLike) -> Bools:
        """Which points (n, 3) are within their radius (n,) of some body at poses (links, 4, 4), m; touching counts."""
        rows = checked_points(points)
        radii = _checked_radii(radius, len(rows))
        return np.asarray(core.points_near_bodies(self._bodies, self._body_poses(link_poses), rows, radii)).view(bool)

    def distances(self, link_poses: Floats, points: ArrayLike, limit: float) -> tuple[Floats, Floats]:
        """How far points (n, 3) are from links at poses (links, 4, 4): distances and lower bounds, (n, links) each, m.

        They are infinite beyond the limit and for links without bodies.
        """
        rows, count = checked_points(points), len(link_poses)
        if not (isinstance(limit, int | float | np.number) and limit >= 0):
            raise PlannercheckError(f"limit must be a distance in m of at least 0, not {limit!r}")
        poses, limits = self._body_poses(link_poses), np.array([limit], dtype=np.float64)
        found, lower = core.distances_of_points(self._bodies, poses, self._links.tolist(), count, rows, limits)
        return found, lower

    def _body_poses(self, link_poses: Floats) -> Floats:
        return np.asarray(core.placed_on_links(np.ascontiguousarray(link_poses[self._links]), self._placements))


def checked_points(points: ArrayLike) -> Floats:
    """Points (n, 3) in m as the core reads them.

    Raises:
        PlannercheckError: If they are no such array, or not finite; the first such row is named.
    """
    try:
        rows = contiguous(points)
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"points must be numbers of shape (n, 3) in m, not {shown_array(points)}") from None
    if rows.ndim != 2 or rows.shape[1] != 3:
        raise PlannercheckError(f"points must have shape (n, 3), not {rows.shape}")
    if not np.isfinite(rows).all():
        bad = np.flatnonzero(~np.isfinite(rows).all(axis=1))
        row = int(bad[0])
        raise PlannercheckError(
            f"points: row {row} is {rows[row].tolist()}, coordinates must be finite ({len(bad)} such rows)"
        )
    return rows


def _checked_radii(radius: ArrayLike, count: int) -> Floats:
    try:
        radii = np.atleast_1d(contiguous(radius))
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"radius must be a length in m, or one for each point, not {radius!r:.80}") from None
    if radii.shape not in {(1,), (count,)}:
        raise PlannercheckError(f"radius must be one number or {count}, one for each point, not of shape {radii.shape}")
    if not (np.isfinite(radii) & (radii >= 0)).all():
        raise PlannercheckError(f"radius must be finite and not negative (m), not {radius!r:.80}")
    return radii


def _prepared(body: GeometryObject, excess: float) -> Polytope:
    points, faces, inflation_radius = inflated_hull(body.shape, excess)
    found = prepared(points, faces, inflation_radius, f"body {body.name!r}")
    return found.of_solid(body.shape) if isinstance(body.shape, Solid) else found
