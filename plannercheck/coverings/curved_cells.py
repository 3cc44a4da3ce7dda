"""Cells of curved bodies: parts whose corners are known, and which stick out of the body by little.

In: a sphere, a cylinder or a capsule. Out: `Cells` that together hold it, each inside the hull of its corners; and
their halves. A cell sticks out by about its size squared over the radius, so that few cells come close to the body,
where cubes would stick out by their size.

Cells of balls are parts of the cones over spherical triangles, between two distances from the middle. With unit vectors
a, b, c whose plane is at distance d from the middle, all points of the cone at distance 1 lie between that plane and
the one through a/d, b/d, c/d. Cells of cylinders are parts between two angles, two heights and two distances from the
axis; an arc lies in the triangle of its ends and of the point where its tangents there meet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Protocol, TypeVar

import numpy as np

from plannercheck.common.array_types import Bools, Floats

# Cells are larger by this part, far more than their corners are off by rounding.
_OUTSET = 1 + 1e-12
# A cylinder's first cells: so many around the axis.
_AROUND = 6

Same = TypeVar("Same", bound="Cells")


class Cells(Protocol):
    """Parts of a body."""

    def __len__(self) -> int: ...

    def corners(self) -> Floats:
        """(m, k, 3) m: each part is in the hull of its corners."""

    def of_rows(self: Same, rows: Bools) -> Same:
        """Some of the parts."""

    def halved(self: Same) -> Same:
        """Each part cut in two or four across its longest direction."""


@dataclass(frozen=True, eq=False)
class BallCells:
    """Parts of a ball.

    Attributes:
        centre: (3,) m.
        radius: m.
        directions: (m, 3, 3) unit vectors, the corners of spherical triangles.
        shares: (m, 2) the least and greatest distance from the centre, as parts of the radius.
    """

    centre: Floats
    radius: float
    directions: Floats
    shares: Floats

    @classmethod
    def of(cls, centre: Floats, radius: float) -> BallCells:
        """The whole ball: the cones over the eight triangles of an octahedron."""
        directions = np.array([np.diag(signs) for signs in product((-1.0, 1.0), repeat=3)])
        return cls(centre, radius, directions, np.tile([0.0, 1.0], (8, 1)))

    def __len__(self) -> int:
        return len(self.shares)

    def corners(self) -> Floats:
        """See `Cells`."""
        a, b, c = (self.directions[:, k] for k in range(3))
        normals = np.cross(b - a, c - a)
        heights = np.abs(np.einsum("mi,mi->m", normals, a)) / np.linalg.norm(normals, axis=1)
        outer = self.shares[:, 1] * _OUTSET / heights
        scaled = np.concatenate(
            [self.shares[:, :1, None] / _OUTSET * self.directions, outer[:, None, None] * self.directions], axis=1
        )
        return np.asarray(self.centre + self.radius * scaled)

    def of_rows(self, rows: Bools) -> BallCells:
        """See `Cells`."""
        return replace(self, directions=self.directions[rows], shares=self.shares[rows])

    def halved(self) -> BallCells:
        """See `Cells`."""
        width = np.linalg.norm(self.directions - np.roll(self.directions, 1, axis=1), axis=2).max(axis=1)
        across = self.shares[:, 1] * width > self.shares[:, 1] - self.shares[:, 0]
        wide, deep = self.of_rows(across), self.of_rows(~across)
        a, b, c = (wide.directions[:, k] for k in range(3))
        ab, bc, ca = (_unit(u + v) for u, v in ((a, b), (b, c), (c, a)))
        quarters = [np.stack(each, axis=1) for each in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        directions = np.concatenate([*quarters, deep.directions, deep.directions])
        shares = np.concatenate([np.tile(wide.shares, (4, 1)), _halves(deep.shares)])
        return replace(self, directions=directions, shares=shares)


@dataclass(frozen=True, eq=False)
class CylinderCells:
    """Parts of a cylinder.

    Attributes:
        pose: (4, 4) of its middle, its axis along z, m; maps it as it is.
        radius: m.
        angles: (m, 2) rad.
        heights: (m, 2) m.
        shares: (m, 2) the least and greatest distance from the axis, as parts of the radius.
    """

    pose: Floats
    radius: float
    angles: Floats
    heights: Floats
    shares: Floats

    @classmethod
    def of(cls, pose: Floats, radius: float, half: float) -> CylinderCells:
        """The whole cylinder of half a length, m."""
        ends = np.linspace(0, 2 * np.pi, _AROUND + 1) * _OUTSET
        angles = np.column_stack([ends[:-1] - 1e-12, ends[1:]])
        return cls(pose, radius, angles, np.tile([-half, half], (_AROUND, 1)), np.tile([0.0, 1.0], (_AROUND, 1)))

    def __len__(self) -> int:
        return len(self.shares)

    def corners(self) -> Floats:
        """See `Cells`."""
        low, high = self.angles.T
        inner, outer = self.radius * self.shares[:, 0], self.radius * self.shares[:, 1] * _OUTSET
        flat = [
            (inner, low),
            (inner, high),
            (outer, low),
            (outer, high),
            (outer / np.cos((high - low) / 2), (low + high) / 2),
        ]
        points = [
            np.stack([length * np.cos(angle), length * np.sin(angle), height], axis=1)
            for length, angle in flat
            for height in self.heights.T * _OUTSET
        ]
        return np.asarray(np.stack(points, axis=1) @ self.pose[:3, :3].T + self.pose[:3, 3])

    def of_rows(self, rows: Bools) -> CylinderCells:
        """See `Cells`."""
        return replace(self, angles=self.angles[rows], heights=self.heights[rows], shares=self.shares[rows])

    def halved(self) -> CylinderCells:
        """See `Cells`."""
        extents = np.stack(
            [
                self.radius * self.shares[:, 1] * np.diff(self.angles)[:, 0],
                np.diff(self.heights)[:, 0],
                self.radius * np.diff(self.shares)[:, 0],
            ]
        )
        longest = extents.argmax(axis=0)
        parts = []
        for k, name in enumerate(("angles", "heights", "shares")):
            part = self.of_rows(longest == k)
            doubled = replace(
                part,
                angles=np.tile(part.angles, (2, 1)),
                heights=np.tile(part.heights, (2, 1)),
                shares=np.tile(part.shares, (2, 1)),
            )
            parts.append(replace(doubled, **{name: _halves(getattr(part, name))}))  # type: ignore[arg-type]
        return replace(
            self,
            angles=np.concatenate([part.angles for part in parts]),
            heights=np.concatenate([part.heights for part in parts]),
            shares=np.concatenate([part.shares for part in parts]),
        )


def capsule_cells(low: Floats, high: Floats, radius: float) -> Sequence[Cells]:
    """The cells of all points within a radius of a segment: two balls and the cylinder between, a little larger."""
    along = high - low
    length = float(np.linalg.norm(along))
    if not length:
        return [BallCells.of(low, radius)]
    axis = along / length
    across = _unit(np.cross(axis, np.eye(3)[np.abs(axis).argmin()]))
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([across, np.cross(axis, across), axis])
    pose[:3, 3] = (low + high) / 2
    return [BallCells.of(low, radius), BallCells.of(high, radius), CylinderCells.of(pose, radius, length / 2)]


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def _halves(ranges: Floats) -> Floats:
    """(2 m, 2) the lower halves of ranges (m, 2), then the upper ones."""
    middle = ranges.mean(axis=1)
    return np.concatenate([np.column_stack([ranges[:, 0], middle]), np.column_stack([middle, ranges[:, 1]])])
