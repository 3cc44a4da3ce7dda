"""Dubins and Reeds-Shepp curves as OMPL interpolates them, taken apart into arcs and lines.

In: two poses of a robot's root. Out: `Curves.pieces`. On each piece the root goes straight or turns about a fixed
centre, in closed form; a bound says how far that is from OMPL's curve.

OMPL's bindings give a curve's length and single states, not its pieces. So a curve is cut into cells between states,
and a test decides whether a cell is of one kind. With lengths in turning radii, heading rates are -1, 0 or 1 and speed
is 1. If the heading changes by a cell's length d, and the displacement along the mean heading is 2 sin(d / 2), the cell
turns and drives one way all along, except for parts whose total length is about the rounding t. A cell with a
displacement of d along its first heading and 0 across it is straight: by construction no curve has two straight pieces,
nor, next to a straight piece, a second arc other than a quarter turn, so arcs at the cell's ends are shorter than about
2 t / d. A cell between two neighbours of known kinds is cut where these would meet.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from plannercheck.common.angles import nearest_turn
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.real_numbers import check_length
from plannercheck.planar.motion_sampling import MotionSampler
from plannercheck.planar.robot import Robot
from plannercheck.planar.spare_states import SpareStates

Curve: TypeAlias = Literal["straight", "dubins", "reeds_shepp"]
CURVES: tuple[Curve, ...] = ("straight", "dubins", "reeds_shepp")

# Rounding of OMPL's states in turning radii, per 1 + the coordinates' size + the length, both in turning radii: some
# ten operations of 2^-53 each.
_ROUNDING = 2.0**-48

# The last parameter at which OMPL interpolates; at 1 it gives the end itself.
_LAST = 1 - 2.0**-53

# The number of cells to begin with; curves have up to five pieces, but often one or two long ones (measured).
_FIRST_CELLS = 3

# Arcs are recognised up to this length, in turning radii: well below half a turn.
_LONGEST_ARC = 2.0

# A cell shorter than this, in turning radii, is not cut: no point moves in it by more than this part of lever plus
# radius.
_SHORTEST = 1e-7


def check_curve(robot: Robot, curve: Curve, turning_radius: float | None) -> None:
    """Raises an error if a robot's root can't follow such curves, or the turning radius does not fit."""
    if curve not in CURVES:
        raise unknown_name("curve", curve, CURVES)
    if curve != "straight" and not robot.is_free:
        raise PlannercheckError(f"the root of {robot.name!r} is fixed: it can't follow {curve} curves")
    if (curve == "straight") != (turning_radius is None):
        raise PlannercheckError(f"turning_radius goes with dubins and reeds_shepp curves, not with {curve!r} alone")
    if turning_radius is not None:
        check_length(turning_radius, "turning_radius")


class _Place(NamedTuple):
    """A state on a curve: parameter, position in m, heading in rad."""

    t: float
    x: float
    y: float
    heading: float


class _Kind(NamedTuple):
    """How a piece goes: heading rate (-1, 0, 1) and whether forwards (1) or backwards (-1)."""

    rate: int
    drive: int


class _Cell(NamedTuple):
    """A part of a curve between two states; `kind` is None if it is of several kinds."""

    start: _Place
    end: _Place
    kind: _Kind | None
    slip: float


class Curves:
    """Curves of one kind and turning radius."""

    def __init__(self, curve: Curve, turning_radius: float) -> None:
        """Makes OMPL's space of a curve, see `check_curve`, with a turning radius in m."""
        from ompl import base  # only curves need OMPL

        made = {"dubins": base.DubinsStateSpace, "reeds_shepp": base.ReedsSheppStateSpace}
        self._radius = float(turning_radius)
        self._space = made[curve](self._radius)
        self._spare = SpareStates(self._space, 3)  # start, end, and one between

    def way(self, start: Floats, end: Floats, sampler: MotionSampler) -> float:
        """A bound on how far any point of the robot travels on the curve between two configurations (nq,), m.

        A curve of length s turns the root by s / radius at most.
        """
        with self._spare.taken() as (first, last, _):
            _write(first, start)
            _write(last, end)
            length = float(self._space.distance(first, last))
        joints = end - start
        joints[:3] = 0
        return length * (1 + float(sampler.levers[2]) / self._radius) + float(sampler.way(joints[None])[0])

    def pieces(self, start: Floats, end: Floats, lever: float) -> Floats:
        """The pieces of the curve between two poses of the root.

        Args:
            start: x, y in m and heading in rad; further numbers are ignored.
            end: The same at the end.
            lever: No point of the robot is further than this from its root, m.

        Returns:
            (k, 11) as the core takes them. The last one is the end itself, which OMPL's curve meets up to 1e-6. The
            last column bounds a piece's distance from OMPL's curve, m: mostly below 1e-9; up to about 1e-5 if the curve
            has arcs shorter than 1e-6 of the radius. For such a piece the tolerance is raised to four times this bound.
        """
        with self._spare.taken() as states:
            first = _write(states[0], start)
            _write(states[1], end)
            length = float(self._space.distance(*states[:2])) / self._radius
            size = (abs(first.x) + abs(first.y) + abs(float(end[0])) + abs(float(end[1]))) / self._radius
            cells = _Cells(self._radius, lever, length, _ROUNDING * (1 + size + length))
            rows = [cells.row(cell) for cell in _cells(cells, partial(self._at, states), first, length)]
        rows.append((1.0, 1.0, float(end[0]), float(end[1]), 0.0, 0.0, float(end[2]), 0.0, 0.0, 0.0, 0.0))
        return np.array(rows)

    def _at(self, states: tuple[Any, ...], t: float) -> _Place:
        """The place at a parameter of the curve from states[0] to states[1]."""
        start, end, between = states
        self._space.interpolate(start, end, t, between)
        return _Place(t, between.getX(), between.getY(), between.getYaw())


