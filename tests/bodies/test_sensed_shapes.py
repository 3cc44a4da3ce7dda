"""Clouds, octrees, voxel grids and height fields as shapes: what they are made of, and what is no such shape."""

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import exact_verdicts
import numpy as np
import pytest
from poses import at

import plannercheck as pc
from plannercheck.bodies.part_sets import PartSet

CORNERS = np.indices((2, 2, 2)).reshape(3, 8).T


def cloud(rng: np.random.Generator) -> pc.PointCloud:
    points = rng.normal(size=(40, 3))
    points[rng.integers(40, size=3)] = np.nan
    return pc.PointCloud(points, rng.uniform(0.01, 0.3, size=40), invalid="drop")


def octree(rng: np.random.Generator, unknown: Any = "occupied") -> pc.Octree:
    keys = np.unique(rng.integers(-3, 3, size=(20, 3)), axis=0) * 2
    sizes = rng.choice([1, 2], size=len(keys))
    return pc.Octree.from_cells(keys, 0.1, sizes, rng.random(len(keys)) < 0.5, unknown)


def grid(rng: np.random.Generator) -> pc.VoxelGrid:
    shape = tuple(rng.integers(1, 7, size=3))
    occupied = rng.random(shape) < 0.7
    occupied.flat[0] = True
    return pc.VoxelGrid(occupied, 0.1, tuple(rng.normal(size=3)))


def terrain(rng: np.random.Generator) -> pc.HeightField:
    heights = rng.uniform(0, 1, size=(4, 5))
    heights[2, 3] = np.nan
    return pc.HeightField(heights, (0.1, 0.3), -0.2, (1 / 3, -2.0))


SHAPES: dict[str, Callable[[np.random.Generator], Any]] = {
    "cloud": cloud,
    "octree": octree,
    "grid": grid,
    "terrain": terrain,
}
EMPTY: dict[str, PartSet] = {
    "cloud": pc.PointCloud([], 0.1),
    "octree": pc.Octree.from_cells(np.zeros((0, 3), dtype=int), 0.1, unknown="occupied"),
    "free": pc.Octree.from_cells([[0, 0, 0]], 0.1, occupied=False),
    "grid": pc.VoxelGrid(np.zeros((2, 3, 1), dtype=bool), 0.1),
    "nothing": pc.VoxelGrid(np.zeros((0, 3, 1), dtype=bool), 0.1),
    "terrain": pc.HeightField(np.full((2, 2), np.nan), 0.1, 0.0),
}


def parts_of(shape: PartSet) -> dict[int, tuple[np.ndarray, float]]:
    """What the core holds, by the part's number."""
    found = {}
    for place in range(shape.core.places):
        corners, radius, source = shape.core.part(place)
        if len(corners):
            assert source not in found
            found[int(source)] = (corners, radius)
    return found


def boxes_of(low: np.ndarray, high: np.ndarray) -> list[np.ndarray]:
    return [np.where(CORNERS, top, bottom) for bottom, top in zip(low, high, strict=True)]


