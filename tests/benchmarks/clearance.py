"""Distances of posed polytopes: how accurate they are, and what they cost beside coal's.

Run: python tests/benchmarks/clearance.py accuracy --pairs 10000
     python tests/benchmarks/clearance.py cost --sizes 8 100 1000 10000

Accuracy: random families, sizes and gaps from 1e-12 to 10 sizes; against the exact distance in Python integers, as a
part of max(distance, 1e-3 of the radius). Cost: pairs of round bodies at random poses; the two libraries take turns
(A B B A) and the least time counts. Ours is one call for all poses, coal's is a call from Python a pair, whose cost is
not taken off.
"""

from __future__ import annotations

import argparse
import time

import coal
import numpy as np

import plannercheck as pc
from plannercheck import exact
from plannercheck.core import core
from plannercheck.stress.families import family

FAMILIES = ("box", "round", "cloud", "flat", "needle", "prism")


def random_pose(rng, far):
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    pose = np.eye(4)
    pose[:3, :3] = turn * np.sign(np.linalg.det(turn))
    way = rng.normal(size=3)
    pose[:3, 3] = far * way / np.linalg.norm(way)
    return pose


def accuracy(pairs, seed):
    rng = np.random.default_rng(seed)
    bodies = [pc.Polytope(family(name, n, seed)) for name in FAMILIES for n in (8, 40, 200, 1000)]
    worst, beyond, wrong, apart = 0.0, 0, 0, 0
    for _ in range(pairs):
        first, second = (bodies[k] for k in rng.integers(len(bodies), size=2))
        poses = random_pose(rng, 5.0), random_pose(rng, 0.3)
        far = pc.distance(first, second, *poses)
        gap = 10 ** rng.uniform(-12, 1)
        poses[0][:3, 3] -= (1 - gap / far.distance) * (far.point_p - far.point_r)
        found = pc.distance(first, second, *poses)
        truth = exact.distance(first.vertices, second.vertices, *poses)
        size = max(first.core.radius, second.core.radius)
        error = abs(found.distance - truth) / max(truth, 1e-3 * size)
        worst, beyond = max(worst, error), beyond + (error > 1e-9)
        wrong += (found.distance == 0) != (truth == 0) or found.lower_bound > truth * (1 + 1e-15)
        apart += truth > 0
    print(f"{pairs} pairs, {apart} of them apart: worst error {worst:.1e}, {beyond} beyond 1e-9; wrong bounds {wrong}")


def coal_shape(body):
    points = coal.StdVec_Vec3s()
    for vertex in body.vertices:
        points.append(np.array(vertex))
    return coal.Convex.convexHull(points, False, None)


def cost(sizes, poses_a_size, seed):
    rng = np.random.default_rng(seed)
    print("vertices   ours ns   coal ns")
    for n in sizes:
        bodies = [pc.Polytope(family("box" if n == 8 else "round", n, k)) for k in (1, 2)]
        poses = [np.array([random_pose(rng, far) for _ in range(poses_a_size)]) for far in (2.0, 0.2)]
        shapes = [coal_shape(body) for body in bodies]
        transforms = [[coal.Transform3s(p[:3, :3], p[:3, 3]) for p in side] for side in poses]
        request, result = coal.DistanceRequest(), coal.DistanceResult()

        def ours(bodies=bodies, poses=poses):
            core.distance_batch(bodies[0].core, poses[0], bodies[1].core, poses[1])

        def theirs(shapes=shapes, transforms=transforms, request=request, result=result):
            for a, b in zip(*transforms, strict=True):
                result.clear()
                coal.distance(shapes[0], a, shapes[1], b, request, result)

        times = {ours: [], theirs: []}
        for _ in range(3):
            for run in (ours, theirs, theirs, ours):
                began = time.perf_counter()
                run()
                times[run].append((time.perf_counter() - began) / poses_a_size)
        print(f"{n:8d} {min(times[ours]) * 1e9:9.0f} {min(times[theirs]) * 1e9:9.0f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["accuracy", "cost"])
    parser.add_argument("--pairs", type=int, default=2000)
    parser.add_argument("--poses", type=int, default=1000)
    parser.add_argument("--sizes", type=int, nargs="+", default=[8, 100, 1000, 10000])
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if options.what == "accuracy":
        accuracy(options.pairs, options.seed)
    else:
        cost(options.sizes, options.poses, options.seed)


if __name__ == "__main__":
    main()
