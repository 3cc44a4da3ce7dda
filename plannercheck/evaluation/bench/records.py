"""Results of measurements as JSON, with the circumstances: command, date, commit, machine.

In: rows of a measurement, as dataclasses or mappings. Out: a file that `docs/render_results.py` makes tables of, so
that no figure is copied by hand.
"""

from __future__ import annotations

import json
import os
import platform
import shlex
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, is_dataclass
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.core import core

_CHECKOUT = Path(__file__).parents[3]


def write_record(path: Path, rows: Sequence[Any]) -> None:
    """Writes frozen dataclasses or mappings of one kind, and the circumstances in which they were measured.

    The path is a `.json`, whose stem names the measurement.
    """
    record = {
        "measurement": path.stem,
        "command": command_line(sys.argv),
        "date": date.today().isoformat(),
        "commit": commit(),
        "machine": machine(),
        "rows": [_fields(row) for row in rows],
    }
    text = json.dumps(record, indent=1, ensure_ascii=False, default=_plain) + "\n"
    write_atomically(path, lambda aside: aside.write_text(text, encoding="utf-8"))


def command_line(arguments: Sequence[str]) -> str:
    """The command `sys.argv` as anyone may repeat it: without `--output` and without folders of this machine."""
    script, rest = Path(arguments[0]).absolute(), list(arguments[1:])
    while "--output" in rest:
        k = rest.index("--output")
        del rest[k : k + 2]
    rest = [Path(part).name if Path(part).is_absolute() else part for part in rest]
    if script.suffix != ".py" or script.name == "__main__.py":
        return shlex.join(["plannercheck", *rest])
    inside = script.is_relative_to(_CHECKOUT)
    return shlex.join(["python", str(script.relative_to(_CHECKOUT) if inside else script.name), *rest])


def commit() -> str | None:
    """The checkout's commit, short; None where plannercheck is installed instead."""
    if not (_CHECKOUT / ".git").exists():
        return None
    git = ["git", "-C", str(_CHECKOUT), "rev-parse", "--short=7", "HEAD"]
    try:
        return subprocess.run(git, check=True, capture_output=True, text=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return None


def machine() -> dict[str, Any]:
    """Processor, number of processors, the core's instruction set, and the mean load of a minute."""
    load = f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else None
    return {
        "processor": _processor(),
        "processors": os.cpu_count(),
        "instruction set": core.level,
        "load": load,
        "python": platform.python_version(),
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, platform.machine())


def _fields(row: Any) -> dict[str, Any]:
    if is_dataclass(row) and not isinstance(row, type):
        return asdict(row)
    assert isinstance(row, Mapping)
    return dict(row)


def _plain(value: Any) -> Any:
    """NumPy's numbers and arrays as JSON has them."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{value!r} can't be written as JSON")
