"""What a changed scene costs: a checker that follows another one, against one that is built from scratch.

Run: python tests/benchmarks/changing_scenes.py. Prints CPU milliseconds, the least of some rounds by turns, with a warm
disk cache; one obstacle of the scene is moved, added, or attached to the last link. The states and pairs judged are the
same; `prepared` counts the bodies that a change prepared.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

import plannercheck as pc
from plannercheck.bodies.shapes import Cylinder
from plannercheck.checking import prepared_bodies
from plannercheck.cli.common import table
from plannercheck.evaluation.bench.records import write_record

CASES = (("panda", "bookshelf"), ("ur5", "kitchen"), ("pr2", "kitchen"), ("talos", "kitchen"))


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    warnings.simplefilter("ignore", RuntimeWarning)
    header = (
        "robot",
        "scene",
        "pairs",
        "from scratch",
        "moved",
        "added",
        "attached",
        "moved while attached",
        "prepared",
    )
    rows = [_row(*case, options.rounds) for case in CASES]
    print(table(header, rows))
    if options.output:
        write_record(options.output, [dict(zip(header, row, strict=True)) for row in rows])


def _row(robot_name: str, scene_name: str, rounds: int) -> tuple[object, ...]:
    robot, scene = pc.Robot.load(robot_name), pc.Scene.load(scene_name)
    prepared = _counted()
    checker = pc.Checker(robot, scene)
    carrying = checker.attach("can", Cylinder(0.03, 0.1), robot.bodies[-1].link or "", _at(0, 0, 0.2))
    prepared.clear()
    rng = np.random.default_rng(0)
    steps: dict[str, Callable[[], object]] = {
        "scratch": lambda: pc.Checker(robot, scene),
        "moved": lambda: checker.with_scene(_moved(checker, rng)),
        "added": lambda: checker.with_scene(_added(checker, rng)),
        "attached": lambda: checker.attach("tin", Cylinder(0.03, 0.1), robot.bodies[-1].link or "", _at(0, 0, 0.2)),
        "both": lambda: carrying.with_scene(_moved(carrying, rng)),
    }
    best = dict.fromkeys(steps, np.inf)
    for _ in range(rounds):
        for name, step in steps.items():
            before = len(prepared)
            began = time.thread_time()
            step()
            best[name] = min(best[name], time.thread_time() - began)
            if name in ("scratch", "added", "attached"):
                del prepared[before:]  # new bodies are prepared there
    milliseconds = [f"{1e3 * seconds:.1f}" for seconds in best.values()]
    return robot_name, scene_name, len(checker.pairs), *milliseconds, len(prepared)


def _counted() -> list[str]:
    """Names of the bodies that are prepared from now on."""
    names: list[str] = []

    def counted(prepare: Callable[..., object]) -> Callable[..., object]:
        def call(points: object, faces: object, inflation_radius: float, name: str) -> object:
            names.append(name)
            return prepare(points, faces, inflation_radius, name)

        return call

    prepared_bodies.Polytope = counted(prepared_bodies.Polytope)  # type: ignore[misc,assignment]
    prepared_bodies.prepared = counted(prepared_bodies.prepared)  # type: ignore[assignment]
    return names


def _moved(checker: pc.Checker, rng: np.random.Generator) -> pc.Scene:
    scene = checker.scene.copy()
    scene.move(scene.object_names[-1], _at(*rng.uniform(0.3, 0.8, 3)))
    return scene


def _added(checker: pc.Checker, rng: np.random.Generator) -> pc.Scene:
    scene = checker.scene.copy()
    scene.add_box("new", rng.uniform(0.05, 0.2, 3).tolist(), _at(*rng.uniform(0.3, 0.8, 3)))
    return scene


def _at(x: float, y: float, z: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


if __name__ == "__main__":
    main()
