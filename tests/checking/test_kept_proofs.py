"""What is computed once a robot, kept from one checker to the next, or compiled: the same as computed anew, exactly."""

import pickle
import warnings

import numpy as np
import pytest
from plain_setup import assert_as_computed_anew, plain_pairs
from random_trees import random_tree

import plannercheck as pc
from plannercheck.bodies.objects import Part
from plannercheck.bodies.polytope import polytopes_of_boxes
from plannercheck.bodies.shapes import Box, Capsule, Cylinder, GeometryObject, Hull, Sphere
from plannercheck.checking import prepared_bodies, robot_reach
from plannercheck.checking.prepared_bodies import Preparation
from plannercheck.checking.reach_bounds import boxes_of
from plannercheck.robots import robot_memory
from plannercheck.robots.description import shipped_robots
from plannercheck.robots.loading import RobotParts
from plannercheck.scenes.scene import shipped_scenes


@pytest.fixture(autouse=True)
def quiet():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        yield


def at(rng, spread=0.8):
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    pose = np.eye(4)
    pose[:3, :3] = q * np.sign(np.diag(r)) * np.sign(np.linalg.det(q * np.sign(np.diag(r))))
    pose[:3, 3] = rng.uniform(-spread, spread, 3)
    return pose


def random_shape(rng):
    a, b, c = rng.uniform(0.02, 0.3, 3)
    return (Box((a, b, c)), Sphere(a), Cylinder(a, b), Capsule(a, b), Hull(rng.normal(size=(8, 3)) * a))[
        rng.integers(5)
    ]


@pytest.mark.parametrize("name", shipped_robots())
def test_shipped_robots_in_shipped_scenes(name):
    robot = pc.Robot.load(name)
    for k, scene in enumerate(map(pc.Scene.load, shipped_scenes())):
        checker = pc.Checker(robot, scene)
        assert [tuple(pair) for pair in checker.pairs.tolist()] == plain_pairs(checker.robot, checker.scene)
        if k < 1 or name == "panda":  # the others take a minute
            assert_as_computed_anew(checker)


@pytest.mark.parametrize("seed", range(10))
def test_random_trees_among_random_obstacles(tmp_path, seed):
    rng = np.random.default_rng(seed)
    tree = random_tree(rng, int(rng.integers(2, 9)), rng.uniform(1e-3, 0.3, 3), rng.uniform(0.05, 1), placed=True)
    robot, scene = tree.robot(tmp_path), pc.Scene("random")
    for k in range(30):
        scene.add(f"object {k}", random_shape(rng), at(rng, rng.choice([0.3, 2.0, 6.0])))
    assert_as_computed_anew(pc.Checker(robot, scene))
    assert_as_computed_anew(pc.Checker(robot, scene, padding=0.02))


@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_random_edits_one_after_the_other(name):
    rng = np.random.default_rng(7)
    robot, scene = pc.Robot.load(name), pc.Scene.load("bookshelf")
    checker, link = pc.Checker(robot, scene, padding=0.001), robot.bodies[-1].link
    for k in range(15):
        kind, names = rng.integers(6), checker.scene.object_names
        scene, attached = checker.scene.copy(), checker.scene.attached
        if kind == 0 or not names:
            scene.add(f"new {k}", [Part(random_shape(rng), at(rng, 0.1)) for _ in range(rng.integers(1, 3))], at(rng))
        elif kind == 1:
            scene.remove(rng.choice(names))
        elif kind == 2:
            scene.move(rng.choice(names), at(rng))
        elif kind == 3:
            scene.attach(f"held {k}", link, at(rng, 0.1), (), random_shape(rng))
        elif kind == 4 and attached:
            scene.detach(attached[0].name, at(rng))
        else:
            scene.allow(rng.choice(names), link, bool(rng.integers(2)))
        checker = checker.with_scene(scene)
        np.testing.assert_array_equal(checker.pairs, pc.Checker(pc.Robot.load(name), scene, padding=0.001).pairs)
        assert_as_computed_anew(checker)


