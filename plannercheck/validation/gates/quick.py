"""The fast path of a gate: most chunks pass by a few operations on whole arrays, and one or two calls of the core.

In: where the robot stands and its waypoints, at even times, straight between them. Out: whether the chunk passes for
sure, or fails for sure; where nothing is known, or all but the stop, the plain path judges (`GateVerdict`).

1. The limits of positions, speeds and accelerations, at the waypoints. A number that is none keeps no limit.
2. One straight motion from the start to the middle of the stop. Its tube is so wide that it covers the chunk and the
   stop: their difference from it is linear between waypoints, so it is largest at one of them. With it some states of
   the chunk are judged: where one is refused, so is the chunk.
3. The pieces as they are, and the stop as a straight motion with a tube. If only this is not proved, some states of
   the stop: where one is refused, so is the chunk.

In a stop, joint j gets by d = v T / 2 further, of which the part 1 − (1 − t/T)² is done at t. The straight motion does
for all joints what the joint does that takes longest, M. With r = T/M, joint j is ahead of it by d (1 − t/M)² − d (1 −
t/T)², which is largest at t = T/(1 + r): d (1 − r)/(1 + r). The motion is moved by half of that. T is less than 2 ns
longer than |v|/brake (stops.py), by which all this changes by less than 8 ns · |v|.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import named_numbers
from plannercheck.trajectories.rounding import UNIT, hermite_error
from plannercheck.trajectories.stamps import durations
from plannercheck.validation.gates.chunks import REMEMBERED, Chunk, even_times
from plannercheck.validation.gates.limits import ROUNDED, GateLimits
from plannercheck.validation.gates.proving import ChunkProofs
from plannercheck.validation.gates.settings import GateSettings

# By how much rounding a stop's times up moves it, at most, as a part of the speed, s.
_LATER = 8e-9

# Relative errors of all that is computed here, by the largest number within the limits: 12 operations, thrice as many.
_ERRORS = 36

# Instants of a stop, as parts of its time, at which its states are judged before its pieces are, (n, 1).
_LOOKS = np.array([[1.0], [0.6], [0.3]])

# In place of the longest time of a stop where all joints rest, s.
_NO_TIME = 1e-300

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
        looks: Rows that are judged as states.
    """

    times: Floats
    shares: Floats
    first: float
    last: float
    least: float
    looks: Ints64


