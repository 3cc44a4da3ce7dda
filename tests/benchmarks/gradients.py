"""Gradients of distances beside derivatives in 300 bits, for the shipped robots.

In: robots, how many states. Out: a line for each robot: rows looked at, share of `unique`, worst error of a gradient
and of a distance where it is. Run: python tests/benchmarks/gradients.py --states 10000 [--robots panda ur5 ...]
"""

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from gradient_oracle import Differences, NoSingleFeatureError, scene_around

import plannercheck as pc

ROBOTS = ("panda", "ur3", "ur5", "ur10", "xarm7", "kinova", "baxter", "tiago", "pr2", "talos", "g1", "go2")


def measured(name: str, states: int, seed: int, rows_a_state: int = 1):
    """(rows, share of unique ones, compared, left open by the oracle, worst error of gradients, of distances)."""
    robot = pc.Robot.load(name)
    checker = pc.Checker(robot, scene_around(robot, seed))
    q = robot.random_configurations(states, seed=seed)
    table = checker.distances(q)
    differences, rng = Differences(checker), np.random.default_rng(seed)
    chosen = np.flatnonzero(table.unique)
    starts = rng.permutation(chosen)[: rows_a_state * states]
    worst = worst_distance = 0.0
    undecided = compared = 0
    for k in starts.tolist():
        try:
            found, apart = differences.gradient(
                q[table.state[k]], int(table.pair[k]), table.normal[k], table.distance[k]
            )
        except NoSingleFeatureError:
            undecided += 1
            continue
        compared += 1
        worst = max(worst, float(np.abs(found - table.gradient[k]).max()))
        worst_distance = max(worst_distance, abs(apart - table.distance[k]))
    return len(table), float(table.unique.mean()), compared, undecided, worst, worst_distance


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--states", type=int, default=1000)
    parser.add_argument("--robots", nargs="*", default=ROBOTS)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    print("robot       rows   unique  compared  open  gradient  distance, m")
    for name in given.robots:
        rows, unique, compared, undecided, worst, apart = measured(name, given.states, given.seed)
        print(
            f"{name:10s} {rows:6d}  {unique:6.1%}  {compared:8d} {undecided:5d}  {worst:8.1e}  {apart:8.1e}", flush=True
        )


if __name__ == "__main__":
    main()
