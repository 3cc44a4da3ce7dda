"""Angles that count modulo a whole turn.

In: angles in rad, of any size. Out: the same angles less whole turns. Idea: 2 pi is no double; for k = 1e13, k times
its rounding error is 4 mm at the end of an arm. So 2 pi k is computed as a sum of doubles, and the rest of the angle is
rounded once, as if 2 pi were known exactly.
"""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np

from plannercheck.common.array_types import Floats

Numbers = TypeVar("Numbers", float, Floats)

# 2 pi is the sum of these two up to 6e-33.
TURN = 2 * math.pi
_TURN_REST = 2.4492935982947064e-16

# An angle of more than a turn, with room for 6.28319, is no orientation that anyone writes in rad.
LARGEST_USUAL_ANGLE = TURN + 0.01

# Veltkamp's factor, which cuts a double into two of 26 bits; and the two of TURN.
_SPLITTER = 2.0**27 + 1
_TURN_HIGH = _SPLITTER * TURN - (_SPLITTER * TURN - TURN)
_TURN_LOW = TURN - _TURN_HIGH


def unwound(angles: Numbers, turns: Numbers) -> Numbers:
    """Angles less whole turns, rounded once.

    Args:
        angles: Up to 1e15 rad.
        turns: Whole numbers, of about angles / 2 pi at most.

    Returns:
        angles - 2 pi turns up to u |result| + 1e-16 * 1e-15 |angles| rad, u = 2^-53: `product` + `lost` is
        TURN * turns (Dekker), `difference` + `left` is angles - product (Knuth), both exactly; what is left out of
        2 pi counts less than 1e-18 rad, and the small parts, at most 2u |angles| each, are rounded by 4u of that.
    """
    product = TURN * turns
    cut = _SPLITTER * turns
    high = cut - (cut - turns)
    low = turns - high
    lost = ((_TURN_HIGH * high - product) + _TURN_HIGH * low + _TURN_LOW * high) + _TURN_LOW * low
    difference = angles - product
    back = difference - angles
    left = (angles - (difference - back)) - (product + back)
    return difference + ((left - lost) - _TURN_REST * turns)


def nearest_turns(starts: Floats, ends: Floats) -> Floats:
    """Ends (rad) less whole turns, so that they are within half a turn of the starts, as OMPL has it.

    Ends that are there already keep their bits, the others are rounded once (`unwound`).
    """
    ways = ends - starts
    if not (np.abs(ways) > np.pi).any():
        return ends
    turns = _turns_too_many(ways)
    near = unwound(ends, turns)
    more = _turns_too_many(near - starts)  # far from 0 the ways are rounded
    if more.any():
        turns = turns + more
        near = unwound(ends, turns)
    return np.where(turns == 0, ends, near)


def nearest_turn(start: float, end: float) -> float:
    """`nearest_turns` of one angle: the same bits."""
    way = end - start
    if -math.pi <= way <= math.pi:
        return end
    return float(nearest_turns(np.array([start]), np.array([end]))[0])


def wrapped(angles: Floats) -> Floats:
    """Angles brought to [-pi, pi); those that are there already keep their bits."""
    near = nearest_turns(np.zeros_like(angles), angles)
    return np.where(near >= np.pi, -np.pi, near)  # no double is nearer to the sharp value, but those below -pi


def _turns_too_many(ways: Floats) -> Floats:
    """How many whole turns longer than need be ways are; 0 for up to half a turn, as double arithmetic has it."""
    lengths = np.abs(ways)
    # The next double after pi is more than half of TURN, also when divided: it is rounded to 1.
    return np.where(lengths > np.pi, np.copysign(np.round(lengths / TURN), ways), 0.0)


def share_within(rows: Floats, lower: Floats, upper: Floats) -> float:
    """The share of rows (n, nq) within limits; 1 if there are none."""
    return float(((rows >= lower) & (rows <= upper)).all(axis=1).mean()) if len(rows) else 1.0


def are_degrees(rows: Floats, lower: Floats, upper: Floats) -> bool:
    """Whether most rows (n, nq) would be within limits as degrees, and some number exceeds a whole turn as rad."""
    return share_within(np.radians(rows), lower, upper) >= 0.5 and float(np.abs(rows).max(initial=0)) > 2 * np.pi