@pytest.mark.parametrize(
    "padding", [{"panda_hand": 0.02}, {("panda_hand", "floor"): 0.03, "panda_link5": 0.01}, {"can_1": 0.05}, 0.02]
)
def test_paddings_of_all_kinds_one_after_the_other(padding):
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    pc.Checker(robot, scene)
    checker = pc.Checker(robot, scene, padding=padding)
    assert_as_computed_anew(checker)
    scene.move("can_1", at(np.random.default_rng(3)))
    assert_as_computed_anew(checker.with_scene(scene))
    assert_as_computed_anew(pc.Checker(robot, scene, excess=0.01))


def test_a_robot_that_holds_other_values_or_has_another_group():
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    joints = robot.joint_names
    made = [
        robot,
        robot.holding({"panda_finger_joint1": 0.0}),
        robot.holding({"panda_finger_joint1": 0.03}),
        robot.holding({"panda_joint2": 0.3}),
        robot.with_group(joints[:4]),
        robot.with_group(joints[3:]).holding({"panda_joint1": 1.0}),
        robot.with_group(joints[3:]).holding({"panda_joint1": -1.0}),
    ]
    for each in (*made, *reversed(made)):
        checker = pc.Checker(each, scene)
        assert_as_computed_anew(checker)
        q = each.random_configurations(200, 1)
        fresh = pickle.loads(pickle.dumps(each))  # nothing is kept there
        np.testing.assert_array_equal(checker.check_states(q), pc.Checker(fresh, scene).check_states(q))
        np.testing.assert_array_equal(each.link_poses(q), fresh.link_poses(q))


def test_equal_robots_share_their_kinematics_and_others_do_not():
    robot = pc.Robot.load("panda")
    first, second = (robot.holding({"panda_finger_joint1": value}) for value in (0.01, 0.02))
    assert robot.holding({"panda_finger_joint1": 0.01}).kinematics is first.kinematics
    assert first.kinematics is not second.kinematics


def test_a_robot_whose_attributes_are_replaced_is_another_robot():
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    q = robot.random_configurations(300, 0)
    before = pc.Checker(robot, scene).check_states(q)
    robot.self_pairs = robot.self_pairs[:-5]
    assert_as_computed_anew(pc.Checker(robot, scene))
    bodies = robot.bodies
    robot.bodies = tuple(GeometryObject(body.name, body.link, body.pose, Sphere(0.3)) for body in bodies)
    changed = pc.Checker(robot, scene)
    assert_as_computed_anew(changed)
    assert changed.check_states(q).sum() < before.sum()
    robot.bodies = bodies
    assert_as_computed_anew(pc.Checker(robot, scene))


def test_stand_ins_are_not_the_robots_own_bodies():
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    own = pc.Checker(robot, scene)
    rounds = [GeometryObject(body.name, body.link, body.pose, Sphere(0.2)) for body in own.bodies]
    assert_as_computed_anew(own.with_bodies(rounds))
    assert_as_computed_anew(pc.Checker(robot, scene))


def test_what_is_carried_is_not_kept_for_the_robot_alone():
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    checker = pc.Checker(robot, scene)
    pose = np.eye(4)
    pose[2, 3] = 0.5
    far = checker.attach("rod", Box((0.02, 0.02, 0.8)), "panda_hand", pose)
    near = checker.attach("rod", Box((0.02, 0.02, 0.1)), "panda_hand", pose)
    for each in (
        far,
        near,
        far.with_scene(near.scene),
        far.detach("rod"),
        pc.Checker(robot, scene),
        pc.Checker(robot, far.scene),
    ):
        assert_as_computed_anew(each)


