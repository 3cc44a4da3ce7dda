"""Sampled motions of planar robots: how many states a straight motion needs.

In: a robot, motions. Out: steps between which no point of the robot moves further than asked for. The bound sums, over
the numbers of a configuration, how far one unit moves a point at most: 1 for x and y together as a length, and for an
angle the longest way from its joint to anything that it carries.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.arrays import read_only
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.motion_ends import short_way
from plannercheck.motions.sampling import MOST_STEPS, checked_resolution
from plannercheck.planar.robot import Robot

Floats = NDArray[np.float64]

# Between two states no point moves further than this, in m: a tenth of what mobile robots usually sample at.
DEFAULT_RESOLUTION = 1e-2

# The way is a sum of products that round a little down.
_ROUNDING = 1 + 1e-12


class MotionSampler:
    """Interpolates straight motions of one robot and says how many states they need."""

    def __init__(self, robot: Robot) -> None:
        """Computes the lever arms of the robot's angles, and how far it reaches from its root, m."""
        self._robot, self._angles = robot, np.flatnonzero(robot.angles)
        self.levers, self.reach = _lever_arms(robot)

    def steps(self, q0: Floats, q1: Floats, resolution: float | None) -> NDArray[np.int64]:
        """How many steps each motion (n, nq) to (n, nq) needs: no point moves over `resolution` m in one."""
        return self.steps_of_way(self.way(q1 - q0), resolution)

    def short_way(self, q0: Floats, q1: Floats) -> Floats:
        """Ends (…, nq) with angles without limits within half a turn of the starts'; the same array if they are."""
        return short_way(q0, q1, self._angles)

    def way(self, differences: Floats) -> Floats:
        """(n,) m: no point travels further on straight motions with these differences (n, nq)."""
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
        """States (k, nq) of one straight motion at parameters (k,) in [0, 1]; the core's bits."""
        return np.asarray((1 - parameters)[:, None] * q0 + parameters[:, None] * q1)


def _lever_arms(robot: Robot) -> tuple[Floats, float]:
    """(nq,) m per rad, 0 for x and y; and the reach from the root's frame, m."""
    reach = np.zeros(len(robot.links))  # of what a link carries, from its own frame
    for body in robot.bodies:
        reach[body.link] = max(reach[body.link], float(np.hypot(*body.vertices.T).max()))
    for k in range(len(robot.links) - 1, 0, -1):
        parent = robot.parent_index(k)
        reach[parent] = max(reach[parent], reach[k] + float(np.hypot(*robot.links[k].anchor[:2])))
    levers = np.zeros(robot.nq)
    for k, link in enumerate(robot.links):
        if link.joint != "fixed":
            levers[robot.column(k) + (2 if link.joint == "free" else 0)] = reach[k]
    return read_only(levers), float(reach[0])
