"""Sets of parts in and around hollow solids, with their truth in whole numbers.

In: a random generator. Out: `Nested`: a solid made of cells of a coarse grid (rings, tubes, cups, closed boxes with
cavities, nested shells, linked rings, loose walls), a set (cloud, grid, octree, heights) of which most parts are in its
hollows, and whether they share a point. Idea: the solid is the union of closed cells, so a part meets it if it meets a
cell: distances of balls and boxes, and separating axes of prisms, in Python's and numpy's whole numbers.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import plannercheck as pc

Whole = NDArray[np.int64]

UNIT = 1 / 64  # m: one step of the lattice on which all is placed
FINER = 16  # steps of the truth's lattice in one of these, for bodies that are grown or shrunk by one step
KINDS = ("cloud", "grid", "octree", "heights")


@dataclass(frozen=True)
class Nested:
    """A solid and a set.

    Attributes:
        shape: Name of the solid's shape.
        kind: Of `KINDS`.
        solid: The solid.
        parts: The set.
        pose: (4, 4) of the set in the solid's frame, m; a signed permutation and whole steps.
        meets: Whether they share a point.
        is_clear: Whether they do so as well if every cell is a millimetre larger or smaller, so that rounding decides
            nothing.
        at: (4, 4) some pose of both in the world, as rounding leaves it.
    """

    shape: str
    kind: str
    solid: pc.Solid
    parts: object
    pose: np.ndarray
    meets: bool
    is_clear: bool
    at: np.ndarray


def cells_of(shape: str) -> NDArray[np.bool_]:
    """The occupied cells of a solid."""
    out = np.zeros((7, 5, 5), dtype=bool)
    if shape == "ring":
        out[:5, :, 1], out[1:4, 1:4, 1] = True, False
    elif shape == "tube":
        out[:3, :3], out[1, 1] = True, False
    elif shape == "cup":
        out[:3, :3], out[1, 1, 1:] = True, False
    elif shape in ("cavity", "shells"):
        out[:5], out[1:4, 1:4, 1:4] = True, False
        out[2, 2, 2] = shape == "shells"
    elif shape == "linked":
        out[:5, :, 2], out[1:4, 1:4, 2] = True, False
        out[2:7, 2, 0] = out[2:7, 2, 4] = out[2, 2, :] = out[6, 2, :] = True
    else:  # walls: a floor, and two walls that stand on nothing
        out[:5, :, 0] = out[0, :, 2:] = out[4, :, 2:] = True
    return out


SHAPES = ("ring", "tube", "cup", "cavity", "shells", "linked", "walls")


def surface(cells: NDArray[np.bool_], size: Whole) -> tuple[Whole, Whole]:
    """Corners (n, 3) in steps and outward triangles (k, 3) of the faces between cells and what is empty."""
    places: dict[tuple[int, ...], int] = {}
    triangles = []
    full = np.pad(cells, 1)
    for cell in np.argwhere(full):
        for axis, side in itertools.product(range(3), (0, 1)):
            beside = cell.copy()
            beside[axis] += 2 * side - 1
            if full[tuple(beside)]:
                continue
            corners = []
            for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                corner = cell - 1
                corner[axis] += side
                corner[(axis + 1) % 3] += u
                corner[(axis + 2) % 3] += v
                corners.append(places.setdefault(tuple((corner * size).tolist()), len(places)))
            a, b, c, d = corners if side else corners[::-1]
            triangles += [(a, b, c), (a, c, d)]
    return np.array(list(places), dtype=np.int64), np.array(triangles, dtype=np.int64)


def draw(seed: int) -> Nested:
    """A random case."""
    rng = np.random.default_rng(seed)
    shape, kind = SHAPES[seed % len(SHAPES)], KINDS[int(rng.integers(len(KINDS)))]
    cells, size = cells_of(shape), rng.integers(10, 25, 3)
    corners, triangles = surface(cells, size)
    turn = np.eye(3, dtype=np.int64)[rng.permutation(3)] * rng.choice([-1, 1], 3)
    turn[0] *= round(np.linalg.det(turn))
    hollow = _enclosed(cells) if rng.integers(4) else np.argwhere(~cells)
    count = int(rng.integers(1, 9))
    points = hollow[rng.integers(len(hollow), size=count)] * size + rng.integers(1, size, (count, 3))
    shift = points[0] if kind != "cloud" else np.zeros(3, dtype=np.int64)
    parts, truth = _set(rng, kind, (points - shift) @ turn)
    low = np.argwhere(cells) * size
    bounds = FINER * low, FINER * (low + size)

    def meets(grown: int) -> bool:
        return truth(turn, FINER * shift, bounds[0] - grown, bounds[1] + grown)

    pose, at = np.eye(4), np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, shift * UNIT
    at[:3, :3], at[:3, 3] = _rotation(rng), rng.uniform(-1, 1, 3)
    solid = pc.Solid(corners * UNIT, triangles)
    return Nested(shape, kind, solid, parts, pose, meets(0), meets(1) == meets(-1), at)


def _enclosed(cells: NDArray[np.bool_]) -> Whole:
    """Empty cells with occupied ones on both sides along some axis."""
    return np.array(
        [
            cell
            for cell in np.argwhere(~cells).tolist()
            if any(
                np.take(cells, range(cell[k]), k)[
                    tuple(line := [c if j != k else slice(None) for j, c in enumerate(cell)])
                ].any()
                and np.take(cells, range(cell[k] + 1, cells.shape[k]), k)[tuple(line)].any()
                for k in range(3)
            )
        ]
    )


def _rotation(rng: np.random.Generator) -> np.ndarray:
    x, y, z, w = (q := rng.normal(size=4)) / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def _set(rng: np.random.Generator, kind: str, points: Whole) -> tuple[object, Callable[..., bool]]:
    """A set, and whether it meets boxes (n, 3) to (n, 3), turned and shifted; points are in the set's frame."""
    if kind == "cloud":
        radii = rng.integers(1, 9, len(points))
        shape = pc.PointCloud(points * UNIT, radii * UNIT)
        return shape, lambda *placed: _balls_meet(FINER * points, FINER * radii, *placed)
    if kind == "heights":
        heights = rng.integers(-2, 6, rng.integers(2, 5, 2)).astype(float)
        heights[tuple(rng.integers(0, heights.shape))] = np.nan if rng.integers(4) == 0 and heights.size > 4 else 1.0
        steps, base = rng.integers(1, 6, 2), -3
        shape = pc.HeightField(heights * UNIT, tuple((steps * UNIT).tolist()), base * UNIT)
        triangles = np.round(shape.triangles() / UNIT).astype(np.int64)
        return shape, lambda *placed: _prisms_meet(FINER * triangles, FINER * base, *placed)
    resolution = int(rng.integers(1, 5))
    filled = rng.random(rng.integers(1, 4, 3)) < 0.5
    filled.flat[0] = True
    keys = np.argwhere(filled)
    if kind == "grid":
        shape = pc.VoxelGrid(filled, resolution * UNIT)
    else:
        keys = np.unique(np.concatenate([keys, points // resolution]), axis=0)
        shape = pc.Octree.from_cells(keys, resolution * UNIT)
    low = FINER * resolution * keys
    return shape, lambda *placed: _boxes_meet(low, low + FINER * resolution, *placed)


def _balls_meet(points: Whole, radii: Whole, turn: Whole, shift: Whole, low: Whole, high: Whole) -> bool:
    centres = (points @ turn.T + shift)[:, None]
    apart = np.maximum(0, np.maximum(low - centres, centres - high))
    return bool(((apart**2).sum(axis=2) <= radii[:, None] ** 2).any())


def _boxes_meet(first: Whole, last: Whole, turn: Whole, shift: Whole, low: Whole, high: Whole) -> bool:
    ends = np.stack([first @ turn.T + shift, last @ turn.T + shift])
    own_low, own_high = ends.min(axis=0)[:, None], ends.max(axis=0)[:, None]
    return bool(((own_low <= high) & (low <= own_high)).all(axis=2).any())


def _prisms_meet(triangles: Whole, base: int, turn: Whole, shift: Whole, low: Whole, high: Whole) -> bool:
    """By separating axes: normals of both, and products of their edges; boxes have an inside, so these are enough."""
    below = triangles.copy()
    below[:, :, 2] = base
    for prism in np.concatenate([triangles, below], axis=1) @ turn.T + shift:
        edges = np.array(
            [prism[b] - prism[a] for a, b in ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4))]
        )
        crossed = np.concatenate(
            [
                np.cross(edges[:, None], np.eye(3, dtype=np.int64)).reshape(-1, 3),
                np.cross(edges[:, None], edges).reshape(-1, 3),
            ]
        )
        axes = np.concatenate([np.eye(3, dtype=np.int64), crossed])
        heights = axes @ prism.T
        box_low = np.minimum(axes[None] * low[:, None], axes[None] * high[:, None]).sum(axis=2)
        box_high = np.maximum(axes[None] * low[:, None], axes[None] * high[:, None]).sum(axis=2)
        apart = (heights.min(axis=1) > box_high) | (heights.max(axis=1) < box_low)
        if not apart.any(axis=1).all():
            return True
    return False
