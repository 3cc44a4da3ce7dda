"""A pair of solids near contact, and their preparation, against the number of their triangles.

In: numbers of triangles. Out: a row for each shape, size, gap and method. The hulls of all pairs meet, so that their
trees of triangles have to decide. Bodies are turned at random, put together so that their surfaces cross, and taken
apart along a line, again and again halved, until they only just touch; there one is moved by the gap.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.protrusion import prepared_solid
from plannercheck.bodies.solids import Solid
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench.build_cost import built
from plannercheck.evaluation.bench.compiled_coal_loop import library
from plannercheck.evaluation.bench.pair_peers import COAL_AT_BEST, Bodies, Judge, Posed, coal_at_best
from plannercheck.evaluation.bench.pairs import OURS, in_batch
from plannercheck.evaluation.bench.timing import Contender, TimedRow, available, measured
from plannercheck.evaluation.stress.contact_poses import identities, random_directions, turns_onto
from plannercheck.evaluation.stress_solids.solid_families import Family, screw, torus

SIZES = (1000, 10_000, 100_000, 1_000_000)
# Over the body's size: apart along the line, and crossing.
GAPS = (1e-4, -1e-4)
SHAPES: dict[str, Family] = {"torus": torus, "screw": screw}
# How many times its time at the smallest size a query may take at the largest.
ASKED = 4
OURS_NAME = "plannercheck"
_SEED = 22
# Places along the line at which the bodies may be apart, over their size; at the last they are.
_AWAY = np.array([0.06, 0.15, 0.3, 0.5, 0.8, 4.0])
_HALVINGS = 40
# Poses that are tried for each that is wanted, as hulls do not meet at all of them.
_TRIED = 4


@dataclass(frozen=True)
class SolidSizeRow(TimedRow):
    """What one method did on pairs of one shape, size and gap.

    Attributes:
        shape: Its name; both bodies have it.
        triangles: Number of triangles of each body.
        gap: How far the bodies were moved apart from where they touch, over their size.
        meet: Part of the pairs that share points.
        wrong: Verdicts that differ from ours.
        pairs: Pairs in a round.
        preparation: Seconds of the processor that a body's preparation took.
        of_hull: Those of them for its hull; None where there is none.
        bytes_a_triangle: Memory of a body, over its triangles; None where the system does not tell.
        note: How it was asked.
    """

    shape: str
    triangles: int
    gap: float
    meet: float
    wrong: int
    pairs: int
    preparation: float
    of_hull: float | None
    bytes_a_triangle: float | None
    note: str


def measure(
    sizes: Sequence[int],
    shapes: Sequence[str],
    pairs: int,
    rounds: int,
    skipped: Callable[[str], None] = lambda reason: None,
) -> list[SolidSizeRow]:
    """Times all methods by turns, on so many pairs of each shape, of about these numbers of triangles, and gap."""
    with suppress(PlannercheckError):  # which coal's judge raises again
        library()  # compiled now, not while building is timed
    rows = []
    for shape, size in product(shapes, sizes):
        surface = SHAPES[shape](size, np.random.default_rng(_SEED))
        solid = Solid(surface.points, surface.triangles, "triangles")
        ours, hull = built(partial(prepared_solid, solid)), built(partial(Polytope, solid.used[0]))
        bodies = ours.value, ours.value
        building = partial(built, partial(coal_at_best, bodies))
        coal = available(COAL_AT_BEST, building, skipped, f" at {size} triangles")
        costs: dict[str, _Cost] = {OURS_NAME: (ours.busy, hull.busy, ours.value.nbytes)}
        if coal is not None:
            costs[COAL_AT_BEST] = (coal.busy, None, coal.resident)
        rng = np.random.default_rng(_SEED)
        for gap, posed in _near_contact(bodies, pairs, rng).items():
            judges = {OURS_NAME: in_batch(bodies, posed, OURS[0])}
            if coal is not None:
                judges[COAL_AT_BEST] = coal.value(posed)
            rows += _timed(shape, len(solid.triangles), gap, judges, costs, rounds)
    return rows


def growth(rows: Sequence[SolidSizeRow], shape: str, gap: float, method: str) -> float | None:
    """The time at the most triangles over that at the fewest; None with a single size."""
    times = {
        row.triangles: row.microseconds for row in rows if (row.shape, row.gap, row.method) == (shape, gap, method)
    }
    return times[max(times)] / times[min(times)] if len(times) > 1 else None


_Cost = tuple[float, float | None, int | None]


def _timed(
    shape: str, triangles: int, gap: float, judges: dict[str, Judge], costs: dict[str, _Cost], rounds: int
) -> list[SolidSizeRow]:
    truth = judges[OURS_NAME]()
    contenders = {name: Contender([judge.work], len(truth)) for name, judge in judges.items()}
    times = measured(contenders, rounds)
    rows = []
    for name, judge in judges.items():
        busy, of_hull, memory = costs[name]
        rows.append(
            SolidSizeRow(
                *times.row(name),
                shape,
                triangles,
                gap,
                float(truth.mean()),
                int((judge() != truth).sum()),
                len(truth),
                busy,
                of_hull,
                None if memory is None else memory / triangles,
                judge.note,
            )
        )
    return rows


def _near_contact(bodies: Bodies, count: int, rng: np.random.Generator) -> dict[float, Posed]:
    """By gap, at most so many poses of both bodies near contact at which their hulls meet."""
    tried = _TRIED * count
    solid, size = bodies[0].solid, float(np.ptp(bodies[0].vertices, axis=0).max())
    assert solid is not None
    corners = solid.points()[rng.integers(0, len(solid.points()), (2, tried))]
    turns = np.asarray(turns_onto(random_directions(tried, rng), random_directions(tried, rng), rng), dtype=np.float64)
    directions = random_directions(tried, rng)
    meeting = corners[1] - np.einsum("nij,nj->ni", turns, corners[0])

    def posed(along: Floats) -> Posed:
        poses = identities(tried)
        poses[:, :3, :3], poses[:, :3, 3] = turns, meeting + along[:, None] * directions
        return poses, identities(tried)

    def meet(both: Bodies, along: Floats) -> Bools:
        return in_batch(both, posed(along), OURS[0])()

    apart = np.full(tried, size * _AWAY[-1])
    for away in size * _AWAY[-2::-1]:
        apart[~meet(bodies, np.full(tried, away))] = away
    touching = np.zeros(tried)
    for _ in range(_HALVINGS):
        middle = (touching + apart) / 2
        shared = meet(bodies, middle)
        touching, apart = np.where(shared, middle, touching), np.where(shared, apart, middle)
    hulls = Polytope(bodies[0].vertices, bodies[0].faces)
    out = {}
    for gap in GAPS:
        along = touching + gap * size
        chosen = np.flatnonzero(meet((hulls, hulls), along))[:count]
        p, r = posed(along)
        out[gap] = p[chosen], r[chosen]
    return out
