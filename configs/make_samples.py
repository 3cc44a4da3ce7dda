"""Writes the sample configuration sets of the shipped scenes, always the same.

In: the scenes in this folder, with a start and a goal for each robot. Out: <scene>_<robot>.npy, (1000, nq):
600 configurations uniform within the joint limits, then 400 around the straight motion from start to goal,
where verdicts are closest.

Run it with `python configs/make_samples.py` from a checkout after changing a scene's start or goal.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plannercheck import planar
from plannercheck.common.package_data import is_planar_file
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

UNIFORM = 600
NEAR = 400

# Spread of the samples around the motion, rad (and m): a few link widths at the hand.
SPREAD = 0.25


def samples(
    robot: Robot | planar.Robot, start: NDArray[np.float64], goal: NDArray[np.float64], seed: int
) -> NDArray[np.float64]:
    """Makes the samples (UNIFORM + NEAR, nq) for one robot in one scene."""
    rng = np.random.default_rng(seed)
    along = rng.uniform(size=(NEAR, 1))
    near = start + along * (goal - start) + SPREAD * rng.normal(size=(NEAR, len(start)))
    return np.vstack([robot.random_configurations(UNIFORM, seed), np.clip(near, robot.lower, robot.upper)])


def main() -> None:
    """Writes a file for each scene and robot."""
    folder = Path(__file__).parent
    files = sorted(folder.glob("*.yaml"))
    for number, path in enumerate(path for path in files if not is_planar_file(path)):
        scene = Scene.load(path)
        for name in scene.states:
            rows = samples(Robot.load(name), scene.start(name), scene.goal(name), seed=number)
            np.save(folder / f"{path.stem}_{name}.npy", rows)
    for number, path in enumerate(path for path in files if is_planar_file(path)):
        flat = planar.Scene.load(path)
        for name in flat.states:
            robot = planar.Checker(planar.Robot.load(name), flat).robot  # within the scene's bounds
            rows = samples(robot, flat.start(name), flat.goal(name), seed=number)
            np.save(folder / f"{path.stem}_{name}.npy", rows)


if __name__ == "__main__":
    main()
