"""`plannercheck gate` answers line by line, `plannercheck replay` judges records again."""

import io
import json

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.cli.main import main

COMMAND = ("gate", "--robot", "panda", "--velocity", "1", "--acceleration", "20", "--brake", "5")


@pytest.fixture
def answers(monkeypatch, capsys):
    def run(lines, *words):
        monkeypatch.setattr("sys.stdin", io.StringIO("\n".join(lines)))
        code = main([*COMMAND, *words])
        return code, [json.loads(line) for line in capsys.readouterr().out.splitlines()]

    return run


def line(shift=0.0, **changes):
    q = pc.Robot.load("panda").reference
    chunk = q + shift + 0.004 * np.arange(1, 9)[:, None]
    given = {"chunk": chunk.tolist(), "rate": 50, "start": {"q": q.tolist(), "dq": [0.2] * 7}}
    return json.dumps({**given, **changes})


def test_each_line_is_answered(answers):
    code, (good, jump, empty, unknown, broken) = answers(
        [line(id="a"), "", line(0.5, id=7), line(chunk=[]), line(speed=3), "{"]
    )
    assert code == 2
    assert (good["id"], good["ok"], good["reasons"], good["safe_until"]) == ("a", True, [], 0.16)
    assert good["stop"]["velocities"][-1] == [0.0] * 7
    assert (jump["id"], jump["ok"], jump["reasons"][0]["kind"]) == (7, False, "jump")
    for answer, words in ((empty, "chunk must have the shape"), (unknown, "unknown key 'speed'"), (broken, "no JSON")):
        assert not answer["ok"]
        assert words in answer["error"]


def test_numbers_beyond_all_robots_are_answered_and_the_next_line_too(answers):
    q = [0.0] * 7
    lines = [line(start={"q": q, "dq": [1e3] * 7}), line(1e14), line(1e300), line(rate=10**400), line()]
    code, (fast, far, huge, rate, good) = answers(lines)
    assert code == 2
    assert [fast["ok"], far["ok"], good["ok"]] == [False, False, True]
    assert {reason["kind"] for reason in far["reasons"]} >= {"jump", "unproved"}
    assert "within 1e+15" in huge["error"]
    assert "rate must be" in rate["error"]


def test_truth_values_are_no_waypoints(answers):
    q = [0.0] * 6
    lines = [line(chunk=[[*q, 0.0], [*q, True]]), line(start=[False, *q]), line(times=[True, 2], rate=None)]
    code, (chunk, start, times) = answers(lines)
    assert code == 2
    assert chunk["error"] == "chunk must be numbers, not a truth value at [1, 6]: write 1 or 0 if a number is meant"
    assert start["error"].startswith("start must be numbers, not a truth value at [0]")
    assert times["error"].startswith("times must be numbers, not a truth value at [0]")


def test_exit_codes(answers):
    assert answers([line()])[0] == 0
    assert answers([line(), line(0.5)])[0] == 1
    assert answers([])[0] == 0


def test_records_are_replayed(answers, tmp_path, capsys):
    path = tmp_path / "judged.jsonl"
    answers([line(), line(0.5)], "--record", str(path))
    assert main(["replay", str(path)]) == 0
    assert capsys.readouterr().out.count("the same") == 2
    assert main(["replay", str(path), "--scene", "table"]) == 1
    assert "scene: not the one that was judged" in capsys.readouterr().out
    record = json.loads(path.read_text().splitlines()[0])
    record["verdict"]["slack"] = False
    path.write_text(json.dumps(record) + "\n")
    assert main(["replay", str(path)]) == 1
    assert "verdict.slack: false, now" in capsys.readouterr().out
    path.write_text("{}\n")
    assert main(["replay", str(path)]) == 2
    assert "is no record of a gate" in capsys.readouterr().err
    path.write_text("")
    assert main(["replay", str(path)]) == 2
