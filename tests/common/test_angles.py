"""Whole turns against exact arithmetic: 2 pi to fifty digits, as OMPL goes round."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from ompl import base

from plannercheck.common.angles import nearest_turn, nearest_turns, unwound, wrapped

mpmath.mp.prec = 300
TWO_PI = Fraction(str(2 * mpmath.pi))
UNIT = 2.0**-53


def far_angles(n, seed):
    rng = np.random.default_rng(seed)
    return rng.choice([-1, 1], n) * 10 ** rng.uniform(-1, 15, n)


def test_turns_are_taken_off_as_if_two_pi_were_exact():
    angles = far_angles(3000, 1)
    turns = np.round(angles / (2 * np.pi))
    for angle, turn, left in zip(angles.tolist(), turns.tolist(), unwound(angles, turns).tolist(), strict=True):
        exact = Fraction(angle) - TWO_PI * int(turn)
        assert abs(Fraction(left) - exact) <= Fraction(UNIT * abs(left) * 1.0001 + 1e-31 * abs(angle) + 1e-17)


def test_ends_are_within_half_a_turn_of_starts_and_whole_turns_from_where_they_were():
    starts, ends = far_angles(3000, 2), far_angles(3000, 3)
    starts[::2] %= 7
    near = nearest_turns(starts, ends)
    for start, end, found in zip(starts.tolist(), ends.tolist(), near.tolist(), strict=True):
        assert nearest_turn(start, end) == found
        error = (Fraction(found) - Fraction(end)) / TWO_PI
        assert abs(error - round(error)) * 6 <= Fraction(UNIT * abs(found) * 1.01 + 1e-16)
        assert abs(found - start) <= np.pi * (1 + 1e-15) + np.spacing(abs(found)) / 2


def test_the_way_round_is_ompls():
    space = base.SO2StateSpace()
    first, second, between = (space.allocState() for _ in range(3))
    rng = np.random.default_rng(4)
    starts, ends = rng.uniform(-np.pi, np.pi, (2, 3000))
    ends[:1000] = starts[:1000] + rng.choice([-np.pi, np.pi], 1000) + rng.integers(-3, 4, 1000) * 4e-16
    kept = np.abs(ends) <= np.pi
    for start, end in zip(starts[kept].tolist(), ends[kept].tolist(), strict=True):
        first.value, second.value = start, end
        space.interpolate(first, second, 0.25, between)
        ours = start + 0.25 * (nearest_turn(start, end) - start)
        assert abs(np.sin((between.value - ours) / 2)) < 1e-15


def test_angles_near_the_starts_keep_their_bits():
    starts = np.zeros(4)
    ends = np.array([np.pi, -np.pi, 1e-300, 3.0])
    assert nearest_turns(starts, ends) is ends


@pytest.mark.parametrize("angle", [np.pi, -np.pi, np.nextafter(np.pi, 4), 3 * np.pi, 1e15, -1e9, 0.3])
def test_wrapped_angles_are_in_ompls_bounds(angle):
    found = float(wrapped(np.array([angle]))[0])
    assert -np.pi <= found < np.pi
    turns = (Fraction(found) - Fraction(float(angle))) / TWO_PI
    assert abs(turns - round(turns)) * 6 < Fraction(5e-16)