def test_the_second_checker_of_a_robot_computes_nothing_of_the_robot_again(monkeypatch):
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    q = robot.reference
    pc.Checker(robot, scene).check_motion(q, q)

    def fail(*_):
        raise AssertionError("computed again")

    monkeypatch.setattr(robot_reach, "RobotReach", fail)
    monkeypatch.setattr("plannercheck.motions.robot_chains.RobotChains", fail)
    monkeypatch.setattr("plannercheck.motions.checker.MotionSampler", fail)
    monkeypatch.setattr("plannercheck.motions.certifier.RoundingBounds", fail)
    for each in (robot, robot.holding({}), robot.with_group(robot.joint_names, robot.group)):
        pc.Checker(each, scene).check_motion(q, q)


def test_parts_and_what_is_kept_of_them_are_copied_apart():
    robot = pc.Robot.load("panda")
    robot.remembered("something", lambda: 1)
    assert isinstance(robot._parts, RobotParts)
    assert pickle.loads(pickle.dumps(robot)).remembered("something", lambda: 2) == 2
    assert robot.remembered("something", lambda: 2) == 1


def test_a_table_of_allowed_collisions_says_what_each_pair_says():
    rng = np.random.default_rng(0)
    for _ in range(50):
        scene, names = pc.Scene(), ["a", "b", "c", "d", "e", "a"]
        for _ in range(rng.integers(0, 6)):
            scene.allow(*rng.choice(names, 2), bool(rng.integers(2)))
        for _ in range(rng.integers(0, 4)):
            scene.allowed.defaults[rng.choice(names)] = bool(rng.integers(2))
        first, second = rng.choice(names, 4).tolist(), rng.choice(names, 5).tolist()
        truth = [[scene.is_allowed(a, b) for b in second] for a in first]
        np.testing.assert_array_equal(scene.allowed.table(first, second), truth)


def test_boxes_are_prepared_as_any_hulls_are():
    rng = np.random.default_rng(1)
    sizes = [*rng.uniform(1e-3, 3, (30, 3)), (1e-9, 1, 2), (1e-200, 1e-200, 1e-200), (1e40, 1, 1e-3)]
    sizes = np.array([*sizes, *sizes[:5], (0, 1, 1), (1e60, 1, 1), (5e-324, 1, 1)])  # the last three have no volume
    radii = rng.choice([0.0, 0.03], len(sizes))
    found = polytopes_of_boxes(sizes, radii)
    for size, radius, polytope in zip(sizes[:-3].tolist(), radii.tolist(), found, strict=False):
        made = pc.Polytope(*Box(tuple(size)).vertices_and_faces(), radius)
        assert polytope.core.serialise() == made.core.serialise()
    assert found[-3:] == [None, None, None]
    same = [(k, k + 33) for k in range(5) if radii[k] == radii[k + 33]]
    assert same
    assert all(found[a] is found[b] for a, b in same)


def test_boxes_around_boxes_need_no_hulls():
    rng = np.random.default_rng(2)
    shapes = [Box(tuple(size)) for size in (*rng.uniform(0, 2, (20, 3)), (0, 1, 2), (0, 0, 0))]
    shapes[3:3] = [Cylinder(0.1, 0.3), Sphere(0.2)]
    bodies = [GeometryObject(f"{k}", None, np.eye(4), shape) for k, shape in enumerate(shapes)]
    preparation = Preparation(bodies, 1e-4, rng.uniform(0, 0.1, len(bodies)))
    for found, truth in zip(
        preparation.boxes(range(len(bodies))), boxes_of(preparation.hulls(len(bodies))), strict=True
    ):
        np.testing.assert_array_equal(found, truth)


def test_paddings_that_come_and_go_leave_little_behind():
    robot = pc.Robot.load("panda")
    for k in range(20):
        pc.Checker(robot, padding=0.001 * k)
    assert all(len(prepared_bodies._PREPARED[body.shape]) <= 4 for body in robot.bodies)
    assert len(robot._parts.memory._results) <= robot_memory._MOST_RESULTS
