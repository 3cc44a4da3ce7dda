"""What proves a verdict about one pair: a separating plane, or a common point.

In: the core's answer and the posed bodies. Out: frozen values in world coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Of evaluating a product of a unit normal and a point in the world, in units of the point's size before posing: three
# products, two sums and as much for posing the point, each 1.1e-16.
_PLANE_ROUNDING = 16 * 2.0**-53


@dataclass(frozen=True)
class Separation:
    """A plane between two bodies: normal · x > offset for all x of the first, < offset for all of the second.

    Attributes:
        normal: Unit vector (3,) in the world, from the second body to the first.
        offset: The plane is normal · x = offset, in m; halfway between the bodies.
        gap: A lower bound of the distance between the bodies in m, rounded down; 0 if it is below rounding.
    """

    normal: Floats
    offset: float
    gap: float


@dataclass(frozen=True)
class SharedPoint:
    """A point of both bodies.

    Attributes:
        point: (3,) in the world, in m.
    """

    point: Floats


Certificate: TypeAlias = Separation | SharedPoint


def separation(normal: Floats, first: Floats, second: Floats, size: float) -> Separation:
    """The plane with a given normal between two sets of posed vertices.

    Args:
        normal: (3,) in the world, any length, from the second set to the first.
        first: Vertices (n, 3) in the world, m.
        second: Vertices (m, 3) in the world, m.
        size: Sum of the 1-norms of the largest vertex of either set, before posing, and of both translations, in m:
            posing rounds in proportion to these, however near to the origin it leads.

    Returns:
        The plane, with the gap along its normal rounded down.
    """
    unit = normal / np.linalg.norm(normal)
    low, high = float((first @ unit).min()), float((second @ unit).max())
    gap = (low - high - _PLANE_ROUNDING * size) * (1 - 2.0**-50)
    return Separation(unit, (low + high) / 2, max(gap, 0.0))
