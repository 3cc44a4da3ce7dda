"""Pairs of bodies and the joints between them, compiled into the core's certifier of motions.

In: a robot, its bodies, some of a checker's pairs. Out: `ChainedPairs`, a core certifier of these pairs only.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from plannercheck.bodies.certificates import Separation
from plannercheck.bodies.intersection import certify_posed
from plannercheck.bodies.part_certificates import PartSeparation
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import GeometryObject
from plannercheck.bodies.solid_separations import SolidSeparation
from plannercheck.bodies.tuning import Tuning, core_tuning
from plannercheck.checking.compiled_pairs import CompiledPairs
from plannercheck.common.array_types import Bools, Floats, Ints
from plannercheck.common.core import core
from plannercheck.common.motion_paths import MotionPath
from plannercheck.motions.joint_drives import SLIDE_DRIVE
from plannercheck.motions.robot_chains import chains_of_robot
from plannercheck.robots.robot import Robot
from plannercheck.robots.robot_memory import RobotMemory

# Two bodies that never move relative to each other and are further apart than this, m, are apart at every
# configuration: it is far above the rounding of kinematics.
_PERMANENT_GAP = 1e-9


class ChainedPairs:
    """The core's certifier of some pairs.

    Attributes:
        core: The compiled certifier of the pairs that move relative to each other.
        rows: (k,) their rows in the checker's pairs.
        flipped: (k,) whether a pair's bodies are swapped.
        frames: (k,) the link in whose frame each pair is seen, -1 for the world.
        touching: Rows of the checker's pairs that never move relative to each other and touch.
        of_robot: The joints of the robot's motions.
        table: (k, 2) the compiled pairs, the body that moves first.
    """

    def __init__(
        self,
        robot: Robot,
        bodies: Sequence[GeometryObject],
        pairs: Ints,
        part: CompiledPairs,
        mounts: tuple[Ints, Floats],
        excess: float,
        tuning: Tuning,
        path: MotionPath = "screw",
    ) -> None:
        """Prepares the chains of joints.

        Args:
            robot: The robot, posed by the compiled kernel.
            bodies: The robot's bodies, then the scene's.
            pairs: (n, 2) indices into bodies: all pairs of the checker.
            part: The rows of pairs to take.
            mounts: The links that bodies hang on, and their poses there, see `compiled_pairs.body_placements`.
            excess: How far polytopes of curved shapes stick out, as a part of the radius.
            tuning: What saves work.
            path: How planar and floating joints move.
        """
        links, placements = mounts
        self._width = robot.nq
        table = _ordered(pairs[part.rows], links)
        moving = links[table[:, 0]] >= 0
        polytopes = part.polytopes
        self.rows = part.rows[moving]
        self.flipped = (table[:, 0] != pairs[part.rows, 0])[moving]
        self.touching = part.rows[~moving][~_permanently_apart(robot, table[~moving], polytopes, placements)].tolist()
        self.of_robot = of_robot = chains_of_robot(robot, bodies, links, excess, path)
        self.table = table[moving].astype(np.int64)
        self._chains = chains = of_robot.of(self.table)
        self.frames = chains.pairs[:, 2].tolist()
        live = sorted(polytopes)
        position = np.full(len(bodies), -1, dtype=np.int32)
        position[live] = np.arange(len(live))
        rows = chains.pairs.copy()
        rows[:, :2] = position[rows[:, :2]]
        (joints, factors, parts), spread = of_robot.drives, of_robot.spread
        self.core = core.MotionCertifier(
            [polytopes[k].core for k in live],
            links[live],
            np.ascontiguousarray(placements[live]),
            rows,
            joints,
            factors,
            chains.first_entry,
            chains.entries,
            chains.arms,
            chains.slides,
            parts,
            robot.nq,
            len(robot.link_names),
            of_robot.defect,
            of_robot.leverage,
            of_robot.depth,
            spread.extent,
            spread.travel,
            spread.joints,
            core_tuning(tuning),
            [part.core] if tuning.middle_states else [],
        )

    def levers(self) -> Floats:
        """(nq,) how far a number moves the bodies of a pair against each other, at most, in m/rad and m/m.

        The levers of all joints of a pair add up; the largest sum of all pairs counts. It is a guide, and no bound:
        slides that lengthen arms are left out.
        """
        chains, (joints, factors, _) = self._chains, self.of_robot.drives
        by_chain = np.zeros((len(chains.first_entry), self._width))  # the last one is of no joint
        of_entry, (kinds, columns) = chains.entries[:, 0], joints.T
        moved = np.abs(factors[:, 0])[of_entry] * np.where(kinds[of_entry] == SLIDE_DRIVE, 1.0, chains.arms)
        chain = np.repeat(np.arange(len(by_chain) - 1), np.diff(chains.first_entry))
        driven = columns[of_entry] >= 0
        np.add.at(by_chain, (chain[driven], columns[of_entry][driven]), moved[driven])
        return np.asarray(by_chain[chains.pairs[:, 3:]].sum(axis=1).max(axis=0, initial=0.0))


def _ordered(pairs: Ints, links: Ints) -> Ints:
    """Pairs in which the first body moves, if either does."""
    moves = links[pairs] >= 0
    swapped = np.flatnonzero(moves[:, 1] > moves[:, 0])
    if len(swapped):
        pairs = pairs.copy()
        pairs[swapped] = pairs[swapped][:, ::-1]
    return pairs


def _permanently_apart(robot: Robot, pairs: Ints, polytopes: Mapping[int, Polytope], poses: Floats) -> Bools:
    """(k,) whether the bodies of pairs (k, 2) at rest are apart; kept with the robot, whose checkers ask again."""
    is_own = np.asarray((pairs < len(robot.bodies)).all(axis=1)).tolist()
    own = [pair for pair, mine in zip(pairs.tolist(), is_own, strict=True) if mine]
    others = [pair for pair, mine in zip(pairs.tolist(), is_own, strict=True) if not mine]
    kept: RobotMemory = robot.remembered("permanently apart", RobotMemory)  # of its own: obstacles come and go
    found = iter(_separations(robot, own, polytopes, poses)) if own else iter(())
    apart = {tuple(pair): next(found) for pair in own}
    for a, b in others:
        key = polytopes[a], polytopes[b], poses[[a, b]].tobytes()
        apart[a, b] = kept.recall(key, partial(_are_separate, a, b, polytopes, poses))
    return np.array([apart[a, b] for a, b in pairs.tolist()], dtype=bool)


def _separations(robot: Robot, pairs: list[list[int]], polytopes: Mapping[int, Polytope], poses: Floats) -> list[bool]:
    """Which of the robot's own pairs are apart, all at once."""
    sides = [k for pair in pairs for k in pair]
    key = "own pairs permanently apart", tuple(polytopes[k] for k in sides), poses[sides].tobytes()
    return robot.remembered(key, lambda: [_are_separate(a, b, polytopes, poses) for a, b in pairs])


def _are_separate(a: int, b: int, polytopes: Mapping[int, Polytope], poses: Floats) -> bool:
    certificate = certify_posed(polytopes[a], polytopes[b], poses[a], poses[b])
    return isinstance(certificate, Separation | SolidSeparation | PartSeparation) and certificate.gap > _PERMANENT_GAP
