"""The polar transformation (paper, section "The polar transformation"), in any dimension.

In: points, hyperplanes and polytopes in doubles. Out: their polars: ρ of points and hyperplanes, ρ₀ and ρ∞ of
polytopes, shell simplices. A hyperplane {y : z·y = 1} misses the origin and is written as its z, which is also its
polar point; so points and hyperplanes are the same arrays, read in two ways, and ρ is the identity on them.

The idea of the paper in one line: points and hyperplanes are swapped, x ∈ h₀ exactly if ρ(h) ∈ ρ₀(x). So a polytope
grows exactly if its polar shrinks, and "P and ρ₀(Q) share a point" means "a hyperplane separates ρ∞(P) from Q".

Where the text needs care: ρ₀(ρ₀(P)) = P wants the origin strictly inside P (counterexample on the boundary:
[-1, 1] × [0, 1], whose ρ₀ is unbounded), and ρ₀ through vertices is false for unbounded P. `Halfspaces` can hold
unbounded polars; `vertices_of` takes bounded ones only. Everything here is in doubles: it shows and tests the theory
and guides the algorithms of `plannercheck.ndim`, whose verdicts are then proved apart from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.arrays import distinct_rows
from plannercheck.common.errors import PlannercheckError
from plannercheck.ndim.qhull import convex_hull, halfspace_vertices

Side: TypeAlias = Literal["zero", "infinity"]

# Simplices that qhull cuts off a facet of the polar with no volume, up to rounding of unit normals.
_NO_VOLUME = 1e-12


@dataclass(frozen=True)
class Halfspaces:
    """The set of all x with normals · x ≤ 1 (side "zero": it holds the origin) or ≥ 1 (side "infinity").

    Attributes:
        normals: (m, d); none at all (0, d) is the whole space.
        side: Which side of each hyperplane.
    """

    normals: Floats
    side: Side

    def violation(self, points: ArrayLike) -> Floats:
        """How far points (n, d), or one (d,), are beyond the worst hyperplane, in its own scale: 0 or less inside."""
        products = _floats(points) @ self.normals.T
        over = products - 1.0 if self.side == "zero" else 1.0 - products
        return np.asarray(over.max(axis=-1, initial=-np.inf))

    def holds(self, points: ArrayLike, slack: float = 0.0) -> NDArray[np.bool_]:
        """Whether points are inside, up to a slack."""
        return np.asarray(self.violation(points) <= slack)


def polar_of_point(point: ArrayLike) -> Floats:
    """ρ(x): the hyperplane {y : x·y = 1}, written as its normal.

    Args:
        point: (d,), not the origin, or several (n, d).

    Returns:
        The hyperplane's z.
    """
    array = _floats(point)
    if not (np.abs(array).max(axis=-1) > 0).all():
        raise PlannercheckError("the origin has no polar hyperplane: give a point other than the origin")
    return array.copy()


def polar_of_hyperplane(normal: ArrayLike, offset: float = 1.0) -> Floats:
    """ρ(h): the point z with h = {y : z·y = 1}.

    Args:
        normal: (d,) of any length but 0.
        offset: The hyperplane is normal · y = offset; it must not hold the origin.

    Returns:
        z (d,).
    """
    if offset == 0:
        raise PlannercheckError("a hyperplane through the origin has no polar: move the origin off it")
    return np.asarray(polar_of_point(normal) / offset)


def rho_zero(vertices: ArrayLike) -> Halfspaces:
    """ρ₀(P) for V(P) (n, d): all y with y·p ≤ 1 for all p in P; bounded exactly if the origin is strictly inside P."""
    return Halfspaces(_floats(vertices), "zero")


def rho_infinity(vertices: ArrayLike) -> Halfspaces:
    """ρ∞(P) for V(P) (n, d): all y with y·p ≥ 1 for all p in P; empty exactly if the origin is in P, else unbounded."""
    return Halfspaces(_floats(vertices), "infinity")


def vertices_of(halfspaces: Halfspaces) -> Floats:
    """The vertices (k, d) of a bounded ρ₀: with `rho_zero`, the polar of the polar."""
    if halfspaces.side != "zero":
        raise PlannercheckError("ρ∞ is unbounded or empty, its vertices do not span it: only ρ₀ is taken")
    rows = halfspaces.normals
    return halfspace_vertices(rows, np.ones(len(rows)), np.zeros(rows.shape[1]))


def facet_polars(vertices: ArrayLike) -> Floats:
    """V(ρ₀(P)) (m, d) of points (n, d) that span P, with the origin strictly inside: the polars of its facets.

    Facets that are the same up to rounding are merged.
    """
    hull = convex_hull(_floats(vertices))
    if not (hull.offsets > 0).all():
        raise PlannercheckError("the origin is not strictly inside the polytope: its ρ₀ is unbounded")
    return distinct_rows(np.round(hull.normals / hull.offsets[:, None], 12))[0]


@dataclass(frozen=True)
class ShellSimplices:
    """A set Σ(P) of shell simplices (paper, Lemma "Simplex lemma"): each a few halfspaces that hold P.

    Every d of the facet polars in a row of `simplices` are a simplex of the boundary of ρ₀(P), triangulated. With the
    origin they span the triangulation of ρ₀(P) that the paper takes; their halfspaces are a cone that holds P and whose
    apex is a vertex of P. (The paper's (d + 1)st halfspace only makes the set smaller, and so its complement larger:
    it is left out.)

    Attributes:
        normals: Facet polars (m, d): each halfspace is normals[j] · x ≤ 1.
        simplices: (s, d) indices into normals.
    """

    normals: Floats
    simplices: Ints

    def tangent(self, normal: ArrayLike) -> int:
        """The row of the shell simplex to which a hyperplane tangent to P, of outward normal (d,), is tangent, too.

        The normals of that row of `simplices` span a cone that holds the normal.
        """
        corners = self.normals[self.simplices].transpose(0, 2, 1)
        shares = np.linalg.inv(corners) @ _floats(normal)
        return int(np.argmax(shares.min(axis=1)))


def shell_simplices(vertices: ArrayLike) -> ShellSimplices:
    """Σ(P) of points (n, d) that span P, with the origin strictly inside: at most O(n^⌊d/2⌋) shell simplices."""
    polars = facet_polars(vertices)
    simplices = convex_hull(polars).simplices
    lengths = np.linalg.norm(polars, axis=1)
    volumes = np.abs(np.linalg.det((polars / lengths[:, None])[simplices]))
    return ShellSimplices(polars, simplices[volumes > _NO_VOLUME])


def _floats(values: ArrayLike) -> Floats:
    return np.asarray(values, dtype=np.float64)