def prisms_of(field: pc.HeightField) -> dict[str, np.ndarray]:
    """Corners by name, from the words of the documentation."""
    found = {}
    rows, columns = field.heights.shape
    for i in range(rows - 1):
        for j in range(columns - 1):
            for side, third in (("x", (i + 1, j)), ("y", (i, j + 1))):
                top = [
                    (
                        field.origin[0] + a * field.resolution[0],
                        field.origin[1] + b * field.resolution[1],
                        float(field.heights[a, b]),
                    )
                    for a, b in ((i, j), third, (i + 1, j + 1))
                ]
                if not any(np.isnan(z) for *_, z in top):
                    found[f"({i}, {j}) {side}"] = np.array([*top, *((x, y, field.base) for x, y, _ in top)])
    return found


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("seed", range(4))
def test_the_core_has_the_parts_under_their_names(name: str, seed: int) -> None:
    shape = SHAPES[name](np.random.default_rng(seed))
    held = parts_of(shape)
    assert len(held) == shape.count == shape.core.count
    if isinstance(shape, pc.PointCloud):
        for k, (corners, radius) in held.items():
            assert np.array_equal(corners, shape.points[[k]])
            assert radius == shape.radii[k]
            assert shape.source is not None
            assert shape.part_name(k) == str(shape.source[k])
    elif isinstance(shape, pc.HeightField):
        prisms = prisms_of(shape)
        assert {shape.part_name(k) for k in held} == set(prisms)
        for k, (corners, radius) in held.items():
            assert (set(map(tuple, corners)), radius) == (set(map(tuple, prisms[shape.part_name(k)])), 0.0)
    else:
        keys, sizes = shape.cells
        low = np.asarray(shape.origin) + keys * shape.resolution
        high = np.asarray(shape.origin) + (keys + sizes[:, None]) * shape.resolution
        assert np.array_equal(np.stack(shape.boxes()), [low, high])
        for k, box in enumerate(boxes_of(low, high)):
            assert (set(map(tuple, held[k][0])), held[k][1]) == (set(map(tuple, box)), 0.0)
            ends = [f"{a}:{a + sizes[k]}" if sizes[k] > 1 else f"{a}" for a in keys[k].tolist()]
            assert shape.part_name(k).removeprefix("unknown ") == f"({', '.join(ends)})"


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("seed", range(6))
def test_bounds_hold_all_parts_and_no_more_than_rounding(name: str, seed: int) -> None:
    shape = SHAPES[name](np.random.default_rng(seed))
    low = np.min([corners.min(axis=0) - radius for corners, radius in parts_of(shape).values()], axis=0)
    high = np.max([corners.max(axis=0) + radius for corners, radius in parts_of(shape).values()], axis=0)
    assert (shape.bounds[0] <= low).all()
    assert (shape.bounds[1] >= high).all()
    holes = np.array([isinstance(shape, pc.HeightField), isinstance(shape, pc.HeightField), False])  # may be at an end
    assert np.allclose(shape.bounds[0][~holes], low[~holes], rtol=1e-15, atol=1e-15)
    assert np.allclose(shape.bounds[1][~holes], high[~holes], rtol=1e-15, atol=1e-15)
    assert (shape.core.low() <= low).all()
    assert (shape.core.high() >= high).all()
    corners, faces = shape.vertices_and_faces()
    assert np.array_equal([corners.min(axis=0), corners.max(axis=0)], shape.bounds)
    assert (corners.shape, np.shape(faces)[0]) == ((8, 3), 6)


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_are_pickled_compared_and_left_alone(name: str) -> None:
    shape, same, other = (SHAPES[name](np.random.default_rng(seed)) for seed in (1, 1, 2))
    again = pickle.loads(pickle.dumps(shape))
    assert again.digest == shape.digest == same.digest != other.digest
    assert repr(again) == repr(shape)
    assert np.array_equal(again.bounds, shape.bounds)
    assert [again.part_name(k) for k in range(shape.count)] == [shape.part_name(k) for k in range(shape.count)]
    assert parts_of(again).keys() == parts_of(shape).keys()
    for array in vars(shape).values():
        if isinstance(array, np.ndarray):
            assert not array.flags.writeable
    assert not shape.bounds.flags.writeable


def test_shapes_keep_their_numbers_when_the_array_given_changes() -> None:
    points, occupied, heights = np.zeros((2, 3)), np.ones((2, 2, 2), dtype=bool), np.zeros((3, 3))
    shapes = pc.PointCloud(points, 0.1), pc.VoxelGrid(occupied, 0.1), pc.HeightField(heights, 0.1, -1.0)
    before = [pickle.loads(pickle.dumps(shape)).digest for shape in shapes]
    points += 1
    occupied[0] = False
    heights += 1
    assert [shape.digest for shape in shapes] == before


