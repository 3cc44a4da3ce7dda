"""Chunks of waypoints, and what the controller runs between them.

In: what a policy gives, and where the robot stands. Out: a `Chunk`, and the `Run` of it: polynomials of one degree.

Time 0 is the instant at which the robot is at `start`. By a rate, waypoint k is reached at (k + 1) / rate, so the
controller runs from where the robot stands to the first waypoint. With times that begin at 0 s, the first waypoint is
where the robot has to stand.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import OwnsArrays, named_numbers, shown_array
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.configurations import LARGEST_VALUE
from plannercheck.trajectories.controllers import Controller
from plannercheck.trajectories.curve import Curve, differentiated
from plannercheck.trajectories.rounding import hermite_error
from plannercheck.trajectories.stamps import durations
from plannercheck.trajectories.trajectory import Trajectory

# Controllers that go straight between positions.
STRAIGHT = ("jtc", "linear")

# Lengths and rates of chunks whose times are remembered.
REMEMBERED = 16

# Waypoints a second, at most: times of messages are whole nanoseconds.
_MOST_A_SECOND = 1e8


@dataclass(frozen=True, eq=False)
class Chunk(OwnsArrays):
    """A chunk as it was given, checked.

    Attributes:
        times: (n,) s, growing from at least 0.
        positions: (n, nq) rad and m.
        q: (nq,) where the robot stands at 0 s.
        dq: (nq,) its velocities there, rad/s and m/s.
        rate: Waypoints a second, if the times were given so.
    """

    times: Floats
    positions: Floats
    q: Floats
    dq: Floats
    rate: float | None = None

    @property
    def from_start(self) -> bool:
        """Whether the controller moves the robot from where it stands to the first waypoint."""
        return bool(self.times[0] > 0)


@dataclass(frozen=True, eq=False)
class Run:
    """What the controller runs: polynomials of one degree.

    Attributes:
        breaks: (m + 1,) s.
        steps: (m,) durations, s.
        points: (m, degree + 1, nq) control points, rad and m.
        error: (nq,) how far these doubles are from the controller's curve, as in `Curve`.
    """

    breaks: Floats
    steps: Floats
    points: Floats
    error: Floats

    @property
    def degree(self) -> int:
        """Of the polynomials."""
        return int(self.points.shape[1]) - 1

    def velocities(self) -> Floats:
        """(m, degree, nq) control points of the velocity, rad/s and m/s."""
        return differentiated(self.points, self.steps[:, None, None])

    def curve(self, first: int = 0, past: int | None = None) -> Curve:
        """The pieces, or some of them."""
        past = len(self.points) if past is None else past
        return Curve(self.breaks[first : past + 1], tuple(self.points[first:past]), self.error)


def chunk_of(
    nq: int, positions: ArrayLike, rate: float | None, times: ArrayLike | None, start: ArrayLike | tuple[Any, Any]
) -> Chunk:
    """A chunk from what a caller gives.

    Args:
        nq: Joints of the robot.
        positions: (n, nq) waypoints.
        rate: Waypoints a second; None with times.
        times: (n,) s; None with a rate.
        start: (nq,) where the robot stands at 0 s, at rest; or a tuple of that and its velocities.

    Raises:
        PlannercheckError: If something is malformed, empty or not finite, or times do not grow.
    """
    rows = _finite(positions, "chunk", None, nq)
    q, dq = start if isinstance(start, tuple) and len(start) == 2 else (start, None)
    own = _finite(q, "start", nq)
    speeds = np.zeros(nq) if dq is None else _finite(dq, "the velocities of start", nq)
    if (rate is None) == (times is None):
        raise PlannercheckError("a chunk needs rate= or times=, and not both")
    even = _checked_rate(rate) if times is None else None
    at = even_times(len(rows), even) if even is not None else _checked_times(times, len(rows))
    if len(at) == 1 and at[0] == 0:
        raise PlannercheckError("a chunk of one waypoint at 0 s is no motion: give it a later time")
    return Chunk(at, rows, own, speeds, even)


def _finite(values: ArrayLike, name: str, *shape: int | None) -> Floats:
    """Numbers of a shape, in which None is any length but 0."""
    array = named_numbers(values, name)
    fits = array.ndim == len(shape) and all(
        n > 0 if want is None else n == want for n, want in zip(array.shape, shape, strict=True)
    )
    if not fits:
        wanted = ", ".join("n > 0" if want is None else str(want) for want in shape)
        raise PlannercheckError(f"{name} must have the shape ({wanted}), rad and m, not {array.shape}")
    if not (np.abs(array) <= LARGEST_VALUE).all():
        place = np.argwhere(~(np.abs(array) <= LARGEST_VALUE))[0].tolist()
        raise PlannercheckError(
            f"{name} must be finite and within {LARGEST_VALUE:g}, but number {place} is {array[tuple(place)]}"
        )
    return array


def is_rate(rate: Any) -> bool:
    """Whether something is a number of waypoints a second."""
    is_number = type(rate) in (float, int) or (isinstance(rate, Real) and not isinstance(rate, bool))
    return is_number and bool(0 < rate <= _MOST_A_SECOND)


def _checked_rate(rate: Any) -> float:
    if not is_rate(rate):
        raise PlannercheckError(
            f"rate must be waypoints a second, more than 0 and at most {_MOST_A_SECOND:g}, not {rate!r:.80}"
        )
    return float(rate)


@lru_cache(REMEMBERED)
def even_times(count: int, rate: float) -> Floats:
    """(count,) times of even waypoints, whole nanoseconds as messages have them."""
    times: Floats = np.rint(np.arange(1, count + 1) * (1e9 / rate)) / 1e9
    times.setflags(write=False)
    return times


def _checked_times(times: Any, count: int) -> Floats:
    at = named_numbers(times, "times")
    if at.shape != (count,) or not np.isfinite(at).all() or at[0] < 0 or not (np.diff(at) >= 1e-9).all():
        raise PlannercheckError(
            f"times must be {count}, one a waypoint, from 0 s on, and grow by at least 1 ns, not {shown_array(times)}"
        )
    return at


def run_of(chunk: Chunk, controller: Controller, turning: list[int]) -> Run:
    """What a controller runs; `turning` are columns of joints that turn without end.

    Raises:
        PlannercheckError: If the controller refuses the chunk.
    """
    if controller in STRAIGHT and not turning:
        return _straight(chunk, controller == "jtc")
    start = (chunk.q, chunk.dq) if chunk.from_start else None
    made = Trajectory(chunk.times, chunk.positions, controller=controller, start=start, continuous=turning).curve
    ((_, points),) = made.by_count.values()
    return Run(made.breaks, durations(made.breaks), points, made.error)


def _straight(chunk: Chunk, by_jtc: bool) -> Run:
    """`Trajectory` of the same, without its checks: the ends of pieces are the waypoints."""
    rows, breaks = chunk.positions, chunk.times
    if chunk.from_start:
        rows, breaks = np.concatenate((chunk.q[None], rows)), np.concatenate((_ZERO, breaks))
    ends = np.array((rows[:-1], rows[1:]))
    error = hermite_error(ends, None, None, 1.0, by_jtc).max(axis=0)
    return Run(breaks, durations(breaks), np.ascontiguousarray(ends.transpose(1, 0, 2)), error)


_ZERO = np.zeros(1)
