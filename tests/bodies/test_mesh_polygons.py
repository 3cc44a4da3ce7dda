"""Polygons of mesh files become triangles of the same area."""

import contextlib

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies.polygons import triangles_of_polygons


@pytest.mark.parametrize("corners", [5, 6, 9, 30])
@pytest.mark.parametrize("times", [1, 2, 3])
@pytest.mark.parametrize("seed", range(5))
def test_concave_polygons_keep_their_area(corners: int, times: int, seed: int) -> None:
    """Stars in any plane: the triangles' areas add up to the polygon's, by the shoelace formula; a fan's do not.

    Nor does it matter how often each corner is given.
    """
    random = np.random.default_rng(seed)
    angles = np.sort(random.uniform(0, 2 * np.pi, corners))
    angles = 2 * np.pi * np.arange(corners) / corners + 0 * angles
    radii = np.where(np.arange(corners) % 2, random.uniform(0.2, 0.5, corners), 2)
    flat = np.column_stack([radii * np.cos(angles), radii * np.sin(angles), np.zeros(corners)])
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    points = flat @ turn.T
    given = np.repeat(np.roll(np.arange(corners), seed), times)
    triangles = triangles_of_polygons(points, np.array([corners * times]), given)
    a, b, c = (flat[triangles[:, k]] for k in range(3))
    areas = np.cross(b - a, c - a)[:, 2] / 2
    x, y = flat[:, 0], flat[:, 1]
    assert (areas >= -1e-12).all()
    assert areas.sum() == pytest.approx((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2)


@pytest.mark.parametrize("depth", [0.0, 0.5])
def test_large_polygons_are_fans_where_fans_are_right(depth: float) -> None:
    """Rounded circles turn both ways, and so do circles with a notch that a fan would cover."""
    angles = 2 * np.pi * np.arange(3000) / 3000
    radii = np.where(np.arange(3000) == 1500, 1 - depth, 1.0)
    points = np.round(np.column_stack([radii * np.cos(angles), radii * np.sin(angles), 0 * angles]), 5)
    counts, corners = np.array([3000]), np.roll(np.arange(3000), 1400)
    if not depth:
        assert len(triangles_of_polygons(points, counts, corners)) == 2998
    else:
        with pytest.raises(pc.PlannercheckError, match=r"concave polygon of 3000 corners.*write triangles"):
            triangles_of_polygons(points, counts, corners)


@pytest.mark.parametrize(("height", "is_refused"), [(1.0, True), (0.0, False)])
def test_polygons_that_cross_themselves_are_refused(height: float, is_refused: bool) -> None:
    """One without area is next to nothing, and harmless."""
    corners = [[-2.0, 1], [1, 1], [2, -2], [0, 2], [-1, -2], [0, -2], [-1, 2]]
    points = np.array([[x, height * y, 0] for x, y in corners])
    with pytest.raises(pc.PlannercheckError, match="crosses itself") if is_refused else contextlib.nullcontext():
        triangles_of_polygons(points, np.array([7]), np.arange(7))
