"""The campaign of pairs of hulls, whose truths are proved in exact arithmetic, independent of the core.

In: a seed, peers. Out: a `PairCampaign`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from plannercheck.bodies.certificates import SharedPoint
from plannercheck.bodies.intersection import certify
from plannercheck.bodies.tuning import METHODS, Method
from plannercheck.evaluation.campaign.pairs import Asked, PairCampaign, Truth
from plannercheck.evaluation.campaign.posed_pairs import ANY_OFFSET, Outcome, batch, limited
from plannercheck.evaluation.campaign.supervised_process import Peer
from plannercheck.evaluation.campaign.tallies import EXCEPTION, TIMEOUT
from plannercheck.evaluation.stress.oracle import Oracle
from plannercheck.evaluation.stress.random_cases import FAMILY_NAMES, GAPS, Draw, numbered_draw
from plannercheck.evaluation.stress.sample_bodies import Specimen, specimen_of
from plannercheck.evaluation.stress.tables import more_lines

# Longest time for one query, s: a thousand times what any should take.
QUERY_LIMIT = 1.0
# Every so many draws the oracle's proofs are held against all vertices, and against another oracle.
THOROUGH_DRAWS = 8
# Every so many draws the core's certificates are asked for and proved by the oracle; and, of one pair of these draws,
# by the package's own `verify`.
CERTIFIED_DRAWS = 4
CERTIFICATE = "certificate"


def campaign(seed: int, peers: tuple[Callable[[], Peer[Draw]], ...] = ()) -> PairCampaign[Specimen]:
    """The campaign of a seed."""
    return PairCampaign(
        "pairs",
        partial(numbered_draw, seed),
        _truth,
        questions,
        specimen_of,
        FAMILY_NAMES,
        (*GAPS, ANY_OFFSET),
        peers,
        more_lines=more_lines,
    )


def _truth(drawn: Draw, number: int) -> Truth:
    return Oracle(drawn).truth(thorough=number % THOROUGH_DRAWS == 0)


def questions(drawn: Draw, truth: list[bool], number: int) -> Asked:
    """All methods, and now and then what the core's certificates prove."""
    asked: Asked = {method: partial(outcomes_of, drawn, method) for method in METHODS}
    if number % CERTIFIED_DRAWS == 0:
        asked[CERTIFICATE] = lambda: _certified(drawn, number)
    return asked


def outcomes_of(drawn: Draw, method: Method) -> list[Outcome]:
    """Of all poses together; one by one if that takes too long or throws."""
    count = len(drawn.poses_p)
    together = limited(lambda: _asked(drawn, method, slice(None)), count, QUERY_LIMIT)
    if together[0] not in (TIMEOUT, EXCEPTION):
        return together
    return [limited(partial(_asked, drawn, method, slice(k, k + 1)), 1, QUERY_LIMIT)[0] for k in range(count)]


def _asked(drawn: Draw, method: Any, some: slice) -> list[Outcome]:
    return batch(drawn.p, drawn.poses_p[some], drawn.r, drawn.poses_r[some], method)


def _certified(drawn: Draw, number: int) -> list[Outcome]:
    """What the core's certificates prove."""
    oracle, count = Oracle(drawn), len(drawn.poses_p)
    outcomes = [proved(oracle, k) for k in range(count)]
    k = number // CERTIFIED_DRAWS % count
    if outcomes[k] != _verified(drawn, k):
        outcomes[k] = EXCEPTION
    return outcomes


def proved(oracle: Oracle, k: int) -> Outcome:
    """What the core's certificate of the k-th pair proves."""
    try:
        shared = oracle.certified(k)
    except Exception:
        return EXCEPTION
    return EXCEPTION if shared is None else shared


def _verified(drawn: Draw, k: int) -> Outcome:
    try:
        certificate = certify(drawn.p.polytope, drawn.r.polytope, drawn.poses_p[k], drawn.poses_r[k])
        return isinstance(certificate, SharedPoint) if certificate.verify() else EXCEPTION
    except Exception:
        return EXCEPTION
