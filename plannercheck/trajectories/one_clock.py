"""Trajectories of several robots on one clock: one trajectory of the cell.

In: a cell, a trajectory or a configuration for each robot of its group, and when each trajectory starts. Out: a
`Trajectory` of the cell, whose pieces are cut at the knots of all of them.

`Curve.error` of what comes out bounds, for each column, how far it is at any instant of the clock from the polynomials
that the robot's own message defines:

- Instants. A knot on the clock is a double, and knots within a nanosecond of each other are one, so each piece runs up
  to τ earlier or later than it should, which moves a number by at most τ times its largest speed; three times that is
  counted, so that verifiers find moving objects where the scene has them.
- Cutting. Pieces are cut by polar forms and raised to higher degrees: averages of control points (`blossom_error`).
- Unit vectors are cut by slerp. As everywhere, their error is stated, and larger ones than 1e-10 are refused.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.sizes import array_of
from plannercheck.common.array_types import Bools, Floats, Ints64
from plannercheck.common.arrays import contiguous, distinct, read_only
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.shown_times import shown_seconds
from plannercheck.robots.robot import CellPart, Robot
from plannercheck.trajectories.curve import Curve, slerp
from plannercheck.trajectories.joint_columns import check_order
from plannercheck.trajectories.rounding import UNIT, blossom_error
from plannercheck.trajectories.stamps import durations
from plannercheck.trajectories.trajectory import MOST_OFF, Trajectory

# What a robot does: its trajectory, or the configuration (k,) at which it stands.
Run: TypeAlias = Trajectory | ArrayLike

# Knots nearer to each other than this are one, s: no piece may be shorter.
_SAME_KNOT = 0.9e-9

# Steps of what moves are compared with the scene's own ones, extended to a knot that has become another: verifiers
# bound the difference by so many times what the shift moves a number (proofs/scene_clocks.py).
_COMPARED = 3

# Roundings of a knot, of the share of a piece, and of a duration, in u of the largest time.
_TIMES = 8

# Curves of which the largest speeds are kept: those of what moves in a scene are asked for with every trajectory.
_KEPT = 64

# Roundings of a slerp's numbers, in u: of lengths, the angle, sines and cosines, and sums.
_SLERPED = 64


class Clocked(NamedTuple):
    """A curve on the clock.

    Attributes:
        curve: Its polynomials.
        knots: Its breaks on the clock before they are rounded to common ones, s.
    """

    curve: Curve
    knots: Floats


class _Cuts(NamedTuple):
    """Which parts of a robot's curve the pieces of the clock are.

    Attributes:
        piece: (m,) the robot's piece; -1 before it starts, and the count of its pieces after its end.
        start: (m,) from 0 to 1, where on the piece.
        end: (m,) likewise.
    """

    piece: Ints64
    start: Floats
    end: Floats

    @property
    def are_cut(self) -> Bools:
        """(m,) whether each is less than a piece of the robot."""
        return np.asarray((self.start > 0) | (self.end < 1))


def on_one_clock(
    cell: Robot, trajectories: Mapping[str, Run], starts: Mapping[str, float] | None = None, knots: ArrayLike = ()
) -> Trajectory:
    """The trajectory of a cell whose robots run their own, each from its start on.

    Before its first point a robot stands at it, and after its last point at that.

    Args:
        cell: What `Robot.together` gives.
        trajectories: By robot, of all robots that the group moves; or the configuration (k,) at which a robot stands.
        starts: By robot, when its trajectory's own 0 s is on the clock, s; 0 if not named.
        knots: (m,) s, of at least 0: where pieces are cut as well; the clock runs to the last one at least.

    Returns:
        A trajectory from 0 s to the end of the longest; its error covers all rounding.

    Raises:
        PlannercheckError: For unknown robots, missing ones, other widths, or a start before 0 s.
    """
    check_runs(cell, trajectories)
    begins = checked_starts(cell, trajectories, starts)
    clocked = {
        name: _clocked(cell.parts[name], run, begins.get(name, 0.0))
        for name, run in trajectories.items()
        if isinstance(run, Trajectory)
    }
    listed = [contiguous(knots).ravel(), *(each.knots for each in clocked.values())]
    breaks = _common_knots(np.concatenate(listed), 0.0)
    cuts = {name: _cuts(each, breaks) for name, each in clocked.items()}
    degrees = np.max([_degrees(clocked[name].curve, cuts[name]) for name in clocked], axis=0)
    shape, error = (len(degrees), int(degrees.max()) + 1, cell.nq), np.zeros(cell.nq)
    points = np.empty(shape)
    for name, run in trajectories.items():
        columns = cell.parts[name].columns
        if isinstance(run, Trajectory):
            each = clocked[name]
            points[:, :, columns] = _cut_points(each.curve, cuts[name], degrees)
            error[columns] = _error(each, cuts[name], breaks, int(degrees.max()))
        else:
            points[:, :, columns] = standing(cell.parts[name], run)
    pieces = tuple(each[: degree + 1] for each, degree in zip(read_only(points), degrees.tolist(), strict=True))
    return Trajectory.of_curve(Curve(breaks, pieces, error, cell.configuration_map.units))


def side_by_side(clocked: Sequence[Clocked], begin: float, end: float) -> Curve:
    """Curves as one curve from begin to end, s of the clock: the columns of the first, then of the second, and so on.

    Each stands still before its first knot and after its last one; the first has knots at begin and end.
    """
    knots = np.concatenate([each.knots for each in clocked])
    breaks = _common_knots(knots[(knots >= begin) & (knots <= end)], begin)
    cuts = [_cuts(each, breaks) for each in clocked]
    degrees = np.max([_degrees(each.curve, cut) for each, cut in zip(clocked, cuts, strict=True)], axis=0)
    both = list(zip(clocked, cuts, strict=True))
    points = np.concatenate([_cut_points(each.curve, cut, degrees) for each, cut in both], axis=2)
    error = np.concatenate([_error(each, cut, breaks, int(degrees.max())) for each, cut in both])
    shifts = np.cumsum([0, *(each.curve.nq for each in clocked)]).tolist()
    units = tuple((a + by, b + by) for each, by in zip(clocked, shifts, strict=False) for a, b in each.curve.units)
    pieces = tuple(each[: degree + 1] for each, degree in zip(read_only(points), degrees.tolist(), strict=True))
    return Curve(breaks, pieces, error, units)


def check_runs(cell: Robot, runs: Mapping[str, Run]) -> tuple[str, ...]:
    """The robots that move, in the cell's order; raises unless each robot of the cell's group has what it does."""
    if not isinstance(cell, Robot) or not cell.parts:
        raise PlannercheckError("several robots on one clock are a cell: see pc.Robot.together")
    if not isinstance(runs, Mapping):
        raise PlannercheckError(f"trajectories are given by robot, {{'left': trajectory, …}}, not {runs!r:.80}")
    group = [name for name, part in cell.parts.items() if len(part.columns)]
    for name in runs:
        if name not in group:
            raise unknown_name("robot of the cell's group", name, group)
    missing = [name for name in group if name not in runs]
    if missing:
        raise PlannercheckError(
            f"no trajectory of {', '.join(missing)}: give one, or the configuration at which the robot stands"
        )
    for name, run in runs.items():
        if isinstance(run, Trajectory):
            _check_columns(cell.parts[name], run)
    moving = tuple(name for name in group if isinstance(runs[name], Trajectory))
    if not moving:
        raise PlannercheckError("no robot moves: give a pc.Trajectory; check_states judges robots that stand")
    return moving


def _check_columns(part: CellPart, trajectory: Trajectory) -> None:
    curve = trajectory.curve
    if curve.nq != len(part.columns):
        raise PlannercheckError(
            f"the trajectory of {part.name!r} has {curve.nq} columns, but the robot has {len(part.columns)} in the"
            f" cell's group: {', '.join(part.joint_names)}"
        )
    if curve.units != part.robot.configuration_map.units:
        raise PlannercheckError(
            f"columns of {part.name!r} form unit vectors, which turn by slerp: give"
            f" trajectory.of_robot(cell.parts[{part.name!r}].robot)"
        )
    with error_context(f"trajectory of {part.name!r}"):
        check_order(part.robot, trajectory.points, f"{part.name}/")


def checked_starts(cell: Robot, runs: Mapping[str, Run], starts: Mapping[str, float] | None) -> dict[str, float]:
    """When each trajectory starts, s, by the robots that are named."""
    if starts is not None and not isinstance(starts, Mapping):
        raise PlannercheckError(f"starts are given by robot, {{'right': 1.5}}, not {starts!r:.80}")
    found = {}
    for name, given in (starts or {}).items():
        if name not in runs:
            raise unknown_name("robot with a start", name, runs)
        if not isinstance(runs[name], Trajectory):
            raise PlannercheckError(f"robot {name!r} stands, so it has no start")
        found[name] = start_time(given, f"the start of {name!r}")
    return found


def start_time(given: float, what: str) -> float:
    """A time of at least 0 s, or an error."""
    time = array_of(given, what)
    if time.ndim or not 0 <= time < np.inf:
        raise PlannercheckError(f"{what} must be a time of at least 0 s, not {given!r:.80}")
    return float(time)


def standing(part: CellPart, configuration: ArrayLike) -> Floats:
    """(k,) where a robot stands, checked."""
    row = part.checked(configuration)
    if row.ndim != 1:
        raise PlannercheckError(
            f"robot {part.name!r} has a pc.Trajectory or one configuration ({len(part.columns)},), not {row.shape}"
        )
    return row


def _clocked(part: CellPart, run: Trajectory, start: float) -> Clocked:
    knots = run.curve.breaks + start
    if knots[0] < 0:
        raise PlannercheckError(
            f"the trajectory of {part.name!r} begins at {shown_seconds(knots[0])} s, before the clock: give it a start"
            f" of at least {shown_seconds(-run.curve.breaks[0])} s"
        )
    return Clocked(run.curve, knots)


def _common_knots(knots: Floats, begin: float) -> Floats:
    """Knots in ascending order from a first one, s, those nearer than a nanosecond once: no curve has two of these."""
    kept = [begin]
    for knot in np.sort(knots).tolist():
        if knot - kept[-1] >= _SAME_KNOT:  # at late times the sum of both would be rounded to the first
            kept.append(knot)
    return np.array(kept)


def _rounded(knots: Floats, breaks: Floats) -> Floats:
    """The common knot that each of a curve's knots became: the last one that is not later; others stay."""
    places = np.searchsorted(breaks, knots, side="right") - 1
    return np.where((places < 0) | (knots > breaks[-1] + _SAME_KNOT), knots, breaks[places])


