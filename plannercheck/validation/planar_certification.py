"""Certificates for the verdicts on a set of planar configurations, each proved in exact arithmetic apart from the core.

In: a planar checker, configurations and the first colliding pair of each. Out: the same report as in space. An invalid
configuration needs one shared point, a valid one a separating line for every pair.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.certificates import UnprovedVerdictError
from plannercheck.common.array_types import Floats
from plannercheck.planar.certificates import SharedPoint
from plannercheck.planar.checker import Checker
from plannercheck.validation.certification import CertificationReport, Unproved


def certify_verdicts(checker: Checker, q: Floats, first_pair: NDArray[np.int32]) -> CertificationReport:
    """Proves the verdicts on configurations (n, nq), of which `first_pair` (n,) says what collides first, or -1."""
    shared = lines = 0
    unproved: list[Unproved] = []
    for row, (poses, first) in enumerate(zip(checker.body_poses(q), first_pair.tolist(), strict=True)):
        for pair in range(len(checker.pairs)) if first < 0 else [first]:
            if not _is_proved(checker, pair, poses, first >= 0):
                a, b = (checker.bodies[k].name for k in checker.pairs[pair].tolist())
                unproved.append(Unproved(row, a, b, first >= 0))
            elif first >= 0:
                shared += 1
            else:
                lines += 1
    return CertificationReport(len(q), shared, lines, 0, tuple(unproved))


def _is_proved(checker: Checker, pair: int, poses: Floats, colliding: bool) -> bool:
    try:
        certificate = checker.pair_verdict(pair, poses, colliding).certificate
    except UnprovedVerdictError:
        return False
    return isinstance(certificate, SharedPoint) == colliding and certificate.verify()
