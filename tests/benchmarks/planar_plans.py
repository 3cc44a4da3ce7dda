"""Plans of planar robots, checked by shapely: `python tests/benchmarks/planar_plans.py [--seeds 10]`.

OMPL's RRTConnect plans between the shipped starts and goals, straight and on curves, with motions sampled at 1 cm. Each
path is then followed so that no point of the robot moves further than 1 mm between two states, and shapely says at each
whether the robot touches an obstacle or itself. Counted are states where shapely and plannercheck differ, collisions at
states that were checked when planning, and collisions between them: sampling proves nothing there.
"""

from __future__ import annotations

import argparse
import sys
import time
from itertools import pairwise

import numpy as np
import shapely

import plannercheck as pc
from plannercheck.ompl import plan, space_of

TASKS = [
    ("warehouse", "forklift", "straight", None),
    ("warehouse", "forklift", "reeds_shepp", 1.5),
    ("parking", "forklift", "straight", None),
    ("parking", "forklift", "dubins", 1.5),
    ("parking", "forklift", "reeds_shepp", 1.5),
    ("parking", "truck_trailer", "straight", None),
    ("parking", "truck_trailer", "reeds_shepp", 6.0),
]
FINE = 1e-3  # m
TIME_LIMIT = 20.0  # s


def followed(checker: pc.planar.Checker, path: np.ndarray, space: object) -> tuple[np.ndarray, np.ndarray]:
    """The states (n, nq) of a path at 1 mm, and which of them are corners or were sampled when planning.

    Curved paths consist of all sampled states; straight ones are sampled anew as they were.
    """
    sampler, states, sampled = checker.motion_sampler, [path[:1]], [[True]]
    for a, b in pairwise(path):
        end = a + space.differences(a, b)
        coarse = int(sampler.steps(a[None], end[None], None)[0]) if space.is_straight else 1
        denser = -(-int(sampler.steps(a[None], end[None], FINE)[0]) // coarse)
        steps = np.arange(1, coarse * denser + 1)
        states.append(sampler.states(a, end, steps / steps[-1]))
        sampled.append((steps % denser == 0).tolist())
    return np.concatenate(states), np.concatenate(sampled)


def shapelys_verdicts(checker: pc.planar.Checker, q: np.ndarray) -> np.ndarray:
    """(n,) whether shapely finds no pair of polygons to touch, pair by pair for all states."""
    poses = checker.body_poses(q)
    valid = np.ones(len(q), dtype=bool)
    posed: dict[int, np.ndarray] = {}

    def polygons(k: int) -> np.ndarray:
        if k not in posed:
            body = checker.bodies[k]
            used = poses[:1, k] if body.link < 0 else poses[:, k]
            vertices = np.einsum("nij,vj->nvi", used[:, :2, :2], body.vertices) + used[:, None, :2, 2]
            posed[k] = shapely.polygons(np.concatenate([vertices, vertices[:, :1]], axis=1))
        return posed[k]

    for a, b in checker.pairs.tolist():
        valid &= ~shapely.intersects(polygons(a), polygons(b))
    return valid


def main() -> int:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=10)
    seeds = range(1, parser.parse_args().seeds + 1)
    print(
        "| scene | robot | curve | solved | median s | states at 1 mm | differ | colliding samples | colliding between "
        "| on plans |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for scene, name, curve, radius in TASKS:
        checker = pc.planar.Checker(pc.planar.Robot.load(name), pc.planar.Scene.load(scene))
        space = space_of(checker, curve, radius)
        ends = checker.scene.start(name), checker.scene.goal(name)
        times, states, differ, at_samples, between, plans = [], 0, 0, 0, 0, 0
        for seed in seeds:
            began = time.perf_counter()
            found = plan(checker, *ends, time_limit=TIME_LIMIT, seed=seed, curve=curve, turning_radius=radius)
            if not found.solved:
                continue
            times.append(time.perf_counter() - began)
            q, sampled = followed(checker, found.path, space)
            valid = shapelys_verdicts(checker, q)
            states += len(q)
            differ += int((valid != checker.check_states(q)).sum())
            at_samples += int((~valid & sampled).sum())
            between += int((~valid & ~sampled).sum())
            plans += bool((~valid & ~sampled).any())
        print(
            f"| {scene} | {name} | {curve} | {len(times)} of {len(seeds)} | {np.median(times):.2f} | {states:,} "
            f"| {differ} | {at_samples} | {between} | {plans} |",
            flush=True,
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
