"""Convex decomposition of concave links, on request: pieces that come with plannercheck, or that CoACD makes.

In: a triangle mesh and options. Out: convex pieces whose union holds every triangle of the mesh, and figures. CoACD
works in single precision, and remeshes bodies that are not closed. So a mesh sticks out of its pieces by some
micrometres or more, and its triangles cross from one piece into another; `piece_repair` makes the pieces hold it, so
that whatever touches the mesh touches a piece. Nothing is claimed about the space within the mesh. Results are cached
on disk by content, as prepared bodies are.
"""

from __future__ import annotations

import hashlib
import importlib.util
import io
import subprocess
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plannercheck.bodies.piece_repair import repaired
from plannercheck.bodies.pieces import Pieces, packed, unpacked
from plannercheck.bodies.protrusion import filled
from plannercheck.bodies.shipped_pieces import shipped_pieces
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.common.array_types import Floats
from plannercheck.common.cache import cache_folder, read_cached, write_to_cache
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.isolated_process import run_isolated
from plannercheck.common.public_names import set_module

# The version of cached results; raised when the repair changes.
_VERSION = 2
# CoACD's own resolution of the meshes that it makes.
_USUAL_RESOLUTION = 50


@set_module("plannercheck")
@dataclass(frozen=True)
class Decomposition:
    """Which links to decompose, and how.

    Attributes:
        links: Names of links; None for all whose hulls are more than 5 % larger than their meshes, or whose meshes are
            open.
        threshold: CoACD's measure of concavity that a piece may have, 0.01 to 1; small ones make many pieces.
        most_pieces: The most pieces of one mesh; None for any number.
        slack: How far a triangle may stick out of a piece and still be added to it, m. Pieces grow by about this much.
        seed: CoACD's seed.
        time_limit: How long CoACD may take for one mesh, s; one that takes longer keeps its hull.
    """

    links: tuple[str, ...] | None = None
    threshold: float = 0.05
    most_pieces: int | None = None
    slack: float = 0.001
    seed: int = 0
    time_limit: float = 600.0

    def __post_init__(self) -> None:
        if not 0.01 <= self.threshold <= 1:
            raise PlannercheckError(f"threshold of a decomposition must be within 0.01 and 1, not {self.threshold!r}")
        if not 0 < self.slack < np.inf:
            raise PlannercheckError(f"slack of a decomposition must be a positive length in m, not {self.slack!r}")
        if self.most_pieces is not None and self.most_pieces < 1:
            raise PlannercheckError(f"most_pieces of a decomposition must be at least 1, not {self.most_pieces!r}")
        if not 0 < self.time_limit < np.inf:
            raise PlannercheckError(
                f"time_limit of a decomposition must be a positive time in s, not {self.time_limit!r}"
            )


def pieces_of(mesh: TriangleMesh, options: Decomposition, name: str = "mesh") -> Pieces | None:
    """Decomposes a mesh, unless its pieces are known; None, with a warning, if CoACD exceeds the options' time.

    Raises:
        PlannercheckError: If CoACD is needed but not installed, or fails.
    """
    if (known := known_pieces(mesh, options)) is not None:
        return known
    pieces = made_pieces(mesh, options, name)
    if pieces is not None and (cache := _cache_file(mesh, options)) is not None:
        write_to_cache(cache, packed(pieces))
    return pieces


def made_pieces(mesh: TriangleMesh, options: Decomposition, name: str, remesh: int | None = None) -> Pieces | None:
    """As `pieces_of`, by CoACD in any case; with `remesh` of a coarser mesh that it makes at this resolution."""
    solid = mesh if remesh or mesh.is_watertight else TriangleMesh.of(*filled(mesh).used)
    try:
        # CoACD makes another mesh of what is not watertight, which is coarser and takes long.
        found = _coacd((solid if solid.is_watertight else mesh).outward, options, name, remesh)
    except subprocess.TimeoutExpired:
        warnings.warn(
            f"{name} keeps its hull: CoACD did not split its {len(mesh.triangles)} triangles within "
            f"{options.time_limit:g} s (time_limit of the decomposition)",
            RuntimeWarning,
            stacklevel=9,
        )
        return None
    return repaired(mesh, found, options.slack)


def known_pieces(mesh: TriangleMesh, options: Decomposition) -> Pieces | None:
    """The pieces that are shipped for a mesh, or cached; None if CoACD has to make them."""
    makes_usual_pieces = options == Decomposition(links=options.links, time_limit=options.time_limit)
    if makes_usual_pieces and (pieces := shipped_pieces(mesh)) is not None:
        return pieces
    cache = _cache_file(mesh, options)
    data = None if cache is None else read_cached(cache)
    return None if data is None else unpacked(data)


def _coacd(mesh: TriangleMesh, options: Decomposition, name: str, remesh: int | None) -> list[Floats]:
    """CoACD's pieces, from a process of its own, see coacd_worker.py."""
    if importlib.util.find_spec("coacd") is None:
        raise PlannercheckError(
            f"{name}: no pieces of this mesh come with plannercheck, or none for these options, and to make them needs "
            "CoACD: pip install 'plannercheck[coacd]'"
        )
    given = io.BytesIO()
    np.savez(
        given,
        points=mesh.points,
        triangles=mesh.triangles,
        threshold=options.threshold,
        most_pieces=options.most_pieces or -1,
        seed=options.seed,
        preprocess="on" if remesh else "off" if mesh.is_watertight else "auto",
        preprocess_resolution=remesh or _USUAL_RESOLUTION,
    )
    ran = run_isolated("plannercheck.bodies.coacd_worker", content=given.getvalue(), time_limit=options.time_limit)
    if ran.returncode:
        last = " ".join(ran.stderr.decode(errors="replace").split())[-300:]
        raise PlannercheckError(f"{name}: CoACD fails ({ran.returncode}): {last}")
    with np.load(io.BytesIO(ran.stdout)) as found:
        return [np.asarray(found[key], dtype=np.float64) for key in found.files]


def _cache_file(mesh: TriangleMesh, options: Decomposition) -> Path | None:
    folder = cache_folder()
    if folder is None:
        return None
    how = f"pieces {_VERSION} {options.threshold!r} {options.most_pieces} {options.slack!r} {options.seed}"
    key = hashlib.sha256(how.encode() + mesh.points.tobytes() + mesh.triangles.tobytes())
    return folder / f"{key.hexdigest()}.pieces"
