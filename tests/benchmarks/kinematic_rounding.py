"""How much posing rounds: `python tests/benchmarks/kinematic_rounding.py [--configurations 100] [--seed 1]`.

For each shipped robot, over random configurations: the farthest point of a body from the robot's base, the largest
distance of a body's vertex from where kinematics in 200 bits puts it, and the proven bound beside it.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from multiprecision import composed, deviation_of_robot, vertices_of

import plannercheck as pc
from plannercheck.evaluation.bench.records import write_record
from plannercheck.robots.description import shipped_robots


def reach(robot: pc.Robot, q: np.ndarray) -> float:
    """Distance of the farthest mapped point from the base over configurations, m."""
    placements = np.array([body.pose[:3] for body in robot.bodies])
    links = [robot.link_index(str(body.link)) for body in robot.bodies]
    poses = [composed(row[links, :3], placements) for row in robot.link_poses(q)]
    return max(
        float(np.linalg.norm(vertices_of(body.shape) @ pose[:, :3].T + pose[:, 3], axis=1).max())
        for row in poses
        for body, pose in zip(robot.bodies, row, strict=True)
    )


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--configurations", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    print("| robot | joints | reach, m | measured, m | bound, m | bound / measured | bound / reach |")
    print("|---|---|---|---|---|---|---|")
    rows: list[dict[str, object]] = []
    for name in shipped_robots():
        robot = pc.Robot.load(name)
        q = robot.random_configurations(options.configurations, options.seed)
        measured, bound, far = deviation_of_robot(robot, q), robot.kinematic_error, reach(robot, q[:10])
        print(
            f"| {name} | {robot.model.njoints - 1} | {far:.2f} | {measured:.1e} | {bound:.1e} "
            f"| {bound / measured:.0f} | {bound / far:.1e} |",
            flush=True,
        )
        rows.append(
            {"robot": name, "joints": robot.model.njoints - 1, "far": far, "measured": measured, "bound": bound}
        )
    if options.output:
        write_record(options.output, rows)


if __name__ == "__main__":
    main()
