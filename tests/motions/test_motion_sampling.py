"""Sampled motions against brute force: no vertex of a link moves further in a step than it may."""

import re

import numpy as np
import pytest
from random_branches import Joint, Tree

import plannercheck as pc
from plannercheck.common.package_data import example_robot_data
from plannercheck.motions.sampling import MOST_STEPS, MotionSampler
from plannercheck.robots.description import find_description, read_description

# Of a length in m, for poses whose rounding is not counted.
ROUNDING = 1e-12


def whole_robot(name, floating=False):
    """A robot in Pinocchio's own numbers."""
    urdf = read_description(find_description(name)).urdf
    return pc.Robot.from_urdf(urdf, package_dirs=example_robot_data(), floating=floating)


ROBOTS = {
    "panda": lambda: pc.Robot.load("panda"),
    "ur5": lambda: pc.Robot.load("ur5"),
    "tiago": lambda: pc.Robot.load("tiago"),  # a prismatic torso
    "pr2": lambda: pc.Robot.load("pr2"),  # continuous joints in the group
    "kinova": lambda: pc.Robot.load("kinova"),
    "tiago whole": lambda: whole_robot("tiago"),  # cosines and sines
    "go2 floating": lambda: whole_robot("go2", floating=True),
    "fingers": lambda: pc.Robot.load("panda").with_group(["panda_joint7", "panda_finger_joint1"]),
}


@pytest.fixture(scope="module", params=list(ROBOTS))
def robot(request):
    return ROBOTS[request.param]()


def furthest_movement(robot, states):
    """(k - 1,) m: how far any vertex of any link moves from each state to the next."""
    poses = robot.link_poses(states)
    moved = np.zeros(len(states) - 1)
    for body in robot.bodies:
        if body.link is None:
            continue
        vertices = body.shape.vertices_and_faces()[0] @ body.pose[:3, :3].T + body.pose[:3, 3]
        some = vertices[np.linspace(0, len(vertices) - 1, min(len(vertices), 60)).astype(int)]
        links = poses[:, robot.link_index(body.link)]
        world = some @ np.swapaxes(links[:, :3, :3], 1, 2) + links[:, None, :3, 3]
        moved = np.maximum(moved, np.linalg.norm(np.diff(world, axis=0), axis=2).max(axis=1))
    return moved


def assert_small_steps(robot, starts, ends, resolution):
    sampler = MotionSampler(robot)
    steps = sampler.steps(starts, ends, resolution)
    for q0, q1, count in zip(starts, ends, steps.tolist(), strict=True):
        states = sampler.states(q0, q1, np.arange(count + 1) / count)
        np.testing.assert_array_equal(states[0], q0)
        np.testing.assert_array_equal(states[-1], q1)
        assert furthest_movement(robot, states).max() <= resolution + ROUNDING


@pytest.mark.parametrize("resolution", [0.1, 0.02])
def test_no_vertex_moves_further_than_the_resolution(robot, resolution):
    q = robot.random_configurations(6, 4)
    assert_small_steps(robot, q[:3], q[3:], resolution)


def test_a_single_joint_moves_no_vertex_further(robot):
    starts, ends = [], []
    base = robot.random_configurations(1, 5)[0]
    if len(robot.joint_names) != robot.nq:
        pytest.skip("its numbers can't be changed one by one")
    for k in range(robot.nq):
        other = base.copy()
        other[k] += 0.3
        starts.append(base)
        ends.append(other)
    assert_small_steps(robot, np.array(starts), np.array(ends), 0.05)


def test_beyond_the_limits_of_a_slide():
    robot = pc.Robot.load("tiago")
    q = robot.random_configurations(4, 6)
    q[:, robot.joint_names.index("torso_lift_joint")] += [20.0, 20.0, 20.0, -20.0]
    assert_small_steps(robot, q[:2], q[2:], 0.5)


def long_slide(tmp_path, limit):
    """An arm that slides on a turning table, carrying a block."""
    path = tmp_path / "table.urdf"
    path.write_text(f"""<robot name="table"><link name="base"/><link name="arm"/>
    <link name="block"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
    <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
    <joint name="slide" type="prismatic"><parent link="arm"/><child link="block"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="{limit}" effort="1" velocity="1"/></joint></robot>""")
    return pc.Robot.from_urdf(path)


def test_a_slide_beyond_its_limit_makes_the_lever_longer(tmp_path):
    robot = long_slide(tmp_path, 0.1)
    assert_small_steps(robot, np.array([[0.0, 5.0]]), np.array([[1.0, 5.0]]), 0.01)


