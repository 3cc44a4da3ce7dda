"""Extreme vertices found by cells of directions, against all vertices in integers and against hierarchies."""

import itertools
import subprocess
import sys

import numpy as np
import pytest
from exact_points import integers

import plannercheck as pc
from plannercheck.evaluation.stress.body_families import family, rim_points

SIZES = (65, 100, 257, 512, 513, 1500)
FAMILIES = ("round", "prism", "cone", "fan", "needle", "lattice", "flat", "polygon", "tilted polygon")
PLACES = {"at the origin": 0.0, "far off": np.array([1e6, -1e6, 1e6])}


def points_of(name, n):
    if name == "polygon":
        return np.column_stack([rim_points(n, 0.3), np.zeros(n)])
    if name == "tilted polygon":  # in x + y + z = 0, exactly: its normal is a corner of the cells' cube
        rim = np.round(rim_points(n, 0.3) * 2**26) / 2**26
        return np.column_stack([rim, -rim.sum(axis=1)])
    return family(name, n, seed=n)


def random_directions(rng, k):
    return rng.normal(size=(k, 3))


def axis_directions():
    return np.array([u for u in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(u)])


def border_directions(rng, k):
    """The largest entry 1, the others multiples of 1/8 to 1/64, or their neighbours among doubles."""
    steps = rng.choice([8, 16, 32, 64], size=(k, 1))
    directions = np.round(rng.uniform(-1, 1, size=(k, 3)) * steps) / steps
    directions[np.arange(k), rng.integers(0, 3, k)] = rng.choice([-1.0, 1.0], k)
    beside = np.nextafter(directions, rng.choice([-2.0, 2.0], size=(k, 3)))
    return np.where(rng.integers(0, 2, size=(k, 1)) == 0, directions, np.where(np.abs(beside) <= 1, beside, directions))


def edge_directions(rng, k):
    """On the edges of the cube: the two largest entries are as long as each other, exactly."""
    directions = rng.uniform(-1, 1, size=(k, 3))
    largest = np.abs(directions).max(axis=1) * rng.choice([-1.0, 1.0], k)
    directions[np.arange(k), rng.integers(0, 3, k)] = largest
    directions[np.arange(k), rng.integers(0, 3, k)] = -largest
    return directions


def directions_across(points, rng, k):
    """At right angles to lines through two vertices, up to rounding: these tie, or nearly so."""
    first, second = points[rng.integers(0, len(points), (2, k))]
    return np.cross(second - first, rng.normal(size=(k, 3)))


def all_directions(points):
    rng = np.random.default_rng(len(points))
    unscaled = np.vstack(
        [
            random_directions(rng, 30),
            axis_directions(),
            border_directions(rng, 60),
            edge_directions(rng, 20),
            directions_across(points, rng, 30),
        ]
    )
    some = unscaled[rng.integers(0, len(unscaled), (4, 12))]
    scaled = [rows * scale for rows, scale in zip(some, (5e-324 * 2**12, 1e-300, 1e-20, 1e300), strict=True)]
    return np.vstack([unscaled, *scaled])


def assert_furthest(body, points, of_polar, directions):
    """No vertex is further along a direction than the one found: exactly, so ties may go to any.

    Those that are nearer by far more than doubles are off are left out.
    """
    corners = integers(points)
    found = np.asarray(body.extremes(directions, of_polar)[0])
    rough = directions / np.abs(directions).max(axis=1, initial=5e-324, keepdims=True) @ points.T
    for direction, vertex, heights in zip(directions, found.tolist(), rough, strict=True):
        products = corners[heights >= heights[vertex] - 1e-12 * np.abs(points).max()] @ integers(direction)[0]
        assert corners[vertex] @ integers(direction)[0] == products.max(), direction


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("name", FAMILIES)
def test_no_vertex_is_further_than_the_one_found(name, n, place):
    body = pc.Polytope(points_of(name, n) + PLACES[place]).core
    points = np.asarray(body.vertices())
    assert_furthest(body, points, False, all_directions(points))
    polar = np.asarray(body.polar_points())
    if len(polar) > 0:
        assert_furthest(body, polar, True, all_directions(polar))


