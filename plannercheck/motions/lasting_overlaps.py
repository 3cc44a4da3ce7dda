"""Boxes of joint values in which two bodies overlap throughout.

In: pairs of hulls on a robot's links, cells of joint values. Out: which cells hold no state that is free. Idea: hulls
that are d deep in each other at a cell's middle, by proof, share a point as long as their points move by less than d
towards each other: along every direction they overlap by d at least, and no plane separates them. Lever arms bound how
far points move (joint_chains.py).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.checking.compiled_tables import CompiledTables
from plannercheck.common.array_types import Bools, Floats, Ints, Ints64
from plannercheck.common.core import core
from plannercheck.motions.robot_chains import ChosenChains, chains_of_robot
from plannercheck.robots.joints import KINDS
from plannercheck.robots.kinematics import JointTable
from plannercheck.robots.robot import Robot

# The rounding of poses and of the sums here, m, far above both; and of products of arms and angles.
_ROUNDING, _STRETCH = 1e-9, 1 + 1e-6


class _Pair(NamedTuple):
    """Two hulls, and how far each number of a configuration moves their points, (nq,) m/rad and m/m."""

    a: int
    b: int
    hulls: tuple[Polytope, Polytope]
    rates: Floats


class LastingOverlaps:
    """The pairs of hulls of two links."""

    def __init__(self, robot: Robot, pairs: Ints, tables: CompiledTables, extents: Floats, excess: float) -> None:
        """Bounds the rates.

        Args:
            robot: The robot, posed by the compiled kernel.
            pairs: (k, 2) indices of its bodies.
            tables: These pairs, compiled.
            extents: (nq,) the largest amount of each number, rad and m.
            excess: How far polytopes of curved shapes stick out, as a part of the radius.
        """
        assert robot.kinematics is not None
        assert robot.joint_table is not None
        self._robot, self._tables = robot, tables
        links, _ = tables.mounts(robot.kinematics)
        moves = links[pairs] >= 0
        rows = np.where((moves[:, 1] > moves[:, 0])[:, None], pairs[:, ::-1], pairs)[moves.any(axis=1)]
        chains = chains_of_robot(robot, robot.bodies, links, excess, "screw").of(rows.astype(np.int64))
        self._pairs = []
        for a, b, _, *both in chains.pairs.tolist():
            p, r = tables.all.polytopes[a], tables.all.polytopes[b]
            if p.traits.fills_hull and r.traits.fills_hull:
                rates = sum((_rates(robot.joint_table, chains, k, extents) for k in both), np.zeros(robot.nq))
                self._pairs.append(_Pair(a, b, (p, r), rates))

    def hold(self, lows: Floats, highs: Floats) -> Bools:
        """(n,) in which cells (n, nq), rad and m, some pair is proved to overlap throughout."""
        middles = (lows + highs) / 2
        halves = np.maximum(highs - middles, middles - lows)
        poses = self._tables.all.body_poses(self._robot.link_poses(middles))
        found = np.zeros(len(lows), dtype=bool)
        for pair in self._pairs:
            moved = halves @ pair.rates * _STRETCH + _ROUNDING
            found |= -posed_distances(*pair.hulls, poses[:, pair.a], poses[:, pair.b]) > moved
        return found


def posed_distances(first: Polytope, second: Polytope, poses_first: Floats, poses_second: Floats) -> Floats:
    """(n,) signed distances of two hulls at poses (n, 4, 4), m, from above: below 0 they overlap."""
    both = np.ascontiguousarray(poses_first), np.ascontiguousarray(poses_second)
    distances: Floats = core.distance_batch(first.core, both[0], second.core, both[1])[1]
    return distances


def _rates(table: JointTable, chains: ChosenChains, chain: int, extents: Floats) -> Floats:
    """(nq,) how fast each number moves the points at the end of a chain at most."""
    rates = np.zeros(table.width)
    if chain < 0:
        return rates
    for k in range(int(chains.first_entry[chain]), int(chains.first_entry[chain + 1])):
        joint, first, past = chains.entries[k].tolist()
        if KINDS[int(table.kinds[joint])].numbers > 1 or table.columns[joint, 0] < 0:
            continue  # held, or of several numbers, which stand at the reference
        arm = float(chains.arms[k]) + _slid(table, chains.slides[first:past].astype(np.int64), extents)
        slides = KINDS[int(table.kinds[joint])].lengths > 0
        rates[int(table.columns[joint, 0])] += abs(float(table.multipliers[joint, 0])) * (1.0 if slides else arm)
    return rates


def _slid(table: JointTable, joints: Ints64, extents: Floats) -> float:
    """How far some joints slide in all, at most, m."""
    columns = table.columns[joints, 0]
    moved = np.where(columns >= 0, extents[columns], 0.0) * np.abs(table.multipliers[joints, 0])
    return float((moved + np.abs(table.offsets[joints, 0])).sum())
