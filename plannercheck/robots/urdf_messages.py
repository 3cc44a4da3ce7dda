"""Says why a URDF does not load: `python -m plannercheck.robots.urdf_messages FILE FLOATING [FOLDER ...]`.

In: the file, whether its root floats, folders of packages. Out: what urdfdom, Pinocchio and assimp write on the
terminal. They write to the process's own descriptors, which can't be redirected safely in a process with threads. So a
file that failed is read again in a process of its own.
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from plannercheck.common.isolated_process import run_isolated

# If a URDF takes longer than this to fail, s, its readers are not heard.
_TIME_LIMIT = 60.0

# Where in its own sources urdfdom was when it found a fault.
_PLACE = re.compile(r"\s+at line \d+ in \S+\.cpp")


def native_messages(urdf: Path, floating: bool, folders: Sequence[str]) -> str:
    """What native code says about a URDF; empty if that can't be found out."""
    arguments = [str(urdf.resolve()), str(int(floating)), *folders]
    try:
        ran = run_isolated("plannercheck.robots.urdf_messages", arguments, time_limit=_TIME_LIMIT)
    except OSError:
        return ""
    except subprocess.TimeoutExpired:
        return f"reading it once more, to find out why, took over {_TIME_LIMIT:g} s"
    # A process that could not start prints a traceback, which is no message about the file.
    return "" if ran.returncode else _PLACE.sub("", (ran.stdout + ran.stderr).decode(errors="replace"))


def main(urdf: str, floating: str, *folders: str) -> None:
    """Reads a URDF for what is said about it."""
    import coal
    import pinocchio as pin

    try:
        model = pin.buildModelFromUrdf(urdf, *([pin.JointModelFreeFlyer()] if int(floating) else []))
        loader = coal.CachedMeshLoader(coal.NODE_TYPE.BV_OBB)
        pin.buildGeomFromUrdf(model, urdf, pin.COLLISION, package_dirs=list(folders), mesh_loader=loader)
    except (ValueError, RuntimeError, IndexError):
        return  # the parent has caught the same


if __name__ == "__main__":
    main(*sys.argv[1:])
