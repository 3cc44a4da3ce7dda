"""Results of measurements as JSON: what they hold, and that nobody's folders get into them."""

import json
from dataclasses import dataclass

import numpy as np
import pytest

from plannercheck.evaluation.bench.records import command_line, write_record


@dataclass(frozen=True)
class Row:
    name: str
    value: float


def test_a_record_has_rows_and_where_they_come_from(tmp_path):
    write_record(tmp_path / "some.json", [Row("a", 1.5), {"name": "b", "value": np.float64(2.5)}])
    found = json.loads((tmp_path / "some.json").read_text("utf-8"))
    assert found["measurement"] == "some"
    assert found["rows"] == [{"name": "a", "value": 1.5}, {"name": "b", "value": 2.5}]
    assert {"command", "date", "commit", "machine"} <= found.keys()
    assert {"processor", "processors", "instruction set", "load"} <= found["machine"].keys()


@pytest.mark.parametrize(
    ("arguments", "command"),
    [
        (["/some/bin/plannercheck", "bench", "pairs", "--output", "/tmp/x"], "plannercheck bench pairs"),
        (["/some/plannercheck/__main__.py", "bench", "pairs"], "plannercheck bench pairs"),
        (["/some/script.py", "/data/set.tar.bz2", "--every", "10"], "python script.py set.tar.bz2 --every 10"),
    ],
)
def test_commands_are_as_anyone_may_type_them(arguments, command):
    assert command_line(arguments) == command
