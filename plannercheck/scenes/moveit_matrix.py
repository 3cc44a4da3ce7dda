"""MoveIt's allowed collision matrices in YAML.

In: `moveit_msgs/AllowedCollisionMatrix`, parsed. Out: AllowedCollisions.
"""

from __future__ import annotations

from typing import Any

from plannercheck.common.checked_yaml import Node, check_keys, sequence, text
from plannercheck.common.errors import PlannercheckError, shortened
from plannercheck.scenes.contents import AllowedCollisions

_FLAGS = frozenset({bool})


def allowed_collisions(node: Node) -> AllowedCollisions:
    """The allowed collision matrix: an entry for each pair of names, defaults for pairs without one."""
    check_keys(node, ("entry_names", "entry_values", "default_entry_names", "default_entry_values"))
    names = [text(n, "entry_names") for n in sequence(node.get("entry_names"), "'entry_names'")]
    rows = [_flags(row) for row in sequence(node.get("entry_values"), "'entry_values'")]
    if len(set(names)) != len(names) or [len(r) for r in rows] != [len(names)] * len(names):
        raise PlannercheckError(f"entry_values must be one row and column for each of {len(names)} different names")
    for i, (row, column) in enumerate(zip(rows, zip(*rows, strict=True), strict=True)):
        if row[:i] != list(column[:i]):
            a, b = names[i], next(name for name, one, other in zip(names, row, column, strict=True) if one != other)
            raise PlannercheckError(f"entry_values of {a!r} with {b!r} and of {b!r} with {a!r} differ")
    known = [text(n, "default_entry_names") for n in sequence(node.get("default_entry_names"), "they")]
    defaults = _flags(node.get("default_entry_values"))
    if len(defaults) != len(known):
        raise PlannercheckError(f"{len(known)} default_entry_names, but {len(defaults)} default_entry_values")
    if len(set(known)) != len(known):
        raise PlannercheckError(f"default_entry_names must differ, but are {shortened(', '.join(known))!r}")
    entries = {
        frozenset((name, earlier)): flag
        for i, name in enumerate(names)
        for earlier, flag in zip(names[:i], rows[i], strict=False)
    }
    return AllowedCollisions(entries, dict(zip(known, defaults, strict=True)))


def _flags(value: Any) -> list[bool]:
    """A row of booleans, bare or in a message's `enabled` field."""
    row = sequence(value.get("enabled") if isinstance(value, dict) else value, "a row of values")
    if _FLAGS.issuperset(map(type, row)):
        return row
    if not all(flag in (True, False) for flag in row):
        raise PlannercheckError(f"values must be true or false, not {row}")
    return [bool(flag) for flag in row]
