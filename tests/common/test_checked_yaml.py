"""YAML files mean what PyYAML's own rules say, whatever other programs teach PyYAML, but nothing in silence.

Keys given twice are refused in files of every kind; what YAML 1.1 alone takes for a number is a text.
"""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

import plannercheck as pc
from plannercheck.common.checked_yaml import (
    error_context,
    number,
    numbers,
    parse_yaml,
    required,
    text,
    text_or_empty,
    warn_here,
)
from plannercheck.common.unique_keys import object_of
from plannercheck.coverings import plain_files
from plannercheck.ompl.plans import Plan
from plannercheck.trajectories.messages import read_document
from plannercheck.validation.formats.paths import read_path
from plannercheck.validation.gates.replay import parse_record


@pytest.mark.parametrize(
    "scalar",
    [
        "no",
        "ON",
        "~",
        "0",
        "-0",
        "0.10",
        "00.5",
        "0x1F",
        "0b11",
        "0o10",
        "-12",
        "1e5",
        "1.0e+5",
        "2026-01-02",
        ".inf",
    ],
)
def test_scalars_are_those_of_yaml_1_1(scalar: str) -> None:
    for given in (f"a: {scalar}", f"a: [1, {scalar}]", f"a: '{scalar}'", f"a: &x {scalar}\nb: *x"):
        assert repr(parse_yaml(given)) == repr(yaml.safe_load(given)) == repr(parse_yaml(given.encode()))


def test_a_key_that_begins_as_parquet_does_is_read() -> None:
    assert parse_yaml("PAR1_joint: 0.5") == {"PAR1_joint": 0.5}


@pytest.mark.skipif(not hasattr(yaml, "CSafeLoader"), reason="needs libyaml's loader beside PyYAML's")
def test_what_others_teach_another_loader_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """Many programs have PyYAML's `SafeLoader` read 1e5 as a number; the loader of these files is another one."""
    more = {"7": [*yaml.SafeLoader.yaml_implicit_resolvers["7"], ("tag:yaml.org,2002:float", re.compile("7e5"))]}
    monkeypatch.setattr(yaml.SafeLoader, "yaml_implicit_resolvers", yaml.SafeLoader.yaml_implicit_resolvers | more)
    assert yaml.safe_load("a: 7e5") == {"a": 7e5}
    assert parse_yaml("a: 7e5") == {"a": "7e5"}


@pytest.mark.parametrize("scalar", ["010", "-017", "0_7", "1_2", "1:30", "-1:30:00", "190:20:30.15"])
def test_octal_and_base_60_are_texts(scalar: str) -> None:
    """Where a number is needed, yaml-cpp reads 010 as 10 and refuses the colons."""
    value = parse_yaml(f"a: {scalar}")["a"]
    assert value == scalar
    if ":" in scalar:
        with pytest.raises(pc.PlannercheckError, match=f"'a' must be a number, not '{scalar}'"):
            number(value, "a")
    else:
        assert number(value, "a") == int(scalar.replace("_", ""), 10)


@pytest.mark.parametrize("scalar", ["1.10", "0x1F", "+1", "1.5e+3", "-.5", "7", "0.1"])
def test_names_are_as_they_are_written(scalar: str) -> None:
    """As MoveIt's yaml-cpp has them; where a number is needed they are numbers."""
    document = parse_yaml(f"a: {scalar}\n{scalar}: [1, {scalar}]")
    assert text(document["a"], "a") == scalar
    assert document[scalar] == yaml.safe_load(f"[1, {scalar}]")
    assert [*map(type, numbers(document[scalar], "a"))] == [float, float]


def test_scenes_keep_names_that_look_like_numbers(tmp_path: Path) -> None:
    """Two names of one number are two obstacles."""
    objects = [f"- {{name: {name}, box: {{size: [1, 1, 1]}}, position: [2, 0, 0]}}" for name in ("1.10", "1.1")]
    (tmp_path / "s.yaml").write_text("\n".join(["objects:", *objects]))
    assert [each.name for each in pc.Scene.load(tmp_path / "s.yaml").objects] == ["1.10", "1.1"]


@pytest.mark.parametrize("scalar", ["on", "no", "2026-01-02", "~"])
def test_names_that_yaml_reads_as_something_else_need_quotes(scalar: str) -> None:
    """As keys they are texts already."""
    document = parse_yaml(f"a: {scalar}\nb: ['{scalar}']\nc: {{{scalar}: 1}}")
    assert (text(document["b"][0], "b"), *document["c"]) == (scalar, scalar)
    for read in (text, lambda *_: text_or_empty({"a": document["a"] or False}, "a")):
        with pytest.raises(pc.PlannercheckError, match=r"^'a' must be a text, not .*: put it in quotes$"):
            read(document["a"], "a")
    with pytest.raises(pc.PlannercheckError, match=r"^key 'a' is missing \(it is null; .* quotes\); given are a$"):
        required({"a": None}, "a")
    assert text_or_empty({"a": None}, "a") == text_or_empty({}, "a") == ""
    assert text_or_empty({"a": 0}, "a") == "0"


