"""Clearance grids against the parts that they stand for, and the balls that together hold a hull."""

import itertools

import numpy as np
import pytest
from poses import pose_at

import plannercheck as pc
from plannercheck.bodies.part_sets import PartSet
from plannercheck.common.array_types import Floats
from plannercheck.common.core import core

FURTHEST = 11  # steps that are looked for


def cloud(rng: np.random.Generator, many_radii: bool) -> PartSet:
    points = rng.uniform(-0.5, 0.5, size=(800, 3)) * [1.0, 0.7, 0.05]
    return pc.PointCloud(points, rng.uniform(0.001, 0.03, size=800) if many_radii else 0.03)


def cells(rng: np.random.Generator) -> PartSet:
    return pc.VoxelGrid(rng.random((12, 9, 7)) < 0.05, 0.07, [-0.4, -0.3, -0.2])


def ground(rng: np.random.Generator) -> PartSet:
    return pc.HeightField(rng.uniform(0.0, 0.3, size=(9, 12)), (0.11, 0.08), -0.1, (-0.4, -0.4))


SHAPES = {
    "one radius": lambda rng: cloud(rng, False),
    "many radii": lambda rng: cloud(rng, True),
    "cells": cells,
    "heights": ground,
}


def looked_up(shape: PartSet, pose: Floats, reach: float, points: Floats) -> Floats:
    """Lower bounds (n,) of how far points are from a posed set."""
    found = core.part_clearances(shape.core, pose, reach, points)
    assert found.shape == (len(points), 2)
    assert np.array_equal(found[:, 0], found[:, 1])  # alone, and in lanes
    return np.asarray(found[:, 0])


def at_most(shape: PartSet, pose: Floats, points: Floats, rng: np.random.Generator) -> Floats:
    """No less than the distances of points to a posed set, of balls the distances: by points of each part."""
    inside, radii = [], []
    for place in range(shape.core.places):
        corners, radius, _ = shape.core.part(place)
        if len(corners):
            mixtures = np.eye(len(corners))
            if len(corners) > 1:
                mixtures = np.concatenate([mixtures, rng.dirichlet(np.full(len(corners), 0.3), size=6)])
            inside.append(mixtures @ corners @ pose[:3, :3].T + pose[:3, 3])
            radii.append(np.full(len(mixtures), radius))
    away = np.linalg.norm(points[:, None] - np.concatenate(inside), axis=2) - np.concatenate(radii)
    return np.asarray(away.min(axis=1))


@pytest.mark.parametrize("kind", SHAPES)
@pytest.mark.parametrize("reach", [np.inf, 0.35, 0.1])
def test_no_point_is_nearer_than_its_clearance(kind: str, reach: float) -> None:
    """With and without sides beyond which parts are left out; points are on the sides of cells, too."""
    rng = np.random.default_rng(5)
    for turned in (False, True, True):
        shape, pose = SHAPES[kind](rng), pose_at(rng, 0.2) if turned else np.eye(4)
        points = rng.uniform(-1.2, 1.2, size=(600, 3))
        points[:300] = rng.uniform(-0.4, 0.4, size=(300, 3))
        points[250:350] = np.round(points[250:350], 2)
        found = looked_up(shape, pose, reach, points)
        assert (found <= at_most(shape, pose, points, rng) + 1e-12).all()
        assert np.isfinite(reach) or (found > 0.02).any()


@pytest.mark.parametrize("reach", [np.inf, 2.0])
def test_clearances_of_balls_are_nearly_their_distances(reach: float) -> None:
    rng = np.random.default_rng(6)
    shape, points = cloud(rng, False), rng.uniform(-0.5, 0.5, size=(1000, 3)) * [1.0, 0.7, 0.1]  # within the grid
    away = at_most(shape, np.eye(4), points, rng)
    found = looked_up(shape, np.eye(4), reach, points)
    step, radius = 0.01, 0.03  # of this set
    looked_for = np.minimum(away, FURTHEST * step - radius)
    assert (found > looked_for - 3.7 * step).all()  # up to two diagonals of a cell


def test_beyond_a_side_where_parts_are_left_out_nothing_is_clear() -> None:
    shape = pc.PointCloud([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]], 0.01)
    points = np.array([[0.3, 0.0, 0.0], [0.99, 0.0, 0.0], [1.5, 0.0, 0.0], [2.9, 0.0, 0.0], [-0.4, 0.0, 0.0]])
    found = looked_up(shape, np.eye(4), 1.0, points)
    assert found[0] > 0.05
    assert (found[1:4] <= 0).all()


def test_what_is_no_number_is_not_clear_of_anything_that_matters() -> None:
    shape = pc.PointCloud([[0.0, 0.0, 0.0]], 0.01)
    found = looked_up(shape, np.eye(4), 1.0, np.array([[np.nan, 0.0, 0.0], [np.inf, -np.inf, 1e300]]))
    assert np.isfinite(found).all()  # nothing is read beyond the grid


def test_sets_that_are_too_large_have_no_grid() -> None:
    shape = pc.PointCloud([[-50.0, -50.0, -50.0], [50.0, 50.0, 50.0]], 0.01)
    assert core.part_clearances(shape.core, np.eye(4), np.inf, np.zeros((1, 3))).shape == (0, 2)
    assert core.part_clearances(shape.core, np.eye(4), 1.0, np.zeros((1, 3))).shape == (1, 2)


SIZES = {"long": (0.1, 0.12, 0.5), "thin": (0.3, 0.02, 0.02), "small": (0.01, 0.01, 0.02), "round": (1.0, 1.0, 1.0)}


@pytest.mark.parametrize("few", [False, True])
@pytest.mark.parametrize("size", SIZES.values(), ids=SIZES)
def test_covering_balls_hold_the_hull(size: tuple[float, float, float], few: bool) -> None:
    rng = np.random.default_rng(7)
    for count in (2, 4, 40, 300):  # a segment, which is cut as well, and hulls
        points = rng.uniform(-0.5, 0.5, size=(count, 3)) * size
        balls = pc.Polytope(points).core.covering_balls(few)
        inside = np.concatenate([points, rng.dirichlet(np.full(count, 0.1), size=4000) @ points])
        gaps = np.linalg.norm(inside[:, None] - balls[:, :3], axis=2) - balls[:, 3]
        assert (gaps.min(axis=1) <= 1e-12).all()
        if count > 4 and size == SIZES["long"]:
            assert (
                balls[:, 3].max() < (0.7 if few else 0.5) * np.linalg.norm(inside - inside.mean(axis=0), axis=1).max()
            )


def test_a_few_balls_are_three_at_most_and_for_large_bodies_only() -> None:
    def balls_of(*size: float) -> int:
        corners = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))
        return len(pc.Polytope(corners * size).core.covering_balls(True))

    assert [balls_of(0.1, 0.1, length) for length in (0.1, 0.2, 0.3, 0.5, 2.0)] == [1, 1, 2, 2, 3]
    assert balls_of(0.01, 0.01, 0.06) == 1
