"""Pieces of chunks and stops proved free, with a gate's tube and margin.

In: a checker, settings, polynomials. Out: which are proved.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.motions.certifier_answers import ImpreciseError
from plannercheck.motions.checker import Checker
from plannercheck.motions.motion_ends import Curves
from plannercheck.motions.trajectory_checks import TrajectoryChecks
from plannercheck.trajectories.curve import ROUNDED_UP
from plannercheck.validation.gates.settings import GateSettings
from plannercheck.validation.gates.stops import Stops


class ChunkProofs:
    """Proves pieces for one checker by a gate's settings."""

    def __init__(self, checker: Checker, settings: GateSettings) -> None:
        """Takes a checker whose scene stands still."""
        self.checker, self._settings = checker, settings
        self.certifier = checker.certifier_of("slerp")

    @cached_property
    def checks(self) -> TrajectoryChecks:
        """Judges trajectories by the same tube, margin and tolerance."""
        told = self._settings
        return TrajectoryChecks(self.checker, told.tube, told.tolerance, told.margin)

    def free(self, points: Floats, error: Floats) -> Bools:
        """(m,) which curves are proved free, by control points (m, degree + 1, nq) that are off by an error (nq,).

        Curves whose numbers are so large that rounding is no small part of the tolerance are not proved.
        """
        told = self._settings
        tubes = np.empty((len(points), points.shape[2] + 1))
        tubes[:, :-1] = (told.tube + error) * ROUNDED_UP
        tubes[:, -1] = told.margin
        try:
            return self.certifier.check_curves(Curves(points, tubes), told.tolerance, 1)
        except ImpreciseError:
            if len(points) == 1:
                return np.zeros(1, dtype=bool)
            return np.concatenate([self.free(points[k : k + 1], error) for k in range(len(points))])

    def stop_pieces_free(self, error: Floats, stops: Stops) -> Bools:
        """(n, nq) which pieces of stops are proved; `error` (nq,) is of the states in which these begin."""
        free = np.ones(stops.lasting.shape, dtype=bool)
        if stops.lasting.any():
            points = np.ascontiguousarray(stops.points[stops.lasting])
            free[stops.lasting] = self.free(points, stops.error + error)
        return free
