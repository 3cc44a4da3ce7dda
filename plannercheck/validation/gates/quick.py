"""The fast path of a gate: most chunks are judged by one call of the core (cpp/motions/chunk_judge.hpp).

In: where the robot stands and its waypoints, at even times, straight between them. Out: whether the chunk passes for
sure, or fails for sure; where nothing is known, or all but the stop, the plain path judges (`GateVerdict`).
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import named_numbers
from plannercheck.trajectories.rounding import UNIT, hermite_error
from plannercheck.trajectories.stamps import durations
from plannercheck.validation.gates.chunks import REMEMBERED, Chunk, even_times
from plannercheck.validation.gates.limits import ROUNDED, GateLimits
from plannercheck.validation.gates.proving import ChunkProofs
from plannercheck.validation.gates.settings import GateSettings

# Relative errors of all that the core computes for a motion, by the largest number within the limits: 75 roundings, of
# numbers of at most twice that.
_ERRORS = 150

# Limits are held here to a smaller part of themselves than in `GateLimits`: what passes here passes there.
_STRICTER = 1 + ROUNDED / 2

# What the core knows of a chunk (`ChunkAnswer`): whether it passes, None if all but its stop does.
_ANSWERS = (False, True, None)


@lru_cache(REMEMBERED)
def _even(count: int, rate: float) -> tuple[Floats, tuple[float, float, float]]:
    """Even times (n,) of a chunk, s; its first step, its last, and its least, s."""
    times = even_times(count, rate)
    steps = durations(np.concatenate(([0.0], times)))
    return times, (float(steps[0]), float(steps[-1]), float(steps.min()))


class QuickJudge:
    """Judges chunks that a controller runs straight between waypoints, of joints that all have limits."""

    def __init__(self, settings: GateSettings, limits: GateLimits, proofs: ChunkProofs, ask: Any = None) -> None:
        """Passes to the core what all chunks share; `ask` as for `MotionCertifier.chunk_judge`."""
        self._rest, self._nq = np.zeros(len(settings.tube)), len(settings.tube)
        speeds = settings.velocity * _STRICTER, settings.acceleration * _STRICTER
        largest = np.maximum(np.abs(limits.lower), np.abs(limits.upper))
        error = hermite_error(np.array((largest, largest)), None, None, 1.0, True) + _ERRORS * UNIT * largest
        tube = np.append((settings.tube + error) * (1 + 2.0**-50), settings.margin)
        rows = np.array((limits.lower, limits.upper, *speeds, settings.brake))
        self._answer = proofs.certifier.chunk_judge(rows, tube, settings.tolerance, ask)

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
        times, steps = _even(len(rows) - 1, rate)
        known = self._answer(rows, dq, *steps)
        return (Chunk(times, rows[1:], rows[0], dq, rate), _ANSWERS[known]) if known < len(_ANSWERS) else None


def _doubles(values: ArrayLike, name: str) -> Floats:
    """An array of doubles as it is, and what else holds numbers as one."""
    if type(values) is np.ndarray and values.dtype == np.float64:
        return values
    return named_numbers(values, name)
