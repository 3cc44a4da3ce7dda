"""The pair table: which bodies are tested against which."""

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.checking.pair_table import fixed_links, pair_table


@pytest.fixture
def scene():
    scene = pc.Scene("two things")
    scene.add_box("shelf", [0.1, 0.2, 0.3], None)
    scene.add_sphere("ball", 0.1, None)
    return scene


def links_and_objects(robot, scene, rows):
    names = [body.link for body in robot.bodies] + list(scene.body_objects)
    return {(names[a], names[b]) for a, b in rows.tolist()}


def test_self_pairs_are_the_robots(panda, scene):
    table = pair_table(panda, scene, True, "robot")
    np.testing.assert_array_equal(table.pairs[: table.self_count], panda.self_pairs)
    assert table.self_count == len(panda.self_pairs) > 0
    assert pair_table(panda, scene, False, "robot").self_count == 0


def test_every_moving_body_meets_every_obstacle_once(panda, scene):
    table = pair_table(panda, scene, True, "robot")
    fixed = fixed_links(panda)
    n = len(panda.bodies)
    moving = [k for k, body in enumerate(panda.bodies) if body.link not in fixed]
    expected = {(k, n + j) for k in moving for j in range(2)}
    assert {tuple(row) for row in table.pairs[table.self_count :].tolist()} == expected
    assert len(table.pairs) == table.self_count + len(expected)
    static = {(k, n + j) for k in range(n) if k not in moving for j in range(2)}
    assert {tuple(row) for row in table.static.tolist()} == static != set()


def test_fixed_links_are_those_that_never_move(panda):
    q = panda.random_configurations(20, 1)
    poses = panda.link_poses(q)
    still = {name for k, name in enumerate(panda.link_names) if (poses[:, k] == poses[0, k]).all()}
    assert fixed_links(panda) <= still
    assert "panda_link0" in fixed_links(panda)
    assert "panda_link1" not in fixed_links(panda)


def test_nothing_is_fixed_on_a_floating_base():
    go2 = pc.Robot.load("go2")
    floating = pc.Robot.from_urdf(_urdf_of("go2"), package_dirs=_packages(), floating=True)
    assert fixed_links(go2)
    assert not {body.link for body in floating.bodies} & fixed_links(floating)


def _urdf_of(name):
    from plannercheck.robots.description import find_description, read_description

    return read_description(find_description(name)).urdf


def _packages():
    from plannercheck.common.package_data import example_robot_data

    return example_robot_data()


def test_allowed_collisions_leave_pairs_with_obstacles_out(panda, scene):
    before = pair_table(panda, scene, True, "robot")
    scene.allow("panda_hand", "shelf")
    after = pair_table(panda, scene, True, "robot")
    gone = links_and_objects(panda, scene, before.pairs) - links_and_objects(panda, scene, after.pairs)
    assert gone == {("panda_hand", "shelf")}


def test_allowed_collisions_act_on_self_pairs_only_if_asked_for(panda, scene):
    first, second = (panda.bodies[k].link for k in panda.self_pairs[0])
    scene.allow(first, second)
    assert pair_table(panda, scene, True, "robot").self_count == len(panda.self_pairs)
    table = pair_table(panda, scene, True, "scene")
    left = links_and_objects(panda, scene, table.pairs[: table.self_count])
    assert (first, second) not in left
    assert len(left) < len(links_and_objects(panda, scene, panda.self_pairs))


def test_allowed_collisions_of_links_are_left_alone_when_something_is_carried(panda, scene):
    robot = pc.Checker(panda, scene).attach("can", pc.Cylinder(0.03, 0.1), "panda_hand", np.eye(4)).robot
    first, second = (robot.bodies[k].link for k in robot.self_pairs[0])
    scene.allow(first, second)
    assert pair_table(robot, scene, True, "robot").self_count == len(robot.self_pairs)


def test_an_unknown_acm_is_refused(panda, scene):
    with pytest.raises(pc.PlannercheckError, match="'robot' or 'scene', not 'srdf'"):
        pair_table(panda, scene, True, "srdf")


def test_an_empty_scene_and_no_self_pairs_leave_nothing(panda):
    table = pair_table(panda, pc.Scene(), False, "robot")
    assert table.pairs.shape == table.static.shape == (0, 2)


def test_tables_are_read_only(panda, scene):
    table = pair_table(panda, scene, True, "robot")
    for rows in (table.pairs, table.static):
        with pytest.raises(ValueError, match="read-only"):
            rows[0] = 0


def of_unknown_names(caught):
    return [each for each in caught if "unknown link or object" in str(each.message)]


def test_pairs_of_names_that_there_are_not_are_one_warning(panda, scene, recwarn):
    scene.allow("panda_hand", "shelf")
    scene.add_sphere("can", 0.01, None)
    scene.attach("can", "panda_hand", touch_links=["panda_hand"])
    scene.allow("can", "ball", False)
    checker = pc.Checker(panda, scene)
    assert not of_unknown_names(recwarn)
    scene.allow("panda_hnad", "shelf")
    scene.allow("ball", "blal")
    pc.Checker(panda, scene)
    (found,) = of_unknown_names(recwarn)
    assert "'blal': did you mean 'ball'" in str(found.message)
    assert "(and 1 more)" in str(found.message)
    assert found.filename == __file__
    checker.with_scene(scene)  # a later scene may lack what an earlier one had
    assert len(of_unknown_names(recwarn)) == 1
    assert scene.copy().allowed == scene.allowed


def test_matrices_may_name_what_is_not_there(panda, scene, recwarn):
    scene.allowed.pairs[frozenset(("gripper of last year", "shelf"))] = True
    pc.Checker(panda, scene)
    assert not of_unknown_names(recwarn)
