"""Convex pieces that come with plannercheck, so that robots need no CoACD for them.

In: a mesh. Out: its pieces, if the folder `robots/pieces` has them. Files are found by the mesh's content: their names
end in the start of its hash, and they hold all of it. `robots/pieces/README.md` says where the meshes are from, under
which licences, and `robots/pieces/make_pieces.py` makes the files.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from plannercheck.bodies.pieces import Pieces, mesh_hash, unpacked
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.common.package_data import shipped_folder

_HASH_LETTERS = 16


def shipped_pieces(mesh: TriangleMesh) -> Pieces | None:
    """The pieces of a mesh that the default options of a `Decomposition` stand for; None if none are shipped."""
    key = mesh_hash(mesh)
    file = _files().get(key.hex()[:_HASH_LETTERS])
    return None if file is None else unpacked(file.read_bytes(), key)


def file_name(robot: str, body: str, key: bytes) -> str:
    """The name of the file of pieces of a mesh with this hash."""
    return f"{robot}_{body}_{key.hex()[:_HASH_LETTERS]}.npz"


def piece_files() -> list[Path]:
    """All files of pieces, sorted."""
    return sorted((shipped_folder("robots") / "pieces").glob("*.npz"))


@cache
def _files() -> dict[str, Path]:
    return {file.stem.rpartition("_")[2]: file for file in piece_files()}
