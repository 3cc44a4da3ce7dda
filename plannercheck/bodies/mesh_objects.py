"""Objects of a mesh file, as its reader gives them, before scale and names are settled.

In: points, polygons or triangles of a format's reader. Out: `RawObject`, checked: finite points, indices in range.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.errors import PlannercheckError

NO_FACES = "it has no faces: a cloud of points is no mesh"


@dataclass(frozen=True, eq=False)
class RawObject:
    """One object of a file.

    Attributes:
        name: Its name in the file, or "".
        points: (n, 3) in the unit that was asked for, posed, each used by a triangle.
        triangles: (m, 3) indices of points.
    """

    name: str
    points: Floats
    triangles: Ints64

    @staticmethod
    def of(name: str, points: Floats, triangles: Ints64) -> RawObject:
        """An object of the points that its triangles use; other points belong to no surface."""
        used = np.zeros(len(points), dtype=bool)
        used[triangles] = True
        if used.all():
            return RawObject(name, points, triangles)
        number = np.cumsum(used) - 1
        return RawObject(name, points[used], number[triangles])


def strip_triangles(strip: Ints64) -> Ints64:
    """The triangles (n - 2, 3) of a strip (n,): every second one is turned, so that all have one sense."""
    triangles = np.column_stack([strip[:-2], strip[1:-1], strip[2:]])
    triangles[1::2] = triangles[1::2, [1, 0, 2]]
    return triangles


def fan_triangles(fan: Ints64) -> Ints64:
    """The triangles (n - 2, 3) of a fan (n,) about its first corner."""
    return np.column_stack([np.full(len(fan) - 2, fan[0]), fan[1:-1], fan[2:]])


def check_indices(indices: Ints64, points: int, what: str, first: int = 0) -> None:
    """Raises for an index, counted from 0, that names no point; the error counts from `first`, as the file does."""
    wrong = (indices < 0) | (indices >= points)
    if wrong.any():
        index = int(indices[int(np.argmax(wrong))]) + first
        raise PlannercheckError(f"{what} names vertex {index}, but its vertices are {first} to {points - 1 + first}")
