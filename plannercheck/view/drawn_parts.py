"""Bodies of very many parts in pictures: the balls of a cloud, the cells of a map.

In: balls or cells. Out: `DrawnParts`: places as whole numbers of 16 bits, in steps from a corner, so that a million
balls take 8 MB. In larger sets, balls are left out evenly and cells are drawn coarser; verdicts are about all of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.lattice_cells import LatticeCells
from plannercheck.bodies.point_clouds import PointCloud
from plannercheck.bodies.shapes import Shape
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.arrays import grouped
from plannercheck.view.cell_faces import outside

Short: TypeAlias = NDArray[np.uint16]
Kind: TypeAlias = Literal["balls", "cells"]

# Balls and cells that are drawn at most: more make pages above 20 MB.
MOST_DRAWN = 1_500_000
# Colours leave out this part of the parts at either end: outliers would take most of them.
_TAIL = 0.01
# The largest number of 16 bits.
_LARGEST = 2**16 - 1


@dataclass(frozen=True, eq=False, repr=False)
class DrawnParts:
    """A body of many parts, drawn.

    Attributes:
        name: Name of the body.
        owner: The link or obstacle that it belongs to.
        kind: What the parts are.
        groups: Of balls, one array (n, 4) of centres and radii; of cells, one of rectangles (n, 5) for each of the six
            directions, as of `outside`; in steps.
        corner: (3,) where the places begin, in the body's frame, m.
        step: m.
        count: How many parts the body has.
        drawn: How many of them are drawn.
        poses: (frames, 4, 4) in the world, or (1, 4, 4) if it does not move.
        colliding: (frames,) whether it collides with anything.
    """

    name: str
    owner: str
    kind: Kind
    groups: tuple[Short, ...]
    corner: Floats
    step: float
    count: int
    drawn: int
    poses: Floats
    colliding: Bools

    def pose(self, frame: int) -> Floats:
        """(4, 4) at a frame."""
        pose: Floats = self.poses[frame if len(self.poses) > 1 else 0]
        return pose

    @property
    def layer(self) -> Literal["sensed"]:
        """Its layer in the picture."""
        return "sensed"

    def ranges(self, centre: Floats) -> Floats:
        """(2, 2) m: what colours go from and to, by the height and by the distance from a point (3,), at frame 0."""
        corners = np.concatenate([group[:, :3].astype(np.float64) for group in self.groups])
        pose = self.pose(0)
        places = (self.corner + self.step * corners) @ pose[:3, :3].T + pose[:3, 3]
        away = np.linalg.norm(places - centre, axis=1)
        found = np.array([np.quantile(by, [_TAIL, 1 - _TAIL]) for by in (places[:, 2], away)])
        found[:, 1] = np.maximum(found[:, 1], found[:, 0] + self.step)
        return found

    @property
    def title(self) -> str:
        """Its name in a page, and what is not drawn."""
        shown = self.owner if self.owner == self.name else f"{self.owner} ({self.name})"
        return shown if self.drawn == self.count else f"{shown}: {self.drawn:,} of {self.count:,} {self.kind} drawn"

    def __repr__(self) -> str:
        return f"DrawnParts({self.title!r}, {self.drawn} {self.kind})"


def has_many_parts(shape: Shape) -> bool:
    """Whether a shape is drawn part by part: a cloud or a map; a height field is a surface like others."""
    return isinstance(shape, PointCloud | LatticeCells)


def parts_of(shape: Shape, where: dict[str, Any]) -> DrawnParts | None:
    """A cloud or a map as it is drawn; None if it is empty. `where` is the rest of `DrawnParts`."""
    if isinstance(shape, PointCloud) and shape.count:
        return drawn_balls(shape.points, shape.radius, **where)
    if isinstance(shape, LatticeCells) and shape.count:
        return drawn_cells(*shape.cells, shape.resolution, np.asarray(shape.origin), **where)
    return None


def drawn_balls(points: Floats, radii: Floats, **where: Any) -> DrawnParts:
    """A cloud of points (n, 3), m, n > 0, of radii (n,) or (1,), m, as it is drawn; `where` as for `parts_of`."""
    rows = np.linspace(0, len(points) - 1, min(len(points), MOST_DRAWN)).astype(np.int64)
    shown, radius = points[rows], np.broadcast_to(radii, len(points))[rows]
    corner = shown.min(axis=0)
    step = max(float(np.max(shown.max(axis=0) - corner)), float(radius.max())) / _LARGEST or 1.0
    places = np.round(np.column_stack([shown - corner, radius]) / step)
    places[:, 3] = np.maximum(places[:, 3], 1)
    return DrawnParts(
        kind="balls",
        groups=(places.astype(np.uint16),),
        corner=corner,
        step=step,
        count=len(points),
        drawn=len(rows),
        **where,
    )


def drawn_cells(keys: NDArray[Any], sizes: NDArray[Any], resolution: float, origin: Floats, **where: Any) -> DrawnParts:
    """A map of n > 0 cells as it is drawn; `where` as for `parts_of`.

    Low corners (n, 3) and edges (n,), powers of two, are in steps of the resolution, m, from the origin (3,), m, on.
    """
    largest = int(sizes.max())
    low = keys.min(axis=0).astype(np.int64) // largest * largest  # so that octree cells stay in their lattices
    places, edges = keys - low, sizes.astype(np.int64)
    step, count = resolution, len(keys)
    while np.max(places + edges[:, None]) > _LARGEST or int((edges * edges).sum()) > 8 * MOST_DRAWN:
        places, edges = _coarser(places, edges)
        step *= 2
    drawn = count if step == resolution else len(places)
    groups = tuple(rows.astype(np.uint16) for rows in outside(places, edges))
    return DrawnParts(
        kind="cells",
        groups=groups,
        corner=np.asarray(origin) + low * resolution,
        step=step,
        count=count,
        drawn=drawn,
        **where,
    )


def _coarser(places: NDArray[np.int64], edges: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Cells of twice the step that hold all cells; none overlap."""
    halves = np.maximum(edges // 2, 1)
    cells = np.column_stack([places // 2, halves])
    index = grouped(cells).first
    rows = cells[index]
    return rows[:, :3], halves[index]