def test_every_number_of_a_shape_is_in_its_digest() -> None:
    shapes: list[PartSet] = [
        pc.PointCloud([[0, 0, 0], [1, 0, 0]], 0.1),
        pc.PointCloud([[1, 0, 0], [0, 0, 0]], 0.1),
        pc.PointCloud([[0, 0, 0], [1, 0, 0]], 0.2),
        pc.PointCloud([[0, 0, 0], [1, 0, 0]], [0.1, 0.1]),
        pc.VoxelGrid(np.ones((1, 1, 1), dtype=bool), 0.1),
        pc.VoxelGrid(np.ones((1, 1, 1), dtype=bool), 0.2),
        pc.VoxelGrid(np.ones((1, 1, 1), dtype=bool), 0.1, (0, 0, 1)),
        pc.VoxelGrid(np.ones((1, 1, 2), dtype=bool), 0.1),
        pc.Octree.from_cells([[0, 0, 0]], 0.1),
        pc.Octree.from_cells([[0, 0, 0]], 0.2),
        pc.Octree.from_cells([[0, 0, 0]], 0.1, 2),
        pc.Octree.from_cells([[0, 0, 0]], 0.1, occupied=False),
        pc.Octree.from_cells([[0, 0, 0]], 0.1, unknown="occupied"),
        pc.HeightField(np.zeros((2, 2)), 0.1, 0.0),
        pc.HeightField(np.zeros((2, 2)), (0.1, 0.2), 0.0),
        pc.HeightField(np.zeros((2, 2)), 0.1, -1.0),
        pc.HeightField(np.zeros((2, 2)), 0.1, 0.0, (0, 1)),
        pc.HeightField(np.ones((2, 2)), 0.1, 0.0),
        pc.HeightField(np.zeros((2, 3)), 0.1, 0.0),
    ]
    assert len({shape.digest for shape in shapes}) == len(shapes)


@pytest.mark.parametrize("name", EMPTY)
def test_sets_without_parts(name: str) -> None:
    shape = EMPTY[name]
    assert (shape.count, shape.core.count) == (0, 0)
    with pytest.raises(pc.PlannercheckError, match="has no parts, so it has no bounds"):
        shape.bounds  # noqa: B018
    box = pc.Box((9.0, 9.0, 9.0))
    assert not pc.intersects(box, shape)
    assert pc.certify(box, shape).verify()
    assert pickle.loads(pickle.dumps(shape)).digest == shape.digest


def test_merged_cells_are_the_cells_of_the_grid() -> None:
    rng = np.random.default_rng(1)
    for _ in range(40):
        occupied = rng.random(tuple(rng.integers(1, 12, size=3))) < rng.choice([0.3, 0.95, 1.0])
        keys, sizes = pc.VoxelGrid(occupied, 0.1).cells
        held = np.zeros(occupied.shape, dtype=int)
        for (i, j, k), size in zip(keys.tolist(), sizes.tolist(), strict=True):
            held[i : i + size, j : j + size, k : k + size] += (
                size == held[i : i + size, j : j + size, k : k + size].shape[0]
            )
        assert np.array_equal(held, occupied)
    assert pc.VoxelGrid(np.ones((64, 64, 64), dtype=bool), 0.1).count == 1


def body(rng: np.random.Generator) -> pc.Polytope:
    return pc.Polytope(
        rng.normal(size=(int(rng.choice([1, 2, 4, 30])), 3)) * 0.1, inflation_radius=rng.choice([0, 0.02])
    )


