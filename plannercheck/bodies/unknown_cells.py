"""The unknown space of an octree, as cells: the box around its known cells without these.

In: known cells in the order of their Morton codes. Out: cells that fill the rest of the box. A descent from the root
takes a level at a time: a node without a known cell is unknown, and is divided only where the box cuts it.
"""

from __future__ import annotations

import numpy as np

from plannercheck.bodies.octomap_files import LEVELS, ROOT_LOW, morton_codes
from plannercheck.common.array_types import Ints64
from plannercheck.common.errors import PlannercheckError

# The most cells of one size that are looked at: those along the box's sides are as many as the sides are large.
_MOST_CELLS = 1 << 23


def unknown_cells(keys: Ints64, sizes: Ints64) -> tuple[Ints64, Ints64]:
    """Cells of unknown space.

    Args:
        keys: (n, 3) low corners of the known cells in steps, in the order of their Morton codes; n > 0.
        sizes: (n,) their edges in steps.

    Returns:
        Low corners (m, 3) and edges (m,) in steps: disjoint cells, that make up the rest of the box.

    Raises:
        PlannercheckError: If there are too many to be held in memory: a few stray cells far away can do that.
    """
    low, high = keys.min(axis=0), (keys + sizes[:, None]).max(axis=0)
    codes = morton_codes(keys - ROOT_LOW)
    nodes = np.full((1, 3), ROOT_LOW, dtype=np.int64)
    found_keys, found_sizes = [], []
    for level in range(LEVELS, -1, -1):
        size = 1 << level
        first = np.searchsorted(codes, morton_codes(nodes - ROOT_LOW))
        past = np.searchsorted(codes, morton_codes(nodes - ROOT_LOW) + (1 << 3 * level))
        known = np.zeros(len(nodes), dtype=np.bool_)
        known[past > first] = sizes[first[past > first]] == size
        whole = (past == first) & ((nodes >= low) & (nodes + size <= high)).all(axis=1)
        outside = ((nodes >= high) | (nodes + size <= low)).any(axis=1)
        found_keys.append(nodes[whole])
        found_sizes.append(np.full(int(whole.sum()), size, dtype=np.int64))
        divided = nodes[~(known | whole | outside)]
        if 8 * len(divided) > _MOST_CELLS:
            sides = " x ".join(str(length) for length in (high - low).tolist())
            raise PlannercheckError(
                f"unknown space in a box of {sides} steps takes too many cells: leave stray cells far away out, or use "
                'a coarser resolution, or unknown="free"'
            )
        nodes = (divided[:, None] + _CORNERS * (size // 2)).reshape(-1, 3)
    return np.concatenate(found_keys), np.concatenate(found_sizes)


_CORNERS = np.arange(8)[:, None] >> np.arange(3) & 1
