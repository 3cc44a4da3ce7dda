"""Which geometry the meshes of links have: hulls, convex pieces, or solids.

In: a robot's bodies with the hulls of their meshes, their pairs, the meshes, and what is asked for. Out: bodies and
pairs with that geometry. "solid" and "triangles" differ for open meshes: caps close these, or they are their triangles
alone, and a body inside them does not collide.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal, TypeAlias, get_args

from plannercheck.bodies.convex_decomposition import Decomposition
from plannercheck.bodies.mesh_files import MeshFile
from plannercheck.bodies.pieces import Pieces
from plannercheck.bodies.shapes import GeometryObject
from plannercheck.bodies.solids import OPEN_MESHES, Solid, open_meshes
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.user_warnings import warn
from plannercheck.robots.decomposed_links import Pairs, decomposed

GeometryKind: TypeAlias = Literal["hull", "pieces", "solid", "triangles"]
Geometry: TypeAlias = GeometryKind | Mapping[str, GeometryKind]

KINDS: tuple[GeometryKind, ...] = get_args(GeometryKind)


def checked_geometry(value: Any) -> Geometry | None:
    """What is asked for, copied; None for nothing.

    Raises:
        PlannercheckError: If it is neither a kind of geometry nor kinds by links.
    """
    if isinstance(value, Mapping):
        return {str(link): _checked_kind(kind, f"geometry of link {str(link)!r}") for link, kind in value.items()}
    return None if value is None else _checked_kind(value, "geometry")


def _checked_kind(value: Any, what: str) -> GeometryKind:
    for kind in KINDS:
        if value == kind:
            return kind
    if isinstance(value, str):
        raise unknown_name(what, value, KINDS)
    raise PlannercheckError(f"{what} must be one of {', '.join(KINDS)}, or a mapping of links to these, not {value!r}")


def with_geometry(
    bodies: tuple[GeometryObject, ...],
    pairs: Pairs,
    meshes: Sequence[MeshFile | None],
    geometry: Geometry | None,
    decomposition: Decomposition | None,
) -> tuple[tuple[GeometryObject, ...], Pairs, Mapping[str, Pieces], tuple[str, ...]]:
    """Gives links the geometry that is asked for.

    Args:
        bodies: The robot's bodies, in the order of the meshes; meshes are hulls.
        pairs: (k, 2) indices of bodies.
        meshes: The mesh of each body; None for other shapes.
        geometry: The kind of all links, or by link; other links have pieces if `decomposition` says so, else hulls.
        decomposition: Which links to decompose, and how.

    Returns:
        Bodies, pairs of them, the pieces by name of the body that they replace, and the links that are solids of open
        meshes.
    """
    kinds = dict(geometry) if isinstance(geometry, Mapping) else {}
    known = {str(body.link) for body in bodies}
    for link in kinds:
        if link not in known:
            raise unknown_name("link with a geometry", link, sorted(known))
    wanted = geometry if isinstance(geometry, str) else None
    is_open: tuple[str, ...] = ()
    if not OPEN_MESHES.keys().isdisjoint((wanted, *kinds.values())):
        bodies, is_open = _with_solids(bodies, meshes, kinds, wanted)
    options = decomposition if wanted in (None, "pieces") else None
    if options is None and wanted == "pieces":
        options = Decomposition()
    if options is None and "pieces" not in kinds.values():
        return bodies, pairs, {}, is_open
    return *decomposed(bodies, pairs, meshes, options, kinds), is_open


def _with_solids(
    bodies: tuple[GeometryObject, ...],
    meshes: Sequence[MeshFile | None],
    kinds: Mapping[str, GeometryKind],
    wanted: GeometryKind | None,
) -> tuple[tuple[GeometryObject, ...], tuple[str, ...]]:
    """The bodies, those of chosen links as solids, of which equal meshes share one; and the links of open meshes."""
    found, known, is_open = [], dict[bytes, Solid](), dict[GeometryObject, Solid]()
    for body, mesh in zip(bodies, meshes, strict=True):
        taken = OPEN_MESHES.get(str(kinds.get(str(body.link), wanted)))
        if taken is None or mesh is None:
            found.append(body)
            continue
        solid = Solid(mesh.points, mesh.triangles, taken)
        solid = known.setdefault(solid.digest, solid)
        if solid.is_open:
            is_open[body] = solid
        found.append(replace(body, shape=solid))
    if is_open:
        link = next(iter(is_open)).link
        words = open_meshes({body.name: solid for body, solid in is_open.items()})
        choices = f"geometry={{{link!r}: 'triangles'}} or 'hull', --geometry {link}=triangles"
        warn(f"{words}. To take a link otherwise, name it: {choices}")
    return tuple(found), tuple(dict.fromkeys(str(body.link) for body in is_open))
