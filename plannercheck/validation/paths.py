"""Proves whole paths free, from any planner.

In: a checker, a path of configurations. Out: a `PathVerdict`, which has the first motion that is not free, with its
parameter, pair and certificate.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.checking.protocols import AnyChecker
from plannercheck.checking.verdicts import MotionVerdict
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.motion_paths import MotionPath
from plannercheck.motions.certifier import DEFAULT_TOLERANCE
from plannercheck.motions.checker import Checker
from plannercheck.validation.validate import beyond_limits


@dataclass(frozen=True)
class PathVerdict:
    """The verdict of a path.

    Attributes:
        states: Its configurations.
        free_motions: How many of its motions are proved free.
        beyond_limits: Configurations beyond a joint limit.
        motion: Index of the first motion that is not free; None if all are.
        stopped: That motion's verdict: parameters, pair, certificate; None if all are free.
        tolerance: A motion that stays further than this from collisions is free, m.
        duration: Time that it took, s.
    """

    states: int
    free_motions: int
    beyond_limits: int
    motion: int | None
    stopped: MotionVerdict | None
    tolerance: float
    duration: float

    @property
    def motions(self) -> int:
        """Its motions; a path of one configuration has one, which stands still."""
        return max(self.states - 1, 1)

    @property
    def free(self) -> bool:
        """Whether every motion is proved free."""
        return self.motion is None

    @property
    def passed(self) -> bool:
        """Whether every motion is free and every configuration within the limits."""
        return self.free and self.beyond_limits == 0


def validate_path(
    checker: AnyChecker,
    path: ArrayLike,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int = 1,
    motion_path: MotionPath = "screw",
) -> PathVerdict:
    """Judges a path, every motion of it.

    Args:
        checker: The checker.
        path: (k, nq) configurations joined by straight motions, k at least 1; rad and m.
        tolerance: As for `Checker.check_motion`, m.
        threads: Number of threads to use.
        motion_path: How planar and floating joints move, as `path` of `Checker.check_motion`.

    Returns:
        The verdict.

    Raises:
        PlannercheckError: If the checker is planar, and the path is not "screw".
    """
    how = how_moved(checker, motion_path)
    began = time.perf_counter()
    rows = checker.robot.check_configurations(path)
    starts, ends = (rows[:-1], rows[1:]) if len(rows) > 1 else (rows, rows)
    free = checker.check_motions(starts, ends, tolerance=tolerance, threads=threads, **how)
    refused = np.flatnonzero(~free)
    first = int(refused[0]) if len(refused) else None
    return PathVerdict(
        states=len(rows),
        free_motions=int(free.sum()),
        beyond_limits=int(beyond_limits(checker, rows).sum()),
        motion=first,
        stopped=None if first is None else checker.explain_motion(starts[first], ends[first], tolerance, **how),
        tolerance=tolerance,
        duration=time.perf_counter() - began,
    )


def how_moved(checker: AnyChecker, motion_path: MotionPath) -> dict[str, Any]:
    """Named arguments of a checker's questions about motions; none for screws, which planar checkers do not know."""
    if motion_path == "screw":
        return {}
    if not isinstance(checker, Checker):
        raise PlannercheckError("motion paths are of robots in space; the root of a planar robot goes straight")
    return {"path": motion_path}
