"""Contact by construction: each obstacle touches a link at a state chosen first; every way of asking finds it.

Obstacles are small, so no ball's slack hides a bound that is too narrow; their numbers are those at which an eight, the
lists of eights and the tree begin. What does not touch is known from exact arithmetic without any filter.
"""

import numpy as np
import pytest
from random_trees import limit_states, random_tree

import plannercheck as pc

UNFILTERED = {"method": "exact", "bounds": False, "boxes": False, "overlaps": False, "learning": False, "reach": False}


def touched_at(rng, robot, q, size):
    """A scene with one obstacle a configuration, about the middle of a body that goes places; of all kinds."""
    scene, poses = pc.Scene("touched"), robot.link_poses(q)
    bodies = [(robot.link_index(body.link), body.pose[:, 3]) for body in robot.bodies]
    somewhere = robot.link_poses(robot.random_configurations(50, 0))
    moving = [k for k, (link, at) in enumerate(bodies) if np.ptp(somewhere[:, link] @ at, axis=0).max() > 0.2]
    for k, (link, at) in enumerate(bodies[i] for i in rng.choice(moving, len(q))):
        pose = np.eye(4)
        pose[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        pose[:3, 0] *= np.sign(np.linalg.det(pose[:3, :3]))
        pose[:, 3] = poses[k, link] @ at
        if k % 3 == 0:
            scene.add_sphere(f"ball{k}", size / 2, pose)
        elif k % 3 == 1:
            scene.add_hull(f"flat{k}", size * np.array([[1.0, 0, 0], [-1, 1, 0], [-1, -1, 0], [1, 1, 0]]), pose)
        else:
            scene.add_box(f"box{k}", (size * rng.uniform(0.1, 1, 3)).tolist(), pose)
    return scene


@pytest.mark.parametrize("self_collision", [True, False])
@pytest.mark.parametrize(("count", "seed"), [(1, 0), (8, 1), (9, 2), (40, 3), (64, 4), (65, 5), (150, 6)])
def test_obstacles_are_found_where_they_touch(tmp_path, count, seed, self_collision):
    rng = np.random.default_rng(seed)
    robot = random_tree(rng, 3 + seed, sizes=(0.02, 0.03, 0.1), placed=True).robot(tmp_path)
    contacts = limit_states(rng, robot, count)
    scene = touched_at(rng, robot, contacts, 0.01)
    q = np.concatenate([contacts, robot.random_configurations(61, seed)])[rng.permutation(count + 61)]
    truth = pc.Checker(robot, scene, self_collision=self_collision, tuning=pc.Tuning(**UNFILTERED)).colliding_pairs(q)
    pairs_with_obstacles = truth[:, -count * (len(robot.link_names)) :]
    assert pairs_with_obstacles.any(axis=1).sum() >= count
    assert not truth.any(axis=1).all()
    checker = pc.Checker(robot, scene, self_collision=self_collision)
    np.testing.assert_array_equal(checker.colliding_pairs(q), truth)
    first = np.where(truth.any(axis=1), truth.argmax(axis=1), -1)
    for size in (1, 2, 3, 5, 8, 17, len(q)):
        for parts in (range(0, len(q), size),):
            found = np.concatenate([checker.check_states(q[k : k + size]) for k in parts])
            np.testing.assert_array_equal(found, first < 0)
            found = np.concatenate([checker.first_colliding_pair(q[k : k + size]) for k in parts])
            np.testing.assert_array_equal(found, first)
    assert [checker.is_valid(row) for row in q] == (first < 0).tolist()
    for switch in ("bounds", "boxes", "overlaps", "learning"):
        other = pc.Checker(robot, scene, self_collision=self_collision, tuning=pc.Tuning(**{switch: False}))
        np.testing.assert_array_equal(other.check_states(q[::-1]), first[::-1] < 0)


@pytest.mark.parametrize("seed", range(3))
def test_contacts_far_from_the_origin_and_of_single_pairs(tmp_path, seed):
    """One obstacle at a time, so that each pair is the first of its table, and the robot 1 km away from it."""
    rng = np.random.default_rng(20 + seed)
    robot = random_tree(rng, 4, sizes=(0.02,) * 3, reach=1.0 if seed == 0 else 300.0).robot(tmp_path)
    for q in limit_states(rng, robot, 12):
        scene = touched_at(rng, robot, q[None], 1e-3)
        checker = pc.Checker(robot, scene, self_collision=False)
        assert not checker.is_valid(q)
        for size in (2, 3, 8, 9):
            assert not checker.check_states(np.repeat(q[None], size, axis=0)).any()


def test_small_bodies_that_pass_each_other_far_from_the_origin_are_free(tmp_path):
    """Bodies of 0.1 mm some millimetres apart, a kilometre away: floats there are 0.06 mm apart, their bounds wider."""
    rng = np.random.default_rng(5)
    robot = random_tree(rng, 4, sizes=(1e-4,) * 3, reach=1000.0).robot(tmp_path)
    free = 0
    for q in limit_states(rng, robot, 12):
        scene, poses = pc.Scene("near"), robot.link_poses(q)
        for k in range(1, 5):
            pose, away = np.eye(4), rng.normal(size=3)
            pose[:3, 3] = poses[k, :3, 3] + rng.uniform(3e-4, 8e-3) * away / np.linalg.norm(away)
            scene.add_box(f"box{k}", [1e-4] * 3, pose)
        truth = pc.Checker(robot, scene, tuning=pc.Tuning(**UNFILTERED)).check_states(q[None])[0]
        checker = pc.Checker(robot, scene)
        assert checker.is_valid(q) == truth
        assert (checker.check_states(np.repeat(q[None], 9, axis=0)) == truth).all()
        free += truth
    assert free > 6
