"""The search for boxes of configurations around given ones that are proved free of collision.

In: a checker, configurations, the sides' proportions. Out: `FreeBoxes`. Idea: a tube around a motion that stands still
proves a box of configurations, by distances and lever arms; a larger box is covered by such boxes. The box grows in
proportion first, and then side by side, as long as a number of cells covers it. Many searches go on at once: each asks
whether one box is covered, and the cells of all these boxes are proved together.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Bools, Floats, Ints64
from plannercheck.common.arrays import named_numbers
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.whole_numbers import whole_number
from plannercheck.motions.certifier import MotionCertifier
from plannercheck.motions.free_boxes import FreeBoxes
from plannercheck.motions.joint_cells import are_free, halved, levers_at
from plannercheck.robots.robot import Robot

# The box in proportion is found to this part of itself; a side that grows by less stays.
_FINE = 1.05

# The least and the largest scale that is looked for.
_SMALLEST, _LARGEST = 1e-6, 16.0

# A side grows by the box's width there, or this often by half of what was tried.
_HALVINGS = 3

# About so many cells at most are in memory at once.
_CELLS_AT_ONCE = 200_000


class BoxChecker(Protocol):
    """The parts of a `Checker` that prove boxes."""

    @property
    def robot(self) -> Robot:
        """The robot."""

    def check_states(self, q: ArrayLike, threads: int = 1) -> Bools:
        """(n,) whether each configuration (n, nq) is free."""

    def body_poses(self, q: ArrayLike) -> Floats:
        """World poses of all bodies (n, bodies, 4, 4), m."""


class _Asked(NamedTuple):
    """A box that a search wants to be covered, (nq,) each, and by how many cells at most."""

    low: Floats
    high: Floats
    most: int


class _Found(NamedTuple):
    """A box that is covered, (nq,) each, and by how many cells; by none if nothing is proved."""

    low: Floats
    high: Floats
    cells: int


def search_boxes(
    checker: BoxChecker, certifier: MotionCertifier, q: Floats, shape: ArrayLike | None, cells: int, threads: int
) -> FreeBoxes:
    """Boxes around configurations (n, nq); the proportions of the sides and how many cells may cover each.

    Raises:
        PlannercheckError: If the proportions or the number are malformed, a configuration is beyond the limits, or the
            robot has unit vectors.
    """
    robot = checker.robot
    if robot.configuration_map.units:
        raise PlannercheckError("free boxes are of plain numbers: this robot's configurations have unit vectors")
    proportions = _proportions(robot, shape)
    cells = whole_number(cells, "cells must be a number of cells, 1 or more")
    _check_within_limits(robot, q)
    # Joints without limits: one turn, since all others are the same.
    lower = np.where(np.isinf(robot.lower), q - np.pi, robot.lower)
    upper = np.where(np.isinf(robot.upper), q + np.pi, robot.upper)
    found, together = list[_Found](), max(1, _CELLS_AT_ONCE // cells)
    for first in range(0, len(q), together):
        levers = np.array([levers_at(checker.body_poses, row) for row in q[first : first + together]])
        searches = [
            _Search(q[k], proportions, levers[k - first], (lower[k], upper[k]), cells).largest()
            for k in range(first, first + len(levers))
        ]
        found += _run(searches, levers, _Cover(checker, certifier, threads))
    lows, highs, counts = (np.array([box[k] for box in found]) for k in range(3))
    return FreeBoxes(lows.reshape(q.shape), highs.reshape(q.shape), counts.astype(np.int64))


def _proportions(robot: Robot, shape: ArrayLike | None) -> Floats:
    given = named_numbers(1.0 if shape is None else shape, "shape")
    if given.shape not in ((1,), (robot.nq,)) or not (np.isfinite(given) & (given > 0)).all():
        raise PlannercheckError(f"shape must be {robot.nq} positive numbers, or one")
    return np.broadcast_to(given / given.max(), (robot.nq,)).astype(np.float64)


def _check_within_limits(robot: Robot, q: Floats) -> None:
    beyond = (q < robot.lower) | (q > robot.upper)
    if not beyond.any():
        return
    row = int(beyond.any(axis=1).argmax())
    names = ", ".join(robot.joint_names[k] for k in np.flatnonzero(beyond[row]).tolist())
    raise PlannercheckError(
        f"{f'row {row}: ' if len(q) > 1 else ''}{names}: beyond the limits, within which boxes are: clip the "
        "configuration to them"
    )


def _run(searches: Sequence[Generator[_Asked, int, _Found]], levers: Floats, cover: _Cover) -> list[_Found]:
    """What searches find, all at once; their levers (n, nq)."""
    found = {}
    asked = {k: next(search) for k, search in enumerate(searches)}
    while asked:
        lows, highs, most = (np.array(column) for column in zip(*asked.values(), strict=True))
        counts = cover.counts(lows, highs, most, levers[list(asked)])
        for k, count in zip(list(asked), counts.tolist(), strict=True):
            try:
                asked[k] = searches[k].send(count)
            except StopIteration as end:
                found[k] = end.value
                del asked[k]
    return [found[k] for k in range(len(searches))]


class _Search:
    """The search around one configuration: asks for boxes to be covered, and is sent by how many cells they are."""

    def __init__(
        self, q: Floats, proportions: Floats, levers: Floats, limits: tuple[Floats, Floats], cells: int
    ) -> None:
        """Takes a configuration (nq,), the proportions of the sides, how far each number moves bodies, and limits."""
        self._q, self._shape, self._levers, self._most = q, proportions, levers, cells
        self._lower, self._upper = limits

    def largest(self) -> Generator[_Asked, int, _Found]:
        """The box that is free."""
        scale, cells = yield from self._largest_scale()
        if cells == 0:
            nothing = np.full(len(self._q), np.nan)
            return _Found(nothing, nothing, 0)
        return (yield from self._grown(*self._scaled(scale), cells))

    def _scaled(self, scale: float) -> tuple[Floats, Floats]:
        return self._clipped(self._q - scale * self._shape, self._q + scale * self._shape)

    def _largest_scale(self) -> Generator[_Asked, int, tuple[float, int]]:
        """The largest scale whose box is covered, and by how many cells."""
        known, cells, failed = 0.0, 0, _LARGEST
        scale = _SMALLEST
        while scale < failed:
            found = yield _Asked(*self._scaled(scale), self._most)
            if found:
                known, cells = scale, found
            else:
                failed = scale
            if failed < known * _FINE:
                break
            scale = 2 * known if failed == _LARGEST else np.sqrt(known * failed) if known > 0 else failed
        return known, cells

    def _grown(self, low: Floats, high: Floats, cells: int) -> Generator[_Asked, int, _Found]:
        """Moves one side after the other out, the ones that turn least first, until none moves by much."""
        order = np.argsort(self._levers * self._shape)
        moved = True
        while moved:
            moved = False
            for k in order.tolist():
                for side in (low, high):
                    before = side[k]
                    cells += yield from self._move_side(low, high, side, k, self._most - cells)
                    moved |= abs(side[k] - before) > (_FINE - 1) * (high[k] - low[k])
        return _Found(low, high, cells)

    def _move_side(self, low: Floats, high: Floats, side: Floats, k: int, most: int) -> Generator[_Asked, int, int]:
        """Moves a side out as far as a slab beside the box is covered; returns by how many cells."""
        width = (high[k] - low[k]) * (1 if side is high else -1)
        for halving in range(_HALVINGS):
            inner, outer = low.copy(), high.copy()
            beyond = side[k] + width / 2**halving
            inner[k], outer[k] = sorted((side[k], beyond))
            inner, outer = self._clipped(inner, outer)
            if outer[k] <= inner[k]:
                return 0
            found = yield _Asked(inner, outer, most)
            if found:
                side[k] = outer[k] if side is high else inner[k]
                return found
        return 0

    def _clipped(self, low: Floats, high: Floats) -> tuple[Floats, Floats]:
        return np.maximum(low, self._lower), np.minimum(high, self._upper)


class _Cover:
    """Covers boxes by cells that are proved free."""

    def __init__(self, checker: BoxChecker, certifier: MotionCertifier, threads: int) -> None:
        self._checker, self._certifier, self._threads = checker, certifier, threads

    def counts(self, lows: Floats, highs: Floats, most: Ints64, levers: Floats) -> Ints64:
        """(n,) by how many cells boxes (n, nq) are proved free, 0 if by no more than `most` (n,); levers (n, nq)."""
        proved = np.zeros(len(lows), dtype=np.int64)
        boxes = np.flatnonzero(most > 0)  # whose the cells are
        lows, highs = lows[boxes], highs[boxes]
        while len(boxes):
            is_open = ~are_free(self._certifier, lows, highs, self._threads)
            proved += np.bincount(boxes[~is_open], minlength=len(proved))
            lows, highs, boxes = lows[is_open], highs[is_open], boxes[is_open]
            given_up = proved + 2 * np.bincount(boxes, minlength=len(proved)) > most
            given_up[boxes[~self._checker.check_states((lows + highs) / 2, self._threads)]] = True
            proved[given_up] = 0
            kept = ~given_up[boxes]
            boxes = boxes[kept]
            lows, highs = halved(lows[kept], highs[kept], levers[boxes])
            boxes = np.concatenate([boxes, boxes])
        return proved
