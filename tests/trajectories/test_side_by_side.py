"""Curves cut and put side by side run through the same configurations, up to the errors that they state."""

import itertools

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.trajectories.curve import Curve
from plannercheck.trajectories.one_clock import Clocked, side_by_side


def _polynomials(rng: np.random.Generator, nq: int) -> Curve:
    """Quintics from 0 to 4 s."""
    knots = np.sort(np.concatenate([[0, 4], rng.uniform(0.2, 3.8, 3)]))
    q, v, a = (rng.uniform(-1, 1, (len(knots), nq)) for _ in range(3))
    v[-1] = 0
    return pc.Trajectory(knots, q, v, a).curve


def _turns(rng: np.random.Generator) -> Curve:
    rows = rng.standard_normal((4, 7))
    rows[:, 3:] = np.abs(rows[:, 3:]) / np.linalg.norm(rows[:, 3:], axis=1, keepdims=True)
    times = np.array([0.0, *np.sort(rng.uniform(0.5, 3.5, 2)), 4.0])
    return Curve(times, tuple(np.stack(pair) for pair in itertools.pairwise(rows)), np.zeros(7), ((3, 7),))


@pytest.mark.parametrize("seed", range(6))
def test_side_by_side_curves_are_the_curves(seed: int) -> None:
    """At random times, by their own evaluation; late clocks count in the errors."""
    rng = np.random.default_rng(seed)
    late = float(rng.choice([0.0, -7.3, 1e3]))
    curves = [_polynomials(rng, 3), _turns(rng), _polynomials(rng, 2)]
    clocked = [Clocked(curve, curve.breaks + by) for curve, by in zip(curves, late + np.array([0, -1, 1]), strict=True)]
    begin, end = clocked[0].knots[[0, -1]]
    merged = side_by_side(clocked, begin, end)
    assert merged.nq == 12
    assert merged.units == ((6, 10),)
    knots = np.concatenate([each.knots for each in clocked])
    assert set(merged.breaks) == {*knots[(knots >= begin) & (knots <= end)].tolist()}
    times = np.concatenate([merged.breaks, rng.uniform(begin, end, 200)])
    expected = [
        curve.at(np.clip(times - each.knots[0] + curve.breaks[0], 0, 4))
        for curve, each in zip(curves, clocked, strict=True)
    ]
    off = np.abs(merged.at(times) - np.concatenate(expected, axis=1))
    assert (off <= merged.error + 2.0**-44 * (1 + abs(late))).all()
    assert (merged.error < 1e-11 * (1 + abs(late))).all()
    for before, after in zip(merged.pieces, merged.pieces[1:], strict=False):
        assert np.array_equal(before[-1], after[0])


def test_a_curve_stands_still_before_and_after() -> None:
    """Between times beyond its own, and within them."""
    rng = np.random.default_rng(0)
    curve = _turns(rng)
    for begin, end in ((-1.0, 6.0), (1.0, 2.0), (5.0, 6.0), (-3.0, -2.0)):
        clock = Curve(np.array([begin, end]), (np.zeros((2, 1)),), np.zeros(1))
        found = side_by_side([Clocked(clock, clock.breaks), Clocked(curve, curve.breaks)], begin, end)
        times = np.linspace(begin, end, 31)
        assert np.allclose(found.at(times)[:, 1:], curve.at(np.clip(times, 0, 4)), atol=1e-14)
        assert found.breaks[[0, -1]].tolist() == [begin, end]


def test_turns_at_late_times_are_refused() -> None:
    """Doubles are too coarse for them at the times of Unix; no tube is around a unit vector."""
    curve = _turns(np.random.default_rng(0))
    with pytest.raises(pc.PlannercheckError, match="times that are not as late"):
        side_by_side([Clocked(curve, curve.breaks + 1.7e9)], 1.7e9, 1.7e9 + 4)


def test_knots_that_a_clock_cannot_tell_apart_are_refused() -> None:
    """At 1e17 s two breaks are the same double."""
    curve = _turns(np.random.default_rng(0))
    with pytest.raises(pc.PlannercheckError, match="less than a nanosecond"):
        side_by_side([Clocked(curve, curve.breaks + 1e17)], 1e17, 1e17 + 16)
