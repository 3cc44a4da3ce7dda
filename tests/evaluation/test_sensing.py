"""Sensed scenes: rays meet what they look at, noise is what it says, maps hold the cells that were put into them."""

import numpy as np
import pytest
import trimesh
from poses import at
from scipy.spatial import ConvexHull

import plannercheck as pc
from plannercheck.evaluation.sensing.buildings import building, pruned
from plannercheck.evaluation.sensing.cameras import DepthCamera, looking
from plannercheck.evaluation.sensing.clouds import camera_poses, cloud, robot_bodies, scene_bodies
from plannercheck.evaluation.sensing.noise import DepthNoise
from plannercheck.evaluation.sensing.rays import depth_image
from plannercheck.evaluation.sensing.terrains import terrain

CAMERA = DepthCamera(80, 60)
PERFECT = DepthNoise(least=0, growth=0, dropouts=0, flying=0, step=0)


def seen(scene, eye, target=(0, 0, 0)):
    pose = looking(eye, target)
    depth = depth_image(scene_bodies(scene), CAMERA, pose)
    return depth, CAMERA.points(depth, pose)


def test_a_wall_is_as_deep_as_it_is_far():
    scene = pc.Scene()
    scene.add_box("wall", (0.2, 10, 10), at(3.0))
    depth, points = seen(scene, (1, 0, 0), (2, 0, 0))
    np.testing.assert_allclose(depth, 1.9, atol=1e-12)
    np.testing.assert_allclose(points[:, 0], 2.9, atol=1e-12)


def test_points_of_a_ball_are_on_it_and_it_hides_what_is_behind():
    scene = pc.Scene()
    scene.add_sphere("ball", 0.5)
    scene.add_box("behind", (0.3, 0.3, 0.3), at(-2.0))
    depth, points = seen(scene, (3, 0.4, 0.2))
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 0.5, atol=1e-12)
    assert 0.05 < (depth > 0).mean() < 0.5


def test_a_solid_is_seen_with_its_hole():
    ring = trimesh.creation.torus(0.5, 0.1, major_sections=24, minor_sections=8)
    scene = pc.Scene()
    scene.add("ring", pc.Solid(ring.vertices, ring.faces))
    depth, points = seen(scene, (0.3, 0.2, 2))
    pose = looking((0.3, 0.2, 2), (0, 0, 0))
    directions = CAMERA.directions.reshape(-1, 3) @ pose[:3, :3].T
    corner, along, across = (ring.triangles[:, 0], *(ring.triangles[:, k] - ring.triangles[:, 0] for k in (1, 2)))
    nearest = np.full(len(directions), np.inf)
    for a, u, v in zip(corner, along, across, strict=True):
        frames = np.stack([directions, *np.broadcast_arrays(-u, -v, directions)[:2]], axis=-1)
        t, x, y = np.linalg.solve(frames, np.broadcast_to((a - pose[:3, 3])[:, None], (len(directions), 3, 1)))[
            ..., 0
        ].T
        nearest = np.where((x >= 0) & (y >= 0) & (x + y <= 1) & (t > 0), np.minimum(nearest, t), nearest)
    expected = np.where(np.isfinite(nearest), nearest, 0).reshape(depth.shape)
    different = np.abs(depth - expected) > 1e-9
    assert different.mean() < 0.002  # rays through edges
    assert depth[30, 40] == 0
    assert len(points) > 100


def test_points_of_a_scene_are_on_its_bodies():
    scene = pc.Scene.load("bookshelf")
    points = cloud(scene_bodies(scene), 5000, 1, noise=PERFECT)
    assert points.shape == (5000, 3)
    nearest = np.full(len(points), np.inf)
    for body in scene.bodies:
        local = (points - body.pose[:3, 3]) @ body.pose[:3, :3]
        planes = ConvexHull(body.shape.vertices_and_faces(5e-3)[0]).equations
        nearest = np.minimum(nearest, np.abs((local @ planes[:, :3].T + planes[:, 3]).max(axis=1)))
    assert nearest.max() < 1e-9


