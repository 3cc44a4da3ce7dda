"""The core's convex bodies: made from checked points, or read from the disk cache.

In: vertices in m, with or without faces. Out: bodies of the core (cpp/bodies/hull, hierarchy and body).
"""

from __future__ import annotations

import contextlib
import itertools
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.polytope_files import GivenFaces, cache_file
from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.arrays import contiguous, unmasked
from plannercheck.common.cache import read_cached, write_to_cache
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError

# Largest coordinate in m: beyond it products of three coordinates could overflow in the filters.
LARGEST_COORDINATE = 1e50


def core_polytope(
    vertices: ArrayLike,
    faces: GivenFaces | None = None,
    inflation_radius: float = 0.0,
    name: str = "polytope",
    cached: bool = False,
) -> Any:
    """The core's body of points (n, 3), m, and faces as for `Polytope`; `cached`: through the disk cache."""
    points = _checked_points(vertices, name)
    file = cache_file(points, faces, inflation_radius) if cached else None
    if file is not None and (data := read_cached(file)) is not None:
        with contextlib.suppress(PlannercheckError):  # a damaged file is prepared anew
            found = parsed_polytope(data)
            if _is_of(found, points, inflation_radius):
                return found
    body = _made(points, faces, inflation_radius, name)
    if file is not None:
        write_to_cache(file, body.serialise())
    return body


def parsed_polytope(data: bytes) -> Any:
    """The core's body of its serialised data."""
    try:
        return core.Polytope.parse(data)
    except core.HullError as error:
        raise PlannercheckError(f"not a prepared body: {error}") from error


def _made(points: Floats, faces: GivenFaces | None, inflation_radius: float, name: str) -> Any:
    radius = _checked_inflation_radius(inflation_radius, name)
    try:
        if faces is None:
            return core.Polytope.from_points(points, radius)
        return core.Polytope.from_faces(points, fans(faces, len(points), name), radius)
    except core.HullError as error:
        raise PlannercheckError(f"{name} ({len(points)} points) has no hull to work with: {error}") from error


def _is_of(body: Any, points: Floats, inflation_radius: float) -> bool:
    """Whether a body has this inflation radius, and its vertices are some of these points."""
    source = body.source()
    known = not len(source) or bool(source.min() >= 0 and source.max() < len(points))
    return known and body.inflation_radius == inflation_radius and body.vertices().tobytes() == points[source].tobytes()


def _checked_points(vertices: ArrayLike, name: str) -> Floats:
    try:
        points = contiguous(vertices)
    except (TypeError, ValueError, OverflowError) as error:
        raise PlannercheckError(f"{name}: vertices must be an array of numbers of shape (n, 3): {error}") from error
    if points.ndim != 2 or points.shape[1] != 3:
        raise PlannercheckError(f"{name}: vertices must have shape (n, 3), not {points.shape}")
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise PlannercheckError(f"{name}: vertex {bad[0]} is {points[bad[0]].tolist()}, it must be finite")
    if len(points) == 0:
        raise PlannercheckError(f"{name} has no points, a body needs at least one")
    if not np.abs(points).max() <= LARGEST_COORDINATE:
        raise PlannercheckError(f"{name}: coordinates must be at most {LARGEST_COORDINATE:g} m in size")
    return points


def _checked_inflation_radius(inflation_radius: float, name: str) -> float:
    if not 0 <= inflation_radius <= LARGEST_COORDINATE:
        raise PlannercheckError(
            f"{name}: inflation radius must be a length in m of at least 0, not {inflation_radius!r}"
        )
    return float(inflation_radius)


def fans(faces: GivenFaces, points: int, name: str) -> Ints:
    """Cuts polygons into fans of triangles (m, 3)."""
    triangles: list[tuple[int, int, int]] = []
    unmasked(faces)
    for number, face in enumerate(faces):
        corners = [int(c) for c in np.asarray(face).ravel()]
        if len(corners) < 3 or len(set(corners)) != len(corners):
            raise PlannercheckError(f"{name}: face {number} is {corners}, it needs at least 3 different corners")
        if min(corners) < 0 or max(corners) >= points:
            raise PlannercheckError(f"{name}: face {number} names a vertex beyond 0 … {points - 1}: {corners}")
        triangles += [(corners[0], b, c) for b, c in itertools.pairwise(corners[1:])]
    return np.array(triangles, dtype=np.int32).reshape(-1, 3)
