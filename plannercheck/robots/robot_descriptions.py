"""Robots by name from the package robot_descriptions, where it is installed.

In: the name of one of its modules, such as "panda_description". Out: where the robot's files are. The package fetches
them at first use; if that fails, our error repeats its message.
"""

from __future__ import annotations

import importlib
import importlib.util
from typing import Any, NamedTuple

from plannercheck.common.errors import PlannercheckError

_PACKAGE = "robot_descriptions"


class NamedFiles(NamedTuple):
    """Files of a robot.

    Attributes:
        urdf: Path of the URDF, of a xacro or of an MJCF file.
        srdf: Path of the SRDF, if there is one.
        folders: Folders that contain packages.
        xacro_args: Values of the xacro's arguments.
    """

    urdf: str
    srdf: str | None
    folders: tuple[str, ...]
    xacro_args: dict[str, str]


def files_by_name(name: str) -> NamedFiles | None:
    """The files of a robot; None if the package is not installed, or has no such module.

    Raises:
        PlannercheckError: If the files can't be fetched, or are of a kind that is not supported.
    """
    if not name.isidentifier() or name.startswith("_") or importlib.util.find_spec(_PACKAGE) is None:
        return None
    if importlib.util.find_spec(f"{_PACKAGE}.{name}") is None:
        return None
    try:
        module: Any = importlib.import_module(f"{_PACKAGE}.{name}")
    except Exception as error:  # of git, of the network, of the file system
        reason = " ".join(str(error).split()) or type(error).__name__
        raise PlannercheckError(f"robot {name!r} of {_PACKAGE} can't be fetched: {reason:.400}") from None
    urdf = next(
        (getattr(module, key) for key in ("URDF_PATH", "XACRO_PATH", "MJCF_PATH") if hasattr(module, key)), None
    )
    if urdf is None:
        raise PlannercheckError(f"robot {name!r} of {_PACKAGE} has no URDF and no MJCF file")
    arguments = {key: str(value) for key, value in getattr(module, "XACRO_ARGS", {}).items()}
    is_xacro = not hasattr(module, "URDF_PATH") and hasattr(module, "XACRO_PATH")
    return NamedFiles(str(urdf), getattr(module, "SRDF_PATH", None), _folders(module), arguments if is_xacro else {})


def _folders(module: Any) -> tuple[str, ...]:
    """Where the packages of a module's robot are, as far as it says so."""
    named = getattr(module, "XACRO_PACKAGE_PATHS", {}).values()
    whole = [getattr(module, key, None) for key in ("PACKAGE_PATH", "REPOSITORY_PATH")]
    return tuple(dict.fromkeys(str(folder) for folder in (*named, *whole) if folder))
