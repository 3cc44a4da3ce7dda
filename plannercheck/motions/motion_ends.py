"""Motions as they are judged: two ends, with whole turns taken off so that angles turn the shorter way; or curves.

In: configurations, in space or in the plane. Out: `Motions` or `Curves`, and whether the given ends are free as well.
An angle less whole turns is another double, so the given end is posed with other roundings.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.checking.named_configurations import given_configurations
from plannercheck.checking.protocols import AnyChecker, AnyRobot
from plannercheck.common.angles import nearest_turns
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.errors import PlannercheckError

# Tubes up to this, rad and m, are within what `unreachable_pairs` leaves: a hundred-thousandth of all lengths.
NARROW = 1e-9


class Motions(NamedTuple):
    """Motions between configurations, rad and m.

    Attributes:
        starts: (n, nq).
        ends: (n, nq) the ends that the motions lead to; the same array as `given` if no whole turns were taken off.
        given: (n, nq) the ends as asked for.
    """

    starts: Floats
    ends: Floats
    given: Floats

    @property
    def points(self) -> Floats:
        """(n, 2, nq) starts and ends."""
        return np.stack([self.starts, self.ends], axis=1)

    @property
    def tubes(self) -> Floats:
        """Empty, (0, 0): these motions have no tubes."""
        return np.empty((0, 0))

    @property
    def need_all_pairs(self) -> bool:
        """False: motions within the limits need no pairs that limits rule out."""
        return False

    def ranges(self) -> tuple[Floats, Floats]:
        """The least and the largest (n, nq) of each number on each motion, the end as asked for included.

        Numbers change linearly, so the ends bound them. Numbers of unit vectors do not, but are at most 1.
        """
        least, largest = np.minimum(self.starts, self.ends), np.maximum(self.starts, self.ends)
        if self.given is self.ends:
            return least, largest
        return np.minimum(least, self.given), np.maximum(largest, self.given)


class Curves(NamedTuple):
    """Polynomials of one degree, rad and m, by their Bernstein coefficients.

    Attributes:
        points: (n, degree + 1, nq) control points.
        tubes: (n, nq + 1), or one for all, by how much each number may be off at every instant, and how far bodies have
            to stay apart, m; none if empty.
    """

    points: Floats
    tubes: Floats

    @property
    def need_all_pairs(self) -> bool:
        """Whether bodies of any have to stay apart, or a tube is so wide that pairs apart by limits count as well."""
        return bool(np.count_nonzero(self.tubes[:, -1:]) or np.count_nonzero(self.tubes > NARROW))

    def ranges(self) -> tuple[Floats, Floats]:
        """The least and the largest (n, nq) of each number on each curve, the tube included."""
        off = self.tubes[:, :-1] if len(self.tubes) else 0.0
        return self.points.min(axis=1) - off, self.points.max(axis=1) + off


def checked_ends(robot: AnyRobot, q0: ArrayLike, q1: ArrayLike) -> tuple[Floats, Floats]:
    """Starts and ends (n, nq) of motions of a robot, or an error."""
    starts, ends = given_configurations(robot, q0), given_configurations(robot, q1)
    if starts.shape != ends.shape:
        raise PlannercheckError(f"q0 and q1 must have the same shape, not {starts.shape} and {ends.shape}")
    return starts, ends


def shorter_turn(starts: Floats, ends: Floats, angles: NDArray[np.int64]) -> Floats:
    """Ends (…, nq) with some columns within half a turn of the starts'; the same array if they already are."""
    if not len(angles):
        return ends
    given = ends[..., angles]
    near = nearest_turns(starts[..., angles], given)
    if near is given:
        return ends
    out = ends.copy()
    out[..., angles] = near
    return out


def with_given_ends(checker: AnyChecker, free: Bools, motions: Motions) -> Bools:
    """Which motions (n,) are free: at their samples, as `free` says, and at their ends as they were asked for."""
    turned = free & (motions.given != motions.ends).any(axis=1)
    if turned.any():
        free[turned] = checker.check_states(motions.given[turned])
    return free
