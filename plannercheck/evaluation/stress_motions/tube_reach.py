"""How far a tube moves bodies towards each other at most, by lever arms: beyond that no curve may be refused.

In: a checker, bounds of a curve's numbers, its tube. Out: a length.
"""

from __future__ import annotations

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.motions.checker import Checker
from plannercheck.motions.robot_chains import chains_of_robot

# Kinds of drives, see `joint_drives.drives`: only these have a tube.
_TURN, _SLIDE = 0, 1


class TubeReach:
    """The chains of joints between all pairs of a checker."""

    def __init__(self, checker: Checker) -> None:
        """Takes the lever arms that the certifier has."""
        assert checker._kernel is not None
        links, _ = checker._tables.mounts(checker._kernel)
        moves = links[checker.pairs] >= 0
        ordered = np.where((moves[:, 1] > moves[:, 0])[:, None], checker.pairs[:, ::-1], checker.pairs)
        of_robot = chains_of_robot(checker.robot, checker.bodies, links, checker.excess, "slerp")
        self._chains = of_robot.of(ordered[moves.any(axis=1)].astype(np.int64))
        (kinds_and_columns, factors, _) = of_robot.drives
        self._kinds, self._columns = kinds_and_columns.T
        self._multipliers, self._offsets = factors.T

    def largest_shift(self, sizes: Floats, tube: Floats) -> float:
        """The bound of all pairs, m, for magnitudes (nq,) of a curve's numbers and a tube (nq,)."""
        chains, driven = self._chains, self._columns >= 0
        factors = np.where(driven, np.abs(self._multipliers), 0.0)
        off = factors * tube[self._columns]
        slides = driven & (self._kinds == _SLIDE)
        extents = np.where(slides, factors * sizes[self._columns] + np.abs(self._offsets) + off, 0.0)
        joints, first, past = chains.entries.T
        arms = chains.arms + [extents[chains.slides[a:b]].sum() for a, b in zip(first, past, strict=True)]
        moved = np.where(self._kinds[joints] == _TURN, off[joints] * arms, np.where(slides[joints], off[joints], 0.0))
        sums = np.append(np.add.reduceat(np.append(moved, 0.0), chains.first_entry[:-1]), 0.0)
        return float(sums[chains.pairs[:, 3:]].sum(axis=1).max(initial=0.0))
