"""Rounds and time of the hardest pairs, not of the mean: `python tests/benchmarks/worst_pairs.py [--largest 100000]`.

For families that are hard for tests of two hulls and 100 to 100,000 vertices: the 50th and 99th percentile and the most
of rounds and of processor time a pair, by the default, by the paper's walk, by python-fcl and by coal in Pinocchio's
loop. Poses are at gaps from 1e-3 of the size to nothing. Each pair is cold, and is timed by itself: the least of a few
repetitions.
"""

import argparse
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

import plannercheck as pc
from plannercheck.bodies.tuning import Method, pair_options
from plannercheck.common.array_types import Floats
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench.pair_peers import COAL, Judge, coal_in_pinocchio, fcl_ready
from plannercheck.evaluation.bench.records import write_record
from plannercheck.evaluation.stress.body_families import family, rim_points
from plannercheck.evaluation.stress.contact_poses import Solid, contact_poses

GAPS = np.array([1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0.0, -1e-12, -1e-9, -1e-6, -1e-3])
EXACT = 6  # the number of the stage in cpp/narrow_phase/pair_frame.hpp
PERCENTILES = (50, 99, 100)
REPEATED, ROUNDS = {"default": 64, "walk": 64, "FCL": 2, COAL: 2}, 3
METHODS: Mapping[str, Method] = {"default": "oracle", "walk": "walk"}


def stack(n: int, seed: int) -> Floats:
    """A barrel of rings whose facets turn by little from one to the next."""
    rings = max(3, int(np.sqrt(n) / 4))
    heights = np.linspace(-0.5, 0.5, rings)
    rim = rim_points(n // rings, 0.37 * seed)
    return np.concatenate([np.column_stack([0.3 * (1 - 1e-4 * z * z) * rim, np.full(len(rim), z)]) for z in heights])


def cap(n: int, seed: int) -> Floats:
    """A shallow cap of a sphere of radius 10, over the polygon of its rim."""
    rng = np.random.default_rng(seed)
    radius, angle = np.sqrt(rng.uniform(0, 1, n)), rng.uniform(0, 2 * np.pi, n)
    x, y = 0.5 * radius * np.cos(angle), 0.5 * radius * np.sin(angle)
    return np.column_stack([x, y, np.sqrt(100 - x * x - y * y) - 10])


FAMILIES: Mapping[str, Callable[[int, int], Floats]] = {
    "needles": lambda n, seed: family("needle", n, seed),
    "stacks": stack,
    "common sphere": lambda n, seed: family("round", n, seed),
    "kissing caps": cap,
}


def least(work: Callable[[], object], repeated: int) -> float:
    """Processor time of one of the repeated tests, us."""
    best = np.inf
    for _ in range(ROUNDS):
        start = time.thread_time()
        work()
        best = min(best, time.thread_time() - start)
    return 1e6 * best / repeated


def spread(values: Sequence[float]) -> list[float]:
    """The percentiles."""
    return [float(each) for each in np.percentile(values, PERCENTILES)]


def measured(name: str, vertices: int, pairs: int, peers: bool) -> list[dict[str, object]]:
    """The rows of one family at one size."""
    bodies = tuple(pc.Polytope(FAMILIES[name](vertices, seed)) for seed in (1, 2))
    solids = [Solid(name, body.vertices, body.faces.astype(np.int64)) for body in bodies]
    gaps = np.resize(GAPS, pairs) * min(solid.size for solid in solids)
    posed = contact_poses(*solids, gaps, np.random.default_rng(vertices))
    p, r = (body.core for body in bodies)
    rounds: dict[str, list[float]] = {}
    microseconds: dict[str, list[float]] = {}
    exact: dict[str, int] = {}
    makers = {}
    if peers:
        for peer, make in (("FCL", fcl_ready), (COAL, coal_in_pinocchio)):
            try:
                makers[peer] = make((bodies[0], bodies[1]))
            except (PlannercheckError, ImportError) as error:
                print(f"{peer} is left out: {error}")
    for a, b in zip(*posed, strict=True):
        for title, method in METHODS.items():
            options = pair_options(method, cached_plane=False)
            _, stages, counters = core.intersect_batch(p, a[None], r, b[None], options)
            rounds.setdefault(title, []).append(counters["rounds"])
            exact[title] = exact.get(title, 0) + int(stages[0] == EXACT)
            many = [np.repeat(pose[None], REPEATED[title], axis=0) for pose in (a, b)]
            spent = least(lambda m=many, o=options: core.intersect_batch(p, m[0], r, m[1], o), REPEATED[title])
            microseconds.setdefault(title, []).append(spent)
        for title, maker in makers.items():
            few = [np.repeat(pose[None], REPEATED[title], axis=0) for pose in (a, b)]
            judge: Judge = maker((few[0], few[1]))
            microseconds.setdefault(title, []).append(least(judge.work, REPEATED[title]))
    return [
        {
            "family": name,
            "vertices": len(bodies[0].vertices),
            "method": title,
            "rounds": spread(rounds[title]) if title in rounds else None,
            "microseconds": spread(spent),
            "exact": exact.get(title),
        }
        for title, spent in microseconds.items()
    ]


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--largest", type=int, default=100_000, help="largest number of vertices")
    parser.add_argument("--pairs", type=int, default=200, help="pairs of each family and size")
    parser.add_argument("--no-peers", action="store_true", help="leave the other libraries out")
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    print("                                         rounds: 50 %, 99 %, most       us: 50 %, 99 %, most     exact")
    rows = []
    for name in FAMILIES:
        for vertices in (10**k for k in range(2, 7) if 10**k <= options.largest):
            for row in measured(name, vertices, options.pairs, not options.no_peers):
                rows.append(row)
                of_rounds = "".join(f"{each:8.0f}" for each in row["rounds"] or ())
                of_time = "".join(f"{each:10.2f}" for each in row["microseconds"])
                print(
                    f"{name:14s} {row['vertices']:8d} {row['method']:16s} {of_rounds:24s} {of_time} "
                    f"{'' if row['exact'] is None else row['exact']:>6}",
                    flush=True,
                )
    if options.output:
        write_record(options.output, rows)


if __name__ == "__main__":
    main()
