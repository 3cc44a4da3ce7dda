"""Curves cut and put side by side run through the same configurations, up to the errors that they state."""

from __future__ import annotations

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.trajectories.curve import Curve
from plannercheck.trajectories.merged_curves import between, shifted, side_by_side

_UNIT = 2.0**-53


def _polynomials(rng: np.random.Generator, nq: int) -> Curve:
    """Quintics from 0 to 4 s."""
    knots = np.sort(np.concatenate([[0, 4], rng.uniform(0.2, 3.8, 3)]))
    q, v, a = (rng.uniform(-1, 1, (len(knots), nq)) for _ in range(3))
    v[-1] = 0
    return pc.Trajectory(knots, q, v, a).curve


def _turns(rng: np.random.Generator) -> Curve:
    rows = rng.standard_normal((4, 7))
    rows[:, 3:] /= np.linalg.norm(rows[:, 3:], axis=1, keepdims=True)
    times = np.array([0.0, *np.sort(rng.uniform(0.5, 3.5, 2)), 4.0])
    return Curve(times, tuple(np.stack(pair) for pair in zip(rows[:-1], rows[1:], strict=True)), np.zeros(7), ((3, 7),))


@pytest.mark.parametrize("seed", range(5))
def test_side_by_side_curves_are_the_curves(seed: int) -> None:
    """At random times, by their own evaluation; late clocks count in the errors."""
    rng = np.random.default_rng(seed)
    late = float(rng.choice([0.0, 3.7, 1e6]))
    curves = [shifted(each, late) for each in (_polynomials(rng, 3), _turns(rng), _polynomials(rng, 2))]
    end = curves[0].breaks[-1]
    curves = [between(each, late, end) for each in curves]
    merged = side_by_side(curves)
    assert merged.nq == 12 and merged.units == ((6, 10),)
    assert set(merged.breaks) == {time for curve in curves for time in curve.breaks}
    times = np.concatenate([merged.breaks, rng.uniform(late, end, 200)])
    expected = np.concatenate([curve.at(times) for curve in curves], axis=1)
    off = np.abs(merged.at(times) - expected)
    evaluated = 400 * _UNIT * (1 + 1e2 * late)
    assert (off <= merged.error + evaluated).all()
    plain = np.r_[0:6, 10:12]
    assert (merged.error[plain] < (1e-13 if late < 10 else 1e-8)).all() and not merged.error[6:10].any()
    for before, after in zip(merged.pieces, merged.pieces[1:], strict=False):
        assert np.array_equal(before[-1], after[0])


def test_a_curve_stands_still_before_and_after() -> None:
    """Between times beyond its own."""
    curve = _turns(np.random.default_rng(0))
    longer = between(curve, -1.0, 6.0)
    assert np.array_equal(longer.at([-1.0, -0.5]), curve.at([0.0, 0.0]))
    assert np.allclose(longer.at([4.5, 6.0]), curve.at([4.0, 4.0]), atol=1e-15)
    inside = between(curve, 1.0, 2.0)
    assert np.allclose(inside.at([1.0, 1.7, 2.0]), curve.at([1.0, 1.7, 2.0]), atol=1e-15)
    apart = between(curve, 5.0, 6.0)
    assert np.allclose(apart.at([5.0, 6.0]), curve.at([4.0, 4.0]), atol=1e-15)


def test_a_clock_that_doubles_cannot_tell_is_refused() -> None:
    """At 1e17 s two breaks are the same double."""
    with pytest.raises(pc.PlannercheckError, match="begin the clock later"):
        shifted(_turns(np.random.default_rng(0)), 1e17)
