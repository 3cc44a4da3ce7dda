"""Distances of posed polytopes: how accurate they are, and what they cost beside coal's.

Run: python tests/benchmarks/clearance.py accuracy --pairs 10000
     python tests/benchmarks/clearance.py cost --sizes 8 32 150 1000 10000

Accuracy: random families, sizes and gaps from 1e-12 to 10 radii, as a part of max(distance, 1e-3 of the larger radius).
The truth lies between two numbers that owe nothing to the library's walks: the gap of all vertices along a direction,
by brute force, and the length between two mixtures of vertices with weights that are solved for here. Both are off by a
few rounding errors of the coordinates (1e-15 of the size). Where they are not close enough together, and for every
EXACT_EVERY-th pair, the truth is computed in Python integers.

Cost: pairs of round bodies at random poses; the libraries take turns (A B B A) and the least time counts, each in one
call for all poses: ours by the batch, coal's by Pinocchio's computeDistances over as many geometry objects at these
poses (which is C++ alone). All start cold: Pinocchio would have coal start from the same pair's last answer, which at
the same poses is the answer.
"""

import argparse
import time
import warnings
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
from scipy.optimize import lsq_linear

import plannercheck as pc
from plannercheck.bodies import exact_reference as exact
from plannercheck.bodies.coal_bodies import coal_hull
from plannercheck.common.core import core
from plannercheck.evaluation.bench.records import write_record
from plannercheck.evaluation.stress.body_families import family

FAMILIES = ("box", "round", "cloud", "flat", "needle", "prism")
COUNTS = (8, 40, 200, 1000)
RADII = (1e-2, 1.0, 30.0)  # m
EXACT_EVERY = 100
PROMISE, LEAST_PART = 1e-9, 1e-3
# Vertices within this part of the size of the nearest one count as its face: far above rounding.
FACE = 1e-11


