"""Heights of bodies along a direction, which are compared if a plane keeps two bodies apart.

In: points on a joint, a direction, rows (w, s) in ball arithmetic. Out: a lower bound of a body's height: w . v + s of
its lowest point, rounded downwards.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from flint import arb, arb_mat

from plannercheck.common.array_types import Floats
from plannercheck.proofs.rounding import ROUNDING, UNDERFLOW, UP

# The 4 x 4 matrix that takes a map's shift alone.
SHIFT = arb_mat(4, 4, [0] * 15 + [1])


class Seen(NamedTuple):
    """A body as seen by an entry.

    Attributes:
        points: (n, 3) whose hull counts: vertices or a centre.
        sizes: (3,) largest size of each coordinate.
        joint: The joint that it is on.
        place: Pose of the points on the joint, 4 x 4.
        centre: Centre of a ball, 4 x 1 on the joint; None for a hull.
        parts: Of a set its `Parts`, which points are the corners of a box around; else None.
    """

    points: Floats
    sizes: Floats
    joint: int
    place: Any
    centre: Any = None
    parts: Any = None


class Direction(NamedTuple):
    """A direction, fixed on a joint.

    Attributes:
        joint: The joint, -1 for the world.
        column: 4 x 1, the last 0.
        row: 1 x 4.
        length: At least its length.
    """

    joint: int
    column: Any
    row: Any
    length: float


def direction_on(joint: int, column: Any) -> Direction:
    """The direction of a column, 4 x 1, on a joint."""
    numbers = [float(x.abs_upper()) for x in column.entries()]
    return Direction(joint, column, column.transpose(), math.hypot(*numbers) * UP)


def lowest(seen: Seen, row: Any) -> float:
    """At most the least value of a linear function (w, s) on a body's points; -infinity or NaN if it is not known."""
    entries = row.entries()
    if len(seen.points) == 1:
        value = sum((x * arb(c) for x, c in zip(entries, seen.points[0].tolist(), strict=False)), entries[3]).lower()
        return float(value) - abs(float(value)) * ROUNDING - UNDERFLOW
    middles = np.array([float(x) for x in entries])
    loose = np.array([float(x.rad()) for x in entries]) + np.abs(middles) * ROUNDING
    values = seen.points @ middles[:3] + middles[3]
    error = float(loose[:3] @ seen.sizes + loose[3])
    return float(values.min()) - error * UP - UNDERFLOW
