"""Trajectories of several robots on one clock: one trajectory of the cell.

In: a cell, a trajectory or a configuration for each robot of its group, and when each trajectory starts. Out: a
`Trajectory` of the cell, whose pieces are cut at the knots of all of them.

`Curve.error` of what comes out bounds, for each column, how far it is at any instant of the clock from the polynomials
that the robot's own message defines:

- Instants. A knot on the clock is a double, and knots within a nanosecond of each other are one, so each piece runs up
  to τ earlier or later than it should, which moves a number by at most τ times its largest speed.
- Cutting. Pieces are cut by polar forms and raised to higher degrees: averages of control points (`blossom_error`).
- Unit vectors are cut by slerp. As everywhere, their error is stated, and larger ones than 1e-10 are refused.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.sizes import array_of
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import contiguous
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.robots.robot import CellPart, Robot
from plannercheck.trajectories.curve import Curve, slerp
from plannercheck.trajectories.rounding import UNIT, blossom_error
from plannercheck.trajectories.stamps import durations
from plannercheck.trajectories.trajectory import MOST_OFF, Trajectory

# What a robot does: its trajectory, or the configuration (k,) at which it stands.
Run: TypeAlias = Trajectory | ArrayLike

# Knots nearer to each other than this are one, s: no piece may be shorter.
_SAME_KNOT = 0.9e-9

# Roundings of a knot, of the share of a piece, and of a duration, in u of the largest time.
_TIMES = 8

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
    pieces = tuple(each[: degree + 1] for each, degree in zip(points, degrees.tolist(), strict=True))
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
    pieces = tuple(each[: degree + 1] for each, degree in zip(points, degrees.tolist(), strict=True))
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
            f"the trajectory of {part.name!r} begins at {knots[0]:g} s, before the clock: give it a start of at least"
            f" {-run.curve.breaks[0]:g} s"
        )
    return Clocked(run.curve, knots)


def _common_knots(knots: Floats, begin: float) -> Floats:
    """Knots in ascending order from a first one, s, those nearer than a nanosecond once: no curve has two of these."""
    kept = [begin]
    for knot in np.sort(knots).tolist():
        if knot >= kept[-1] + _SAME_KNOT:
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
    own = np.array([1, *(len(piece) - 1 for piece in curve.pieces), 1])
    return np.asarray(own[cuts.piece + 1])


def _cut_points(curve: Curve, cuts: _Cuts, degrees: Ints64) -> Floats:
    """(m, highest degree + 1, k) control points of the pieces of the clock, by the first degrees[i] + 1 rows."""
    first, last = curve.pieces[0][:1], curve.pieces[-1][-1:]
    own = [np.repeat(first, 2, axis=0), *curve.pieces, np.repeat(last, 2, axis=0)]
    counts = _degrees(curve, cuts)
    points = np.zeros((len(degrees), int(degrees.max()) + 1, curve.nq))
    for count, degree in {*zip(counts.tolist(), degrees.tolist(), strict=True)}:
        rows = np.flatnonzero((counts == count) & (degrees == degree))
        control = np.array([own[k + 1] for k in cuts.piece[rows].tolist()])
        points[rows, : degree + 1] = _raised(_part(control, cuts.start[rows], cuts.end[rows]), degree)
    for a, b in curve.units:
        ends = np.array([piece[[0, -1], a:b] for piece in own])[cuts.piece + 1]
        _cut_units(points[:, :, a:b], ends, cuts, degrees)
    return points


def _part(control: Floats, start: Floats, end: Floats) -> Floats:
    """Control points (m, degree + 1, k) of parts of polynomials, from `start` (m,) to `end`: their polar forms."""
    degree = control.shape[1] - 1
    out = np.empty_like(control)
    for j in range(degree + 1):
        points = control
        for k in range(degree):
            at = (end if k < j else start)[:, None, None]
            points = points[:, :-1] * (1 - at) + points[:, 1:] * at
        out[:, j] = points[:, 0]
    return out


def _raised(control: Floats, degree: int) -> Floats:
    """The same polynomials (m, degree + 1, k) by more control points."""
    while control.shape[1] <= degree:
        count = control.shape[1]
        share = (np.arange(1, count) / count)[None, :, None]
        inner = control[:, :-1] * share + control[:, 1:] * (1 - share)
        control = np.concatenate([control[:, :1], inner, control[:, -1:]], axis=1)
    return control


def _cut_units(points: Floats, ends: Floats, cuts: _Cuts, degrees: Ints64) -> None:
    """Sets the unit vectors of pieces: from their place on the slerp between `ends` (m, 2, 2 or 4) to the next one.

    A place is computed once for the piece that ends there and the piece that begins there, so that they meet.
    """
    for k, (a, b) in enumerate(ends):
        s = np.array([cuts.start[k], cuts.end[k]])
        first, last = slerp(a, b, s, 0)
        points[k] = a if s[0] == 0.0 else first
        points[k, degrees[k]] = b if s[1] == 1.0 else last


def _error(clocked: Clocked, cuts: _Cuts, breaks: Floats, degree: int) -> Floats:
    """(k,) how far a robot's columns are at most from its message's own polynomials at any instant of the clock."""
    curve, knots = clocked
    late = np.abs(_rounded(knots, breaks) - knots).max()
    largest = max(float(np.abs(breaks).max()), float(np.abs(curve.breaks).max()), float(np.abs(knots).max()))
    shift = (late + _TIMES * UNIT * largest) * (1 + 2.0**-40)
    error = (curve.error + shift * speeds(curve)[1].max(axis=0)) * (1 + 2.0**-40)
    is_cut = (cuts.start > 0) | (cuts.end < 1)
    highest = max(len(piece) - 1 for piece in curve.pieces)
    steps = (highest if is_cut.any() else 0) + degree - min(len(piece) - 1 for piece in curve.pieces)
    error = error + np.max([blossom_error(piece, steps) for piece in curve.pieces], axis=0)
    for a, b in curve.units:
        if is_cut.any():
            error[a:b] += _SLERPED * UNIT * max(_condition(piece[0, a:b], piece[-1, a:b]) for piece in curve.pieces)
        if float(error[a:b].max()) > MOST_OFF:
            raise PlannercheckError(
                f"columns {a} to {b - 1} of a robot form a unit vector, which is off by up to {error[a:b].max():.3g} on"
                " the clock: give pieces that are not as short, and times that are not as late"
            )
    return np.asarray(error)


def _condition(start: Floats, end: Floats) -> float:
    """By how much the rounding of a slerp grows: near half a turn of a cosine and sine, sideways is hardly known."""
    angle = float(np.linalg.norm(slerp(start, end, np.zeros(1), 1)[0]))
    return 1.0 if angle <= 2.0 else 1 / max(float(np.sin(angle)), 2.0**-53)


def speeds(curve: Curve, parts: int = 1) -> tuple[Floats, Floats]:
    """The largest speed of each number, from above, on parts of pieces.

    Args:
        curve: The curve.
        parts: A piece is looked at in so many parts at most, none shorter than this part of an average piece.

    Returns:
        (m + 1,) where parts begin and end, s; and (m, nq) rad/s and m/s.
    """
    steps = durations(curve.breaks)
    counts = np.clip(np.rint(parts * steps * len(steps) / steps.sum()), 1, parts).astype(np.int64).tolist()
    places, found = [curve.breaks[:1]], []
    for piece, begin, step, count in zip(curve.pieces, curve.breaks[:-1].tolist(), steps.tolist(), counts, strict=True):
        ends = np.arange(count + 1) / count
        cut = _part(np.repeat(piece[None], count, axis=0), ends[:-1], ends[1:]) if count > 1 else piece[None]
        degree, off = len(piece) - 1, blossom_error(piece, len(piece) - 1)
        fastest = (np.abs(np.diff(cut, axis=1)).max(axis=1) + 2 * off) * (degree * count / step)
        for a, b in curve.units:
            turn = slerp(piece[0, a:b], piece[-1, a:b], np.zeros(1), 1)[0]
            fastest[:, a:b] = float(np.linalg.norm(turn)) / step
        found.append(fastest * (1 + 2.0**-40))
        places.append(begin + step * ends[1:])
    return np.concatenate(places), np.concatenate(found)
