"""YAML files mean what PyYAML's own rules say, whatever other programs teach PyYAML."""

import re

import pytest
import yaml

from plannercheck.common.checked_yaml import parse_yaml


@pytest.mark.parametrize(
    "scalar", ["no", "ON", "~", "010", "0o10", "1_000", "1:30", "1e5", "1.0e+5", "2026-01-02", ".inf"]
)
def test_scalars_are_those_of_yaml_1_1(scalar: str) -> None:
    for text in (f"a: {scalar}", f"a: [1, {scalar}]", f"a: '{scalar}'", f"a: &x {scalar}\nb: *x", f"a: 1\na: {scalar}"):
        assert repr(parse_yaml(text)) == repr(yaml.safe_load(text)) == repr(parse_yaml(text.encode()))


def test_a_key_that_begins_as_parquet_does_is_read() -> None:
    assert parse_yaml("PAR1_joint: 0.5") == {"PAR1_joint": 0.5}


@pytest.mark.skipif(not hasattr(yaml, "CSafeLoader"), reason="needs libyaml's loader beside PyYAML's")
def test_what_others_teach_another_loader_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """Many programs have PyYAML's `SafeLoader` read 1e5 as a number; the loader of these files is another one."""
    more = {"7": [*yaml.SafeLoader.yaml_implicit_resolvers["7"], ("tag:yaml.org,2002:float", re.compile("7e5"))]}
    monkeypatch.setattr(yaml.SafeLoader, "yaml_implicit_resolvers", yaml.SafeLoader.yaml_implicit_resolvers | more)
    assert yaml.safe_load("a: 7e5") == {"a": 7e5}
    assert parse_yaml("a: 7e5") == {"a": "7e5"}