def test_a_held_slide_beyond_its_limit_makes_the_lever_longer(tmp_path):
    robot = long_slide(tmp_path, 0.1).with_group(["turn"]).holding({"slide": 5.0})
    assert_small_steps(robot, np.array([[0.0]]), np.array([[1.0]]), 0.01)


def test_the_long_way_of_a_continuous_joint_is_sampled_as_such():
    robot = pc.Robot.load("pr2")
    column = robot.joint_names.index("r_forearm_roll_joint")
    assert np.isinf(robot.upper[column])
    q0 = robot.reference.copy()
    q1 = q0.copy()
    q1[column] += 6.2
    assert_small_steps(robot, q0[None], q1[None], 0.02)


@pytest.fixture
def turntable(tmp_path):
    """A block 1 m from a vertical axis, and a checker with a thin wall at 45 degrees."""
    robot = long_slide(tmp_path, 2.0)
    scene = pc.Scene()
    pose = np.eye(4)
    pose[:2, :2] = np.sqrt(0.5) * np.array([[1, -1], [1, 1]])
    pose[:3, 3] = np.array([1, 1, 0]) * np.sqrt(0.5)
    scene.add_box("wall", [0.01, 1e-4, 0.01], pose)
    return pc.Checker(robot, scene)


def test_a_thin_wall_is_found(turntable):
    q0, q1 = np.array([0.0, 1.0]), np.array([1.5, 1.0])
    assert turntable.is_valid(q0)
    assert turntable.is_valid(q1)
    assert not turntable.check_motion(q0, q1)
    assert not turntable.check_motion(q1, q0, resolution=0.05)
    assert turntable.check_motion(q0, np.array([0.6, 1.0]))
    assert turntable.check_motion([0.0, 1.5], [1.5, 1.5])


def test_both_ends_count(turntable):
    hit = np.array([np.pi / 4, 1.0])
    free = np.array([0.0, 1.0])
    assert not turntable.is_valid(hit)
    for q0, q1 in ((hit, free), (free, hit), (hit, hit)):
        assert not turntable.check_motion(q0, q1, resolution=1e3)
    assert turntable.check_motion(free, free)


def test_coarse_sampling_may_miss_the_wall(turntable):
    # Sampling is what it is: with one step only the ends are looked at.
    assert turntable.check_motion([0.0, 1.0], [1.5, 1.0], resolution=1e3)


@pytest.mark.parametrize("kinematics", ["batch", "pinocchio"])
def test_motions_are_judged_at_their_sampled_states(kinematics):
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    checker = pc.Checker(robot, scene, kinematics=kinematics)
    valid = scene.samples("panda")[:200]
    valid = valid[checker.check_states(valid)][:24]
    starts, ends, resolution = valid[:12], valid[12:], 0.02
    sampler = MotionSampler(robot)
    found = checker.check_motions(starts, ends, resolution)
    for q0, q1, free in zip(starts, ends, found, strict=True):
        count = int(sampler.steps(q0[None], q1[None], resolution)[0])
        states = sampler.states(q0, q1, np.arange(count + 1) / count)
        assert checker.check_states(states).all() == free
        assert checker.check_motion(q0, q1, resolution) == free
    assert 0 < found.sum() < 12


def test_a_floating_base_moves_along_the_group(tmp_path):
    robot = whole_robot("go2", floating=True)
    scene = pc.Scene()
    scene.add_box("wall", [0.001, 4, 4], None)
    checker = pc.Checker(robot, scene, self_collision=False)
    q0 = robot.reference.copy()
    q1 = q0.copy()
    q0[0], q1[0] = -2, 2
    assert checker.is_valid(q0)
    assert checker.is_valid(q1)
    assert not checker.check_motion(q0, q1, 0.01)
    q1[0] = -1.5
    assert checker.check_motion(q0, q1, 0.01)


