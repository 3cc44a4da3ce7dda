"""A section of a path as points that a controller interpolates, under limits that hold between the points as well.

In: a section, limits. Out: `TimedSection`: points at whole nanoseconds, from rest to rest.

The points are slowed down by one factor until the quintic polynomials between them keep the limits. Slower points give
the same curve, so its proof holds. If the factor is large, more points give a faster trajectory.
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
from plannercheck.trajectories.trajectory import Trajectory

# First step between points, s: plans of the Panda then take about 1 % longer than TOPP-RA's law. A section has so many
# steps at first at most, and steps are halved so often at most.
STEP, _STEPS, HALVINGS = 0.02, 500, 3

# A blend takes so many of the least steps at least, or the whole section would be slowed down for it.
_STEPS_A_BLEND = 10

# Slowing down by more than this calls for more points.
_SLOWER = 1.04

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


def timed(section: Section, limits: JointLimits, halvings: int) -> TimedSection | None:
    """A section with its points; None if TOPP-RA finds no law.

    Args:
        section: The section.
        limits: The limits of each joint.
        halvings: How often the first step is halved; it is halved further where that makes the section faster.
    """
    law = fastest(section.curve, limits.velocity, limits.acceleration)
    if law is None:
        return None
    first = max(STEP, float(law.times[-1]) / _STEPS)
    if len(section.legs) > 1:
        least = _STEPS_A_BLEND * first * 0.5**HALVINGS
        law = fastest(section.curve, limits.velocity, limits.acceleration, least)
    if law is None:
        return None
    found, factor = _sampled(section, law, limits, first * 0.5**halvings)
    while factor > _SLOWER and halvings < HALVINGS:
        halvings += 1
        found, factor = _sampled(section, law, limits, first * 0.5**halvings)
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
    """By what factor points have to be slowed down to keep the limits; at most 1 if they do.

    The derivatives of the polynomials are in the hull of their control points.
    """
    (p, q), (v, w), (a, b) = (
        (rows[:-1], rows[1:]) for rows in (points.positions, points.velocities, points.accelerations)
    )
    h = np.diff(points.times)[:, None]
    after, before = v + a * (h / 4), w - b * (h / 4)
    middle = 5 * (q - p) / h - 2 * (v + w) + (b - a) * (h / 4)
    speeds = np.abs([v, after, middle, before, w]) / limits.velocity
    bends = np.abs([a, 4 * (middle - after) / h, 4 * (before - middle) / h, b]) / limits.acceleration
    return float(max(speeds.max(), bends.max() ** 0.5))


def joined(sections: Sequence[TimedSection], names: Sequence[str]) -> Trajectory:
    """The trajectory of these joints through one section or more; the last point of one is the first of the next."""
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