@lru_cache(REMEMBERED)
def _even(count: int, rate: float) -> _Even:
    times = even_times(count, rate)
    whole = np.concatenate(([0.0], times))
    steps = durations(whole)
    looks = np.array([0, count // 2, count])
    shares = (whole / times[-1])[:, None]
    return _Even(times, shares, float(steps[0]), float(steps[-1]), float(steps.min()), looks)


class QuickJudge:
    """Judges chunks that a controller runs straight between waypoints, of joints that all have limits."""

    def __init__(self, settings: GateSettings, limits: GateLimits, proofs: ChunkProofs) -> None:
        """Computes what all chunks share."""
        self._free, self._brake = proofs.certifier.curve_judge(settings.tolerance), settings.brake
        self._rest = np.zeros(len(settings.tube))
        self._lower, self._upper, self._nq = limits.lower, limits.upper, len(settings.tube)
        self._velocity, self._acceleration = settings.velocity * _STRICTER, settings.acceleration * _STRICTER
        self._bends = limits.has_accelerations
        self._centre = (limits.lower + limits.upper) / 2
        reach = (limits.upper - limits.lower) / 2
        rounding = 4 * UNIT * (np.abs(self._centre) + reach)
        self._around_centre, self._beyond = reach - rounding, reach + rounding
        self._sizes: dict[tuple[int, float], Floats] = {}
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

    def judge(self, rows: Floats, dq: Floats, rate: float) -> tuple[Chunk, bool | None] | None:
        """The chunk, and whether it passes, None if all but its stop does; None if nothing is known."""
        at = _even(len(rows) - 1, rate)
        keeps = self._keeps_limits(rows, dq, at)
        if not keeps:
            return None if keeps is None else (Chunk(at.times, rows[1:], rows[0], dq, rate), False)
        velocity = (rows[-1] - rows[-2]) / at.last
        speed = np.abs(velocity)
        lasts = speed / self._brake
        late = _LATER * speed
        half = velocity * lasts / 4
        rest = rows[-1] + 2 * half
        chunk = Chunk(at.times, rows[1:], rows[0], dq, rate)
        if not ((rest - late >= self._lower).all() and (rest + late <= self._upper).all()):
            beyond = (rest + late < self._lower).any() or (rest - late > self._upper).any()
            return (chunk, False) if beyond else None
        covered = self._is_covered(rows, rows[-1] + half, np.abs(half) + late, at)
        if covered is not None:
            return chunk, covered
        share = lasts / max(lasts.max(), _NO_TIME)
        aside = half * ((1 - share) / (1 + share))
        known = self._is_free(rows, aside, rest + aside, np.abs(aside) + late)
        if known is None and not self._may_stop(rows[-1], velocity, lasts):
            known = False
        return chunk, known

    def _keeps_limits(self, rows: Floats, dq: Floats, at: _Even) -> bool | None:
        """Whether all limits are kept; None if that is not sure."""
        count = len(rows)
        sizes = np.empty((2 * count, self._nq))
        moved = sizes[count:-1]
        np.subtract(rows, self._centre, out=sizes[:count])
        np.subtract(rows[1:], rows[:-1], out=moved)
        sizes[-1] = dq
        if self._bends:
            most = self._acceleration * (at.least * at.least)
            from_start = np.abs(moved[0] - dq * at.first) <= most
            if not (from_start.all() and (np.abs(moved[1:] - moved[:-1]) <= most).all()):
                return None
        np.abs(sizes, out=sizes)
        if (sizes <= self._largest_sizes(count, at.least)).all():
            return True
        return False if (sizes[:count] > self._beyond).any() and np.isfinite(sizes).all() else None

    def _largest_sizes(self, count: int, step: float) -> Floats:
        """(2 count, nq) of offsets from the middle of the limits, of steps, and of velocities at the start."""
        known = self._sizes.get((count, step))
        if known is not None:
            return known
        if len(self._sizes) >= REMEMBERED:
            self._sizes.clear()
        rows = ((self._around_centre, count), (self._velocity * step, count - 1), (self._velocity, 1))
        return self._sizes.setdefault((count, step), np.concatenate([np.tile(row, (n, 1)) for row, n in rows]))

    def _is_covered(self, rows: Floats, middle: Floats, reach: Floats, at: _Even) -> bool | None:
        """Whether one straight motion is proved whose tube covers all; False if a state is refused, else None."""
        straight = rows[0] + at.shares * (middle - rows[0])
        tubes = self._tubes(1 + len(at.looks))
        tubes[0, :-1] += np.maximum(np.abs(rows - straight).max(axis=0), reach)
        ends = np.empty((len(tubes), 2, self._nq))
        ends[0, 0], ends[0, 1], ends[1:] = rows[0], middle, rows[at.looks, None]
        free = self._free(ends, tubes)
        return True if free[0] else None if free[1:].all() else False

    def _tubes(self, count: int) -> Floats:
        """(count, nq + 1) the tube and the margin of all motions."""
        tubes = np.empty((count, self._nq + 1))
        tubes[:] = self._around
        return tubes

    def _is_free(self, rows: Floats, aside: Floats, end: Floats, off: Floats) -> bool | None:
        """Whether the pieces are proved, and the stop as a straight motion; None if only the stop is not.

        The stop's motion begins aside of the last waypoint.
        """
        ends = np.empty((len(rows), 2, self._nq))
        ends[:, 0], ends[:-1, 1], ends[-1, 1] = rows, rows[1:], end
        ends[-1, 0] += aside
        tubes = self._tubes(len(rows))
        tubes[-1, :-1] += off
        free = self._free(ends, tubes)
        if not free[:-1].all():
            return False
        return True if free[-1] else None

    def _may_stop(self, q: Floats, velocity: Floats, lasts: Floats) -> bool:
        """Whether some states of the stop are proved: else the stop is not."""
        share = np.minimum(_LOOKS * lasts.max() / np.maximum(lasts, _NO_TIME), 1.0)
        states = q + velocity * lasts * share * (1 - share / 2)
        return bool(self._free(np.stack((states, states), axis=1), self._tubes(len(states))).all())


def _doubles(values: ArrayLike, name: str) -> Floats:
    """An array of doubles as it is, and what else holds numbers as one."""
    if type(values) is np.ndarray and values.dtype == np.float64:
        return values
    return named_numbers(values, name)
