"""Sampled motions of planar robots: how many states a straight motion needs.

In: a robot, motions. Out: how many steps they need so that no point moves further than a given distance in a step. The
bound is a sum over the numbers of a configuration of the largest distance that one unit moves a point: 1 for x and y
together as a length; for an angle, the longest chain from its joint to a point that it carries.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import read_only
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.motion_ends import shorter_turn
from plannercheck.motions.sampling import MOST_STEPS, checked_resolution
from plannercheck.planar.robot import Robot

# Between two states no point moves further than this, in m: a tenth of the usual step for mobile robots.
DEFAULT_RESOLUTION = 1e-2

# Room for the rounding of the way, which is a sum of products.
_ROUNDING = 1 + 1e-12


class MotionSampler:
    """Interpolates straight motions of one robot and computes how many states they need."""

    def __init__(self, robot: Robot) -> None:
        """Computes the lever arms of the robot's angles, and how far it reaches from its root, m."""
        self._robot, self._angles = robot, np.flatnonzero(robot.angles)
        self.levers, self.extent = _lever_arms(robot)

    def steps(self, q0: Floats, q1: Floats, resolution: float | None) -> NDArray[np.int64]:
        """How many steps each motion (n, nq) to (n, nq) needs: no point moves over `resolution` m in one."""
        return self.steps_of_way(self.way(q1 - q0), resolution)

    def shorter_turn(self, q0: Floats, q1: Floats) -> Floats:
        """Ends (…, nq) with unlimited angles within half a turn of the starts'; the same array if they already are."""
        return shorter_turn(q0, q1, self._angles)

    def way(self, differences: Floats) -> Floats:
        """(n,) m: bounds on how far points travel on straight motions with these differences (n, nq)."""
        sliding = np.hypot(differences[:, 0], differences[:, 1]) if self._robot.is_free else 0.0
        return np.asarray(sliding + np.abs(differences) @ self.levers)

    def steps_of_way(self, way: Floats, resolution: float | None) -> NDArray[np.int64]:
        """How many steps are needed where no point travels further than `way` (n,), m."""
        resolution = checked_resolution(resolution, DEFAULT_RESOLUTION)
        steps = np.maximum(1, np.ceil(way * _ROUNDING / resolution))
        if not (steps <= MOST_STEPS).all():
            raise PlannercheckError(
                f"motion {int(np.argmax(way))} moves points {way.max():.3g} m, more than {MOST_STEPS:g} steps of "
                f"{resolution:g} m: choose a coarser resolution or a shorter motion"
            )
        return steps.astype(np.int64)

    def states(self, q0: Floats, q1: Floats, parameters: Floats) -> Floats:
        """States (k, nq) of one straight motion at parameters (k,) in [0, 1]: the very doubles of the core."""
        return np.asarray((1 - parameters)[:, None] * q0 + parameters[:, None] * q1)


def _lever_arms(robot: Robot) -> tuple[Floats, float]:
    """(nq,) lever arms in m per rad, 0 for x and y; and the robot's reach from the root's frame, m."""
    extent = np.zeros(len(robot.links))  # of the bodies that a link carries, from its own frame
    for body in robot.bodies:
        extent[body.link] = max(extent[body.link], float(np.hypot(*body.vertices.T).max()))
    for k in range(len(robot.links) - 1, 0, -1):
        parent = robot.parent_index(k)
        extent[parent] = max(extent[parent], extent[k] + float(np.hypot(*robot.links[k].anchor[:2])))
    levers = np.zeros(robot.nq)
    for k, link in enumerate(robot.links):
        if link.joint != "fixed":
            levers[robot.column(k) + (2 if link.joint == "free" else 0)] = extent[k]
    return read_only(levers), float(extent[0])
