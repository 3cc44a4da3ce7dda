"""Random sets of parts: clouds of balls, cells of lattices, heights over a base.

In: a family's name, about how many parts, a size in m. Out: a `Body`.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Floats
from plannercheck.evaluation.stress_parts.bodies import Body
from plannercheck.evaluation.stress_parts.given import CORNERS, Balls, Cells, Columns

# Inflation radii of whole sets over their size, as padding gives them, and how often.
_PADDINGS, _PADDED = (2.0**-6, 1e-3, 1e-7), 0.15
# Radii of balls over the distance of neighbours.
_RADII = (1.0, 0.5, 0.25, 0.1, 1e-2, 1e-5)
# Own origins of sets over their size: their frames need not be near them.
_ORIGINS = (0.0, 0.0, 0.0, 1.0, 100.0, 1e6)
_HOLES = 0.15  # of heights
_FULL, _MOST_SPLITS = 0.6, 5  # of octrees: the part of the nodes that are kept, and levels


def random_set(family: str, n: int, size: float, rng: np.random.Generator) -> Body:
    """A set of a family, of about n parts and a size in m."""
    return SETS[family](family, n, size, rng)


def _scattered(family: str, n: int, size: float, rng: np.random.Generator) -> Body:
    return _balls(family, rng.normal(size=(n, 3)) / 2, size, rng)


def _in_planes(family: str, n: int, size: float, rng: np.random.Generator) -> Body:
    """On a lattice in one or two planes across an axis, where coordinates and distances are equal."""
    side = int(np.ceil(np.sqrt(n)))
    points = np.array(list(itertools.product(range(side), range(side), range(2))))[: n + side] / side - 0.5
    points[:, 2] *= rng.integers(0, 2)
    return _balls(family, np.roll(points[rng.permutation(len(points))[:n]], rng.integers(3), axis=1), size, rng)


def _repeated(family: str, n: int, size: float, rng: np.random.Generator) -> Body:
    """Few places, each many times."""
    places = rng.normal(size=(max(1, n // 8), 3)) / 2
    return _balls(family, places[rng.integers(0, len(places), n)], size, rng)


def _on_a_line(family: str, n: int, size: float, rng: np.random.Generator) -> Body:
    way = rng.normal(size=3) if rng.integers(2) else np.eye(3)[rng.integers(3)]
    return _balls(family, rng.uniform(-0.5, 0.5, size=(n, 1)) * way, size, rng)


def _in_one_place(family: str, n: int, size: float, rng: np.random.Generator) -> Body:
    return _balls(family, np.tile(rng.normal(size=3), (n, 1)), size, rng)


def _surface(family: str, n: int, size: float, rng: np.random.Generator) -> Body:
    """What a camera sees: a wavy surface."""
    xy = rng.uniform(-0.5, 0.5, size=(n, 2))
    return _balls(family, np.column_stack([xy, 0.1 * np.sin(9 * xy).sum(axis=1)]), size, rng)


def _balls(family: str, unit: Floats, size: float, rng: np.random.Generator) -> Body:
    """Balls about points (n, 3), about 1 across; of one radius, or of uneven ones."""
    n = len(unit)
    points = np.ascontiguousarray(unit * size + _origin(size, rng))
    base = float(rng.choice(_RADII)) * size / n ** (1 / 2)
    radii = base * np.ones(1) if rng.integers(2) else base * 10.0 ** rng.uniform(-2, 0, size=n)
    if rng.random() < 0.1:
        radii = np.resize(radii, n)
        radii[rng.integers(n)] = size  # one that hides what the others say
    return Body(family, Balls(_padding(size, rng), points, radii))


def _grid(family: str, n: int, size: float, rng: np.random.Generator) -> Body:
    """Cells of one size, side by side."""
    side = max(1, int(np.ceil((2 * n) ** (1 / 3))))
    every = np.array(list(itertools.product(range(side), repeat=3)))
    keys = every[rng.permutation(len(every))[:n]]
    return _cells(family, keys, np.ones(len(keys)), size / side, size, rng)


def _octree(family: str, n: int, size: float, rng: np.random.Generator) -> Body:
    """Leaves of many sizes that share no inside."""
    levels = int(np.clip(np.ceil(np.log(4 * n) / np.log(8)) + rng.integers(0, 3), 1, _MOST_SPLITS))
    waiting, leaves = [(np.zeros(3, dtype=np.int64), 2**levels)], list[tuple[NDArray[Any], int]]()
    while waiting and len(waiting) + len(leaves) < n:
        low, side = waiting.pop(int(rng.integers(len(waiting))))
        if side == 1:
            leaves.append((low, side))
            continue
        waiting += [(low + c * (side // 2), side // 2) for c in CORNERS[rng.random(8) < _FULL]]
    leaves += waiting
    leaves = leaves or [(np.zeros(3, dtype=np.int64), 2**levels)]
    keys, sizes = np.array([low for low, _ in leaves]), np.array([side for _, side in leaves])
    return _cells(family, keys, sizes, size / 2**levels, size, rng)


def _single_cell(family: str, n: int, size: float, rng: np.random.Generator) -> Body:
    side = int(rng.choice([1, 2, 16, 1000]))
    return _cells(family, rng.integers(-5, 5, size=(1, 3)), np.array([side]), size / side, size, rng)


def _cells(
    family: str, keys: NDArray[Any], sizes: NDArray[Any], step: float, size: float, rng: np.random.Generator
) -> Body:
    """Cells from keys (n, 3) on, of sizes (n,), in steps; half the time of a step that is a power of two."""
    if rng.integers(2):
        step = float(2.0 ** np.round(np.log2(step)))
    keys = keys + rng.choice([0, 0, -7, 32768, -32768, 2**24]) * rng.integers(0, 2, size=3)
    origin = _origin(size, rng)
    return Body(family, Cells(_padding(size, rng), keys, sizes, step, origin))


def _terrain(family: str, n: int, size: float, rng: np.random.Generator) -> Body:
    rows, columns = _lattice_of_heights(n, rng)
    waves = 0.1 * np.sin(np.arange(rows))[:, None] + 0.1 * rng.normal(size=(rows, columns))
    return _heights(family, waves, size, rng)


def _flat_heights(family: str, n: int, size: float, rng: np.random.Generator) -> Body:
    """Level ground, which may have no thickness."""
    return _heights(family, np.full(_lattice_of_heights(n, rng), 0.25), size, rng, [0.0, 0.0, 0.1])


def _steep(family: str, n: int, size: float, rng: np.random.Generator) -> Body:
    """Steps of a height that is far above a cell's width."""
    return _heights(family, rng.choice([0.0, 0.5, 1.0], size=_lattice_of_heights(n, rng)), size, rng)


