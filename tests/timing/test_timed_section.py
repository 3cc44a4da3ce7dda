"""Points of a section: the controller's curve through them stays on the section, and keeps the limits."""

import numpy as np
import pytest
from scipy.interpolate import BPoly

from plannercheck.timing.rounded_path import Legs, sections
from plannercheck.timing.timed_section import joined, timed
from plannercheck.trajectories.joint_limits import JointLimits


def distance(path, q):
    """From a point to the chord of a path (n, nq) at its nearest point."""
    k = np.clip(np.linalg.norm(path - q, axis=1).argmin(), 1, len(path) - 2)
    chord = path[k + 1] - path[k - 1]
    away = q - path[k]
    return np.linalg.norm(away - chord * (away @ chord) / (chord @ chord))


@pytest.mark.parametrize("blend", [0.02, 0.1, 1.0])
def test_the_curve_through_the_points_stays_on_the_section(blend):
    legs = Legs.through(np.cumsum(np.random.default_rng(5).normal(size=(5, 3)), axis=0))
    limits = JointLimits(np.array([1.0, 2.0, np.inf]), np.array([2.0, 5.0, 3.0]))
    (section,) = sections(legs, legs.blends(blend))
    found = timed(section, limits, 0)
    rows = np.stack([found.points.positions, found.points.velocities, found.points.accelerations], axis=1)
    run = BPoly.from_derivatives(found.points.times, rows)
    path = section.curve.at(np.linspace(0, section.curve.breaks[-1], 20000))
    assert max(distance(path, q) for q in run(np.linspace(0, found.points.times[-1], 500))) < 1e-6
    assert 0.018e9 < found.nanoseconds < 0.021e9  # hardly slowed down, so that no more points were needed
    assert len(found.pieces) == len(found.points.times) - 1
    middles = run((found.points.times[1:] + found.points.times[:-1]) / 2)
    for corner in (1, 2, 3):
        near = np.linalg.norm(middles - legs.points[corner], axis=1).argmin()
        assert section.corners[found.pieces[near]] == corner
    names = ("a", "b", "c")
    assert np.array_equal(joined([found], names).points.times, found.points.times)