@pytest.mark.parametrize("n", SIZES)
def test_a_direction_without_length_finds_a_vertex(n):
    body = pc.Polytope(family("round", n, seed=n)).core
    zeros = np.array([[0.0, 0.0, 0.0], [-0.0, 0.0, -0.0]])
    for of_polar in (False, True):
        found, _ = body.extremes(zeros, of_polar)
        assert set(found.tolist()) <= set(range(len(body.polar_points() if of_polar else body.vertices())))


@pytest.mark.parametrize("n", SIZES)
def test_few_vertices_are_looked_at(n):
    """Four blocks of eight vertices at a time, mostly once or twice; walks of hierarchies look at any number."""
    body = pc.Polytope(family("round", n, seed=n)).core
    blocks = body.extremes(random_directions(np.random.default_rng(5), 500), False)[1]
    assert (blocks % 8 == 0).all()
    assert np.median(blocks) <= 16


def vertices_looked_at(body, directions, of_polar=False):
    return 4 * np.asarray(body.extremes(directions, of_polar)[1])


@pytest.mark.parametrize(
    ("name", "n"), [("round", 5000), ("round", 20000), ("prism", 3000), ("cone", 3000), ("needle", 3000)]
)
def test_cells_and_hierarchies_agree(name, n):
    """Exactly: where they find different vertices, these are equally far."""
    body = pc.Polytope(points_of(name, n) * np.array([1, 0.7, 0.5])).core
    plain, rng = body.without_cells(), np.random.default_rng(n)
    for of_polar, points in ((False, np.asarray(body.vertices())), (True, np.asarray(body.polar_points()))):
        directions = np.vstack(
            [
                random_directions(rng, 2000),
                border_directions(rng, 2000),
                edge_directions(rng, 500),
                directions_across(points, rng, 500),
            ]
        )
        found, others = (np.asarray(one.extremes(directions, of_polar)[0]) for one in (body, plain))
        for k in np.flatnonzero(found != others):
            both = integers(points[[found[k], others[k]]]) @ integers(directions[k])[0]
            assert both[0] == both[1], directions[k]


def test_looking_at_cells_takes_as_long_for_large_bodies():
    """Hierarchies look at more vertices the more there are, cells do not."""
    sizes = (1000, 6000, 30000)
    directions = random_directions(np.random.default_rng(1), 2000)
    bodies = [pc.Polytope(family("round", n, seed=n) * np.array([1, 0.7, 0.5])).core for n in sizes]
    means = [vertices_looked_at(body, directions).mean() for body in bodies]
    assert max(means) < 2 * min(means)
    assert all(vertices_looked_at(body.without_cells(), directions).mean() > 1.2 * max(means) for body in bodies[1:])


def test_a_body_of_which_a_cell_would_hold_too_much_has_none():
    """Of a polygon's 3,000 corners a thousand may be extreme about its normal; a hierarchy looks at a few."""
    assert_no_cells(pc.Polytope(points_of("polygon", 3000)).core)


THIN = """
import resource, sys
import plannercheck as pc
from plannercheck.evaluation.stress.body_families import family

points = family("round", 60_000, 1) * [1, 1, float(sys.argv[1])]
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
body = pc.Polytope(points)
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024 / body.nbytes)
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="counts memory in kB")
def test_thin_bodies_are_not_prepared_in_vain():
    """Floats can't tell most of their vertices apart in a cell; the first such cell ends the division of the cube."""
    run = subprocess.run([sys.executable, "-c", THIN, "1e-6"], capture_output=True, text=True, check=True)
    assert float(run.stdout) < 5  # times the memory of the body


def assert_no_cells(body):
    near_normal = np.array([1e-6, 1e-6, 1.0]) * random_directions(np.random.default_rng(1), 200)
    assert vertices_looked_at(body, near_normal).max() < 400
    np.testing.assert_array_equal(
        vertices_looked_at(body, near_normal), vertices_looked_at(body.without_cells(), near_normal)
    )
