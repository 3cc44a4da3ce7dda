"""Where the files shipped with plannercheck are: robots, scenes, and example-robot-data."""

from __future__ import annotations

import importlib.metadata
from pathlib import Path

_PLANAR = "kind: planar"
_PACKAGE = Path(__file__).resolve().parent


def shipped_folder(name: str) -> Path:
    """The folder `robots` or `configs`, from the installed wheel or from a checkout.

    Args:
        name: "robots" or "configs".

    Returns:
        The folder's path.
    """
    installed = _PACKAGE / name
    return installed if installed.is_dir() else _PACKAGE.parent / name


def is_planar_file(path: Path) -> bool:
    """Whether a robot's or scene's YAML file says `kind: planar`."""
    return path.is_file() and any(line.rstrip() == _PLANAR for line in path.read_text(encoding="utf-8").splitlines())


def example_robot_data() -> Path:
    """The share folder of the example-robot-data wheel, a `package_dirs` entry for its URDFs."""
    distribution = importlib.metadata.distribution("example-robot-data")
    return Path(str(distribution.locate_file("cmeel.prefix/share"))).resolve()
