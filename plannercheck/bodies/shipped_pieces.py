"""Convex pieces that come with plannercheck, so that robots need no CoACD for them.

In: a mesh. Out: its pieces, if the folder `robots/pieces` has them or a recipe for them. Files are found by the mesh's
content: their names end in the start of its hash, and they hold all of it. The folder's README.md says where the meshes
are from, under which licences, and which scripts make the files.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from plannercheck.bodies.piece_recipes import pieces_by_recipe
from plannercheck.bodies.pieces import Pieces, mesh_hash, unpacked
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.common.package_data import shipped_folder

PIECES, RECIPE = ".npz", ".json"
_HASH_LETTERS = 16


def shipped_pieces(mesh: TriangleMesh) -> Pieces | None:
    """The pieces of a mesh that the default options of a `Decomposition` stand for; None if none are shipped."""
    key = mesh_hash(mesh)
    file = _files().get(key.hex()[:_HASH_LETTERS])
    if file is None:
        return None
    if file.suffix == RECIPE:
        return pieces_by_recipe(file.read_text(encoding="ascii"), mesh, key)
    return unpacked(file.read_bytes(), key)


def file_name(robot: str, body: str, key: bytes, suffix: str = PIECES) -> str:
    """The name of the file of pieces, or of their recipe, of a mesh with this hash."""
    return f"{robot}_{body}_{key.hex()[:_HASH_LETTERS]}{suffix}"


def piece_files() -> list[Path]:
    """All files of pieces and of recipes, sorted."""
    folder = shipped_folder("robots") / "pieces"
    return sorted([*folder.glob(f"*{PIECES}"), *folder.glob(f"*{RECIPE}")])


@cache
def _files() -> dict[str, Path]:
    return {file.stem.rpartition("_")[2]: file for file in piece_files()}
