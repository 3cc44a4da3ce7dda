"""What a release stands on: one version everywhere, C++'s headers, scripts and licences that are there."""

import importlib
import importlib.metadata
import re
import sys
from pathlib import Path

import pytest

import plannercheck as pc
from plannercheck.common import package_data

ROOT = Path(__file__).parents[2]


def test_all_files_name_one_version(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "packaging")
    notes = importlib.import_module("release_notes")
    assert set(notes.versions().values()) == {pc.__version__}
    assert notes.section(pc.__version__)[1]


def test_cpp_installs_only_its_face() -> None:
    folder = ROOT / "plannercheck/cpp/library/include/plannercheck"
    promised = re.findall(r"`plannercheck/(\w+\.hpp)`", (ROOT / "docs/reference/public_names.md").read_text("utf-8"))
    assert sorted(path.name for path in folder.iterdir()) == sorted(promised)


def test_workflows_run_scripts_that_are_there() -> None:
    texts = [path.read_text("utf-8") for path in (ROOT / ".github/workflows").glob("*.yml")]
    scripts = {script for text in texts for script in re.findall(r"[.\w]+/[\w/]*(?:\.sh|\.py|run)\b", text)}
    assert {".ci/run", "packaging/sdist.sh", "packaging/aarch64.sh"} <= scripts
    assert [script for script in scripts if not (ROOT / script).exists()] == []


def test_every_page_of_licences_is_there() -> None:
    table = (ROOT / "packaging/licenses/README.md").read_text("utf-8")
    named = set(re.findall(r"`([\w./-]*(?:\.txt|LICENSE[\w-]*))` \|$", table, re.MULTILINE))
    assert len(named) == 4
    assert [
        name for name in named if not any((folder / name).exists() for folder in (ROOT, ROOT / "packaging/licenses"))
    ] == []


def test_example_robot_data_of_conda(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def none(name: str) -> None:
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(importlib.metadata, "distribution", none)
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    assert package_data.example_robot_data() == tmp_path.resolve() / "share"
