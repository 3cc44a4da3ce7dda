"""Whether two links of a robot ever collide within the joint limits: proved, or shown by a configuration.

In: a robot, two links. Out: a `PairDecision`. Idea: only the joints between both links matter. Their box of values is
cut into cells; a cell is done once a tube around its middle is proved free, and the search ends at a middle that
collides. What is not done after some time stays open, and its share of the box is said.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import DEFAULT_EXCESS
from plannercheck.bodies.tuning import DEFAULT_TUNING, core_tuning
from plannercheck.checking.collision_matrix import with_all_joints
from plannercheck.checking.compiled_pairs import PairSource
from plannercheck.checking.compiled_tables import CompiledTables
from plannercheck.checking.prepared_bodies import Preparation
from plannercheck.common.array_types import Bools, Floats, Ints
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.certifier import MotionCertifier
from plannercheck.motions.joint_cells import LEAST_LEVER, are_free, halved
from plannercheck.motions.lasting_overlaps import LastingOverlaps, posed_distances
from plannercheck.robots.configurations import COSINE
from plannercheck.robots.robot import Robot

# never, always: proved for every configuration. collides: at `example`. open: none of these is known.
Answer: TypeAlias = Literal["never", "always", "collides", "open"]

# Cells that are judged at once, and the most that wait: a search that needs more stays open.
_BATCH, _MOST_WAITING = 4096, 1_000_000

# Half a turn of a continuous joint, rad: the nearest double beyond pi.
_HALF_TURN = np.nextafter(np.pi, 4.0)

# So many configurations that collide are measured at once, until one is deep enough: _ROUNDING more, m, than poses are
# off, since proofs have such a margin. Of these the deepest is taken.
_MEASURED, _ROUNDING = 64, 1e-12

# Before cells, so many random configurations are tried: a pair that collides often is found at once.
_TRIED = 2000


@dataclass(frozen=True, eq=False)
class PairDecision(OwnsArrays):
    """What is known of two links, at all configurations within the limits.

    Attributes:
        link_a: A link.
        link_b: Another link.
        answer: "never" and "always": proved. "collides": at `example`, hulls by more than poses are rounded. "open":
            none of these is known.
        joints: The joints between both, which alone matter; the others stand at the reference.
        cells: How many cells were proved free, or for "always" to collide throughout.
        open_share: The share of the joints' box that is in cells which are not proved; 0 for "never" and "always".
        example: (nq,) a configuration that collides, of the group of all joints, rad and m; None if none was found.
    """

    link_a: str
    link_b: str
    answer: Answer
    joints: tuple[str, ...]
    cells: int
    open_share: float
    example: Floats | None


class PairDecider:
    """Decides pairs of links of one robot.

    Attributes:
        robot: The robot, whose group has all joints of one value that do not follow others.
        lower: (nq,) its limits, rad and m; of a continuous joint one turn is all.
        upper: (nq,).
    """

    def __init__(self, robot: Robot) -> None:
        """Takes a robot; its group and its disabled pairs do not matter.

        Raises:
            PlannercheckError: If Pinocchio itself poses it, or no joint moves.
        """
        self.robot = with_all_joints(robot)
        if self.robot.joint_table is None:
            raise PlannercheckError(f"pairs of {robot.name!r} can't be proved, since Pinocchio itself has to pose it")
        self._preparation = Preparation(self.robot.bodies, DEFAULT_EXCESS, np.zeros(len(self.robot.bodies)))
        unbounded = ~(np.isfinite(self.robot.lower) & np.isfinite(self.robot.upper))
        self.lower = np.where(unbounded, -_HALF_TURN, self.robot.lower)
        self.upper = np.where(unbounded, _HALF_TURN, self.robot.upper)
        known = self.robot.configuration_map
        self._has_range = ~unbounded
        self._has_range[known.columns[known.roles == COSINE]] = True  # continuous joints: one turn is all

    def decide(self, link_a: str, link_b: str, seconds: float) -> PairDecision:
        """Searches for so many seconds of processor time at most.

        Raises:
            PlannercheckError: If one of the names is no link with bodies.
        """
        return self.search(link_a, link_b).run(seconds)

    def search(self, link_a: str, link_b: str) -> PairSearch:
        """The search for one pair; errors as of `decide`."""
        return PairSearch(self, link_a, link_b, self.pairs(link_a, link_b))

    def polytope(self, body: int) -> Polytope:
        """One of the robot's bodies, prepared."""
        return self._preparation.polytope(body)

    def pairs(self, link_a: str, link_b: str) -> Ints:
        """(k, 2) all pairs of their bodies."""
        bodies = [[k for k, body in enumerate(self.robot.bodies) if body.link == link] for link in (link_a, link_b)]
        for link, some in zip((link_a, link_b), bodies, strict=True):
            if not some:
                raise PlannercheckError(f"{link!r} is no link with collision bodies")
        return np.array([(min(i, j), max(i, j)) for i in bodies[0] for j in bodies[1]], dtype=np.int32)

    def _columns_between(self, link_a: str, link_b: str) -> list[int]:
        """The numbers of a configuration that move one of both links relative to the other."""
        table = self.robot.joint_table
        assert table is not None
        carrying = []
        for link in (link_a, link_b):
            joint, joints = int(table.link_joints[self.robot.link_index(link)]), set[int]()
            while joint >= 0:
                joints.add(joint)
                joint = int(table.parents[joint])
            carrying.append(joints)
        columns = table.columns[sorted(carrying[0] ^ carrying[1])]
        return sorted({int(column) for column in columns.ravel() if column >= 0})


