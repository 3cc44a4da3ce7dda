"""Sets of parts: clouds, lattices and heights against the same parts one by one, in exact integers."""

import pickle
from collections.abc import Iterator
from typing import Any

import exact_verdicts
import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies.part_certificates import PartSeparation
from plannercheck.bodies.part_sets import PartSet

Part = tuple[np.ndarray[Any, Any], float]


def rotation(rng: np.random.Generator) -> np.ndarray[Any, Any]:
    w, x, y, z = (lambda v: v / np.linalg.norm(v))(rng.normal(size=4))
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def pose(rng: np.random.Generator, size: float) -> np.ndarray[Any, Any]:
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = rotation(rng), rng.normal(size=3) * size
    return out


def box_corners(low: np.ndarray[Any, Any], high: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])


def cloud(rng: np.random.Generator, size: float) -> tuple[PartSet, list[Part]]:
    n = int(rng.integers(1, 60))
    points = rng.normal(size=(n, 3)) * size
    if rng.random() < 0.3:
        points[:, 2] = 0.0  # a plane, where ties are many
    radii = rng.uniform(0.01, 0.1, size=n if rng.random() < 0.5 else 1) * size
    return pc.PointCloud(points, radii), [(p[None], float(r)) for p, r in zip(points, np.resize(radii, n), strict=True)]


def grid(rng: np.random.Generator, size: float) -> tuple[PartSet, list[Part]]:
    occupied = rng.random(tuple(rng.integers(1, 5, size=3))) < 0.4
    occupied.flat[0] = True
    step, origin = 0.3 * size, rng.normal(size=3) * size
    sides = [origin[axis] + np.arange(occupied.shape[axis] + 1) * step for axis in range(3)]
    parts = []
    for i, j, k in np.argwhere(occupied).tolist():
        low, high = (
            np.array([sides[0][i], sides[1][j], sides[2][k]]),
            np.array([sides[0][i + 1], sides[1][j + 1], sides[2][k + 1]]),
        )
        parts.append((box_corners(low, high), 0.0))
    return pc.VoxelGrid(occupied, step, origin), parts


def heights(rng: np.random.Generator, size: float) -> tuple[PartSet, list[Part]]:
    field = rng.uniform(0, 1, size=tuple(rng.integers(2, 6, size=2))) * size
    if field.size > 9:
        field[rng.random(field.shape) < 0.1] = np.nan
    step, origin, base = np.array([0.4, 0.3]) * size, rng.normal(size=2) * size, -0.2 * size
    parts = []
    for i in range(field.shape[0] - 1):
        for j in range(field.shape[1] - 1):
            for third in ((i + 1, j), (i, j + 1)):
                top = [(a, b, field[a, b]) for a, b in ((i, j), third, (i + 1, j + 1))]
                if any(np.isnan(z) for *_, z in top):
                    continue
                at = [(origin[0] + a * step[0], origin[1] + b * step[1], z) for a, b, z in top]
                parts.append((np.array([*at, *((x, y, base) for x, y, _ in at)]), 0.0))
    return pc.HeightField(field, (step[0], step[1]), base, (origin[0], origin[1])), parts


def cases(seed: int, count: int) -> Iterator[tuple[np.random.Generator, float, PartSet, list[Part]]]:
    rng = np.random.default_rng(seed)
    for case in range(count):
        size = 10.0 ** int(rng.integers(-4, 5))
        made = (cloud, grid, heights)[case % 3](rng, size)
        if made[1]:
            yield rng, size, *made


def other_body(rng: np.random.Generator, size: float) -> pc.Polytope:
    corners = rng.normal(size=(int(rng.choice([1, 2, 3, 4, 30, 200])), 3)) * size * rng.uniform(0.02, 0.5)
    return pc.Polytope(corners, inflation_radius=float(rng.choice([0, 0.05 * size])))


def exactly(body: pc.Polytope, at: Any, parts: list[Part], set_at: Any) -> bool:
    return any(
        exact_verdicts.intersects(body.vertices, corners, at, set_at, body.inflation_radius, radius)
        for corners, radius in parts
    )


