"""What a controller runs between the points of a message: the exact polynomials of its doubles; what proves a piece.

In: a file of a trajectory, who runs it, where the robot stands. Out: pieces. With a start, the way to the first point
is piece 0, unless this point is at 0 s. A piece and the polynomial of a proof are brought to one degree, in fractions.
Their control points may differ, in each column, by what the proof's tube has more than the tube that is asked for:
polynomials differ no more than their control points do.

The rules are written from the controllers' own code: `set_point_before_trajectory_msg`, `wraparound_joint`,
`fill_cubic_spline_velocities` and `interpolate_between_points` of ros2_controllers, `cubicSplineRun` and
`quinticSplineRun` of the UR client library's external_control.urscript, MotoROS2's MotionControl.c. Joints that turn
without end are those of the proof's model, which `--robot` compares with the robot.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import Any, Literal, TypeAlias, get_args

from plannercheck.common.errors import PlannercheckError
from plannercheck.common.model_comparisons import Followers, message_reader
from plannercheck.proofs.data import Motion, ProofData

Runner: TypeAlias = Literal["jtc", "jtc-upsampled", "ur", "motoros2", "linear"]
RUNNERS: tuple[Runner, ...] = get_args(Runner)

# Nanoseconds beyond which doubles skip whole numbers, 104 days.
_MOST = 2**53

# Pi, and how far this is off it at most.
_PI = Fraction(314159265358979323846264338327950288419716939937510582097494459, 10**62)
_OFF_PI = Fraction(1, 10**62)

# How near half a turn the way to the first point is a tie, rad (`wraparound_joint`).
_TIE = Fraction(1, 10**9)

# Velocities of a spline are rounded to multiples of this; how far that is off is computed.
_GRID = 2**160

# A row of numbers, one a column or one a control point.
Row: TypeAlias = list[Fraction]


@dataclass(frozen=True)
class _Point:
    """A point that a controller passes: its time, s, and its numbers by column; none of what it does not have."""

    time: Fraction
    positions: Row
    velocities: Row
    accelerations: Row


@dataclass(frozen=True)
class Piece:
    """A piece that a controller runs: the control points of each column, and how far these may be off at most."""

    control: list[Row]
    off: Row


def numbers_of(name: str, given: Any, columns: int) -> Row:
    """A number for each column."""
    try:
        numbers = [Fraction(float(x)) for x in given]  # the infinities and NaN are no fractions
    except (TypeError, ValueError, OverflowError):
        numbers = []
    if len(numbers) != columns:
        raise PlannercheckError(f"{name} must be {columns} finite numbers, rad and m, not {given!r:.80}")
    return numbers


def _message(read: Any, path: Any, controller: str) -> list[_Point]:
    """The points of a file as a controller takes them: with the times and derivatives that it uses."""
    rows = zip(
        *([_exact(row) for row in r] for r in (read.positions, read.velocities, read.accelerations)), strict=True
    )
    times = _instants(read.times.tolist(), controller)
    points = [_Point(time, *row) for time, row in zip(times, rows, strict=True)]
    still, without = (
        [Fraction(0)] * read.positions.shape[1],
        [k for k, point in enumerate(points) if not point.velocities],
    )
    if controller == "linear":
        return [replace(point, velocities=[], accelerations=[]) for point in points]
    if controller == "motoros2":
        if len(set(times)) < len(times):
            raise PlannercheckError(
                f"trajectory file {str(path)!r}: has points at the same ms, to which motoros2 cuts times"
            )
        if without:
            raise PlannercheckError(f"trajectory file {str(path)!r}: point {without[0]} has no velocities for motoros2")
        return [replace(point, accelerations=[]) for point in points]
    if controller == "ur":
        accelerated = [bool(point.accelerations) for point in points]
        if 0 < len(without) < len(points) or 0 < sum(accelerated) < len(points) or (without and accelerated[0]):
            raise PlannercheckError(
                f"trajectory file {str(path)!r}: the UR driver runs points that all have velocities or none, and"
                " accelerations likewise, but only with velocities"
            )
        points = [replace(point, velocities=point.velocities or still) for point in points]
        if times[0] == 0:  # passed over: the robot stands there
            points[0] = replace(points[0], velocities=still, accelerations=still if accelerated[0] else [])
    return points


def _pieces(
    points: Sequence[_Point], controller: str, stands: Row | None, turning: Sequence[int], path: Any
) -> list[Piece]:
    """The pieces between the points, and before them that from where the robot stands."""
    still = [Fraction(0)] * len(points[0].positions)
    run, off, unsure, before = list(points), still, still, list[Piece]()
    is_bare = not any(point.velocities or point.accelerations for point in points)
    if controller == "jtc-upsampled" and is_bare and len(points) > 1:
        run, off = _upsampled(points)
    if stands is not None:
        ends = list(zip(stands, run[0].positions, strict=True))
        turns = turning if controller.startswith("jtc") else ()
        ways = [_way(q, p, k in turns) for k, (q, p) in enumerate(ends)]
        about = [_OFF_PI * (abs(q) + abs(p) + 1) if k in turns else Fraction(0) for k, (q, p) in enumerate(ends)]
        if run[0].time > 0 and controller != "motoros2":
            there = _Point(Fraction(0), [p - way for (_, p), way in zip(ends, ways, strict=True)], still, still)
            before = [_piece(there, run[0], about, still, "start and point 0")]
        else:
            if any(abs(way) > (_TIE if k in turns else 0) for k, way in enumerate(ways)):
                why = "motoros2 refuses it" if controller == "motoros2" else "the robot would jump"
                raise PlannercheckError(f"trajectory file {str(path)!r}: does not begin at the start: {why}")
            unsure = [abs(way) + each for way, each in zip(ways, about, strict=True)]
    if len(run) + len(before) < 2:
        raise PlannercheckError(f"trajectory file {str(path)!r}: has one point, and no way between points")
    between = (
        _piece(*pair, still if k else unsure, off, f"points {k} and {k + 1}") for k, pair in enumerate(pairwise(run))
    )
    return [*before, *between]


def _way(q: Fraction, first: Fraction, turns: bool) -> Fraction:
    """From where a joint stands to the first point: that without whole turns, of joints that turn without end."""
    way = first - q
    if not turns:
        return way
    shortest = way - 2 * _PI * round(way / (2 * _PI))
    if abs(abs(shortest) - _PI) < _TIE:
        return abs(shortest) if way > 0 else -abs(shortest)
    return shortest


def _upsampled(points: Sequence[_Point]) -> tuple[list[_Point], Row]:
    """The points with the velocities of the spline that is at rest at both ends, and how far these are off at most.

    Each row of the system, alpha before + 2 here + beta after with alpha + beta = 1, has a diagonal that exceeds the
    rest by 1: so velocities are off by the largest residual at most.
    """
    steps = [b.time - a.time for a, b in pairwise(points)]
    columns = [_spline(steps, list(column)) for column in zip(*(point.positions for point in points), strict=True)]
    rows = zip(*(velocities for velocities, _ in columns), strict=True)
    run = [replace(point, velocities=list(row)) for point, row in zip(points, rows, strict=True)]
    return run, [residual for _, residual in columns]


def _spline(steps: Row, q: Row) -> tuple[Row, Fraction]:
    """The velocities of one column, and their largest residual."""
    rows = []
    for k, (h, after) in enumerate(pairwise(steps)):
        alpha, slopes = after / (h + after), ((q[k + 1] - q[k]) / h, (q[k + 2] - q[k + 1]) / after)
        rows.append((alpha, 1 - alpha, 3 * (alpha * slopes[0] + (1 - alpha) * slopes[1])))
    swept = [(Fraction(0), Fraction(0))]  # a velocity is the second less the first times the next velocity
    for alpha, beta, right in rows:
        pivot = 2 - alpha * swept[-1][0]
        swept.append((_rounded(beta / pivot), _rounded((right - alpha * swept[-1][1]) / pivot)))
    v = [Fraction(0)] * len(q)
    for k in range(len(rows), 0, -1):
        v[k] = _rounded(swept[k][1] - swept[k][0] * v[k + 1])
    residuals = (abs(a * v[k] + 2 * v[k + 1] + b * v[k + 2] - right) for k, (a, b, right) in enumerate(rows))
    return v, max(residuals, default=Fraction(0))


def _rounded(x: Fraction) -> Fraction:
    return Fraction(round(x * _GRID), _GRID)


def pieces_run(
    path: Any,
    names: Sequence[str],
    controller: str,
    turning: Sequence[int],
    stands: Row | None = None,
    message: int | None = None,
    followers: Followers | None = None,
) -> tuple[Row, list[Piece], Mapping[str, float]]:
    """The times at which pieces of a message begin and end, s, the pieces, of joints by name, and what others hold.

    Args:
        path: A file that `pc.Trajectory.load` reads.
        names: The joints.
        controller: One of `RUNNERS`.
        turning: Which of the joints turn without end.
        stands: Where the robot stands at 0 s, at rest; None: at the first point.
        message: Which trajectory of the file, from 0; None: it holds one.
        followers: The joints that follow these; None: they are not known.
    """
    read = message_reader()(path, names, message, followers)
    points = _message(read, path, controller)
    pieces, times = _pieces(points, controller, stands, turning, path), [point.time for point in points]
    return [Fraction(0)] * (len(pieces) + 1 - len(times)) + times, pieces, read.held


def is_proved(proof: ProofData, piece: Piece, tube: Row) -> bool:
    """Whether a proof proves a piece of its first columns with a tube."""
    motion, count = proof.motion, len(tube)
    if not isinstance(motion, Motion) or motion.end != motion.asked_end:
        return False
    own = [[Fraction(x) for x in column] for column in zip(*motion.control, strict=True)]
    widths = motion.tube or (0.0,) * len(own)
    return all(
        _difference(given, asked) + off <= Fraction(width) - within
        for given, asked, off, width, within in zip(
            own[:count], piece.control, piece.off, widths[:count], tube, strict=True
        )
    )


def _difference(a: Row, b: Row) -> Fraction:
    """The largest difference of control points, at one degree."""
    a, b = (_raised(control, max(len(a), len(b))) for control in (a, b))
    return max(abs(x - y) for x, y in zip(a, b, strict=True))


def _raised(control: Row, count: int) -> Row:
    """The same polynomial by as many control points."""
    while len(control) < count:
        n = len(control)
        inner = [(k * control[k - 1] + (n - k) * control[k]) / n for k in range(1, n)]
        control = [control[0], *inner, control[-1]]
    return control


def _instants(times: Sequence[float], controller: str) -> list[Fraction]:
    """The times of points, s: whole nanoseconds, as a message has them, if the doubles are the nearest to such.

    MotoROS2 cuts them to ms (MotionControl.c).
    """
    stamps = [round(Fraction(time) * 10**9) for time in times]
    if controller == "motoros2":
        return [Fraction(stamp // 10**6, 1000) for stamp in stamps]
    is_message = all(stamp / 10**9 == time and stamp < _MOST for stamp, time in zip(stamps, times, strict=True))
    return [Fraction(stamp, 10**9) for stamp in stamps] if is_message else [Fraction(time) for time in times]


def _piece(a: _Point, b: _Point, unsure: Row, off: Row, named: str) -> Piece:
    """The piece from a point to the next; both are named for errors.

    Each position of the first one may be `unsure`, and each velocity `off`: control points are off by a third of the
    duration times as much.
    """
    step, p, q = b.time - a.time, a.positions, b.positions
    has_velocities, has_accelerations = bool(a.velocities and b.velocities), bool(a.accelerations and b.accelerations)
    if has_accelerations and not has_velocities:
        raise PlannercheckError(f"{named} have accelerations without velocities: a controller runs to 0")
    if not has_velocities:
        return Piece([list(ends) for ends in zip(p, q, strict=True)], unsure)
    ends = zip(p, a.velocities, b.velocities, q, strict=True)
    if not has_accelerations:
        control = [[x, x + y * step / 3, z - u * step / 3, z] for x, y, u, z in ends]
        return Piece(control, [x + y * step / 3 for x, y in zip(unsure, off, strict=True)])
    fifth, twentieth = step / 5, step * step / 20
    quintic = [
        [x, x + y * fifth, x + 2 * y * fifth + c * twentieth, z - 2 * u * fifth + d * twentieth, z - u * fifth, z]
        for (x, y, u, z), c, d in zip(ends, a.accelerations, b.accelerations, strict=True)
    ]
    return Piece(quintic, unsure)


def _exact(row: Any) -> Row:
    """The numbers of a point; none if it has NaN, as rows have that a message leaves out."""
    return [] if row[0] != row[0] else [Fraction(x) for x in row.tolist()]
