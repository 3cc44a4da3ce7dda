"""Proofs by lever arms about a robot's bodies without a scene: computed once a robot, for all its checkers.

In: a robot, its bodies' hulls. Out: `RobotReach`. It knows which of the robot's own pairs never meet within the limits,
and has the cells of joint space with the places of each body in them, compiled, so that an obstacle takes microseconds.
The proofs are the proofs of unreachable_pairs.py, with whose functions tests compare this module.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import GeometryObject, InflatedHull
from plannercheck.checking.apart_cells import PairsInCells, pairs_in_cells
from plannercheck.checking.reach_bounds import Boxes, Chains
from plannercheck.checking.unreachable_pairs import MARGIN, RELATIVE, apart_among_links, sizes_of
from plannercheck.common.array_types import Bools, Floats, Ints
from plannercheck.common.arrays import read_only
from plannercheck.common.core import core
from plannercheck.robots.kinematics import JointTable
from plannercheck.robots.robot import Robot


class RobotReach:
    """Proofs about the bodies on a robot's links. Immutable but for results that are kept; threads may share it."""

    def __init__(
        self,
        robot: Robot,
        table: JointTable,
        bodies: Sequence[GeometryObject],
        hulls: Sequence[InflatedHull],
        carrier: RobotReach | None = None,
    ) -> None:
        """Measures the chains.

        Args:
            robot: The robot, which the compiled kinematics poses.
            table: Its joint table.
            bodies: All bodies on its links, what they carry last.
            hulls: The hulls of these bodies.
            carrier: The reach of the robot without what it carries; its results are taken over.
        """
        self._chains = Chains(robot, table, bodies, hulls)
        self._carrier = carrier
        if carrier is not None:
            self._chains.inherit(carrier._chains)
        self._known: dict[bytes, tuple[Bools, Bools]] = {}
        self._cells_of: dict[bytes, tuple[PairsInCells, ...]] = {}

    @cached_property
    def is_proved(self) -> bool:
        """Whether the margins cover all rounding within the limits; if not, no pair counts as apart."""
        return self._chains.is_proved()

    @cached_property
    def at_rest(self) -> Bools:
        """(bodies,) which bodies no joint of the group moves."""
        return read_only(np.array([not self._chains.chain(b) for b in range(self._chains.count)], dtype=bool))

    def own_pairs(self, pairs: Ints) -> tuple[Bools, Bools]:
        """Which pairs (k, 2) of these bodies never meet within the limits, and which no joint moves; kept."""
        key = pairs.astype(np.int64).tobytes()
        if key not in self._known:
            static = self._chains.screen.static(pairs.astype(np.int64))
            self._known[key] = read_only(self._apart(pairs)), read_only(static)
        return self._known[key]

    def _apart(self, pairs: Ints) -> Bools:
        if not self.is_proved:
            return np.zeros(len(pairs), dtype=bool)
        if self._carrier is None:
            return apart_among_links(self._chains, pairs)
        apart = np.zeros(len(pairs), dtype=bool)
        is_new = (pairs >= self._carrier._chains.count).any(axis=1)
        apart[is_new] = apart_among_links(self._chains, pairs[is_new])
        apart[~is_new] = self._carrier.own_pairs(pairs[~is_new])[0]
        return apart

    def in_cells(
        self, pairs: Ints, polytopes: Callable[[int], Polytope], sampled: Callable[[], Floats]
    ) -> tuple[PairsInCells, ...]:
        """Cells in which pairs (k, 2) of these bodies are apart, see `pairs_in_cells`; kept. Carried ones have none."""
        key = pairs.tobytes()
        if key not in self._cells_of:
            self._cells_of[key] = self._find_cells(pairs, polytopes, sampled)
        return self._cells_of[key]

    def _find_cells(
        self, pairs: Ints, polytopes: Callable[[int], Polytope], sampled: Callable[[], Floats]
    ) -> tuple[PairsInCells, ...]:
        if self._carrier is not None:
            return self._carrier.in_cells(pairs, polytopes, sampled)
        own = self._chains.count
        # Bodies at rest are obstacles in the core, and obstacles have no cells.
        rows = np.flatnonzero((pairs < own).all(axis=1) & ~self.at_rest[np.minimum(pairs, own - 1)].any(axis=1))
        if not self.is_proved or not len(rows):
            return ()
        found = pairs_in_cells(self._chains, pairs[rows], polytopes, sampled)
        return tuple(each.of(rows) for each in found)

    @property
    def carrier_count(self) -> int:
        """How many of the bodies are the robot's own, if it carries something; else 0."""
        return 0 if self._carrier is None else self._carrier._chains.count

    def shared_with(self, other: RobotReach | None) -> int:
        """For how many of the first bodies both agree; the robots may carry different objects."""
        mine, others = (self, self._carrier), () if other is None else (other, other._carrier)
        return next((one._chains.count for one in mine if one is not None and one in others), 0)

    def clear_of(self, boxes: Boxes, poses: Floats, first: int = 0) -> Bools:
        """Which bodies, from the first on (0 or `carrier_count`), never meet which of n obstacles: (bodies, n).

        Obstacles are boxes at poses (n, 4, 4) in the world, m.
        """
        if not self.is_proved:
            return np.zeros((self._chains.count - first, len(poses)), dtype=bool)
        sizes = sizes_of(boxes, poses)
        corners = np.ascontiguousarray(boxes.low), np.ascontiguousarray(boxes.high)
        clear = self._cells.clear_of(poses, *corners, np.ascontiguousarray(boxes.inflation_radius), sizes)
        mine = np.asarray(clear).view(bool)
        if self._carrier is None or first:
            return mine
        return np.concatenate([self._carrier.clear_of(boxes, poses), mine])

    @cached_property
    def _cells(self) -> Any:
        """The cells of all cuts of the bodies that the carrier does not have, compiled.

        Bodies beyond one joint share their centres.
        """
        chains = self._chains
        numbers: dict[int, int] = {}
        sets: list[Floats] = []
        rows: list[tuple[int, float, float]] = []
        first_cut = [0]
        for body in range(self.carrier_count, chains.count):
            chain = chains.chain(body)
            columns = chains.columns(chain)
            for count in range(len(columns) + 1):
                cut = tuple(columns[:count])
                end = chains.end(body, chain, cut)
                centres, sway = chains.centres_in_cells(body, chain, cut)
                if id(centres) not in numbers:
                    numbers[id(centres)] = len(sets)
                    sets.append(centres)
                extent = end.radius + sway + float(np.linalg.norm(centres, axis=1).max())
                rows.append((numbers[id(centres)], end.radius + sway, extent))
            first_cut.append(len(rows))
        of_cut, radii, extents = zip(*rows, strict=True) if rows else ((), (), ())
        return core.reach_cells(
            np.ascontiguousarray(np.concatenate([np.zeros((0, 3)), *sets])),
            np.cumsum([0, *map(len, sets)]).astype(np.int64),
            np.array(of_cut, dtype=np.int64),
            np.array(radii, dtype=np.float64),
            np.array(extents, dtype=np.float64),
            np.array(first_cut, dtype=np.int64),
            MARGIN,
            RELATIVE,
        )


def reach_of(
    robot: Robot,
    bodies: tuple[GeometryObject, ...],
    hulls: Callable[[int], Sequence[InflatedHull]],
    paddings: Floats,
    excess: float,
) -> RobotReach | None:
    """The proofs about a robot's bodies, computed when a checker of it first asks.

    Args:
        robot: The robot.
        bodies: The bodies on its links, or stand-ins for them.
        hulls: A function that gives the hulls of the first so many bodies; called only if something is computed.
        paddings: (bodies,) the part of each inflation radius that is padding, m.
        excess: How far polytopes of curved shapes stick out, as a part of the radius.

    Returns:
        The proofs; None if Pinocchio itself poses the robot.
    """
    table = robot.joint_table
    if table is None or robot.kinematics is None:
        return None

    def compute() -> RobotReach:
        own = sum(body.carried is None for body in bodies)
        carrier = None
        if own < len(bodies):
            carrier = reach_of(robot.carrying(()), bodies[:own], hulls, paddings[:own], excess)
        return RobotReach(robot, table, bodies, hulls(len(bodies)), carrier)

    return robot.remembered(("reach", bodies, paddings.tobytes(), excess), compute)
