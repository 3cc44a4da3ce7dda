"""The cover of one link: spheres, capsules and boxes in the link's frame.

In: centres, ends, poses and sizes, m. Out: `Primitives`, and for points or cubes the value of each primitive: how far
it has to grow to hold the point, negative inside. For spheres and capsules this is the signed distance; for boxes, that
along the sides. Values are convex, so that a triangle lies in a primitive if and only if its corners do, and change by
hardly more than the distance of two points. Values in doubles are off by at most `error`; signs within it are decided
by fractions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import TypeAlias

import numpy as np

from plannercheck.bodies.integers import cross, dot
from plannercheck.common.array_types import Floats

Point: TypeAlias = tuple[Fraction, Fraction, Fraction]

# Some 60 roundings at most lie between the given numbers and a value, each by 2^-53 of the largest coordinate, length
# or radius; 2^-45 leaves room for four times as many.
_ROUNDING = 2.0**-45
# A value changes by at most this many times the distance of two points: poses of boxes are rigid up to 3.6e-6.
STEEPEST = 1 + 1e-5
# Values that are held at once.
_MOST_VALUES = 1 << 21


@dataclass(frozen=True, eq=False)
class Primitives:
    """Spheres, capsules and boxes in the frame of a link.

    Attributes:
        ends: (n, 2, 3) m, both ends of the segments of spheres and capsules; a sphere's are equal.
        radii: (n,) m.
        frames: (k, 4, 4) poses of boxes, m.
        halves: (k, 3) m, half the edge lengths of the boxes.
    """

    ends: Floats
    radii: Floats
    frames: Floats
    halves: Floats

    @classmethod
    def of(
        cls,
        spheres: Sequence[tuple[Sequence[float], float]] = (),
        capsules: Sequence[tuple[Sequence[float], Sequence[float], float]] = (),
        boxes: Sequence[tuple[Floats, Sequence[float]]] = (),
    ) -> Primitives:
        """Spheres (centre, radius), capsules (end, end, radius) and boxes (pose, full edge lengths)."""
        rounded = [(c, c, r) for c, r in spheres] + list(capsules)
        return cls(
            np.array([[a, b] for a, b, _ in rounded], dtype=np.float64).reshape(-1, 2, 3),
            np.array([r for *_, r in rounded], dtype=np.float64),
            np.array([pose for pose, _ in boxes], dtype=np.float64).reshape(-1, 4, 4),
            np.array([size for _, size in boxes], dtype=np.float64).reshape(-1, 3) / 2,
        )

    def __len__(self) -> int:
        return len(self.radii) + len(self.halves)

    def __add__(self, other: Primitives) -> Primitives:
        pairs = ((getattr(self, name), getattr(other, name)) for name in ("ends", "radii", "frames", "halves"))
        return Primitives(*(np.concatenate(pair) for pair in pairs))

    @cached_property
    def are_spheres(self) -> bool:
        """Whether all are spheres."""
        return not len(self.halves) and bool((self.ends[:, 0] == self.ends[:, 1]).all())

    def grown(self, growth: float) -> Primitives:
        """All radii larger, and all sides of boxes further out, by a growth in m, rounded up to numbers of 32 bits."""
        radii, halves = (upwards(each + growth) for each in (self.radii, self.halves))
        return replace(self, radii=radii, halves=halves) if growth else self

    def error(self, points: Floats) -> float:
        """The largest error of values at points (..., 3), m."""
        sizes = (points, self.ends, self.radii, self.frames[:, :3, 3], self.halves)
        return _ROUNDING * sum(float(np.abs(each).max(initial=0.0)) for each in sizes)

    def values(self, points: Floats) -> Floats:
        """(m, n) m: how far each primitive has to grow to hold points (m, 3)."""
        step = max(1, _MOST_VALUES // max(1, len(self)))
        parts = [self._values(points[i : i + step]) for i in range(0, len(points), step)]
        return np.concatenate(parts) if parts else np.zeros((0, len(self)))

    def values_of_cubes(self, middles: Floats, half: float) -> Floats:
        """(m, n) m: an upper bound of the values in cubes (m, 3) of half an edge length; of spheres, the largest."""
        step = max(1, _MOST_VALUES // max(1, len(self)))
        parts = [self._of_cubes(middles[i : i + step], half) for i in range(0, len(middles), step)]
        return np.concatenate(parts) if parts else np.zeros((0, len(self)))

    def _values(self, points: Floats) -> Floats:
        a, b = self.ends[:, 0], self.ends[:, 1]
        if (a == b).all():
            x, y, z = (points[:, k, None] - a[:, k] for k in range(3))
            beyond = np.sqrt(x * x + y * y + z * z)
        else:
            along, from_a = b - a, points[:, None] - a
            squares = np.maximum(np.einsum("ni,ni->n", along, along), np.finfo(float).tiny)
            shares = np.clip(np.einsum("mni,ni->mn", from_a, along) / squares, 0.0, 1.0)
            beyond = np.linalg.norm(from_a - shares[..., None] * along, axis=2)
        rounded = beyond - self.radii
        if not len(self.halves):
            return np.asarray(rounded)
        return np.concatenate([rounded, (np.abs(self._in_boxes(points)) - self.halves).max(axis=2)], axis=1)

    def _of_cubes(self, middles: Floats, half: float) -> Floats:
        if self.are_spheres:
            a = self.ends[:, 0]
            further = [np.abs(middles[:, k, None] - a[:, k]) + half for k in range(3)]
            x, y, z = further
            return np.asarray(np.sqrt(x * x + y * y + z * z) - self.radii, dtype=np.float64)
        return np.asarray(self._values(middles) + half * np.sqrt(3.0) * STEEPEST)

    def _in_boxes(self, points: Floats) -> Floats:
        """(m, k, 3) points in the frames of boxes."""
        inverse = np.linalg.inv(self.frames[:, :3, :3])
        found: Floats = np.einsum("kij,mkj->mki", inverse, points[:, None] - self.frames[:, :3, 3])
        return found

    def holds(self, index: int, point: Point, radius: float = 0.0) -> bool:
        """Whether a primitive holds the ball of a radius (of a box: 0) about an exact point, exactly."""
        if index >= len(self.radii):
            return self._box_holds(index - len(self.radii), point)
        a, b = ((Fraction(x), Fraction(y), Fraction(z)) for x, y, z in self.ends[index].tolist())
        left = Fraction(float(self.radii[index])) - Fraction(radius)
        return left >= 0 and square_from_segment(a, b, point) <= left**2

    def _box_holds(self, index: int, point: Point) -> bool:
        frame = [[Fraction(x) for x in row] for row in self.frames[index].tolist()]
        columns = [[frame[i][k] for i in range(3)] for k in range(3)]
        from_middle = [point[i] - frame[i][3] for i in range(3)]
        whole = dot(columns[0], cross(columns[1], columns[2]))
        for k, half in enumerate(self.halves[index].tolist()):
            across = cross(columns[(k + 1) % 3], columns[(k + 2) % 3])
            if abs(dot(from_middle, across)) > Fraction(half) * abs(whole):
                return False
        return True


def upwards(lengths: Floats) -> Floats:
    """Numbers of 32 bits that are larger than lengths, by at most two steps."""
    singles = np.nextafter(np.asarray(lengths, dtype=np.float32), np.float32(np.inf))
    return np.asarray(singles, dtype=np.float64)


def square_from_segment(a: Point, b: Point, point: Point) -> Fraction:
    """The squared distance of an exact point from a segment, exactly."""
    along, from_a = [y - x for x, y in zip(a, b, strict=True)], [y - x for x, y in zip(a, point, strict=True)]
    square = dot(along, along)
    share = min(max(dot(along, from_a) / square, Fraction(0)), Fraction(1)) if square else Fraction(0)
    apart = [x - share * y for x, y in zip(from_a, along, strict=True)]
    return dot(apart, apart)
