"""Every code block of README.md, CONTRIBUTING.md and docs/ runs, in the order of its file.

Python blocks share one namespace a file. Of console and sh blocks, lines that call plannercheck run in this process and
must not exit with bad input. Blocks of yaml or xml whose first line is a comment that names a file are written to that
file. Commands of bash blocks, which need files of the reader, and those after `<!-- only parsed: why -->` are parsed
alone; `<!-- not run: why -->` leaves a block out.
"""

import importlib
import inspect
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import zlib
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from plannercheck.cli.main import COMMANDS, main, parser_for
from plannercheck.common.package_data import shipped_folder

ROOT = Path(__file__).parents[2]
MADE = ROOT / "docs/reference/commands.md"  # by the build, from the parsers
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted({*(ROOT / "docs").glob("**/*.md")} - {MADE})]
BLOCK = re.compile(
    r"(?:<!-- (?P<mark>only parsed|not run): .+? -->\n)?```(?P<language>\w+)\n(?P<text>.*?)```", re.DOTALL
)
FILE = re.compile(r"(?:<!-- |# )(?P<name>[\w.]+\.(?:urdf|yaml))")
# More marks than these would hide that blocks rot.
MOST_MARKED = 20
# Where public names are, and classes that public calls give without being public names themselves.
FACES = ("plannercheck", *(f"plannercheck.{name}" for name in ("planar", "ndim", "ompl", "view", "proofs")))
GIVEN = (
    "plannercheck.bodies.objects.SceneObject",
    "plannercheck.bodies.shapes.GeometryObject",
    "plannercheck.checking.verdicts.MotionProof",
    "plannercheck.checking.verdicts.MotionVerdict",
    "plannercheck.checking.verdicts.PairCount",
    "plannercheck.checking.verdicts.PairVerdict",
    "plannercheck.ompl.plans.Plan",
    "plannercheck.view.model.Mesh",
    "plannercheck.view.model.Plane",
    "plannercheck.view.model.Witness",
)
MOST_README_LINES = 150
RESULTS = ROOT / "docs/results"


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
    shutil.copytree(shipped_folder("configs") / "puzzles", folder / "configs/puzzles")
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
    elif block.language in ("console", "sh", "bash"):
        for arguments in commands(block.text):
            if block.mark is None and block.language != "bash":
                assert main(arguments) in (0, 1), arguments
            elif block.mark != "not run":
                parser_for(arguments).parse_args(arguments)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
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


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The documentation, built with warnings as errors."""
    pytest.importorskip("sphinx", reason="pip install '.[docs]'")
    pytest.importorskip("myst_parser")
    folder = tmp_path_factory.mktemp("docs")
    shutil.copytree(ROOT, folder / "root", ignore=lambda name, names: [n for n in names if _is_not_docs(name, n)])
    command = [sys.executable, "-m", "sphinx", "-W", "-q", str(folder / "root/docs"), str(folder / "html")]
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
    done = subprocess.run(command, capture_output=True, text=True, env=env)
    assert done.returncode == 0, done.stderr
    return folder / "html"


def test_the_documentation_builds_without_warnings(site):
    assert "plannercheck validate" in (site / "reference/commands.html").read_text("utf-8")


def test_no_public_name_is_missing_from_the_reference(site):
    documented = names_in_inventory(site / "objects.inv")
    missing = [name for name in public_names() if name not in documented]
    assert missing == []


def test_the_reference_lists_public_names_alone():
    """docs/reference/public_names.md promises what these pages list: no more and no less than the modules give away."""
    pages = (ROOT / "docs/reference" / f"{name}.md" for name in ("python", "planar", "ndim", "proofs"))
    listed = {name for page in pages for name in names_listed(page.read_text("utf-8"))}
    of_faces = {name for name in listed if name.rpartition(".")[0] in FACES}
    assert of_faces == {name for name in public_names() if name.rpartition(".")[0] in FACES}


def names_listed(page):
    """Full names of what a page describes."""
    module = ""
    for kind, name in re.findall(r"\.\. (currentmodule|autoclass|autofunction|autodata|data):: ([\w.]+)", page):
        if kind == "currentmodule":
            module = name
        else:
            yield name if name.startswith("plannercheck.") else f"{module}.{name}"


def names_in_inventory(path):
    """Python names that the built pages describe."""
    data = path.read_bytes().split(b"\n", 4)[4]
    entries = (line.split(" ", 2) for line in zlib.decompress(data).decode("utf-8").splitlines())
    return {name for name, kind, _ in entries if kind.startswith("py:")}


def public_names():
    """Public names of all faces, and the methods and properties of the classes among them."""
    for face in FACES:
        module = importlib.import_module(face)
        for name in sorted(getattr(module, "__all__", None) or names_of(module)):
            target = getattr(module, name)
            if not inspect.ismodule(target):
                yield f"{face}.{name}"
                yield from members_of(target, f"{face}.{name}")
    for path in GIVEN:
        module, _, name = path.rpartition(".")
        yield path
        yield from members_of(getattr(importlib.import_module(module), name), path)


def names_of(module):
    """Names that a module without `__all__` gives away: of objects that say that they are its own."""
    return [name for name, value in vars(module).items() if getattr(value, "__module__", None) == module.__name__]


def members_of(target, path):
    if inspect.isclass(target):
        for name in dir(target):
            member = inspect.getattr_static(target, name)
            called = isinstance(member, property | cached_property | classmethod | staticmethod)
            ours = not name.startswith("_") and _is_ours(target, name)
            if ours and (called or inspect.isfunction(member)):
                yield f"{path}.{name}"


def _is_ours(target, name):
    """Whether a member comes from plannercheck, not from what a class is built on."""
    owner = next(base for base in target.__mro__ if name in vars(base))
    return owner.__module__.split(".")[0] == "plannercheck"


def test_tables_of_figures_are_rendered_from_results(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "docs")
    script = importlib.import_module("render_results")
    stale = [
        page.name for page in script.pages() if script.rendered(page.read_text("utf-8")) != page.read_text("utf-8")
    ]
    assert stale == [], "run: python docs/render_results.py"


def test_every_result_is_shown():
    names = {path.stem for path in RESULTS.glob("*.json")}  # docs/results/history is data alone
    text = "".join(page.read_text("utf-8") for page in [*PAGES, *(ROOT / "docs").glob("result_*.py")])
    assert [name for name in sorted(names) if f'"{name}"' not in text] == []


def test_results_say_where_they_come_from():
    for path in RESULTS.glob("**/*.json"):
        found = json.loads(path.read_text("utf-8"))
        assert {"date", "commit", "machine"} <= found.keys(), path
        assert "command" in found or "source" in found, path


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_text("utf-8").splitlines()) <= MOST_README_LINES


def test_the_readme_has_two_commands_and_ci_runs_the_second_as_it_stands_there():
    text = (ROOT / "README.md").read_text("utf-8").partition("## Two commands\n")[2]
    found = BLOCK.search(text)
    assert found["text"].splitlines() == ["pip install . && plannercheck demo", "pip install '.[test]' && pytest"]
    assert found["text"].splitlines()[1] in (ROOT / ".ci/run").read_text("utf-8").splitlines()


def test_the_page_on_new_parts_names_every_file_that_has_its_example_shape():
    page = (ROOT / "docs/explanation/add_a_part.md").read_text("utf-8")
    sources = [path for path in (ROOT / "plannercheck").glob("**/*.py") if "evaluation" not in path.parts]
    having = [path for path in sources if re.search(r"\bEllipsoid\b", path.read_text("utf-8"))]
    assert [name for path in having if (name := str(path.relative_to(ROOT))) not in page] == []


def test_links_lead_somewhere():
    """Those of files that Sphinx does not read, or that a reader of the repository follows."""
    link = re.compile(r"\]\(([^)#:]+)(?:#[^)]*)?\)")
    targets = [(page, target) for page in PAGES for target in link.findall(page.read_text("utf-8"))]
    assert [(page.name, target) for page, target in targets if not (page.parent / target).exists()] == []


def test_pages_know_one_way_of_installing():
    other = re.compile(r"pip install (?:-e|plannercheck|'plannercheck|--upgrade)")
    assert [page.name for page in PAGES if other.search(page.read_text("utf-8"))] == []


def _is_not_docs(folder, name):
    return Path(folder) == ROOT and name not in ("docs", "CONTRIBUTING.md", "CHANGELOG.md")
