"""Triangle meshes of which the solids of the stress are made.

In: occupied cells of a lattice, grids of points, paths. Out: a `Surface`, its triangles counter-clockwise seen from
outside, where there is an outside.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct, distinct_rows, distinct_values

Corners = NDArray[np.int32]
Cells = NDArray[np.bool_]

# The corners of a cell's upper face along the first axis, counter-clockwise seen from there.
_UPPER_FACE = np.array([[1, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]])


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles (m, 3) of points (n, 3), m."""

    points: Floats
    triangles: Corners

    @property
    def used_points(self) -> Floats:
        """Points that are corners of triangles, (k, 3), m."""
        return np.asarray(self.points[distinct(self.triangles)])

    @property
    def inverted(self) -> Surface:
        """The same, turned inside out."""
        return Surface(self.points, np.ascontiguousarray(self.triangles[:, ::-1]))

    def scaled(self, factor: float) -> Surface:
        """The same, of another size."""
        return Surface(self.points * factor, self.triangles)

    def moved(self, matrix: Floats, shift: Floats) -> Surface:
        """The same under a linear map (3, 3) and a shift (3,), m."""
        return Surface(np.asarray(self.points @ matrix.T + shift), self.triangles)


def surface(points: Floats | Sequence[Sequence[float]], triangles: object) -> Surface:
    """A surface of points (n, 3), m, and triangles (m, 3)."""
    return Surface(
        np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3),
        np.ascontiguousarray(triangles, dtype=np.int32).reshape(-1, 3),
    )


def joined(parts: Sequence[Surface]) -> Surface:
    """All triangles of several surfaces."""
    starts = np.cumsum([0, *(len(part.points) for part in parts)])
    corners = [part.triangles + start for part, start in zip(parts, starts, strict=False)]
    return surface(np.vstack([part.points for part in parts]), np.vstack(corners))


def merged(given: Surface) -> Surface:
    """The same with each point once."""
    points, index = distinct_rows(given.points)
    return surface(points, index.reshape(-1)[given.triangles])


def of_quads(points: Floats, quads: NDArray[np.integer], rng: np.random.Generator) -> Surface:
    """Two triangles for each quad (m, 4), along a random diagonal of each."""
    turned = np.where(rng.integers(0, 2, (len(quads), 1)) == 0, quads, np.roll(quads, 1, axis=1))
    return surface(points, np.vstack([turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]]))


def of_cells(cells: Cells, rng: np.random.Generator) -> Surface:
    """The border of cells (a, b, c) of a lattice of unit steps; where cells meet in an edge or corner, so does it."""
    corners = []
    for axis in range(3):
        upper = np.roll(_UPPER_FACE, axis, axis=1)
        lower = upper[::-1].copy()
        lower[:, axis] = 0
        ahead, behind = np.zeros_like(cells), np.zeros_like(cells)
        first, rest = (np.arange(cells.shape[axis])[part] for part in (slice(None, -1), slice(1, None)))
        for beyond, into, source in ((ahead, first, rest), (behind, rest, first)):
            np.moveaxis(beyond, axis, 0)[into] = np.moveaxis(cells, axis, 0)[source]
        corners += [np.argwhere(cells & ~ahead)[:, None] + upper, np.argwhere(cells & ~behind)[:, None] + lower]
    quads = np.vstack(corners)
    index = np.ravel_multi_index(tuple(quads.reshape(-1, 3).T), tuple(n + 1 for n in cells.shape)).reshape(-1, 4)
    used, place = distinct_values(index)
    points = np.stack(np.unravel_index(used, tuple(n + 1 for n in cells.shape)), axis=1)
    return of_quads(points.astype(np.float64), place.reshape(-1, 4), rng)


def of_grid(points: Floats, closes: tuple[bool, bool], rng: np.random.Generator) -> Surface:
    """A grid of points (u, v, 3) as quads; its last row or column joined to its first where it closes."""
    rows, columns = points.shape[:2]
    i, j = np.indices((rows if closes[0] else rows - 1, columns if closes[1] else columns - 1)).reshape(2, -1)
    past, beside = (i + 1) % rows, (j + 1) % columns
    quads = np.stack([i * columns + j, past * columns + j, past * columns + beside, i * columns + beside], axis=1)
    return of_quads(points.reshape(-1, 3), quads, rng)


def tube(path: Floats, section: Floats, closes: bool, rng: np.random.Generator) -> Surface:
    """A section (k, 2), counter-clockwise, swept along a path (n, 3), m; with ends where the path does not close.

    Sections stand across the path, upright to an axis that it nowhere runs along.
    """
    along = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0)
    if not closes:
        along[0], along[-1] = path[1] - path[0], path[-1] - path[-2]
    along = along / np.linalg.norm(along, axis=1)[:, None]
    aside = np.cross(along, [0.0137, 0.0071, 1.0])
    aside = aside / np.linalg.norm(aside, axis=1)[:, None]
    upwards = np.cross(along, aside)
    rings = path[:, None] + section[None, :, :1] * aside[:, None] + section[None, :, 1:] * upwards[:, None]
    side = of_grid(rings, (closes, True), rng).inverted
    if closes:
        return side
    n, k = rings.shape[:2]
    fan = np.stack([np.zeros(k - 2, dtype=np.int64), np.arange(1, k - 1), np.arange(2, k)], axis=1)
    ends = np.vstack([fan[:, ::-1], fan + (n - 1) * k])
    return surface(side.points, np.vstack([side.triangles, ends]))


def circle(corners: int, radius: float) -> Floats:
    """Corners (k, 2) of a regular polygon, counter-clockwise, m."""
    angles = 2 * np.pi * np.arange(corners) / corners
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def octahedron() -> Surface:
    """Of corners at distance 1/2 along the axes."""
    points = np.vstack([np.eye(3), -np.eye(3)]) / 2
    upper = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2]]
    return surface(points, upper + [[b, a, 5] for a, b, _ in upper])


def ball(triangles: int) -> Surface:
    """An octahedron whose triangles are split in four until there are about so many, on a sphere of 1 m across."""
    found = octahedron()
    while 4 * len(found.triangles) <= 2 * triangles:
        a, b, c = (found.points[found.triangles[:, k]] for k in range(3))
        ab, bc, ca = a + b, b + c, c + a
        corners = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, 3)
        split = merged(surface(corners, np.arange(len(corners))))
        found = Surface(split.points / np.linalg.norm(split.points, axis=1)[:, None] / 2, split.triangles)
    return found
