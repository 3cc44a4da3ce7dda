"""Paths of several robots on one clock: `--path left=a.yaml right=b.yaml --delay right=1.5`.

In: options. Out: by robot a file, or the numbers (k,) at which it stands; when each starts; for `validate`, what came
of judging the cell's trajectory.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from plannercheck.checking.protocols import AnyChecker
from plannercheck.cli.proved_paths import check_proof_file, write_proofs
from plannercheck.cli.told_certificates import certificate_as_json
from plannercheck.cli.trajectory_files import trajectory_of
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.motions.checker import Checker
from plannercheck.timing.conflicts import Conflict, first_conflict
from plannercheck.trajectories.one_clock import Run

# Where the proof of a cell is written without --proof, beside the first file.
_PROOF = "cell.proof.json"


def add_delay_argument(group: argparse._ActionsContainer) -> None:
    """Adds --delay."""
    group.add_argument(
        "--delay",
        nargs="+",
        metavar="ROBOT=S",
        help="for --path ROBOT=FILE of a cell's robots, on one clock: when a trajectory starts, s; default: 0. "
        "A robot that stands has its configuration in place of a file: --path left=a.yaml right=0,0.5,…",
    )


def is_of_cell(paths: Sequence[Path] | None) -> bool:
    """Whether --path has files by robot."""
    return any(path.parts and "=" in path.parts[0] and not path.exists() for path in paths or ())


def parts_of(options: argparse.Namespace) -> dict[str, Path | list[float]]:
    """By robot the file, or where it stands."""
    found: dict[str, Path | list[float]] = {}
    for path in options.path:
        name, is_named, value = str(path).partition("=")
        if not is_named or name in found:
            raise PlannercheckError(f"--path takes one ROBOT=FILE for each robot of a cell, not {str(path)!r}")
        try:
            found[name] = [float(word) for word in value.split(",")]
        except ValueError:
            found[name] = Path(value)
    return found


def delays_of(options: argparse.Namespace) -> dict[str, float]:
    """By robot when its trajectory starts, s."""
    found = {}
    for given in options.delay or ():
        name, _, value = given.partition("=")
        if name in found:
            raise PlannercheckError(f"--delay says twice when {name!r} starts: give one time")
        try:
            found[name] = float(value)
        except ValueError:
            raise PlannercheckError(f"--delay takes ROBOT=SECONDS, e.g. right=1.5, not {given!r}") from None
    return found


def judge_cell(options: argparse.Namespace, checker: AnyChecker) -> int:
    """Judges trajectories of a cell's robots on one clock; 0 if they are proved free, else 1."""
    parts = parts_of(options)
    if not isinstance(checker, Checker) or not checker.robot.parts:
        raise PlannercheckError(f"--path ROBOT=FILE is of a cell's robots, and {checker.robot.name!r} is no cell")
    runs: dict[str, Run] = {}
    for name, part in parts.items():
        if name not in checker.robot.parts:
            raise unknown_name("robot of the cell", name, checker.robot.parts)
        robot = checker.robot.parts[name].robot
        runs[name] = part if isinstance(part, list) else trajectory_of(part, robot, options.controller)
    files = [part for part in parts.values() if isinstance(part, Path)]
    file = options.proof or files[0].with_name(_PROOF) if files else options.proof
    if options.certify and file is not None:
        check_proof_file(file, files)
    tube = 0.0 if options.tube is None else options.tube
    found = first_conflict(checker, runs, delays_of(options), tube, options.tolerance)
    proved = write_proofs(found.proof, file, "piece") if options.certify and found.free and file is not None else None
    if options.format == "json":
        print(json.dumps([_as_json(found, parts) | ({} if proved is None else proved.as_json)], indent=1))
    else:
        told = [found.sentence, *(f"breaks a limit: {excess}" for excess in found.verdict.limits)]
        told += [] if proved is None else [proved.sentence]
        print(f"{', '.join(parts)} on one clock: {'; '.join(told)}")
    return 0 if found.free and not found.verdict.limits and (proved is None or proved.written) else 1


def _as_json(found: Conflict, parts: dict[str, Path | list[float]]) -> dict[str, Any]:
    out: dict[str, Any] = {
        "paths": {name: part if isinstance(part, list) else str(part) for name, part in parts.items()},
        "starts": dict(found.starts),
        "free": found.free,
        "free_until": found.free_until,
        "collides_at": found.instant,
        "collides_until": None if found.until is None or math.isinf(found.until) else found.until,
        "robots": list(found.robots),
        "limits": [vars(excess) for excess in found.verdict.limits],
        "pieces": len(found.trajectory.curve.pieces),
    }
    return out if found.pair is None else out | certificate_as_json(found.pair)
