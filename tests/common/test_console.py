"""What is written on the console, by whom, while several threads work: nobody loses stdout, stderr or a log level."""

import json
import subprocess
import sys
import threading
from pathlib import Path

import pytest

import plannercheck as pc
from plannercheck.common.isolated_process import run_isolated
from plannercheck.common.silence import Silence
from plannercheck.evaluation.bench import many_boxes, set_up

# Eight threads load a robot, and one that does not load; then both streams are written to.
_LOADING = """
import os, sys, threading
import plannercheck as pc

def load():
    for _ in range(3):
        pc.Robot.load("ur5")
        try:
            pc.Robot.from_urdf(sys.argv[1])
        except pc.PlannercheckError as error:
            assert "broken.urdf" in str(error), error

before = [os.fstat(n).st_ino for n in (1, 2)]
threads = [threading.Thread(target=load) for _ in range(8)]
[t.start() for t in threads]
[t.join() for t in threads]
assert [os.fstat(n).st_ino for n in (1, 2)] == before
print("to stdout", flush=True)
print("to stderr", file=sys.stderr, flush=True)
"""


def test_threads_that_load_robots_leave_stdout_and_stderr_alone(tmp_path: Path) -> None:
    broken = tmp_path / "broken.urdf"
    broken.write_text('<robot name="r"><link name="a"/><joint name="j" type="revolute"/></robot>')
    ran = subprocess.run([sys.executable, "-c", _LOADING, broken], capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "to stdout\n", "to stderr\n")


def test_the_last_one_brings_the_level_back() -> None:
    level = [2]
    silence = Silence(lambda: level[0], lambda new: level.__setitem__(0, new), 9)
    first, second = silence(), silence()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    assert level == [9]
    second.__exit__(None, None, None)
    assert level == [2]


def test_concurrent_plans_leave_the_log_level() -> None:
    from ompl import util

    before = util.getLogLevel()
    checker = pc.Checker(pc.Robot.load("ur5"))
    q = checker.robot.reference

    def plan() -> None:
        for _ in range(20):
            pc.ompl.plan(checker, q, q + 0.01, time_limit=1.0, simplify=False)

    threads = [threading.Thread(target=plan) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert util.getLogLevel() == before


def test_workers_run_nothing_from_the_current_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("coacd", "numpy", "pinocchio", "runpy"):
        (tmp_path / f"{name}.py").write_text(f"raise SystemExit('{name} of the current folder was run')")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.syspath_prepend("")
    ran = run_isolated("plannercheck.bodies.coacd_worker")
    assert b"of the current folder" not in ran.stdout + ran.stderr
    assert b"plannercheck" in ran.stderr  # it was started, and had nothing to read


@pytest.mark.parametrize("measured", ["boxes", "set-up"])
def test_benchmarks_run_nothing_from_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, measured: str
) -> None:
    for name in ("json", "numpy", "pinocchio", "runpy"):
        (tmp_path / f"{name}.py").write_text(f"raise SystemExit('{name} of the current folder was run')")
    monkeypatch.chdir(tmp_path)
    if measured == "boxes":
        assert many_boxes.measure("panda", 1, True, 0).boxes == 1
    else:
        given = json.dumps(["panda", None, [0.0] * 7, [0.0] * 7])
        assert len(set_up._fresh(given, True)) == 6
