"""An OMPL objective that maximises the least clearance along a path.

In: a checker and its space. Out: costs that OMPL minimises: for a path, the negative of the least clearance at sampled
states. OMPL 2.0.1 ignores a `stateCost` that Python overrides in a `StateCostIntegralObjective`, but it calls
`motionCost` of a plain `OptimizationObjective`, so this one is overridden.
"""

from __future__ import annotations

from math import ceil
from typing import Any

import numpy as np
from ompl import base

from plannercheck.common.real_numbers import positive_number
from plannercheck.motions.checker import Checker
from plannercheck.ompl.motion_validators import Space
from plannercheck.ompl.pose_space import PoseSpace

# The step between states at which a motion's clearance is measured, in the space's distance (rad).
CLEARANCE_RESOLUTION = 0.05


class MaxMinClearance(base.OptimizationObjective):  # type: ignore[misc]  # OMPL has no types
    """Costs are negative clearances in m; the cost of a path is that of its costliest state."""

    def __init__(self, information: Any, checker: Checker, space: Space, resolution: float) -> None:
        """Takes OMPL's SpaceInformation of the space; the resolution is in the space's distance."""
        resolution = positive_number(resolution, "resolution must be a positive distance")
        super().__init__(information)
        self._ompl_space = information.getStateSpace()  # keeping the information would be a cycle
        self._checker = checker
        self._space = space
        self._resolution = resolution

    def stateCost(self, state: Any) -> Any:  # noqa: N802
        """The negative clearance of a state."""
        return base.Cost(-self._checker.clearance(np.array(self._space.read(state))))

    def motionCost(self, first: Any, second: Any) -> Any:  # noqa: N802
        """The negative of the least clearance at states along a motion, both ends included."""
        steps = max(1, ceil(self._ompl_space.distance(first, second) / self._resolution))
        t = np.linspace(0.0, 1.0, steps + 1)
        if isinstance(self._space, PoseSpace):
            return base.Cost(-float(self._checker.clearances(self._space.curve_states(first, second, t)).min()))
        ends = (np.array(self._space.read(state)) for state in (first, second))
        starts, ends_too = (self._checker.robot.check_configurations(q[None]) for q in ends)
        ends_too = self._checker.motion_sampler.shorter_turn(starts, ends_too)
        part = t[:, None]
        return base.Cost(-float(self._checker.clearances((1 - part) * starts + part * ends_too).min()))

    def combineCosts(self, first: Any, second: Any) -> Any:  # noqa: N802
        """The costlier of two parts of a path."""
        return first if first.value() >= second.value() else second

    def identityCost(self) -> Any:  # noqa: N802
        """The cost of an empty path: less than that of any state."""
        return base.Cost(-float("inf"))

    def infiniteCost(self) -> Any:  # noqa: N802
        """A cost above that of any path."""
        return base.Cost(float("inf"))
