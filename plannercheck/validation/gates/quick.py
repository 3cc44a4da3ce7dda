"""The fast path of a gate: most chunks pass by a few operations on whole arrays, and one or two calls of the core.

In: where the robot stands and its waypoints, at even times, straight between them. Out: whether the chunk passes for
sure, or fails for sure, or nothing is known: then the plain path judges (`GateVerdict`).

1. The limits of positions, speeds and accelerations, at the waypoints. A number that is none keeps no limit.
2. One straight motion from the start to the middle of the stop. Its tube is so wide that it covers the chunk and the
   stop: their difference from it is linear between waypoints, so it is largest at one of them.
3. The pieces as they are, and the stop as the box of all states between its begin and its end.

In a stop each joint moves by v T / 2 one way, where T is less than 2 ns longer than |v| / brake (stops.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import named_numbers
from plannercheck.motions.motion_ends import Curves
from plannercheck.trajectories.rounding import UNIT, hermite_error
from plannercheck.trajectories.stamps import durations
from plannercheck.validation.gates.chunks import REMEMBERED, Chunk, even_times
from plannercheck.validation.gates.limits import ROUNDED, GateLimits
from plannercheck.validation.gates.proving import ChunkProofs
from plannercheck.validation.gates.settings import GateSettings

# Longer than a stop may last beyond |v| / brake, s.
_LATER = 2e-9

# Relative errors of all that is computed here, by the largest number within the limits: 12 operations, thrice as many.
_ERRORS = 36

# Limits are held here to a smaller part of themselves than in `GateLimits`: what passes here passes there.
_STRICTER = 1 + ROUNDED / 2


@dataclass(frozen=True, eq=False)
class _Even:
    """Even times of a chunk.

    Attributes:
        times: (n,) s.
        shares: (n + 1, 1) parts of the whole time, with the start's.
        first: The first step, s.
        last: The last step, s.
        least: The least step, s.
    """

    times: Floats
    shares: Floats
    first: float
    last: float
    least: float


@lru_cache(REMEMBERED)
def _even(count: int, rate: float) -> _Even:
    times = even_times(count, rate)
    whole = np.concatenate(([0.0], times))
    steps = durations(whole)
    return _Even(times, (whole / times[-1])[:, None], float(steps[0]), float(steps[-1]), float(steps.min()))


class QuickJudge:
    """Judges chunks that a controller runs straight between waypoints, of joints that all have limits."""

    def __init__(self, settings: GateSettings, limits: GateLimits, proofs: ChunkProofs) -> None:
        """Computes what all chunks share."""
        self._proofs, self._brake = proofs, settings.brake
        self._tolerance, self._rest = settings.tolerance, np.zeros(len(settings.tube))
        self._lower, self._upper, self._nq = limits.lower, limits.upper, len(settings.tube)
        self._velocity, self._acceleration = settings.velocity * _STRICTER, settings.acceleration * _STRICTER
        self._bends = limits.has_accelerations
        largest = np.maximum(np.abs(limits.lower), np.abs(limits.upper))
        error = hermite_error(np.array((largest, largest)), None, None, 1.0, True) + _ERRORS * UNIT * largest
        self._around = np.append((settings.tube + error) * (1 + 2.0**-50), settings.margin)

    def rows(self, chunk: ArrayLike, start: ArrayLike | tuple[Any, Any]) -> tuple[Floats, Floats] | None:
        """(n + 1, nq) where the robot stands and its waypoints, and (nq,) its velocities: copies, read-only.

        None if something has another shape.
        """
        q, dq = start if isinstance(start, tuple) and len(start) == 2 else (start, self._rest)
        waypoints, here, speeds = _doubles(chunk, "chunk"), _doubles(q, "start"), _doubles(dq, "start's velocities")
        if waypoints.ndim != 2 or not len(waypoints) or waypoints.shape[1] != self._nq:
            return None
        if here.shape != (self._nq,) or speeds.shape != (self._nq,):
            return None
        rows = np.empty((len(waypoints) + 1, self._nq))
        rows[0], rows[1:] = here, waypoints
        speeds = speeds.copy()
        rows.setflags(write=False)
        speeds.setflags(write=False)
        return rows, speeds

    def judge(self, rows: Floats, dq: Floats, rate: float) -> tuple[bool | None, Chunk | None]:
        """Whether a chunk passes, None if that is not known; and the chunk where it is."""
        at = _even(len(rows) - 1, rate)
        moved = rows[1:] - rows[:-1]
        if not self._keeps_limits(rows, moved, dq, at):
            return None, None
        velocity = moved[-1] / at.last
        half = velocity * (np.abs(velocity) / self._brake + _LATER) / 4
        middle = rows[-1] + half
        rest = middle + half
        if not ((rest >= self._lower).all() and (rest <= self._upper).all()):
            return None, None
        reach = np.abs(half)
        known = self._is_covered(rows, middle, reach, at) or self._is_free(rows, middle, reach)
        return known, None if known is None else Chunk(at.times, rows[1:], rows[0], dq, rate)

    def _keeps_limits(self, rows: Floats, moved: Floats, dq: Floats, at: _Even) -> bool:
        """Whether all limits are kept for sure."""
        if not ((rows >= self._lower).all() and (rows <= self._upper).all()):
            return False
        if not ((np.abs(moved) <= self._velocity * at.least).all() and (np.abs(dq) <= self._velocity).all()):
            return False
        if not self._bends:
            return True
        most = self._acceleration * (at.least * at.least)
        from_start = np.abs(moved[0] - dq * at.first) <= most
        return bool(from_start.all() and (np.abs(moved[1:] - moved[:-1]) <= most).all())

    def _is_covered(self, rows: Floats, middle: Floats, reach: Floats, at: _Even) -> bool:
        """Whether one straight motion is proved whose tube covers all."""
        straight = rows[0] + at.shares * (middle - rows[0])
        tubes = self._around[None].copy()
        tubes[0, :-1] += np.maximum(np.abs(rows - straight).max(axis=0), reach)
        ends = np.array(((rows[0], middle),))
        return bool(self._proofs.certifier.check_curves(Curves(ends, tubes), self._tolerance, 1)[0])

    def _is_free(self, rows: Floats, middle: Floats, reach: Floats) -> bool | None:
        """Whether the pieces are proved, and the box of the stop; None if only the box is not."""
        ends = np.empty((len(rows), 2, self._nq))
        ends[:-1, 0], ends[:-1, 1], ends[-1] = rows[:-1], rows[1:], middle
        tubes = np.empty((len(rows), self._nq + 1))
        tubes[:] = self._around
        tubes[-1, :-1] += reach
        free = self._proofs.certifier.check_curves(Curves(ends, tubes), self._tolerance, 1)
        if free.all():
            return True
        return None if free[:-1].all() else False


def _doubles(values: ArrayLike, name: str) -> Floats:
    """An array of doubles as it is, and what else holds numbers as one."""
    if type(values) is np.ndarray and values.dtype == np.float64:
        return values
    return named_numbers(values, name)
