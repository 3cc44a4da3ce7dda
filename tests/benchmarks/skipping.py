"""What is skipped, and what that brings: `python tests/benchmarks/skipping.py [--states 2000]`.

For robots in shipped scenes: how many pairs are proved never to meet within the limits, how long that takes, what the
pairs of random states are settled by, and the time of all states without each way of skipping over the time with all of
them. They take turns (A B … B A) in one process; the least CPU time of each counts.
"""

from __future__ import annotations

import argparse
import functools
import time
import warnings
from pathlib import Path

import numpy as np

import plannercheck as pc
from plannercheck.bodies.shapes import inflated_hull
from plannercheck.checking.unreachable_pairs import unreachable_pairs
from plannercheck.cli.inspect import times_without
from plannercheck.common.package_data import example_robot_data
from plannercheck.evaluation.bench.records import write_record
from plannercheck.robots.description import find_description, read_description

CASES = (("panda", "bookshelf"), ("ur5", "kitchen"), ("baxter", "kitchen"), ("talos", "empty"), ("tiago", "empty"))
ROUNDS, REPETITIONS = 21, 3
BOXES, SPANS = 10_000, (1.0, 10.0)


def whole_talos() -> pc.Robot:
    """Talos without a group: all its joints move."""
    description = read_description(find_description("talos"))
    return pc.Robot.from_urdf(description.urdf, description.srdf, package_dirs=example_robot_data())


def many_boxes(span: float) -> pc.Scene:
    """Small boxes within a cube about the robot's base, m."""
    rng, scene = np.random.default_rng(0), pc.Scene(f"{BOXES} boxes within {span:g} m")
    centres = rng.uniform(-span, span, (2 * BOXES, 3))
    for k, centre in enumerate(centres[np.linalg.norm(centres, axis=1) > 0.3][:BOXES]):
        pose = np.eye(4)
        pose[:3, 3] = centre
        scene.add_box(f"box {k}", tuple(rng.uniform(0.02, 0.2, 3)), pose)
    return scene


def proof_time(checker: pc.Checker) -> float:
    """Least CPU seconds that the proof takes."""
    spent, hulls = [], [inflated_hull(body.shape) for body in checker.bodies]
    for _ in range(REPETITIONS):
        start = time.process_time()
        unreachable_pairs(checker.robot, checker.bodies, checker.pairs, hulls)
        spent.append(time.process_time() - start)
    return min(spent)


def show(robot: pc.Robot, scene: pc.Scene, states: int) -> list[dict[str, object]]:
    """Prints one robot in one scene, and gives a row for each way of skipping."""
    rows: list[dict[str, object]] = []
    start = time.process_time()
    checker = pc.Checker(robot, scene)
    built = time.process_time() - start
    gone, static = checker.unreachable, checker.static
    print(f"\n{checker!r}, built in {built:.2f} s of CPU, {proof_time(checker):.2f} s of it for the proof of reach")
    print(f"  {gone.sum()} dropped ({gone.mean():.0%}), of which {(gone & static).sum()} of {static.sum()} at rest")
    q = robot.random_configurations(states, 0)
    spent = times_without(functools.partial(pc.Checker, robot, scene), q, ROUNDS)
    for name, seconds in spent.items():
        ratio = seconds / spent["nothing"]
        print(f"  without {name:14} {1e6 * seconds / states:8.2f} us a state  {ratio:6.2f} x")
        what = {"robot": robot.name, "scene": scene.name, "without": name}
        rows.append({**what, "microseconds": 1e6 * seconds / states, "ratio": ratio})
    return rows


def main() -> None:
    """Prints all cases."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--states", type=int, default=2000)
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    states = options.states
    warnings.simplefilter("ignore")  # bases that stand on floors
    rows: list[dict[str, object]] = []
    for robot, scene in CASES:
        rows += show(pc.Robot.load(robot), pc.Scene.load(scene), states)
    rows += show(whole_talos(), pc.Scene.load("empty"), states)
    for span in SPANS:
        rows += show(pc.Robot.load("panda"), many_boxes(span), states // 4)
    if options.output:
        write_record(options.output, rows)


if __name__ == "__main__":
    main()