@pytest.mark.parametrize("kind", ["planar", "floating"])
def test_a_joint_in_mid_chain_makes_the_levers_before_it_longer(kind, tmp_path):
    """Also where it goes along half a turn of a screw."""
    kinds = "revolute", kind, "revolute"
    links = "base", "a", "b", "c"
    joints = [
        Joint(k, parent, child, (0.1, 0, 0), (0, 0, 0), (0, 0, 1))
        for k, parent, child in zip(kinds, links[:-1], links[1:], strict=True)
    ]
    path = tmp_path / "tree.urdf"
    path.write_text(Tree(tuple(joints)).with_body("c", 0.01, np.zeros(3)).urdf().replace('upper="50"', 'upper="3"'))
    robot = pc.Robot.from_urdf(path)
    turned = [0.0, 1.0] if kind == "planar" else [0.0, 0.0, 1.0, 0.0]
    rest = [1.0, 0.0] if kind == "planar" else [0.0, 0.0, 0.0, 1.0]
    place = [[x, 0.0] if kind == "planar" else [x, 0.0, 0.0] for x in (-4.0, 4.0)]
    starts = np.array([[0.0, *place[1], *rest, 0.0], [0.0, *place[0], *rest, 0.0]])
    ends = np.array([[1.0, *place[1], *rest, 0.0], [1.0, *place[1], *turned, 0.0]])
    assert_small_steps(robot, starts, ends, 0.01)


def test_groups_with_a_floating_joint_are_not_sampled():
    robot = whole_robot("ur5", floating=True).with_group(["root_joint", "elbow_joint"])
    checker = pc.Checker(robot)
    q = robot.random_configurations(2, 1)
    assert checker.check_states(q).shape == (2,)
    with pytest.raises(pc.PlannercheckError, match="can't be sampled"):
        checker.check_motion(q[0], q[1], 0.1)
    assert checker.check_motion(q[0], q[0])


@pytest.mark.parametrize("resolution", [0.0, -1.0, np.nan, np.inf])
def test_bad_resolutions_are_refused(turntable, resolution):
    with pytest.raises(pc.PlannercheckError, match="resolution"):
        turntable.check_motion([0.0, 1.0], [1.0, 1.0], resolution)


@pytest.mark.parametrize(("far", "resolution"), [(1e14, 1e-3), (1.0, 1e-12), (1.0, 1e-300), (1e14, 5e-324)])
def test_motions_of_too_many_steps_are_refused(turntable, far, resolution):
    with pytest.raises(pc.PlannercheckError, match=re.escape(f"more than {MOST_STEPS:g} steps")):
        turntable.check_motion([0.0, 1.0], [0.0, far + 1], resolution)


def test_bad_motions_are_refused(turntable):
    with pytest.raises(pc.PlannercheckError, match="same shape"):
        turntable.check_motions(np.zeros((2, 2)), np.zeros((3, 2)))
    with pytest.raises(pc.PlannercheckError, match="row 1"):
        turntable.check_motions(np.zeros((2, 2)), np.array([[0.0, 0.0], [np.nan, 0.0]]))
    with pytest.raises(pc.PlannercheckError, match=r"\(2,\), not \(2, 2\)"):
        turntable.check_motion(np.zeros((2, 2)), np.zeros((2, 2)))


@pytest.mark.parametrize("steps", [1, 2, 3, 7, 8, 9, 16, 17, 33])
def test_every_sampled_state_is_looked_at(tmp_path, steps):
    """A dot on a slide, and one obstacle at a time at one sampled state, or half-way to the next, where none is."""
    path = tmp_path / "dot.urdf"
    path.write_text(
        """<robot name="dot"><link name="rail"/>
<link name="dot"><collision><geometry><box size="1e-3 1e-3 1e-3"/></geometry></collision></link>
<joint name="slide" type="prismatic"><parent link="rail"/><child link="dot"/><axis xyz="1 0 0"/>
<limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>"""
    )
    robot = pc.Robot.from_urdf(path)
    resolution = 1.01 / steps
    assert MotionSampler(robot).steps(np.array([[0.0]]), np.array([[1.0]]), resolution).tolist() == [steps]
    for k in np.arange(0, steps + 0.5, 0.5):
        scene, pose = pc.Scene("one"), np.eye(4)
        pose[0, 3] = k / steps
        scene.add_box("box", [1e-3, 1e-3, 1e-3], pose)
        checker = pc.Checker(robot, scene)
        sampled = k == int(k)
        assert checker.check_motion([0.0], [1.0], resolution) != sampled
        free = checker.check_motions([[0.0], [1.0], [0.0]], [[1.0], [0.0], [1.0]], resolution)
        assert (free != sampled).all()


def test_nobody_can_write_to_what_the_checkers_of_a_robot_share():
    """The columns that take the short way: were they changed, motions of all other checkers would change, too."""
    sampler = pc.Checker(pc.Robot.load("kinova")).motion_sampler
    assert len(sampler.whole_turns) > 0
    with pytest.raises(ValueError, match="read-only"):
        sampler.whole_turns[:] = 0
