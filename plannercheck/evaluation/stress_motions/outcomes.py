"""The results of the motion stress for a draw: answers, counts and faults; and queries that all judges share.

In: a checker, motions. Out: `Judged`, states on a motion, which states are valid.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress_motions.draws import Draw
from plannercheck.evaluation.stress_motions.subjects import Subject

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

# What errors say that decline a motion.
_DECLINED = ("rounding is no small part", "of length 1", "off length 1", "a unit vector, which is off by")


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
        faults: Kinds of faults of the verdicts.
    """

    counts: Counter[str] = field(default_factory=Counter)
    faults: list[Fault] = field(default_factory=list)

    def add(self, kind: str, row: int, what: str) -> None:
        """Notes a fault."""
        self.faults.append(Fault(kind, row, what))


def said(subject: Subject, q: Floats) -> NDArray[np.int64]:
    """(n,) what is said of states (n, nq): 1 valid, 0 not, -1 declined."""
    try:
        return subject.check_states(q).astype(np.int64)
    except PlannercheckError:
        if len(q) == 1:
            return np.array([-1])
    half = len(q) // 2
    return np.concatenate([said(subject, q[:half]), said(subject, q[half:])])


def valid(subject: Subject, q: Floats) -> Bools:
    """(n,) whether states are valid; those that are declined count as valid, since nothing was said of them."""
    return np.asarray(said(subject, q) != 0)


def states_on(draw: Draw, used: Subject, row: int, parameters: Floats) -> Floats:
    """States (k, nq) on a motion, the row of a draw's, at parameters (k,)."""
    return used.states(draw.motions.q0[row], draw.motions.q1[row], parameters)


def declined(error: PlannercheckError, row: int, judged: Judged) -> int:
    """DECLINED, if the error says that numbers are too large or off length 1; else a fault."""
    words = str(error)
    if any(each in words for each in _DECLINED):
        return DECLINED
    judged.add(EXCEPTION, row, repr(error))
    return FAILED
