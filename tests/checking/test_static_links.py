"""Links that no joint of the group moves are posed once, and judged once against what stands still as they do."""

import numpy as np
import pytest
from poses import at

import plannercheck as pc

pytestmark = pytest.mark.filterwarnings("ignore:.*touches obstacle:RuntimeWarning")

# With a held arm or held legs.
HELD = [("baxter", "kitchen"), ("baxter", "table"), ("talos", None)]


def _scene(name):
    return pc.Scene.load(name) if name else None


def _box_over_the_right_arm(robot, gap):
    """A box that stands so far, m, above the highest point of Baxter's right arm; below 0 it is in it."""
    checker = pc.Checker(robot)
    poses = checker.body_poses(robot.reference[None])[0]
    arm = [k for k, body in enumerate(checker.bodies) if body.link.startswith("right_")]
    points = np.concatenate([checker.polytopes[k].vertices @ poses[k, :3, :3].T + poses[k, :3, 3] for k in arm])
    placed = at(*points[points[:, 2].argmax()] + [0, 0, gap + 0.01])
    scene = pc.Scene("over the arm")
    scene.add_box("box", [0.02] * 3, placed)
    return scene


def _settled(counted):
    return sum(n for name, n in counted.items() if name not in ("states", "pairs", "queries"))


@pytest.mark.parametrize(("robot", "scene"), HELD)
def test_verdicts_are_those_of_links_posed_every_time(robot, scene):
    robot = pc.Robot.load(robot)
    q = robot.random_configurations(400, 1)
    once, always = (pc.Checker(robot, _scene(scene), tuning=pc.Tuning(static_poses=on)) for on in (True, False))
    np.testing.assert_array_equal(once.check_states(q), always.check_states(q))
    np.testing.assert_array_equal(once.first_colliding_pair(q), always.first_colliding_pair(q))
    np.testing.assert_array_equal(once.colliding_pairs(q), always.colliding_pairs(q))
    np.testing.assert_array_equal(once.body_poses(q), always.body_poses(q))
    assert [once.is_valid(row) for row in q[:50]] == always.check_states(q[:50]).tolist()


@pytest.mark.parametrize("switches", [{}, {"reach": False}, {"bounds": False}, {"learning": False}])
def test_a_held_arm_in_an_obstacle_leaves_no_valid_state(switches):
    baxter = pc.Robot.load("baxter")
    scene = _box_over_the_right_arm(baxter, -0.01)
    q = baxter.random_configurations(200, 2)
    once, always = (pc.Checker(baxter, scene, tuning=pc.Tuning(static_poses=on, **switches)) for on in (True, False))
    if not switches:
        assert not once.check_states(q).any()
        counted = once.statistics()
        assert (counted["overlaps"], counted["bounds"]) == (200, 0)  # nothing else is asked of such a state
    for checker in (once, always):
        assert not checker.check_states(q).any()
        assert not checker.is_valid(q[0])
        box = {k for k, name in enumerate(checker.pair_names(k) for k in range(len(checker.pairs))) if "box" in name}
        assert set(np.flatnonzero(checker.colliding_pairs(q).all(axis=0))) & box
        counted = checker.statistics()
        assert _settled(counted) == counted["pairs"] == counted["states"] * len(checker.pairs)
    np.testing.assert_array_equal(once.colliding_pairs(q), always.colliding_pairs(q))
    np.testing.assert_array_equal(once.first_colliding_pair(q), always.first_colliding_pair(q))
    beyond = baxter.upper + np.abs(q[:5])  # all pairs are judged there
    assert not once.check_states(beyond).any()
    np.testing.assert_array_equal(once.colliding_pairs(beyond), always.colliding_pairs(beyond))


@pytest.mark.parametrize("gap", [1e-13, 1e-9, 1e-3])
def test_a_held_arm_just_above_an_obstacle_does_no_harm(gap):
    """The nearest gaps are too narrow for a proof that lasts: such pairs are judged when the checker is built."""
    baxter = pc.Robot.load("baxter")
    scene = _box_over_the_right_arm(baxter, gap)
    q = baxter.random_configurations(200, 2)
    once, always, alone = (
        pc.Checker(baxter, scene),
        pc.Checker(baxter, scene, tuning=pc.Tuning(static_poses=False)),
        pc.Checker(baxter),
    )
    np.testing.assert_array_equal(once.check_states(q), always.check_states(q))
    free, robot_bodies = alone.check_states(q), baxter.bodies
    assert free.any()
    assert once.check_states(q)[free].any()
    arm = [k for k, (a, b) in enumerate(once.pairs) if b == len(robot_bodies) and robot_bodies[a].link[:6] == "right_"]
    assert arm
    assert not once.colliding_pairs(q)[:, arm].any()


def test_pinocchios_poses_are_taken_as_they_are():
    """They may differ from the kernel's in their last bits, so nothing is posed with the kernel's."""
    baxter = pc.Robot.load("baxter")
    q = baxter.random_configurations(20, 3)
    theirs = pc.Checker(baxter, pc.Scene.load("table"), kinematics="pinocchio")
    links = baxter.pinocchio_link_poses(q)
    placements = np.array([body.pose for body in baxter.bodies])
    index = [baxter.link_index(body.link) for body in baxter.bodies]
    expected = np.einsum("nbij,bjk->nbik", links[:, index], placements)
    np.testing.assert_allclose(theirs.body_poses(q)[:, : len(index)], expected, rtol=0, atol=1e-15)
    assert (theirs.body_poses(q)[0, : len(index), 3] == [0, 0, 0, 1]).all()


def test_an_object_in_a_held_hand_stands_still_too():
    baxter = pc.Robot.load("baxter")
    touched = [name for name in baxter.link_names if name.startswith(("r_gripper", "right_gripper"))]
    pose = at(0, 0, 0.1)
    checkers = []
    for on in (True, False):
        checker = pc.Checker(baxter, pc.Scene.load("table"), tuning=pc.Tuning(static_poses=on))
        checkers.append(checker.attach("held", pc.Box([0.05] * 3), "right_hand_link", pose, touched))
    q = baxter.random_configurations(200, 4)
    once, always = checkers
    np.testing.assert_array_equal(once.colliding_pairs(q), always.colliding_pairs(q))
    np.testing.assert_array_equal(once.check_states(q), always.check_states(q))
    np.testing.assert_array_equal(once.body_poses(q), always.body_poses(q))
