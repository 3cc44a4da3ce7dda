"""A path of straight legs whose corners are rounded.

In: waypoints, and the length of each corner's blend. Out: `Section`s: curves by length of the path, from stop to stop.
A blend leaves its leg at the distance b before the corner and meets the next leg at b after it. It is the quintic
polynomial with the legs' positions and directions at both ends, and no curvature there, so that a section's first two
derivatives by the length are continuous. It lies in the triangle of its ends and the corner.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import OwnsArrays
from plannercheck.trajectories.curve import Curve

# Waypoints nearer to each other than this are one, and legs whose unit directions differ by less are one, rad and m.
SAME = 1e-9

# Part of a leg that the blend at its end may take: some of the leg is left.
_PART = 0.45

# The middle of a blend is at this part of b |u' - u| from its corner, with the legs' unit directions u and u'.
_MIDDLE = 6 / 32

# The middle of a blend of legs whose directions are opposite up to this has no direction: the path stops there.
_REVERSAL = 1e-3


@dataclass(frozen=True, eq=False)
class Legs(OwnsArrays):
    """Straight legs in a row, each of some length, with a corner between any two.

    Attributes:
        points: (k, nq) their ends.
        given: (k,) which waypoints of the path these are.
        lengths: (k - 1,) rad and m.
        directions: (k - 1, nq) of length 1.
    """

    points: Floats
    given: tuple[int, ...]
    lengths: Floats
    directions: Floats

    @classmethod
    def through(cls, waypoints: Floats) -> Legs:
        """The legs through waypoints (n, nq), less those that repeat or are on a straight line; n >= 1."""
        given = [0]
        for k in range(1, len(waypoints)):
            if np.linalg.norm(waypoints[k] - waypoints[given[-1]]) < SAME:
                continue
            while len(given) > 1 and _is_straight(waypoints[[given[-2], given[-1], k]]):
                given.pop()
            given.append(k)
        if len(given) > 1:
            given[-1] = len(waypoints) - 1  # the very last one, if those before are the same
        points = waypoints[given]
        ways = np.diff(points, axis=0)
        lengths = np.linalg.norm(ways, axis=1)
        return cls(points, tuple(given), lengths, ways / lengths[:, None])

    def blends(self, deviation: float) -> Floats:
        """(k,) lengths b of blends whose middle is at most so far from the corner, rad and m; 0 at both ends."""
        sizes = np.zeros(len(self.points))
        turns = np.linalg.norm(np.diff(self.directions, axis=0), axis=1)
        room = _PART * np.minimum(self.lengths[:-1], self.lengths[1:])
        sizes[1:-1] = np.where(turns < 2 - _REVERSAL, np.minimum(room, deviation / (_MIDDLE * turns)), 0.0)
        return sizes

    def blend(self, corner: int, size: float) -> Floats:
        """Control points (6, nq) of the blend at a corner."""
        before, after = self.directions[corner - 1 : corner + 1]
        steps = np.array([-1.0, -0.6, -0.2, 0.2, 0.6, 1.0])[:, None] * size
        return np.asarray(self.points[corner] + steps * np.where(steps < 0, before, after))


def _is_straight(three: Floats) -> bool:
    """Whether three points (3, nq) are on a line, in this order."""
    ways = np.diff(three, axis=0)
    u, v = ways / np.linalg.norm(ways, axis=1)[:, None]
    return bool(np.linalg.norm(v - u) < SAME)


@dataclass(frozen=True, eq=False)
class Section:
    """A path from stop to stop.

    Attributes:
        curve: By length of the path, rad and m.
        corners: For each piece of the curve the corner that it rounds, or None for what is left of a leg.
        legs: For each piece the leg that it leaves.
    """

    curve: Curve
    corners: tuple[int | None, ...]
    legs: tuple[int, ...]


def sections(legs: Legs, sizes: Floats) -> Iterator[Section]:
    """The path with blends (k,) at its corners, 0 where it stops."""
    pieces: list[Floats] = []
    corners: list[int | None] = []
    through: list[int] = []
    lengths = [0.0]
    for leg, length in enumerate(legs.lengths.tolist()):
        steps = np.array([[sizes[leg]], [length - sizes[leg + 1]]])
        ends = legs.points[leg] + steps * legs.directions[leg]
        if sizes[leg + 1] == 0:
            ends[1] = legs.points[leg + 1]
        pieces.append(ends)
        corners.append(None)
        through.append(leg)
        lengths.append(length - sizes[leg] - sizes[leg + 1])
        if sizes[leg + 1] > 0:
            pieces.append(legs.blend(leg + 1, sizes[leg + 1]))
            corners.append(leg + 1)
            through.append(leg)
            lengths.append(2 * sizes[leg + 1])
            continue
        yield Section(
            Curve(np.cumsum(lengths), tuple(pieces), np.zeros(pieces[0].shape[1])), tuple(corners), tuple(through)
        )
        pieces, corners, through, lengths = [], [], [], [0.0]
