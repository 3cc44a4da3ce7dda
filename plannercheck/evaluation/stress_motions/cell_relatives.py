"""Checks of trajectories of a cell against what has to have the same verdict.

In: a draw of cells with the answers to it. Out: faults. The robots in another order, the clock split in two, and a
checker that saves no work: verdicts may differ within the tolerance only. The merged trajectory is where each robot's
own curve is.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from plannercheck.bodies.tuning import DEFAULT_TUNING, tuning_table
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress_motions.cell_numbers import reordered
from plannercheck.evaluation.stress_motions.cell_subject import CellSubject
from plannercheck.evaluation.stress_motions.curve_numbers import unit_columns
from plannercheck.evaluation.stress_motions.draws import Draw
from plannercheck.evaluation.stress_motions.outcomes import ASTRAY, FREE, HISTORY, REFUSED, Answers, Judged, declined
from plannercheck.evaluation.stress_motions.relatives import alike, cut
from plannercheck.evaluation.stress_motions.subjects import Subject
from plannercheck.trajectories.curve import Curve
from plannercheck.trajectories.trajectory import Trajectory

# Trajectories of a draw that are asked in other ways, and instants at which merged ones are looked at.
_LIKE, _INSTANTS = 2, 8
# Cells whose robots are asked in another order, the part of others' switches that are off.
_TURNED, _OFF = 0.5, 0.5
# Trajectories that are split at a knot, others are split between two.
_AT_KNOTS = 0.5
# Merged states are where the robots' own are up to this, per largest number.
_SAME_STATE = 1e-9
# Switches of what saves work.
_SWITCHES = [row.name for row in tuning_table() if row.type == "bool"]


def cell_relatives(draw: Draw, used: Subject, answers: Answers, judged: Judged, rng: np.random.Generator) -> None:
    """Judges some trajectories of a draw."""
    assert isinstance(used, CellSubject)
    assert draw.recipe["kind"] == "cell"
    known = rng.permutation(np.flatnonzero((answers == FREE) | (answers == REFUSED)))
    names, off = list(draw.recipe["robots"]), list[str]()
    if rng.random() < _TURNED:
        names = [str(name) for name in rng.permutation(names)]
    else:
        off = [switch for switch in _SWITCHES if rng.random() < _OFF]
    how_other = f"without {', '.join(off)}" if off else f"in the order {', '.join(names)}"
    robots = {name: draw.recipe["robots"][name] for name in names}
    other = CellSubject({**draw.recipe, "robots": robots}, None, DEFAULT_TUNING.without(*off))
    columns = np.concatenate([used.robot.parts[name].columns for name in names])
    for row in known[:_LIKE].tolist():
        q0, q1 = draw.motions.q0[row], draw.motions.q1[row]
        _is_where_robots_are(used, q0, q1, row, judged, rng)
        turned, first = reordered(used.robot, q0, names), bool(answers[row] == FREE)
        made = used.merged(q0)
        time = _split_time(made.curve.breaks, rng)
        ways: dict[str, Callable[[], bool]] = {
            "split in two": partial(_split, used, q0, q1, time, draw.tolerance),
            how_other: partial(other.check_one, turned, q1[columns], draw.tolerance),
        }
        for how, ask in ways.items():
            try:
                answer = ask()
            except PlannercheckError as error:
                declined(error, row, judged)  # rounding is a larger part of it
                continue
            alike(draw, used, row, time / made.duration, first, answer, how, judged)
            if how.startswith("without") and answer != first:
                judged.add(HISTORY, row, f"{how} {answer}, with these {first}")


def _is_where_robots_are(
    used: CellSubject, q0: Floats, q1: Floats, row: int, judged: Judged, rng: np.random.Generator
) -> None:
    at, made = rng.random(_INSTANTS), used.merged(q0)
    own = used.states(q0, q1, at)[:, :-1]
    merged = used.robot.link_poses(made.position(at * made.duration))
    wanted = used.robot.link_poses(own)
    if np.abs(merged - wanted).max() > _SAME_STATE * (1 + np.abs(wanted).max()) * (1 + np.abs(q0).max()):
        judged.add(ASTRAY, row, "on one clock, the robots are not where their own curves are")


def _split(used: CellSubject, q0: Floats, q1: Floats, time: float, tolerance: float) -> bool:
    """Whether both parts of a trajectory are free that is split at a time on the clock, s."""
    made, units = used.merged(q0), unit_columns(used.robot)
    curve = made.curve
    k = int(np.searchsorted(curve.breaks, time, side="right")) - 1
    first, last = curve.breaks[k : k + 2].tolist()
    if time == first:
        halves = curve.pieces[:k], curve.pieces[k:]
    else:
        parts = cut(curve.pieces[k], (time - first) / (last - first))
        (middle,) = made.position([time])
        parts[0][1:, units] = parts[1][:-1, units] = middle[units]
        halves = (*curve.pieces[:k], parts[0]), (parts[1], *curve.pieces[k + 1 :])
    breaks = np.append(curve.breaks[curve.breaks < time], time), np.append(time, curve.breaks[curve.breaks > time])
    found = [
        used.checker.check_trajectory(
            Trajectory.of_curve(Curve(at, pieces, curve.error, curve.units)),
            q1,
            tolerance,
            start_time=float(q0[0] + at[0]),
        )
        for at, pieces in zip(breaks, halves, strict=True)
    ]
    return all(found)


def _split_time(breaks: Floats, rng: np.random.Generator) -> float:
    """Where to split: between two knots, or at one, s; no part of a piece may take less than 1 ns."""
    k = int(rng.choice(np.flatnonzero(np.diff(breaks) > 1e-7)))
    at_knot = k > 0 and rng.random() < _AT_KNOTS
    return float(breaks[k] if at_knot else breaks[k] + rng.uniform(0.1, 0.9) * (breaks[k + 1] - breaks[k]))
