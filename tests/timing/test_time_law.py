"""Time laws against the closed forms of straight motions, and their samples against splines of SciPy."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from plannercheck.timing.rounded_path import Legs, sections
from plannercheck.timing.time_law import Samples, fastest


def law_of(waypoints, velocity, acceleration, blend=0.0):
    legs = Legs.through(np.array(waypoints, dtype=float))
    (section,) = sections(legs, legs.blends(blend))
    return fastest(section.curve, np.array(velocity, dtype=float), np.array(acceleration, dtype=float))


@pytest.mark.parametrize("length", [1e-7, 1e-3, 1.0, 100.0])
@pytest.mark.parametrize(("velocity", "acceleration"), [(1, 2), (np.inf, 3), (0.1, 50)])
def test_a_straight_motion_takes_the_least_time(length, velocity, acceleration):
    law = law_of([[0, 0], [length, -length / 2]], [velocity, 9e9], [acceleration, 9e9])
    ramp = min(velocity / acceleration, (length / acceleration) ** 0.5)
    least = 2 * ramp + max(length - acceleration * ramp**2, 0) / velocity
    assert least * (1 - 1e-6) <= law.times[-1] <= 1.02 * least


def test_samples_are_the_spline_of_the_laws_lengths():
    law = law_of([[0, 0], [1, 0], [1, 1]], [1, 1], [2, 3], 0.1)
    samples = Samples.of(law, 0.02)
    count = len(samples.lengths)
    coefficients = np.interp(np.arange(-2, count), np.arange(count - 2), law.at(np.arange(count - 2) * samples.step))
    spline = BSpline(np.arange(-4, count + 2) * 1.0, coefficients, 3)
    k = np.arange(-1, count - 1)
    for order, values in enumerate((samples.lengths, samples.steps, samples.bends)):
        np.testing.assert_allclose(values, spline(k, order), atol=1e-12)
    assert samples.lengths[0] == 0
    assert samples.lengths[-1] == law.lengths[-1]
    for values in (samples.steps, samples.bends):
        assert values[0] == values[-1] == 0
    assert (np.diff(samples.lengths) >= 0).all()


def test_lengths_between_the_grid_follow_constant_accelerations():
    law = law_of([[0], [1]], [1], [2])
    times = np.linspace(0, law.times[-1], 4001)
    s = law.at(times)
    np.testing.assert_allclose(law.at(law.times), law.lengths, atol=1e-15)
    bends = np.diff(s, 2) / (times[1] - times[0]) ** 2
    assert np.abs(bends).max() < 2 * (1 + 1e-3)
    assert np.median(np.abs(bends[:800])) == pytest.approx(2, rel=1e-3)
    assert law.at(np.array([-1.0, 9.0])).tolist() == [0, 1]
