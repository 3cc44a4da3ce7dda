"""Which geometry the meshes of links have: their hulls, convex pieces, or the solids that they are.

In: a robot's bodies with the hulls of their meshes, their pairs, the meshes, and what is asked for. Out: bodies and
pairs with that geometry. Meshes that are not closed keep their hulls unless their link is named, since a body inside
such a mesh would not collide.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal, TypeAlias, get_args

from plannercheck.bodies.convex_decomposition import Decomposition
from plannercheck.bodies.mesh_files import MeshFile
from plannercheck.bodies.pieces import Pieces
from plannercheck.bodies.shapes import GeometryObject
from plannercheck.bodies.solids import OPEN_WORDS, Solid
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.robots.decomposed_links import Pairs, decomposed

GeometryKind: TypeAlias = Literal["hull", "pieces", "solid"]
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
        Bodies, pairs of them, the pieces by name of the body that they replace, and the links that keep their hulls
        although solids are asked for, since their meshes are not closed.
    """
    kinds = dict(geometry) if isinstance(geometry, Mapping) else {}
    known = {str(body.link) for body in bodies}
    for link in kinds:
        if link not in known:
            raise unknown_name("link with a geometry", link, sorted(known))
    wanted = geometry if isinstance(geometry, str) else None
    kept: tuple[str, ...] = ()
    if wanted == "solid" or "solid" in kinds.values():
        bodies, kept = _with_solids(bodies, meshes, kinds, wanted == "solid")
    options = decomposition if wanted in (None, "pieces") else None
    if options is None and wanted == "pieces":
        options = Decomposition()
    if options is None and "pieces" not in kinds.values():
        return bodies, pairs, {}, kept
    return *decomposed(bodies, pairs, meshes, options, kinds), kept


def _with_solids(
    bodies: tuple[GeometryObject, ...],
    meshes: Sequence[MeshFile | None],
    kinds: Mapping[str, GeometryKind],
    all_links: bool,
) -> tuple[tuple[GeometryObject, ...], tuple[str, ...]]:
    """The bodies, those of chosen links as solids, of which equal meshes share one; the links that keep their hulls."""
    found, kept, known = [], [], dict[bytes, Solid]()
    for body, mesh in zip(bodies, meshes, strict=True):
        named = kinds.get(str(body.link))
        if mesh is None or not (named == "solid" or all_links):
            found.append(body)
            continue
        solid = Solid(mesh.points, mesh.triangles)
        solid = known.setdefault(solid.digest, solid)
        if not solid.is_closed and named is None:
            kept.append(str(body.link))
            found.append(body)
            continue
        if not solid.is_closed:
            warnings.warn(f"link {body.link!r}: its mesh {mesh.path} {OPEN_WORDS}", RuntimeWarning, stacklevel=7)
        found.append(replace(body, shape=solid))
    links = tuple(dict.fromkeys(kept))
    if links:
        warnings.warn(
            f"meshes of {', '.join(links)} are not closed, so they keep their hulls: name a link, "
            f"geometry={{{links[0]!r}: 'solid'}} or --geometry {links[0]}=solid, to take the triangles alone",
            RuntimeWarning,
            stacklevel=7,
        )
    return tuple(found), links
