"""A copy of the checkout with a build of its own, into which `mutation.py` puts small faults.

In: a folder for temporary files, a SIMD level. Out: `CheckoutCopy`, which builds, applies a mutant, runs tests. The
folder is kept for the next run: what did not change keeps its time, and so its build.
"""

import contextlib
import fcntl
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from mutants import CHECKOUT, Mutant

BUILD_LIMIT = 1800.0  # s for a first build in one thread
MEMORY = 12_000_000  # kB that tests may take, so that a mutant without an end does not take the machine's


class Ran(NamedTuple):
    """A command's exit code, None if it was ended at its time limit, and what it wrote."""

    code: int | None
    text: str


def run(command: Sequence[str], folder: Path, environment: dict[str, str], limit: float) -> Ran:
    """Runs a command in a group of its own, all of which ends at the time limit."""
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as written:
        process = subprocess.Popen(
            command, cwd=folder, env=environment, stdout=written, stderr=subprocess.STDOUT, start_new_session=True
        )
        try:
            code: int | None = process.wait(limit)
        except subprocess.TimeoutExpired:
            code = None
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
        written.seek(0)
        return Ran(code, written.read())


class CheckoutCopy:
    """The copy."""

    def __init__(self, folder: Path, level: str) -> None:
        """Brings the folder up to date with the checkout; what did not change keeps its time, and so its build."""
        self.root, self._level = folder / "checkout", level
        self._build = folder / f"build-{level}"
        self._original = folder / f"core-{level}"
        self._is_built = False
        self.environment = os.environ | {
            "PYTHONPATH": str(self.root),
            "PYTHONHASHSEED": "0",
            "PLANNERCHECK_CACHE": "0",
            "PLANNERCHECK_LEVEL": level,
            "CCACHE_BASEDIR": str(self.root),
            "CCACHE_NOHASHDIR": "1",
        }
        self.root.mkdir(parents=True, exist_ok=True)
        self._lock = (folder / "lock").open("w")
        fcntl.flock(self._lock, fcntl.LOCK_EX)
        self._follow_the_checkout()

    def _follow_the_checkout(self) -> None:
        command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
        listed = subprocess.run(command, cwd=CHECKOUT, check=True, capture_output=True, text=True).stdout
        files = {name for name in listed.split("\0") if name and (CHECKOUT / name).is_file()}
        for path in [path for path in self.root.rglob("*") if path.is_file() or path.is_symlink()]:
            if str(path.relative_to(self.root)) not in files:
                path.unlink()
        for name in sorted(files):
            source, target = CHECKOUT / name, self.root / name
            if not target.is_file() or target.read_bytes() != source.read_bytes():
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(source.read_bytes())
                shutil.copymode(source, target)

    def build(self) -> str:
        """Builds the core of what is in the copy and puts it into its package; what the compiler said if it can't."""
        configure = ["cmake", "-S", "plannercheck/cpp", "-B", str(self._build), f"-DPLANNERCHECK_LEVELS={self._level}"]
        configure += ["-DCMAKE_UNITY_BUILD=OFF", f"-DPython_EXECUTABLE={sys.executable}"]
        configure += ["-GNinja"] if shutil.which("ninja") else []
        configure += ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
        commands = [] if (self._build / "CMakeCache.txt").exists() else [configure]
        for command in [*commands, ["cmake", "--build", str(self._build), "--parallel", "2"]]:
            ran = run(command, self.root, self.environment, BUILD_LIMIT)
            if ran.code != 0:
                return ran.text or "no word of the compiler: its time was over"
        self._put_in(self._build)
        return ""

    def build_original(self) -> None:
        """Builds the core without any mutant, once, and keeps it aside."""
        if self._is_built:
            return
        if said := self.build():
            raise SystemExit(f"The checkout itself does not build:\n{said[-3000:]}")
        self._original.mkdir(exist_ok=True)
        for path in self.root.glob("plannercheck/*.so"):
            shutil.copy2(path, self._original)
        self._is_built = True

    def _put_in(self, folder: Path) -> None:
        for path in folder.glob("*.so"):
            target = self.root / "plannercheck" / path.name
            target.unlink(missing_ok=True)  # never written over: a process that still has it open would crash
            shutil.copy2(path, target)

    def test(self, tests: Iterable[str], limit: float, *options: str) -> Ran:
        """Runs tests as they stand in the copy."""
        shutil.rmtree(self.root / ".hypothesis", ignore_errors=True)
        command = [
            sys.executable,
            "-m",
            "pytest",
            "-q",
            "-n0",
            "-rfE",
            "--tb=line",
            "-p",
            "no:cacheprovider",
            *options,
            *tests,
        ]
        limited = ["/bin/sh", "-c", f'ulimit -v {MEMORY}; exec "$0" "$@"', *command]
        return run(limited, self.root, self.environment, limit)

    @contextlib.contextmanager
    def with_mutant(self, mutant: Mutant) -> Iterator[str]:
        """Puts a mutant in, and takes it out again; gives what the compiler said if it can't be built."""
        path = self.root / mutant.file
        text = path.read_text(encoding="utf-8")
        try:
            self._write(path, mutant.applied(text))
            yield self.build() if mutant.is_compiled else ""
        finally:
            self._write(path, text)
            if mutant.is_compiled:
                self._put_in(self._original)

    def _write(self, path: Path, text: str) -> None:
        """Writes a source; its byte code goes, since it is told by seconds and sizes."""
        path.write_text(text, encoding="utf-8")
        for compiled in (path.parent / "__pycache__").glob(f"{path.stem}.*.pyc"):
            compiled.unlink()