def test_a_grid_an_octree_and_the_same_boxes_have_one_verdict() -> None:
    """Cells alone, merged, as an octree and as boxes one by one; near faces, edges and corners, too."""
    rng, met = np.random.default_rng(2), 0
    for resolution in (0.125, 0.1):  # of a power of two all sums are exact, so bodies may touch cells
        for _ in range(5):
            occupied = rng.random((4, 3, 5)) < 0.4
            occupied[0, 0, 0] = True
            keys = np.argwhere(occupied)
            merged, sizes = _merged(keys)
            shapes = [
                pc.VoxelGrid(occupied, resolution),
                pc.Octree.from_cells(keys, resolution),
                pc.Octree.from_cells(merged, resolution, sizes),
            ]
            boxes = boxes_of(keys * resolution, (keys + 1) * resolution)
            wholes = [pc.Polytope(shape) for shape in shapes]
            singles = [pc.Polytope(box) for box in boxes]
            for _ in range(20):
                other = body(rng) if rng.random() < 0.6 else pc.Polytope(CORNERS * resolution)
                there = at(*np.round(rng.uniform(-1, 5, size=3) * 2) / 2 * resolution)
                if rng.random() < 0.5:
                    there[:3, 3] += rng.choice([-1, 0, 1], size=3) * 2.0**-53
                expected = any(pc.intersects(other, single, there) for single in singles)
                exact = any(
                    exact_verdicts.intersects(other.vertices, box, there, np.eye(4), other.inflation_radius, 0.0)
                    for box in boxes
                )
                assert expected == exact
                assert [pc.intersects(other, whole, there) for whole in wholes] == [expected] * 3
                met += expected
    assert 40 < met < 170


