"""`plannercheck demo`: the main job on shipped data, by the commands that a user would give; or a moving camera."""

from __future__ import annotations

import argparse
import shlex
import tempfile
from pathlib import Path

from plannercheck.cli.main import main
from plannercheck.cli.unused_options import check_used
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.package_data import shipped_folder
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

_ROBOT, _SCENE = "panda", "bookshelf"

_HOW_TO_GO_ON = """\
How to go on:
  plannercheck robots                                   the other robots
  plannercheck inspect --robot ur5 --scene kitchen      bodies, pairs, and what checking takes
  plannercheck validate --robot panda --scene my_scene.yaml my_configurations.npy
  plannercheck view --robot panda --scene bookshelf --html panda.html     a page to look at, what collides in red
  plannercheck demo --camera                            planning again with every frame of a moving camera
  plannercheck plan --help                              planners, problem sets, verification by FCL
"""


# Frames of the moving camera, and points of each frame.
_FRAMES, _POINTS = 90, 100_000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    parser.add_argument("--camera", action="store_true", help="instead, plan again with every frame of a moving camera")
    parser.add_argument("--frames", type=int, default=_FRAMES, help="of the camera (default: %(default)s)")
    parser.add_argument("--points", type=int, default=_POINTS, help="of each frame (default: %(default)s)")


def run(options: argparse.Namespace) -> int:
    """Runs the command; some samples collide, so that only errors count."""
    if options.camera:
        return _moving_camera(options)
    check_used(options, ("--frames", "--points"), "with --camera")
    samples = shipped_folder("configs") / f"{_SCENE}_{_ROBOT}.npy"
    where = ["--robot", _ROBOT, "--scene", _SCENE]
    with tempfile.TemporaryDirectory() as folder:
        plan = Path(folder) / "plan.csv"
        print("1. Which of 1,000 configurations of a Panda arm collide with a bookshelf or itself?\n")
        codes = [_shown(["validate", *where, "--pairs", "all", str(samples)])]
        print("\n2. How does the arm get out of one compartment and into another?\n")
        codes.append(_shown(["plan", *where, "--seed", "1", "--output", str(plan)]))
        print("\n3. Is every motion of the path free, not only its corners?\n")
        codes.append(_shown(["validate", *where, "--path", str(plan)]))
    print(f"\n{_HOW_TO_GO_ON}", end="")
    return 0 if codes == [1, 0, 0] else max(codes)


def _moving_camera(options: argparse.Namespace) -> int:
    if options.frames < 1 or options.points < 1:
        raise PlannercheckError("--frames and --points must be at least 1")
    from plannercheck.cli.camera_frames import follow  # OMPL's import takes a second

    follow(Robot.load(_ROBOT), Scene.load("table"), options.frames, options.points)
    return 0


def _shown(command: list[str]) -> int:
    """Prints a command as one would type it, then runs it."""
    print(f"$ plannercheck {shlex.join(command)}")
    return main(command)
