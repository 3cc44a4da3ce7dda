"""The core's answers to a draw, by every call that users have.

In: a draw and the oracle's verdicts. Out: outcomes (k,) of each contestant: a verdict, or how it failed.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from plannercheck.bodies.certificates import Separation, SharedPoint
from plannercheck.bodies.distance import distance
from plannercheck.bodies.intersection import certify
from plannercheck.bodies.part_certificates import PartSeparation
from plannercheck.evaluation.campaign.pairs import Asked
from plannercheck.evaluation.campaign.posed_pairs import UNFIT, Outcome, batch, method_of, one_by_one, some_of
from plannercheck.evaluation.stress_parts.draws import Draw
from plannercheck.evaluation.stress_parts.ellipsoid_truth import decide_ellipsoids
from plannercheck.evaluation.stress_parts.truth import decide

BATCH, SWAPPED, SHUFFLED, SINGLE = "batch", "swapped", "shuffled", "single"
CERTIFICATE, DISTANCE, BETWEEN = "certificate", "distance", "between"
OURS = (BATCH, SWAPPED, SHUFFLED, SINGLE, CERTIFICATE, DISTANCE, BETWEEN)
# Of a draw: pairs that are proved, and measured; and in how many draws they are.
_PROVED, _MEASURED = 3, 2
PROVED_DRAWS, MEASURED_DRAWS = 8, 8
# Numbers of draws of which each contestant and each method is asked.
ASK_ALL = (0, MEASURED_DRAWS // 2, PROVED_DRAWS)
# More parts, corners or pairs of parts would take exact arithmetic too long.
_MOST_PROVED, _MOST_CORNERS, _MOST_MEASURED = 70, 300, 1000
# What `plannercheck.distance` promises, over the distance; and what places are rounded by, over both bodies' sizes.
_DISTANCE_ERROR, _LEAST_OF_SIZE = 1e-9, 1e-12


def questions(drawn: Draw, truth: list[bool], number: int) -> Asked:
    """Each way of asking about a draw's pairs, whose verdicts by the oracle are given; UNFIT where a pair is not asked.

    The draw's number chooses the method, and the pairs that are asked one by one. Outcomes (k,) are by contestant; of
    CERTIFICATE, DISTANCE and BETWEEN the truth if what they say is right, else not.
    """
    method, some = method_of(number), some_of(len(drawn.poses_p), number)
    return {
        BATCH: lambda: batch(drawn.p, drawn.poses_p, drawn.r, drawn.poses_r, method),
        SWAPPED: lambda: batch(drawn.r, drawn.poses_r, drawn.p, drawn.poses_p, method),
        SHUFFLED: lambda: _shuffled(drawn, method, number),
        SINGLE: lambda: one_by_one(drawn, some),
        CERTIFICATE: lambda: _certificates(drawn, truth, some, number),
        DISTANCE: lambda: _distances(drawn, truth, some, number),
        BETWEEN: lambda: _between(drawn, truth, method),
    }


def _shuffled(drawn: Draw, method: Any, number: int) -> list[Outcome]:
    """In another order, in which the parts that are tried first are those of other poses."""
    order = np.random.default_rng(number).permutation(len(drawn.poses_p))
    told = batch(drawn.p, drawn.poses_p[order], drawn.r, drawn.poses_r[order], method)
    return [told[k] for k in np.argsort(order).tolist()]


def _certificates(drawn: Draw, truth: list[bool], some: list[int], number: int) -> list[Outcome]:
    outcomes: list[Outcome] = [UNFIT] * len(drawn.poses_p)
    is_large = max(len(body.pieces) for body in (drawn.p, drawn.r)) > _MOST_PROVED
    is_large |= len(drawn.r.pieces) == 1 and len(drawn.r.corners) > _MOST_CORNERS
    if number % PROVED_DRAWS or is_large or drawn.r.solid is not None:
        return outcomes
    for k in some[:_PROVED]:
        found = certify(drawn.p.polytope, drawn.r.polytope, drawn.poses_p[k], drawn.poses_r[k])
        kinds = (SharedPoint,) if truth[k] else (Separation, PartSeparation)
        outcomes[k] = truth[k] == (isinstance(found, kinds) and bool(found.verify()))
    return outcomes


def _distances(drawn: Draw, truth: list[bool], some: list[int], number: int) -> list[Outcome]:
    outcomes: list[Outcome] = [UNFIT] * len(drawn.poses_p)
    is_large = len(drawn.p.pieces) * len(drawn.r.pieces) > _MOST_MEASURED
    if number % MEASURED_DRAWS != MEASURED_DRAWS // 2 or is_large or drawn.r.solid is not None:
        return outcomes
    for k in some[:_MEASURED]:
        outcomes[k] = truth[k] == _is_distance(drawn, k, truth[k])
    return outcomes


def _between(drawn: Draw, truth: list[bool], method: Any) -> list[Outcome]:
    """Whether an ellipsoid is in its outer polytope, and its inner one in the ellipsoid, as far as verdicts tell."""
    themselves = decide_ellipsoids(drawn.p, drawn.poses_p, drawn.r, drawn.poses_r)
    if themselves is None:
        return [UNFIT] * len(drawn.poses_p)
    outer = batch(drawn.p, drawn.poses_p, drawn.r, drawn.poses_r, method)
    p, r = (body.inner or body for body in (drawn.p, drawn.r))
    inner = batch(p, drawn.poses_p, r, drawn.poses_r, method)
    verdicts_of_each = zip(truth, inner, themselves.tolist(), outer, strict=True)
    return [told == (within <= itself <= around) for told, within, itself, around in verdicts_of_each]


def _is_distance(drawn: Draw, k: int, shared: bool) -> bool:
    """Whether the distance is 0 if a point is shared, and else the true one, with its lower bound below.

    Bodies share a point once one of them is inflated by their distance, which exact arithmetic decides.
    """
    pose_p, pose_r = drawn.poses_p[k], drawn.poses_r[k]
    found = distance(drawn.p.polytope, drawn.r.polytope, pose_p, pose_r)
    if shared:
        return found.distance == 0
    lengths = (each for body in (drawn.p, drawn.r) for each in (body.corners, body.radii))
    sizes = max(float(np.abs(given).max()) for given in (*lengths, pose_p, pose_r))
    room = _DISTANCE_ERROR * found.distance + _LEAST_OF_SIZE * sizes
    below, above = max(found.lower_bound, found.distance) - room, found.distance + room
    given = drawn.p.given
    wider = (replace(given, padding=given.padding + max(by, 0.0)) for by in (below, above))
    inflated = [replace(drawn.p, given=each) for each in wider]
    return [bool(decide(p, pose_p[None], drawn.r, pose_r[None])[0]) for p in inflated] == [False, True]
