"""A search that samples near start and goal first, and further from them the longer it takes.

In: a set-up whose planner keeps what it has found from one `solve` to the next, its joint space, both ends. Out: OMPL's
status.

Few paths leave the box around start and goal by much, and a sample far from it draws the trees away. So samples are
first taken from that box, with a margin; after a number of iterations the margin is doubled, as is that number, and so
on. Each stage goes on with the trees of the stage before. The last one samples all of the space, without end: whatever
the planner would find by itself is found here, too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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

# The first margin, rad or m, and the iterations that it is given (measured: docs/reference/performance.md).
FIRST_MARGIN = 0.5
FIRST_ITERATIONS = 1000


def solve_near_first(setup: Any, space: JointSpace, ends: Sequence[Floats], condition: Any) -> Any:
    """Solves the problem of a set-up.

    Args:
        setup: An OMPL SimpleSetup with one of `NEAR_FIRST`, set up; its space is `space`'s.
        space: The joint space.
        ends: Start and goal, (nq,).
        condition: OMPL's termination condition of the whole search.

    Returns:
        OMPL's status. The space has all of its bounds again.
    """
    ompl_space = setup.getStateSpace()
    iterations = FIRST_ITERATIONS
    try:
        for lower, upper in _boxes(space, ends):
            space.bound(ompl_space, lower, upper)
            limit = base.PlannerTerminationCondition(core.call_limit(iterations))
            status = setup.solve(base.plannerOrTerminationCondition(limit, condition))
            if setup.haveExactSolutionPath() or condition.eval():
                return status
            iterations *= 2
    finally:
        space.bound(ompl_space, space.lower, space.upper)
    return setup.solve(condition)


def _boxes(space: JointSpace, ends: Sequence[Floats]) -> Iterator[tuple[Floats, Floats]]:
    """Ever larger bounds around both ends, as long as they are not the space's own. Angles have none."""
    lowest, highest = np.minimum(*ends), np.maximum(*ends)
    room = np.maximum(lowest - space.lower, space.upper - highest)
    room[space.continuous] = 0
    widest = room.max()
    margin = FIRST_MARGIN
    while margin < widest:
        yield np.maximum(space.lower, lowest - margin), np.minimum(space.upper, highest + margin)
        margin *= 2
