"""Blends against finite differences, and legs against the waypoints they are made of."""

import numpy as np
import pytest

from plannercheck.timing.rounded_path import Legs, sections

WAYPOINTS = np.cumsum(np.random.default_rng(2).normal(size=(6, 3)), axis=0)


def rounded(deviation):
    legs = Legs.through(WAYPOINTS)
    return legs, list(sections(legs, legs.blends(deviation)))


def test_a_rounded_path_has_two_continuous_derivatives_by_its_length():
    _, (section,) = rounded(0.1)
    step = 1e-6
    for s in section.curve.breaks[1:-1].tolist():
        for order in (1, 2):
            before, after = section.curve.at([s - step, s + step], order)
            np.testing.assert_allclose(before, after, atol=3e-3 if order == 2 else 1e-6)
    speeds = np.linalg.norm(section.curve.at(section.curve.breaks, 1), axis=1)
    np.testing.assert_allclose(speeds, 1, atol=1e-12)


@pytest.mark.parametrize("deviation", [0.01, 0.1, 10.0])
def test_blends_pass_corners_within_the_deviation(deviation):
    legs, (section,) = rounded(deviation)
    path = section.curve.at(np.linspace(0, section.curve.breaks[-1], 20000))
    for k in range(1, len(WAYPOINTS) - 1):
        least = np.linalg.norm(path - WAYPOINTS[k], axis=1).min()
        assert 1e-4 < least < deviation * 1.01
        if deviation == 0.01:  # no leg is too short for it
            assert least == pytest.approx(deviation, rel=0.01)
    assert (legs.blends(deviation)[1:-1] <= 0.45 * np.minimum(legs.lengths[1:], legs.lengths[:-1])).all()


def test_without_blends_each_leg_is_a_section():
    legs, parts = rounded(0.0)
    assert len(parts) == len(WAYPOINTS) - 1
    for k, part in enumerate(parts):
        assert np.array_equal(part.curve.pieces[0], WAYPOINTS[k : k + 2])
    assert legs.given == tuple(range(len(WAYPOINTS)))


def test_repeated_waypoints_and_those_on_a_line_are_no_corners():
    a, b, c = np.array([[0.0, 0, 0], [1, 2, 0], [4, 2, 1]])
    waypoints = np.array([a, a, (a + b) / 2, b, b + 1e-12, b, (2 * b + c) / 3, (b + c) / 2, c, c])
    legs = Legs.through(waypoints)
    np.testing.assert_allclose(legs.points, [a, b, c], atol=1e-11)
    assert legs.given == (0, 3, 9)
    assert Legs.through(waypoints[[0, 1]]).given == (0,)


def test_the_path_stops_where_it_turns_back():
    legs = Legs.through(np.array([[0.0, 0], [1, 1], [0.25, 0.25], [1, 0]]))
    assert legs.blends(0.1)[1] == 0
    assert legs.blends(0.1)[2] > 0
    assert [part.corners for part in sections(legs, legs.blends(0.1))] == [(None,), (None, 2, None)]
