"""Contact by construction: a state within the limits first, then bodies that touch there: they are reachable."""

import numpy as np
import pytest
from poses import at
from random_trees import limit_states, points_on_others, random_tree

import plannercheck as pc

CONTACTS = 60


def scene_of_cubes(points, size):
    scene = pc.Scene("contacts")
    for k, point in enumerate(points):
        pose = at(*point)
        scene.add_box(f"cube{k}", [size] * 3, pose)
    return scene


def assert_nothing_that_touches_is_unreachable(robot, scene, q, least):
    """Both with few and with all obstacles; returns the share of pairs that are proved never to meet."""
    checker = pc.Checker(robot, scene)
    touching = pc.Checker(robot, scene, tuning=pc.Tuning(reach=False)).colliding_pairs(q).any(axis=0)
    assert touching.sum() >= least
    wrong = [checker.pair_names(k) for k in np.flatnonzero(touching & checker.unreachable)]
    assert not wrong
    return checker.unreachable.mean()


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("reach", [1.0, 0.03])
def test_obstacles_that_bodies_touch(tmp_path, seed, reach):
    """Where links are short, what joints slide is most of all lengths."""
    rng = np.random.default_rng(seed)
    kinds = ("revolute", "prismatic", "continuous") if reach == 1.0 else ("revolute", "prismatic")
    robot = random_tree(rng, int(rng.integers(2, 6)), reach=reach, kinds=kinds).robot(tmp_path)
    q = limit_states(rng, robot, CONTACTS)
    links = rng.integers(1, len(robot.link_names), CONTACTS)
    points = robot.link_poses(q)[np.arange(CONTACTS), links, :3, 3]
    few = scene_of_cubes(points[:6], 1e-4)
    assert_nothing_that_touches_is_unreachable(robot, few, q[:6], 6)
    proved = assert_nothing_that_touches_is_unreachable(robot, scene_of_cubes(points, 1e-4), q, CONTACTS)
    assert proved > 0.05


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("sizes", "padding"), [((1e-3,) * 3, 0.0), ((1.0, 1e-3, 1e-3), 0.0), ((1e-3,) * 3, 0.05)])
def test_branches_that_touch(tmp_path, seed, sizes, padding):
    """Dots, rods that touch with an end, and dots that come within the padding."""
    rng = np.random.default_rng(100 + seed)
    count = int(rng.integers(4, 8))
    tree = random_tree(rng, count, sizes)
    bare = tree.robot(tmp_path)
    q = limit_states(rng, bare, CONTACTS)
    links = np.array([rng.choice(count + 1, 2, replace=False) for _ in range(CONTACTS)])
    ends = rng.choice([-0.5, 0.5], (CONTACTS, 3)) * sizes
    away = rng.normal(size=(CONTACTS, 3))
    offsets = ends + 0.95 * padding * away / np.linalg.norm(away, axis=1, keepdims=True)
    robot = tree.robot(tmp_path, points_on_others(bare, q, *links.T, offsets), 1e-4)
    checker = pc.Checker(robot, padding=padding)
    touching = pc.Checker(robot, padding=padding, tuning=pc.Tuning(reach=False)).colliding_pairs(q).any(axis=0)
    assert touching.sum() >= CONTACTS // 4
    assert not [checker.pair_names(k) for k in np.flatnonzero(touching & checker.unreachable)]


HELD = """<robot name="held"><link name="base"/>
<link name="a"><collision><geometry>{shape}</geometry></collision></link>
<link name="between"/><link name="b"><collision><geometry>{shape}</geometry></collision></link>
<joint name="turn" type="revolute"><parent link="base"/><child link="a"/><origin xyz="0.3 0.1 0.7"/>
<axis xyz="0.6 0.8 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="hold" type="prismatic"><parent link="a"/><child link="between"/><axis xyz="1 0 0"/>
<limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
<joint name="hold2" type="prismatic"><parent link="between"/><child link="b"/><axis xyz="1 0 0"/>
<limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>"""


