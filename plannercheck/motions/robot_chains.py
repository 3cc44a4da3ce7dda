"""Chains of joints of a robot's bodies, made once a robot, because they do not depend on obstacles.

In: a robot, its bodies, the links that move. Out: `RobotChains`, which gives the arrays that the core's certifier takes
for any pairs of these bodies with each other and with bodies at rest.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from plannercheck.bodies.shapes import GeometryObject
from plannercheck.common.array_types import Floats, Ints, Ints64
from plannercheck.common.arrays import read_only
from plannercheck.common.motion_paths import MotionPath
from plannercheck.motions.joint_axes import JointTree
from plannercheck.motions.joint_chains import ChainBuilder, ChainJoint, PairParts, chain_arrays
from plannercheck.motions.joint_drives import Spread, defect, drives, spread
from plannercheck.robots.robot import Robot

# Arrays are cached for so many choices of pairs of at most so many pairs each: a moved obstacle keeps its pairs.
_MOST_CHOICES, _MOST_PAIRS_KEPT = 8, 4096


class ChosenChains(NamedTuple):
    """The chains of some pairs, as the core takes them.

    Attributes:
        pairs: (k, 5) first body, second body, frame, and the chains of both; -1 for the world and for no chain.
        first_entry: (chains + 1,) where the entries of each chain begin.
        entries: (entries, 3) joint, and where its slides begin and end.
        arms: (entries,) m.
        slides: Joints.
    """

    pairs: Ints
    first_entry: Ints
    entries: Ints
    arms: Floats
    slides: Ints


class RobotChains:
    """The chains of one robot's bodies. Immutable but for results that are kept; threads may share it.

    Attributes:
        drives: Kinds and columns, factors, and parts of the joints, see `joint_drives.drives`.
        defect: Bound of ||M^T M - 1|| for all placements and held joints together.
        leverage: Sum of all multipliers.
        depth: The largest number of quaternions, or cosines and sines, on one chain.
        spread: How far from the world's origin joints and links may be.
    """

    drives: tuple[Ints, Floats, Ints]
    defect: float
    leverage: float
    depth: int
    spread: Spread
    _builder: ChainBuilder

    def __init__(
        self,
        robot: Robot,
        bodies: Sequence[GeometryObject],
        links: Sequence[int],
        excess: float,
        carrier: RobotChains | None = None,
        path: MotionPath = "screw",
    ) -> None:
        """Poses the joints at rest.

        Args:
            robot: The robot, posed by the compiled kernel.
            bodies: The bodies on its links, what they carry last.
            links: Each body's link, -1 if no joint moves the body.
            excess: How far polytopes of curved shapes stick out, as a part of the radius.
            carrier: The chains of the robot without what it carries; its results are taken over.
            path: How planar and floating joints move.
        """
        table = robot.joint_table
        assert table is not None
        self._lock, self._own, self._carrier = threading.Lock(), len(bodies), carrier
        # One more link, that of any body beyond those given: it is at rest.
        self._links = np.array([*links, -1], dtype=np.int32)
        tree = (
            JointTree(robot.model, robot.configuration_map, table, robot.frames, path)
            if carrier is None
            else carrier.tree
        )
        self._builder = ChainBuilder(tree, bodies, self._links.tolist(), excess)
        self.drives = drives(table, path) if carrier is None else carrier.drives
        self.defect = defect(table) if carrier is None else carrier.defect
        self.leverage = float(max(1.0, np.abs(table.multipliers).sum()))
        self.depth = robot.configuration_map.lengths.depth
        self.spread = spread(table) if carrier is None else carrier.spread
        self._with_world = np.full(self._own, -1, dtype=np.int32)
        self._is_known = np.zeros(self._own, dtype=bool)  # which of the above
        self._own_pairs: dict[bytes, Ints] = {}
        self._known_parts: dict[tuple[int, int], PairParts] = {}  # for robots that carry something
        self._flat: dict[bytes, tuple[Ints, Ints, Floats, Ints]] = {}
        self._chosen: dict[bytes, ChosenChains] = {}

    @property
    def own_count(self) -> int:
        """The number of bodies on links; indices from it on are at rest."""
        return self._own

    @property
    def tree(self) -> JointTree:
        """The joints."""
        return self._builder.tree

    def of(self, pairs: Ints64) -> ChosenChains:
        """The chains of pairs (k, 2), of which the first body moves; obstacles follow the bodies."""
        if len(pairs) > _MOST_PAIRS_KEPT:
            with self._lock:
                return self._of(pairs)
        key = pairs.tobytes()
        with self._lock:
            found = self._chosen.get(key)
            if found is None:
                if len(self._chosen) >= _MOST_CHOICES:
                    self._chosen.clear()
                found = self._chosen[key] = self._of(pairs)
        return found

    def _of(self, pairs: Ints64) -> ChosenChains:
        rows = np.empty((len(pairs), 5), dtype=np.int32)
        rows[:, :2] = pairs
        at_rest = np.asarray(self._links[np.minimum(pairs[:, 1], self._own)] < 0)
        rows[at_rest, 2] = rows[at_rest, 4] = -1
        rows[at_rest, 3] = self._chains_from_world(pairs[at_rest, 0])
        rows[~at_rest, 2:] = self._of_own(pairs[~at_rest])
        chosen, rows[:, 3:] = _by_first_use(rows[:, 3:])
        return ChosenChains(read_only(rows), *self._arrays(chosen))

    def _chains_from_world(self, bodies: Ints64) -> Ints:
        """(k,) the chain from the world to each body."""
        for body in sorted(set(bodies[~self._is_known[bodies]].tolist())):
            self._with_world[body] = self._builder.index(self._parts(body, self._own).first)
            self._is_known[body] = True
        return self._with_world[bodies]

    def _of_own(self, pairs: Ints64) -> Ints:
        """(k, 3) frame and chains of pairs (k, 2) that both move."""
        key = pairs.tobytes()
        if key not in self._own_pairs:
            index = self._builder.index
            made = (self._parts(a, b) for a, b in pairs.tolist())
            rows = [(parts.frame, index(parts.first), index(parts.second)) for parts in made]
            self._own_pairs[key] = read_only(np.array(rows, dtype=np.int32).reshape(-1, 3))
        return self._own_pairs[key]

    def _parts(self, first: int, second: int) -> PairParts:
        """The chains of two bodies, the second of which may be one at rest; the carrier knows those of its own."""
        carrier = self._carrier
        if carrier is None or first >= carrier._own or carrier._own <= second < self._own:
            return self._builder.parts(first, second)
        with carrier._lock:
            key = first, min(second, carrier._own)
            if key not in carrier._known_parts:
                carrier._known_parts[key] = carrier._builder.parts(*key)
            return carrier._known_parts[key]

    def _arrays(self, chosen: Ints64) -> tuple[Ints, Ints, Floats, Ints]:
        key = chosen.tobytes()
        if key not in self._flat:
            chains: list[tuple[ChainJoint, ...]] = [self._builder.chains[k] for k in chosen.tolist()]
            self._flat[key] = chain_arrays(chains)
        return self._flat[key]


def _by_first_use(chains: Ints) -> tuple[Ints64, Ints]:
    """The chains (m,) that pairs (k, 2) use, in the order in which they first do, and the pairs by places in it."""
    used = chains.ravel()
    first = np.full(used.max(initial=-1) + 2, -1, dtype=np.int64)  # by chain; the last is that of no chain
    first[used[::-1]] = np.arange(len(used))[::-1]  # of several numbers for one chain, the last one stays
    numbers = np.flatnonzero(first[:-1] >= 0)
    order = numbers[np.argsort(first[numbers])]
    new = np.full(len(first), -1, dtype=np.int32)
    new[order] = np.arange(len(order))
    return order, new[used].reshape(-1, 2)


def chains_of_robot(
    robot: Robot, bodies: Sequence[GeometryObject], links: Ints, excess: float, path: MotionPath = "screw"
) -> RobotChains:
    """The chains of a robot's bodies, made when a certifier of it first asks.

    Args:
        robot: The robot, posed by the compiled kernel.
        bodies: The bodies on its links, or stand-ins for them, then obstacles, then copies of any of them.
        links: Each body's link, -1 if no joint moves the body.
        excess: How far polytopes of curved shapes stick out, as a part of the radius.
        path: How planar and floating joints move.
    """
    count = len(robot.bodies)
    if (links[count:] >= 0).any():  # a pair has a padding of its own
        return RobotChains(robot, bodies, links.tolist(), excess, None, path)
    own, hung = tuple(bodies[:count]), tuple(links[:count].tolist())
    alone = next((k for k, body in enumerate(own) if body.carried is not None), count)

    def compute() -> RobotChains:
        carrier = None
        if alone < count:
            carrier = chains_of_robot(robot.carrying(()), own[:alone], links[:alone], excess, path)
        return RobotChains(robot, own, hung, excess, carrier, path)

    return robot.remembered(("chains", own, hung, excess, path), compute)
