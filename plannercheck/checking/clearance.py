"""Distances of a checker's pairs: the least ones, and tables of all that are near.

In: a checker's pairs, as they are compiled. Out: `MeasuringChecker` with `distances`, `clearances` and `nearest_pair`,
which rest on the same rows of the core (cpp/distances), without padding.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, Protocol, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.moving import checked_time
from plannercheck.checking.compiled_tables import CompiledTables
from plannercheck.checking.distances import CORNER_NUMBERS, Distances, Places
from plannercheck.checking.named_configurations import given_configurations
from plannercheck.checking.nearest_sets import NearestPlace
from plannercheck.checking.prepared_bodies import Preparation
from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.arrays import Configuration, named_numbers, shown_array
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module
from plannercheck.common.real_numbers import positive_number
from plannercheck.common.threads import checked_threads
from plannercheck.common.whole_numbers import whole_number
from plannercheck.robots.robot import Robot
from plannercheck.trajectories.joint_columns import check_order
from plannercheck.trajectories.trajectory import Trajectory

Same = TypeVar("Same", bound="MeasuringChecker")

# Steps of the descent for a lower bound of a distance.
_BOUND_ROUNDS = 2

# An earlier table: where the rows of each configuration begin (n + 1,), pairs (r,), corners (r, CORNER_NUMBERS).
Earlier: TypeAlias = tuple[Ints, Ints, Ints]
_NOTHING_EARLIER = np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros((0, CORNER_NUMBERS), np.int32)

# Configurations whose links Pinocchio poses at once.
_BLOCK = 1024


class Positions(Protocol):
    """A trajectory."""

    def position(self, time: ArrayLike) -> Floats:
        """Configurations (n, nq) at times (n,), s."""


def _checked_limit(limit: Any) -> float:
    """A limit as a float, or an error that names it."""
    is_infinite = isinstance(limit, float | np.floating) and limit == math.inf
    return math.inf if is_infinite else positive_number(limit, "limit must be positive, in m")


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
    _labels: tuple[str, ...]
    _preparation: Preparation
    _tables: CompiledTables
    _kernel: core.Kinematics | None

    @abstractmethod
    def body_poses(self, q: ArrayLike) -> Floats:
        """World poses of all bodies (n, bodies, 4, 4), m."""

    @abstractmethod
    def _link_poses(self, rows: Floats) -> Floats:
        """World poses of all links (n, links, 4, 4), m, at checked configurations."""

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

    def distances(
        self,
        q: ArrayLike,
        limit: float = 0.1,
        nearest: int | None = None,
        gradients: bool = True,
        threads: int = 1,
        *,
        times: ArrayLike | None = None,
        start: Distances | None = None,
    ) -> Distances:
        """Distances of the pairs that are near, with nearest points and gradients.

        Args:
            q: (n, nq) rad and m.
            limit: Pairs that are further apart are left out, m; infinite for all pairs. A new limit is prepared once.
            nearest: So many pairs of each configuration, the nearest ones, in place of those within the limit.
            gradients: Whether to give gradients.
            threads: How many threads measure.
            times: As of `check_states`; gradients are by the robot's own configuration, at a standing clock.
            start: This checker's table of configurations near these, row by row, as of an optimiser's last step. Two
                hulls are searched from their nearest vertices there on: faster, and bounds hold as ever; the last
                digits, or which of several nearest points is given, may change.

        Returns:
            A table; the same rows whatever the threads and the other configurations.

        Raises:
            PlannercheckError: If the limit is not positive, `nearest` is below 1, gradients are asked for or `start` is
                given where Pinocchio poses the links, or `start` is of other configurations.
        """
        limit = _checked_limit(limit)
        most = 0 if nearest is None else whole_number(nearest, "nearest must be a number of pairs, 1 or more")
        if gradients and self._kernel is None:
            raise PlannercheckError(
                "gradients need the compiled kinematics, and Pinocchio poses this robot's links: "
                "ask for distances(..., gradients=False)"
            )
        checker, rows = self.in_time(given_configurations(self.robot, q), times)
        own = self.robot.configuration_map.tangent_places if gradients else None
        most = min(most, max(len(self.pairs), 1))
        earlier = checker._earlier(start, len(rows))
        return checker._measured(rows, limit, most, own, checked_threads(threads, len(rows)), earlier)

    def distance_function(
        self, limit: float = 0.1, *, time: float | None = None
    ) -> Callable[[ArrayLike], tuple[Floats, Floats]]:
        """A function of one configuration for optimisers, which take as many numbers at every configuration.

        Args:
            limit: Distances beyond it count as the limit, and don't change, m.
            time: As `times` of `distances`.

        Returns:
            f(q) with q (nq,): distances (k,), m, of the k rows of `pairs`, at most the limit; and their derivatives (k,
            nv), see `Distances.gradient`; 0 beyond the limit.
        """
        count = len(self.pairs)
        limit = _checked_limit(limit)
        if math.isinf(limit):
            raise PlannercheckError(f"limit must be finite, in m, not {limit!r}")

        def values(q: ArrayLike) -> tuple[Floats, Floats]:
            table = self.distances(self._single(q), limit, times=time)
            distance, jacobian = np.full(count, limit), np.zeros((count, table.gradient.shape[1]))
            distance[table.pair], jacobian[table.pair] = table.distance, table.gradient
            return distance, jacobian

        return values

    def _clearances(self, rows: Floats, lower_bound: bool) -> tuple[Floats, Ints]:
        if not len(self.pairs):
            return np.full(len(rows), np.inf), np.full(len(rows), -1, dtype=np.int32)
        _, pairs, found, *_ = self._rows(self.robot.check_configurations(rows), math.inf, 1, None, 1, lower_bound)
        return found, pairs

    def _earlier(self, start: Distances | None, rows: int) -> Earlier:
        """Where the rows of each configuration lie in an earlier table, their pairs and corners."""
        if start is None:
            return _NOTHING_EARLIER
        if self._kernel is None:
            raise PlannercheckError(
                "start needs the compiled kinematics, and Pinocchio poses this robot's links: leave it out"
            )
        known = isinstance(start, Distances) and start._is_of(self.pairs, self._labels)
        if not known or start.state.max(initial=-1) >= rows:
            raise PlannercheckError(
                f"start must be this checker's table of {rows} configurations near these, not {start!r:.80}"
            )
        return np.searchsorted(start.state, np.arange(rows + 1)).astype(np.int32), start.pair, start._corners

    def _measured(
        self, rows: Floats, limit: float, nearest: int, own: Ints | None, threads: int, earlier: Earlier
    ) -> Distances:
        """A table of configurations of this checker; `own`: the places of the first columns' gradients."""
        rows = self.robot.check_configurations(rows)
        places = None if own is None else self.robot.configuration_map.tangent_places
        found = self._rows(rows, limit, nearest, places, threads, earlier=earlier)
        state, pair, distance, lower, points, normal, gap, unique, gradient, corners = found
        width = 0 if own is None else int(own.max(initial=-1)) + 1
        nearest_places = self._places(rows, state, pair, width, limit) if width else None
        tables = gap, unique.view(bool), np.ascontiguousarray(gradient[:, :width])
        made_by = self.pairs, self._labels
        return Distances(state, pair, distance, lower, points, normal, *tables, corners, nearest_places, made_by)

    def _rows(
        self,
        rows: Floats,
        limit: float,
        nearest: int,
        places: Ints | None,
        threads: int,
        lower_bound: bool = False,
        earlier: Earlier = _NOTHING_EARLIER,
    ) -> Any:
        """The core's columns of a table."""
        measure, rounds = self._tables.all.distances(limit), _BOUND_ROUNDS if lower_bound else 0
        if self._kernel is not None:
            return measure.of_states(self._kernel, places, rows, nearest, rounds, threads, *earlier)
        blocks = [
            measure.of_poses(self._link_poses(rows[first : first + _BLOCK]), nearest, rounds, threads)
            for first in range(0, max(len(rows), 1), _BLOCK)
        ]
        for k, block in enumerate(blocks):
            block[0][:] += k * _BLOCK
        return tuple(np.concatenate(columns) for columns in zip(*blocks, strict=True))

    def _places(self, rows: Floats, state: Any, pair: Ints, width: int, limit: float) -> Places:
        """The places where the bodies of a row are nearest, and gradients at points of the first one."""

        def of_row(k: int) -> tuple[list[NearestPlace], Callable[[Floats, Floats], Floats]]:
            q, own, kernel = rows[state[k]], int(pair[k]), self._kernel
            places, measure = self.robot.configuration_map.tangent_places, self._tables.all.distances(limit)
            assert kernel is not None  # or there are no gradients

            def gradients_at(points: Floats, normal: Floats) -> Floats:
                return np.asarray(measure.gradients_at(kernel, places, q, own, normal, points))[:, :width]

            return [NearestPlace(*place) for place in measure.nearest_places(kernel, q, own)], gradients_at

        return of_row


@set_module("plannercheck")
def distances_along(
    checker: MeasuringChecker, trajectory: Positions, at: ArrayLike, limit: float = 0.1, *, start_time: float = 0.0
) -> Distances:
    """`distances` at instants of a trajectory.

    Args:
        checker: The checker.
        trajectory: A `Trajectory`.
        at: (n,) instants, s.
        limit: As of `distances`.
        start_time: The scene's time at which the trajectory starts, s, where the scene moves.

    Returns:
        A table whose `state` is the row of `at`.

    Raises:
        PlannercheckError: As `distances`, or if instants are no numbers.
    """
    if not callable(getattr(trajectory, "position", None)):
        raise PlannercheckError(f"distances_along takes a pc.Trajectory, not {trajectory!r:.80}")
    if isinstance(trajectory, Trajectory):
        check_order(checker.robot, trajectory.points)
    instants = named_numbers(at, "at")
    if instants.ndim != 1:
        raise PlannercheckError(f"at must be instants (n,), s, not {shown_array(at)}")
    return checker.distances(
        trajectory.position(instants), limit, times=instants + checked_time(start_time, "start_time")
    )
