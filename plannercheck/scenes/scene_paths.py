"""Where the files are that scenes name.

In: what a scene calls a mesh, or another file: a path, or a file:// or package:// address. Out: the path of the file.
Packages are looked for as URDFs have it: in given folders that contain packages, then in all folders above the scene.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from plannercheck.common.errors import PlannercheckError
from plannercheck.common.package_data import is_file

# Turns what a scene calls a file into its path.
FindFile = Callable[[str], Path]

_PACKAGE = "package://"


def file_finder(folder: Path, package_dirs: Sequence[Path] = ()) -> FindFile:
    """Makes the function that finds a scene's files.

    Args:
        folder: Of the scene file: relative paths start there.
        package_dirs: Folders that contain packages; they come before the folders above the scene.
    """

    def find(resource: str) -> Path:
        if not resource.startswith(_PACKAGE):
            return folder / resource.removeprefix("file://")
        relative = resource.removeprefix(_PACKAGE)
        for place in (*package_dirs, *_folders_above(folder)):
            if is_file(place / relative):
                return place / relative
        looked = ", ".join(str(place) for place in package_dirs) or "none were given"
        raise PlannercheckError(
            f"file {resource!r} is in none of the package_dirs ({looked}), nor in a folder above the scene: "
            f"{_PACKAGE}NAME/... needs the folder that contains NAME"
        )

    return find


def _folders_above(folder: Path) -> tuple[Path, ...]:
    """The folder and what is above it, by its name as given, then as its links lead."""
    here = (folder.absolute(), folder.resolve())
    return tuple(dict.fromkeys(place for each in here for place in (each, *each.parents)))
