"""Clearances: the least distance of all pairs of bodies.

In: a checker's pairs, prepared bodies and their poses. Out: `MeasuringChecker` with `clearance`, `clearances` and
`nearest_pair`. Distances are the core's (cpp/narrow_phase/distance), whatever the padding.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.checking.named_configurations import given_configurations
from plannercheck.checking.prepared_bodies import Preparation
from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.arrays import Configuration, distinct
from plannercheck.common.core import core
from plannercheck.robots.robot import Robot

Same = TypeVar("Same", bound="MeasuringChecker")

# Steps of the descent for a lower bound of a distance.
_BOUND_ROUNDS = 2

# Configurations whose poses are held at once.
_BLOCK = 1024


class MeasuringChecker(ABC):
    """A checker that measures the distances of its pairs.

    Attributes:
        robot: The robot.
        pairs: (k, 2) indices of bodies.
        paddings: (bodies,) each body's part of the padding, m.
    """

    robot: Robot
    pairs: Ints
    paddings: Floats
    _preparation: Preparation

    @abstractmethod
    def body_poses(self, q: ArrayLike) -> Floats:
        """World poses of all bodies (n, bodies, 4, 4), m."""

    @abstractmethod
    def _single(self, q: Configuration) -> Floats:
        """One configuration (nq,) as a row (1, nq)."""

    @abstractmethod
    def in_time(self: Same, q: Floats, times: ArrayLike | None) -> tuple[Same, Floats]:
        """The checker of configurations (n, nq) at times, and its rows."""

    def clearance(self, q: Configuration, lower_bound: bool = False, *, time: float | None = None) -> float:
        """The least distance of all pairs, whatever the padding.

        Args:
            q: (nq,) rad and m.
            lower_bound: Whether a proved lower bound is enough; it is cheaper.
            time: As `times` of `check_states`.

        Returns:
            m, within 1e-9 of max(distance, 1e-3 of the bodies' radius). Where bodies overlap, it is the negative of a
            depth: a translation of that length separates them, and a shorter one may do so as well (see
            `bodies.distance.Distance`). Infinite if there are no pairs.
        """
        return float(self.clearances(self._single(q), lower_bound, times=time)[0])

    def clearances(self, q: ArrayLike, lower_bound: bool = False, *, times: ArrayLike | None = None) -> Floats:
        """`clearance` of a set of configurations.

        Args:
            q: (n, nq) rad and m.
            lower_bound: As for `clearance`.
            times: As of `check_states`.

        Returns:
            (n,), m.
        """
        checker, rows = self.in_time(given_configurations(self.robot, q), times)
        return checker._clearances(rows, lower_bound)[0]

    def nearest_pair(self, q: ArrayLike, *, times: ArrayLike | None = None) -> Ints:
        """The nearest pair of each configuration, or the one that overlaps most deeply.

        Args:
            q: (n, nq) rad and m.
            times: As of `check_states`.

        Returns:
            (n,) rows of `pairs`; -1 if the checker has no pairs.
        """
        checker, rows = self.in_time(given_configurations(self.robot, q), times)
        return checker._clearances(rows, False)[1]

    def _clearances(self, rows: Floats, lower_bound: bool) -> tuple[Floats, Ints]:
        if not len(self.pairs):
            return np.full(len(rows), np.inf), np.full(len(rows), -1, dtype=np.int32)
        used = distinct(self.pairs)
        table = np.searchsorted(used, self.pairs).astype(np.int32)
        polytopes = [self._preparation.polytope(k) for k in used.tolist()]
        bodies = [polytope.core for polytope in polytopes]
        rounds = _BOUND_ROUNDS if lower_bound else 0
        distances, nearest = np.empty(len(rows)), np.empty(len(rows), dtype=np.int32)
        for first in range(0, len(rows), _BLOCK):
            block = slice(first, first + _BLOCK)
            poses = np.ascontiguousarray(self.body_poses(rows[block])[:, used])
            distances[block], nearest[block] = core.clearances(bodies, poses, table, self.paddings[used], rounds)
        return distances, nearest