def _cuts(clocked: Clocked, breaks: Floats) -> _Cuts:
    own = _rounded(clocked.knots, breaks)
    if not (np.diff(own) > 0).all():
        raise PlannercheckError("a piece of a trajectory takes less than a nanosecond on the clock: start earlier")
    piece = np.searchsorted(own, breaks[:-1], side="right") - 1
    inside = (piece >= 0) & (piece < len(own) - 1)
    low, high = own[np.where(inside, piece, 0)], own[np.where(inside, piece, 0) + 1]
    start, end = ((where - low) / (high - low) for where in (breaks[:-1], breaks[1:]))
    return _Cuts(piece, np.where(inside, start, 0.0), np.where(inside, end, 1.0))


def _degrees(curve: Curve, cuts: _Cuts) -> Ints64:
    """(m,) of the pieces of the clock; a robot that stands has degree 1."""
    return np.concatenate([[1], curve.counts - 1, [1]])[cuts.piece + 1]


def _cut_points(curve: Curve, cuts: _Cuts, degrees: Ints64) -> Floats:
    """(m, highest degree + 1, k) control points of the pieces of the clock, by the first degrees[i] + 1 rows."""
    points = np.empty((len(degrees), int(degrees.max()) + 1, curve.nq))
    points[:], points[cuts.piece >= len(curve.pieces)] = curve.pieces[0][0], curve.pieces[-1][-1]
    moves, is_cut = np.flatnonzero((cuts.piece >= 0) & (cuts.piece < len(curve.pieces))), cuts.are_cut
    for some, own in curve.points_of(cuts.piece[moves]):
        rows = moves[some]
        if is_cut[rows].any():
            own = _part(own, cuts.start[rows], cuts.end[rows])
        for degree in distinct(degrees[rows]).tolist():
            alike = degrees[rows] == degree
            points[rows[alike], : degree + 1] = _raised(own[alike], degree)
    for a, b in curve.units:
        _cut_units(points[:, :, a:b], curve.ends[:, :, a:b], cuts, degrees)
    return points


