"""Answers of the core's motion certifiers, in space and in the plane.

In: the core's codes and arrays. Out: verdicts, a `MotionResult` (how far a motion is free), and a `Proof` for each
proved pair and interval; or an error if rounding takes too large a part of the tolerance.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Bools, Floats, Ints
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.real_numbers import check_length

# MotionAnswer in cpp/motions/motion_report.hpp.
FREE, REFUSED, IMPRECISE = 0, 1, 2


class ImpreciseError(PlannercheckError):
    """Rounding is too large a part of the tolerance, for a reason, at the row of a motion or piece."""

    def __init__(self, name: str, row: int, tolerance: float) -> None:
        self.row = row
        self.reason = (
            "lengths and angles are so large that rounding is no small part of the tolerance of "
            f"{tolerance:g} m; choose a larger tolerance, or smaller numbers"
        )
        super().__init__(f"{name}: {self.reason}")


class Proof(NamedTuple):
    """The proof that a pair is apart on an interval of a motion.

    Attributes:
        pair: Row of the checker's pairs.
        start: Parameter.
        end: Parameter.
        frame: Index of the link in whose frame the direction is given, -1 for the world.
        flipped: Whether the direction points from the pair's first body to its second, else the other way.
        direction: (3,) unit vector up to rounding.
        gap: Along it both bodies are at least this far apart at both ends, m.
        chord_deviation: How far their points leave their chords at most, both bodies together, m; less than the gap.
    """

    pair: int
    start: float
    end: float
    frame: int
    flipped: bool
    direction: Floats
    gap: float
    chord_deviation: float


class MotionResult(NamedTuple):
    """How far a motion is free.

    Attributes:
        free: Whether the whole motion is free.
        free_until: It is proved free up to this parameter.
        near: If not free: the parameter at which the pair is within the tolerance.
        pair: If not free: row of the checker's pairs; else -1.
        proofs: If asked for, the proofs of all pairs up to `proved_until`.
        proved_until: `free_until`, or less where a pair that can't meet within the limits is so near that rounding
            prevents a proof, or where the planes would be too many.
    """

    free: bool
    free_until: float
    near: float
    pair: int
    proofs: tuple[Proof, ...] = ()
    proved_until: float = 0.0


def verdicts(
    answers: NDArray[np.uint8], tolerance: float, rows: NDArray[np.int64] | None = None, is_curve: bool = False
) -> Bools:
    """Which answers (n,), codes of the core, mean free; `rows` (n,) number the motions, or curves' pieces, for errors.

    Raises:
        ImpreciseError: If rounding is too large a part of the tolerance, m, for one of them.
    """
    if (answers == IMPRECISE).any():
        first = int(np.argmax(answers == IMPRECISE))
        row = first if rows is None else int(rows[first])
        raise ImpreciseError(f"{'piece' if is_curve else 'motion'} {row}", row, tolerance)
    return np.asarray(answers == FREE)


def motion_result_of(answer: int, until: float, near: float, pair: int, tolerance: float) -> MotionResult:
    """The result of one motion without proofs, or an error; only a refused one has the core's numbers."""
    if answer == IMPRECISE:
        raise ImpreciseError("motion 0", 0, tolerance)
    return MotionResult(True, 1.0, -1.0, -1) if answer == FREE else MotionResult(False, until, near, pair)


def proofs_of(frames: Sequence[int], pairs: Ints, intervals: Floats, directions: Floats, gaps: Floats) -> list[Proof]:
    """Proofs of the certifier's pairs from the core's arrays; `frames` are the pairs' links, -1 for the world."""
    listed = zip(pairs.tolist(), intervals.tolist(), directions, gaps.tolist(), strict=True)
    return [
        Proof(pair, start, end, frames[pair], False, direction, gap, chord_deviation)
        for pair, (start, end), direction, (gap, chord_deviation) in listed
    ]


def check_tolerance(tolerance: float) -> None:
    """Raises an error unless a tolerance is a positive length."""
    check_length(tolerance, "tolerance")
