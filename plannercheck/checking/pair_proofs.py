"""Proofs about pairs, kept from one checker to the next: which never meet within the limits, and which are at rest.

In: a robot, bodies, their preparation, and the proofs of an earlier checker of the same robot. Out: `MeetingProofs`. A
proof about a pair holds as long as neither body is moved. A moved obstacle is a new `GeometryObject`, so only pairs of
bodies that were moved, added or attached are proved again (see unreachable_pairs.py).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.shapes import GeometryObject
from plannercheck.checking.prepared_bodies import Preparation
from plannercheck.checking.reach_bounds import Chains
from plannercheck.checking.unreachable_pairs import UnreachablePairs, chains_of, stays_apart, unreachable_pairs
from plannercheck.common.array_types import Bools, Floats, Ints
from plannercheck.robots.robot import Robot

_Side = tuple[GeometryObject, float]  # and its padding, m

# In a pair's number, the bits of the second body's number.
_HALF = 32


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
        """Starts with what an earlier checker has proved.

        Args:
            robot: The robot.
            bodies: Its bodies, then the obstacles, then copies of them with another padding.
            preparation: The prepared polytopes of these bodies.
            is_compiled: Whether the compiled kinematics poses the robot; nothing is proved for other kinematics.
            earlier: The proofs of a checker of the same robot and paddings.
        """
        self._robot, self._bodies, self._preparation, self._is_compiled = robot, bodies, preparation, is_compiled
        # Chains list bodies on links first. Where there are copies, nothing is taken over, since indices differ.
        self._order = sorted(range(len(bodies)), key=lambda k: bodies[k].link is None)
        self._has_copies = self._order != list(range(len(bodies)))
        if earlier is not None and (self._has_copies or earlier._has_copies):
            earlier = None
        self._numbers: dict[_Side, int] = {} if earlier is None else earlier._numbers
        self._known: NDArray[np.int64] = np.zeros(0, dtype=np.int64) if earlier is None else earlier._known  # ascending
        self._facts: Bools = np.zeros((0, 2), dtype=bool) if earlier is None else earlier._facts
        self._chains: Chains | None = earlier._chains if earlier is not None else None

    def of(self, pairs: Ints) -> tuple[Bools, Bools]:
        """Which pairs (k, 2) never meet within the limits, and which are at rest relative to each other."""
        keys = self._keys(pairs)
        place = np.searchsorted(self._known, keys)
        known = np.zeros(len(keys), dtype=bool)
        inside = place < len(self._known)
        known[inside] = self._known[place[inside]] == keys[inside]
        facts = np.zeros((len(keys), 2), dtype=bool)
        facts[known] = self._facts[place[known]]
        if not known.all():
            facts[~known] = np.stack(self._proved(pairs[~known]), axis=1)
        self._known, first = np.unique(keys, return_index=True)  # pairs that are gone are forgotten
        self._facts = facts[first]
        return facts[:, 0], facts[:, 1]

    def _keys(self, pairs: Ints) -> NDArray[np.int64]:
        """(k,) a number for each pair: equal if and only if both bodies and their paddings are the same."""
        sides = list(zip(self._bodies, self._preparation.paddings.tolist(), strict=True))
        fresh = itertools.count(max(self._numbers.values(), default=-1) + 1)
        numbers = {side: self._numbers[side] if side in self._numbers else next(fresh) for side in sides}
        self._numbers = numbers
        of_body = np.array([numbers[side] for side in sides], dtype=np.int64)
        return np.asarray(of_body[pairs[:, 0]] << _HALF | of_body[pairs[:, 1]])

    def _proved(self, pairs: Ints) -> tuple[Bools, Bools]:
        found = self._reach(pairs)
        if not self._is_compiled or not found.is_proved:
            return np.zeros(len(pairs), dtype=bool), found.static
        apart, prepared = found.apart.copy(), self._preparation.polytope
        near = np.flatnonzero(found.static & ~apart)
        poses = self._poses_at_reference() if len(near) else None
        for k in near.tolist():
            assert poses is not None
            a, b = pairs[k].tolist()
            apart[k] = stays_apart(prepared(a), prepared(b), poses[a], poses[b])
        return apart, found.static

    def _reach(self, pairs: Ints) -> UnreachablePairs:
        place = np.argsort(self._order).astype(np.int32)
        bodies = [self._bodies[k] for k in self._order]
        hulls = [self._preparation.hulls[k] for k in self._order]
        self._chains = chains_of(self._robot, bodies, hulls, self._chains)
        return unreachable_pairs(self._robot, bodies, place[pairs], hulls, self._chains)

    def _poses_at_reference(self) -> Floats:
        """(bodies, 4, 4) up to rounding, m."""
        links = self._robot.link_poses(self._robot.reference)
        worlds = (np.eye(4) if b.link is None else links[self._robot.link_index(b.link)] for b in self._bodies)
        return np.array([world @ body.pose for world, body in zip(worlds, self._bodies, strict=True)])
