"""xacro files: whether a file is one, and what it expands to.

In: a path, arguments, folders of packages. Out: the text of a URDF, or a sentence on what to do. PyPI's xacro runs in a
separate process, since its state is global and it prints; `$(find PACKAGE)` finds packages as package:// does.
"""

from __future__ import annotations

import json
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

from plannercheck.common.errors import PlannercheckError
from plannercheck.common.isolated_process import run_isolated
from plannercheck.common.optional_imports import extra_module
from plannercheck.common.package_data import is_file, why_no_file
from plannercheck.common.user_warnings import warn

XACRO_SUFFIX = ".xacro"

# Marks that only xacro files have.
_XACRO_SIGNS = (b"<xacro:", b"${", b"$(optenv ", b"$(arg ", b"$(find ", b"$(env ")

# The time limit for expanding a file, s.
_TIME_LIMIT = 120.0


def xacro_hint(path: Path) -> str:
    """Says so if a file is a xacro that was not expanded; empty if it is none, or can't be read."""
    try:
        content = path.read_bytes()
    except OSError:
        return ""
    if path.suffix == XACRO_SUFFIX or not any(sign in content for sign in _XACRO_SIGNS):
        return ""
    name = path.name
    return f"it is a xacro, which has to be expanded first: xacro {name} > expanded.urdf; or call it {name}.xacro"


def expanded(path: Path, arguments: Mapping[str, str], folders: Sequence[Path]) -> str:
    """The text of the URDF that a xacro file stands for, with its <xacro:arg>s by name.

    Its packages are searched in the folders first. What xacro warns of is one warning.

    Raises:
        PlannercheckError: If it can't be expanded; the message is xacro's.
    """
    if not is_file(path):
        raise PlannercheckError(f"xacro {path} {why_no_file(path)}")
    extra_module("xacro", "xacro", "xacro files")
    task = json.dumps({"arguments": dict(arguments), "folders": [str(folder.resolve()) for folder in folders]})
    try:
        ran = run_isolated("plannercheck.robots.xacro_worker", [str(path.absolute())], task.encode(), _TIME_LIMIT)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise PlannercheckError(f"xacro {path} can't be expanded: {error}") from None
    said = " ".join(ran.stderr.decode(errors="replace").split())
    if ran.returncode:
        raise PlannercheckError(f"xacro {path} can't be expanded: {said:.600}")
    if said:
        warn(f"xacro {path}: {said:.600}")
    return ran.stdout.decode()
