"""The campaign of pairs of hulls, whose truths are proved in exact arithmetic, independent of the core.

In: a seed, peers. Out: a `PairCampaign`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from plannercheck.bodies.certificates import SharedPoint
from plannercheck.bodies.intersection import certify
from plannercheck.bodies.tuning import METHODS, Method
from plannercheck.evaluation.campaign.pairs import Asked, PairCampaign, Truth
from plannercheck.evaluation.campaign.posed_pairs import ANY_OFFSET, UNFIT, Outcome, batch, limited
from plannercheck.evaluation.campaign.supervised_process import Peer
from plannercheck.evaluation.campaign.tallies import EXCEPTION, FAILURES, TIMEOUT, Tally, total
from plannercheck.evaluation.stress.oracle import BY_INTEGERS, Oracle
from plannercheck.evaluation.stress.random_cases import FAMILY_NAMES, GAPS, Draw, numbered_draw
from plannercheck.evaluation.stress.sample_bodies import Specimen, specimen_of

# Longest time for one query, s: a thousand times what any should take.
QUERY_LIMIT = 1.0
# Every so many draws the oracle's proofs are held against all vertices, and against another oracle.
THOROUGH_DRAWS = 8
# Every so many draws the core's certificates are asked for and proved by the oracle; and, of one pair of these draws,
# by the package's own `verify`.
CERTIFIED_DRAWS = 4
CERTIFICATE = "certificate"

# Columns of the tables by family and gap: every other magnitude keeps them on a page.
_GAP_COLUMNS = ("1e-2", "1e-4", "1e-6", "1e-8", "1e-10", "1e-12", "1e-14", "1e-16", "1e-18", "1 ulp", "0")


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
        more_lines=_more_lines,
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


def _more_lines(tally: Tally[Any], peers: list[str]) -> list[str]:
    """Shares by family and size of the gap, and how many pairs Python's integers had to decide."""
    shares = [line for peer in peers for line in ("", *_shares(tally, peer))]
    return [*shares, "", f"decided by Python's integers: {total(tally.counts, outcome=BY_INTEGERS)}"]


def _shares(tally: Tally[Any], peer: str) -> Iterator[str]:
    """Wrong verdicts of a peer in percent."""
    asked, wrong = Counter[tuple[str, str]](), Counter[tuple[str, str]]()
    for entry, count in tally.counts.items():
        if entry.who == peer and entry.outcome != UNFIT:
            cell = entry.family, entry.offset.lstrip("+-")
            asked[cell] += count
            wrong[cell] += count * (entry.outcome in FAILURES)
    yield f"{peer}: wrong verdicts and exceptions in percent, by size of the gap over that of the smaller body"
    yield " " * 18 + "".join(f"{name:>8}" for name in _GAP_COLUMNS)
    for family in sorted({family for family, _ in asked}):
        cells = ((family, name) for name in _GAP_COLUMNS)
        yield f"{family:18}" + "".join(
            f"{100 * wrong[cell] / asked[cell]:8.1f}" if asked[cell] else f"{'-':>8}" for cell in cells
        )
