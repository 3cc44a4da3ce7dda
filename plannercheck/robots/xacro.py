"""Whether a file is a xacro, which nothing here reads.

In: a path. Out: a sentence that says what to do, or an empty one.
"""

from __future__ import annotations

from pathlib import Path

# What only xacro knows.
_XACRO_SIGNS = (b"<xacro:", b"${")


def xacro_hint(path: Path) -> str:
    """Says so if a file is a xacro; empty if it is none, or can't be read."""
    try:
        content = path.read_bytes()
    except OSError:
        return ""
    if path.suffix != ".xacro" and not any(sign in content for sign in _XACRO_SIGNS):
        return ""
    return f"it is a xacro, which has to be expanded first: xacro {path.name} > expanded.urdf"
