"""Depths of overlapping bodies: known ones, against all facets' and edges' directions, and against translations."""

import itertools

import numpy as np
import pytest
from poses import at, pose_at
from scipy.spatial import ConvexHull
from solid_meshes import angle

import plannercheck as pc
from plannercheck.common.core import core
from plannercheck.evaluation.stress.body_families import family

CUBE = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
FAMILIES = [("box", 8), ("round", 20), ("cloud", 60), ("needle", 20), ("flat", 30), ("prism", 24)]


def widths(first, second, poses):
    """Normals of facets and products of edges, and how far the bodies are in each other along each."""
    points, normals, edges = [], [], []
    for body, pose in zip((first, second), poses, strict=True):
        points.append(body.vertices @ pose[:3, :3].T + pose[:3, 3])
        a, b, c = (points[-1][body.faces[:, k]] for k in range(3))
        normals += [np.cross(b - a, c - a), -np.cross(b - a, c - a)]
        edges.append(np.concatenate([b - a, c - b, a - c]))
    products = np.cross(edges[0][:, None], edges[1]).reshape(-1, 3)
    directions = np.concatenate([*normals, products, -products])
    lengths = np.linalg.norm(directions, axis=1)
    clear = lengths > 1e-9 * lengths.max()
    directions = directions[clear] / lengths[clear, None]
    return directions, (points[1] @ directions.T).max(axis=0) - (points[0] @ directions.T).min(axis=0)


def by_all_directions(first, second, poses):
    """The least of them: in the direction that parts the first body from the second."""
    return float(widths(second, first, poses[::-1])[1].min())


@pytest.mark.parametrize(("name", "n"), FAMILIES)
def test_depths_are_least(name, n):
    rng = np.random.default_rng(n)
    for other, m in FAMILIES:
        first, second = pc.Polytope(family(name, n, 1)), pc.Polytope(family(other, m, 2))
        poses = pose_at(rng, 0.3), pose_at(rng, 0.0)
        found = pc.depth(first, second, *poses)
        if not pc.intersects(first, second, *poses):
            assert found.depth == found.lower_bound == 0
            continue
        assert found.depth == pytest.approx(by_all_directions(first, second, poses), abs=1e-12)
        assert found.depth - 1e-12 <= found.lower_bound <= found.depth
        assert found.depth <= -pc.distance(first, second, *poses).lower_bound + 1e-12
        for factor, shared in ((1 - 1e-9, True), (1 + 1e-9, False)):
            moved = poses[0].copy()
            moved[:3, 3] += factor * found.depth * found.direction
            assert pc.intersects(first, second, moved, poses[1]) == shared


def test_edges_of_cubes():
    """Two cubes edge to edge: the way out is along the product of both edges, which `distance` does not try."""
    turn = np.eye(4)
    c = np.sqrt(0.5)
    turn[:3, :3] = [[c, -c, 0], [c, c, 0], [0, 0, 1]]
    tilt = np.eye(4)
    tilt[:3, :3] = [[c, 0, c], [0, 1, 0], [-c, 0, c]]
    first, second = pc.Polytope(CUBE - 0.5), pc.Polytope(CUBE - 0.5)
    pose = turn @ tilt  # an edge below
    pose_r = tilt.copy()
    pose[2, 3] = 1.35
    found = pc.depth(first, second, pose, pose_r)
    if found.depth > 0:
        assert found.depth == pytest.approx(by_all_directions(first, second, (pose, pose_r)), abs=1e-12)
    assert found.depth > 0


def test_inflation_radii_add():
    cube = pc.Polytope(CUBE, inflation_radius=0.1)
    pose = at(0.7)
    assert pc.depth(cube, cube, pose).depth == pytest.approx(0.5, abs=1e-13)
    pose[0, 3] = 1.15
    found = pc.depth(cube, cube, pose)
    assert found.depth == pytest.approx(0.05, abs=1e-13)
    assert found.lower_bound == pytest.approx(0.05, abs=1e-13)
    ball = pc.Polytope([[0.0, 0, 0]], inflation_radius=1.0)
    assert pc.depth(ball, ball, pose).depth == pytest.approx(0.85, abs=1e-13)
    pose[0, 3] = 1.21
    assert pc.depth(cube, cube, pose).depth == 0


