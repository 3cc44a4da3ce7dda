"""`plannercheck export`: a robot in a scene as a prepared cell, which plannercheck's C++ library reads."""

from __future__ import annotations

import argparse
from pathlib import Path

from plannercheck.cli.common import (
    add_checker_arguments,
    check_folder,
    space_checker,
)
from plannercheck.common.errors import PlannercheckError
from plannercheck.planar.robot_files import is_planar

_EPILOG = """\
Example:
  plannercheck export --robot panda --scene bookshelf --output cell.plannercheck
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    parser.epilog = _EPILOG
    add_checker_arguments(parser)
    parser.add_argument(
        "--output", type=Path, required=True, metavar="FILE", help="where it goes, by custom ….plannercheck"
    )


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    check_folder(options.output)
    if is_planar(options.robot, "robots"):
        raise PlannercheckError("export is for robots in space: the C++ library has no planar robots")
    checker = space_checker(options)
    checker.save(options.output)
    print(f"{options.output}: {checker.robot.name} in {checker.scene.name}, {len(checker.pairs)} pairs")
    return 0