def test_verdicts_are_those_of_the_parts() -> None:
    shared = 0
    for rng, size, shape, parts in cases(7, 50):
        whole = pc.Polytope(shape)
        for _ in range(4):
            body, at, set_at = other_body(rng, size), pose(rng, size), pose(rng, 0.3 * size)
            expected = exactly(body, at, parts, set_at)
            shared += expected
            assert pc.intersects(body, whole, at, set_at) == expected
            assert pc.intersects(whole, body, set_at, at) == expected
    assert 7 < shared < 170


def test_parts_that_touch_share_a_point() -> None:
    ball = pc.PointCloud([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]], 0.5)
    box = pc.Box((1.0, 1.0, 1.0))
    at = np.eye(4)
    at[0, 3] = 1.0
    assert pc.intersects(box, ball, at)
    at[0, 3] = np.nextafter(1.0, 2.0)
    assert not pc.intersects(box, ball, at)
    cell = pc.VoxelGrid(np.ones((1, 1, 1), dtype=bool), 0.5)
    at[:3, 3] = 1.0
    assert pc.intersects(box, cell, at)  # corner to corner
    at[0, 3] = np.nextafter(1.0, 2.0)
    assert not pc.intersects(box, cell, at)


def test_balls_keep_their_radius_where_a_pose_shrinks_their_set() -> None:
    """Poses are affine maps that may be off rigid; radii are lengths of the world."""
    set_at, at = np.diag([1 - 4e-7, 1, 1, 1]), np.eye(4)
    at[0, 3] = 1.0
    cloud = pc.PointCloud([[0.0, 0.0, 0.0]], 1.0)
    assert pc.intersects(pc.Polytope([[0.0, 0.0, 0.0]]), cloud, at, set_at)
    assert isinstance(pc.certify(pc.Polytope([[0.0, 0.0, 0.0]]), cloud, at, set_at), pc.SharedPoint)
    at[0, 3] = np.nextafter(1.0, 2.0)
    assert not pc.intersects(pc.Polytope([[0.0, 0.0, 0.0]]), cloud, at, set_at)


SHRUNK = 1 - 4e-7  # along one axis: about as much as a pose may be off rigid


def at_x(x: float, stretch: float = 1.0) -> np.ndarray[Any, Any]:
    out = np.diag([stretch, 1.0, 1.0, 1.0])
    out[0, 3] = x
    return out


def cube(half: float, x: float = 0.0, inflation_radius: float = 0.0) -> pc.Polytope:
    corners = half * box_corners(-np.ones(3), np.ones(3))
    return pc.Polytope(corners + np.array([x, 0.0, 0.0]), inflation_radius=inflation_radius)


# A body at a pose, by how much the set's pose shrinks, and where along x the set touches the body. What is inside of
# the cubes reaches their sides; a first look takes poses for rigid, which is wrong by 4e-7 of lengths and of places.
TOUCHING = {
    "a cube": (cube(0.5), at_x(0.0, SHRUNK), 1.0, 0.5 * SHRUNK),
    "a large inflation": (cube(1e-3, inflation_radius=1.0), at_x(0.0, SHRUNK), 1.0, 1.0 + 1e-3 * SHRUNK),
    "far from its origin": (cube(1e-2, 100.0), at_x(0.0, SHRUNK), 1.0, 100.01 * SHRUNK),
    "a set far from its origin": (cube(1e-2), at_x(0.0), SHRUNK, 1e-2),
}


@pytest.mark.parametrize("kind", ["ball", "cell"])
@pytest.mark.parametrize("case", TOUCHING)
def test_parts_just_apart_from_what_is_inside_are_apart(kind: str, case: str) -> None:
    """A ball of 1 cm, or a cell of 1 m, to the right of the body; in a set far from its origin to the left."""
    body, at, stretch, place = TOUCHING[case]
    left = stretch < 1
    middle = 100.0 if left else 0.0
    shape: PartSet
    if kind == "ball":
        shape, near = pc.PointCloud([[middle, 0.0, 0.0]], 0.01), middle * stretch + (0.01 if left else -0.01)
        corners, radius = np.array([[middle, 0.0, 0.0]]), 0.01
    else:
        low = np.array([middle - 1.0 if left else 0.0, -0.5, -0.5])
        occupied = np.zeros((2, 4, 1), dtype=bool)
        occupied[0 if left else 1, 0, 0] = occupied[1 if left else 0, 3, 0] = True  # the other one only widens the hull
        shape, near = pc.VoxelGrid(occupied, 1.0, low - np.array([not left, 0.0, 0.0])), middle * stretch
        corners, radius = box_corners(low, low + 1), 0.0
    for gap, shared in ((-1e-9, True), (1e-9, False)):
        set_at = at_x(-(place + gap) - near if left else place + gap - near, stretch)
        assert exact_verdicts.intersects(body.vertices, corners, at, set_at, body.inflation_radius, radius) == shared
        assert pc.intersects(body, shape, at, set_at) == shared


