"""Motions of planar robots on curves: their pieces and their samples.

In: both ends of a motion, the curve that the root follows. Out: the pieces that the core judges, and how many samples
the motion needs. OMPL's space for a kind of curve and a turning radius is made once.
"""

from __future__ import annotations

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.planar.curves import Curve, Curves
from plannercheck.planar.motion_certifier import STRAIGHT
from plannercheck.planar.motion_sampling import MotionSampler


class CurveMotions:
    """Pieces and samples of one robot's motions."""

    def __init__(self, sampler: MotionSampler) -> None:
        """Takes the robot's sampler."""
        self._sampler = sampler
        self._curves: dict[tuple[Curve, float], Curves] = {}

    def pieces(self, start: Floats, end: Floats, curve: Curve, turning_radius: float | None) -> Floats:
        """The pieces (k, 11) of a motion (nq,) to (nq,); none of a straight one."""
        if curve == "straight":
            return STRAIGHT
        return self._curves_of(curve, turning_radius).pieces(start, end, self._sampler.extent)

    def steps(
        self, start: Floats, end: Floats, curve: Curve, turning_radius: float | None, resolution: float | None
    ) -> int:
        """How many steps a motion on a curve needs, so that no point moves further than a resolution in one, m."""
        way = self._curves_of(curve, turning_radius).way(start, end, self._sampler)
        return int(self._sampler.steps_of_way(np.array([way]), resolution)[0])

    def _curves_of(self, curve: Curve, turning_radius: float | None) -> Curves:
        assert turning_radius is not None  # it was checked
        key = curve, float(turning_radius)
        if key not in self._curves:
            self._curves[key] = Curves(*key)
        return self._curves[key]
