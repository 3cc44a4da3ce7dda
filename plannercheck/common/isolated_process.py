"""Runs one of our modules, or some lines, in a separate process that imports nothing from the user's current folder.

In: the module's name or the lines, its standard input and arguments. Out: its output. Python's isolated mode removes
the current folder and the user's environment from the path; the parent's path follows after the installed packages.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

# The first argument is the path.
_FIND = "import os, sys; sys.path += sys.argv.pop(1).split(os.pathsep)\n"

# The first argument names the module, the second the path.
_START = (
    "import os, runpy, sys; "
    "module, path = sys.argv[1:3]; del sys.argv[1:3]; "
    "sys.path += path.split(os.pathsep); "
    "runpy.run_module(module, run_name='__main__', alter_sys=True)"
)


def run_isolated(
    module: str, arguments: Sequence[str] = (), content: bytes = b"", time_limit: float | None = None
) -> subprocess.CompletedProcess[bytes]:
    """Runs a module, e.g. "plannercheck.bodies.coacd_worker", as a program, and returns its code, output and messages.

    `content` is its standard input; the time limit is in s, None waits for ever.

    Raises:
        subprocess.TimeoutExpired: After the time limit; the process is gone then.
    """
    command = [sys.executable, "-I", "-c", _START, module, os.pathsep.join(_path()), *arguments]
    return subprocess.run(command, input=content, capture_output=True, check=False, timeout=time_limit)


def run_isolated_lines(
    lines: str, argument: str, environment: Mapping[str, str] | None = None, time_limit: float | None = None
) -> subprocess.CompletedProcess[str]:
    """Runs lines of Python, whose `sys.argv[1]` is the argument; output and errors as of `run_isolated`.

    The environment is this process's if None.
    """
    command = [sys.executable, "-I", "-c", _FIND + lines, os.pathsep.join(_path()), argument]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=time_limit)


def _path() -> list[str]:
    """Where the parent finds modules, less the current folder, which no one chose; ours in any case."""
    ours, here = str(Path(__file__).resolve().parents[2]), os.path.realpath(os.curdir)
    others = [folder for folder in sys.path if folder and os.path.realpath(folder) not in (here, ours)]
    return [*others, ours]
