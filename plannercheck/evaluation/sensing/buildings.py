"""A building as an octree of cells: storeys with walls, doors and furniture, as a mapping robot would have it.

In: lengths in m, a resolution, a seed. Out: `Cells`: low corners and sizes of cubes in steps of a lattice, which do not
overlap. A storey is a plan, raised: where the plan has a wall there are cells up to the ceiling, less the doors.
Furniture is hollow, as a sensor sees only its surface. Eight full cells that make a larger one become one, as OctoMap
prunes them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.arrays import grouped

Keys = NDArray[np.int32]

# Metres: of a storey from floor to floor, of its slab, a wall, a door's width and height, and rooms.
_STOREY, _SLAB, _WALL, _DOOR, _LINTEL, _ROOM = 3.2, 0.2, 0.1, 0.9, 2.1, 5.0
# Pieces of furniture in a room, and their least and largest edges, m.
_PIECES = 4
_EDGES = np.array([[0.4, 0.4, 0.4], [1.6, 0.9, 1.8]])
# Part of the cells of surfaces that the sensor never saw.
_UNSEEN = 0.01


class Cells(NamedTuple):
    """Cubes on a lattice.

    Attributes:
        keys: (n, 3) low corners in steps of the lattice.
        sizes: (n,) edges in steps, powers of two.
        resolution: The step, m.
        origin: (3,) where the lattice's corner 0, 0, 0 is, m.
    """

    keys: Keys
    sizes: Keys
    resolution: float
    origin: Floats


def building(
    length: float = 40.0, width: float = 20.0, storeys: int = 3, resolution: float = 0.05, seed: int = 0
) -> Cells:
    """The occupied cells of a building whose corner is at the world's origin; lengths are in m.

    The `resolution` is the edge of the smallest cells; the seed is that of rooms, doors and furniture.
    """
    rng = np.random.default_rng(seed)
    shape = tuple(int(np.ceil(edge / resolution)) for edge in (length, width, _STOREY))
    parts = []
    for k in range(storeys):
        found = np.argwhere(_storey((shape[0], shape[1], shape[2]), resolution, rng)).astype(np.int32)
        found[:, 2] += k * shape[2]
        parts.append(found)
    keys, sizes = pruned(np.concatenate(parts))
    return Cells(keys, sizes, resolution, np.zeros(3))


def _storey(shape: tuple[int, int, int], step: float, rng: np.random.Generator) -> Bools:
    """The occupied cells of one storey."""
    full = np.zeros(shape, dtype=bool)
    slab, wall, lintel = (max(1, round(edge / step)) for edge in (_SLAB, _WALL, _LINTEL))
    walls, doors = _plan(shape[:2], step, wall, rng)
    full[walls] = True
    full[doors, : slab + lintel] = False
    for room in range(max(1, round(shape[0] * shape[1] * step * step / _ROOM**2))):
        for _ in range(_PIECES):
            _furnish(full, slab, step, rng, hollow=room % 2 == 0)
    full &= rng.random(shape) >= _UNSEEN
    full[:, :, :slab] = True
    return full


def _plan(shape: tuple[int, int], step: float, wall: int, rng: np.random.Generator) -> tuple[Bools, Bools]:
    """Where walls and doors are, seen from above."""
    walls, doors = np.zeros(shape, dtype=bool), np.zeros(shape, dtype=bool)
    for axis in (0, 1):
        along, across = np.moveaxis(walls, axis, 0), np.moveaxis(doors, axis, 0)
        places = [*range(0, shape[axis] - wall, max(1, round(_ROOM / step))), shape[axis] - wall]
        for place in places:
            along[place : place + wall] = True
            if 0 < place < shape[axis] - wall:
                _open(across[place : place + wall], step, wall, rng)
    return walls, doors


def _open(strip: Bools, step: float, wall: int, rng: np.random.Generator) -> None:
    """A door in each room's piece of a wall (wall, n), away from the walls across."""
    room, door = round(_ROOM / step), round(_DOOR / step)
    for begin in range(0, strip.shape[1] - room + 1, room):
        at = begin + int(rng.integers(2 * wall, room - door - wall))
        strip[:, at : at + door] = True


def _furnish(full: Bools, slab: int, step: float, rng: np.random.Generator, hollow: bool) -> None:
    """Puts a box on the slab."""
    edges = np.maximum(2, np.round(rng.uniform(*_EDGES) / step)).astype(int)
    low = rng.integers(0, np.maximum(1, np.array(full.shape[:2]) - edges[:2]))
    x, y, z = (slice(int(a), int(a + e)) for a, e in zip([*low, slab], edges, strict=True))
    full[x, y, z] = True
    if hollow:
        full[x.start + 1 : x.stop - 1, y.start + 1 : y.stop - 1, z.start : z.stop - 1] = False


def pruned(keys: Keys) -> tuple[Keys, Keys]:
    """Joins eight cells that make a larger one, again and again.

    From distinct cells (n, 3) of one step to low corners (m, 3) and sizes (m,) in steps.
    """
    left, level, done = keys, 0, []
    while len(left):
        parents, index, counts = _unique(left >> 1)
        is_joined = counts == 8
        lone = left[~is_joined[index]]
        done.append((lone << level, np.full(len(lone), 1 << level, dtype=np.int32)))
        left, level = parents[is_joined], level + 1
    corners, sizes = zip(*done, strict=True)
    return np.concatenate(corners), np.concatenate(sizes)


def _unique(keys: Keys) -> tuple[Keys, NDArray[np.intp], NDArray[np.intp]]:
    """Distinct rows, the row of each key among them, and how often each occurs."""
    codes = (keys.astype(np.int64) * np.array([1 << 40, 1 << 20, 1])).sum(axis=1)
    first, index, counts = grouped(codes)
    distinct = codes[first]
    rows = np.column_stack([distinct >> 40, (distinct >> 20) & 0xFFFFF, distinct & 0xFFFFF])
    return rows.astype(np.int32), index.reshape(-1), counts
