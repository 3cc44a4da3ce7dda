"""Whether triangles lie in the union of convex pieces, beside fractions and rational barycentric coordinates."""

from fractions import Fraction

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies import exact_coverage
from plannercheck.bodies.exact_coverage import Parts, are_inside, uncovered

CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])


def inside_exactly(parts, points):
    """Every facet of the hull against every corner, all in fractions."""
    hull = pc.Polytope(points)
    facets = [[tuple(map(Fraction, hull.vertices[k].tolist())) for k in face] for face in np.asarray(hull.faces)]
    found = []
    for triangle, weights in zip(parts.triangles.tolist(), parts.weights.tolist(), strict=True):
        exact = [tuple(map(Fraction, corner)) for corner in triangle]
        corners = [
            tuple(sum(Fraction(w, parts.whole) * c[k] for w, c in zip(row, exact, strict=True)) for k in range(3))
            for row in weights
        ]
        found.append(all(side(facet, corner) <= 0 for facet in facets for corner in corners))
    return np.array(found)


def side(facet, point):
    (a, b, c) = facet
    u, v, w = ([p[k] - a[k] for k in range(3)] for p in (b, c, point))
    return w[0] * (u[1] * v[2] - u[2] * v[1]) + w[1] * (u[2] * v[0] - u[0] * v[2]) + w[2] * (u[0] * v[1] - u[1] * v[0])


@pytest.mark.parametrize("shift", [0.0, 7.3, 1e6])
def test_parts_in_a_hull_as_fractions_say(shift):
    """Corners on vertices, edges and facets, and a rounding beside them."""
    rng = np.random.default_rng(1)
    points = rng.normal(size=(12, 3)) + shift
    hull = pc.Polytope(points)
    vertices = np.asarray(hull.vertices)
    of_facets = vertices[np.asarray(hull.faces)]
    weights = rng.dirichlet(np.ones(3), (40, 3))
    on_facets = np.einsum("nck,nki->nci", weights, of_facets[rng.integers(len(of_facets), size=40)])
    drawn = np.concatenate([of_facets, on_facets, vertices[rng.integers(len(vertices), size=(20, 3))]])
    drawn = np.concatenate([drawn, np.nextafter(drawn, np.inf), drawn + rng.normal(size=drawn.shape)])
    parts = Parts.of(drawn)
    for _ in range(3):
        found = are_inside(parts, hull)
        np.testing.assert_array_equal(found, inside_exactly(parts, points))
        assert 0 < found.sum() < len(found)
        parts = parts.quartered().of_rows(rng.integers(4 * len(parts), size=150))


def test_the_plain_way_says_the_same(monkeypatch):
    """Signs of doubles that are all left to integers."""
    rng = np.random.default_rng(2)
    hull = pc.Polytope(rng.normal(size=(9, 3)))
    parts = Parts.of(rng.normal(size=(60, 3, 3)) * 0.6).quartered()
    fast = are_inside(parts, hull)
    monkeypatch.setattr(exact_coverage, "_SIDE_ERROR", 1e9)
    np.testing.assert_array_equal(are_inside(parts, hull), fast)
    assert fast.any()


def test_a_triangle_over_two_pieces_is_covered_if_they_overlap():
    """It crosses from one into the other: halves that meet in a plane that no cut lies in leave parts over."""
    triangle = np.array([[[0.1, 0.2, 0.5], [0.9, 0.3, 0.5], [0.4, 0.8, 0.5]]])
    left, right = CUBE * [0.43, 1, 1], CUBE * [0.6, 1, 1] + [0.4, 0, 0]
    assert uncovered(triangle, [left, right], 8).tolist() == []
    assert uncovered(triangle, [left], 8).tolist() == [0]
    gap = CUBE * [0.6, 1, 1] + [np.nextafter(0.43, 1), 0, 0]
    assert uncovered(triangle, [left, gap], 8).tolist() == [0]


def test_a_part_that_sticks_out_by_less_than_a_rounding_is_out():
    """The middle of an edge that ends one unit in the last place beyond a facet."""
    low = np.array([[[0.5, 0.5, 1.0], [0.5, 0.25, np.nextafter(1.0, 2)], [0.25, 0.25, 0.5]]])
    assert uncovered(low, [CUBE], 6).tolist() == [0]
    assert uncovered(np.minimum(low, 1.0), [CUBE], 6).tolist() == []


def test_flat_pieces_hold_nothing():
    assert uncovered(CUBE[None, [0, 1, 2]], [CUBE[[0, 1, 2, 3]]], 2).tolist() == [0]
