"""Checks of answers: refusals have a reason, motions pass the right states, proofs are verified.

In: a draw with the answers to its motions. Out: faults.
"""

from __future__ import annotations

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress_motions.draws import Draw
from plannercheck.evaluation.stress_motions.outcomes import (
    ASTRAY,
    DECLINED,
    EXCEPTION,
    FAILED,
    FREE,
    HISTORY,
    PROOF,
    REFUSED,
    UNREASONED,
    Answers,
    Judged,
    declined,
    states_on,
    valid,
)
from plannercheck.evaluation.stress_motions.recipes import is_of_solids
from plannercheck.evaluation.stress_motions.subjects import Subject

# States, and rounds, of a search for the least clearance of a refusal that seems to have no reason.
_STATES, _ROUNDS = 513, 4
# Refusals may name a state that is this much further away than the tolerance, m, and the same per largest number:
# what distances and poses are rounded by.
_SLACK, _SLACK_PER_NUMBER = 1e-8, 1e-13
# Poses of the state that a motion passes agree up to this, m per m and rad.
_SAME_STATE = 1e-9
# Refused motions of a draw that are explained in full.
_EXPLAINED = 1
# Refused motions of solids that are asked for their reason, which takes much longer than of hulls.
_OF_SOLIDS = 12
# What is told where surfaces come too near to each other for a proof.
_NOT_FOUND = "no proof of it was found"

# ----- refused motions come within the tolerance


def reasons(draw: Draw, used: Subject, answers: Answers, judged: Judged, rng: np.random.Generator) -> None:
    """The named state is within the tolerance, or some other; a few are explained in full."""
    refused = np.flatnonzero(answers == REFUSED)
    if is_of_solids(draw.recipe):
        refused = rng.permutation(refused)[:_OF_SOLIDS]
    named = []
    for row in refused.tolist():
        result = used.motion_result(draw.motions.q0[row], draw.motions.q1[row], draw.tolerance)
        if result.free:
            judged.add(HISTORY, row, "refused by a fresh checker among all, explained as free")
        near = result.near
        named.append(states_on(draw, used, row, np.array([min(max(near, 0.0), 1.0)]))[0])
    if not named:
        return
    clearances = used.clearances(np.array(named)) - used.padding
    for row, clearance in zip(refused.tolist(), clearances.tolist(), strict=True):
        most = refused_within(draw, used, draw.motions.q0[row], draw.motions.q1[row])
        if clearance > most:
            least = least_clearance(used, draw.motions.q0[row], draw.motions.q1[row])
            judged.counts["named off"] += 1
            if least > most:
                judged.add(UNREASONED, row, f"its clearance is {least} m, {clearance} m at the state that is named")
    for row in rng.permutation(refused)[:_EXPLAINED].tolist():
        verdict = used.explain(draw.motions.q0[row], draw.motions.q1[row], draw.tolerance)
        if verdict.collides_at is not None:
            state = states_on(draw, used, row, np.array([verdict.collides_at]))
            rounding = used.rounding(draw.motions.q0[row])
            apart = valid(used, state)[0] and (not rounding or used.clearances(state)[0] - used.padding > rounding)
            if apart or verdict.collides_at < verdict.free_until:
                judged.add(UNREASONED, row, "the state that is said to collide does not, or lies in the free part")


def refused_within(draw: Draw, used: Subject, q0: Floats, q1: Floats) -> float:
    """A motion that keeps further away than this may not be refused, m."""
    return draw.tolerance + _SLACK + _SLACK_PER_NUMBER * float(np.abs(q0).max()) + used.slack(q0, q1)


def least_clearance(used: Subject, q0: Floats, q1: Floats) -> float:
    """The least clearance along a motion that a search finds, m."""
    low, high, least = 0.0, 1.0, np.inf
    for _ in range(_ROUNDS):
        parameters = np.linspace(low, high, _STATES)
        clearances = used.clearances(used.states(q0, q1, parameters)) - used.padding
        found, least = int(np.argmin(clearances)), min(least, float(clearances.min()))
        low, high = parameters[max(found - 1, 0)], parameters[min(found + 1, _STATES - 1)]
    return least


# ----- motions go where they should


def whereabouts(draw: Draw, used: Subject, answers: Answers, judged: Judged) -> None:
    """At the parameter of the contact, links are where they are at the state that the motion was laid through."""
    motions = draw.motions
    rows = np.flatnonzero((answers != FAILED) & (answers != DECLINED) & (motions.at > 0) & (motions.at < 1))
    if not len(rows):
        return
    states = np.vstack([states_on(draw, used, row, motions.at[row : row + 1]) for row in rows.tolist()])
    found = used.placed(used.nearest(states, motions.through[rows], motions.q1[rows]))
    wanted = used.placed(motions.through[rows])
    sizes = 1 + np.abs(wanted).max(axis=(1, 2, 3)) * (1 + np.abs(motions.q0[rows]).max(axis=1))
    off = np.abs(found - wanted).max(axis=(1, 2, 3)) / sizes
    for row in rows[off > _SAME_STATE].tolist():
        judged.add(ASTRAY, row, "it does not pass the state that it was laid through")


# ----- proofs


def verified(draw: Draw, used: Subject, answers: Answers, judged: Judged, count: int) -> None:
    """Proofs of so many accepted motions, verified apart from the core.

    There may be none where rounding hides what keeps pairs apart that a verdict leaves out: that is counted.
    """
    for row in np.flatnonzero(answers == FREE)[:count].tolist():
        q0, q1 = draw.motions.q0[row], draw.motions.q1[row]
        try:
            (proofs,) = used.certify(q0[None], q1[None], draw.tolerance)
            if proofs is None and used.motion_result(q0, q1, draw.tolerance, proofs=True).proved_until < 1:
                judged.counts["no proof"] += 1
                continue
            verifications = [proof.verify() for proof in proofs or ()]
        except PlannercheckError as error:
            if _NOT_FOUND in str(error):
                judged.counts["no proof"] += 1
            else:
                declined(error, row, judged)
            continue
        except Exception as error:
            judged.add(EXCEPTION, row, f"proof: {error!r}")
            continue
        judged.counts["verified"] += 1
        faults = [str(each.fault) for each in verifications if not each]
        if faults or not verifications:
            judged.add(PROOF, row, faults[0] if faults else "no proof")
