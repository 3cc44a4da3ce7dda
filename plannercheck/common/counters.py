"""Counters of several parts of one whole, summed.

In: tables of counters with the same names, or records with the same fields. Out: their sums.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any


def sum_counters(tables: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """The sum of tables of counts by name, nested ones included; empty if there are no tables.

    All tables have the names of the first one.
    """
    first, *others = [dict(table) for table in tables] or [{}]
    return {
        name: sum_counters([value, *(table[name] for table in others)])
        if isinstance(value, Mapping)
        else sum((table[name] for table in others), value)
        for name, value in first.items()
    }


def sum_fields(records: Sequence[object], *names: str) -> dict[str, Any]:
    """The sums of some fields of records, by name; 0 if there are no records."""
    return sum_counters([dict.fromkeys(names, 0), *({name: getattr(each, name) for name in names} for each in records)])
