"""Runs of `validate` that are killed at random and resumed: the bytes are those of a run that nobody stopped.

In: how many kills. Out: counts. All output formats take turns with all input formats, plain verdicts with certificates
of each row. A kill counts once the run has begun its journal; those that came before are told apart.
"""

import itertools
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import plannercheck as pc
from long_runs.counts import BrokenPromiseError, Counts
from long_runs.environment import ENVIRONMENT, PYTHON

OUTPUTS = ("npz", "csv", "parquet")
INPUTS = ("npy", "npz", "csv", "parquet", "h5")
OPTIONS: tuple[tuple[str, ...], ...] = ((), ("--only-invalid",), ("--explain",))
ROWS = {(): 800_000, ("--only-invalid",): 800_000, ("--explain",): 28_000}  # a dozen chunks each
_LATE = 0.8  # The part of the kills that wait for the journal: most time goes by before it is begun.
KILLED_BY = (signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
_COMMAND = [*PYTHON, "-m", "plannercheck", "validate", "--robot", "panda", "--scene", "bookshelf"]


@dataclass
class _Stages:
    """When kills came: bytes of the journal at each, by what was run."""

    early: int = 0
    sizes: dict[str, list[int]] = field(default_factory=dict)
    by_signal: Counter[str] = field(default_factory=Counter)


def run(folder: Path, kills: int, rng: np.random.Generator, rows: float = 1.0) -> Counts:
    """Kills runs.

    Args:
        folder: For their files.
        kills: How many to make after a journal was begun.
        rng: When to kill.
        rows: What `ROWS` are multiplied by.

    Returns:
        Counts; raises `BrokenPromiseError` at other bytes, or at a file that was left behind.
    """
    stages, compared, done = _Stages(), Counter[str](), 0
    wholes: dict[tuple[str, ...], tuple[bytes, float]] = {}
    for trial in itertools.count():
        if done >= kills:
            break
        output, options = OUTPUTS[trial % len(OUTPUTS)], OPTIONS[trial // len(OUTPUTS) % len(OPTIONS)]
        source = _source(folder, INPUTS[trial % len(INPUTS)], max(100, round(rows * ROWS[options])))
        place = folder / f"o.{output}"
        key = (output, source.name, *options)
        if key not in wholes:
            began = time.monotonic()
            _finish([*_COMMAND, source, "--output", place, *options])
            wholes[key] = place.read_bytes(), time.monotonic() - began
            place.unlink()
        whole, usual = wholes[key]
        done += _one([*_COMMAND, source, "--output", place, *options], place, usual, rng, stages, kills - done)
        if place.read_bytes() != whole:
            raise BrokenPromiseError(f"{' '.join(key)}: other bytes after kills")
        place.unlink()
        left = sorted(path.name for path in folder.iterdir() if not path.name.startswith("q"))
        if left:
            raise BrokenPromiseError(f"{' '.join(key)}: left behind: {', '.join(left)}")
        compared[output] += 1
    written = sum(sum(size == max(sizes) for size in sizes) for sizes in stages.sizes.values())
    return {
        "kills": done,
        **{f"by {name}": count for name, count in sorted(stages.by_signal.items())},
        "with the longest journal": written,
        "before a journal": stages.early,
        **{f"equal {name} files": count for name, count in compared.items()},
    }


def _one(command: list[object], place: Path, usual: float, rng: np.random.Generator, stages: _Stages, most: int) -> int:
    """Starts a run until its output is there, and kills it on the way: how often."""
    done, patience = 0, 1.0  # which grows: an output may take longer to write than the first runs are given
    journal = Path(f"{place}.progress")
    # A kill between the output and the end of its journal leaves both: one more run resumes and takes the journal away.
    while not place.exists() or journal.exists():
        process = subprocess.Popen(
            [*map(str, command), "--resume"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=ENVIRONMENT
        )
        if done < most and rng.random() < _LATE:
            while process.poll() is None and not journal.exists():
                time.sleep(0.002)
        try:
            process.wait(None if done >= most else 0.5 * rng.uniform() ** 3 * usual * patience)
        except subprocess.TimeoutExpired:
            chosen = KILLED_BY[int(rng.integers(len(KILLED_BY)))]
            size = journal.stat().st_size if journal.exists() else 0
            process.send_signal(chosen)
            if process.wait() in (0, 1):  # it had just finished
                continue
            if size:
                done += 1
                stages.by_signal[chosen.name] += 1
                stages.sizes.setdefault(" ".join(map(str, command)), []).append(size)
            else:
                stages.early += 1
            patience *= 1.15
        if process.returncode not in (0, 1, -signal.SIGKILL, 130, 143, -signal.SIGINT, -signal.SIGTERM):
            raise BrokenPromiseError(f"a resumed run ended with {process.returncode}: {' '.join(map(str, command))}")
    return done


def _finish(command: list[object]) -> None:
    ran = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False, env=ENVIRONMENT)
    if ran.returncode not in (0, 1):
        raise BrokenPromiseError(f"{' '.join(map(str, command))} ended with {ran.returncode}: {ran.stderr[-1000:]}")


def _source(folder: Path, suffix: str, rows: int) -> Path:
    """Configurations in a file of a format."""
    path = folder / f"q{rows}.{suffix}"
    if path.exists():
        return path
    robot = pc.Robot.load("panda")
    q = robot.random_configurations(rows, 0)
    if suffix == "npy":
        np.save(path, q)
    elif suffix == "npz":
        np.savez(path, q=q)
    elif suffix == "csv":
        np.savetxt(path, q, delimiter=",", header=",".join(robot.joint_names), comments="", fmt="%.9g")
    else:  # in a process of its own, since later parts fork
        code = {"parquet": _PARQUET, "h5": _HDF5}[suffix]
        source = _source(folder, "npy", rows)
        subprocess.run([sys.executable, "-c", code, source, path, *robot.joint_names], check=True, env={**os.environ})
    return path


_PARQUET = """
import sys, numpy, pyarrow, pyarrow.parquet
rows = numpy.load(sys.argv[1])
pyarrow.parquet.write_table(pyarrow.table(dict(zip(sys.argv[3:], rows.T))), sys.argv[2])
"""
_HDF5 = """
import sys, numpy, h5py
with h5py.File(sys.argv[2], "w") as file:
    file["q"] = numpy.load(sys.argv[1])
"""
