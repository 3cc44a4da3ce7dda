"""Curves of configurations in time: polynomials, one after the other.

In: breaks and control points. Out: `Curve`, which gives positions, velocities and accelerations.

Each piece is given by its Bernstein coefficients, its *control points*: the piece lies in their hull, their differences
are the derivative's control points up to a factor, and a piece of degree 1 is a straight line at constant speed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import OwnsArrays, named_numbers, read_only
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.configurations import LARGEST_VALUE

# s: 1 ns, less the rounding of late times.
_SHORTEST = 0.9e-9

# Highest degree of a piece.
MOST_DEGREE = 20

# Times a sum of two lengths, it is at least what the sum is without rounding.
ROUNDED_UP = 1 + 2.0**-52


@dataclass(frozen=True, eq=False)
class Curve(OwnsArrays):
    """Polynomials in a row.

    Attributes:
        breaks: (m + 1,) s, growing: piece k runs from breaks[k] to breaks[k + 1].
        pieces: (degree + 1, nq) each, the control points, rad and m.
        error: (nq,) how far the pieces, and the controller's own evaluation in doubles, are at most from the
            polynomials that the numbers given define, rad and m (rounding.py). Of "ur" the pieces alone: the driver
            sends whole millionths, and the robot adds up speeds. MotoROS2 commands whole pulses.
        units: (first, past) of columns that form a unit vector: cosine and sine, or a quaternion. They turn from the
            first control point of a piece to its last by slerp, the short way.
    """

    breaks: Floats
    pieces: tuple[Floats, ...]
    error: Floats
    units: tuple[tuple[int, int], ...] = ()

    @property
    def nq(self) -> int:
        """Numbers of a configuration."""
        return int(self.pieces[0].shape[1])

    @cached_property
    def counts(self) -> NDArray[np.int64]:
        """(m,) how many control points each piece has."""
        return read_only(np.array([len(piece) for piece in self.pieces]))

    @cached_property
    def by_count(self) -> dict[int, tuple[NDArray[np.int64], Floats]]:
        """The pieces by the count of their control points: their numbers (m,), and (m, degree + 1, nq)."""
        numbers = {count: np.flatnonzero(self.counts == count) for count in sorted(set(self.counts.tolist()))}
        return {
            count: (read_only(some), read_only(np.array([self.pieces[k] for k in some.tolist()])))
            for count, some in numbers.items()
        }

    def points_of(self, piece: NDArray[np.int64]) -> Iterator[tuple[NDArray[np.int64], Floats]]:
        """Of pieces (n,), by the count of their control points: which these are (k,), and (k, degree + 1, nq)."""
        if len(self.by_count) == 1:
            yield np.arange(len(piece)), self.by_count[self.counts[0]][1][piece]
            return
        counts = self.counts[piece]
        for count, (numbers, points) in self.by_count.items():
            rows = (counts == count).nonzero()[0]
            if len(rows):
                yield rows, points[numbers.searchsorted(piece[rows])]

    @cached_property
    def own_tube(self) -> Floats:
        """(1, nq + 1) the tube of the curve's own error, and 0 m that bodies stay apart."""
        return read_only(np.append(self.error * ROUNDED_UP, 0.0)[None])

    @cached_property
    def ends(self) -> Floats:
        """(m, 2, nq) the first and the last control point of each piece."""
        return read_only(np.array([piece[[0, -1]] for piece in self.pieces]))

    def at(self, times: ArrayLike, derivative: int = 0) -> Floats:
        """Positions, or derivatives by time.

        Args:
            times: (n,) or a number, s, from the first break to the last. At a break the later piece counts.
            derivative: 0 for positions, 1 for velocities, 2 for accelerations.

        Returns:
            (n, nq), or (nq,) for a number; rad and m, by s.

        Raises:
            PlannercheckError: If a time is not a number, or is before the first break or after the last.
        """
        asked = np.atleast_1d(named_numbers(times, "times"))
        outside = ~((asked >= self.breaks[0]) & (asked <= self.breaks[-1]))  # NaN as well
        if outside.any():
            raise PlannercheckError(
                f"times must be within {self.breaks[0]} and {self.breaks[-1]} s, not {asked[outside][0]}"
            )
        piece = np.searchsorted(self.breaks[1:-1], asked, side="right")
        start, end = self.breaks[piece], self.breaks[piece + 1]
        s = ((asked - start) / (end - start))[:, None]
        found = np.empty((len(asked), self.nq))
        for rows, points in self.points_of(piece):
            control = differentiated(points, (end - start)[rows, None, None], derivative)
            found[rows] = _de_casteljau(control, s[rows])
        for first, past in self.units:
            a, b = np.moveaxis(self.ends[piece, :, first:past], 1, 0)
            found[:, first:past] = slerp(a, b, s, derivative) / (end - start)[:, None] ** derivative
        return found[0] if np.ndim(times) == 0 else found


