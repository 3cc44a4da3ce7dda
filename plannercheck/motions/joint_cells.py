"""Boxes of joint values, cut into cells until each is proved free by one distance a pair.

In: cells, as their least and largest configurations. Out: which are proved free, their halves, and by what cells are
cut. Idea: a tube around a motion that stands still holds all configurations of a cell.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.motions.certifier import MotionCertifier
from plannercheck.motions.motion_ends import NARROW, Curves

# A cell is refused once pairs come nearer than this, m: far below what splitting it would gain.
_TOLERANCE = 1e-6

# A step by which levers are measured, rad or m, and the least lever that counts, m/rad or m/m.
_STEP, LEAST_LEVER = 1e-6, 1e-3


def are_free(certifier: MotionCertifier, lows: Floats, highs: Floats, threads: int = 1) -> Bools:
    """(n,) which cells (n, nq), rad and m, are proved free; whatever cells are asked for at once."""
    middles = (lows + highs) / 2
    tubes = np.zeros((len(lows), lows.shape[1] + 1))
    # A width at least, so that all pairs judge each cell.
    tubes[:, :-1] = np.maximum(np.maximum(highs - middles, middles - lows) * (1 + 2.0**-50), 2 * NARROW)
    points = np.repeat(middles[:, None], 2, axis=1)
    return certifier.check_curves(Curves(np.ascontiguousarray(points), tubes), _TOLERANCE, threads)


def levers_at(body_poses: Callable[[Floats], Floats], q: Floats) -> Floats:
    """(nq,) how fast each number moves bodies about q (nq,), roughly, m/rad and m/m."""
    rows = np.concatenate([q[None], q + _STEP * np.eye(len(q))])
    poses = body_poses(rows)[:, :, :3]
    moved = np.nan_to_num(np.abs(poses[1:] - poses[0])).max(axis=(1, 2, 3)) / _STEP
    return np.asarray(np.maximum(moved, LEAST_LEVER))


def halved(lows: Floats, highs: Floats, levers: Floats) -> tuple[Floats, Floats]:
    """Both halves of each cell, cut across the side that moves bodies most; levers (nq,), or (n, nq) of each cell."""
    cut = ((highs - lows) * levers).argmax(axis=1)
    rows = np.arange(len(lows))
    middle = (lows[rows, cut] + highs[rows, cut]) / 2
    first_highs, second_lows = highs.copy(), lows.copy()
    first_highs[rows, cut] = second_lows[rows, cut] = middle
    return np.concatenate([lows, second_lows]), np.concatenate([first_highs, highs])
