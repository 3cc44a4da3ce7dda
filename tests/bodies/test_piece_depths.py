"""Depths of solids and of two sets of parts, between bounds by convex pieces, against brute force."""

import numpy as np
import pytest
from part_oracle import DifferenceOracle
from poses import at, pose_at
from scipy.spatial import ConvexHull
from solid_meshes import angle, both, box, dimpled, ring

import plannercheck as pc

DIRECTIONS = np.random.default_rng(5).normal(size=(150, 3))
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1)[:, None]
CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])


def hull_mesh(points):
    """The vertices and outward triangles of a hull."""
    hull = ConvexHull(points)
    corners, triangles = points[hull.vertices], np.searchsorted(hull.vertices, hull.simplices)
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    inward = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(axis=1) < 0
    triangles[inward, 1:] = triangles[inward, :0:-1]
    return corners, triangles


def stones(rng):
    """A solid of some hulls that may cross, and the hulls."""
    hulls = [
        rng.normal(size=3) * 0.5 + rng.normal(size=(int(rng.integers(4, 9)), 3)) * 0.3
        for _ in range(rng.integers(2, 5))
    ]
    meshes = [hull_mesh(points) for points in hulls]
    mesh = meshes[0]
    for other in meshes[1:]:
        mesh = both(mesh, other)
    return pc.Solid(*mesh), hulls


def corner(_):
    """An L, and the two boxes that it is made of."""
    boxes = np.array([[0.0, 0, 0], [3, 1, 1]]), np.array([[0.0, 0, 0], [1, 2, 1]])
    return pc.Solid(0.4 * angle()[0], angle()[1]), [0.4 * np.where(CORNERS, high, low) for low, high in boxes]


def grid(rng):
    """A grid, and its cells."""
    occupied = rng.random((2, 2, 3)) < 0.6
    return pc.VoxelGrid(occupied, 0.3, (-0.3, -0.3, -0.45)), [
        0.3 * (np.array(cell) + CORNERS) - (0.3, 0.3, 0.45) for cell in np.argwhere(occupied)
    ]


def stone(rng):
    points = 0.4 * rng.normal(size=(12, 3))
    return pc.Hull(points), [points]


BODIES = {"stones": stones, "corner": corner, "grid": grid, "stone": stone}
PAIRS = [
    ("stones", "stones"),
    ("stones", "corner"),
    ("stones", "grid"),
    ("stones", "stone"),
    ("corner", "corner"),
    ("corner", "grid"),
    ("corner", "stone"),
    ("grid", "grid"),
    ("grid", "stone"),
]


def judge(bodies, hulls, poses):
    """Whether the bounds meet, of bodies that overlap; None of others."""
    found = pc.depth(*bodies, *poses)
    if found.depth == 0:
        return None
    posed = [
        [points @ pose[:3, :3].T + pose[:3, 3] for points in some] for some, pose in zip(hulls, poses, strict=True)
    ]
    oracle = DifferenceOracle(*posed)
    assert found.lower_bound <= oracle.depth_estimate(DIRECTIONS) + 1e-12
    assert oracle.exits(found.direction[None])[0] <= found.depth + 1e-12
    signed = pc.signed_distance(*bodies, *poses)
    assert (signed.lower_bound, 0 - signed.distance) == (-found.depth, found.lower_bound)
    np.testing.assert_allclose(signed.point_r - signed.point_p, found.depth * found.direction, atol=1e-12)
    return found.depth - found.lower_bound < 1e-9


@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_no_sampled_translation_is_shorter_than_the_lower_bound(first, second):
    rng = np.random.default_rng(sum(map(ord, first + second)))
    met = []
    for _ in range(8):
        (p, hulls_p), (r, hulls_r) = BODIES[first](rng), BODIES[second](rng)
        met.append(judge((p, r), (hulls_p, hulls_r), (pose_at(rng, rng.uniform(0, 1.2)), pose_at(rng, 0))))
    assert any(found is not None for found in met)