def slerp(start: Floats, end: Floats, s: Floats, derivative: int) -> Floats:
    """Unit vectors (n, 2) or (n, 4) on the way from one to another at s (n, 1) from 0 to 1, or derivatives by s."""
    a, b = start / _length(start), end / _length(end)
    cosine = (a * b).sum(axis=1, keepdims=True)
    if a.shape[1] == 4:  # quaternions of both signs turn alike
        b, cosine = np.where(cosine < 0, -b, b), np.abs(cosine)
    across = b - cosine * a
    length = _length(across)
    angle = np.arctan2(length, cosine)
    phase = angle * s + derivative * np.pi / 2
    sideways = across / np.where(length > 0, length, 1.0)
    return np.asarray(angle**derivative * (np.cos(phase) * a + np.sin(phase) * sideways))


def _length(vectors: Floats) -> Floats:
    """(n, 1) of vectors (n, k)."""
    return np.asarray(np.sqrt((vectors * vectors).sum(axis=1, keepdims=True)))


def check_curve(curve: Curve) -> None:
    """Raises for a curve that is none of a robot: pieces of another degree or size, or that do not meet."""
    check_size(curve.breaks, curve.pieces)
    for k, piece in enumerate(curve.pieces):
        if not 2 <= len(piece) <= MOST_DEGREE + 1:
            raise PlannercheckError(f"piece {k} must have 2 to {MOST_DEGREE + 1} control points, not {len(piece)}")
        if k > 0 and (curve.pieces[k - 1][-1] != piece[0]).any():
            raise PlannercheckError(f"pieces {k - 1} and {k} do not meet: no robot can jump")


def check_size(breaks: Floats, pieces: Sequence[Floats]) -> None:
    """Raises for pieces that are shorter than any message has them, or larger than any robot."""
    if not (np.diff(breaks) >= _SHORTEST).all():
        k = int(np.argmin(np.diff(breaks) >= _SHORTEST))
        raise PlannercheckError(f"piece {k} takes {breaks[k + 1] - breaks[k]:.3g} s, less than 1 ns")
    for k, piece in enumerate(pieces):
        if not (np.abs(piece) <= LARGEST_VALUE).all():
            raise PlannercheckError(f"piece {k} has control points beyond {LARGEST_VALUE:g}")


def differentiated(control: Floats, duration: ArrayLike, times: int = 1) -> Floats:
    """Control points (…, degree + 1, nq) of a derivative by time, one fewer each time, but at least one."""
    for _ in range(times):
        degree = control.shape[-2] - 1
        control = np.diff(control, axis=-2) * (degree / duration) if degree else np.zeros_like(control)
    return control


def bernstein(powers: Floats) -> Floats:
    """Control points (degree + 1, nq) of polynomials in s from 0 to 1, by their coefficients of 1, s, s² and so on."""
    # Summed as s → the polynomial about 0: b[j] = sum over i of C(j, i) / C(degree, i) * powers[i].
    degree = len(powers) - 1
    control = np.zeros_like(powers)
    ratios = np.ones(degree + 1)
    for i in range(degree + 1):
        control += ratios[:, None] * powers[i]
        ratios *= (np.arange(degree + 1) - i) / max(degree - i, 1)
    return control


def _de_casteljau(points: Floats, s: Floats) -> Floats:
    """Values (n, nq) of polynomials by control points (n, degree + 1, nq), at parameters s (n, 1) from 0 to 1."""
    s = s[:, None]
    while points.shape[1] > 1:
        points = points[:, :-1] * (1 - s) + points[:, 1:] * s
    return np.asarray(points[:, 0])
