"""A search that samples near start and goal first, and further from them the longer it takes.

In: a set-up whose planner keeps its trees from one `solve` to the next, its joint space, start and goals. Out: OMPL's
status.

Few paths leave the box around start and goal by much, and a sample far from it draws the trees away. So samples first
come from that box with some room on each side, for a number of iterations; then from a wider box; then from the whole
space, without end. Each stage continues with the trees of the stage before: this search finds every path that the
planner alone would find, later by the iterations of the first stages.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
from ompl import base

from plannercheck.common.array_types import Floats
from plannercheck.common.core import core
from plannercheck.ompl.joint_space import JointSpace

# Where a planner samples: near start and goal first, or everywhere from the beginning.
Sampling: TypeAlias = Literal["near", "everywhere"]
SAMPLINGS: tuple[Sampling, ...] = get_args(Sampling)

# Planners whose first path counts, and whose `solve` goes on where the one before has stopped.
NEAR_FIRST = ("RRTConnect",)

# The room of each stage, as a part of each joint's range, and its iterations (measured: docs/reference/performance.md).
STAGES = ((0.15, 1000), (0.4, 2000))


class NearFirst:
    """A search that stops and goes on, stage by stage."""

    def __init__(self, space: JointSpace, ends: Sequence[Floats]) -> None:
        """Takes the joint space, and start and goals, (nq,) each."""
        self._space, self._ends = space, ends
        self._left = list(STAGES)  # and their iterations that are left

    def go_on(self, setup: Any, condition: Any, iterations: int | None = None) -> Any:
        """Solves the problem of a set-up, for some iterations at most.

        Args:
            setup: An OMPL SimpleSetup with one of `NEAR_FIRST`; its space is `space`'s. The same one each time.
            condition: OMPL's termination condition of the whole search.
            iterations: How many at most.

        Returns:
            OMPL's status. The space has all of its bounds again.
        """
        setup.setup()  # by the bounds of the whole space, of which OMPL takes a part as its range where none is set
        ompl_space, space = setup.getStateSpace(), self._space
        try:
            while self._left:
                part, most = self._left[0]
                count = most if iterations is None else min(most, iterations)
                space.bound(ompl_space, *box_around(space, self._ends, part))
                status = setup.solve(_limited(condition, count))
                self._left[0] = part, most - count
                if count == most:
                    del self._left[0]
                iterations = None if iterations is None else iterations - count
                if setup.haveExactSolutionPath() or condition.eval() or iterations == 0:
                    return status
        finally:
            space.bound(ompl_space, space.lower, space.upper)
        return setup.solve(condition if iterations is None else _limited(condition, iterations))


def solve_near_first(setup: Any, space: JointSpace, ends: Sequence[Floats], condition: Any) -> Any:
    """Solves the problem of a set-up; arguments and result as of `NearFirst` and its `go_on`."""
    return NearFirst(space, ends).go_on(setup, condition)


def _limited(condition: Any, iterations: int) -> Any:
    """OMPL's condition, or so many iterations."""
    return base.plannerOrTerminationCondition(base.PlannerTerminationCondition(core.call_limit(iterations)), condition)


def box_around(space: JointSpace, ends: Sequence[Floats], part: float) -> tuple[Floats, Floats]:
    """Bounds (nq,) of a box around all ends, with this part of each joint's range as room. Angles have none."""
    room = part * (space.upper - space.lower)
    low, high = reduce(np.minimum, ends) - room, reduce(np.maximum, ends) + room
    return np.maximum(space.lower, low), np.minimum(space.upper, high)