@pytest.mark.parametrize(("first", "second"), [("stones", "stones"), ("grid", "grid"), ("stones", "grid")])
def test_depths_are_exact_where_one_pair_of_pieces_leaves_last(first, second):
    """Near contact only one pair overlaps."""
    rng, met = np.random.default_rng(3), []
    for _ in range(6):
        (p, hulls_p), (r, hulls_r) = BODIES[first](rng), BODIES[second](rng)
        pose = pose_at(rng, 3)
        way = pose[:3, 3] / 3
        for _ in range(100):  # until they nearly touch, or the first one is past the second
            pose[:3, 3] -= min(pc.distance(p, r, pose).distance, 0.2) * way
        pose[:3, 3] -= 1e-3 * way
        met.append(judge((p, r), (hulls_p, hulls_r), (pose, np.eye(4))))
    assert met.count(True) >= 3
    assert met.count(False) <= 1


def cube(half, place=(0.0, 0.0, 0.0)):
    points, triangles = box(half)
    return points + place, triangles


@pytest.mark.parametrize("side", [1, -1])
def test_the_deepest_piece_counts(side):
    """Two cubes in a slab, 0.05 and 0.15 deep."""
    cubes = cube(0.1), cube(0.1, (0.5 * side, 0.0, 0.1))
    found = pc.depth(pc.Solid(*both(*cubes)), pc.Box((4, 4, 2)), at(0.0, 0.0, 0.95))
    assert found.lower_bound == pytest.approx(0.15, abs=1e-12)
    assert found.depth == pytest.approx(0.15, abs=1e-12)


def test_solids_in_cavities_do_not_overlap_and_in_walls_do():
    """A cavity of half edge 0.6 in a cube of half edge 1."""
    hollow, small = pc.Solid(*both(box(), box(0.6), flipped=True)), pc.Solid(*both(cube(0.1), cube(0.05, (0.3, 0, 0))))
    assert pc.depth(small, hollow).depth == 0
    assert pc.signed_distance(small, hollow).distance == pytest.approx(0.25, abs=1e-12)
    found = pc.depth(small, hollow, at(0.8, 0.0, 0.0))
    # the larger cube is from 0.7 to 0.9 in a wall from 0.6 to 1
    assert 0.09 < found.lower_bound <= 0.3 <= found.depth <= 0.3 + 1e-6
    found = pc.depth(small, hollow, at(0.55, 0.0, 0.0))  # 0.3 into the cavity, 0.55 out of the wall
    assert 0.04 < found.lower_bound <= 0.3 <= found.depth <= 0.3 + 1e-6


def test_a_solid_within_another_one():
    """No surfaces cross; the way out is through the nearest face."""
    outer, inner = pc.Solid(*dimpled(0.2)), pc.Solid(*both(cube(0.1), cube(0.1, (0.3, 0, 0))))
    found = pc.depth(inner, outer, at(0.4, 0.0, 0.0))
    # the second cube's left face is at 0.6, the first one's at 0.3
    assert 0.2 < found.lower_bound <= 0.7 <= found.depth < 0.7 + 1e-6
    np.testing.assert_allclose(found.direction, [1, 0, 0], atol=1e-6)


def test_surfaces_are_their_triangles():
    """Two sheets that cross have the depth of what sticks through."""
    sheet = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]])
    flat = pc.Solid(*both(sheet, (sheet[0] + (0, 0, 5), sheet[1])), open="triangles")
    upright = at(0.2, 0.5, -0.25, turn=[[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    found = pc.depth(flat, flat, upright)
    assert found.depth == pytest.approx(0.25, abs=1e-9)
    assert 0 < found.lower_bound <= found.depth


def test_rings_that_are_linked_have_a_way_out():
    """No piece of a ring is known; triangles bound the depth from below, translations from above."""
    solid = pc.Solid(*ring(9, 5, 0.3))
    upright = at(0.4, 0.0, 0.0, turn=[[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    found = pc.depth(solid, solid, upright)
    assert 0 < found.lower_bound < found.depth < 0.6
    upright[:3, 3] += (1 + 1e-9) * found.depth * found.direction
    assert not pc.intersects(solid, solid, upright)
