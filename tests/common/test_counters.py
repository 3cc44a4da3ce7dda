"""Counters of several parts, summed."""

from types import SimpleNamespace

from plannercheck.common.counters import sum_counters, sum_fields


def test_tables_of_counters_add_up_name_by_name():
    tables = [{"states": k, "queries": {"rounds": 10 * k, "games": 1}} for k in (1, 2, 3)]
    assert sum_counters(tables) == {"states": 6, "queries": {"rounds": 60, "games": 3}}
    assert sum_counters(tables[:1]) == tables[0]
    assert sum_counters([]) == {}


def test_fields_of_records_add_up():
    records = [SimpleNamespace(states=2, duration=0.5, name="a"), SimpleNamespace(states=3, duration=0.25, name="b")]
    assert sum_fields(records, "states", "duration") == {"states": 5, "duration": 0.75}
    assert sum_fields([], "states") == {"states": 0}
