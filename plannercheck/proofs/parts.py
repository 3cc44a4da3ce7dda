"""Sets of parts in proofs: heights of balls, boxes and prisms along a direction, of all at once in doubles.

In: a body with `parts`, rows (w, s) in ball arithmetic. Out: a lower bound of each part's height, from the body's
numbers, without a tree. A box has the lesser of two products in each coordinate. A prism has the lowest of three
corners, each at the lower of its place and its place on the base. These are the same products as of corners, so a sum
of them errs by at most 4 u of their sizes; comparisons do not err.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Bools, Floats, Ints64
from plannercheck.proofs.data import PosedBody
from plannercheck.proofs.rounding import ROUNDING, UNDERFLOW, UP

# How many vertices a part of a kind has.
VERTICES = {"balls": 1, "boxes": 2, "prisms": 3}

# Sums of three products: NumPy takes many times as long for `sum` along so short an axis.
_ONES = np.ones(3)


def part_count(body: PosedBody) -> int:
    """How many parts a set has."""
    return len(body.vertices) // VERTICES[body.parts]


def largest_radius(body: PosedBody) -> float:
    """How far around its vertices, at most, a body reaches by its parts' own radii, m."""
    return 0.0 if body.radii is None else float(body.radii.max(initial=0.0))


@dataclass(frozen=True, eq=False)
class Parts:
    """Parts of a set.

    Attributes:
        kind: Of `VERTICES`.
        vertices: (n, k, 3) in the set's frame, m.
        radii: (n,) m.
        base: Where prisms end, m.
        sizes: (3,) largest size of each coordinate of all.
    """

    kind: str
    vertices: Floats
    radii: Floats
    base: float
    sizes: Floats

    def __len__(self) -> int:
        return len(self.vertices)

    @property
    def box(self) -> Floats:
        """(8, 3) the corners of a box around all vertices; the origin of an empty set."""
        if not len(self):
            return np.zeros((1, 3))
        points = self.vertices.reshape(-1, 3)
        low, high = points.min(axis=0), points.max(axis=0)
        if self.kind == "prisms":
            low[2], high[2] = min(low[2], self.base), max(high[2], self.base)
        signs = np.arange(8)[:, None] >> np.arange(3) & 1
        corners: Floats = np.where(signs, high, low)
        return corners

    def taken(self, rows: slice | Bools | Ints64) -> Parts:
        """Some of the parts."""
        return replace(self, vertices=self.vertices[rows], radii=self.radii[rows])

    def least(self, w: Floats) -> Floats:
        """(n,) the least product of (3,) numbers with each part's points, radii left out."""
        if self.kind == "balls":
            return np.asarray(self.vertices[:, 0] @ w)
        products = self.vertices * w
        if self.kind == "boxes":
            return np.asarray(np.minimum(products[:, 0], products[:, 1]) @ _ONES)
        products[:, :, 2] = np.minimum(products[:, :, 2], self.base * w[2])
        first, second, third = (products[:, k] @ _ONES for k in range(3))
        return np.asarray(np.minimum(np.minimum(first, second), third))

    def lowest(self, row: Any) -> Floats:
        """(n,) at most the least value of a linear function (w, s) on each part, radii left out; NaN if not known."""
        entries = row.entries()
        middles = np.array([float(x) for x in entries])
        loose = np.array([float(x.rad()) for x in entries]) + np.abs(middles) * ROUNDING
        error = float(loose[:3] @ self.sizes + loose[3])
        heights: Floats = self.least(middles[:3]) + (middles[3] - error * UP - UNDERFLOW)
        return heights


def parts_of(body: PosedBody) -> Parts:
    """The parts of a set, in the order of its vertices."""
    vertices = body.vertices.reshape(-1, VERTICES[body.parts], 3)
    radii = np.zeros(1) if body.radii is None else body.radii
    sizes: NDArray[np.float64] = np.abs(vertices).max(axis=(0, 1), initial=0.0)
    if body.parts == "prisms":
        sizes[2] = max(sizes[2], abs(body.base))
    return Parts(body.parts, vertices, np.broadcast_to(radii, len(vertices)), body.base, sizes)