@pytest.mark.parametrize("shape", ['<sphere radius="0.25"/>', '<box size="0.5 0.5 0.5"/>'])
def test_what_rests_within_rounding_is_not_said_to_be_apart(tmp_path, shape):
    """Two bodies that a held joint keeps at contact: rounding decides state by state, so every state is asked."""
    (tmp_path / "held.urdf").write_text(HELD.format(shape=shape))
    q = np.random.default_rng(1).uniform(-2, 2, (100, 1))
    mixed = False
    for gap in (0.0, 1e-16, 2e-16, 1e-15, 1e-9, 1e-7, 1e-3):
        held = {"hold": 0.5, "hold2": gap}
        robot = pc.Robot.from_urdf(tmp_path / "held.urdf", group=["turn"]).holding(held)
        checker, full = pc.Checker(robot), pc.Checker(robot, tuning=pc.Tuning(reach=False))
        (k,) = [k for k in range(len(checker.pairs)) if set(checker.pair_names(k)) == {"a", "b"}]
        assert checker.static[k]
        assert checker.unreachable[k] == (gap == 1e-3)
        truth = full.check_states(q)
        np.testing.assert_array_equal(checker.check_states(q), truth)
        mixed |= bool(truth.any() and not truth.all())
    assert mixed


def test_a_slide_whose_reference_is_its_far_end(tmp_path):
    """Lengths are measured there, with the dot at 1 m; where the slide is out, the dot is at 3 m."""
    path = tmp_path / "crane.urdf"
    path.write_text(
        """<robot name="crane"><link name="base"/><link name="boom"/>
<link name="dot"><collision><origin xyz="2 0 0"/><geometry><box size="1e-3 1e-3 1e-3"/></geometry></collision></link>
<joint name="turn" type="revolute"><parent link="base"/><child link="boom"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="slide" type="prismatic"><parent link="boom"/><child link="dot"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""
    )
    robot = pc.Robot.from_urdf(path, group=["turn", "slide"], reference={"turn": 0.0, "slide": -1.0})
    q = np.array([[turn, slide] for turn in (-2.0, 2.0) for slide in (-1.0, 1.0)])
    points = [[(2 + slide) * np.cos(turn), (2 + slide) * np.sin(turn), 0.0] for turn, slide in q]
    assert_nothing_that_touches_is_unreachable(robot, scene_of_cubes(points, 1e-3), q, 4)
    beyond = [[3.05 * np.cos(turn), 3.05 * np.sin(turn), 0.0] for turn in (-2.0, 2.0)]
    assert pc.Checker(robot, scene_of_cubes(beyond, 1e-3)).unreachable.all()


OVER_A_BALL = """
<robot name="two_arms">
  <link name="base"/>
  <link name="hand"/>
  <link name="ball"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
  <joint name="turn_hand" type="revolute"><parent link="base"/><child link="hand"/><axis xyz="0 0 1"/>
    <limit lower="-0.001" upper="0.001" effort="1" velocity="1"/></joint>
  <joint name="turn_ball" type="revolute"><parent link="base"/><child link="ball"/><axis xyz="0 0 1"/>
    <origin xyz="0 0 0.3"/><limit lower="-0.5" upper="0.5" effort="1" velocity="1"/></joint>
</robot>"""


@pytest.mark.parametrize("stretch", [4.9e-7, -4.9e-7])
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("far", [20.0, 1000.0])
def test_an_object_far_from_its_frame_whose_pose_is_off_rigid(tmp_path, stretch, side, far):
    """A cube at z = far in its frame, whose pose brings its face into the ball, by less than the pose's inverse and
    transpose differ there."""
    (tmp_path / "r.urdf").write_text(OVER_A_BALL)
    half, deep = 0.05, 0.8 * abs(stretch) * far
    corners = half * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    pose = np.eye(4)
    pose[2, 2] = 1 + stretch
    pose[2, 3] = 0.3 - 0.01 + deep - pose[2, 2] * (side * far + half)
    bare = pc.Checker(pc.Robot.from_urdf(tmp_path / "r.urdf"), pc.Scene("empty"))
    checker = bare.attach("cube", pc.Hull(corners + np.array([0, 0, side * far])), "hand", pose)
    assert not checker.check_states(np.zeros((1, 2))).any()
    assert not checker.unreachable.any()
