"""Finds the files that scenes name.

In: a scene's name for a mesh or another file: a path, or a file: or package:// address. Out: the path of the file, and
the geometry of its meshes. Packages are found as for URDFs (common/package_files.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

from plannercheck.bodies.mesh_files import MeshUnits
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.package_data import is_file
from plannercheck.common.package_files import (
    PACKAGE_SCHEMES,
    address_hint,
    file_paths,
    folders_above,
    package_file,
    where_sought,
)

# What the meshes of a scene are taken as. Caps close open meshes of "solid"; open ones of "triangles" stay open.
MeshKind: TypeAlias = Literal["hull", "solid", "triangles"]


@dataclass(frozen=True)
class FindFile:
    """Turns a scene's names for files into their paths.

    Attributes:
        folder: The folder of the scene file: relative paths start there.
        package_dirs: Folders that contain packages; they are searched before the folders above the scene.
        meshes: What the scene's meshes are taken as.
        mesh_units: How mesh files are read that do not say so themselves; None for the format's default.
    """

    folder: Path
    package_dirs: Sequence[Path] = ()
    meshes: MeshKind = "hull"
    mesh_units: MeshUnits | None = None

    def __call__(self, address: str) -> Path:
        """The path of a file by its address."""
        if address.startswith(PACKAGE_SCHEMES):
            found = package_file(address, self.package_dirs, folders_above(self.folder / "scene"))
            if found is None:
                where = where_sought(self.package_dirs)
                raise PlannercheckError(f"file {address!r} is not found{address_hint(address)}. {where}")
            return found
        paths = [self.folder / path for path in file_paths(address)]
        there = next((path for path in paths if is_file(path)), None)
        if there is None and (hint := address_hint(address)):
            raise PlannercheckError(f"file {address!r} is not found{hint}")
        return there or paths[0]
