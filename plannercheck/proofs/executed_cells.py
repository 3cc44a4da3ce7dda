"""Whether proofs prove what several robots run on one clock: the exact polynomials of their messages, at their starts.

In: confirmed proofs of one file, a message or a standing configuration for each robot, their starts. Out: what is
missing. A robot's columns are those of joints whose names begin with its own and a slash. Before its first point it
stands there, and after its last point at that.

The clock is cut at the knots of all robots in fractions, and piece k is proved by proof k. Knots that are less than
0.9 ns apart are one: a robot whose knot is moved so is elsewhere by its largest speed times the shift, at most, which
is taken off the proof's tube. Pieces are cut by their polar forms. Control points are compared as for one robot
(executed_curves.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import TypeAlias

from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.proofs.claims import column_names
from plannercheck.proofs.data import Model, ProofData
from plannercheck.proofs.executed_curves import RUNNERS, Piece, Row, is_proved, numbers_of, pieces_run
from plannercheck.proofs.paths import PathProved, held_elsewhere

# The file of a robot's message, or the configuration (k,) at which it stands.
Part: TypeAlias = str | Path | Sequence[float]

_SAME_KNOT = Fraction(9, 10**10)


@dataclass(frozen=True)
class _Run:
    """What one robot does: its columns, knots on the clock, s, the pieces between them, and what other joints hold."""

    columns: tuple[int, ...]
    knots: Row
    pieces: Sequence[Piece]
    held: Mapping[str, float] = field(default_factory=dict)


def cell_proved(
    proofs: Sequence[ProofData],
    parts: Mapping[str, Part],
    starts: Mapping[str, float],
    controller: str = "jtc",
    tube: float = 0.0,
) -> PathProved:
    """Whether proofs prove the messages of a cell's robots as a controller runs them, each from its start on.

    Args:
        proofs: At least one, of one model; those that are confirmed, in their order.
        parts: By robot, a file that `pc.Trajectory.load` reads, or the numbers (k,) at which the robot stands.
        starts: By robot, when its message starts on the clock, s; 0 if not named.
        controller: One of `RUNNERS`, of all messages.
        tube: How far each number may be off at any instant, rad and m.

    Returns:
        What is missing.

    Raises:
        PlannercheckError: If a robot is missing or unknown, or a file can't be read.
    """
    if controller not in RUNNERS:
        raise unknown_name("controller", controller, RUNNERS)
    model, names = proofs[0].model, column_names(proofs[0])
    if not isinstance(model, Model) or len(names) != model.columns:
        raise PlannercheckError("robots on one clock have joints of one number each, and the proof has others")
    known = dict.fromkeys(name.partition("/")[0] for name in names if "/" in name)
    for name in (*parts, *starts):
        if name not in known:
            raise unknown_name("robot of the proof", name, known)
    missing = [name for name in known if name not in parts]
    if missing:
        raise PlannercheckError(f"nothing says what {', '.join(missing)} does: give its message, or where it stands")
    runs = [_run(name, part, names, starts.get(name, 0.0), controller, model) for name, part in parts.items()]
    clock = _clock([knot for run in runs for knot in run.knots])
    warped = [[max(t for t in clock if t <= knot) for knot in run.knots] for run in runs]
    around = numbers_of("tube", [tube] * model.columns, model.columns)
    other = held_elsewhere(proofs[0], {name: value for run in runs for name, value in run.held.items()})
    if other:
        return PathProved(len(clock) - 1, tuple(range(len(clock) - 1)), other)
    bad = [
        k
        for k, ends in enumerate(pairwise(clock))
        if k >= len(proofs) or not is_proved(proofs[k], _merged(runs, warped, ends, model.columns), around)
    ]
    count = len(clock) - 1
    fault = f"{len(bad)} of the {count} pieces on the clock are not proved, piece {bad[0]} first" if bad else None
    if not bad and len(proofs) > count:
        fault = f"there are {count} pieces on the clock, and {len(proofs)} proofs"
    return PathProved(count, tuple(bad), fault)


def _run(name: str, part: Part, names: Sequence[str], start: float, controller: str, model: Model) -> _Run:
    columns = tuple(k for k, each in enumerate(names) if each.startswith(f"{name}/"))
    own = tuple(names[k].partition("/")[2] for k in columns)
    if not isinstance(part, str | Path):
        row = numbers_of(f"where {name!r} stands", part, len(columns))
        return _Run(columns, [Fraction(0)], [Piece([[x, x] for x in row], [Fraction(0)] * len(row))])
    if not 0 <= start < float("inf"):
        raise PlannercheckError(f"the start of {name!r} must be a time of at least 0 s, not {start!r}")
    turning = [k for k, column in enumerate(columns) if column in model.whole_turns]
    times, pieces, held = pieces_run(part, own, controller, turning)
    others = {f"{name}/{joint}": value for joint, value in held.items()}
    return _Run(columns, [Fraction(start) + time for time in times], pieces, others)


def _clock(knots: Row) -> Row:
    """The instants at which the clock is cut, in ascending order from 0 s on."""
    kept = [Fraction(0)]
    for knot in sorted(knots):
        if knot >= kept[-1] + _SAME_KNOT:
            kept.append(knot)
    return kept


def _merged(runs: Sequence[_Run], warped: Sequence[Row], ends: tuple[Fraction, Fraction], width: int) -> Piece:
    """The control points of all columns between two instants, and how far they may be off."""
    control, off = [[Fraction(0)]] * width, [Fraction(0)] * width
    for run, knots in zip(runs, warped, strict=True):
        piece, begin, end = _standing(run, ends[0] >= knots[-1]), Fraction(0), Fraction(1)
        for k, (low, high) in enumerate(pairwise(knots)):
            if low <= ends[0] < high:
                piece, begin, end = run.pieces[k], (ends[0] - low) / (high - low), (ends[1] - low) / (high - low)
        late = max(abs(a - b) for a, b in zip(run.knots, knots, strict=True))
        for own, column in enumerate(run.columns):
            control[column] = _part(piece.control[own], begin, end)
            off[column] = piece.off[own] + late * _speed(run, own)
    return Piece(control, off)


def _standing(run: _Run, has_ended: bool) -> Piece:
    piece = run.pieces[-1] if has_ended else run.pieces[0]
    return Piece([[row[-1 if has_ended else 0]] * 2 for row in piece.control], piece.off)


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
