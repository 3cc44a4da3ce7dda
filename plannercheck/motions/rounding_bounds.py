"""Bounds on how far computed poses are from exact kinematics on motions.

In: a robot, motions. Out: `RoundingBounds`, which groups motions by the bound that holds for them. The bound of
a range around the limits is computed once. Motions that leave this range get the bound of a range up to the next powers
of 2, so that a verdict depends on its own motion only.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct_rows
from plannercheck.robots.robot import Robot

Rows: TypeAlias = NDArray[np.int64]

# Beyond the limits by this much, rad and m, the bound of kinematic rounding is computed once for all.
_MARGIN = 10.0


class RoundingBounds:
    """Bounds of the kinematics' rounding on motions of one robot.

    Attributes:
        low: (nq,) lower end of the range in which the usual bound holds, rad and m.
        high: (nq,) upper end of that range.
        usual: The usual bound, m.
        turning: Columns of angles that whole turns do not change.
    """

    def __init__(self, robot: Robot) -> None:
        """Computes the usual bound."""
        self._robot = robot
        low, high = robot.configuration_map.sampled_range()
        self.low, self.high = low - _MARGIN, high + _MARGIN
        self.usual = robot.kinematic_error_within(self.low, self.high)
        self._far: dict[bytes, float] = {}
        self.turning: tuple[int, ...] = tuple(np.flatnonzero(robot.configuration_map.turning_columns()).tolist())

    def are_usual(self, least: Floats, largest: Floats) -> bool:
        """Whether the usual bound holds on all motions, given by `Motions.ranges`."""
        return bool((least >= self.low).all() and (largest <= self.high).all())

    def of_ranges(self, least: Floats, largest: Floats) -> Callable[[Rows], list[tuple[float, Rows]]]:
        """A function that groups rows of motions, given by `Motions.ranges`, by their bound, m.

        A row's bound depends on the row only. Within the range around the limits it is the usual bound; else it is that
        of a range that reaches to the next powers of 2 in the columns that leave the usual range. It holds for the
        whole motion.
        """
        near = (least >= self.low) & (largest <= self.high)
        if near.all():
            return lambda rows: [(self.usual, rows)]
        furthest = np.maximum(-least, largest)
        powers = np.where(near, -1.0, np.ceil(np.log2(np.maximum(furthest, 1.0))))
        return lambda rows: self._by_powers(powers[rows], rows)

    def _by_powers(self, powers: Floats, rows: Rows) -> list[tuple[float, Rows]]:
        kinds, kind_of = distinct_rows(powers)
        return [(self._far_error(kind), rows[kind_of.ravel() == k]) for k, kind in enumerate(kinds)]

    def _far_error(self, powers: Floats) -> float:
        """The bound where columns (nq,) reach to powers of 2; -1 for columns within the usual range."""
        if (powers < 0).all():
            return self.usual
        key = powers.tobytes()
        if key not in self._far:
            reach = np.where(powers < 0, 0.0, 2.0**powers)
            low, high = np.minimum(self.low, -reach), np.maximum(self.high, reach)
            self._far[key] = self._robot.kinematic_error_within(low, high)
        return self._far[key]
