"""The order of the folders: a folder includes and imports only those below it; one wrong line is found.

import-linter holds the Python packages to the contract in pyproject.toml, the lists below hold the folders of cpp/.
"""

import graphlib
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CPP = ROOT / "plannercheck" / "cpp"

# Bottom first; folders in one line know nothing of each other.
LAYERS = [
    ["math"],
    ["bodies", "robots"],
    ["narrow_phase", "broad_phase"],
    ["checking"],
    ["distances"],
    ["motions"],
    ["planar", "library"],
    ["bindings"],
]
# What the core is held against shares nothing with it.
APART = ["oracle"]


def includes() -> dict[str, list[str]]:
    """What each source and header of the core includes with quotes, by its path from cpp/."""
    sources = sorted([*CPP.glob("**/*.cpp"), *CPP.glob("**/*.hpp")])
    return {
        str(path.relative_to(CPP)): re.findall(r'^#include "([^"]+)"', path.read_text(encoding="utf-8"), re.MULTILINE)
        for path in sources
    }


def faults(included: Mapping[str, list[str]]) -> list[str]:
    """Includes of a folder that is not below the file's own, and of files that are not there."""
    floor = {folder: k for k, layer in enumerate(LAYERS) for folder in layer}
    found = []
    for file, names in included.items():
        own = file.split("/")[0]
        for name in names:
            other = name.split("/")[0]
            is_below = own in floor and other in floor and floor[other] < floor[own]
            if name not in included or (other != own and not is_below):
                found.append(f"{file} includes {name}")
    return found


def test_every_folder_of_the_core_has_its_place():
    folders = {path.name for path in CPP.iterdir() if path.is_dir()}
    assert folders == {*APART, *(folder for layer in LAYERS for folder in layer)}


def test_the_core_includes_only_what_is_below():
    included = includes()
    assert len(included) > 100
    assert faults(included) == []


def test_the_core_includes_in_no_circle():
    graphlib.TopologicalSorter(includes()).prepare()


@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("bodies/hull.hpp", "narrow_phase/gjk.hpp"),  # up
        ("broad_phase/mover_groups.hpp", "narrow_phase/gjk.hpp"),  # across
        ("math/vec.hpp", "simd.hpp"),  # without its folder
        ("oracle/integer.hpp", "math/dyadic.hpp"),  # from what has to stand apart
    ],
)
def test_a_wrong_include_is_found(file, name):
    included = includes()
    included[file] = [*included[file], name]
    assert faults(included) == [f"{file} includes {name}"]


def test_a_circle_is_found():
    included = includes()
    included["math/vec.hpp"] = ["math/dyadic.hpp"]
    with pytest.raises(graphlib.CycleError):
        graphlib.TopologicalSorter(included).prepare()


@pytest.fixture
def lint(tmp_path):
    """Runs import-linter on a copy of the package's Python."""
    pytest.importorskip("importlinter", reason="pip install '.[dev]'")
    package = ROOT / "plannercheck"
    shutil.copytree(package, tmp_path / "plannercheck", ignore=shutil.ignore_patterns("cpp", "*.so", "__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)

    def run() -> tuple[int, str]:
        code = "import sys; from importlinter.cli import lint_imports_command as c; c(['--no-cache'])"
        environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
        done = subprocess.run(
            [sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
        )
        return done.returncode, " ".join((done.stdout + done.stderr).split())

    return run


def test_the_package_imports_only_what_is_below(lint):
    code, said = lint()
    assert code == 0, said


@pytest.mark.parametrize(
    ("file", "line", "says"),
    [
        ("bodies/shapes.py", "import plannercheck.robots.robot", "plannercheck.bodies.shapes -> plannercheck.robots"),
        ("robots/srdf.py", "import plannercheck.scenes.scene", "plannercheck.robots.srdf -> plannercheck.scenes"),
        ("ndim/game.py", "from plannercheck.bodies import polytope", "plannercheck.ndim.game -> plannercheck.bodies"),
        # A circle inside a folder, and through a function.
        ("bodies/solids.py", "def f():\n    import plannercheck.bodies.shapes", "in plannercheck.bodies. It could"),
    ],
)
def test_a_wrong_import_is_found(lint, tmp_path, file, line, says):
    path = tmp_path / "plannercheck" / file
    path.write_text(f"{path.read_text()}\n{line}\n")
    code, said = lint()
    assert code == 1
    assert says in said


def test_a_folder_without_a_place_is_found(lint, tmp_path):
    (tmp_path / "plannercheck" / "loft").mkdir()
    (tmp_path / "plannercheck" / "loft" / "__init__.py").write_text("")
    code, said = lint()
    assert code == 1
    assert "loft" in said


def units() -> list[list[Path]]:
    """Sources that CMake compiles as one, by CMakeLists.txt: those of all levels together, and those of each level."""
    text = (CPP / "CMakeLists.txt").read_text(encoding="utf-8")
    (by_level,) = re.findall(r"^foreach\(source ([\w ]+)\)", text, re.MULTILINE)
    (more,) = re.findall(r"^list\(APPEND common_sources\s+([^)]*)\)", text, re.MULTILINE)
    common = {*CPP.glob("math/*.cpp"), *CPP.glob("bodies/*.cpp"), *(CPP / name for name in more.split())}
    common -= {CPP / "bodies" / f"{name}.cpp" for name in by_level.split()}
    apart = {"oracle", "bindings", "library"}
    each = {p for p in CPP.glob("*/*.cpp") if p not in common and p.parent.name not in apart}
    return [sorted(common), sorted(each | {CPP / "library" / "engine.cpp"})]


def test_constants_of_sources_that_are_compiled_as_one_have_names_of_their_own():
    for unit in units():
        assert len(unit) > 30
        known: dict[str, Path] = {}
        for path in unit:
            for line in re.findall(r"^(?:inline )?constexpr (.*)$", path.read_text(encoding="utf-8"), re.MULTILINE):
                for name in set(re.findall(r"\b(k[A-Z]\w*)(?: = |\{)", line)):
                    assert name not in known, f"{name} is in {known[name].name} and in {path.name}"
                    known[name] = path
