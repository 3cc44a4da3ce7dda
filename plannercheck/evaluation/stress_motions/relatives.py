"""Checks of curves by others through the same states: of higher degree, cut, straight, and the part that is free.

In: a draw of curves with the answers to them. Out: faults. Verdicts of the same states may differ within the tolerance
only.
"""

from __future__ import annotations

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress_motions.curve_numbers import numbers_of, rows_of, unit_columns
from plannercheck.evaluation.stress_motions.draws import Draw
from plannercheck.evaluation.stress_motions.outcomes import (
    COLLISION,
    DECLINED,
    FREE,
    HISTORY,
    REFUSED,
    UNREASONED,
    Answers,
    Judged,
    declined,
    valid,
)
from plannercheck.evaluation.stress_motions.reasons import least_clearance, refused_within
from plannercheck.evaluation.stress_motions.subjects import CurveSubject, Subject
from plannercheck.motions.motion_ends import Motions
from plannercheck.motions.trajectory_verdict import TrajectoryVerdict

# Curves of a draw that are raised and cut, and that are explained as trajectories.
_LIKE, _EXPLAINED = 8, 1
# How often a curve is halved into short pieces at most: of these, covers prove several at once.
_MOST_HALVINGS = 5
# Corners of the largest tube that are looked at, and instants.
_INSTANTS = 64


def relatives(draw: Draw, used: Subject, answers: Answers, judged: Judged, rng: np.random.Generator) -> None:
    """Judges some curves of a draw."""
    assert isinstance(used, CurveSubject)
    _straight(draw, used, answers, judged)
    known = np.flatnonzero((answers == FREE) | (answers == REFUSED))
    for row in rng.permutation(known)[:_LIKE].tolist():
        points, tube = numbers_of(draw.motions.q0[row], draw.motions.q1[row])
        place = float(rng.choice([draw.motions.at[row], rng.random()]))
        parts = _cut(draw, used, row, place)
        likes = {"raised": [raised(points)], "cut": parts if 0 < place < 1 else [points]}
        if not unit_columns(used.robot).any():
            likes["in short pieces"] = _short_pieces(list(likes["cut"]), int(rng.integers(1, _MOST_HALVINGS + 1)))
        for how, pieces in likes.items():
            breaks = np.arange(len(pieces) + 1.0)
            try:
                answer = used.checker.check_trajectory(used.of_pieces(breaks, pieces), tube, draw.tolerance)
            except PlannercheckError as error:
                declined(error, row, judged)  # rounding is a larger part of it than of the curve itself
                continue
            alike(draw, used, row, place, answers[row] == FREE, answer, how, judged)
    for row in rng.permutation(known)[:_EXPLAINED].tolist():
        _explained(draw, used, row, answers[row] == FREE, judged, rng)


def _straight(draw: Draw, used: CurveSubject, answers: Answers, judged: Judged) -> None:
    """Curves of degree 1 without a tube have the verdicts of motions that go as far."""
    q0, (q1, tubes) = draw.motions.q0, np.split(draw.motions.q1, 2, axis=1)
    if q0.shape != q1.shape or tubes.any():
        return
    ends: Motions = used.checker._motion_ends(q0, q1)
    rows = np.flatnonzero((ends.ends == ends.given).all(axis=1) & (answers != DECLINED))
    found = used.checker.check_motions(q0[rows], q1[rows], tolerance=draw.tolerance, path="slerp") if len(rows) else []
    for row, free in zip(rows.tolist(), found, strict=True):
        if free != (answers[row] == FREE):
            judged.add(HISTORY, row, f"as a motion {bool(free)}, as a curve {answers[row]}")