def _cells(cells: _Cells, at: Callable[[float], _Place], first: _Place, length: float) -> list[_Cell]:
    """Cells of one kind each, except those too short to matter."""
    if length == 0:  # the root is at rest, but joints may move
        return [cells.cell(first, first._replace(t=_LAST))]
    places = [first, *(at(k / _FIRST_CELLS) for k in range(1, _FIRST_CELLS)), at(_LAST)]
    found = [cells.cell(a, b) for a, b in pairwise(places)]
    k = 0
    while k < len(found):
        cell = found[k]
        if cell.kind is not None or cells.length(cell.start, cell.end) <= _SHORTEST:
            k += 1
            continue
        before = found[k - 1].kind if k > 0 else None
        after = found[k + 1].kind if k + 1 < len(found) else None
        guess = cells.meeting(cell, before, after)
        halves = [] if guess is None else _cut(cells, cell, at(guess))
        if not halves or any(half.kind is None for half in halves):
            halves = _cut(cells, cell, at((cell.start.t + cell.end.t) / 2))  # so that it ends
        found[k : k + 1] = halves
    return _joined(cells, found)


def _cut(cells: _Cells, cell: _Cell, middle: _Place) -> list[_Cell]:
    return [cells.cell(cell.start, middle), cells.cell(middle, cell.end)]


def _write(state: Any, pose: Floats) -> _Place:
    x, y, heading = (float(value) for value in pose[:3])
    heading = nearest_turn(0.0, heading)
    state.setX(x)
    state.setY(y)
    state.setYaw(heading)
    return _Place(0.0, x, y, heading)


def _joined(cells: _Cells, found: list[_Cell]) -> list[_Cell]:
    """Joins neighbours of one kind to one cell, where the result is known to be of that kind."""
    joined = found[:1]
    for cell in found[1:]:
        last = joined[-1]
        both = cells.cell(last.start, cell.end) if cell.kind == last.kind else last
        if cell.kind is not None and cell.kind == both.kind == last.kind:
            joined[-1] = both
        else:
            joined.append(cell)
    return joined


