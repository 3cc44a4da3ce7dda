"""`plannercheck gate`: judges chunks of waypoints, one a line of standard input, and answers line by line.

In: JSON lines. Out: JSON lines, and on request records that `plannercheck replay` judges again.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any, TextIO

from plannercheck.checking.protocols import AnyChecker
from plannercheck.cli.common import (
    add_checker_arguments,
    check_folder,
    limits_of,
    numbers_of,
    space_checker,
)
from plannercheck.common.checked_yaml import Node, check_keys, mapping, required
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.unique_keys import object_of
from plannercheck.planar.robot_files import is_planar
from plannercheck.validation.gates.gate import Gate
from plannercheck.validation.gates.settings import OF_POSITIONS
from plannercheck.validation.gates.verdict import GateVerdict

_EPILOG = """\
A line of input: {"chunk": [[...], ...], "rate": 50, "start": {"q": [...], "dq": [...]}}, with "times" in place of
"rate" if waypoints are not even; "id" is given back. An answer: ok, reasons, safe_until (s) and stop, the points of the
stop behind safe_until. A line that is malformed gets {"ok": false, "error": ...}.

Exit codes: 0 all chunks pass, 1 some do not, 2 bad input, on any line.

Example:
  plannercheck gate --robot panda --scene bookshelf --acceleration 10 --brake 5 < chunks.jsonl
"""
_KEYS = ("chunk", "rate", "times", "start", "id")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    parser.epilog = _EPILOG
    add_checker_arguments(parser)
    parser.add_argument(
        "--controller", choices=OF_POSITIONS, default="jtc", help="who runs the chunks; default: jtc, straight between"
    )
    parser.add_argument(
        "--velocity",
        metavar="A,B,...",
        help="largest speeds, rad/s and m/s, one number or one a joint, or MoveIt's joint_limits.yaml; default: the "
        "URDF's",
    )
    parser.add_argument(
        "--acceleration", metavar="A,B,...", help="largest accelerations, rad/s² and m/s², likewise; default: no limit"
    )
    parser.add_argument(
        "--brake", metavar="A,B,...", help="decelerations of stops, rad/s² and m/s², likewise; default: --acceleration"
    )
    parser.add_argument(
        "--tube", default="0.01", metavar="A,B,...", help="how far joints may be off, rad and m; default: 0.01"
    )
    parser.add_argument("--margin", type=float, default=0.005, metavar="M", help="distance to keep, m; default: 0.005")
    parser.add_argument("--record", type=Path, metavar="FILE", help="append a record of each judgement (JSON lines)")


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    check_folder(options.record)
    if is_planar(options.robot, "robots"):
        raise PlannercheckError("gate is for robots in space: trajectories have one column a joint")
    gate = _gate_of(space_checker(options), options)
    if options.record is None:
        return _answer_all(gate, None)
    try:
        with options.record.open("a", encoding="utf-8") as records:
            return _answer_all(gate, records)
    except OSError as error:
        raise PlannercheckError(f"file {str(options.record)!r} can't be written: {error.strerror}") from None


def _gate_of(checker: AnyChecker, options: argparse.Namespace) -> Gate:
    limits = {
        name: None if (given := getattr(options, name)) is None else limits_of(given, f"--{name}")
        for name in ("velocity", "acceleration", "brake")
    }
    tube: Any = numbers_of(options.tube, "--tube")
    return Gate(checker, options.controller, tube=tube, margin=options.margin, **limits)  # type: ignore[arg-type]


def _answer_all(gate: Gate, records: TextIO | None) -> int:
    """Answers each line; the exit code."""
    worst = 0
    for line in sys.stdin if sys.stdin is not None else ():
        if not line.strip():
            continue
        answer, verdict = _answer(gate, line)
        worst = max(worst, 2 if verdict is None else 0 if verdict else 1)
        print(json.dumps(answer), flush=True)
        if records is not None and verdict is not None:
            print(verdict.record(), file=records, flush=True)
    return worst


def _answer(gate: Gate, line: str) -> tuple[dict[str, Any], GateVerdict | None]:
    """What is printed, and the verdict; None for a line that is malformed."""
    given: Node = {}
    try:
        given = mapping(json.loads(line, object_pairs_hook=object_of), "a line")
        verdict = _judged(gate, given)
        return {**_id(given), **verdict.as_json()}, verdict
    except PlannercheckError as error:
        return {**_id(given), "ok": False, "error": str(error)}, None
    except (ValueError, RecursionError) as error:  # of json
        return {"ok": False, "error": f"no JSON: {error!s:.100}"}, None


def _id(given: Node) -> dict[str, Any]:
    return {"id": given["id"]} if "id" in given else {}


def _judged(gate: Gate, given: Node) -> GateVerdict:
    check_keys(given, _KEYS)
    begin: Any = required(given, "start")
    if isinstance(begin, dict):
        check_keys(begin, ("q", "dq"))
        begin = (required(begin, "q"), begin["dq"]) if begin.get("dq") is not None else required(begin, "q")
    return gate.judge(required(given, "chunk"), given.get("rate"), times=given.get("times"), start=begin)
