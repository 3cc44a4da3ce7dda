"""Every verdict on the motions of a draw, held against what must be so.

In: a draw. Out: `Judged`: how its motions were answered, and faults.

- A motion that passes a contact by construction is not free, nor is one that collides at any state that is sampled:
  around the contact, all along, and where a search finds the least clearance. Ends count as they were given.
- A motion that is refused comes within the tolerance, at the state that the certifier names or somewhere else.
- A verdict depends on nothing but the motion: asked alone, in batches of any order, explained, by a fresh checker.
- A motion is where it should be at the parameter of the contact.
- A proof is verified, apart from the core.
- Numbers that are too large, or too far off length 1, may be declined by a `PlannercheckError`, by each way alike.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from plannercheck.errors import PlannercheckError
from plannercheck.stress.motion_draws import Draw
from plannercheck.stress.motion_subjects import Subject

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Answers = NDArray[np.int8]

FREE, REFUSED, DECLINED, FAILED = 1, 0, -1, -2

COLLISION, UNREASONED, HISTORY, ASTRAY, PROOF, EXCEPTION = (
    "collision passed",
    "refused without reason",
    "depends on history",
    "goes another way",
    "proof refused",
    "exception",
)
FAULTS = (COLLISION, UNREASONED, HISTORY, ASTRAY, PROOF, EXCEPTION)

# States of an accepted motion: evenly spread with a random start, and at both sides of the contact so far off.
_SPREAD = 16
_ASIDE = np.concatenate([-(10.0 ** -np.arange(1.0, 10.0, 2)), [0.0], 10.0 ** -np.arange(1.0, 10.0, 2)])
# Of so many accepted motions of a draw the least clearance is searched for: states at first, then rounds of so many
# within the two steps around the least.
_SEARCHED, _FIRST_STATES, _ROUNDS, _STATES = 8, 17, 4, 9
# The same for a refusal that seems to have no reason.
_THOROUGH_STATES, _THOROUGH_ROUNDS = 513, 4
# Motions of a draw that are asked one by one, and that are explained in full.
_SINGLE, _EXPLAINED = 20, 1
# Checkers of a draw that are asked about a few motions only; in space they take longer to build.
_FRESH = {"space": 1, "plane": 12}
# With more pairs only as few are explained with proofs, which are as many as pairs.
_MANY_PAIRS = 400
# Refusals may name a state that is this much further away than the tolerance, m, and the same per largest number:
# what distances and poses are rounded by.
_SLACK, _SLACK_PER_NUMBER = 1e-8, 1e-13
# Poses of the state that a motion passes agree up to this, m per m and rad.
_SAME_STATE = 1e-9
# In how many parts motions are split for a batch in another order.
_PARTS = 3


@dataclass
class Fault:
    """What was wrong with one motion: row of the draw's, or -1 for no one motion."""

    kind: str
    row: int
    what: str


@dataclass
class Judged:
    """A draw's outcome.

    Attributes:
        counts: Motions, free, refused, declined, sharp (free at both ends, in contact between), sampled states,
            verified; "named off" are refusals whose named state is not within the tolerance, though another one is.
        faults: What was wrong.
    """

    counts: Counter[str] = field(default_factory=Counter)
    faults: list[Fault] = field(default_factory=list)

    def add(self, kind: str, row: int, what: str) -> None:
        """Notes a fault."""
        self.faults.append(Fault(kind, row, what))