@pytest.mark.parametrize(
    ("document", "expected"),
    [
        ("a: &x 1.50\nb: {*x : on}", {"a": 1.5, "b": {"1.50": True}}),
        ("b: {&x on: 1.50}\na: *x", {"a": True, "b": {"on": 1.5}}),
        ("args: {b: &x true}\na: *x", {"args": {"b": "true"}, "a": True}),
        ("a: &x {b: 1.10}\nargs: *x", {"a": {"b": 1.1}, "args": {"b": "1.10"}}),
        ("a: &x {b: 1.10}\nargs: {<<: *x, c: 0x1}", {"a": {"b": 1.1}, "args": {"b": "1.10", "c": "0x1"}}),
    ],
)
def test_a_scalar_that_is_a_text_in_one_place_is_a_value_in_another(document: str, expected: dict[str, Any]) -> None:
    assert parse_yaml(document, as_written="args") == expected


@pytest.mark.parametrize(
    ("document", "key", "lines"),
    [
        ("objects: []\nrobots: 1\nobjects: []", "objects", "1, 3"),
        ("a:\n- b: {c: 1,\n    c: 1}", "c", "2, 3"),
        ("a: {1: x, '1': y}", "1", "1, 1"),
        ("a: &a {x: 1}\nb:\n  <<: *a\n  y: 1\n  y: 2", "y", "4, 5"),
        ("a: &a\n  x: 1\n  x: 2\nb: {<<: [*a]}", "x", "2, 3"),
    ],
)
def test_a_key_that_stands_twice_is_refused(document: str, key: str, lines: str) -> None:
    for given in (document, document.encode()):
        with pytest.raises(pc.PlannercheckError, match=f"^a mapping has the key '{key}' twice, on lines {lines}: "):
            parse_yaml(given)


@pytest.mark.parametrize(
    "document",
    [
        "a: &a {x: 1, y: 2}\nb: &b {<<: *a, x: 3}\nc: {<<: *b, x: 4, z: 5}\nd: {<<: [*b, *a]}\ne: *b",
        "c: {<<: &b {<<: &a {x: 1}, x: 2}, x: 3}\nd: *b\ne: {<<: [*a, *b]}",
    ],
)
def test_merged_keys_may_be_overridden(document: str) -> None:
    assert parse_yaml(document) == yaml.safe_load(document)


@pytest.mark.parametrize(
    ("name", "content", "read"),
    [
        ("s.yaml", "objects: []\nobjects: []", pc.Scene.load),
        ("r.yaml", "urdf: a.urdf\nheld: {j: 1, j: 2}", pc.Robot.load),
        ("p.yaml", "points: []\npoints: []", lambda path: read_path(path, ("a",), 1)),
        ("t.yaml", "points: []\npoints: []", read_document),
        ("t.json", '{"points": [], "points": []}', read_document),
        ("p.json", '{"path": [], "path": []}', lambda path: read_path(path, ("a",), 1)),
        ("p.json", '{"path": [], "path": []}', Plan.load),
        ("c.json", '{"links": {"a": [], "a": []}}', lambda path: plain_files.read(path, ("a",))),
        ("r.jsonl", '{"points": 1, "points": 1}', lambda path: parse_record(path.read_text())),
    ],
)
def test_readers_refuse_a_key_that_stands_twice(
    tmp_path: Path, name: str, content: str, read: Callable[[Path], Any]
) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(pc.PlannercheckError, match=r"has the key '(objects|j|points|path|a)' twice.*: give it once"):
        read(tmp_path / name)


def test_objects_of_json_are_those_of_python() -> None:
    content = '{"a": {"b": [1, {}]}, "c": null}'
    assert json.loads(content, object_pairs_hook=object_of) == json.loads(content)


def test_lists_that_echo_cut_short_are_refused() -> None:
    assert parse_yaml("a: ['...', x]\nb: '...'") == {"a": ["...", "x"], "b": "..."}
    for entry in ("1.5", "{x: 1, y: 2}", "text"):
        message = (
            "list on line 2 ends in '...' after 128 entries: `ros2 topic echo` cuts lists short without --full-length"
        )
        with pytest.raises(pc.PlannercheckError, match=message):
            parse_yaml("a:\n" + f"- {entry}\n" * 128 + "- '...'\n---\n")


def test_a_context_that_is_left_late_is_no_place_of_later_warnings():
    """As of a generator that is given up while it waits."""

    def lines():
        with error_context("file"):
            yield 1

    given_up = lines()
    with error_context("inside"):
        next(given_up)
    given_up.close()
    with error_context("here"), pytest.warns(RuntimeWarning, match=r"^here: odd$"):
        warn_here("odd")
