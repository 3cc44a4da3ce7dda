"""Proves whole paths free, from any planner.

In: a checker, a path of configurations. Out: a `PathVerdict`, which has the first motion that is not free, with its
parameter, pair and certificate.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.checking.protocols import AnyChecker
from plannercheck.checking.verdicts import MotionVerdict
from plannercheck.common.array_types import Ints64
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
        cut: How many more motions are proved than the path has: pieces of motions on which a continuous joint turns
            further than half a turn.
    """

    states: int
    free_motions: int
    beyond_limits: int
    motion: int | None
    stopped: MotionVerdict | None
    tolerance: float
    duration: float
    cut: int = 0

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
    pieces: Ints64 | None = None,
) -> PathVerdict:
    """Judges a path, every motion of it.

    Args:
        checker: The checker.
        path: (k, nq) configurations joined by straight motions, k at least 1; rad and m.
        tolerance: As for `Checker.check_motion`, m.
        threads: Number of threads to use.
        motion_path: How planar and floating joints move, as `path` of `Checker.check_motion`.
        pieces: (m,) how many motions between rows are one motion of the path (`PathFile.pieces`); None: one each.

    Returns:
        The verdict, about the path's own motions.

    Raises:
        PlannercheckError: If the checker is planar, and the path is not "screw".
    """
    how = how_moved(checker, motion_path)
    began = time.perf_counter()
    rows = checker.robot.check_configurations(path)
    starts, ends = (rows[:-1], rows[1:]) if len(rows) > 1 else (rows, rows)
    free = checker.check_motions(starts, ends, tolerance=tolerance, threads=threads, **how)
    counts = np.ones(len(starts), dtype=np.int64) if pieces is None or not len(pieces) else pieces
    firsts = np.cumsum(counts) - counts
    own = rows[[*firsts.tolist(), -1]] if len(rows) > 1 else rows
    refused = np.flatnonzero(~free)
    motion, stopped = None, None
    if len(refused):
        piece = int(refused[0])
        motion = int(np.searchsorted(firsts, piece, side="right")) - 1
        found = checker.explain_motion(starts[piece], ends[piece], tolerance, **how)
        stopped = _of_whole(found, piece - int(firsts[motion]), int(counts[motion]))
    return PathVerdict(
        states=len(own),
        free_motions=int(np.logical_and.reduceat(free, firsts).sum()),
        beyond_limits=int(beyond_limits(checker, own).sum()),
        motion=motion,
        stopped=stopped,
        tolerance=tolerance,
        duration=time.perf_counter() - began,
        cut=len(starts) - len(firsts),
    )


def _of_whole(found: MotionVerdict, piece: int, count: int) -> MotionVerdict:
    """The verdict of a motion, from that of one of its equal pieces; all before it are free."""

    def parameter(t: float | None) -> float | None:
        return None if t is None else (piece + t) / count

    return replace(
        found,
        free_until=(piece + found.free_until) / count,
        collides_at=parameter(found.collides_at),
        near_at=parameter(found.near_at),
    )


def how_moved(checker: AnyChecker, motion_path: MotionPath) -> dict[str, Any]:
    """Named arguments of a checker's questions about motions; none for screws, which planar checkers do not know."""
    if motion_path == "screw":
        return {}
    if not isinstance(checker, Checker):
        raise PlannercheckError("motion paths are of robots in space; the root of a planar robot goes straight")
    return {"path": motion_path}
