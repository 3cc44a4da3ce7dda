"""The core's answers to a draw, by every call that users have, compared with the oracle.

In: a draw. Out: outcomes (k,) of each contestant: a verdict, or how it failed.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from plannercheck.bodies.distance import distance
from plannercheck.bodies.intersection import intersects
from plannercheck.bodies.solids import Solid
from plannercheck.common.array_types import Floats
from plannercheck.evaluation.campaign.pairs import Asked
from plannercheck.evaluation.campaign.posed_pairs import UNFIT, Outcome, batch, method_of, one_by_one, some_of
from plannercheck.evaluation.stress_solids.bodies import Body, decided
from plannercheck.evaluation.stress_solids.draws import Draw
from plannercheck.evaluation.stress_solids.surfaces import surface

BATCH, SWAPPED, PUBLIC, SINGLE, DISTANCE, POINTS = "batch", "swapped", "public", "single", "distance", "points"
CAPS = "caps"
OURS = (BATCH, SWAPPED, PUBLIC, SINGLE, DISTANCE, POINTS, CAPS)
# What `plannercheck.distance` promises: its error over the distance, or over a part of the larger body's radius, for
# which its size stands here; and in m.
_DISTANCE_ERROR, _LEAST_OF_RADIUS, _SMALLEST_ERROR = 1e-9, 1e-3, 1e-319
# Points of which it is asked whether a solid of a draw contains them.
_POINTS = 4


def questions(drawn: Draw, truth: list[bool], number: int) -> Asked:
    """Each way of asking about a draw's pairs, whose verdicts by the oracle are given; UNFIT where a pair is not asked.

    The draw's number chooses the method, and the pairs that are asked one by one. Outcomes (k,) are by contestant; of
    DISTANCE, POINTS and CAPS, which are asked for more than verdicts, the truth if all that they say is right, else
    not.
    """
    method, single = method_of(number), some_of(len(drawn.poses_p), number)
    return {
        BATCH: lambda: batch(drawn.p, drawn.poses_p, drawn.r, drawn.poses_r, method),
        SWAPPED: lambda: _with_inner_shapes(drawn, method),
        PUBLIC: lambda: _public(drawn),
        SINGLE: lambda: one_by_one(drawn, single),
        DISTANCE: lambda: _distances(drawn, truth, single),
        POINTS: lambda: _of_single_solids(drawn, truth, number),
        CAPS: lambda: _between(drawn, truth),
    }


def _with_inner_shapes(drawn: Draw, method: Any) -> list[Outcome]:
    """The other way round, and with what is inside of bodies known, as it is to checkers: that may tell first."""
    for body in (drawn.p, drawn.r):
        body.polytope.core.inner_shapes()
    return batch(drawn.r, drawn.poses_r, drawn.p, drawn.poses_p, method)


def _public(drawn: Draw) -> list[Outcome]:
    """As users give them: a `Solid` that is prepared in the call."""
    p, r = (body.polytope if body.inflation_radius else body.given for body in (drawn.p, drawn.r))
    return list(np.asarray(intersects(p, r, drawn.poses_p, drawn.poses_r)).tolist())


def _distances(drawn: Draw, truth: list[bool], some: list[int]) -> list[Outcome]:
    outcomes: list[Outcome] = [UNFIT] * len(drawn.poses_p)
    for k in some:
        outcomes[k] = truth[k] == _is_distance(drawn, k, truth[k])
    return outcomes


def _is_distance(drawn: Draw, k: int, shared: bool) -> bool:
    """Whether the distance is 0 if and only if a point is shared, and else the true one, with its lower bound below.

    Bodies share a point once they are inflated by their distance, which exact arithmetic decides.
    """
    p, r, pose_p, pose_r = drawn.p, drawn.r, drawn.poses_p[k], drawn.poses_r[k]
    found = distance(p.polytope, r.polytope, pose_p, pose_r)
    if shared or found.distance == 0:
        return shared == (found.distance == 0)
    if p.inflation_radius:  # a sum of radii would be rounded
        return True
    tolerance = _DISTANCE_ERROR * max(found.distance, _LEAST_OF_RADIUS * max(p.size, r.size)) + _SMALLEST_ERROR
    below = min(float(np.nextafter(found.lower_bound, 0.0)), found.distance)
    least, most = max(below, found.distance - tolerance), found.distance + tolerance
    inflated = (replace(p, inflation_radius=max(radius, 0.0)) for radius in (least, most))
    within = [bool(decided(body, pose_p[None], r, pose_r[None])[0]) for body in inflated]
    return within == [False, True] and found.lower_bound <= found.distance


def _of_single_solids(drawn: Draw, truth: list[bool], number: int) -> list[Outcome]:
    """Whether they are closed, how many components they have, whether they contain some points."""
    is_right = all(_solid_is_right(body, np.random.default_rng(number)) for body in (drawn.p, drawn.r))
    return [shared == is_right for shared in truth]


def _solid_is_right(body: Body, rng: np.random.Generator) -> bool:
    given = body.given
    if not isinstance(given, Solid):
        return True
    told = (given.core.is_closed, given.core.components, given.is_closed)
    if told != (body.truth.is_closed, body.truth.components, body.truth.is_closed):
        return False
    bare = replace(body, inflation_radius=0.0)
    return all(bool(given.core.contains(point)) == _contains(bare, point) for point in _points_near(body, rng))


def _between(drawn: Draw, truth: list[bool]) -> list[Outcome]:
    """Whether triangles without caps share a point only if the solids do, and these only if their hulls do.

    The oracle decides all three.
    """
    p, r = drawn.p, drawn.r
    if not (p.is_capped or r.is_capped):
        return [UNFIT] * len(truth)
    alone = decided(p.triangles_alone, drawn.poses_p, r.triangles_alone, drawn.poses_r) != 0
    hulls = decided(p.hull, drawn.poses_p, r.hull, drawn.poses_r) != 0
    rows = zip(alone.tolist(), truth, hulls.tolist(), strict=True)
    return [shared == (few <= shared <= most) for few, shared, most in rows]


def _points_near(body: Body, rng: np.random.Generator) -> Floats:
    """Corners, middles of pairs of corners, and any points between them, (_POINTS, 3), m."""
    ends = body.surface.used_points[rng.integers(0, len(body.surface.used_points), (2, _POINTS))]
    share = rng.choice([0.0, 0.5, rng.uniform(0, 1)], (_POINTS, 1))
    return np.asarray(ends[0] + share * (ends[1] - ends[0]))


def _contains(body: Body, point: Floats) -> bool:
    single = Body("point", surface(point[None], [[0, 0, 0]]))
    pose = np.eye(4)[None]
    return bool(decided(single, pose, body, pose)[0])