def _part(control: Floats, start: Floats, end: Floats) -> Floats:
    """Control points (m, degree + 1, k) of parts of polynomials, from `start` (m,) to `end`: their polar forms."""
    count = control.shape[1]
    points = np.repeat(control[:, None], count, axis=1)
    for k in range(count - 1):
        at = np.where(np.arange(count) > k, end[:, None], start[:, None])[:, :, None, None]
        points = points[:, :, :-1] * (1 - at) + points[:, :, 1:] * at
    return np.asarray(points[:, :, 0])


def _raised(control: Floats, degree: int) -> Floats:
    """The same polynomials (m, degree + 1, k) by more control points."""
    while control.shape[1] <= degree:
        count = control.shape[1]
        share = (np.arange(1, count) / count)[None, :, None]
        inner = control[:, :-1] * share + control[:, 1:] * (1 - share)
        control = np.concatenate([control[:, :1], inner, control[:, -1:]], axis=1)
    return control


def _cut_units(points: Floats, ends: Floats, cuts: _Cuts, degrees: Ints64) -> None:
    """Sets the unit vectors of pieces: from their place on the slerp between `ends` (pieces, 2, 2 or 4) to the next.

    A place is computed once for the piece that ends there and the piece that begins there, so that they meet.
    """
    own = np.concatenate([ends[:1, [0, 0]], ends, ends[-1:, [1, 1]]])[cuts.piece + 1]
    first, last = own[:, 0].copy(), own[:, 1].copy()
    after, before = np.flatnonzero(cuts.start > 0), np.flatnonzero(cuts.end < 1)
    first[after] = slerp(own[after, 0], own[after, 1], cuts.start[after, None], 0)
    if len(before) and before[-1] == len(own) - 1:
        last[-1:] = slerp(own[-1:, 0], own[-1:, 1], cuts.end[-1:, None], 0)
        before = before[:-1]
    last[before] = first[before + 1]
    points[:] = first[:, None]
    points[np.arange(len(own)), degrees] = last


