"""Checks paths again: every sampled state by FCL, and states between the samples.

In: a checker and a path. Out: `PathCheck`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.motions.checker import Checker
from plannercheck.motions.sampling import DEFAULT_RESOLUTION
from plannercheck.validation.fcl_agreement import AgreementReport, compare_with_fcl, merged

# States between the samples are this many times denser than the samples.
DENSER = 10


@dataclass(frozen=True)
class PathCheck:
    """The results for a path's states.

    Attributes:
        agreement: The comparison with FCL on the path resampled as its motions were checked.
        between: States between those samples that were checked.
        between_colliding: Number of these that collide.
    """

    agreement: AgreementReport
    between: int
    between_colliding: int

    @property
    def passed(self) -> bool:
        """Whether no sampled state collides, by the checker and by FCL or, where they differ, exactly."""
        return self.agreement.passed and self.agreement.collisions == 0


def check_path(checker: Checker, path: Floats, resolution: float = DEFAULT_RESOLUTION) -> PathCheck:
    """Checks a path (k, nq) again.

    Args:
        checker: The checker.
        path: Configurations, joined by straight motions, on which free bodies go by slerp as OMPL moves them.
        resolution: No link point moves further than this between two sampled states, m.

    Returns:
        What was found.
    """
    agreements, between, colliding = [], 0, 0
    for states in resampled(checker, path, resolution):
        agreements.append(compare_with_fcl(checker, states))
    for states in resampled(checker, path, resolution, DENSER):
        inner = states[np.arange(len(states)) % DENSER != 0]
        between += len(inner)
        colliding += int((~checker.check_states(inner)).sum())
    return PathCheck(merged(agreements), between, colliding)


def resampled(checker: Checker, path: Floats, resolution: float, denser: int = 1) -> Iterator[Floats]:
    """The states (steps + 1, nq) of each motion of a path (k, nq), both ends included: those a motion check looks at.

    The resolution is as for `check_path`. There may be more steps: every `denser`-th state is the motion check's.
    """
    sampler = checker.motion_sampler
    for q0, q1 in pairwise(path):
        end = sampler.shorter_turn(q0, q1)
        steps = int(sampler.steps(q0[None], end[None], resolution)[0]) * denser
        yield sampler.states(q0, end, np.arange(steps + 1) / steps, "slerp")
