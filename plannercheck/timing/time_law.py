"""The robot's place on a section at each time: TOPP-RA, and even samples of it with continuous accelerations.

In: a section of a rounded path, limits. Out: `Samples`.

TOPP-RA (Pham and Pham 2018, `toppra`) gives the fastest s(t) from rest to rest under the limits, with an acceleration
that jumps. A quintic polynomial between samples can't follow a jump and would overshoot. So s(t) is the cubic B-spline
whose coefficients are samples of TOPP-RA's s, h apart: its acceleration is continuous, 0 at both ends, and never above
means of TOPP-RA's acceleration; it takes 2 h longer. Its knots are the samples, so on a straight leg the quintic
polynomial between two of them is the spline itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.optional_imports import extra_module
from plannercheck.trajectories.curve import Curve

# TOPP-RA holds the limits at so many places of each piece, closer to its ends: there a fast robot speeds up on a short
# part of a long leg. A part of 0 to 1 of the piece each.
_GRID = (1 - np.cos(np.linspace(0, np.pi, 41)[:-1])) / 2


@dataclass(frozen=True, eq=False)
class Law(OwnsArrays):
    """TOPP-RA's answer: constant accelerations between times.

    Attributes:
        times: (n,) s from 0 on.
        lengths: (n,) how far along the section, rad and m.
        speeds: (n,) by s.
    """

    times: Floats
    lengths: Floats
    speeds: Floats

    def at(self, times: Floats) -> Floats:
        """Lengths at times (m,), standing before the first and after the last."""
        times = np.clip(times, 0.0, self.times[-1])
        k = np.clip(np.searchsorted(self.times, times, side="right") - 1, 0, len(self.times) - 2)
        part = (times - self.times[k]) / np.diff(self.times)[k]
        u, v = self.speeds[k], self.speeds[k + 1]
        # The speed is linear: its mean is (u + v) / 2, which is scaled so that the way is exactly that between lengths.
        return self.lengths[k] + np.diff(self.lengths)[k] * part * (2 * u + (v - u) * part) / (u + v)


@dataclass(frozen=True, eq=False)
class Samples(OwnsArrays):
    """A section's time law at even times.

    Attributes:
        step: Time from sample to sample, s.
        lengths: (n,) how far along the section, rad and m.
        steps: (n,) their first derivative by the number of the sample.
        bends: (n,) the second one.
    """

    step: float
    lengths: Floats
    steps: Floats
    bends: Floats

    @classmethod
    def of(cls, law: Law, step: float) -> Samples:
        """Samples of the spline whose coefficients are the law's lengths each `step` s or somewhat less."""
        count = max(int(np.ceil(law.times[-1] / step)), 1)
        even = float(law.times[-1]) / count
        s = law.at(np.arange(-2.0, count + 3.0) * even)
        bends = s[2:] - 2 * s[1:-1] + s[:-2]
        return cls(even, s[1:-1] + bends / 6, (s[2:] - s[:-2]) / 2, bends)


def fastest(curve: Curve, velocity: Floats, acceleration: Floats, least: float = 0.0) -> Law | None:
    """The fastest law from rest to rest of a section by its length; None if TOPP-RA finds none.

    Largest speeds and accelerations are (nq,), in rad and m a second; a blend takes at least so many seconds.
    """
    toppra = extra_module("toppra", "timing", "timed plans")
    # In units in which the section has length 1 and the largest acceleration is 1: toppra's thresholds are absolute.
    length = float(curve.breaks[-1])
    second = float(np.sqrt(length / acceleration.max()))
    s = np.append(curve.breaks[:-1, None] + np.diff(curve.breaks)[:, None] * _GRID, curve.breaks[-1])
    unit = s / length
    unit[-1] = 1.0
    slow = [np.diff(curve.breaks)[k] / least if least and len(p) > 2 else np.inf for k, p in enumerate(curve.pieces)]
    speeds = np.append(np.repeat(slow, len(_GRID)), np.inf) * (second / length)
    algorithm = toppra.algorithm.TOPPRA(
        [
            _velocity(toppra, velocity * (second / length), speeds),
            toppra.constraint.JointAccelerationConstraint(_band(acceleration * (second * second / length))),
        ],
        _path(toppra, curve, length),
        gridpoints=unit,
        solver_wrapper="seidel",
    )
    found = algorithm.compute_parameterization(0, 0)[1]
    if found is None or not np.isfinite(found).all():
        return None
    means = (found[1:] + found[:-1]) / 2
    if not (means > 0).all():
        return None
    return Law(np.concatenate([[0.0], np.cumsum(np.diff(unit) / means)]) * second, s, found * (length / second))


def _band(limits: Floats) -> Floats:
    return np.stack([-limits, limits], axis=1)


def _velocity(toppra: Any, velocity: Floats, speeds: Floats) -> Any:
    """Limits of joints (nq,), and of the path's own speed at the places of the grid."""

    class Velocity(toppra.constraint.JointVelocityConstraint):  # type: ignore[misc]
        def compute_constraint_params(self, path: Any, gridpoints: Any) -> Any:
            found = super().compute_constraint_params(path, gridpoints)
            found[-1][:, 1] = np.minimum(found[-1][:, 1], speeds**2)  # bounds of squares
            return found

    return Velocity(_band(velocity))


def _path(toppra: Any, curve: Curve, length: float) -> Any:
    """A section of length 1 as toppra asks for it."""

    class Path(toppra.interpolator.AbstractGeometricPath):  # type: ignore[misc]
        dof = curve.nq
        path_interval = np.array([0.0, 1.0])
        waypoints = None

        def __call__(self, path_positions: Any, order: int = 0) -> Floats:
            s = np.minimum(np.asarray(path_positions) * length, length)
            return curve.at(s, order) * length ** (order - 1)

    return Path()