def test_flat_bodies():
    """Two plates in one plane are parted by nothing at all; crossing ones by what sticks through."""
    plate = pc.Polytope([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    pose = at(0.3)
    assert pc.depth(plate, plate, pose).depth == pytest.approx(0.0, abs=1e-13)
    upright = np.eye(4)
    upright[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    upright[:3, 3] = 0.2, 0.5, -0.25
    found = pc.depth(plate, plate, upright)
    assert found.depth == pytest.approx(0.25, abs=1e-13)


def test_touching_is_no_depth():
    cube = pc.Polytope(CUBE)
    pose = at(1.0)
    assert pc.intersects(cube, cube, pose)
    assert pc.depth(cube, cube, pose).depth == pytest.approx(0.0, abs=1e-13)


def test_large_bodies():
    """Of hulls whose differences are too many for a hull: bounds that meet, and no direction beats them."""
    rng = np.random.default_rng(11)
    directions = rng.normal(size=(10_000, 3))
    for name, n, other, m in (
        ("round", 3000, "round", 1000),
        ("cloud", 3000, "needle", 500),
        ("flat", 800, "cone", 150),
    ):
        first, second = pc.Polytope(family(name, n, 1)), pc.Polytope(family(other, m, 2))
        poses = pose_at(rng, 0.1), pose_at(rng, 0.0)
        found = pc.depth(first, second, *poses)
        assert 0 < found.depth - found.lower_bound < 1e-12
        points = [
            body.vertices @ pose[:3, :3].T + pose[:3, 3] for body, pose in zip((first, second), poses, strict=True)
        ]
        near = found.direction + 1e-3 * rng.normal(size=(1000, 3))
        tried = np.concatenate([directions, near, found.direction[None]])
        tried /= np.linalg.norm(tried, axis=1)[:, None]
        along = (points[1] @ tried.T).max(axis=0) - (points[0] @ tried.T).min(axis=0)
        assert along.min() >= found.lower_bound - 1e-14
        assert along[-1] <= found.depth + 1e-14


@pytest.mark.parametrize(("name", "n"), FAMILIES)
def test_depths_are_those_of_the_hull_of_all_differences(name, n):
    """By brute force: the least height of the facets of the hull of all differences of vertices."""
    rng = np.random.default_rng(100 + n)
    for (other, m), distance in itertools.product(FAMILIES, (0.0, 0.2)):
        first, second = pc.Polytope(family(name, n, 1)), pc.Polytope(family(other, m, 2))
        poses = pose_at(rng, distance), pose_at(rng, 0.0)
        if not pc.intersects(first, second, *poses):
            continue
        on_p, on_r = (b.vertices @ m[:3, :3].T + m[:3, 3] for b, m in zip((first, second), poses, strict=True))
        depth = -ConvexHull((on_p[:, None] - on_r).reshape(-1, 3)).equations[:, 3].max()
        found = pc.depth(first, second, *poses)
        assert found.lower_bound - 1e-13 <= depth <= found.depth + 1e-13
        assert found.depth - found.lower_bound < 1e-12


def test_exact_hulls_and_doubles_agree():
    """The path for polytopes that doubles do not tell, on bodies that seldom need it."""
    rng = np.random.default_rng(12)
    for (name, n), (other, m) in itertools.product(FAMILIES, repeat=2):
        first, second = pc.Polytope(family(name, n, 3)), pc.Polytope(family(other, m, 4))
        poses = pose_at(rng, 0.05), pose_at(rng, 0.0)
        if not pc.intersects(first, second, *poses):
            continue
        given = first.core, poses[0][None], second.core, poses[1][None]
        (lower, upper), (exact_lower, exact_upper) = (core.hull_depth(*given, doubles) for doubles in (True, False))
        assert max(lower, exact_lower) <= min(upper, exact_upper)
        assert max(upper - lower, exact_upper - exact_lower) < 1e-12


@pytest.mark.parametrize("exponent", [-1000, -300, 150])
def test_depths_scale(exponent):
    """Bodies, poses and depths in units of a power of two."""
    rng = np.random.default_rng(13)
    for name, n in FAMILIES:
        points, poses = family(name, n, 5), [pose_at(rng, 0.05), pose_at(rng, 0.02)]
        found = pc.signed_distance(points, points, *poses)
        for pose in poses:
            pose[:3, 3] = np.ldexp(pose[:3, 3], exponent)
        scaled = pc.signed_distance(np.ldexp(points, exponent), np.ldexp(points, exponent), *poses)
        assert scaled.distance == pytest.approx(np.ldexp(found.distance, exponent), rel=1e-12, abs=0)
        assert scaled.lower_bound == pytest.approx(np.ldexp(found.lower_bound, exponent), rel=1e-12, abs=0)


def test_depth_into_a_half_space_is_minus_the_distance():
    floor = pc.HalfSpace((0, 0, 1), 0.0)
    box = pc.Box((1, 1, 1))
    found = pc.depth(box, floor, at(0, 0, 0.25))
    assert found.lower_bound == pytest.approx(0.25, abs=1e-13)
    assert found.lower_bound <= 0.25 <= found.depth
    np.testing.assert_allclose(found.direction, [0, 0, 1])


def test_distances_of_overlapping_solids_and_sets_claim_no_depth():
    """Their hulls' depth separates them; `depth` looks at their pieces as well."""
    cloud, box = pc.PointCloud([[0.0, 0, 0], [1, 0, 0]], 0.1), pc.Box((1, 1, 1))
    solid = pc.Polytope(pc.Solid(*angle()))
    for first, second, least in ((cloud, cloud, 0.2), (solid, box, 0.5)):
        assert pc.distance(first, second).distance == 0
        found = pc.depth(first, second)
        assert found.lower_bound == pytest.approx(least, abs=1e-9)
        assert found.depth == pytest.approx(least, abs=1e-9)


@pytest.mark.parametrize("swapped", [False, True])
def test_a_set_of_parts_leaves_a_hull_with_its_deepest_part(swapped):
    """Exact where no other part is in the way; else the deepest part and a translation bound the depth."""
    box = pc.Box((1, 1, 1))
    for places, depth, translation in (
        ([[0.45, 0, 0], [-2, 0, 0], [0.52, 0.1, 0]], 0.15, 0.15),
        ([[0.45, 0, 0], [-0.45, 0, 0]], 0.15, 0.6),  # in the way of each other: out sideways
    ):
        bodies = [pc.PointCloud(places, 0.1), box]
        found = pc.depth(*(bodies[::-1] if swapped else bodies))
        assert found.lower_bound == pytest.approx(depth, abs=1e-12)
        assert found.depth == pytest.approx(translation, abs=1e-12 if translation == depth else 1e-5)  # a box's room
        away = found.direction * (-1 if swapped else 1)
        assert not pc.intersects(*bodies, at(*(1 + 1e-9) * found.depth * away))
        assert pc.intersects(*bodies, at(*(1 - 1e-9) * found.lower_bound * away))


def _exact_depth_bounds(first, second, pose, pose_r):
    """The depth of two posed hulls between fractions: along directions it is at most so much, and hulls prove it."""
    import mpmath

    mpmath.mp.prec = 200
    posed = []
    for body, matrix in ((first, pose), (second, pose_r)):
        points = []
        for v in body.vertices.tolist():
            points.append(
                [
                    sum(mpmath.mpf(matrix[i, k]) * mpmath.mpf(v[k]) for k in range(3)) + mpmath.mpf(matrix[i, 3])
                    for i in range(3)
                ]
            )
        posed.append(points)
    return posed


def _width(posed, direction):
    """How far the first body is in the second along a direction, in 200 bits."""
    import mpmath

    d = [mpmath.mpf(float(x)) for x in direction]
    length = mpmath.sqrt(sum(x * x for x in d))
    along = [[sum(a * b for a, b in zip(d, p, strict=True)) for p in points] for points in posed]
    return (max(along[1]) - min(along[0])) / length


def test_both_bounds_are_proved():
    """Against 200 bits: the depth is enough along its direction, and no direction that is tried needs less."""
    rng = np.random.default_rng(17)
    for k in range(60):
        (name, n), (other, m) = (FAMILIES[i] for i in rng.integers(0, len(FAMILIES), 2))
        inflation_radius = 0.0 if k % 3 else float(rng.uniform(0, 0.2))
        first, second = (
            pc.Polytope(family(name, n, k), inflation_radius=inflation_radius),
            pc.Polytope(family(other, m, k + 1)),
        )
        poses = pose_at(rng, float(rng.uniform(0, 0.6))), pose_at(rng, 0.0)
        found = pc.depth(first, second, *poses)
        if found.depth == 0:
            continue
        assert found.lower_bound <= found.depth
        posed = _exact_depth_bounds(first, second, *poses)
        assert found.depth >= _width(posed, found.direction) + inflation_radius
        tried = by_all_directions_of(first, second, poses)
        least = min(_width(posed, d) for d in tried)
        if least > 0:  # the hulls overlap, and some direction of these is the way out
            assert found.lower_bound <= least + inflation_radius


def by_all_directions_of(first, second, poses):
    """The few directions along which the bodies are least in each other."""
    directions, along = widths(first, second, poses)
    return directions[np.argsort(along)[:5]]


@pytest.mark.parametrize("gap", [1e-3, 0.05, 0.19])
def test_the_depth_of_inflated_bodies_whose_hulls_are_apart(gap):
    cube = pc.Polytope(CUBE, inflation_radius=0.1)
    pose = at(1 + gap)
    found = pc.depth(cube, cube, pose)
    assert found.lower_bound < 0.2 - (pose[0, 3] - 1) < found.depth  # the depth in fractions is between doubles
    assert found.depth - found.lower_bound < 1e-12


def test_needles_of_the_hull_of_differences():
    """A triangle with a normal of few digits must not raise the lower bound."""
    rng = np.random.default_rng(7)
    for thin in (1e-5, 1e-6, 1e-7, 1e-8, 1e-9):
        for k in range(20):
            first = pc.Polytope(family("round", 12, k) * [1, 1, 1 + thin])
            tilt = np.eye(4)
            tilt[:3, :3] = [[1, -thin, 0], [thin, 1, 0], [0, 0, 1]]
            pose = pose_at(rng, 0.2)
            second = pc.Polytope(family("round", 12, k) @ tilt[:3, :3].T)
            found = pc.depth(first, second, pose, pose)
            posed = _exact_depth_bounds(first, second, pose, pose)
            least = min(_width(posed, d) for d in by_all_directions_of(first, second, (pose, pose)))
            assert found.lower_bound <= least
            assert found.depth >= _width(posed, found.direction)
