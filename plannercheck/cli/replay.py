"""`plannercheck replay`: judges again what a gate has judged, and says what differs.

In: files of records, JSON lines, as `plannercheck gate --record` and `GateVerdict.record` write them. Out: a line each.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from plannercheck.cli.common import add_scene_argument, add_settings, space_checker
from plannercheck.cli.robot_options import ROBOT_HELP, add_urdf_arguments
from plannercheck.common.checked_yaml import Node, error_context, read_bytes
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.checker import Checker
from plannercheck.validation.gates.replay import differences, name_of, parse_record

_EPILOG = """\
Exit codes: 0 all verdicts are the same, 1 something differs, 2 bad input, such as a file that holds no records.

Example:
  plannercheck replay judged.jsonl
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    parser.epilog = _EPILOG
    parser.add_argument("files", nargs="+", metavar="FILE", type=Path, help="records, one a line")
    parser.add_argument("--robot", help=f"{ROBOT_HELP}; default: what the record names")
    add_urdf_arguments(parser)
    add_scene_argument(parser, "default: what the record names")
    add_settings(parser)


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    checkers: dict[tuple[str, str], Checker] = {}
    worst = 0
    for path in options.files:
        with error_context(f"file {str(path)!r}"):
            lines = read_bytes(path).decode("utf-8", "replace").splitlines()
        records = [(k, line) for k, line in enumerate(lines, 1) if line.strip()]
        if not records:
            raise PlannercheckError(f"file {str(path)!r} holds no records")
        for k, line in records:
            with error_context(f"file {str(path)!r}, line {k}"):
                record = parse_record(line)
                found = differences(record, _checker(checkers, record, options))
            print(f"{path}, line {k}: {'; '.join(found) or 'the same'}")
            worst = max(worst, 1 if found else 0)
    return worst


def _checker(known: dict[tuple[str, str], Checker], record: Node, options: argparse.Namespace) -> Checker:
    """The checker of the robot and the scene that options or the record name."""
    robot = options.robot or name_of(record, "robot")
    scene = options.scene or name_of(record, "scene")
    if (robot, scene) not in known:
        named = argparse.Namespace(**{**vars(options), "robot": robot, "scene": None if scene == "empty" else scene})
        known[robot, scene] = space_checker(named)
    return known[robot, scene]
