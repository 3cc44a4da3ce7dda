"""Time for a pair of bodies against its vertices and gap, beside coal, python-fcl and MuJoCo.

In: numbers of vertices. Out: a row for each method, size and gap. Bodies are round (all points are vertices). Poses are
random: a random feature of one body at the gap from one of the other. plannercheck is timed by the core's batch call,
each pair cold (no cached plane), and one by one from Python. coal is timed by `computeCollisions` of a Pinocchio
geometry model with as many pairs, without early stop, so that no Python is timed, each pair cold as well; and by a C++
loop with coal's best settings. FCL and MuJoCo are called from Python.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from plannercheck.bodies.intersection import intersects
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.tuning import Method, pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.bench.pair_peers import COAL, PEERS, Bodies, Judge, JudgeMaker, Posed
from plannercheck.evaluation.bench.timing import Contender, available, measured
from plannercheck.evaluation.stress.body_families import family
from plannercheck.evaluation.stress.contact_poses import Solid, contact_poses

SIZES = (8, 32, 150, 1000, 10_000, 100_000)
# Relative to the bodies' size of 1 m: far apart, near contact, deep inside each other.
GAPS = (0.5, 1e-4, -0.3)
# How many times faster than coal's loop the goals are, by vertices: at the first gap and at the second.
ASKED = {8: (4, 2), 32: (8, 3), 150: (10, 4), 1000: (15, 5), 10_000: (30, 10), 100_000: (70, 25)}
_HALF_AXES = np.array([1.0, 0.7, 0.5])
OURS: tuple[Method, ...] = ("oracle", "walk")
FROM_PYTHON, IN_ONE_CALL = "plannercheck, intersects from Python", "plannercheck, intersects in one call"


@dataclass(frozen=True)
class PairRow:
    """What one method did on pairs of one size at one gap.

    Attributes:
        vertices: Number of vertices of each body.
        gap: Relative to the bodies' size.
        method: Its name.
        microseconds: The least time a pair.
        coal_ratio: coal's time over that; None without coal.
        noise: How many times longer the same code took when it ran twice: a smaller ratio says nothing.
        asked: The ratio that is asked for; None where none is.
        wrong: Verdicts that differ from the exact ones.
        pairs: Pairs in a round.
        note: How it was asked, where that differs from run to run.
    """

    vertices: int
    gap: float
    method: str
    microseconds: float
    coal_ratio: float | None
    noise: float
    asked: int | None
    wrong: int
    pairs: int
    note: str


def measure(
    sizes: Sequence[int],
    pairs: int,
    rounds: int,
    skipped: Callable[[str], None] = lambda reason: None,
    ellipsoids: bool = False,
) -> list[PairRow]:
    """Times all methods by turns: on so many pairs of each size, at least 4 vertices, and gap; rows by size and gap.

    `ellipsoids`: points are on ellipsoids, which balls bound less closely, not on spheres.
    """
    rows = []
    for vertices in sizes:
        first, second = (family("round", vertices, seed) * (_HALF_AXES if ellipsoids else 1.0) for seed in (1, 2))
        bodies = Polytope(first), Polytope(second)
        solids = [Solid("round", p.vertices, np.asarray(p.faces, dtype=np.int64)) for p in bodies]
        rng = np.random.default_rng(vertices)
        at = f" at {len(bodies[0].vertices)} vertices"
        ready = ((name, available(name, partial(make, bodies), skipped, at)) for name, make in PEERS)
        peers = {name: make for name, make in ready if make is not None}
        for gap in GAPS:
            wished = np.full(pairs, gap * min(solid.size for solid in solids))
            rows += _measured(bodies, peers, contact_poses(solids[0], solids[1], wished, rng), gap, rounds)
    return rows


def growth(rows: Sequence[PairRow], method: str, smallest: int = 150) -> float | None:
    """Time near contact at the most vertices over that at `smallest`; None if either is missing."""
    near = {row.vertices: row.microseconds for row in rows if row.method == method and row.gap == GAPS[1]}
    return near[max(near)] / near[smallest] if smallest in near and max(near) > smallest else None


def _measured(bodies: Bodies, peers: Mapping[str, JudgeMaker], posed: Posed, gap: float, rounds: int) -> list[PairRow]:
    judges = {f"plannercheck, {method}": in_batch(bodies, posed, method) for method in OURS}
    judges |= {FROM_PYTHON: _from_python(bodies, posed), IN_ONE_CALL: _in_one_call(bodies, posed)}
    judges |= {name: make(posed) for name, make in peers.items()}
    truth = in_batch(bodies, posed, "exact")()
    wrong = {name: int((judge() != truth).sum()) for name, judge in judges.items()}
    pairs, vertices = len(truth), len(bodies[0].vertices)
    times = measured({name: Contender([judge.work], pairs) for name, judge in judges.items()}, rounds)
    coal = times.seconds.get(COAL)
    return [
        PairRow(
            vertices,
            gap,
            name,
            1e6 * spent,
            None if coal is None else coal / spent,
            times.noise(name, name if coal is None else COAL),
            ASKED[vertices][GAPS.index(gap)] if name in _BEST and vertices in ASKED and gap > 0 else None,
            wrong[name],
            pairs,
            judges[name].note,
        )
        for name, spent in times.seconds.items()
    ]


_BEST = f"plannercheck, {OURS[0]}"


def in_batch(bodies: Bodies, posed: Posed, method: Method) -> Judge:
    """Pairs of two bodies in the core's batch, each cold."""
    options = pair_options(method, cached_plane=False)
    p, r = (body.core for body in bodies)
    return Judge(
        lambda: core.intersect_batch(p, posed[0], r, posed[1], options),
        lambda found: np.asarray(found[0]).astype(bool),
    )


def _from_python(bodies: Bodies, posed: Posed) -> Judge:
    """As a user calls it, pair by pair, with poses as arrays."""
    p, r = bodies
    poses = list(zip(*posed, strict=True))
    return Judge(
        lambda: [intersects(p, r, a, b) for a, b in poses],
        lambda found: np.array(found, dtype=bool),
        "pc.intersects, poses as arrays",
    )


def _in_one_call(bodies: Bodies, posed: Posed) -> Judge:
    """As a user calls it for many poses."""
    p, r = bodies
    return Judge(
        lambda: intersects(p, r, *posed),
        lambda found: np.asarray(found, dtype=bool),
        "pc.intersects, poses as two arrays (n, 4, 4)",
    )
