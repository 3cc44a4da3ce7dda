"""Qhull through SciPy: convex hulls and halfspace intersections in any dimension, in doubles.

In: points (n, d), or halfspaces with a point strictly inside. Out: facets as simplices with outward unit normals, or
vertices. Results are rounded and only guide; verdicts are proved from the given numbers.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.arrays import OwnsArrays, distinct, grouped
from plannercheck.common.errors import PlannercheckError


class FlatError(PlannercheckError):
    """Points that span no volume, up to rounding, so that qhull finds no hull."""


@dataclass(frozen=True)
class Hull(OwnsArrays):
    """A hull's boundary, triangulated.

    Attributes:
        simplices: (m, d) indices into the points.
        normals: Outward unit normals (m, d).
        offsets: (m,): the facet's plane is normals · x = offsets.
        vertices: Indices of the extreme points, sorted.
    """

    simplices: Ints
    normals: Floats
    offsets: Floats
    vertices: Ints


def part_of_scipy(name: str) -> Any:
    """A part of SciPy, or an error that says how to get it."""
    try:
        return importlib.import_module(f"scipy.{name}")
    except ImportError as error:
        raise PlannercheckError("pc.ndim needs SciPy: pip install 'plannercheck[ndim]'") from error


def convex_hull(points: Floats) -> Hull:
    """The triangulated boundary of the hull of points (n, d), d at least 2; FlatError if they span no volume."""
    if len(points) <= points.shape[1]:
        raise FlatError(f"{len(points)} points span no volume in dimension {points.shape[1]}")
    if points.shape[1] == 1:
        return _interval(points[:, 0])
    library = part_of_scipy("spatial")
    try:
        hull = library.ConvexHull(points)
    except library.QhullError as error:
        raise FlatError(f"qhull finds no hull: {str(error).splitlines()[0]}") from error
    equations = np.asarray(hull.equations, dtype=np.float64)
    simplices = np.asarray(hull.simplices, dtype=np.int32)
    return Hull(simplices, equations[:, :-1].copy(), -equations[:, -1], distinct(simplices))


def _interval(values: Floats) -> Hull:
    low, high = int(values.argmin()), int(values.argmax())
    if values[low] == values[high]:
        raise FlatError("the points are all the same")
    ends = np.array([[low], [high]], dtype=np.int32)
    return Hull(ends, np.array([[-1.0], [1.0]]), np.array([-values[low], values[high]]), distinct(ends))


def halfspace_vertices(normals: Floats, offsets: Floats, inside: Floats) -> Floats:
    """The vertices (k, d), rounded, of a bounded intersection of halfspaces normals (m, d) · x ≤ offsets (m,).

    `inside` (d,) is strictly inside. Raises FlatError if qhull finds none.
    """
    polars = normals / (offsets - normals @ inside)[:, None]
    hull = convex_hull(polars)
    if not (hull.offsets > 0).all():
        raise PlannercheckError("the halfspaces bound no polytope: their intersection is unbounded")
    found = hull.normals / hull.offsets[:, None]
    scale = np.abs(found).max()
    first = grouped(np.round(found / scale, 12)).first
    return np.asarray(found[np.sort(first)] + inside)