class PairSearch:
    """The search for one pair.

    Attributes:
        pairs: (k, 2) the bodies of both links.
        columns: The numbers of a configuration that move one relative to the other.
        tables: These pairs, compiled.
        certifier: What proves cells free.
        low: (nq,) the least configuration: others of its numbers are the reference's.
        high: (nq,) the largest.
        levers: (nq,) how fast each of these numbers moves bodies, roughly, m/rad and m/m; 0 of others.
    """

    def __init__(self, decider: PairDecider, link_a: str, link_b: str, pairs: Ints) -> None:
        self._decider, self._links, self.pairs, robot = decider, (link_a, link_b), pairs, decider.robot
        source = PairSource(robot, robot.bodies, decider._preparation, core_tuning(), robot.kinematics)
        self.tables = CompiledTables(source, pairs, np.zeros(len(pairs), dtype=bool))
        self.certifier = MotionCertifier(robot, robot.bodies, pairs, self.tables, DEFAULT_EXCESS, DEFAULT_TUNING)
        self.columns = decider._columns_between(link_a, link_b)
        self.low, self.high = robot.reference.copy(), robot.reference.copy()
        self.low[self.columns], self.high[self.columns] = decider.lower[self.columns], decider.upper[self.columns]
        self.levers = np.zeros(robot.nq)
        self.levers[self.columns] = np.maximum(self.certifier.levers()[self.columns], LEAST_LEVER)

    def run(self, seconds: float) -> PairDecision:
        """Cuts the box until it is proved, a middle collides, or the time is over."""
        until, decider = time.process_time() + seconds, self._decider
        low, high, levers = self.low, self.high, self.levers
        if not decider._has_range[self.columns].all():
            return self._decision("open", 0, 1.0)
        tried = np.random.default_rng(0).uniform(low, high, (_TRIED, len(low)))
        free = self._are_free(tried)
        example = self._deepest(tried[~free])
        if not free.any():
            return self._always(low, high, levers, until, example)
        if example is not None:
            return self._decision("collides", 0, 1.0, example)
        waiting, proved, share = [(low[None], high[None])], 0, 1.0
        while waiting and time.process_time() < until and sum(len(lows) for lows, _ in waiting) < _MOST_WAITING:
            lows, highs = self._next(waiting)
            free = are_free(self.certifier, lows, highs)
            proved += int(free.sum())
            share -= float(self._shares(lows[free], highs[free], low, high).sum())
            lows, highs = lows[~free], highs[~free]
            if not len(lows):
                continue
            middles = (lows + highs) / 2
            example = self._deepest(middles[~self._are_free(middles)])
            if example is not None:
                return self._decision("collides", proved, share, example)
            waiting.append(halved(lows, highs, levers))
        return self._decision("open", proved, share) if waiting else self._decision("never", proved, 0.0)

    def _deepest(self, q: Floats) -> Floats | None:
        """One of the deepest of colliding configurations (n, nq); None if all may touch only by the poses' rounding."""
        polytopes, pairs = self.tables.all.polytopes, self.pairs.tolist()
        if len(q) and not all(polytopes[k].traits.fills_hull for pair in pairs for k in pair):
            return np.asarray(q[0])
        rounding = _ROUNDING + 2 * self._decider.robot.kinematic_error_within(self._decider.lower, self._decider.upper)
        for begin in range(0, len(q), _MEASURED):
            some: Floats = q[begin : begin + _MEASURED]
            poses = self.body_poses(some)
            depths = np.max(
                [-posed_distances(polytopes[a], polytopes[b], poses[:, a], poses[:, b]) for a, b in pairs], 0
            )
            deepest = int(depths.argmax())
            if depths[deepest] > rounding:
                return np.asarray(some[deepest])
        return None

    def _always(self, low: Floats, high: Floats, levers: Floats, until: float, example: Floats | None) -> PairDecision:
        """Cuts the box until every cell is proved to collide throughout, a middle is free, or the time is over."""
        extents = np.maximum(np.abs(self._decider.lower), np.abs(self._decider.upper))
        overlaps = LastingOverlaps(self._decider.robot, self.pairs, self.tables, extents, DEFAULT_EXCESS)
        some: Answer = "open" if example is None else "collides"
        if not self.columns:
            return self._decision(some, 0, 1.0) if example is None else self._decision("always", 1, 0.0, example)
        waiting, proved, share = [(low[None], high[None])], 0, 1.0
        while waiting and time.process_time() < until and sum(len(lows) for lows, _ in waiting) < _MOST_WAITING:
            lows, highs = self._next(waiting)
            hold = overlaps.hold(lows, highs)
            proved += int(hold.sum())
            share -= float(self._shares(lows[hold], highs[hold], low, high).sum())
            lows, highs = lows[~hold], highs[~hold]
            if len(lows) and self._are_free((lows + highs) / 2).any():
                return self._decision(some, proved, share, example)
            if len(lows):
                waiting.append(halved(lows, highs, levers))
        if waiting:
            return self._decision(some, proved, share, example)
        return self._decision("always", proved, 0.0, example)

    def _next(self, waiting: list[tuple[Floats, Floats]]) -> tuple[Floats, Floats]:
        """Takes a batch of the largest cells that wait: they come first."""
        lows, highs = waiting.pop(0)
        if len(lows) > _BATCH:
            waiting.insert(0, (lows[_BATCH:], highs[_BATCH:]))
        return lows[:_BATCH], highs[:_BATCH]

    def _shares(self, lows: Floats, highs: Floats, low: Floats, high: Floats) -> Floats:
        """(n,) the share of the whole box that each cell has."""
        sides = [k for k in self.columns if high[k] > low[k]]
        return np.asarray(((highs - lows)[:, sides] / (high - low)[sides]).prod(axis=1))

    def _are_free(self, q: Floats) -> Bools:
        """(n,) whether configurations (n, nq) are free."""
        robot = self._decider.robot
        assert robot.kinematics is not None
        return self.tables.check_states(robot.kinematics, q, 1)

    def body_poses(self, q: Floats) -> Floats:
        """(n, bodies, 4, 4) of the robot's bodies at configurations (n, nq)."""
        return self.tables.all.body_poses(self._decider.robot.link_poses(q))

    def _decision(self, answer: Answer, cells: int, share: float, example: Floats | None = None) -> PairDecision:
        names = self._decider.robot.joint_names
        joints = tuple(names[column] for column in self.columns)
        return PairDecision(*self._links, answer, joints, cells, max(share, 0.0), example)