def _with_holes(family: str, n: int, size: float, rng: np.random.Generator) -> Body:
    heights = 0.2 * rng.random(_lattice_of_heights(n, rng))
    hole = rng.random(heights.shape) < _HOLES
    hole[:2, :2] = False  # one cell stays
    return _heights(family, np.where(hole, np.nan, heights), size, rng)


def _lattice_of_heights(n: int, rng: np.random.Generator) -> tuple[int, int]:
    cells = max(1, n // 2)
    rows = int(rng.integers(1, max(2, min(cells, int(2 * np.sqrt(cells)))) + 1))
    return rows + 1, max(1, round(cells / rows)) + 1


def _heights(
    family: str, unit: Floats, size: float, rng: np.random.Generator, below: list[float] | None = None
) -> Body:
    """Prisms below heights (i, j), about 1 high, down to a base."""
    heights = np.ascontiguousarray(unit * size)
    steps = size / np.array(heights.shape) * rng.uniform(0.5, 1.0, size=2)
    if rng.integers(2):
        steps = np.exp2(np.round(np.log2(steps)))
    origin, padding = _origin(size, rng)[:2].copy(), _padding(size, rng)
    base = float(np.nanmin(heights) - size * rng.choice(below or [0.0, 0.1, 1.0]))
    return Body(family, Columns(padding, heights, steps, origin, base))


def _origin(size: float, rng: np.random.Generator) -> Floats:
    return np.asarray(float(rng.choice(_ORIGINS)) * size * rng.normal(size=3))


def _padding(size: float, rng: np.random.Generator) -> float:
    return float(rng.choice(_PADDINGS)) * size if rng.random() < _PADDED else 0.0


Family = Callable[[str, int, float, np.random.Generator], Body]
CLOUDS: dict[str, Family] = {
    "cloud": _scattered,
    "cloud in planes": _in_planes,
    "cloud of repeats": _repeated,
    "cloud on a line": _on_a_line,
    "cloud in one place": _in_one_place,
    "cloud of a surface": _surface,
}
LATTICES: dict[str, Family] = {"grid": _grid, "octree": _octree, "single cell": _single_cell}
HEIGHTS: dict[str, Family] = {
    "terrain": _terrain,
    "flat heights": _flat_heights,
    "steep heights": _steep,
    "heights with holes": _with_holes,
}
SETS = CLOUDS | LATTICES | HEIGHTS
