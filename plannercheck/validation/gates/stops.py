"""Stops: each joint brakes at its own constant deceleration until it rests, independently of the others.

In: positions and velocities at which stops begin, decelerations. Out: `Stops`, quadratic pieces. A joint rests after
|v| / brake, rounded up to a whole nanosecond, the least time between points of a trajectory; so a joint brakes by no
more than `brake`. A piece ends where a joint comes to rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.trajectories.curve import Curve
from plannercheck.trajectories.rounding import UNIT

# Relative errors of a control point p + t (v + a t / 2) + h (v + a t) / 2, by |p| + |v| T: 9 operations act on terms of
# at most twice this sum.
_ERRORS = 20


@dataclass(frozen=True, eq=False)
class Stops:
    """Stops from n states.

    Attributes:
        times: (n, nq + 1) s after a stop's begin, ascending from 0, at which a joint comes to rest.
        points: (n, nq, 3, nq) control points of the pieces between these, rad and m.
        lasting: (n, nq) which pieces take any time.
        error: (nq,) how far the control points are from the exact ones at most.
    """

    times: Floats
    points: Floats
    lasting: Bools
    error: Floats

    @property
    def rests(self) -> Floats:
        """(n, nq) where the stops end."""
        return np.asarray(self.points[:, -1, -1])

    def curve(self, k: int, begin: float, error: Floats) -> Curve | None:
        """Stop k as a curve that begins at a whole nanosecond, s; None if the robot rests already.

        `error` (nq,) is that of the state in which it begins.
        """
        lasting = self.lasting[k]
        if not lasting.any():
            return None
        after = np.concatenate((self.times[k, :1], self.times[k, 1:][lasting]))
        breaks = np.rint((begin + after) * 1e9) / 1e9
        return Curve(breaks, tuple(self.points[k][lasting]), self.error + error)


def stops_from(positions: Floats, velocities: Floats, brake: Floats) -> Stops:
    """The stops from n positions (n, nq), rad and m, and velocities, by decelerations (nq,), rad/s² and m/s²."""
    speeds = np.abs(velocities)
    rest = np.ceil(speeds / brake * 1e9) / 1e9
    times = np.zeros((len(positions), rest.shape[1] + 1))
    times[:, 1:] = np.sort(rest, axis=1)
    change = np.divide(-velocities, rest, out=np.zeros_like(rest), where=rest > 0)[:, None]
    running = np.minimum(times[:, :, None], rest[:, None])
    gained = running * change
    q = positions[:, None] + running * (velocities[:, None] + gained / 2)
    moving = running < rest[:, None]
    steps = np.diff(times, axis=1)
    half = (steps / 2)[:, :, None] * ((velocities[:, None] + gained) * moving)[:, :-1]
    points = np.stack((q[:, :-1], q[:, :-1] + half, q[:, 1:]), axis=2)
    error = _ERRORS * UNIT * (np.abs(positions) + speeds * rest).max(axis=0)
    return Stops(times, points, steps > 0, error)
