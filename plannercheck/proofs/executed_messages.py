"""Whether proofs prove what one robot or several run on a clock: the exact polynomials of messages, at their starts.

In: confirmed proofs of one file, a message of the robot, or of each robot a message or a standing configuration and a
start. Out: what is missing. A cell's robot has the columns of joints whose names begin with its own and a slash. Before
its first point a robot stands there, and after its last point at that.

The clock is cut at the knots of all robots in fractions, and piece k is proved by proof k. In a scene that moves, the
proofs' own clocks cut it: they follow each other from the start to the end, and each knot is one of their ends. Columns
behind the robot's are then those of what moves, and are as the proofs have them: `--robot` and `--scene` compare them.

Knots that are less than 0.9 ns apart are one, and so are a knot and the double it is rounded to: a robot whose knot is
moved so is elsewhere by its largest speed times the shift, at most, which is taken off the proof's tube. Pieces are cut
by their polar forms. Control points are compared in executed_curves.py.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeAlias

from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.model_comparisons import Followers, RobotJoints
from plannercheck.common.shown_times import shown_seconds, shown_span
from plannercheck.proofs.claims import clock_of, named_columns
from plannercheck.proofs.data import Model, ProofData
from plannercheck.proofs.executed_curves import RUNNERS, Piece, Row, is_proved, numbers_of, pieces_run
from plannercheck.proofs.paths import PathProved, held_elsewhere

# The file of a robot's message, or the configuration (k,) at which it stands.
Part: TypeAlias = str | Path | Sequence[float]

_SAME_KNOT = Fraction(9, 10**10)

# By what part of a clock's end a knot and a double of its clock may differ: eight roundings.
_ROUNDED = Fraction(1, 2**50)


@dataclass(frozen=True)
class _Run:
    """What one robot does: its columns, knots on the clock, s, the pieces between them, and what other joints hold."""

    columns: Sequence[int]
    knots: Row
    pieces: Sequence[Piece]
    held: Mapping[str, float] = field(default_factory=dict)


def trajectory_proved(
    proofs: Sequence[ProofData],
    path: Any,
    controller: str = "jtc",
    tube: float | Sequence[float] = 0.0,
    start: Sequence[float] | None = None,
    message: int | None = None,
    start_time: float = 0.0,
    robot_columns: int | None = None,
    joints: RobotJoints | None = None,
) -> PathProved:
    """Whether proofs prove a message as a controller runs it.

    Args:
        proofs: At least one, of one model; those that are confirmed, in their order.
        path: A file that `pc.Trajectory.load` reads.
        controller: One of `RUNNERS`: "jtc" (joint_trajectory_controller of ros2_control), and so on.
        tube: How far each number may be off the curve at any instant, rad and m: one number, or one a column.
        start: (columns,) where the robot stands at 0 s, at rest, rad and m; None: at the first point.
        message: Which trajectory of the file, from 0; None: it holds one.
        start_time: The scene's clock where the trajectory begins, s; without effect where nothing moves.
        robot_columns: How many columns are the robot's, the first ones; needed where something in the scene moves. The
            other columns are as the proofs have them.
        joints: The robot's, by which a message may have joints that follow others; None: they are not known.

    Returns:
        What is missing.

    Raises:
        PlannercheckError: If the file can't be read, holds other joints or one point without `start`, no controller
            runs it, the tube or the start is malformed, or `robot_columns` is missing.
    """
    _check_controller(controller)
    model, names = _of_robots(proofs, robot_columns, joints)
    width = len(names)
    widths = numbers_of("tube", [tube] * width if isinstance(tube, int | float) else tube, width)
    if min(widths) < 0:
        raise PlannercheckError(f"tube must be at least 0 in each number, not {float(min(widths))!r}")
    stands = None if start is None else numbers_of("start", start, width)
    followers = None if joints is None else joints.followers
    times, pieces, held = pieces_run(path, names, controller, model.whole_turns, stands, message, followers)
    try:
        begin = Fraction(float(start_time))  # the infinities and NaN are no fractions
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"start_time must be a number of seconds, not {start_time!r:.80}") from None
    run = _Run(range(width), [begin + time - times[0] for time in times], pieces, held)
    return _proved(proofs, [run], begin, widths, "of the trajectory")


def cell_proved(
    proofs: Sequence[ProofData],
    parts: Mapping[str, Part],
    starts: Mapping[str, float],
    controller: str = "jtc",
    tube: float = 0.0,
    robot_columns: int | None = None,
    joints: RobotJoints | None = None,
) -> PathProved:
    """Whether proofs prove the messages of a cell's robots as a controller runs them, each from its start on.

    Args:
        proofs: At least one, of one model; those that are confirmed, in their order.
        parts: By robot, a file that `pc.Trajectory.load` reads, or the numbers (k,) at which the robot stands.
        starts: By robot, when its message starts on the clock, s; 0 if not named.
        controller: One of `RUNNERS`, of all messages.
        tube: How far each number may be off at any instant, rad and m.
        robot_columns: As for `trajectory_proved`, of all robots.
        joints: Likewise.

    Returns:
        What is missing.

    Raises:
        PlannercheckError: If a robot is missing or unknown, a file can't be read, or `robot_columns` is missing.
    """
    _check_controller(controller)
    model, names = _of_robots(proofs, robot_columns, joints)
    known = dict.fromkeys(name.partition("/")[0] for name in names)
    for name in (*parts, *starts):
        if name not in known:
            raise unknown_name("robot of the proof", name, known)
    missing = [name for name in known if name not in parts]
    if missing:
        raise PlannercheckError(f"nothing says what {', '.join(missing)} does: give its message, or where it stands")
    runs = [_run(name, part, names, starts.get(name, 0.0), controller, model, joints) for name, part in parts.items()]
    around = numbers_of("tube", [tube] * len(names), len(names))
    return _proved(proofs, runs, Fraction(0), around, "on the clock")


def _check_controller(controller: str) -> None:
    if controller not in RUNNERS:
        raise unknown_name("controller", controller, RUNNERS)


def _of_robots(
    proofs: Sequence[ProofData], robot_columns: int | None, joints: RobotJoints | None
) -> tuple[Model, tuple[str, ...]]:
    """The proofs' model, and the joints of the robots' columns."""
    model = proofs[0].model
    if not isinstance(model, Model):
        raise PlannercheckError("a JointTrajectory is of joints in space, and the proof is in the plane")
    width: int | None = model.columns
    if clock_of(proofs):
        width = joints.columns if robot_columns is None and joints is not None else robot_columns
    if width is None:
        raise PlannercheckError(
            "something in the proof's scene moves: name --robot and --scene (robot_columns=), which say what"
            " columns are the robot's"
        )
    own = [joint for joint in model.joints if any(0 <= column < width for column in joint.columns)]
    if any(len(joint.columns) > 1 for joint in own):
        raise PlannercheckError("a JointTrajectory is of joints of one number each, and the proof has others")
    if not own or {joint.columns[0] for joint in own} != set(range(width)):
        raise PlannercheckError("the proof has no joints, or numbers that no joint takes")
    return model, named_columns(proofs[0], () if joints is None else joints.names)[:width]


def _run(
    name: str,
    part: Part,
    names: Sequence[str],
    start: float,
    controller: str,
    model: Model,
    joints: RobotJoints | None,
) -> _Run:
    columns = tuple(k for k, each in enumerate(names) if each.startswith(f"{name}/"))
    own = tuple(names[k].partition("/")[2] for k in columns)
    if not isinstance(part, str | Path):
        row = numbers_of(f"where {name!r} stands", part, len(columns))
        return _Run(columns, [Fraction(0)], [Piece([[x, x] for x in row], [Fraction(0)] * len(row))])
    if not 0 <= start < float("inf"):
        raise PlannercheckError(f"the start of {name!r} must be a time of at least 0 s, not {start!r}")
    turning = [k for k, column in enumerate(columns) if column in model.whole_turns]
    followers = None if joints is None else _within(name, joints.followers)
    times, pieces, held = pieces_run(part, own, controller, turning, followers=followers)
    others = {f"{name}/{joint}": value for joint, value in held.items()}
    return _Run(columns, [Fraction(start) + time for time in times], pieces, others)


def _within(name: str, followers: Followers) -> Followers:
    """The joints of one robot of a cell that follow others, by their names in its own files."""
    before = f"{name}/"
    return {
        joint.removeprefix(before): (leader.removeprefix(before), multiplier, offset)
        for joint, (leader, multiplier, offset) in followers.items()
        if joint.startswith(before)
    }


def _proved(proofs: Sequence[ProofData], runs: Sequence[_Run], begin: Fraction, tube: Row, where: str) -> PathProved:
    """Whether proofs prove what robots run from a begin on the clock on, within a tube."""
    knots, clocks = sorted([begin, *(knot for run in runs for knot in run.knots)]), clock_of(proofs)
    clock = [Fraction(time) for time in clocks] or _merged(knots)
    count = len(clock) - 1
    fault = held_elsewhere(proofs[0], {name: value for run in runs for name, value in run.held.items()})
    fault = fault or _cut_elsewhere(clock, knots)
    if fault:
        return PathProved(count, tuple(range(count)), fault)
    bad = [
        k
        for k, piece in enumerate(_pieces(runs, clock, len(tube)))
        if k >= len(proofs) or clock_of(proofs[k : k + 1]) != clocks[k : k + 2] or not is_proved(proofs[k], piece, tube)
    ]
    if bad:
        sizes = dict.fromkeys(f"{float(width):g}" for width in (min(tube), max(tube)))
        within = f" within {' to '.join(sizes)} rad and m" if any(tube) else ""
        fault = f"{len(bad)} of the {count} pieces {where} are not proved{within}, piece {bad[0]} first"
    elif len(proofs) > count:
        fault = f"there are {count} pieces {where}, and {len(proofs)} proofs"
    return PathProved(count, tuple(bad), fault)


def _merged(knots: Row) -> Row:
    """Sorted knots, those that are one once."""
    kept = knots[:1]
    for knot in knots:
        if knot >= kept[-1] + _SAME_KNOT:
            kept.append(knot)
    return kept


def _place(clock: Row, knot: Fraction) -> Fraction:
    """The instant of the clock that a knot is: the last one before it, if both are one, else the nearest."""
    k = bisect_right(clock, knot)
    around = clock[max(k - 1, 0) : k + 1]
    return around[0] if abs(knot - around[0]) < _SAME_KNOT else min(around, key=lambda time: abs(knot - time))


def _cut_elsewhere(clock: Row, knots: Row) -> str | None:
    """Whether a knot is no instant of the clock, or the clock is longer than the knots, in words."""
    places, near = [_place(clock, knot) for knot in knots], _SAME_KNOT + abs(clock[-1]) * _ROUNDED
    off = [knot for knot, place in zip(knots, places, strict=True) if abs(knot - place) > near]
    if not off and (places[0], places[-1]) == (clock[0], clock[-1]):
        return None
    path, own = (shown_span(float(each[0]), float(each[-1])) for each in (knots, clock))
    knot = f", with a knot at {shown_seconds(float(off[0]))} s" if off else ""
    told = f"the path is from {path} of the scene's clock{knot}; the proofs are from {own}, and cut elsewhere"
    return f"{told}: give the starts that were proved (--start-time, --delay)"


def _pieces(runs: Sequence[_Run], clock: Row, width: int) -> Iterator[Piece]:
    """The control points of the robots' columns from each instant of the clock to the next, and how far they are off.

    An end of the clock that a robot's knot has become cuts its polynomials in the knot's place.
    """
    moved = [[_place(clock, knot) for knot in run.knots] for run in runs]
    shifted = [_shifts(run, knots) for run, knots in zip(runs, moved, strict=True)]
    for ends in pairwise(clock):
        control, off = [[Fraction(0)]] * width, [Fraction(0)] * width
        for run, knots, shifts in zip(runs, moved, shifted, strict=True):
            piece = _piece(run, knots, ends)
            for own, column in enumerate(run.columns):
                control[column], off[column] = piece.control[own], piece.off[own] + shifts[own]
        yield Piece(control, off)


def _piece(run: _Run, knots: Row, ends: tuple[Fraction, Fraction]) -> Piece:
    """What a robot does between two instants, its knots being at others."""
    k = bisect_right(knots, ends[0]) - 1
    if not 0 <= k < len(knots) - 1:
        piece, there = (run.pieces[0], 0) if k < 0 else (run.pieces[-1], -1)
        return Piece([[row[there]] * 2 for row in piece.control], piece.off)
    begin, end = ((time - knots[k]) / (knots[k + 1] - knots[k]) for time in ends)
    return Piece([_part(row, begin, end) for row in run.pieces[k].control], run.pieces[k].off)


def _part(control: Row, begin: Fraction, end: Fraction) -> Row:
    """Control points of a part of a polynomial: its polar forms."""
    if begin == 0 and end == 1:
        return control
    degree, out = len(control) - 1, []
    for j in range(degree + 1):
        points = control
        for k in range(degree):
            at = end if k < j else begin
            points = [a + (b - a) * at for a, b in pairwise(points)]
        out.append(points[0])
    return out


def _shifts(run: _Run, knots: Row) -> Row:
    """How far each column is off at most, of a robot whose knots have become others: by its largest speed."""
    late = max(abs(a - b) for a, b in zip(run.knots, knots, strict=True))
    return [late * _speed(run, own) if late else late for own in range(len(run.columns))]


def _speed(run: _Run, column: int) -> Fraction:
    """The largest speed of a column, from above."""
    steps = [b - a for a, b in pairwise(run.knots)]
    rows = [piece.control[column] for piece in run.pieces[: len(steps)]]
    return max(
        (
            (len(row) - 1) * max(abs(b - a) for a, b in pairwise(row)) / step
            for row, step in zip(rows, steps, strict=True)
        ),
        default=Fraction(0),
    )