def random_poses(rng, n, far):
    """(n, 4, 4) random turns, translations of one length."""
    w, x, y, z = (q := rng.normal(size=(4, n))) / np.linalg.norm(q, axis=0)
    poses = np.zeros((n, 4, 4))
    poses[:, 0, 0], poses[:, 0, 1], poses[:, 0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    poses[:, 1, 0], poses[:, 1, 1], poses[:, 1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    poses[:, 2, 0], poses[:, 2, 1], poses[:, 2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    way = rng.normal(size=(n, 3))
    poses[:, :3, 3] = far * way / np.linalg.norm(way, axis=1)[:, None]
    poses[:, 3, 3] = 1
    return poses


def mixture(points, target, face):
    """The point nearest to the target that some weights mix from points near it (k, 3)."""
    moved = (points - target) / face
    rows = np.vstack([moved.T, np.ones(len(points))])
    weights = lsq_linear(rows, np.array([0.0, 0, 0, 1]), (0, np.inf), method="bvls", tol=1e-15).x
    return (weights / weights.sum()) @ moved * face + target


class Judge:
    """Counts how far answers are off the truth."""

    def __init__(self):
        self.pairs = self.apart = self.beyond = self.wrong = self.exactly = 0
        self.worst, self.worst_exact = 0.0, 0.0

    def batch(self, first, second, poses_p, poses_r):
        """Answers for n pairs of poses of two bodies."""
        overlap, found, lower, on_p, on_r, along = core.distance_batch(first.core, poses_p, second.core, poses_r)
        size = max(body.core.radius for body in (first, second))
        heights = [
            body.vertices @ (poses[:, :3, :3].transpose(0, 2, 1) @ (sign * along[:, :, None]))[:, :, 0].T
            for body, poses, sign in ((first, poses_p, 1), (second, poses_r, -1))
        ]
        offsets = np.einsum("ij,ij->i", along, poses_p[:, :3, 3] - poses_r[:, :3, 3])
        gaps = (heights[0].min(axis=0) + heights[1].min(axis=0) + offsets) / np.linalg.norm(along, axis=1)
        for i in range(len(found)):
            self.pairs += 1
            room = PROMISE * max(found[i], LEAST_PART * size) / (1 + PROMISE)
            by_brackets = not overlap[i] and self.pairs % EXACT_EVERY and gaps[i] > 0
            if by_brackets:
                ends = [
                    self._mixed(body, pose[i], column[:, i], point[i], size)
                    for body, pose, column, point in (
                        (first, poses_p, heights[0], on_p),
                        (second, poses_r, heights[1], on_r),
                    )
                ]
                above = float(np.linalg.norm(ends[0] - ends[1]))
                error = max(abs(found[i] - gaps[i]), abs(found[i] - above))
                if error <= room and lower[i] <= above + 1e-14 * (size + found[i]):
                    self.apart += 1
                    self.worst = max(self.worst, PROMISE * error / room)
                    continue
            self._exact(first, second, poses_p[i], poses_r[i], overlap[i], found[i], lower[i], size)

    @staticmethod
    def _mixed(body, pose, heights, point, size):
        near = np.flatnonzero(heights <= heights.min() + FACE * size)
        posed = body.vertices[near] @ pose[:3, :3].T + pose[:3, 3]
        return posed[0] if len(near) == 1 else mixture(posed, point, size)

    def _exact(self, first, second, pose_p, pose_r, overlap, found, lower, size):
        self.exactly += 1
        truth = exact.distance(first.vertices, second.vertices, pose_p, pose_r)
        error = abs((0.0 if overlap else found) - truth) / max(truth, LEAST_PART * size)
        self.worst_exact, self.beyond = max(self.worst_exact, error), self.beyond + (error > PROMISE)
        self.wrong += bool(overlap) != (truth == 0) or lower > truth * (1 + 1e-15)
        self.apart += truth > 0

    def report(self):
        """Prints what was found so far."""
        print(
            f"{self.pairs} pairs, {self.apart} of them apart: worst error {self.worst:.1e} by brackets, "
            f"{self.worst_exact:.1e} of the {self.exactly} in exact arithmetic; {self.beyond} beyond {PROMISE:g}, "
            f"wrong bounds or verdicts {self.wrong}",
            flush=True,
        )


def accuracy(pairs, seed, block=50):
    rng = np.random.default_rng(seed)
    shapes = [family(name, n, seed + k) for name in FAMILIES for k, n in enumerate(COUNTS)]
    bodies = [pc.Polytope(vertices * radius) for vertices in shapes for radius in RADII]
    judge, reported = Judge(), 0
    while judge.pairs < pairs:
        first, second = (bodies[k] for k in rng.integers(len(bodies), size=2))
        size = max(first.core.radius, second.core.radius)
        poses_p, poses_r = random_poses(rng, block, 5.0 * size), random_poses(rng, block, 0.3 * size)
        _, far, _, on_p, on_r, _ = core.distance_batch(first.core, poses_p, second.core, poses_r)
        gap = size * 10 ** rng.uniform(-12, 1, block)
        poses_p[:, :3, 3] -= (1 - gap / far)[:, None] * (on_p - on_r)
        judge.batch(first, second, poses_p, poses_r)
        if judge.pairs >= reported + 100_000:
            reported = judge.pairs
            judge.report()
    judge.report()


def all_distances(bodies, poses):
    """Functions that have Pinocchio measure all pairs of poses with coal, and that return the distances (n,) then."""
    model, geometry = pin.Model(), pin.GeometryModel()
    shapes = [coal_hull(body, "a body") for body in bodies]
    for i, pair in enumerate(zip(*poses, strict=True)):
        objects = [pin.GeometryObject(f"{i} {k}", 0, pin.SE3(pose), shapes[k]) for k, pose in enumerate(pair)]
        geometry.addCollisionPair(pin.CollisionPair(*(geometry.addGeometryObject(item) for item in objects)))
    data, geometry_data = model.createData(), geometry.createData()
    pin.updateGeometryPlacements(model, data, geometry, geometry_data, np.zeros(0))
    for request in geometry_data.distanceRequests:
        request.gjk_initial_guess = coal.GJKInitialGuess.DefaultGuess
        if hasattr(request, "enable_cached_gjk_guess"):
            request.enable_cached_gjk_guess = False

    def measure():
        pin.computeDistances(geometry, geometry_data)

    def distances():
        measure()
        return np.array([result.min_distance for result in geometry_data.distanceResults])

    return measure, distances


def cost(sizes, poses_a_size, seed):
    rng, rows = np.random.default_rng(seed), []
    print(f"{'vertices':>8s} {'gap':>6s} {'ours ns':>9s} {'coal ns':>9s} {'ratio':>6s}   off by at most: ours, coal")
    for n in sizes:
        bodies = [pc.Polytope(family("box" if n == 8 else "round", n, k)) for k in (1, 2)]
        for gap in (1.0, 0.1, 0.001):  # of a radius
            rows.append(cost_at(n, bodies, gap, poses_a_size, rng))
    return rows


def cost_at(n, bodies, gap, count, rng):
    size = max(body.core.radius for body in bodies)
    poses = random_poses(rng, count, 5.0 * size), random_poses(rng, count, 0.2 * size)
    _, far, _, on_p, on_r, _ = core.distance_batch(bodies[0].core, poses[0], bodies[1].core, poses[1])
    poses[0][:, :3, 3] -= (1 - gap * size / far)[:, None] * (on_p - on_r)
    theirs, distances = all_distances(bodies, poses)

    def ours():
        return core.distance_batch(bodies[0].core, poses[0], bodies[1].core, poses[1])

    truths = [exact.distance(bodies[0].vertices, bodies[1].vertices, poses[0][i], poses[1][i]) for i in range(10)]
    off = [np.abs(found[:10] - truths).max() for found in (ours()[1], distances())]
    times = {ours: [], theirs: []}
    for _ in range(5):
        for run in (ours, theirs, theirs, ours):
            began = time.process_time()
            run()
            times[run].append((time.process_time() - began) / count)
    mine, coals = min(times[ours]) * 1e9, min(times[theirs]) * 1e9
    print(f"{n:8d} {gap:6g} {mine:9.0f} {coals:9.0f} {coals / mine:6.2f}   {off[0]:.0e} m, {off[1]:.0e} m", flush=True)
    return {"vertices": n, "gap": gap, "ours": mine, "coal": coals, "ours_off": off[0], "coal_off": off[1]}


def main():
    warnings.simplefilter("ignore", DeprecationWarning)  # coal's, of a switch that has to be off
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["accuracy", "cost"])
    parser.add_argument("--pairs", type=int, default=2000)
    parser.add_argument("--poses", type=int, default=1000)
    parser.add_argument("--sizes", type=int, nargs="+", default=[8, 32, 150, 1000, 10000])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows of cost as JSON")
    options = parser.parse_args()
    if options.what == "accuracy":
        accuracy(options.pairs, options.seed)
    else:
        rows = cost(options.sizes, options.poses, options.seed)
        if options.output:
            write_record(options.output, rows)


if __name__ == "__main__":
    main()
