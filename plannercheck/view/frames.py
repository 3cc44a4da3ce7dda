"""The frames of an animation: of a path at even steps, its own configurations among them; of a trajectory in time.

In: a checker and a path, or a trajectory. Out: configurations with labels or times.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.checking.named_configurations import given_configurations
from plannercheck.checking.protocols import AnyChecker
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.motion_paths import MotionPath, check_path
from plannercheck.motions.checker import Checker
from plannercheck.trajectories import Trajectory

# Frames of an animation of four seconds.
DEFAULT_FRAMES = 120

# Frames a second of a trajectory, and the most of a long one.
_A_SECOND, _MOST = 30.0, 600


def along_path(
    checker: AnyChecker,
    path: ArrayLike,
    frames: int = DEFAULT_FRAMES,
    motion_path: MotionPath = "screw",
    pieces: Ints64 | None = None,
) -> tuple[Floats, tuple[str, ...]]:
    """Configurations along a path of straight motions.

    Args:
        checker: Knows how its robot moves from one configuration to the next.
        path: (k, nq) rad and m.
        frames: Approximate number of frames; the path's own configurations are always among them.
        motion_path: How planar and floating joints move, as `path` of `Checker.check_motion`.
        pieces: (m,) how many motions between rows are one motion of the path, for the labels; None: one each.

    Returns:
        (n, nq) configurations, and their labels: motion and parameter.

    Raises:
        PlannercheckError: If the path is empty or `frames` is less than 1.
    """
    rows = given_configurations(checker.robot, path)
    check_path(motion_path)
    if not len(rows) or frames < 1:
        raise PlannercheckError(f"an animation needs a path and at least 1 frame, not {len(rows)} states and {frames}")
    steps = _steps(checker, rows, frames)
    counts = [1] * len(steps) if pieces is None else pieces.tolist()
    places = [(motion, piece, count) for motion, count in enumerate(counts) for piece in range(count)]
    parts, labels = [rows[:1]], ["start"]
    for k, (count, (motion, piece, of)) in enumerate(zip(steps.tolist(), places, strict=True)):
        parameters = np.arange(1, count + 1) / count
        parts.append(_states(checker, rows[k], rows[k + 1], parameters, motion_path))
        labels += [f"motion {motion} at {(piece + t) / of:.3g}" for t in parameters.tolist()]
    return np.concatenate(parts), tuple(labels)


def along_trajectory(trajectory: Trajectory, frames: int | None = None) -> tuple[Floats, Floats]:
    """Configurations (n, nq) of a trajectory at even times, and these (n,), s.

    Without a number of frames 30 a second, but not fewer than `DEFAULT_FRAMES` and not more than `_MOST`.
    """
    count = min(max(DEFAULT_FRAMES, round(_A_SECOND * trajectory.duration)), _MOST) if frames is None else frames
    times = np.linspace(trajectory.curve.breaks[0], trajectory.curve.breaks[-1], max(count, 2))
    return trajectory.position(times), times


def _steps(checker: AnyChecker, rows: Floats, frames: int) -> NDArray[np.int64]:
    """(motions,) at least one each, else by the part of the way that it takes."""
    ends = rows[1:]
    if isinstance(checker, Checker):
        ends = checker.motion_sampler.shorter_turn(rows[:-1], ends)
    lengths = np.linalg.norm(ends - rows[:-1], axis=1)
    whole = float(lengths.sum())
    return np.maximum(1, np.round(frames * lengths / whole)).astype(np.int64) if whole else np.ones(len(ends), np.int64)


def _states(checker: AnyChecker, q0: Floats, q1: Floats, parameters: Floats, motion_path: MotionPath) -> Floats:
    if isinstance(checker, Checker):
        sampler = checker.motion_sampler
        return sampler.states(q0, sampler.shorter_turn(q0, q1), parameters, motion_path)
    return q0 + parameters[:, None] * (q1 - q0)
