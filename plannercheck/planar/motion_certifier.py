"""Proves planar motions free: a checker's bodies and pairs for the certifier (cpp/planar/motion_certifier_2d.hpp).

In: the core's model of a planar checker; motions, given by both ends and, on curves, by their pieces. Out:
whether they are free, how far, and proofs. The proofs cover the rounding of configurations and poses.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.core import core
from plannercheck.motions.certifier_answers import (
    FREE,
    MotionResult,
    check_tolerance,
    motion_result_of,
    proofs_of,
    verdicts,
)

# PlanarPiece in cpp/planar/motion_bounds_2d.hpp: parameters from and to, origin, way, heading, turn, arm, slip.
PIECE_NUMBERS = 11
STRAIGHT: Floats = np.zeros((0, PIECE_NUMBERS))


class MotionCertifier:
    """Judges motions of one planar robot among given pairs of bodies. Immutable, so threads may share it."""

    def __init__(self, model: Any) -> None:
        """Takes the core's model of robot, bodies and pairs."""
        self._core = core.PlanarCertifier(model)
        self._frames = self._core.frames().tolist()

    def check(self, q0: Floats, q1: Floats, tolerance: float, threads: int, given: Floats | None = None) -> Bools:
        """Whether each straight motion (n, nq) to (n, nq) is free.

        Args:
            q0: Starts, validated.
            q1: Ends; angles move linearly from one number to the other.
            tolerance: m.
            threads: Number of threads to use.
            given: Ends before whole turns were taken off their angles, which rounds them; None if none were.

        Returns:
            (n,) True means proved free, False that a pair comes within the tolerance.
        """
        check_tolerance(tolerance)
        answers = np.asarray(self._core.check(q0, q1, q1 if given is None else given, tolerance, threads))
        return verdicts(answers, tolerance)

    def is_free(
        self,
        q0: ArrayLike,
        q1: ArrayLike,
        tolerance: float,
        pieces: Floats = STRAIGHT,
        given: Floats | None = None,
    ) -> bool:
        """Whether one motion (nq,) to (nq,) is proved free; `given` as for `check`.

        Pieces of a curve are (k, 11), from `Curves.pieces`; none for a straight motion.
        """
        check_tolerance(tolerance)
        start, end = (np.asarray(q, dtype=np.float64) for q in (q0, q1))
        answer = self._core.check_pieces(start, end, end if given is None else given, pieces, tolerance)
        return bool(verdicts(np.array([answer]), tolerance)[0])

    def motion_result(
        self,
        q0: Floats,
        q1: Floats,
        tolerance: float,
        proofs: bool = False,
        pieces: Floats = STRAIGHT,
        given: Floats | None = None,
    ) -> MotionResult:
        """How far one validated motion is free, from its start on, on request with the proofs of all pairs.

        Arguments as for `is_free`.
        """
        check_tolerance(tolerance)
        asked = q0, q1, q1 if given is None else given, pieces, tolerance
        answer, until, near, pair = self._core.explain(*asked, False)[:4]
        found = motion_result_of(answer, until, near, pair, tolerance)
        if not proofs:
            return found
        answer, reached, _, _, *listed = self._core.explain(*asked, True)
        kept = tuple(each for each in proofs_of(self._frames, *listed) if found.free or each.start < found.free_until)
        return found._replace(proofs=kept, proved_until=min(found.free_until, 1.0 if answer == FREE else reached))

    def states(self, q0: Floats, q1: Floats, parameters: Floats, pieces: Floats = STRAIGHT) -> Floats:
        """(k, nq) of one motion at parameters (k,) in [0, 1]."""
        return np.asarray(self._core.states(q0, q1, pieces, parameters))

    def statistics(self) -> dict[str, Any]:
        """Counters of all calls so far."""
        return dict(self._core.statistics())