def _error(clocked: Clocked, cuts: _Cuts, breaks: Floats, degree: int) -> Floats:
    """(k,) how far a robot's columns are at most from its message's own polynomials at any instant of the clock."""
    curve, knots = clocked
    late = np.abs(_rounded(knots, breaks) - knots).max()
    largest = max(float(np.abs(each).max()) for each in (breaks, curve.breaks, knots))
    times = np.full(curve.nq, _COMPARED)
    for a, b in curve.units:  # compared at the ends of pieces, without a tube
        times[a:b] = 1
    shift = (times * late + _TIMES * UNIT * largest) * (1 + 2.0**-40)
    error = (curve.error + shift * _largest_speeds(curve)) * (1 + 2.0**-40)
    is_cut, degrees = cuts.are_cut.any(), curve.counts - 1
    steps = (int(degrees.max()) if is_cut else 0) + degree - int(degrees.min())
    error = error + blossom_error(np.concatenate(curve.pieces), steps)
    for a, b in curve.units:
        if is_cut:
            error[a:b] += _SLERPED * UNIT * _largest_condition(curve, a, b)
        if float(error[a:b].max()) > MOST_OFF:
            raise PlannercheckError(
                f"columns {a} to {b - 1} of a robot form a unit vector, which is off by up to {error[a:b].max():.3g} on"
                " the clock: give pieces that are not as short, and times that are not as late"
            )
    return np.asarray(error)


@lru_cache(maxsize=_KEPT)
def _largest_speeds(curve: Curve) -> Floats:
    """(nq,) of all pieces, rad/s and m/s."""
    return read_only(speeds(curve)[1].max(axis=0))


@lru_cache(maxsize=_KEPT)
def _largest_condition(curve: Curve, first: int, past: int) -> float:
    """By how much the rounding of a slerp grows: near half a turn of a cosine and sine, sideways is hardly known."""
    angles = _turns(curve.ends[:, :, first:past])
    return float(np.where(angles <= 2.0, 1.0, 1 / np.maximum(np.sin(angles), 2.0**-53)).max())


def _turns(ends: Floats) -> Floats:
    """(m,) rad, the turns of unit vectors between `ends` (m, 2, 2 or 4)."""
    return np.asarray(np.linalg.norm(slerp(ends[:, 0], ends[:, 1], np.zeros((1, 1)), 1), axis=1))


def speeds(curve: Curve, parts: int = 1) -> tuple[Floats, Floats]:
    """Where parts of pieces begin and end, (m + 1,) s, and the largest speed of each number there, from above, (m, nq).

    A piece is looked at in so many parts at most, none shorter than this part of an average piece. Rad/s and m/s.
    """
    steps = durations(curve.breaks)
    counts = np.clip(np.rint(parts * steps * len(steps) / steps.sum()), 1, parts).astype(np.int64)
    owners, ends = np.repeat(np.arange(len(steps)), counts), np.cumsum(counts)
    place = np.arange(len(owners)) - (ends - counts)[owners]
    start, end = place / counts[owners], (place + 1) / counts[owners]
    spans = (steps / counts)[owners, None]
    found = np.empty((len(owners), curve.nq))
    for rows, own in curve.points_of(owners):
        degree = own.shape[1] - 1
        cut, off = _part(own, start[rows], end[rows]) if parts > 1 else own, blossom_error(own, degree)
        found[rows] = (np.abs(np.diff(cut, axis=1)).max(axis=1) + 2 * off) * (degree / spans[rows])
    for a, b in curve.units:
        found[:, a:b] = (_turns(curve.ends[:, :, a:b]) / steps)[owners, None]
    return np.append(curve.breaks[0], curve.breaks[owners] + steps[owners] * end), found * (1 + 2.0**-40)