def alike(
    draw: Draw, used: Subject, row: int, place: float, first: bool, other: bool, how: str, judged: Judged
) -> None:
    """The answer to the same states; what is refused has to be near enough, perhaps only at the place of the cut."""
    if other and draw.motions.touching[row]:
        judged.add(COLLISION, row, f"{how}, it is free though it touches by construction")
    if first != other:
        q0, q1 = draw.motions.q0[row], draw.motions.q1[row]
        at_cut = float(used.clearances(used.states(q0, q1, np.array([place]))).min()) - used.padding
        least = min(least_clearance(used, q0, q1), at_cut)
        if least > refused_within(draw, used, q0, q1):
            judged.add(UNREASONED, row, f"{how}, it is {other} instead of {first}, and its clearance is {least} m")


def _explained(draw: Draw, used: CurveSubject, row: int, free: bool, judged: Judged, rng: np.random.Generator) -> None:
    """The explanation has the same answer; what it says is free, or keeps so far apart, does so."""
    q0, q1 = draw.motions.q0[row], draw.motions.q1[row]
    _, tube = numbers_of(q0, q1)
    verdict: TrajectoryVerdict = used.explain(q0, q1, draw.tolerance)
    if verdict.free != free:
        judged.add(HISTORY, row, f"explained as a trajectory {verdict.free}, asked {free}")
    at = np.append(rng.random(_INSTANTS), [0.0, 1.0])
    states = used.states(q0, q1, at)
    _no_collision(used, states[at < verdict.free_until], tube, row, "the part that is free", judged, rng)
    if verdict.largest_tube:
        largest = np.where(unit_columns(used.robot), 0.0, verdict.largest_tube)
        _no_collision(used, states, largest, row, "the largest tube", judged, rng)
    if verdict.free:
        least = float(used.clearances(states).min()) - used.padding
        if not least > verdict.clearance * (1 - 1e-9) - 1e-9:
            judged.add(COLLISION, row, f"its clearance is {least} m, not {verdict.clearance} m")
    elif 0 < verdict.free_until < 1 and not verdict.free_until < 2**-40:
        part, _ = _cut(draw, used, row, verdict.free_until)
        a, b = (rows[0] for rows in rows_of(part[None], tube))
        if not used.check_one(a, b, draw.tolerance) and least_clearance(used, a, b) > refused_within(draw, used, a, b):
            judged.add(UNREASONED, row, f"the part until {verdict.free_until} is not free by itself")


def _no_collision(
    used: CurveSubject, states: Floats, tube: Floats, row: int, what: str, judged: Judged, rng: np.random.Generator
) -> None:
    corners = states + tube * rng.choice([-1.0, 1.0], states.shape)
    if len(states) and not (valid(used, states).all() and valid(used, corners).all()):
        judged.add(COLLISION, row, f"{what} collides")


def _cut(draw: Draw, used: Subject, row: int, place: float) -> tuple[Floats, Floats]:
    """Control points of both parts; unit vectors turn from one end to the other."""
    q0, q1 = draw.motions.q0[row], draw.motions.q1[row]
    parts, units = cut(numbers_of(q0, q1).points, place), unit_columns(used.robot)
    (middle,) = used.states(q0, q1, np.array([place]))
    parts[0][1:, units] = parts[1][:-1, units] = middle[units]
    return parts


def _short_pieces(pieces: list[Floats], halvings: int) -> list[Floats]:
    """Control points of pieces, each halved so many times."""
    for _ in range(halvings):
        pieces = [half for piece in pieces for half in cut(piece, 0.5)]
    return pieces


def raised(points: Floats) -> Floats:
    """(degree + 2, nq) control points of the same curve."""
    degree = len(points) - 1
    part = np.arange(1, degree + 1)[:, None] / (degree + 1)
    return np.concatenate([points[:1], part * points[:-1] + (1 - part) * points[1:], points[-1:]])


def cut(points: Floats, place: float) -> tuple[Floats, Floats]:
    """Control points of both parts of a curve, up to a place and from there on, by de Casteljau's algorithm."""
    first, last = [points[0]], [points[-1]]
    while len(points) > 1:
        points = (1 - place) * points[:-1] + place * points[1:]
        first.append(points[0])
        last.append(points[-1])
    return np.array(first), np.array(last[::-1])