def _merged(keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cells with each full block of 2 x 2 x 2 as one: keys and sizes."""
    known, low, sizes = set(map(tuple, keys.tolist())), [], []
    blocks = {key for key in known if all(c % 2 == 0 for c in key)}
    for key in list(blocks):
        block = {tuple(np.add(key, corner).tolist()) for corner in CORNERS}
        if block <= known:
            known -= block
            low.append(key)
            sizes.append(2)
    return np.array([*low, *sorted(known)]), np.array([*sizes, *[1] * len(known)])


def test_a_height_field_has_the_verdicts_of_its_prisms_one_by_one() -> None:
    rng, met = np.random.default_rng(3), 0
    for case in range(8):
        heights = np.round(rng.uniform(0, 1, size=tuple(rng.integers(2, 6, size=2))) * 8) / 8
        heights[rng.random(heights.shape) < 0.1 * (case % 2)] = np.nan
        heights[0, 0] = heights[1, 1] = heights[1, 0] = -0.25 if case % 4 == 0 else 0.5  # a prism without height
        field = pc.HeightField(heights, (0.25, 0.125), -0.25)
        whole, prisms = pc.Polytope(field), list(prisms_of(field).values())
        for _ in range(20):
            other = body(rng)
            i, j = rng.integers(heights.shape[0]), rng.integers(heights.shape[1])
            there = at(0.25 * i, 0.125 * j, np.nan_to_num(heights[i, j]))
            there[:3, 3] += rng.choice([0, 0.125, 0.01], size=3)
            if rng.random() < 0.5:
                other = pc.Polytope([[0, 0, 0], [0, 0, 2.0]])  # stands on the surface, or beside it
                there[2, 3] += rng.choice([0, 2.0**-40, -0.01])
            exact = any(
                exact_verdicts.intersects(other.vertices, prism, there, np.eye(4), other.inflation_radius, 0.0)
                for prism in prisms
            )
            assert pc.intersects(other, whole, there) == exact
            met += exact
    assert 40 < met < 140


def test_the_height_of_a_surface() -> None:
    field = pc.HeightField([[0, 1, np.nan], [2, 5, 0], [0, 0, 0]], (1.0, 2.0), -1.0, (10.0, 20.0))
    places = [[10, 20], [11, 20], [10, 22], [11, 22], [10.5, 20], [10.5, 21], [10.75, 20.5], [10.25, 21.5], [10.5, 24]]
    found = field.surface_height([*places, [9.99, 20], [12.01, 20], [10, 24], [12, 24]])
    assert found[:8].tolist() == [0, 2, 1, 5, 1, 2.5, 2.25, 1.75]
    assert np.isnan(found[8:12]).all()
    assert found[12] == 0
    rng = np.random.default_rng(1)
    field = pc.HeightField(rng.uniform(0, 1, size=(5, 6)), 0.5, -1.0)
    whole = pc.Polytope(field)
    for x, y in rng.uniform([0, 0], [2, 2.5], size=(200, 2)):
        (z,) = field.surface_height([[x, y]])
        assert pc.intersects(pc.Polytope([[x, y, z - 1e-9]]), whole)
        assert not pc.intersects(pc.Polytope([[x, y, z + 1e-9]]), whole)


def test_points_in_a_grid() -> None:
    rng = np.random.default_rng(4)
    occupied = rng.random((4, 5, 6)) < 0.5
    shape = pc.VoxelGrid(occupied, 0.1, (1 / 3, 0.0, -0.7))
    steps = np.indices(occupied.shape).reshape(3, -1).T
    assert np.array_equal(shape.query(shape.corners(steps)), occupied.ravel())
    assert np.array_equal(shape.query(np.nextafter(shape.corners(steps + 1), -np.inf)), occupied.ravel())
    assert not shape.query([[9, 9, 9], [-9, 0, 0], [1e40, 0, 0]]).any()
    with pytest.raises(pc.PlannercheckError, match="finite"):
        shape.query([[np.nan, 0, 0]])


ZEROS = np.zeros((2, 2))
CELL = np.ones((1, 1, 1), dtype=bool)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: pc.PointCloud([[0, 0]], 0.1), r"shape \(n, 3\), not \(1, 2\)"),
        (lambda: pc.PointCloud([0, 0, 0], 0.1), r"shape \(n, 3\)"),
        (lambda: pc.PointCloud([["a", 0, 0]], 0.1), "must be numbers"),
        (lambda: pc.PointCloud([[0, 0, 0], [0]], 0.1), "must be numbers"),
        (lambda: pc.PointCloud([[1j, 0, 0]], 0.1), "must be numbers"),
        (lambda: pc.PointCloud([[0, np.nan, 0], [np.inf, 0, 0]], 0.1), "row 0 is .* and 1 more are so"),
        (lambda: pc.PointCloud([[0, 1e300, 0]], 0.1), "at most 1e"),
        (lambda: pc.PointCloud([[0, 1e300, 0]], 0.1, invalid="drop"), "at most 1e"),
        (lambda: pc.PointCloud([[0, 0, 0]], 0.1, invalid="skip"), "skip.*valid"),  # type: ignore[arg-type]
        (lambda: pc.PointCloud([[0, 0, 0]], 0), "above 0"),
        (lambda: pc.PointCloud([[0, 0, 0]], -1), "above 0"),
        (lambda: pc.PointCloud([[0, 0, 0]], np.nan), "above 0"),
        (lambda: pc.PointCloud([[0, 0, 0]], np.inf), "finite"),
        (lambda: pc.PointCloud([[0, 0, 0]], 1e300), "at most 1e"),
        (lambda: pc.PointCloud([[0, 0, 0]], "x"), "must be a length"),  # type: ignore[arg-type]
        (lambda: pc.PointCloud([[0, 0, 0]], [0.1, 0.1]), "one for each of 1 points"),
        (lambda: pc.PointCloud([[0, 0, 0], [1, 0, 0]], [0.1, 0]), "radius 1 of a cloud"),
        (lambda: pc.PointCloud([], 0), "above 0"),
        (lambda: pc.VoxelGrid(np.ones((2, 2)), 0.1), r"shape \(i, j, k\)"),
        (lambda: pc.VoxelGrid(np.ones((1, 1, 1)), 0.1), "truth values"),
        (lambda: pc.VoxelGrid(np.full((1, 1, 1), 2), 0.1), "0 \\(free\\) or 1"),
        (lambda: pc.VoxelGrid(np.full((1, 1, 1), -1), 0.1), "0 \\(free\\) or 1"),
        (lambda: pc.VoxelGrid(CELL, 0), "resolution of a voxel grid"),
        (lambda: pc.VoxelGrid(CELL, -0.1), "resolution of a voxel grid"),
        (lambda: pc.VoxelGrid(CELL, np.nan), "resolution of a voxel grid"),
        (lambda: pc.VoxelGrid(CELL, None), "resolution of a voxel grid"),  # type: ignore[arg-type]
        (lambda: pc.VoxelGrid(CELL, 0.1, (0, 0)), "3 finite numbers"),  # type: ignore[arg-type]
        (lambda: pc.VoxelGrid(CELL, 0.1, (0, 0, np.nan)), "3 finite numbers"),
        (lambda: pc.VoxelGrid(CELL, 1e-20, (1, 1, 1)), "no different places"),
        (lambda: pc.HeightField(np.zeros(3), 0.1, 0), "at least"),
        (lambda: pc.HeightField(np.zeros((1, 3)), 0.1, 0), "at least"),
        (lambda: pc.HeightField([["a", "b"], ["c", "d"]], 0.1, 0), "must be numbers"),
        (lambda: pc.HeightField(ZEROS > 0, 0.1, 0), "of dtype bool"),
        (lambda: pc.HeightField([[0, np.inf], [0, 0]], 0.1, 0), "finite"),
        (lambda: pc.HeightField([[0, 1e300], [0, 0]], 0.1, 0), "at most 1e"),
        (lambda: pc.HeightField(ZEROS, 0, 0), "resolution of a height field"),
        (lambda: pc.HeightField(ZEROS, (0.1, -1), 0), "resolution of a height field"),
        (lambda: pc.HeightField(ZEROS, (0.1, 0.1, 0.1), 0), "one or two lengths"),  # type: ignore[arg-type]
        (lambda: pc.HeightField(ZEROS, 0.1, 0.5), "at most its lowest height, 0.0 m, not 0.5 m"),
        (lambda: pc.HeightField(ZEROS, 0.1, np.nan), "base of a height field"),
        (lambda: pc.HeightField(ZEROS, 0.1, 0, (0, 0, 0)), "2 finite numbers"),
        (lambda: pc.HeightField(ZEROS, 1e-20, 0, (1, 1)), "no different places"),
        (lambda: pc.Octree.from_cells([[0, 0, 0]], 0), "resolution of an octree"),
        (lambda: pc.Octree.from_cells([[0, 0, 0]], 1e49), "octree"),
        (lambda: pc.Octree.from_cells([[0, 0]], 0.1), r"shape \(n, 3\), not \(1, 2\)"),
        (lambda: pc.Octree.from_cells([[0, 0], [0, 0], [0, 0]], 0.1), r"shape \(n, 3\), not \(3, 2\)"),
        (lambda: pc.Octree.from_cells([[0.5, 0, 0]], 0.1), "whole numbers"),
        (lambda: pc.Octree.from_cells([[0, 0, 0], [1]], 0.1), "whole numbers"),
        (lambda: pc.Octree.from_cells([[10**30, 0, 0]], 0.1), "whole numbers"),
        (lambda: pc.Octree.from_cells([[2**63 - 1, 0, 0]], 0.1), "cell 0 of an octree"),
        (lambda: pc.Octree.from_cells(np.full((1, 3), 2**64 - 1, dtype=np.uint64), 0.1), "whole numbers"),
        (lambda: pc.Octree.from_cells([[32768, 0, 0]], 0.1), "cell 0 of an octree"),
        (lambda: pc.Octree.from_cells([[0, 0, 0], [1, 0, 0]], 0.1, [1, 2]), "cell 1 of an octree"),
        (lambda: pc.Octree.from_cells([[0, 0, 0]], 0.1, 3), "cell 0 of an octree"),
        (lambda: pc.Octree.from_cells([[0, 0, 0]], 0.1, 0), "cell 0 of an octree"),
        (lambda: pc.Octree.from_cells([[0, 0, 0]], 0.1, 2**62), "cell 0 of an octree"),
        (lambda: pc.Octree.from_cells([[0, 0, 0]], 0.1, [1, 1]), "one for each of 1 cells"),
        (lambda: pc.Octree.from_cells([[0, 0, 0]], 0.1, 1, [True, False]), "one for each of 1 cells"),
        (lambda: pc.Octree.from_cells([[0, 0, 0]], 0.1, 1, 0.7), "occupied must be truth values"),
        (lambda: pc.Octree.from_cells([[0, 0, 0]], 0.1, 1, 2), "occupied must be truth values"),
        (lambda: pc.Octree.from_cells([[0, 0, 0], [1, 0, 0]], 0.1, [2, 1]), "must be disjoint"),
        (lambda: pc.Octree.from_cells([[1, 0, 0], [1, 0, 0]], 0.1), "must be disjoint"),
        (lambda: pc.Octree.from_cells([[0, 0, 0]], 0.1, unknown="maybe"), "maybe.*valid"),  # type: ignore[arg-type]
    ],
)
def test_what_is_no_such_shape(make: Callable[[], object], said: str) -> None:
    with pytest.raises(pc.PlannercheckError, match=said):
        make()


def test_arrays_in_files(tmp_path: Path) -> None:
    grid_file, heights_file = tmp_path / "g.npy", tmp_path / "h.npy"
    np.save(grid_file, CELL.astype(np.uint8))
    np.save(heights_file, ZEROS.astype(np.int16))
    assert pc.VoxelGrid.load(grid_file, 0.1).count == 1
    assert pc.HeightField.load(heights_file, 0.1, -1.0).count == 2
    for path, load in (
        (grid_file, lambda path: pc.VoxelGrid.load(path, 0.1)),
        (heights_file, lambda path: pc.HeightField.load(path, 0.1, -1.0)),
    ):
        content = path.read_bytes()
        for size in range(len(content)):
            path.write_bytes(content[:size])
            with pytest.raises(pc.PlannercheckError, match=r"file '.*can't be read as npy"):
                load(path)
        np.savez(path.open("wb"), a=ZEROS, b=ZEROS)
        with pytest.raises(pc.PlannercheckError, match="several arrays"):
            load(path)
        for wrong in (np.zeros((2, 2, 2, 2)), np.array(["a"]), np.zeros(2, dtype=[("x", "f8")]), np.zeros((2, 2)) * 1j):
            np.save(path, wrong)
            with pytest.raises(pc.PlannercheckError):
                load(path)
        with pytest.raises(pc.PlannercheckError, match="does not exist"):
            load(tmp_path / "other.npy")


def test_meanings_of_unknown_space_are_one_map() -> None:
    free = octree(np.random.default_rng(1), "free")
    occupied = free.with_unknown("occupied")
    assert occupied.with_unknown("free").digest == free.digest
    assert free.with_unknown("free") is free
    assert occupied.count > free.count
    assert not any(occupied.part_name(k).startswith("unknown") for k in range(free.count))
    assert all(occupied.part_name(k).startswith("unknown (") for k in range(free.count, occupied.count))
    low, high = free.keys.min(axis=0), (free.keys + free.sizes[:, None]).max(axis=0)
    assert np.array_equal(occupied.bounds, [low * 0.1, high * 0.1]) or (occupied.bounds[0] >= low * 0.1).all()
    steps = np.stack(np.meshgrid(*map(np.arange, low - 2, high + 2), indexing="ij"), axis=-1).reshape(-1, 3)
    states = free.query((steps + 0.5) * 0.1)
    inside = ((steps >= low) & (steps < high)).all(axis=1)
    for shape, expected in ((free, states == 1), (occupied, (states == 1) | ((states == -1) & inside))):
        whole = pc.Polytope(shape)
        assert [pc.intersects(pc.Polytope([point]), whole) for point in (steps + 0.5) * 0.1] == expected.tolist()
