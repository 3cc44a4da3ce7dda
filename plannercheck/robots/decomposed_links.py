"""Robots whose concave links are made of convex pieces.

In: a robot's bodies, their pairs, the meshes they come from, options. Out: bodies and pairs in which each chosen mesh
is replaced by its pieces (bodies named "body/piece 0" and so on), and each of its pairs by the pairs of all pieces.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.convex_decomposition import Decomposition, pieces_of
from plannercheck.bodies.mesh_files import MeshFile
from plannercheck.bodies.pieces import Pieces, hull_volume
from plannercheck.bodies.shapes import GeometryObject, Hull
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.common.errors import unknown_name

Pairs = NDArray[np.int64]

# A mesh whose hull is larger by less than this part is not decomposed, unless its link is named.
LEAST_EXCESS = 0.05


def decomposed(
    bodies: tuple[GeometryObject, ...],
    pairs: Pairs,
    meshes: Sequence[MeshFile | None],
    options: Decomposition | None,
    kinds: Mapping[str, str] = MappingProxyType({}),
) -> tuple[tuple[GeometryObject, ...], Pairs, Mapping[str, Pieces]]:
    """Replaces bodies by their pieces.

    Args:
        bodies: The robot's bodies; meshes are hulls.
        pairs: (k, 2) indices of bodies.
        meshes: The mesh of each body; None for other shapes.
        options: Which links to decompose, and how; None for none but those of kind "pieces".
        kinds: The geometry of links by name, which decides for these: "pieces", or anything else for none.

    Returns:
        Bodies, pairs of them, and the pieces by name of the body that they replace.
    """
    known = {str(body.link) for body in bodies}
    for link in (options.links if options is not None else None) or ():
        if link not in known:
            raise unknown_name("link to decompose", link, sorted(known))
    found: dict[str, Pieces] = {}
    parts: list[list[GeometryObject]] = []
    for body, each in zip(bodies, meshes, strict=True):
        mesh = _chosen_mesh(body, each, options, kinds.get(str(body.link)))
        pieces = None if mesh is None else pieces_of(mesh, options or Decomposition(), f"body {body.name!r}")
        parts.append([body] if pieces is None or len(pieces.points) < 2 else _bodies(body, pieces))
        if pieces is not None and len(pieces.points) > 1:
            found[body.name] = pieces
    first = np.cumsum([0, *(len(each) for each in parts)])
    new = [(i, j) for a, b in pairs.tolist() for i in range(*first[a : a + 2]) for j in range(*first[b : b + 2])]
    return tuple(b for each in parts for b in each), np.array(new, dtype=np.int64).reshape(-1, 2), found


def _chosen_mesh(
    body: GeometryObject, given: MeshFile | None, options: Decomposition | None, kind: str | None
) -> TriangleMesh | None:
    """A body's mesh, if it is to be decomposed."""
    is_named = kind == "pieces" or (kind is None and body.link in ((options and options.links) or ()))
    is_asked = is_named or (kind is None and options is not None and options.links is None)
    if given is None or not is_asked or not isinstance(body.shape, Hull):  # a solid stays one
        return None
    mesh = TriangleMesh.of(given.points, given.triangles)
    return mesh if is_named or is_concave(mesh) else None


def is_concave(mesh: TriangleMesh) -> bool:
    """Whether a mesh is decomposed without its link being named: it is concave, or may be, since it is open."""
    return mesh.volume is None or hull_volume(mesh.points) > (1 + LEAST_EXCESS) * mesh.volume


def _bodies(body: GeometryObject, pieces: Pieces) -> list[GeometryObject]:
    return [
        GeometryObject(f"{body.name}/piece {k}", body.link, body.pose, Hull(p)) for k, p in enumerate(pieces.points)
    ]
