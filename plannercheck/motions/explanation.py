"""One motion explained: how far it is proved free, where it collides first, by which pair, and the certificates.

In: a checker, a motion. Out: a `MotionVerdict`. The certifier finds where the motion comes within the tolerance. From
there on, states are checked exactly to find the first one that collides.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from plannercheck.checking.protocols import AnyChecker
from plannercheck.checking.verdicts import MotionProof, MotionVerdict, PairVerdict
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct
from plannercheck.motions.certifier_answers import MotionResult, Proof
from plannercheck.proofs.proof import Proof as WholeProof

States: TypeAlias = Callable[[Floats], Floats]

# Where a motion is no longer proved free, this many states are checked over the rest of it, and this many close by, at
# distances that grow from the least one (in parameters).
_SPREAD = 2000
_CLOSE = 200
_LEAST_STEP = 1e-9

# The first colliding parameter is bisected until it no longer changes in doubles, at most this often.
_MOST_HALVINGS = 60


def explained_motion(
    checker: AnyChecker,
    result: MotionResult,
    states: States,
    tolerance: float,
    prover: Callable[[], WholeProof | None] | None = None,
) -> MotionVerdict:
    """The verdict of a motion, in space or in the plane, from the certifier's answer.

    `states` are a function from parameters (k,) to states (k, nq); `prover` returns the proof of the motion, if it is
    free.
    """
    named = tuple(_named(checker, proof) for proof in result.proofs)
    if result.free:
        return MotionVerdict(True, tolerance, 1.0, None, None, None, named, prover)
    collides_at = _first_collision(checker, states, result)
    pair = _stopping_pair(checker, states, result, collides_at)
    return MotionVerdict(False, tolerance, result.free_until, collides_at, result.near, pair, named)


def _first_collision(checker: AnyChecker, states: States, result: MotionResult) -> float | None:
    """The first parameter that is found to collide."""
    begin = result.free_until
    close = begin + np.geomspace(_LEAST_STEP, 1.0, _CLOSE)
    parameters = distinct(np.concatenate([[begin, result.near, 1.0], np.linspace(begin, 1.0, _SPREAD), close]))
    parameters = parameters[(parameters >= begin) & (parameters <= 1)]
    colliding = np.flatnonzero(~checker.check_states(states(parameters)))
    if not len(colliding):
        return None
    first = int(colliding[0])
    low, high = float(parameters[max(first - 1, 0)]), float(parameters[first])
    for _ in range(_MOST_HALVINGS):
        middle = (low + high) / 2
        if not low < middle < high:
            break
        if checker.check_states(states(np.array([middle])))[0]:
            low = middle
        else:
            high = middle
    return high


def _stopping_pair(checker: AnyChecker, states: States, result: MotionResult, collides_at: float | None) -> PairVerdict:
    state = states(np.array([result.near if collides_at is None else collides_at]))[0]
    if collides_at is not None:
        return checker.explain(state).collisions[0]
    return checker.explain_pair(result.pair, state)


def _named(checker: AnyChecker, proof: Proof) -> MotionProof:
    first, second = checker.pair_names(proof.pair)
    a, b = (int(k) for k in checker.pairs[proof.pair])
    frame = None if proof.frame < 0 else checker.robot.link_names[proof.frame]
    normal = -proof.direction if proof.flipped else proof.direction
    return MotionProof(first, second, a, b, proof.start, proof.end, frame, normal, proof.gap, proof.chord_deviation)
