"""What the core's certifiers of motions answer, in space and in the plane.

In: the core's codes and arrays. Out: verdicts, a `Passage` (how far a motion is free), and a `Proof` for each pair and
interval that was proved; or an error, where rounding takes too much of the tolerance.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.errors import PlannercheckError

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.int32]

# MotionAnswer in cpp/motions/motion_certifier.hpp, PlanarAnswer in cpp/planar/motion_certifier_2d.hpp.
FREE, REFUSED, IMPRECISE = 0, 1, 2


class Proof(NamedTuple):
    """What proves a pair apart on an interval.

    Attributes:
        pair: Row of the checker's pairs.
        start: Parameter.
        end: Parameter.
        frame: Index of the link in whose frame the direction is, -1 for the world.
        flipped: Whether the direction points from the pair's first body to its second, else the other way.
        direction: (3,) unit vector up to rounding.
        gap: Along it both bodies are at least this far apart at both ends, m.
        bulge: Their points leave their chords by at most this, which is less than the gap, m.
    """

    pair: int
    start: float
    end: float
    frame: int
    flipped: bool
    direction: Floats
    gap: float
    bulge: float


class Passage(NamedTuple):
    """How far a motion is free.

    Attributes:
        free: Whether all of it is.
        free_until: It is proved free up to this parameter.
        near: If not free: the parameter at which the pair is within the tolerance.
        pair: If not free: row of the checker's pairs; else -1.
        proofs: If wanted, what proves it free, all pairs, up to `proved_until`.
        proved_until: That is `free_until`, or less if a pair that can't meet within the limits is nearer all the time
            than rounding allows to prove.
    """

    free: bool
    free_until: float
    near: float
    pair: int
    proofs: tuple[Proof, ...] = ()
    proved_until: float = 0.0


def verdicts(answers: Ints, tolerance: float, rows: NDArray[np.int64] | None = None) -> Bools:
    """Which answers (n,) mean free.

    Args:
        answers: The core's.
        tolerance: m.
        rows: (n,) numbers of the motions, for errors; None if they are 0, 1, …

    Raises:
        PlannercheckError: If rounding is no small part of the tolerance for one of them.
    """
    if (answers == IMPRECISE).any():
        first = int(np.argmax(answers == IMPRECISE))
        raise _imprecise(first if rows is None else int(rows[first]), tolerance)
    return np.asarray(answers == FREE)


def passage_of(answer: int, until: float, near: float, pair: int, tolerance: float) -> Passage:
    """The passage of one motion without proofs, or an error; only a refused one has the core's numbers."""
    if answer == IMPRECISE:
        raise _imprecise(0, tolerance)
    return Passage(True, 1.0, -1.0, -1) if answer == FREE else Passage(False, until, near, pair)


def proofs_of(frames: Sequence[int], pairs: Ints, intervals: Floats, directions: Floats, gaps: Floats) -> list[Proof]:
    """Proofs of the certifier's pairs from the core's arrays; `frames` are the pairs' links, -1 for the world."""
    listed = zip(pairs.tolist(), intervals.tolist(), directions, gaps.tolist(), strict=True)
    return [
        Proof(pair, start, end, frames[pair], False, direction, gap, bulge)
        for pair, (start, end), direction, (gap, bulge) in listed
    ]


def check_tolerance(tolerance: float) -> None:
    """Raises an error if a tolerance is no positive length."""
    if not 0 < tolerance < float("inf"):
        raise PlannercheckError(f"tolerance must be a positive length in m, not {tolerance!r}")


def _imprecise(row: int, tolerance: float) -> PlannercheckError:
    """The error for a motion whose rounding exceeds a part of the tolerance."""
    return PlannercheckError(
        f"motion {row}: lengths and angles are so large that rounding is no small part of the tolerance of "
        f"{tolerance:g} m; choose a larger tolerance, or smaller numbers"
    )
