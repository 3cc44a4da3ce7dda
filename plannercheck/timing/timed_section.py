"""A section of a path as points that a controller interpolates, under limits that hold between the points as well.

In: a section, limits. Out: `TimedSection`: points at whole nanoseconds, from rest to rest.

The points are slowed down by one factor until the quintic polynomials between them keep the limits. Slower points give
the same curve, so that a proof of it needs no second look. Where the factor is large, more points cost less time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import OwnsArrays
from plannercheck.timing.rounded_path import Section
from plannercheck.timing.time_law import Law, Samples, fastest
from plannercheck.trajectories.controllers import Points
from plannercheck.trajectories.joint_limits import JointLimits
from plannercheck.trajectories.limits import broken_limits
from plannercheck.trajectories.trajectory import Trajectory

# Steps between points, s: the first that is tried, and the least. Plans of the Panda take 1 % longer than TOPP-RA's at
# the first one (tests/benchmarks/rounded_plans.py).
STEP = 0.02
FINEST = STEP / 8

# Slowing down by more than this calls for more points.
_SLOWER = 1.02

# Slowed down a little further, for the rounding of times.
_MARGIN = 1 + 1e-9


@dataclass(frozen=True, eq=False)
class TimedSection(OwnsArrays):
    """A section with its points.

    Attributes:
        section: The section.
        nanoseconds: Time from point to point.
        points: Its points, from 0 s on.
        pieces: (n - 1,) which piece of the section the middle between a point and the next is on.
    """

    section: Section
    nanoseconds: int
    points: Points
    pieces: Ints64


def timed(section: Section, limits: JointLimits, step: float) -> TimedSection | None:
    """A section with its points, at most `step` s apart at first; None if TOPP-RA finds no law."""
    law = fastest(section.curve, limits.velocity, limits.acceleration)
    if law is None:
        return None
    found, factor = _sampled(section, law, limits, step)
    while factor > _SLOWER and step > FINEST:
        step /= 2
        found, factor = _sampled(section, law, limits, step)
    return found


def _sampled(section: Section, law: Law, limits: JointLimits, step: float) -> tuple[TimedSection, float]:
    """A section with its points, and by what factor they were slowed down."""
    samples = Samples.of(law, step)
    length = section.curve.breaks[-1]
    q, rate, bend = (section.curve.at(np.clip(samples.lengths, 0.0, length), order) for order in range(3))
    by_sample = q, rate * samples.steps[:, None], bend * samples.steps[:, None] ** 2 + rate * samples.bends[:, None]
    first = nanoseconds = int(np.ceil(samples.step * 1e9))
    points = _points(by_sample, nanoseconds)
    while (factor := _excess(points, limits)) > 1:
        nanoseconds = int(np.ceil(nanoseconds * factor * _MARGIN))
        points = _points(by_sample, nanoseconds)
    middles = (samples.lengths[:-1] + samples.lengths[1:]) / 2
    pieces = np.searchsorted(section.curve.breaks[1:-1], middles, side="right")
    return TimedSection(section, nanoseconds, points, pieces), nanoseconds / first


def _points(by_sample: tuple[Floats, Floats, Floats], nanoseconds: int) -> Points:
    """Points from positions and their derivatives by the number of the sample, at rest at both ends."""
    times = np.arange(len(by_sample[0])) * nanoseconds / 1e9
    second = nanoseconds / 1e9
    return Points(times, by_sample[0], by_sample[1] / second, by_sample[2] / second**2)


def _excess(points: Points, limits: JointLimits) -> float:
    """By what factor points have to be slowed down to keep the limits; at most 1 if they do."""
    curve = Trajectory(points.times, points.positions, points.velocities, points.accelerations).curve
    names = [str(j) for j in range(curve.nq)]
    speeds = broken_limits(curve, names, "velocity", -limits.velocity, limits.velocity)
    bends = broken_limits(curve, names, "acceleration", -limits.acceleration, limits.acceleration)
    factors = [each.value / each.limit for each in speeds] + [(each.value / each.limit) ** 0.5 for each in bends]
    return max(factors, default=1.0)


def joined(sections: Sequence[TimedSection], names: Sequence[str]) -> Trajectory:
    """The trajectory through sections in a row; the last point of one is the first of the next.

    Args:
        sections: At least one.
        names: Of the joints.
    """
    ends = np.cumsum([(len(each.points.times) - 1) * each.nanoseconds for each in sections])
    starts = np.concatenate([[0], ends[:-1]])
    stamps = [
        start + np.arange(len(each.points.times)) * each.nanoseconds
        for start, each in zip(starts, sections, strict=True)
    ]
    points = [each.points for each in sections]
    return Trajectory(
        _through(stamps) / 1e9,
        _through([each.positions for each in points]),
        _through([each.velocities for each in points]),
        _through([each.accelerations for each in points]),
        joint_names=names,
    )


def _through(rows: Sequence[Any]) -> Any:
    """Rows of sections one after the other, without the first row of all sections but the first."""
    return np.concatenate([rows[0], *(each[1:] for each in rows[1:])])
