"""An OMPL objective: the least clearance along a path, as great as possible.

In: a checker and its space. Out: costs that OMPL minimises: of a path, the negative of the least clearance at the
states looked at. OMPL 2.0.1 ignores a `stateCost` that Python overrides in a `StateCostIntegralObjective`; `motionCost`
of a plain `OptimizationObjective` is asked, so that is what is overridden.
"""

from __future__ import annotations

from math import ceil
from typing import Any

import numpy as np
from ompl import base

from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.checker import Checker
from plannercheck.ompl.motion_validators import Space

# Between states at which a motion's clearance is measured, in the space's distance (rad).
CLEARANCE_RESOLUTION = 0.05


class MaxMinClearance(base.OptimizationObjective):  # type: ignore[misc]  # OMPL has no types
    """Costs are negative clearances in m; a path costs as much as its costliest state."""

    def __init__(self, information: Any, checker: Checker, space: Space, resolution: float) -> None:
        """The information is OMPL's, of the space; the resolution is in the space's distance."""
        if not (np.isfinite(resolution) and resolution > 0):
            raise PlannercheckError(f"resolution must be a positive distance, not {resolution!r}")
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
        ends = (np.array(self._space.read(state)) for state in (first, second))
        starts, ends_too = (self._checker.robot.check_configurations(q[None]) for q in ends)
        ends_too = self._checker.motion_sampler.short_way(starts, ends_too)
        steps = max(1, ceil(self._ompl_space.distance(first, second) / self._resolution))
        t = np.linspace(0.0, 1.0, steps + 1)[:, None]
        return base.Cost(-float(self._checker.clearances((1 - t) * starts + t * ends_too).min()))

    def combineCosts(self, first: Any, second: Any) -> Any:  # noqa: N802
        """The costlier of two parts of a path."""
        return first if first.value() >= second.value() else second

    def identityCost(self) -> Any:  # noqa: N802
        """What a path of nothing costs: less than any state."""
        return base.Cost(-float("inf"))

    def infiniteCost(self) -> Any:  # noqa: N802
        """What no path costs."""
        return base.Cost(float("inf"))
