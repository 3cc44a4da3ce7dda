"""Says why a URDF does not load: `python -m plannercheck.robots.urdf_messages FILE FLOATING`.

In: the file, whether its root floats. Out: the messages of urdfdom and Pinocchio. They write to the process's
descriptors, which can't be redirected safely in a process with threads. So a file that failed is read again in a
separate process.
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

from plannercheck.common.isolated_process import run_isolated

# If a URDF takes longer than this to fail, s, its readers are not heard.
_TIME_LIMIT = 60.0

# Where in its own sources urdfdom was when it found a fault.
_PLACE = re.compile(r"\s+at line \d+ in \S+\.cpp")


def native_messages(urdf: Path, floating: bool) -> str:
    """What native code says about a URDF; empty if that can't be found out."""
    arguments = [str(urdf.resolve()), str(int(floating))]
    try:
        ran = run_isolated("plannercheck.robots.urdf_messages", arguments, time_limit=_TIME_LIMIT)
    except OSError:
        return ""
    except subprocess.TimeoutExpired:
        return f"reading it once more, to find out why, took over {_TIME_LIMIT:g} s"
    # A process that could not start prints a traceback, which is no message about the file.
    return "" if ran.returncode else _PLACE.sub("", (ran.stdout + ran.stderr).decode(errors="replace"))


def main(urdf: str, floating: str) -> None:
    """Reads a URDF for what is said about it."""
    import pinocchio as pin

    try:
        pin.buildModelFromUrdf(urdf, *([pin.JointModelFreeFlyer()] if int(floating) else []))
    except (ValueError, RuntimeError, IndexError):
        return  # the parent has caught the same


if __name__ == "__main__":
    main(*sys.argv[1:])
