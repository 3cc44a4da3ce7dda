"""Gradients of distances beside derivatives in 300 bits, for the shipped robots.

In: robots, how many states, with `--parts` also a solid, a cloud and a grid in the scene, and links as solids. Out: a
line for each robot and kind of rows (hulls apart, hulls that overlap, pairs with parts apart): how many rows, the share
of `unique`, worst error of a gradient and of a distance where it is.
Run: python tests/benchmarks/gradients.py --states 10000 [--parts] [--robots panda ur5 ...]
"""

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from gradient_oracle import Differences, NoSingleFeatureError, scene_around

import plannercheck as pc

ROBOTS = ("panda", "ur3", "ur5", "ur10", "xarm7", "kinova", "baxter", "tiago", "pr2", "talos", "g1", "go2")


def measured(name: str, states: int, seed: int, parts: bool):
    """For each kind of rows (rows, share of unique ones, compared, left open by the oracle, worst error of gradients,
    of distances)."""
    robot = pc.Robot.load(name, geometry="solid" if parts else None)
    checker = pc.Checker(robot, scene_around(robot, seed, parts))
    q = robot.random_configurations(states, seed=seed)
    table = checker.distances(q)
    differences, rng = Differences(checker), np.random.default_rng(seed)
    convex = np.array([body.traits.is_convex for body in checker.polytopes])
    hulls = convex[checker.pairs].all(axis=1)[table.pair]
    apart = table.distance > 0
    kinds = {"apart": hulls & apart, "overlap": hulls & ~apart, "parts": ~hulls & apart}
    for kind, rows in kinds.items():
        if not rows.any():
            continue
        worst = worst_distance = 0.0
        undecided = compared = 0
        for k in rng.permutation(np.flatnonzero(table.unique & rows))[:states].tolist():
            try:
                found, distance = differences.gradients(
                    q[table.state[k]], int(table.pair[k]), table.normal[k], table.distance[k]
                )
            except NoSingleFeatureError:
                undecided += 1
                continue
            compared += 1
            worst = max(worst, float(np.abs(found - table.gradient[k]).max()))
            worst_distance = max(worst_distance, abs(distance - table.distance[k]))
        yield kind, rows.sum(), float(table.unique[rows].mean()), compared, undecided, worst, worst_distance


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--states", type=int, default=1000)
    parser.add_argument("--robots", nargs="*", default=ROBOTS)
    parser.add_argument("--parts", action="store_true")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    print("robot      kind       rows   unique  compared  open  gradient  distance, m")
    for name in given.robots:
        for kind, rows, unique, compared, undecided, worst, apart in measured(
            name, given.states, given.seed, given.parts
        ):
            counts = f"{rows:6d}  {unique:6.1%}  {compared:8d} {undecided:5d}"
            print(f"{name:10s} {kind:8s} {counts}  {worst:8.1e}  {apart:8.1e}", flush=True)


if __name__ == "__main__":
    main()
