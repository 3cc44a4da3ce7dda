"""Names the kind of a file that was taken for another kind.

In: a file's content, or its path. Out: a clause for an error message, "it is a URDF", empty where nothing is known.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

# The bytes at the start of a file that decide its kind.
_START = 1 << 16

# How files begin.
_MAGIC = {
    b"version https://git-lfs": "it is a Git LFS pointer, not the file itself: `git lfs pull` fetches it",
    b"\x93NUMPY": "it is a numpy array, as .npy files are",
    b"\x89HDF": "it is an HDF5 file",
    b"PAR1\x15": "it is a parquet file",
    b"PK\x03\x04": "it is a zip archive, as .npz files are",
    b"\x89PNG": "it is a picture",
    b"\xff\xd8\xff": "it is a picture",
}

# What the root of an XML document tells.
# Each part of it has one match: where several had, many comments in front of anything else would take for ever.
_ROOT = re.compile(
    rb"\A(?:\xef\xbb\xbf)?\s*(?:<\?(?:(?!\?>).)*\?>\s*|<!--(?:(?!-->).)*-->\s*|<!(?!--)[^>]*>\s*)*<([A-Za-z]\w*)",
    re.DOTALL,
)
_ROOTS = {
    b"sdf": "it is an SDF of Gazebo",
    b"mujoco": "it is an MJCF of MuJoCo",
    b"html": "it is a web page",
}
_URDF_LINK = re.compile(rb"<link\b[^>]*[^/]>|<joint\b[^>]*\btype\s*=")


def file_kind(content: bytes) -> str:
    """What a file is, told by how its content begins: a clause; empty if nothing is known."""
    found = _kind_unless_xml(content)
    root = None if found else _ROOT.match(content)
    if root is None:
        return found
    if b"<xacro:" in content:
        return "it is a xacro"
    if root[1] == b"robot":
        return "it is a URDF" if _URDF_LINK.search(content) else "it is an SRDF"
    return _ROOTS.get(root[1].lower(), f"it is XML whose root is <{root[1].decode()}>")


def is_mjcf(content: bytes) -> bool:
    """Whether a file is XML whose root is that of MuJoCo's format."""
    root = _ROOT.match(content)
    return root is not None and root[1] == b"mujoco"


def kind_of(path: Path) -> str:
    """`file_kind` of a file; a folder is one, too, and of what can't be read nothing is known."""
    return _of_file(path, file_kind)


def kind_unless_xml(path: Path) -> str:
    """`kind_of` a file; empty also if it begins as XML does, which may then be broken."""
    return _of_file(path, _kind_unless_xml)


def _kind_unless_xml(content: bytes) -> str:
    if not content.strip():
        return "it is empty"
    return next((words for magic, words in _MAGIC.items() if content.startswith(magic)), "")


def _of_file(path: Path, kind: Callable[[bytes], str]) -> str:
    try:
        with path.open("rb") as file:
            return kind(file.read(_START))
    except IsADirectoryError:
        return "it is a folder"
    except (OSError, ValueError):
        return ""
