"""YAML built from events: the values, types and errors of PyYAML's own loader, whatever the text."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest
import yaml

from plannercheck.common import plain_yaml
from plannercheck.common.package_data import shipped_folder
from plannercheck.common.plain_yaml import LOADER, load_yaml

FILES = sorted([*shipped_folder("configs").glob("*.yaml"), *shipped_folder("robots").glob("*.yaml")])

SCALARS = (
    *("0", "-0", "1", "+1", "-17", "007", "0o7", "0x1F", "0b11", "1_000", "12345678901234567890", "1:30", "1:30.5"),
    *("1.5", "-1.5", "+1.5", "1.", ".5", "-.5", "1e5", "1e-5", "1.0e5", "1.0e+5", "-2.5E-300", "1.0e+999", "00.5"),
    *(".inf", "-.Inf", ".nan", "~", "null", "Null", "NULL", "nULL", "", "yes", "No", "ON", "off", "true", "TRUE", "y"),
    *("2026-01-02", "2026-01-02T03:04:05Z", "2026-99-99", "text", "a b", "-a", "a: b", "=", "<<", "a#b", "#b", "1.2.3"),
    *('"quoted"', "'single'", '"1.5"', "'true'", '"\\x41"', "!!str 5", "!!float 5", "!other 5", "&a 5", "*a", "! 5"),
    *("[1, 2]", "{a: 1}", "{a: 1, a: 2}", "[]", "{}", "{[1]: 2}", "{? {a: b} : c}", "[a, [b, {c: d}]]", "{a, b}"),
    *("|\n  block\n  text", ">\n  folded\n  text", "1__0", "1.5_0", "0.1_", "9" * 40, "x" * 200, "\u00e9", "a\tb"),
)


def outcome(load, text):
    try:
        value = load(text)
    except (yaml.YAMLError, ValueError) as error:
        return type(error), " ".join(str(error).split())
    return repr(value), types(value)


def types(value):
    if isinstance(value, dict):
        return [(type(key), types(key), types(item)) for key, item in value.items()]
    return [type(value), *map(types, value)] if isinstance(value, list) else type(value)


def pyyaml(text):
    return yaml.load(text, Loader=LOADER)


def assert_same(text):
    assert outcome(load_yaml, text) == outcome(pyyaml, text)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_shipped_files_without_pyyamls_constructors(path, monkeypatch):
    truth = pyyaml(path.read_bytes())
    monkeypatch.setattr(plain_yaml.yaml, "load", None)
    assert repr(load_yaml(path.read_bytes())) == repr(truth)
    assert repr(load_yaml(path.read_text(encoding="utf-8"))) == repr(truth)


@pytest.mark.parametrize("scalar", SCALARS)
def test_scalars_of_all_kinds(scalar):
    for form in ("{}", "a: {}", "- {}", "{}: b", "[1, {}]", "{{k: {}, l: 2}}", "a:\n  - {}\n  - 1\nb: {}"):
        assert_same(form.format(*[scalar] * form.count("{}")))


@pytest.mark.parametrize(
    "text",
    [
        *("", "---", "--- 1\n--- 2", "--- 1\n...", "%YAML 1.1\n--- 1", "# only a comment", "a: 1\na: 2", "? a\n: b"),
        *("a: &x [1]\nb: *x", "a: &x {b: 1}\nc: {<<: *x, d: 2}", "a: [1", "a: b: c", "\ta: 1", "a: 'b", "- a\nb"),
        *("? [1]\n: 2", "? - 1\n: 2", "!!set {a, b}", "!!omap [a: 1]", "!!python/none x", "\x00", "a: \x07"),
        *(b"\xff\xfea\x00:\x00 \x001\x00", b"\xef\xbb\xbfa: 1", b"a: \xff", "a: 1\n\n\nb: 2\n...\n", "[a, b]: c"),
    ],
)
def test_documents_of_all_kinds(text):
    assert_same(text)


@pytest.mark.parametrize("seed", range(20))
def test_damaged_files(seed):
    rng = random.Random(seed)
    text = rng.choice(FILES).read_text(encoding="utf-8")[:4000]
    for _ in range(60):
        start, count = rng.randrange(len(text)), rng.choice([0, 1, 1, 3, 20])
        assert_same(text[:start] + rng.choice(["", *"[]{}:-,#&*!|>'\"%@`?\n ", *SCALARS]) + text[start + count :])


WORDS = (
    *(
        "a",
        "b1",
        "long_name",
        "yes",
        "null",
        "-7",
        "0",
        "1.5",
        "-2.5e-3",
        "1e5",
        "a b",
        "a - b",
        "a, b",
        "x (y)",
        "a:b",
    ),
    *(
        "package://p/m.stl",
        "2026-01-02",
        "12:30",
        ".5",
        "-",
        "-a",
        "--",
        "---",
        "...",
        '"q"',
        "'q r'",
        "'",
        '"a',
        "#",
        "",
    ),
    *(
        "[]",
        "{}",
        "[1, 2.5, -3]",
        "[true, false]",
        "[ 1,2 , a ]",
        "[1, ]",
        "[,]",
        "[a: 1]",
        "{a: 1}",
        "{a: [1, {b: 2}]}",
    ),
    *(
        "{a}",
        "{a:1}",
        "{a: }",
        "[[[[1]]]]",
        "[1",
        "1]",
        "[a b, -c]",
        "[a:b]",
        "a # b",
        "a #b",
        "a#b",
        "a: b",
        "&a",
        "!a",
    ),
    *(
        "9007199254740993.0",
        "123456789012345678",
        "0.1e999",
        "00.5",
        "1_0.5",
        "-0",
        "-0.0",
        "5.",
        "1.0E+5",
        "% b",
        "a%",
    ),
)


@pytest.mark.parametrize("seed", range(40))
def test_random_lines(seed):
    """Lines of all kinds, whose indentation often fits: read by the core, or left to the others."""
    rng, read = random.Random(seed), 0
    for _ in range(300):
        lines, column = [], 0
        for _ in range(rng.randrange(1, 9)):
            column = max(0, column + rng.choice([-4, -2, -2, 0, 0, 0, 0, 0, 0, 2, 2, rng.choice([1, -1, 0, 0])]))
            dashes = "- " * rng.choice([0, 0, 0, 0, 1, 1, 2])
            key = rng.choice(
                ["a:", "b:", "c:", "yes:", "key_1:", "_k:", "null:", rng.choice(["", "a :", "1:", "'a':"])]
            )
            value = rng.choice(WORDS) if rng.random() < 0.4 else rng.choice(["1", "x", "2.5", "y z", ""])
            comment = rng.choice(["", "", "", "", "", " # c", rng.choice(["# c", " #"])])
            line = " " * column + dashes + key + (" " if key and value else "") + value + comment
            lines.append(line if rng.random() < 0.9 else rng.choice(["", "  ", "# c", "   # c", "---", line + "  "]))
            column += len(dashes) if rng.random() < 0.8 else 0
        text = "\n".join(lines)
        assert_same(text)
        read += plain_yaml.value_of_lines(text) is not None
    assert read > 20


@pytest.mark.parametrize(
    "text",
    ["a: x\n  b: 1", "a: 1\n  b: 2\nc: 3", "- x\n  b: 1", "a:\n  b: x\n    c: 1", "a:\n- b: 1\n    c: 2", "- 1\n  - 2"],
)
def test_lines_that_may_continue_the_text_before_them_are_left_to_the_others(text):
    assert plain_yaml.value_of_lines(text) is None
    assert_same(text)


@pytest.mark.parametrize("seed", range(5))
def test_documents_as_programs_write_them_are_read_by_the_core(seed):
    rng = random.Random(seed)

    def node(depth):
        kind = rng.randrange(2 + 2 * (depth > 0))
        if kind == 2:
            return {f"key_{rng.randrange(99)}": node(depth - 1) for _ in range(rng.randrange(1, 5))}
        if kind == 3:
            return [node(depth - 1) for _ in range(rng.randrange(1, 5))]
        return rng.choice([rng.random(), rng.randrange(-99, 99), "name of it", True, None, [0.5, 1, -2.25], "a/b.stl"])

    for _ in range(50):
        document = {"first": [node(4)], "second": node(3)}
        text = yaml.safe_dump(document, default_flow_style=rng.choice([None, False]), width=10_000)
        value = plain_yaml.value_of_lines(text)
        assert value is not None
        assert repr(value) == repr(yaml.safe_load(text))


def test_what_is_kept_is_short():
    plain_yaml._resolved.cache_clear()
    load_yaml(f"a: {'x' * 100}")
    assert plain_yaml._resolved.cache_info().currsize == 1  # the key


def test_the_plain_way_can_be_left_out(monkeypatch):
    path = Path(FILES[0])
    truth = load_yaml(path.read_bytes())
    monkeypatch.setattr(plain_yaml, "value_of_lines", lambda text: None)
    assert load_yaml(path.read_bytes()) == truth
    monkeypatch.setattr(plain_yaml, "_value_of_events", lambda text: (_ for _ in ()).throw(plain_yaml.NotPlainError))
    assert load_yaml(path.read_bytes()) == truth


@pytest.mark.skipif(LOADER is yaml.SafeLoader, reason="needs libyaml's loader beside PyYAML's")
def test_what_others_teach_another_loader_does_not_count(monkeypatch):
    """Many programs have PyYAML's `SafeLoader` read 1e5 as a number; the loader of these files is another one."""
    more = {"7": [*yaml.SafeLoader.yaml_implicit_resolvers["7"], ("tag:yaml.org,2002:float", re.compile("7e5"))]}
    resolvers = {**yaml.SafeLoader.yaml_implicit_resolvers, **more}
    monkeypatch.setattr(yaml.SafeLoader, "yaml_implicit_resolvers", resolvers)
    plain_yaml._resolved.cache_clear()
    assert yaml.safe_load("7e5") == 7e5
    assert_same("7e5")
    plain_yaml._resolved.cache_clear()
