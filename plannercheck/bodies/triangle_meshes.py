"""Triangle meshes as their files have them: whether they are closed, and their volume.

In: coal's meshes, or mesh files. Out: `TriangleMesh`, with equal points merged. Verdicts use the hulls of meshes. These
classes measure how much a hull adds, and have the triangles that a convex decomposition has to cover.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plannercheck.common.array_types import Floats, Ints, Ints64
from plannercheck.common.arrays import OwnsArrays, distinct, distinct_rows


@dataclass(frozen=True, eq=False)
class TriangleMesh(OwnsArrays):
    """A mesh of triangles.

    Attributes:
        points: (n, 3) m, each once.
        triangles: (m, 3) indices of points, without those that have a corner twice.
    """

    points: Floats
    triangles: Ints64

    @staticmethod
    def of(points: Floats, triangles: Ints | Ints64) -> TriangleMesh:
        """Merges equal points (n, 3), m, of triangles (m, 3); the result does not depend on the order of either."""
        merged, index = distinct_rows(points)
        corners = index[triangles].reshape(-1, 3)
        a, b, c = corners.T
        corners = corners[(a != b) & (b != c) & (c != a)]
        turned = np.take_along_axis(corners, (corners.argmin(axis=1)[:, None] + np.arange(3)) % 3, axis=1)
        return TriangleMesh(merged, turned[np.lexsort(turned.T[::-1])])

    @cached_property
    def is_watertight(self) -> bool:
        """Whether each edge belongs to one triangle on either side, all with the same orientation."""
        if not len(self.triangles):
            return False
        a, b = np.concatenate([self.triangles[:, [0, 1]], self.triangles[:, [1, 2]], self.triangles[:, [2, 0]]]).T
        forth, back = a * len(self.points) + b, b * len(self.points) + a
        return len(distinct(forth)) == len(forth) and np.array_equal(np.sort(forth), np.sort(back))

    @cached_property
    def signed_volume(self) -> float:
        """The volume, m³: negative if the triangles are turned inside out. Meaningful for watertight meshes only."""
        middle = self.points.mean(axis=0)
        a, b, c = (self.points[self.triangles[:, k]] - middle for k in range(3))
        return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)

    @property
    def volume(self) -> float | None:
        """The volume, m³; None unless the mesh is watertight."""
        return abs(self.signed_volume) if self.is_watertight else None

    @cached_property
    def outward(self) -> TriangleMesh:
        """The same mesh with its triangles turned outwards; those of mirrored meshes point inwards."""
        return self if self.signed_volume >= 0 else TriangleMesh(self.points, self.triangles[:, ::-1])


def triangles_of_coal(shape: Any) -> TriangleMesh | None:
    """One of coal's meshes; None for other shapes."""
    found = corners_of_coal(shape)
    return None if found is None else TriangleMesh.of(*found)


def corners_of_coal(shape: Any) -> tuple[Floats, Ints64] | None:
    """Points (n, 3), m, and triangles (m, 3) of one of coal's meshes as coal has them; None for other shapes."""
    if not hasattr(shape, "tri_indices") or not hasattr(shape, "vertices"):
        return None
    corners = [(t[0], t[1], t[2]) for t in map(shape.tri_indices, range(shape.num_tris))]
    # One vertex alone comes as (3,).
    points = np.array(shape.vertices(), dtype=np.float64).reshape(-1, 3)
    return points, np.array(corners, dtype=np.int64).reshape(-1, 3)
