"""Pairs of links whose hulls meet: meshes in the core's batch, beside coal's trees of boxes in a loop of its own.

In: a checker of meshes, configurations. Out: a row for each pair of bodies and verdict. All queries are pairs of random
states, each cold: no plane, no triangles and no guess are left from another query. Hulls that are apart decide before
any mesh is tested, so only pairs whose hulls overlap are asked, with at least one concave body. The time of queries is
the time of a call less the time of an empty call: most pairs have few queries, and both libraries' calls come from
Python.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.evaluation.bench.pair_peers import Judge, coal_at_best
from plannercheck.evaluation.bench.pairs import OURS, in_batch
from plannercheck.evaluation.bench.solid_checkers import is_nested, posed_pair, with_hulls
from plannercheck.evaluation.bench.timing import Contender, available, measured
from plannercheck.motions.checker import Checker

# How many times coal's time over ours is asked for.
ASKED = 8


@dataclass(frozen=True)
class LinkPairRow:
    """Queries of one pair of bodies with one verdict.

    Attributes:
        robot: Its name.
        first: The first body's name.
        second: That of the second.
        triangles: Numbers of triangles of both; of a hull, those of its faces.
        meet: The exact verdict of all these queries.
        queries: Their number.
        microseconds: Our least time a query.
        coal: coal's, at its best; None without it.
        noise: How many times longer the same code took when it ran twice: a smaller ratio says nothing.
        inside: Queries in which one body is inside the other, so that no surfaces meet.
        false_free: Queries that coal calls free though the bodies share points; those inside are among them.
        false_collision: Queries that coal calls colliding though the bodies share none.
        note: How coal was asked.
    """

    robot: str
    first: str
    second: str
    triangles: tuple[int, int]
    meet: bool
    queries: int
    microseconds: float
    coal: float | None
    noise: float
    inside: int
    false_free: int
    false_collision: int
    note: str


@dataclass(frozen=True)
class _Queries:
    """Queries of a pair with one verdict, ready to be judged."""

    pair: int
    meet: bool
    inside: int
    ours: Judge
    coal: Judge | None
    ours_without: Judge
    coal_without: Judge | None
    count: int


def measure(
    checker: Checker, q: Floats, most: int, rounds: int, skipped: Callable[[str], None] = lambda reason: None
) -> list[LinkPairRow]:
    """Times at most so many queries of each pair of meshes by turns: rows by pair, colliding queries first."""
    colliding, poses = with_hulls(checker).colliding_pairs(q), checker.body_poses(q)
    found = [
        each for k in range(len(checker.pairs)) for each in _queries(checker, k, colliding[:, k], poses, most, skipped)
    ]
    if not found:
        return []
    contenders = {f"{k}": Contender([each.ours.work]) for k, each in enumerate(found)}
    contenders |= {f"{k} by coal": Contender([each.coal.work]) for k, each in enumerate(found) if each.coal is not None}
    contenders["call"] = Contender([found[0].ours_without.work])
    if found[0].coal_without is not None:
        contenders["call of coal"] = Contender([found[0].coal_without.work])
    times = measured(contenders, rounds)
    call, call_of_coal = (times.seconds.get(name, 0.0) for name in ("call", "call of coal"))
    rows = []
    for k, each in enumerate(found):
        ours, coal = f"{k}", f"{k} by coal"
        spent_by_coal = times.seconds[coal] - call_of_coal if each.coal is not None else None
        noise = times.noise(ours, ours if each.coal is None else coal)
        rows.append(_row(checker, each, times.seconds[ours] - call, spent_by_coal, noise))
    return rows


def _queries(
    checker: Checker, pair: int, colliding: Bools, poses: Floats, most: int, skipped: Callable[[str], None]
) -> list[_Queries]:
    """The queries of a pair in the states (n,) in which its hulls meet, by verdict."""
    a, b = checker.pairs[pair].tolist()
    bodies = checker.polytopes[a], checker.polytopes[b]
    states = np.flatnonzero(colliding)[:most]
    if bodies[0] is None or bodies[1] is None or not len(states) or not (bodies[0].solid or bodies[1].solid):
        return []
    both = bodies[0], bodies[1]
    make = available("coal", partial(coal_at_best, both), skipped)
    posed = np.ascontiguousarray(poses[states, a]), np.ascontiguousarray(poses[states, b])
    truth = in_batch(both, posed, OURS[0])()
    no_poses = np.zeros((0, 4, 4)), np.zeros((0, 4, 4))
    ours_without, coal_without = in_batch(both, no_poses, OURS[0]), None if make is None else make(no_poses)
    out = []
    for meet in (True, False):
        chosen = posed[0][truth == meet], posed[1][truth == meet]
        if len(chosen[0]):
            inside = sum(is_nested(*both, *each) for each in zip(*chosen, strict=True)) if meet else 0
            coal = None if make is None else make(chosen)
            ours = in_batch(both, chosen, OURS[0])
            out.append(_Queries(pair, meet, inside, ours, coal, ours_without, coal_without, len(chosen[0])))
    return out


def _row(checker: Checker, found: _Queries, ours: float, coal: float | None, noise: float) -> LinkPairRow:
    a, b = checker.pairs[found.pair].tolist()
    p, r, *_ = posed_pair(checker, found.pair, np.zeros((len(checker.bodies), 4, 4)))
    triangles = [len(each.faces) if each.solid is None else len(each.solid.triangles()) for each in (p, r)]
    told = np.zeros(0, dtype=bool) if found.coal is None else found.coal()
    wrong = int((told != found.meet).sum())
    return LinkPairRow(
        checker.robot.name,
        checker.bodies[a].name,
        checker.bodies[b].name,
        (triangles[0], triangles[1]),
        found.meet,
        found.count,
        1e6 * ours / found.count,
        None if coal is None else 1e6 * coal / found.count,
        noise,
        found.inside,
        wrong if found.meet else 0,
        0 if found.meet else wrong,
        "" if found.coal is None else found.coal.note,
    )


def mean(rows: Sequence[LinkPairRow], of: Callable[[LinkPairRow], float | None]) -> float | None:
    """The mean over all queries of rows; None where a row has none, or there are no rows."""
    values = [(of(row), row.queries) for row in rows]
    known = [(value, count) for value, count in values if value is not None]
    if not known or len(known) < len(values):
        return None
    return sum(value * count for value, count in known) / sum(count for _, count in known)
