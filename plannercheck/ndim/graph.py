"""The overlap graph of convex regions, on which planners over convex sets search.

In: regions (`Polytope`s, e.g. of free configurations, from halfspaces as IRIS gives them, or from points). Out: their
exact overlap graph. Pairs whose boxes are proved apart are not tested.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from plannercheck.common.array_types import Ints64
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module
from plannercheck.common.whole_numbers import whole_number
from plannercheck.ndim.bodies import Polytope, check_bodies
from plannercheck.ndim.pair import Method, intersects


@set_module("plannercheck.ndim")
@dataclass(frozen=True)
class OverlapGraph:
    """Which regions share a point.

    Attributes:
        edges: Pairs i < j that do (k, 2), in ascending order.
        neighbours: Neighbours of each region, in ascending order.
        tested: Pairs that were tested.
        skipped: Pairs whose boxes are apart.
    """

    edges: Ints64
    neighbours: tuple[tuple[int, ...], ...] = field(repr=False)
    tested: int
    skipped: int

    def path(self, start: int, goal: int) -> list[int] | None:
        """A shortest sequence of regions from one to another, or None if there is none.

        Args:
            start: A region's number.
            goal: A region's number.

        Returns:
            Numbers of regions, each sharing a point with the next.
        """
        wanted = f"a region must be one of {len(self.neighbours)}, from 0 on"
        for region in (start, goal):
            if whole_number(region, wanted, 0) >= len(self.neighbours):
                raise PlannercheckError(f"{wanted}, not {region}")
        came_from = {start: start}
        front = [start]
        while front and goal not in came_from:
            found = [(n, region) for region in front for n in self.neighbours[region] if n not in came_from]
            for region, source in found:
                came_from.setdefault(region, source)
            front = list(dict.fromkeys(region for region, _ in found))
        if goal not in came_from:
            return None
        way = [goal]
        while way[-1] != start:
            way.append(came_from[way[-1]])
        return way[::-1]


@set_module("plannercheck.ndim")
def overlap_graph(regions: Sequence[Polytope], method: Method = "auto") -> OverlapGraph:
    """Finds which regions of a set share a point; touching counts.

    Args:
        regions: All of the same dimension, in one frame.
        method: As for `intersects`.

    Returns:
        The graph.
    """
    check_bodies(*regions)
    dimensions = {region.dimension for region in regions}
    if len(dimensions) > 1:
        raise PlannercheckError(f"regions have dimensions {sorted(dimensions)}: one is expected")
    candidates = _box_pairs(regions)
    edges = [(i, j) for i, j in candidates if intersects(regions[i], regions[j], method=method)]
    around: list[list[int]] = [[] for _ in regions]
    for i, j in edges:
        around[i].append(j)
        around[j].append(i)
    pairs = len(regions) * (len(regions) - 1) // 2
    return OverlapGraph(
        np.array(edges, dtype=np.int64).reshape(-1, 2),
        tuple(tuple(sorted(a)) for a in around),
        len(candidates),
        pairs - len(candidates),
    )


def _box_pairs(regions: Sequence[Polytope]) -> list[tuple[int, int]]:
    """Pairs whose boxes share a point."""
    if not regions:
        return []
    low = np.array([region.box[0] for region in regions])
    high = np.array([region.box[1] for region in regions])
    pairs = []
    for i in range(len(regions)):
        meets = ((low[i + 1 :] <= high[i]) & (high[i + 1 :] >= low[i])).all(axis=1)
        pairs += [(i, int(i + 1 + j)) for j in np.flatnonzero(meets)]
    return pairs
