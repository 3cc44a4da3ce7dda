"""Names that hold markup, control characters and formulas: they reach every output as text."""

import csv
import io
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.cli import main as cli
from plannercheck.common.escaping import csv_cell, json_in_script, on_terminal

NAMES = ["<!--<script>alert(1)</script>", "/*DATA*/", "\x1b[31mred\x1b[0m\x07", "a\rb", "a\nb", '"quoted", and more']
FORMULAS = ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1"]


class _Scripts(HTMLParser):
    """The scripts of a page as a browser sees them."""

    def __init__(self) -> None:
        super().__init__()
        self.scripts: list[list[str]] = []
        self._inside = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "script":
            self.scripts.append([dict(attrs).get("id") or "", ""])
            self._inside = True

    def handle_endtag(self, tag: str) -> None:
        if tag == "script":
            self._inside = False

    def handle_data(self, data: str) -> None:
        if self._inside:
            self.scripts[-1][1] += data


@pytest.mark.parametrize("name", [*NAMES, "</script>", "<!--TITLE-->"])
def test_a_page_has_the_scripts_that_it_should(name: str, tmp_path: Path) -> None:
    scene = pc.Scene(name)
    scene.add_box(name, [0.1, 0.1, 0.1], np.eye(4))
    checker = pc.Checker(pc.Robot.load("panda"), scene)
    picture = pc.view.picture(checker, [checker.robot.reference], labels=[name])
    pc.view.write_page(picture, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    parsed = _Scripts()
    parsed.feed(page)
    assert len(parsed.scripts) == 2
    data = json.loads(parsed.scripts[0][1])
    assert (parsed.scripts[0][0], data["labels"]) == ("data", [name])
    assert any(name in mesh["name"] for mesh in data["meshes"])
    # A browser leaves a script's plain state at "<!--" and "<script": none of them is in the data.
    assert not re.search(
        r"[<>&]", page[page.index('id="data">') + 10 : page.index("</script>", page.index('id="data"'))]
    )


@pytest.mark.parametrize("text", [*NAMES, *FORMULAS, "\x00\x9b\u202e"])
def test_nothing_on_a_terminal_acts(text: str) -> None:
    shown = on_terminal(text)
    assert not [c for c in shown if c not in "\t\n" and not c.isprintable()]
    assert on_terminal("plain – ü ✓\ttext\n") == "plain – ü ✓\ttext\n"


@pytest.mark.parametrize("text", [*NAMES, "plain", "", "a,b", "x\x00y"])
def test_csv_cells_are_read_back(text: str) -> None:
    line = f"{csv_cell(text)},{csv_cell('next')}\n"
    if "\x00" not in text:  # which Python's reader refuses before 3.11
        assert list(csv.reader(io.StringIO(line, newline=""))) == [[text, "next"]]


@pytest.mark.parametrize("text", FORMULAS)
def test_no_cell_is_a_formula(text: str) -> None:
    (cell,) = next(csv.reader(io.StringIO(csv_cell(text) + "\n", newline="")))
    assert cell == f"'{text}"


def test_json_in_a_script_is_the_same_json() -> None:
    value = {"a": ["<!--", "</script>", "&amp;", "\u2028"], "b": 1.5}
    text = json_in_script(value)
    assert json.loads(text) == value
    assert not set("<>&") & set(text)


def test_the_command_line_shows_names_as_text(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = pc.Scene("s")
    scene.add_box("bo\x1b[2Jx", [9.0, 9.0, 9.0])
    scene.save(tmp_path / "s.yaml")
    np.save(tmp_path / "q.npy", pc.Robot.load("panda").reference[None])
    arguments = ["validate", "--robot", "panda", "--scene", str(tmp_path / "s.yaml"), str(tmp_path / "q.npy")]
    assert cli.main([*arguments, "--pairs", "all"]) == 1
    printed = capsys.readouterr()
    assert "\x1b" not in printed.out + printed.err
    assert "bo\\x1b[2Jx" in printed.out
    assert cli.main([*arguments, "--output", str(tmp_path / "o\x1b.txt")]) == 2
    assert "\x1b" not in capsys.readouterr().err
