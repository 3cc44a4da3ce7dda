"""Curves as rows of `Motions`: q0 holds all control points but the last, q1 the last control point and the tube.

In: such a row. Out: control points and tube.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.robots.robot import Robot


class CurveNumbers(NamedTuple):
    """A curve's numbers: (degree + 1, nq) control points and (nq,) the tube, rad and m."""

    points: Floats
    tube: Floats


def numbers_of(q0: Floats, q1: Floats) -> CurveNumbers:
    """The curve of a row of `Motions`."""
    last, tube = np.split(q1, 2)
    return CurveNumbers(np.concatenate([q0.reshape(-1, len(last)), last[None]]), tube)


def rows_of(points: Floats, tube: Floats) -> tuple[Floats, Floats]:
    """q0 and q1 of curves with control points (n, degree + 1, nq), and one tube (nq,)."""
    n = len(points)
    return points[:, :-1].reshape(n, -1), np.hstack([points[:, -1], np.tile(tube, (n, 1))])


def unit_columns(robot: Robot) -> Bools:
    """(nq,) which numbers are of unit vectors: they follow no polynomial, and have no tube."""
    covered = np.zeros(robot.nq, dtype=bool)
    for first, past in robot.configuration_map.units:
        covered[first:past] = True
    return covered
