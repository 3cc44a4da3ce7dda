"""`plannercheck validate` on many configurations: `python tests/benchmarks/validate_scale.py --folder /tmp/scale`.

Random configurations of a Panda in the bookshelf, as npy, through the command line in a process: alone, with a SIGKILL
in the middle and `--resume`, and on a dask cluster of two workers of which one gets a SIGKILL. Prints the rate, the
peak memory of that process, the share of time outside the checker, and whether the outputs are the same bytes. The file
(560 MB for 10 million) and the outputs are removed at the end.
"""

from __future__ import annotations

import argparse
import filecmp
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import plannercheck as pc
from plannercheck.evaluation.bench.records import write_record

ROBOT, SCENE, SEED = "panda", "bookshelf", 0
MADE_AT_ONCE = 1_000_000
RUNS = ("alone", "killed", "dask")

# Bytes of the journal a configuration: the first pair, and whether it is beyond the limits.
JOURNAL_BYTES = 5


def make(path: Path, count: int) -> None:
    """Writes uniformly random configurations, a part at a time."""
    robot, generator = pc.Robot.load(ROBOT), np.random.default_rng(SEED)
    rows = np.lib.format.open_memmap(path, mode="w+", dtype=np.float64, shape=(count, robot.nq))
    for first in range(0, count, MADE_AT_ONCE):
        rows[first : first + MADE_AT_ONCE] = robot.random_configurations(min(MADE_AT_ONCE, count - first), generator)


class Process:
    """The command in a process of its own."""

    def __init__(self, source: Path, output: Path, *options: str) -> None:
        self.journal = output.with_name(output.name + ".progress")
        self._summary = output.with_suffix(".json")
        where = ["--robot", ROBOT, "--scene", SCENE, "--output", str(output), "--summary", str(self._summary)]
        command = [sys.executable, "-m", "plannercheck", "validate", *where, *options, str(source)]
        self._began = time.perf_counter()
        self._process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        self.pid = self._process.pid

    def wait_for(self, part: float, count: int) -> None:
        """Until the journal has that part of the configurations."""
        while not self.journal.exists() or self.journal.stat().st_size < part * count * JOURNAL_BYTES:
            time.sleep(0.01)

    def result(self) -> dict[str, float]:
        """Waits for the end: the summary, seconds, and peak memory in MB."""
        peak = 0.0
        while self._process.poll() is None:
            peak = max(peak, peak_memory(self.pid))
            time.sleep(0.05)
        seconds = time.perf_counter() - self._began
        if self._process.returncode not in (0, 1):
            return {"wall": seconds, "peak": peak}
        return {**json.loads(self._summary.read_text()), "wall": seconds, "peak": peak}


def peak_memory(pid: int) -> float:
    """Most memory that a process has held so far, MB; 0 if it is gone. (A child's rusage counts its parent's, too.)"""
    try:
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    except OSError:
        return 0.0
    return next((int(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM:")), 0.0)


def alone(source: Path, output: Path, count: int) -> dict[str, float]:
    """One process, one thread."""
    return Process(source, output).result()


def killed(source: Path, output: Path, count: int) -> dict[str, float]:
    """The same, killed in the middle, and resumed."""
    first = Process(source, output)
    first.wait_for(0.5, count)
    os.kill(first.pid, signal.SIGKILL)
    before = first.result()
    assert not output.exists()
    after = Process(source, output, "--resume").result()
    return {**after, "wall": before["wall"] + after["wall"], "peak": max(before["peak"], after["peak"])}


def on_dask(source: Path, output: Path, count: int) -> dict[str, float]:
    """Two workers, one killed when a third is done."""
    process = Process(source, output, "--engine", "dask", "--workers", "2")
    process.wait_for(1 / 3, count)
    os.kill(worker_of(process.pid), signal.SIGKILL)
    return process.result()


def worker_of(parent: int) -> int:
    """A worker's process: a child that multiprocessing has spawned, and no helper of it."""
    import psutil  # distributed brings it

    children = psutil.Process(parent).children(recursive=True)
    return int(min(child.pid for child in children if any("spawn_main" in word for word in child.cmdline())))


def shown(name: str, found: dict[str, float], same: bool) -> str:
    """A line of the table."""
    fresh = found["states"] - found["resumed"]
    share = f"{1 - found['checking'] / found['elapsed']:6.1%}" if name != "dask" else "     -"
    return (
        f"{name:8} {found['states']:>12,} {found['resumed']:>12,} {found['wall']:8.1f} {found['elapsed']:8.1f} "
        f"{fresh / found['elapsed']:>12,.0f} {1e6 * found['checking'] / fresh:8.2f} {share} {found['peak']:8.0f}  "
        f"{'yes' if same else 'NO'}"
    )


def main() -> None:
    """Makes the file, runs, prints the table, cleans up."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--states", type=int, default=10_000_000)
    parser.add_argument("--folder", type=Path, help="where the files go; default: a temporary folder")
    parser.add_argument("--runs", nargs="+", choices=RUNS, default=RUNS)
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    ways: dict[str, Callable[[Path, Path, int], dict[str, float]]] = {"alone": alone, "killed": killed, "dask": on_dask}
    if options.folder is not None:
        options.folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=options.folder) as name:
        folder = Path(name)
        make(folder / "q.npy", options.states)
        print(
            f"{'':8} {'states':>12} {'resumed':>12} {'wall s':>8} {'run s':>8} {'states/s':>12} {'µs check':>8} "
            f"outside  peak MB  same bytes",
            flush=True,
        )
        rows: list[dict[str, object]] = []
        for run in options.runs:
            output = folder / f"{run}.npz"
            found = ways[run](folder / "q.npy", output, options.states)
            same = filecmp.cmp(output, folder / f"{options.runs[0]}.npz", shallow=False)
            print(shown(run, found, same), flush=True)
            rows.append({"run": run, "same": same, **found})
        if options.output:
            write_record(options.output, rows)


if __name__ == "__main__":
    main()