def judge(draw: Draw, build: Callable[[], Subject], rng: np.random.Generator, verified: int = 0) -> Judged:
    """Judges all motions of a draw.

    Args:
        draw: The draw.
        build: Makes a new checker of the draw.
        rng: Random numbers: orders, and states to be looked at.
        verified: How many of the accepted motions to prove and verify.

    Returns:
        The outcome.
    """
    judged = Judged()
    fresh, used = build(), build()
    answers = together(fresh, draw, np.arange(len(draw.motions.at)), judged)
    _count(draw, answers, fresh, judged)
    _alike(draw, used, answers, judged, rng)
    _after_few(draw, build, answers, judged, rng)
    _ends_and_contacts(draw, used, answers, judged, rng)
    _sampled(draw, used, answers, judged, rng)
    _least_clearances(draw, used, answers, judged, rng)
    _reasons(draw, used, answers, judged, rng)
    _whereabouts(draw, used, answers, judged)
    if verified:
        _verified(draw, used, answers, judged, verified)
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
            return np.array([_declined(error, int(rows[0]), judged)], dtype=np.int8)
    except Exception as error:
        if len(rows) == 1:
            judged.add(EXCEPTION, int(rows[0]), repr(error))
            return np.array([FAILED], dtype=np.int8)
    half = len(rows) // 2
    return np.concatenate([together(subject, draw, part, judged, threads) for part in (rows[:half], rows[half:])])


def _declined(error: PlannercheckError, row: int, judged: Judged) -> int:
    """Declined, if the error says that numbers are too large or off length 1."""
    words = str(error)
    if "rounding is no small part" in words or "of length 1" in words or "off length 1" in words:
        return DECLINED
    judged.add(EXCEPTION, row, repr(error))
    return FAILED


def _count(draw: Draw, answers: Answers, subject: Subject, judged: Judged) -> None:
    motions = draw.motions
    free_ends = _valid(subject, motions.q0) & _valid(subject, motions.q1)
    inside = (motions.at > 0) & (motions.at < 1)
    judged.counts["motions"] += len(answers)
    for name, answer in (("free", FREE), ("refused", REFUSED), ("declined", DECLINED)):
        judged.counts[name] += int((answers == answer).sum())
    judged.counts["sharp"] += int((free_ends & inside & motions.touching).sum())


def _valid(subject: Subject, q: Floats) -> Bools:
    """(n,) whether states are valid; those that are declined count as valid, since nothing was said of them."""
    try:
        return np.asarray(subject.checker.check_states(q))
    except PlannercheckError:
        if len(q) == 1:
            return np.ones(1, dtype=bool)
    half = len(q) // 2
    return np.concatenate([_valid(subject, q[:half]), _valid(subject, q[half:])])


# ----- the same verdict, however it is asked for


def _alike(draw: Draw, used: Subject, answers: Answers, judged: Judged, rng: np.random.Generator) -> None:
    """The other checker is asked one by one, then together in other orders and batches, then explains."""
    count = len(answers)
    order = rng.permutation(count)
    for row in order[:_SINGLE].tolist():
        _compare("alone", row, _single(used, draw, row, judged), answers, judged)
    for part in np.array_split(rng.permutation(count), _PARTS):
        found = together(used, draw, part, judged, int(rng.integers(1, 3)))
        for row, answer in zip(part.tolist(), found.tolist(), strict=True):
            _compare("in another batch", row, answer, answers, judged)
    proving = _SINGLE if len(used.checker.pairs) <= _MANY_PAIRS else _EXPLAINED
    for k, row in enumerate(order[-_SINGLE:].tolist()):
        proofs = k < proving and bool(rng.integers(2))
        _compare("explained" + " with proofs" * proofs, row, _passage(used, draw, row, judged, proofs), answers, judged)


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
    try:
        free = subject.check_one(draw.motions.q0[row], draw.motions.q1[row], draw.tolerance)
        return FREE if free else REFUSED
    except PlannercheckError as error:
        return _declined(error, row, judged)
    except Exception as error:
        judged.add(EXCEPTION, row, repr(error))
        return FAILED


def _passage(subject: Subject, draw: Draw, row: int, judged: Judged, proofs: bool) -> int:
    try:
        found = subject.passage(draw.motions.q0[row], draw.motions.q1[row], draw.tolerance, proofs)
        return FREE if found.free else REFUSED
    except PlannercheckError as error:
        return _declined(error, row, judged)
    except Exception as error:
        judged.add(EXCEPTION, row, repr(error))
        return FAILED