@pytest.mark.parametrize("times", [1.9, 2.2])
def test_balls_so_small_that_their_squares_underflow_touch_where_they_do(times: float) -> None:
    ball, place = pc.Polytope([[0.0, 0.0, 0.0]], inflation_radius=1e-162), np.full((1, 3), times * 1e-162 / 3**0.5)
    assert pc.intersects(ball, pc.PointCloud(place, 1e-162)) == (times < 2)


def test_what_is_inside_of_one_part_is_not_inside_of_the_next() -> None:
    """The balls that touch a ball at the middle say nothing about one beside it, whose box meets theirs."""
    middle, ball = pc.PointCloud([[0.0, 0.0, 0.0]], 0.1), pc.PointCloud([[0.0, 0.0, 0.0]], 0.5)
    beside = pc.PointCloud([[0.57, 0.57, 0.0]], 0.1)
    assert pc.intersects(middle, ball)
    assert not pc.intersects(beside, ball)
    assert pc.intersects(middle, ball)


def test_certificates_are_verified() -> None:
    kinds = set()
    for rng, size, shape, parts in cases(11, 40):
        body, at, set_at = other_body(rng, size), pose(rng, size), pose(rng, 0.3 * size)
        certificate = pc.certify(body, shape, at, set_at)
        kinds.add(type(certificate))
        assert certificate.verify()
        assert isinstance(certificate, pc.SharedPoint) == exactly(body, at, parts, set_at)
    assert kinds == {pc.SharedPoint, pc.Separation, PartSeparation}


def test_a_separation_that_leaves_a_part_out_is_refused() -> None:
    shape = pc.PointCloud([[-1.0, 0, 0], [1.0, 0, 0], [0, 1.0, 0], [0, -1.0, 0]], 0.1)
    certificate = pc.certify(pc.Box((0.5, 0.5, 0.5)), shape)
    assert isinstance(certificate, PartSeparation)
    assert certificate.verify()
    less = PartSeparation(certificate.gap, certificate.ranges[1:], certificate.bodies)
    assert not less.verify()
    assert not PartSeparation(2.0, certificate.ranges, certificate.bodies).verify()


def test_two_sets_meet_where_their_parts_do() -> None:
    met = 0
    for rng, size, first, parts in cases(13, 15):
        second, others = cloud(rng, 0.4 * size)
        at, set_at = pose(rng, size), pose(rng, 0.3 * size)
        expected = any(exact_verdicts.intersects(p, q, at, set_at, r, s) for p, r in parts for q, s in others)
        met += expected
        assert pc.intersects(first, second, at, set_at) == expected
        assert pc.certify(first, second, at, set_at).verify()
    assert 1 < met < 14


def test_a_set_meets_a_solid_as_its_parts_do() -> None:
    rng = np.random.default_rng(3)
    shell = pc.Solid(*_shell())
    inside, met = pc.PointCloud([[0.0, 0.0, 0.0]], 0.05), 0
    assert not pc.intersects(shell, inside)
    for _ in range(60):
        points = rng.uniform(-1.5, 1.5, size=(2, 3))
        shape = pc.PointCloud(points, 0.05)
        expected = any(pc.intersects(shell, pc.Polytope(p[None], inflation_radius=0.05)) for p in points)
        met += expected
        assert pc.intersects(shell, shape) == expected
    assert 5 < met < 60


def _shell() -> tuple[Any, Any]:
    """A cube with a cubic hole inside: the inner faces are turned inwards."""
    corners = box_corners(-np.ones(3), np.ones(3))
    faces = pc.Polytope(corners).faces
    points = pc.Polytope(corners).vertices
    return np.concatenate([points, 0.6 * points]), np.concatenate([faces, faces[:, ::-1] + len(points)])


