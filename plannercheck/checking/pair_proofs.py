"""Proofs about a checker's pairs: which pairs never meet within the limits, and which are static.

In: a robot, bodies, their preparation, and the proofs of an earlier checker. Out: `MeetingProofs`. Proofs about the
robot alone are made once a robot (robot_reach.py). A proof about an obstacle holds as long as neither the obstacle nor
the robot changes; a moved obstacle is a new `GeometryObject`, so a changed scene needs proofs only for obstacles that
were moved or added. If pairs have their own paddings, copies of bodies follow the obstacles; then unreachable_pairs.py
proves all pairs.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.shapes import GeometryObject
from plannercheck.checking.apart_cells import PairsInCells
from plannercheck.checking.prepared_bodies import Preparation
from plannercheck.checking.robot_reach import RobotReach, reach_of
from plannercheck.checking.unreachable_pairs import UnreachablePairs, stays_apart, unreachable_pairs
from plannercheck.common.array_types import Bools, Floats, Ints
from plannercheck.robots.robot import Robot

_Side = tuple[GeometryObject, float]  # an obstacle and its padding, m

# What is known of a body and an obstacle.
_MAY_MEET, _APART, _MEET_AT_REST = 0, 1, 2


class MeetingProofs:
    """Proofs about pairs of bodies."""

    def __init__(
        self,
        robot: Robot,
        bodies: Sequence[GeometryObject],
        preparation: Preparation,
        is_compiled: bool,
        earlier: MeetingProofs | None = None,
    ) -> None:
        """Starts with what is known of the robot, and with what an earlier checker has proved.

        Args:
            robot: The robot.
            bodies: Its bodies, then the obstacles, then copies of them with another padding.
            preparation: The prepared polytopes of these bodies.
            is_compiled: Whether the compiled kinematics poses the robot; nothing is proved for other kinematics.
            earlier: The proofs of a checker of the same settings.
        """
        self._robot, self._bodies, self._preparation, self._is_compiled = robot, bodies, preparation, is_compiled
        self._own = len(robot.bodies)
        self._has_copies = any(body.link is not None for body in bodies[self._own :])
        self._reach: RobotReach | None = None
        self._facts: NDArray[np.uint8] = np.zeros((self._own, 0), dtype=np.uint8)  # of bodies and obstacles
        if not self._has_copies:
            self._find_reach()
            self._find_facts(earlier)

    def _find_reach(self) -> None:
        own, preparation = self._own, self._preparation
        self._reach = reach_of(
            self._robot,
            tuple(self._bodies[:own]),
            preparation.hulls,
            preparation.paddings[:own],
            preparation.excess,
        )

    def _find_facts(self, earlier: MeetingProofs | None) -> None:
        """What is known of the obstacles: by the earlier checker, and by cells for those that it did not have."""
        own = self._own
        count = len(self._bodies) - own
        self._facts = np.zeros((own, count), dtype=np.uint8)
        if self._reach is None or not self._is_compiled:
            return
        shared = 0 if earlier is None else self._reach.shared_with(earlier._reach)
        places = np.full(count, -1, dtype=np.int64)
        if earlier is not None and shared:
            columns = earlier._columns
            places = np.array([columns.get(side, -1) for side in self._sides()], dtype=np.int64)
            known = np.flatnonzero(places >= 0)
            self._facts[:shared, known] = earlier._facts[:shared, places[known]]
            if shared < own:  # nothing is known about what the robot carries
                self._look(known, shared)
        self._look(np.flatnonzero(places < 0))

    def _look(self, obstacles: NDArray[np.int64], first: int = 0) -> None:
        """Finds by cells what is known of some obstacles (n,) and the bodies from `first` on."""
        if not len(obstacles):
            return
        assert self._reach is not None
        numbers = (obstacles + self._own).tolist()
        poses = np.concatenate([self._bodies[k].pose for k in numbers]).reshape(-1, 4, 4)
        self._facts[first:, obstacles] = self._reach.clear_of(self._preparation.boxes(numbers), poses, first)

    def _sides(self) -> Iterable[_Side]:
        own = self._own
        return zip(self._bodies[own:], self._preparation.paddings[own:].tolist(), strict=True)

    @cached_property
    def _columns(self) -> dict[_Side, int]:
        """The column of each obstacle in the facts; only a later checker asks."""
        return {side: k for k, side in enumerate(self._sides())}

    def of(self, pairs: Ints) -> tuple[Bools, Bools]:
        """Which pairs (k, 2) never meet within the limits, and which are at rest relative to each other."""
        if self._has_copies:
            return self._proved_plainly(pairs)
        apart, static = np.zeros(len(pairs), dtype=bool), np.zeros(len(pairs), dtype=bool)
        if self._reach is None or not self._reach.is_proved:
            return apart, static
        with_obstacle = pairs[:, 1] >= self._own
        own, others = pairs[~with_obstacle], pairs[with_obstacle]
        apart[~with_obstacle], static[~with_obstacle] = self._of_own(own)
        static[with_obstacle] = self._reach.at_rest[others[:, 0]]
        if self._is_compiled:
            apart[with_obstacle] = self._of_obstacles(others, static[with_obstacle])
        return (apart if self._is_compiled else np.zeros_like(apart)), static

    def _of_own(self, pairs: Ints) -> tuple[Bools, Bools]:
        """Which pairs (k, 2) of bodies on links are proved apart, and which are static."""
        assert self._reach is not None
        apart, static = self._reach.own_pairs(pairs)
        near = np.flatnonzero(static & ~apart)
        if not len(near) or not self._is_compiled:
            return apart, static
        what = ("apart at rest", tuple(self._bodies[: self._own]), self._preparation.paddings[: self._own].tobytes())
        key = (*what, self._preparation.excess, pairs[near].tobytes())
        at_rest = self._robot.remembered(key, lambda: self._stay_apart(pairs[near]))
        apart = apart.copy()
        apart[near] = at_rest
        return apart, static

    def in_cells(self, pairs: Ints) -> tuple[PairsInCells, ...]:
        """Cells of the joints of the robot in which pairs (k, 2) are apart, for those for which they pay."""
        reach = self._reach
        if reach is None or not self._is_compiled:
            return ()
        rows = np.flatnonzero((pairs < self._own).all(axis=1))
        found = reach.in_cells(pairs[rows], self._preparation.polytope, self._sampled_poses)
        return tuple(each.of(rows) for each in found)

    def _sampled_poses(self) -> Floats:
        """(n, bodies, 4, 4) of the bodies on links in sampled states, m."""
        own = self._bodies[: self._own]
        links = [self._robot.link_index(str(body.link)) for body in own]
        return np.asarray(self._robot.sampled_link_poses[:, links] @ np.array([body.pose for body in own]))

    def _of_obstacles(self, pairs: Ints, static: Bools) -> Bools:
        """Which pairs (k, 2) of a body on a link and an obstacle are proved apart."""
        rows, columns = pairs[:, 0], pairs[:, 1] - self._own
        near = np.flatnonzero(static & (self._facts[rows, columns] == _MAY_MEET))
        if len(near):
            found = self._stay_apart(pairs[near])
            self._facts[rows[near], columns[near]] = np.where(found, _APART, _MEET_AT_REST)
        return np.asarray(self._facts[rows, columns] == _APART)

    def _stay_apart(self, pairs: Ints) -> Bools:
        """(k,) whether pairs (k, 2) that are at rest relative to each other are apart."""
        prepared, robot = self._preparation.polytope, self._robot
        links = robot.link_poses(robot.reference)

        def pose(k: int) -> Floats:
            body = self._bodies[k]
            return body.pose if body.link is None else np.asarray(links[robot.link_index(body.link)] @ body.pose)

        return np.array(
            [stays_apart(prepared(a), prepared(b), pose(a), pose(b)) for a, b in pairs.tolist()], dtype=bool
        )

    def _proved_plainly(self, pairs: Ints) -> tuple[Bools, Bools]:
        found = self._in_order_of_chains(pairs)
        if not self._is_compiled or not found.is_proved:
            return np.zeros(len(pairs), dtype=bool), found.static
        apart = found.apart.copy()
        near = np.flatnonzero(found.static & ~apart)
        apart[near] = self._stay_apart(pairs[near])
        return apart, found.static

    def _in_order_of_chains(self, pairs: Ints) -> UnreachablePairs:
        """By unreachable_pairs.py, which lists bodies on links first."""
        order = sorted(range(len(self._bodies)), key=lambda k: self._bodies[k].link is None)
        place = np.argsort(order).astype(np.int32)
        bodies, hulls = [self._bodies[k] for k in order], [self._preparation.hull(k) for k in order]
        return unreachable_pairs(self._robot, bodies, place[pairs], hulls)
