"""Where the files shipped with plannercheck are: robots, scenes, and example-robot-data."""

from __future__ import annotations

import codecs
import importlib.metadata
import sys
from pathlib import Path

_PLANAR = "kind: planar"
_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_PACKAGE = Path(__file__).resolve().parents[1]


def shipped_folder(name: str) -> Path:
    """The folder `robots` or `configs`, from the installed wheel or from a checkout."""
    installed = _PACKAGE / "data" / name
    return installed if installed.is_dir() else _PACKAGE.parent / name


def is_planar_file(path: Path) -> bool:
    """Whether a robot's or scene's YAML file says `kind: planar`."""
    if not is_file(path):
        return False
    content = path.read_bytes()
    text = content.decode("utf-16" if content[:2] in _UTF16 else "utf-8", errors="replace")  # as YAML has it
    return any(line.rstrip() == _PLANAR for line in text.splitlines())


def example_robot_data() -> Path:
    """The share folder of the example-robot-data wheel or of conda's package, a `package_dirs` entry for its URDFs."""
    try:
        distribution = importlib.metadata.distribution("example-robot-data")
    except importlib.metadata.PackageNotFoundError:  # conda's is no distribution of Python
        return Path(sys.prefix, "share").resolve()
    return Path(str(distribution.locate_file("cmeel.prefix/share"))).resolve()


def is_file(path: Path) -> bool:
    """Whether there is a file; none can have a name that is too long, or stand where one may not look."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def is_folder(path: Path) -> bool:
    """Whether there is a folder, as `is_file`."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def why_no_file(path: Path) -> str:
    """Words of an error, after the path of what is no file."""
    if is_folder(path):
        return "is a folder: give the path of a file in it"
    return "does not exist" + (": ~ is not expanded, give the whole path" if path.parts[:1] == ("~",) else "")