def test_distances_are_those_of_the_nearest_part() -> None:
    for rng, size, shape, parts in cases(17, 60):
        body, at, set_at = other_body(rng, size), pose(rng, 2 * size), pose(rng, 0.3 * size)
        if pc.intersects(body, shape, at, set_at):
            continue
        found = pc.distance(body, shape, at, set_at)
        each = [
            pc.distance(body, pc.Polytope(corners, inflation_radius=radius), at, set_at).distance
            for corners, radius in parts
        ]
        assert found.distance == pytest.approx(min(each), rel=1e-8, abs=1e-9 * size)


def test_bodies_are_pickled_with_what_they_were_made_of() -> None:
    for rng, size, shape, _ in cases(19, 12):
        whole = pc.Polytope(shape)
        again = pickle.loads(pickle.dumps(whole))
        assert [str(part) for part in again.parts.state()[1]] == [str(part) for part in whole.parts.state()[1]]
        body, at = other_body(rng, size), pose(rng, size)
        assert pc.intersects(body, again, at) == pc.intersects(body, whole, at)


def test_every_part_is_named_as_it_was_given() -> None:
    points = np.random.default_rng(5).normal(size=(1000, 3))
    compiled = pc.PointCloud(points, 0.1).core
    seen = set()
    for place in range(compiled.places):
        corners, radius, source = compiled.part(place)
        if len(corners):
            assert np.array_equal(corners[0], points[source])
            assert radius == 0.1
            seen.add(source)
    assert seen == set(range(1000))


@pytest.mark.parametrize("points", [1, 7, 8, 9, 63, 64, 65, 511, 513])
def test_clouds_of_any_size_have_all_their_points(points: int) -> None:
    rng = np.random.default_rng(points)
    at = rng.uniform(-1, 1, size=(points, 3))
    whole = pc.Polytope(pc.PointCloud(at, 1e-3))
    for p in at:
        assert pc.intersects(pc.Polytope(p[None]), whole)


@pytest.mark.parametrize("crowd", ["lattice", "one place", "an outlier", "a line"])
def test_crowded_clouds_have_all_their_points(crowd: str) -> None:
    """Where most places along an axis are the same, or fall into one bin, of those that order a tree."""
    rng = np.random.default_rng(1)
    at = rng.integers(0, 4, size=(700, 3)) / 4.0 if crowd == "lattice" else rng.uniform(-1, 1, size=(700, 3))
    if crowd == "one place":
        at[:650] = at[0]
    if crowd == "an outlier":
        at[300] = [1e9, -1e7, 1e5]
    if crowd == "a line":
        at[:, 1:] = 0.25
    shape = pc.PointCloud(at, 1e-3)
    assert {shape.core.part(place)[2] for place in range(shape.core.places)} >= set(range(700))
    whole = pc.Polytope(shape)
    assert all(pc.intersects(pc.Polytope(p[None]), whole) for p in np.unique(at, axis=0))


def test_cells_of_any_size_are_found() -> None:
    rng = np.random.default_rng(2)
    sizes = 2 ** rng.integers(0, 4, size=60)
    keys = np.unique(rng.integers(0, 8, size=(60, 3)), axis=0) * 8
    sizes = sizes[: len(keys)]
    whole = pc.Polytope(pc.Octree.from_cells(keys, 0.25, sizes))
    for corner in (keys + np.eye(3, dtype=int)[rng.integers(0, 3, len(keys))] * sizes[:, None], keys + sizes[:, None]):
        assert all(pc.intersects(pc.Polytope(0.25 * p[None]), whole) for p in corner)


def test_points_at_the_sides_of_the_boxes_of_a_tree_are_found() -> None:
    """Of radii that no rounding of boxes inwards would leave room for."""
    at = np.random.default_rng(8).uniform(-1, 1, size=(150, 3))
    whole = pc.Polytope(pc.PointCloud(at, 1e-12))
    assert all(pc.intersects(pc.Polytope(p[None]), whole) for p in at)


def test_an_empty_cloud_collides_with_nothing() -> None:
    empty = pc.PointCloud(np.zeros((0, 3)), 0.1)
    assert not pc.intersects(pc.Box((1.0, 1.0, 1.0)), empty)
    scene = pc.Scene()
    scene.add("camera", empty, None)
    robot = pc.Robot.load("panda")
    q = robot.random_configurations(200, seed=1)
    assert np.array_equal(pc.Checker(robot, scene).check_states(q), pc.Checker(robot, pc.Scene()).check_states(q))
