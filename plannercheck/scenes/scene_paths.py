"""Finds the files that scenes name.

In: a scene's name for a mesh or another file: a path, or a file:// or package:// address. Out: the path of the file.
Packages are found as for URDFs (common/package_files.py).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from plannercheck.common.errors import PlannercheckError
from plannercheck.common.package_files import folders_above, package_file, where_sought

# Turns a scene's name for a file into its path.
FindFile = Callable[[str], Path]


def file_finder(folder: Path, package_dirs: Sequence[Path] = ()) -> FindFile:
    """Makes the function that finds a scene's files.

    Args:
        folder: The folder of the scene file: relative paths start there.
        package_dirs: Folders that contain packages; they are searched before the folders above the scene.
    """

    def find(address: str) -> Path:
        if not address.startswith("package://"):
            return folder / address.removeprefix("file://")
        found = package_file(address, package_dirs, folders_above(folder / "scene"))
        if found is None:
            raise PlannercheckError(f"file {address!r} is not found. {where_sought(package_dirs)}")
        return found

    return find
