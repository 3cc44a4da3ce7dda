"""Every code block of README.md, CONTRIBUTING.md and docs/ runs, in the order of its file.

Python blocks share one namespace a file. Of console and sh blocks, lines that call plannercheck run in this process and
must not exit with bad input. Blocks of yaml or xml whose first line is a comment that names a file are written to that
file. `<!-- only parsed: why -->` before a block has its commands parsed alone, `<!-- not run: why -->` leaves it out.
"""

from __future__ import annotations

import importlib
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from plannercheck.cli.main import COMMANDS, main, parser_for
from plannercheck.common.package_data import shipped_folder

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(
    r"(?:<!-- (?P<mark>only parsed|not run): .+? -->\n)?```(?P<language>\w+)\n(?P<text>.*?)```", re.DOTALL
)
FILE = re.compile(r"(?:<!-- |# )(?P<name>[\w.]+\.(?:urdf|yaml))")
# More marks than these would hide that blocks rot.
MOST_MARKED = 15


class Block(NamedTuple):
    mark: str | None
    language: str
    text: str


def blocks(page):
    return [Block(*found.group("mark", "language", "text")) for found in BLOCK.finditer(page.read_text("utf-8"))]


def commands(text):
    """Calls of plannercheck in a block, as arguments."""
    lines = (line.removeprefix("$ ") for line in text.replace("\\\n", " ").splitlines())
    calls = (part.strip() for line in lines for part in line.split("&&"))
    return [shlex.split(call, comments=True)[1:] for call in calls if call.startswith("plannercheck ")]


def prepare(folder):
    """Files that pages name without making them."""
    samples = np.load(shipped_folder("configs") / "bookshelf_panda.npy")[:8]
    np.save(folder / "set.npy", samples)
    np.savetxt(folder / "set.csv", samples, delimiter=",")
    parquet.write_table(pyarrow.table({"q": samples.tolist()}), folder / "big.parquet")
    np.save(folder / "set_ur5.npy", np.load(shipped_folder("configs") / "kitchen_ur5.npy")[:8])
    scene = (shipped_folder("configs") / "table.yaml").read_text("utf-8")
    (folder / "my_scene.yaml").write_text(re.sub(r" +samples: .*\n", "", scene), encoding="utf-8")


def write(block, folder):
    name = FILE.match(block.text)
    if name:
        (folder / name["name"]).write_text(block.text, encoding="utf-8")


def execute(block, namespace, page):
    if block.language == "python" and block.mark is None:
        exec(compile(block.text, str(page), "exec"), namespace)
    elif block.language in ("console", "sh"):
        for arguments in commands(block.text):
            if block.mark is None:
                assert main(arguments) in (0, 1), arguments
            elif block.mark == "only parsed":
                parser_for(arguments).parse_args(arguments)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_blocks_run(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    prepare(tmp_path)
    namespace = {"__name__": "documentation"}
    for block in blocks(page):
        write(block, tmp_path)
        execute(block, namespace, page)


def test_few_blocks_are_marked():
    marks = [block.mark for page in PAGES for block in blocks(page) if block.mark]
    assert len(marks) <= MOST_MARKED


def test_the_reference_has_every_command(tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.syspath_prepend(ROOT / "docs")
    importlib.import_module("command_reference").write_reference(tmp_path / "commands.md")
    page = (tmp_path / "commands.md").read_text("utf-8")
    for name in (*COMMANDS, "bench states"):
        assert f"\n## plannercheck {name}\n" in page


def test_the_documentation_builds_without_warnings(tmp_path):
    pytest.importorskip("sphinx", reason="pip install '.[docs]'")
    pytest.importorskip("myst_parser")
    shutil.copytree(ROOT, tmp_path / "root", ignore=lambda folder, names: [n for n in names if _is_not_docs(folder, n)])
    command = [sys.executable, "-m", "sphinx", "-W", "-q", str(tmp_path / "root/docs"), str(tmp_path / "html")]
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
    done = subprocess.run(command, capture_output=True, text=True, env=env)
    assert done.returncode == 0, done.stderr
    assert "plannercheck validate" in (tmp_path / "html/commands.html").read_text("utf-8")


def _is_not_docs(folder, name):
    return Path(folder) == ROOT and name not in ("docs", "CONTRIBUTING.md", "CHANGELOG.md")
