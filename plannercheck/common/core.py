"""Loads the compiled core for the best instruction set of this processor.

`PLANNERCHECK_LEVEL` (v2, v3, v4 or plain) overrides the choice; verdicts and poses are the same on every level.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import os
import platform
import sys
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from plannercheck.common.errors import PlannercheckError

LEVELS = ("v4", "v3", "v2", "plain")  # best first

# What a level needs, in the words of /proc/cpuinfo (Linux) or `sysctl machdep.cpu` (macOS).
_NEEDS = {
    "v4": ("avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"),
    "v3": ("avx2", "bmi1", "bmi2", "fma", "f16c", "movbe"),
    "v2": (),
    "plain": (),
}


def _processor_flags() -> frozenset[str]:
    """Lower-case feature names of this processor; empty where the system does not tell."""
    cpuinfo = Path("/proc/cpuinfo")
    if platform.system() == "Linux" and cpuinfo.exists():
        for line in cpuinfo.read_text().splitlines():
            if line.startswith("flags"):
                return frozenset(line.split(":", 1)[1].split())
    return frozenset()


def _core_folder() -> Path:
    """Where the extensions are: in this package, or with the installed package if this is a checkout.

    Python run in a checkout finds the checkout's files first, which have no core.
    """
    here = Path(__file__).resolve().parents[1]
    if not any(here.glob("_core_*")):
        try:
            installed = Path(str(importlib.metadata.distribution("plannercheck").locate_file("plannercheck")))
        except importlib.metadata.PackageNotFoundError:
            return here
        package_path = sys.modules["plannercheck"].__path__
        if str(installed) not in package_path:
            package_path.append(str(installed))
        return installed
    return here


def available_levels() -> list[str]:
    """The levels that are built and that this processor runs, best first."""
    flags = _processor_flags()
    built = {p.name.split(".")[0].removeprefix("_core_") for p in _core_folder().glob("_core_*")}
    return [level for level in LEVELS if level in built and flags.issuperset(_NEEDS[level])]


def load() -> ModuleType:
    """Imports the extension module of the chosen level."""
    levels = available_levels()
    wanted = os.environ.get("PLANNERCHECK_LEVEL")
    if wanted and wanted not in levels:
        raise PlannercheckError(f"PLANNERCHECK_LEVEL={wanted!r}: this machine and build have {', '.join(levels)}")
    if not levels:
        raise ImportError("plannercheck's compiled core is missing: reinstall with a C++20 compiler at hand")
    return importlib.import_module(f"plannercheck._core_{wanted or levels[0]}")


if TYPE_CHECKING:
    from plannercheck.common import _core as core  # one stub for all levels
else:
    core = load()

__all__ = ["LEVELS", "available_levels", "core", "load"]