def _compare(how: str, row: int, answer: int, answers: Answers, judged: Judged) -> None:
    if answer != answers[row]:
        judged.add(HISTORY, row, f"{how} {answer}, by a fresh checker among all {answers[row]}")


# ----- accepted motions collide nowhere


def _ends_and_contacts(draw: Draw, used: Subject, answers: Answers, judged: Judged, rng: np.random.Generator) -> None:
    """Both ends as they were given, and the state of the contact, alone and in company."""
    motions, free = draw.motions, np.flatnonzero(answers == FREE)
    for name, q in (("start", motions.q0), ("end", motions.q1)):
        for row in free[~_valid(used, q[free])].tolist() if len(free) else []:
            judged.add(COLLISION, row, f"its {name} collides")
    _, first = np.unique(motions.through, axis=0, return_index=True)
    known = first[motions.touching[first]]
    if not len(known):
        return
    together_valid = _said(used, motions.through[known])
    for row, valid in zip(known.tolist(), together_valid.tolist(), strict=True):
        if valid == 1 or _said(used, motions.through[row][None])[0] == 1:
            judged.add(COLLISION, row, "a state in contact by construction is called valid")


def _said(subject: Subject, q: Floats) -> NDArray[np.int64]:
    """(n,) 1 valid, 0 not, -1 declined."""
    try:
        return np.asarray(subject.checker.check_states(q)).astype(np.int64)
    except PlannercheckError:
        if len(q) == 1:
            return np.array([-1])
    half = len(q) // 2
    return np.concatenate([_said(subject, q[:half]), _said(subject, q[half:])])


def _sampled(draw: Draw, used: Subject, answers: Answers, judged: Judged, rng: np.random.Generator) -> None:
    """States all along, and close to the contact."""
    free = np.flatnonzero(answers == FREE)
    states = [_states(draw, used, row, _parameters(draw.motions.at[row], rng)) for row in free.tolist()]
    if not states:
        return
    judged.counts["sampled states"] += sum(len(part) for part in states)
    owners = np.repeat(free, [len(part) for part in states])
    colliding = ~_valid(used, np.vstack(states))
    for row in np.unique(owners[colliding]).tolist():
        judged.add(COLLISION, row, "a state on it collides")


def _parameters(at: float, rng: np.random.Generator) -> Floats:
    spread = (np.arange(_SPREAD) + rng.random()) / _SPREAD
    return np.asarray(np.clip(np.concatenate([spread, at + _ASIDE, [0.0, 1.0]]), 0, 1))


def _states(draw: Draw, used: Subject, row: int, parameters: Floats) -> Floats:
    return used.states(draw.motions.q0[row], draw.motions.q1[row], parameters)


def _least_clearances(draw: Draw, used: Subject, answers: Answers, judged: Judged, rng: np.random.Generator) -> None:
    """A search for the state of least clearance, which must not collide."""
    free = np.flatnonzero(answers == FREE)
    chosen = rng.permutation(free)[:_SEARCHED]
    low, high = np.zeros(len(chosen)), np.ones(len(chosen))
    for step in range(_ROUNDS if len(chosen) else 0):
        k = _STATES if step else _FIRST_STATES
        parameters = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, k)
        states = [_states(draw, used, row, t) for row, t in zip(chosen.tolist(), parameters, strict=True)]
        judged.counts["sampled states"] += len(chosen) * k
        clearances = used.clearances(np.vstack(states)).reshape(len(chosen), k)
        found = np.argmin(clearances, axis=1)
        for row in chosen[(clearances <= used.padding).any(axis=1)].tolist():
            judged.add(COLLISION, row, "the state of least clearance collides")
        rows = np.arange(len(chosen))
        low, high = parameters[rows, np.maximum(found - 1, 0)], parameters[rows, np.minimum(found + 1, k - 1)]


# ----- refused motions come within the tolerance


