"""Points of a sensor against the robot: which points collide, and their distances.

In: a checker's robot, a configuration, points in the world. Out: `PointChecker` with `points_in_collision` and
`point_distances`, batches of points at one configuration. The scene plays no part, nor does the padding.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.arrays import Configuration
from plannercheck.robots.robot import Robot


class PointChecker(ABC):
    """A checker that tests points against its robot.

    Attributes:
        robot: The robot, with what its links carry.
        excess: How far polytopes of curved shapes stick out, as a part of the radius.
    """

    robot: Robot
    excess: float

    @abstractmethod
    def _link_poses(self, rows: Floats) -> Floats:
        """World poses of all links (n, links, 4, 4), m, at checked configurations."""

    @abstractmethod
    def _single(self, q: Configuration) -> Floats:
        """One configuration (nq,) as a row (1, nq)."""

    def points_in_collision(self, q: Configuration, points: ArrayLike, radius: ArrayLike = 0.0) -> Bools:
        """Which points are in the robot, or within a radius of it, at one configuration.

        Verdicts are exact, touching included, for the hulls and solids that the checker tests, without padding.

        Args:
            q: (nq,) rad and m, or each joint's value by its name.
            points: (n, 3) in the world, m.
            radius: One radius, or (n,), m.

        Returns:
            (n,), True for points within their radius of a link's body, or of an object that a link carries.

        Raises:
            PlannercheckError: If points are not finite or have another shape, or if a radius is negative.
        """
        return self.robot.link_points(self.excess).near(self._poses_at(q), points, radius)

    def point_distances(
        self, q: Configuration, points: ArrayLike, limit: float = math.inf, lower_bound: bool = False
    ) -> Floats:
        """The distance of each point from each link at one configuration.

        Args:
            q: (nq,) rad and m, or each joint's value by its name.
            points: (n, 3) in the world, m.
            limit: Distances beyond it, decided exactly, are infinite; the smaller it is, the faster this is. m.
            lower_bound: Whether to give the proved lower bound of each distance instead.

        Returns:
            (n, links) m, in the order of `robot.link_names`; objects count as parts of the links that carry them. A
            distance is within 1e-9 of max(distance, 1e-3 of the body's radius), and 0 if and only if the point is in
            the link. Infinite for links without bodies.

        Raises:
            PlannercheckError: If points are not finite or have another shape.
        """
        found, lower = self.robot.link_points(self.excess).distances(self._poses_at(q), points, limit)
        return lower if lower_bound else found

    def _poses_at(self, q: Configuration) -> Floats:
        row = self.robot.check_configurations(self._single(q))
        return np.asarray(self._link_poses(row)[0])
