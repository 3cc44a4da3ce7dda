"""Records of judgements judged again.

In: a record, a checker of the robot and the scene that it names. Out: the differences, in words.
"""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from plannercheck.common.checked_yaml import Node, error_context, mapping, number, numbers, required, sequence, text
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.unique_keys import object_of
from plannercheck.common.version import __version__
from plannercheck.motions.checker import Checker
from plannercheck.validation.gates.gate import Gate
from plannercheck.validation.gates.record import FORMAT

# Numbers of a verdict that differ by less than this part of themselves are the same: instants are searched for.
_SAME = 1e-9


def parse_record(line: str) -> Node:
    """A record from a line of JSON.

    Raises:
        PlannercheckError: If it is none.
    """
    try:
        document = json.loads(line, object_pairs_hook=object_of)
    except (ValueError, RecursionError) as error:
        raise PlannercheckError(f"is no JSON: {error!s:.100}") from None
    record = mapping(document, "a record")
    if record.get("format") != FORMAT:
        raise PlannercheckError(f"is no record of a gate: its format must be {FORMAT!r}")
    for key in ("robot", "scene"):
        name_of(record, key)
    return record


def name_of(record: Node, key: str) -> str:
    """The name of the record's robot or scene."""
    with error_context(repr(key)):
        return text(required(mapping(required(record, key), key), "name"), "name")


def differences(record: Node, checker: Checker) -> tuple[str, ...]:
    """Judges a record's chunk again and says what differs, in words; nothing if all is the same.

    Raises:
        PlannercheckError: If the record is malformed.
    """
    gate = _gate(mapping(required(record, "settings"), "settings"), checker)
    verdict = _judged(gate, mapping(required(record, "chunk"), "chunk"))
    made = json.loads(verdict.record())
    found = [] if record.get("version") == __version__ else [f"version: {record.get('version')}, now {__version__}"]
    for key in ("robot", "scene", "settings", "chunk"):
        if mapping(record[key], key).get("hash") != made[key]["hash"]:
            found.append(f"{key}: not the one that was judged")
    return (*found, *_changes(required(record, "verdict"), made["verdict"], "verdict"))


def _gate(given: Node, checker: Checker) -> Gate:
    with error_context("settings"):
        nq = checker.robot.nq
        rows: dict[str, Any] = {
            name: np.array(numbers(required(given, name), name, nq)) for name in ("velocity", "tube", "brake")
        }
        bends = sequence(required(given, "acceleration"), "'acceleration'")
        acceleration = np.array([math.inf if each is None else number(each, "acceleration") for each in bends])
        lengths = {name: number(required(given, name), name) for name in ("margin", "tolerance")}
        controller: Any = required(given, "controller")
        return Gate(checker, controller, acceleration=acceleration, **rows, **lengths)


def _judged(gate: Gate, chunk: Node) -> Any:
    with error_context("chunk"):
        start = mapping(required(chunk, "start"), "start")
        begin = (required(start, "q"), required(start, "dq"))
        return gate.judge(required(chunk, "positions"), chunk.get("rate"), times=chunk.get("times"), start=begin)


def _changes(old: Any, new: Any, place: str) -> list[str]:
    """What differs between two values as JSON has them."""
    if isinstance(old, dict) and isinstance(new, dict):
        keys = [*old, *(key for key in new if key not in old)]
        return [words for key in keys for words in _changes(old.get(key), new.get(key), f"{place}.{key}")]
    if isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        return [
            words for k, pair in enumerate(zip(old, new, strict=True)) for words in _changes(*pair, f"{place}[{k}]")
        ]
    if (old == new and type(old) is type(new)) or (
        _is_number(old) and _is_number(new) and math.isclose(old, new, rel_tol=_SAME, abs_tol=_SAME)
    ):
        return []
    return [f"{place}: {_shown(old)}, now {_shown(new)}"]


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _shown(value: Any) -> str:
    return f"{json.dumps(value):.60}"