def _reasons(draw: Draw, used: Subject, answers: Answers, judged: Judged, rng: np.random.Generator) -> None:
    """The named state is within the tolerance, or some other; a few are explained in full."""
    refused = np.flatnonzero(answers == REFUSED)
    named = []
    for row in refused.tolist():
        passage = used.passage(draw.motions.q0[row], draw.motions.q1[row], draw.tolerance)
        if passage.free:
            judged.add(HISTORY, row, "refused by a fresh checker among all, explained as free")
        near = passage.near
        named.append(_states(draw, used, row, np.array([min(max(near, 0.0), 1.0)]))[0])
    if not named:
        return
    clearances = used.clearances(np.array(named)) - used.padding
    for row, clearance in zip(refused.tolist(), clearances.tolist(), strict=True):
        slack = (
            _SLACK
            + _SLACK_PER_NUMBER * float(np.abs(draw.motions.q0[row]).max())
            + used.slack(draw.motions.q0[row], draw.motions.q1[row])
        )
        if clearance > draw.tolerance + slack:
            least = _least_clearance(draw, used, row)
            judged.counts["named off"] += 1
            if least > draw.tolerance + slack:
                judged.add(UNREASONED, row, f"its clearance is {least} m, {clearance} m at the state that is named")
    for row in rng.permutation(refused)[:_EXPLAINED].tolist():
        verdict = used.explain(draw.motions.q0[row], draw.motions.q1[row], draw.tolerance)
        if verdict.collides_at is not None:
            state = _states(draw, used, row, np.array([verdict.collides_at]))
            if _valid(used, state)[0] or verdict.collides_at < verdict.free_until:
                judged.add(UNREASONED, row, "the state that is said to collide does not, or lies in the free part")


def _least_clearance(draw: Draw, used: Subject, row: int) -> float:
    """The least clearance along a motion that a search finds, m."""
    low, high, least = 0.0, 1.0, np.inf
    for _ in range(_THOROUGH_ROUNDS):
        parameters = np.linspace(low, high, _THOROUGH_STATES)
        clearances = used.clearances(_states(draw, used, row, parameters)) - used.padding
        found, least = int(np.argmin(clearances)), min(least, float(clearances.min()))
        low, high = parameters[max(found - 1, 0)], parameters[min(found + 1, _THOROUGH_STATES - 1)]
    return least


# ----- motions go where they should


def _whereabouts(draw: Draw, used: Subject, answers: Answers, judged: Judged) -> None:
    """At the parameter of the contact, links are where they are at the state that the motion was laid through."""
    motions = draw.motions
    rows = np.flatnonzero((answers != FAILED) & (answers != DECLINED) & (motions.at > 0) & (motions.at < 1))
    if not len(rows):
        return
    states = np.vstack([_states(draw, used, row, motions.at[row : row + 1]) for row in rows.tolist()])
    found, wanted = used.placed(states), used.placed(motions.through[rows])
    sizes = 1 + np.abs(wanted).max(axis=(1, 2, 3)) * (1 + np.abs(motions.q0[rows]).max(axis=1))
    off = np.abs(found - wanted).max(axis=(1, 2, 3)) / sizes
    for row in rows[off > _SAME_STATE].tolist():
        judged.add(ASTRAY, row, "it does not pass the state that it was laid through")


# ----- proofs


def _verified(draw: Draw, used: Subject, answers: Answers, judged: Judged, count: int) -> None:
    """Proofs of so many accepted motions, verified apart from the core."""
    for row in np.flatnonzero(answers == FREE)[:count].tolist():
        try:
            (proof,) = used.certify(draw.motions.q0[row : row + 1], draw.motions.q1[row : row + 1], draw.tolerance)
            verification = None if proof is None else proof.verify()
        except Exception as error:
            judged.add(EXCEPTION, row, f"proof: {error!r}")
            continue
        judged.counts["verified"] += 1
        if not verification:
            judged.add(PROOF, row, "no proof" if verification is None else str(verification.fault))
