"""The long runs of docs/explanation/reliability.md, with few trials each: that they run, count and notice."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from long_runs import forked, seed_files
from long_runs.environment import ENVIRONMENT
from long_runs.loaders import FILES, NAMES

import plannercheck as pc

SCRIPT = Path(__file__).parents[1] / "benchmarks" / "reliability.py"


def rows_of(tmp_path: Path, *arguments: str) -> list[dict[str, object]]:
    table = tmp_path / "table.jsonl"
    command = [sys.executable, str(SCRIPT), *arguments, "--output", str(table)]
    ran = subprocess.run(command, capture_output=True, text=True, check=False, env=ENVIRONMENT)
    assert ran.returncode == 0, ran.stdout[-3000:] + ran.stderr[-3000:]
    return [json.loads(line) for line in table.read_text(encoding="utf-8").splitlines()]


def test_damage_scenes_plans_threads_and_forks(tmp_path: Path) -> None:
    parts = ("damage", "scenes", "plans", "threads", "forks")
    counts = ("--damage", "4", "--scenes", "20", "--plans", "4", "--threads", "1", "--forks", "1")
    rows = {row["part"]: row for row in rows_of(tmp_path, *parts, *counts)}
    assert rows["damage"]["bodies"] == rows["damage"]["cache files"] == rows["damage"]["journals"] == 4
    assert rows["scenes"]["calls"] == 20
    assert rows["plans"]["plans"] == 4
    assert rows["threads"]["threads"] == 8
    assert rows["forks"]["calls"] == 80


def test_kills(tmp_path: Path) -> None:
    (row,) = rows_of(tmp_path, "kills", "--kills", "1")
    assert row["kills"] == 1


def test_mutated_inputs_of_every_loader(tmp_path: Path) -> None:
    rows = rows_of(tmp_path, "mutants", "--mutants", "5")
    assert [row["loader"] for row in rows] == list(NAMES)
    assert all((row["inputs"], row["faults"]) == (5, 0) for row in rows)


def test_what_dies_hangs_or_raises_is_charged_to_its_trial(tmp_path: Path) -> None:
    """Else the runs above would pass with nothing behind them."""

    def trial(number: int) -> str:
        if number == 2:
            os.abort()
        if number == 4:
            while True:
                time.sleep(1)
        if number == 5:
            raise KeyError("no error of ours")
        if number == 6:
            raise pc.PlannercheckError("an error of ours")
        if number == 7:
            return str(len(bytes(3 << 30)))
        return "accepted"

    tally = forked.run(trial, 9, tmp_path, time_limit=1.0, batch=4)
    assert tally.outcomes == {"accepted": 4, "refused": 1}
    words = dict(tally.faults)
    assert sorted(words) == [2, 4, 5, 7]
    assert "SIGABRT" in words[2]
    assert "hangs" in words[4]
    assert "KeyError" in words[5]
    assert "MemoryError" in words[7]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the sound files of all loaders."""
    folder = tmp_path_factory.mktemp("sound")
    forked.apart(lambda: seed_files.make(folder), folder)
    return folder


@pytest.mark.parametrize("name", FILES)
def test_each_loader_takes_its_sound_files(name: str, made: Path) -> None:
    loader = FILES[name]
    sound = [p for p in (made / name).rglob("*") if p.is_file() and p.suffix in (loader.suffixes or (p.suffix,))]
    assert sound
    for path in sound:
        loader.read(path)


def test_the_page_has_the_number_of_loaders() -> None:
    page = Path(__file__).parents[2] / "docs" / "explanation" / "reliability.md"
    assert f"each of {len(FILES)} loaders" in page.read_text(encoding="utf-8")
