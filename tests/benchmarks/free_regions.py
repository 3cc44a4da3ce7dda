"""Boxes of configurations that are proved free, beside drake's IRIS-ZO, whose regions are free with some probability.

In: how many regions. Out: for each method seconds of processor time a region, volumes, and how many sampled states of
the regions collide, of ours a million of each. Run: python tests/benchmarks/free_regions.py --regions 1000
[--cells 1000] [--drake 10]
"""

import argparse
import time

import numpy as np

import plannercheck as pc
from plannercheck.evaluation.bench.distances import free_states
from plannercheck.evaluation.bench.drake_checker import drake_model

_BATCH = 20_000
_ROOM = 1e-3  # m, for the fingers, which are held


def colliding(checker, sample, count: int) -> int:
    """How many of so many states that `sample(n)` draws collide."""
    return sum(int((~checker.check_states(sample(min(_BATCH, count - k)))).sum()) for k in range(0, count, _BATCH))


def ours(checker, q, cells: int, samples: int):
    rng, collide, start = np.random.default_rng(0), 0, time.process_time()
    boxes = checker.free_boxes(q, cells=cells)
    spent = time.process_time() - start
    for k in np.flatnonzero(boxes.proved):
        low, high = boxes.lower[k], boxes.upper[k]
        collide += colliding(checker, lambda n, low=low, high=high: rng.uniform(low, high, (n, len(low))), samples)
    return spent / len(q), boxes.volume, collide


def by_drake(checker, q, samples: int):
    """IRIS-ZO's default options (a twentieth of the region may collide, with some probability)."""
    from pydrake.common import RandomGenerator
    from pydrake.geometry.optimization import HPolyhedron, Hyperellipsoid
    from pydrake.planning import IrisZo, IrisZoOptions

    made, robot, rng = drake_model(checker), checker.robot, np.random.default_rng(0)
    low, high = (robot.expand(np.array([limit]))[0] for limit in (robot.lower, robot.upper))
    held = np.where(high > low, 0.0, _ROOM)  # drake's sampler needs a volume
    domain = HPolyhedron.MakeBox(low - held, high + held)
    volumes, collide, spent = [], 0, 0.0
    for row in q:
        full = robot.expand(row[None])[0]
        start = time.process_time()
        try:
            region = IrisZo(made, Hyperellipsoid.MakeHypersphere(1e-2, full), domain, IrisZoOptions())
        except RuntimeError:  # the state is too near to a collision for its options
            region = None
        spent += time.process_time() - start
        if region is None:
            volumes.append(0.0)
            continue
        moved, still = region.A()[:, : robot.nq], region.A()[:, robot.nq :]
        slice_of_group = HPolyhedron(moved, region.b() - still @ full[robot.nq :])
        volumes.append(slice_of_group.CalcVolumeViaSampling(RandomGenerator(0), 0.1, 1_000_000).volume)
        points = hit_and_run(region, full, rng, samples)
        collide += int((~checker.check_states(points[:, : robot.nq])).sum())
    return spent / len(q), volumes, collide


def hit_and_run(region, start, rng, count: int):
    """States in a polytope {A x <= b}, by hit and run."""
    a, b = region.A(), region.b()
    x, found = start.copy(), np.empty((count, len(start)))
    for k in range(count):
        d = rng.normal(size=len(x))
        d /= np.linalg.norm(d)
        rates, rooms = a @ d, b - a @ x
        ahead, behind = rates > 1e-12, rates < -1e-12
        high, low = (rooms[ahead] / rates[ahead]).min(), (rooms[behind] / rates[behind]).max()
        x = x + rng.uniform(low, high) * d
        found[k] = x
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--regions", type=int, default=100)
    parser.add_argument("--cells", type=int, default=1000)
    parser.add_argument("--samples", type=int, default=1_000_000, help="states of each region of ours")
    parser.add_argument("--drake", type=int, default=0, help="regions that drake makes")
    given = parser.parse_args()
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
    q = free_states(checker, given.regions, 0)
    show(f"free_boxes, {given.cells} cells", len(q), ours(checker, q, given.cells, given.samples))
    if given.drake:
        few = q[: given.drake]
        show("free_boxes, the same", len(few), ours(checker, few, given.cells, 1000))
        show("IrisZo", len(few), by_drake(checker, few, 2000))


def show(name: str, regions: int, found) -> None:
    seconds, volumes, collide = found
    print(
        f"{name}: {regions} regions, {seconds:.3f} s each, volume median {np.median(volumes):.2e}, largest "
        f"{max(volumes):.2e}, none for {sum(v == 0 for v in volumes)}; {collide} sampled states collide",
        flush=True,
    )


if __name__ == "__main__":
    main()
