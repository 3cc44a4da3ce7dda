"""Checks every verdict on the motions of a draw by rules that have to hold.

In: a draw. Out: `Judged`: counts of verdicts, and faults. The rules:

- A motion is not free if it passes a contact by construction, or collides at any sampled state: around the contact, all
  along, and where a search finds the least clearance. Ends count as they were given.
- A refused motion comes within the tolerance, at the state that the certifier names or at another one.
- A verdict depends on the motion only: it is the same alone, in batches of any order, explained, and by a new checker.
- A motion is where it should be at the parameter of the contact.
- A proof is verified without the core.
- Curves that are the same as another one, or a part of it, have its verdict, within the tolerance.
- Of solids: coal finds no surfaces that meet on a free motion, and some within the tolerance on a refused one.
- Too large numbers, and unit vectors too far from length 1, may be declined by a `PlannercheckError`, in every call
  alike.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress_motions.cell_relatives import cell_relatives
from plannercheck.evaluation.stress_motions.collisions import ends_and_contacts, least_clearances, sampled
from plannercheck.evaluation.stress_motions.draws import Draw
from plannercheck.evaluation.stress_motions.mesh_collisions import by_meshes
from plannercheck.evaluation.stress_motions.outcomes import (
    DECLINED,
    EXCEPTION,
    FAILED,
    FREE,
    HISTORY,
    REFUSED,
    Answers,
    Judged,
    declined,
    valid,
)
from plannercheck.evaluation.stress_motions.planned_draws import PLANNED, refused_by_others
from plannercheck.evaluation.stress_motions.reasons import reasons, verified, whereabouts
from plannercheck.evaluation.stress_motions.recipes import is_curved, is_of_solids
from plannercheck.evaluation.stress_motions.relatives import relatives
from plannercheck.evaluation.stress_motions.subjects import Subject

# Motions of a draw that are asked one by one, and that are explained in full. What cells move is merged for each
# question, which takes longest: so few are asked again.
_SINGLE, _SINGLE_OF_CELLS, _EXPLAINED = 20, 2, 1
_AGAIN_OF_CELLS = 6
# Checkers of a draw that are asked about a few motions only; in space they take longer to build.
_FRESH = {"space": 1, "plane": 12, "cell": 1}
# With more pairs only as few are explained with proofs, which are as many as pairs. Of solids so many are explained at
# all, since that takes milliseconds, and none with proofs, which may be a million.
_MANY_PAIRS, _SOLIDS_EXPLAINED = 400, 4
# In how many parts motions are split for a batch in another order.
_PARTS = 3


def judge(
    draw: Draw, build: Callable[[], Subject], rng: np.random.Generator, proofs: int = 0, pieces: bool = False
) -> Judged:
    """Judges all motions of a draw, with checkers that `build` makes anew.

    So many of the accepted motions are proved and verified. `pieces`: what convex pieces refuse of a planner's motions
    among solids is counted.
    """
    judged = Judged()
    fresh, used = build(), build()
    answers = together(fresh, draw, np.arange(len(draw.motions.at)), judged)
    _count(draw, answers, fresh, judged)
    _alike(draw, used, answers, judged, rng)
    _after_few(draw, build, answers, judged, rng)
    ends_and_contacts(draw, used, answers, judged, rng)
    sampled(draw, used, answers, judged, rng)
    least_clearances(draw, used, answers, judged, rng)
    reasons(draw, used, answers, judged, rng)
    whereabouts(draw, used, answers, judged)
    if is_curved(draw.recipe):
        relatives(draw, used, answers, judged, rng)
    elif draw.recipe["kind"] == "cell":
        cell_relatives(draw, used, answers, judged, rng)
    elif is_of_solids(draw.recipe):
        by_meshes(draw, used, answers, judged, rng)
    if draw.family in PLANNED:
        refused_by_others(draw, answers, judged, pieces)
    if proofs:
        verified(draw, used, answers, judged, proofs)
    return judged


def together(subject: Subject, draw: Draw, rows: NDArray[np.int64], judged: Judged, threads: int = 1) -> Answers:
    """Answers to some motions asked together; where any is declined, in halves, so that it is known which."""
    if not len(rows):
        return np.zeros(0, dtype=np.int8)
    try:
        found = subject.check(draw.motions.q0[rows], draw.motions.q1[rows], draw.tolerance, threads)
        return np.where(found, FREE, REFUSED).astype(np.int8)
    except PlannercheckError as error:
        if len(rows) == 1:
            return np.array([declined(error, int(rows[0]), judged)], dtype=np.int8)
    except Exception as error:
        if len(rows) == 1:
            judged.add(EXCEPTION, int(rows[0]), repr(error))
            return np.array([FAILED], dtype=np.int8)
    half = len(rows) // 2
    return np.concatenate([together(subject, draw, part, judged, threads) for part in (rows[:half], rows[half:])])


def _count(draw: Draw, answers: Answers, subject: Subject, judged: Judged) -> None:
    motions = draw.motions
    starts, ends = subject.ends(motions.q0, motions.q1)
    free_ends = valid(subject, starts) & valid(subject, ends)
    inside = (motions.at > 0) & (motions.at < 1)
    judged.counts["motions"] += len(answers)
    for name, answer in (("free", FREE), ("refused", REFUSED), ("declined", DECLINED)):
        judged.counts[name] += int((answers == answer).sum())
    judged.counts["sharp"] += int((free_ends & inside & motions.touching).sum())


# ----- the same verdict, however it is asked for


def _alike(draw: Draw, used: Subject, answers: Answers, judged: Judged, rng: np.random.Generator) -> None:
    """The other checker is asked one by one, then together in other orders and batches, then explains."""
    count, is_cell = len(answers), draw.recipe["kind"] == "cell"
    single = _SINGLE_OF_CELLS if is_cell else _SINGLE
    order = rng.permutation(count)
    for row in order[:single].tolist():
        _compare("alone", row, _single(used, draw, row, judged), answers, judged)
    for part in np.array_split(rng.permutation(count)[: _AGAIN_OF_CELLS if is_cell else count], _PARTS):
        found = together(used, draw, part, judged, int(rng.integers(1, 3)))
        for row, answer in zip(part.tolist(), found.tolist(), strict=True):
            _compare("in another batch", row, answer, answers, judged)
    solids = is_of_solids(draw.recipe)
    proving = _EXPLAINED if len(used.checker.pairs) > _MANY_PAIRS else single
    for k, row in enumerate(order[-_SOLIDS_EXPLAINED if solids else -single :].tolist()):
        proofs = k < proving and bool(rng.integers(2)) and not solids
        answer = _motion_result(used, draw, row, judged, proofs)
        # Proofs are of all pairs, also of those that a verdict leaves out, whose numbers may be larger.
        if not (proofs and answer == DECLINED):
            _compare("explained" + " with proofs" * proofs, row, answer, answers, judged)


def _after_few(
    draw: Draw, build: Callable[[], Subject], answers: Answers, judged: Judged, rng: np.random.Generator
) -> None:
    """Fresh checkers are asked about one to three motions that are free, then about one that is not.

    What a motion leaves behind, a longer history overwrites.
    """
    free, refused = np.flatnonzero(answers == FREE), np.flatnonzero(answers == REFUSED)
    if not len(free) or not len(refused):
        return
    for _ in range(_FRESH[draw.recipe["kind"]]):
        subject = build()
        for row in [*rng.choice(free, int(rng.integers(1, 4))).tolist(), int(rng.choice(refused))]:
            _compare("after few others", row, _single(subject, draw, row, judged), answers, judged)


def _single(subject: Subject, draw: Draw, row: int, judged: Judged) -> int:
    q0, q1 = draw.motions.q0[row], draw.motions.q1[row]
    return _answer(row, judged, lambda: subject.check_one(q0, q1, draw.tolerance))


def _motion_result(subject: Subject, draw: Draw, row: int, judged: Judged, proofs: bool) -> int:
    q0, q1 = draw.motions.q0[row], draw.motions.q1[row]
    return _answer(row, judged, lambda: subject.motion_result(q0, q1, draw.tolerance, proofs).free)


def _answer(row: int, judged: Judged, is_free: Callable[[], bool]) -> int:
    try:
        return FREE if is_free() else REFUSED
    except PlannercheckError as error:
        return declined(error, row, judged)
    except Exception as error:
        judged.add(EXCEPTION, row, repr(error))
        return FAILED


def _compare(how: str, row: int, answer: int, answers: Answers, judged: Judged) -> None:
    if answer != answers[row]:
        judged.add(HISTORY, row, f"{how} {answer}, by a fresh checker among all {answers[row]}")
