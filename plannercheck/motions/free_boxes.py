"""Boxes of configurations around a configuration that are proved free of collision.

In: a checker, a configuration, the sides' proportions. Out: a `FreeBox`: every configuration in it is free. Idea: a
tube around a motion that stands still proves a box of configurations, by distances and lever arms; a larger box is
covered by such boxes. The box grows in proportion first, and then side by side, as long as a number of cells covers it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.arrays import OwnsArrays, named_numbers
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module
from plannercheck.motions.certifier import MotionCertifier
from plannercheck.motions.joint_cells import are_free, halved, levers_at
from plannercheck.robots.robot import Robot

# The box in proportion is found to this part of itself; a side that grows by less stays.
_FINE = 1.05

# The least and the largest scale that is looked for.
_SMALLEST, _LARGEST = 1e-6, 16.0

# A side grows by the box's width there, or this often by half of what was tried.
_HALVINGS = 3


@set_module("plannercheck")
@dataclass(frozen=True, eq=False)
class FreeBox(OwnsArrays):
    """A box of configurations, all proved free.

    Attributes:
        lower: (nq,) the least of each number, rad and m.
        upper: (nq,) the largest.
        cells: How many boxes, each proved by one distance a pair, cover it.
    """

    lower: Floats
    upper: Floats
    cells: int

    @property
    def volume(self) -> float:
        """The product of its widths, in rad and m."""
        return float(np.prod(self.upper - self.lower))

    def half_spaces(self) -> tuple[Floats, Floats]:
        """(A, b), (2 nq, nq) and (2 nq,): the box is {q : A q <= b}, as drake's HPolyhedron takes it."""
        eye = np.eye(len(self.lower))
        return np.concatenate([eye, -eye]), np.concatenate([self.upper, -self.lower])


class BoxChecker(Protocol):
    """The parts of a `Checker` that prove boxes."""

    @property
    def robot(self) -> Robot:
        """The robot."""

    def check_states(self, q: ArrayLike) -> Bools:
        """(n,) whether each configuration (n, nq) is free."""

    def body_poses(self, q: ArrayLike) -> Floats:
        """World poses of all bodies (n, bodies, 4, 4), m."""


class FreeBoxes:
    """Finds a box around one configuration for one checker."""

    def __init__(
        self, checker: BoxChecker, certifier: MotionCertifier, q: Floats, shape: ArrayLike | None, cells: int
    ) -> None:
        """Takes a configuration (nq,), the proportions of the sides, (nq,) rad and m, and how many cells may cover it.

        Raises:
            PlannercheckError: If the proportions or the number are malformed, the configuration is beyond the limits,
                or the robot has unit vectors.
        """
        robot = checker.robot
        if robot.configuration_map.units:
            raise PlannercheckError("free boxes are of plain numbers: this robot's configurations have unit vectors")
        given = named_numbers(1.0 if shape is None else shape, "shape")
        if given.shape not in ((1,), (robot.nq,)) or not (np.isfinite(given) & (given > 0)).all():
            raise PlannercheckError(f"shape must be {robot.nq} positive numbers, or one")
        if isinstance(cells, bool) or not isinstance(cells, int) or cells < 1:
            raise PlannercheckError(f"cells must be a number of cells, 1 or more, not {cells!r}")
        self._checker, self._certifier, self._most = checker, certifier, cells
        self._shape = np.broadcast_to(given / given.max(), (robot.nq,)).astype(np.float64)
        beyond = np.flatnonzero((q < robot.lower) | (q > robot.upper)).tolist()
        if beyond:
            names = ", ".join(robot.joint_names[k] for k in beyond)
            raise PlannercheckError(
                f"{names}: beyond the limits, within which boxes are: clip the configuration to them"
            )
        self._q, self._levers = q, levers_at(checker.body_poses, q)
        # Of joints without limits, one turn: all others are the same.
        self._lower = np.where(np.isinf(robot.lower), q - np.pi, robot.lower)
        self._upper = np.where(np.isinf(robot.upper), q + np.pi, robot.upper)

    def largest(self) -> FreeBox | None:
        """The box that is free; None if nothing around the configuration is proved free."""
        scale, cells = self._largest_scale()
        return None if scale == 0 else self._grown(*self._scaled(scale), cells)

    def _scaled(self, scale: float) -> tuple[Floats, Floats]:
        return self._clipped(self._q - scale * self._shape, self._q + scale * self._shape)

    def _largest_scale(self) -> tuple[float, int]:
        """The largest scale whose box is covered, and by how many cells."""
        known, cells, failed = 0.0, 0, _LARGEST
        scale = _SMALLEST
        while scale < failed:
            found = self._cover(*self._scaled(scale), self._most)
            if found is None:
                failed = scale
            else:
                known, cells = scale, found
            if failed < known * _FINE:
                break
            scale = 2 * known if failed == _LARGEST else np.sqrt(known * failed) if known > 0 else failed
        return known, cells

    def _grown(self, low: Floats, high: Floats, cells: int) -> FreeBox:
        """Moves one side after the other out, the ones that turn least first, until none moves by much."""
        order = np.argsort(self._levers * self._shape)
        moved = True
        while moved:
            moved = False
            for k in order.tolist():
                for side in (low, high):
                    before = side[k]
                    cells += self._move_side(low, high, side, k, self._most - cells)
                    moved |= abs(side[k] - before) > (_FINE - 1) * (high[k] - low[k])
        return FreeBox(low, high, cells)

    def _move_side(self, low: Floats, high: Floats, side: Floats, k: int, most: int) -> int:
        """Moves a side out as far as a slab beside the box is covered; returns by how many cells."""
        width = (high[k] - low[k]) * (1 if side is high else -1)
        for halving in range(_HALVINGS):
            inner, outer = low.copy(), high.copy()
            beyond = side[k] + width / 2**halving
            inner[k], outer[k] = sorted((side[k], beyond))
            inner, outer = self._clipped(inner, outer)
            if outer[k] <= inner[k]:
                return 0
            found = self._cover(inner, outer, most)
            if found is not None:
                side[k] = outer[k] if side is high else inner[k]
                return found
        return 0

    def _cover(self, low: Floats, high: Floats, most: int) -> int | None:
        """By how many cells a box is proved free, None if by no more than `most`."""
        lows, highs, proved = low[None], high[None], 0
        while len(lows):
            if proved + len(lows) > most:
                return None
            open_ones = ~are_free(self._certifier, lows, highs)
            proved += int(len(lows) - open_ones.sum())
            lows, highs = lows[open_ones], highs[open_ones]
            if len(lows) and not self._checker.check_states((lows + highs) / 2).all():
                return None
            lows, highs = halved(lows, highs, self._levers)
        return proved

    def _clipped(self, low: Floats, high: Floats) -> tuple[Floats, Floats]:
        return np.maximum(low, self._lower), np.minimum(high, self._upper)