class _Cells:
    """Tests and cuts cells of one curve."""

    def __init__(self, radius: float, lever: float, length: float, rounding: float) -> None:
        self._radius, self._lever, self._length, self._rounding = radius, lever, length, rounding

    def length(self, a: _Place, b: _Place) -> float:
        """The length of the curve between two states, in turning radii."""
        return (b.t - a.t) * self._length

    def _way(self, a: _Place, b: _Place, heading: float) -> tuple[float, float]:
        """The displacement between two states, along a heading and across it to the left, in turning radii."""
        x, y = (b.x - a.x) / self._radius, (b.y - a.y) / self._radius
        c, s = math.cos(heading), math.sin(heading)
        return x * c + y * s, y * c - x * s

    def cell(self, a: _Place, b: _Place) -> _Cell:
        """The cell between two states, with its kind."""
        d, t = self.length(a, b), self._rounding
        turn = math.remainder(b.heading - a.heading, 2 * math.pi)
        moved = self._radius + self._lever  # no point moves by more than this for a length of 1
        if abs(turn) <= t:
            along, across = self._way(a, b, a.heading)
            if abs(along) >= d - t and abs(across) <= t:
                # Arcs at the ends, of length c each, have a way across of c (d - c).
                turned = min(d / 2, 2 * t / max(d, t)) + 2 * t
                slip = turned * self._lever + 8 * t * self._radius
                return _Cell(a, b, _Kind(0, 1 if along > 0 else -1), slip)
        if d <= _LONGEST_ARC and abs(turn) >= d - t:
            rate = 1 if turn > 0 else -1
            along, _ = self._way(a, b, a.heading + rate * d / 2)
            if abs(along) >= 2 * math.sin(d / 2) - t:
                # Parts that turn or drive the other way are shorter than t / cos(d / 2).
                return _Cell(a, b, _Kind(rate, 1 if along > 0 else -1), 8 * t * moved * (1 + d))
        return _Cell(a, b, None, d * moved + 8 * t * self._radius)

    def meeting(self, cell: _Cell, before: _Kind | None, after: _Kind | None) -> float | None:
        """The parameter within a cell at which two kinds meet, if the cell consists of these two."""
        a, b, d = cell.start, cell.end, self.length(cell.start, cell.end)
        if before is None or after is None or before == after or d > _LONGEST_ARC:
            return None
        if before.rate != after.rate:
            turn = math.remainder(b.heading - a.heading, 2 * math.pi)
            part = (turn - after.rate * d) / (before.rate - after.rate)
        else:
            # Forwards and backwards: both half ways, and the whole way on the other side, are chords of the same
            # circle.
            along, across = self._way(a, b, a.heading)
            whole = math.sin(d), before.rate * (1 - math.cos(d))
            half = (whole[0] + before.drive * along) / 2, (whole[1] + before.drive * across) / 2
            part = 2 * math.asin(min(1.0, math.hypot(*half) / 2))
        t = a.t + (b.t - a.t) * part / d
        return t if a.t < t < b.t else None

    def row(self, cell: _Cell) -> tuple[float, ...]:
        """The cell as a piece for the core."""
        a, b, d = cell.start, cell.end, self.length(cell.start, cell.end)
        end = 1.0 if b.t == _LAST else b.t
        if cell.kind is None:
            return a.t, end, a.x, a.y, 0.0, 0.0, a.heading, 0.0, 0.0, 0.0, cell.slip
        rate, drive = cell.kind
        c, s = math.cos(a.heading), math.sin(a.heading)
        way = drive * d * self._radius
        if rate == 0:
            return a.t, end, a.x, a.y, way * c, way * s, a.heading, 0.0, 0.0, 0.0, cell.slip
        arm = -drive * rate * self._radius  # to the left of the heading, from the centre to the root
        return a.t, end, a.x + s * arm, a.y - c * arm, 0.0, 0.0, a.heading, rate * d, 0.0, arm, cell.slip