def test_the_robot_hides_the_scene():
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("table"))
    robot = robot_bodies(checker.robot, checker.robot.reference)
    (pose, *_), camera = camera_poses(), DepthCamera(160, 120)
    alone = depth_image(scene_bodies(checker.scene), camera, pose)
    both = depth_image([*scene_bodies(checker.scene), *robot], camera, pose)
    of_robot = depth_image(robot, camera, pose)
    hidden = (of_robot > 0) & ((alone == 0) | (of_robot < alone))
    assert 0.005 < hidden.mean() < 0.5
    assert np.array_equal(both, np.where(hidden, of_robot, alone))


def test_noise_is_repeatable_and_as_large_as_it_says():
    depth = np.full((400, 500), 1.4)
    noise = DepthNoise(least=0.001, growth=0.002, dropouts=0.1, flying=0.0, step=0.0)
    shown = noise.of(depth, np.random.default_rng(3))
    assert np.array_equal(shown, noise.of(depth, np.random.default_rng(3)))
    assert abs((shown == 0).mean() - 0.1) < 0.01
    assert abs(shown[shown > 0].std() - 0.003) < 1e-4
    assert np.array_equal(PERFECT.of(depth, np.random.default_rng(0)), depth)
    steps = DepthNoise(step=0.001).of(depth, np.random.default_rng(0)) / 0.001
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)


def test_points_fly_at_edges_only():
    depth = np.full((50, 40), 1.0)
    depth[:, 20:] = 2.0
    shown = DepthNoise(least=0, growth=0, dropouts=0, flying=0.5, step=0).of(depth, np.random.default_rng(0))
    between = (shown > 1.001) & (shown < 1.999)
    assert between[:, 19].mean() > 0.2
    assert not np.delete(between, 19, axis=1).any()


def test_clouds_have_as_many_points_as_asked_and_their_seed():
    bodies = scene_bodies(pc.Scene.load("table"))
    first, again, other = (cloud(bodies, 3000, seed) for seed in (5, 5, 6))
    assert first.shape == (3000, 3)
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_cameras_that_see_nothing_are_refused():
    with pytest.raises(pc.PlannercheckError, match="the cameras see none of the bodies"):
        cloud([], 10, 0)


def small_cells(keys, sizes):
    """All cells of one step, one row each, as a sorted set."""
    parts = []
    for size in np.unique(sizes):
        inside = np.stack(np.meshgrid(*[np.arange(size)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        parts.append((keys[sizes == size][:, None] + inside).reshape(-1, 3))
    return np.concatenate(parts)


def test_pruning_keeps_the_cells_and_leaves_no_eight():
    rng = np.random.default_rng(0)
    full = rng.random((32, 32, 16)) < 0.9
    full[:16, :16] = True
    keys, sizes = pruned(np.argwhere(full).astype(np.int32))
    small = small_cells(keys, sizes)
    assert len(small) == full.sum() == len(np.unique(small, axis=0))
    assert full[tuple(small.T)].all()
    assert sizes.max() == 16
    assert (keys % sizes[:, None] == 0).all()
    for size in np.unique(sizes):
        _, counts = np.unique(keys[sizes == size] // (2 * size), axis=0, return_counts=True)
        assert counts.max() < 8


def test_a_building_has_storeys_walls_and_doors():
    cells = building(12, 8, 2, 0.1, seed=1)
    assert all(np.array_equal(a, b) for a, b in zip(cells, building(12, 8, 2, 0.1, seed=1), strict=True))
    small = small_cells(cells.keys, cells.sizes)
    assert len(np.unique(small, axis=0)) == len(small)
    share = np.bincount(small[:, 2], minlength=64) / (120 * 80)
    assert share[0] == share[32] == 1  # slabs
    assert 0.02 < share[31] < 0.2
    assert share[10] < 0.6
    high, low = (set(map(tuple, small[small[:, 2] == z][:, :2].tolist())) for z in (31, 10))
    doors = high - low
    assert len(doors) > 20


def test_terrain_is_continuous_and_as_high_as_asked():
    ground = terrain(256, 0, height=2.0)
    assert ground.shape == (256, 256)
    assert ground.min() == 0
    assert abs(ground.max() - 2) < 1e-12
    assert np.abs(np.diff(ground, axis=0)).max() < 0.2
    assert np.array_equal(ground, terrain(256, 0, height=2.0))
