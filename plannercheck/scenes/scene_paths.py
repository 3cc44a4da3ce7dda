"""Finds the files that scenes name.

In: a scene's name for a mesh or another file: a path, or a file:// or package:// address. Out: the path of the file,
and what its meshes are taken as. Packages are found as for URDFs (common/package_files.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

from plannercheck.bodies.mesh_files import MeshUnits
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.package_files import folders_above, package_file, where_sought

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
        if not address.startswith("package://"):
            return self.folder / address.removeprefix("file://")
        found = package_file(address, self.package_dirs, folders_above(self.folder / "scene"))
        if found is None:
            raise PlannercheckError(f"file {address!r} is not found. {where_sought(self.package_dirs)}")
        return found
