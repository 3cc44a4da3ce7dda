"""Posing errs by no more than its proven bound, and the bound is not silly: held to kinematics in 200 bits."""

import math

import numpy as np
import pytest
from multiprecision import CONTEXT, composed, deviation, deviation_of_robot, vertices_of
from random_chains import random_axis, random_chain, random_placement, random_rows

import plannercheck as pc
from plannercheck.bodies.shapes import Box, Capsule, Cone, Cylinder, GeometryObject, Hull, Sphere
from plannercheck.common.core import core
from plannercheck.robots.description import shipped_robots
from plannercheck.robots.kinematic_error import _SINCOS, KinematicRounding, largest_distance, radius_of
from plannercheck.robots.kinematics import JointTable

KINDS = range(12)

# How much larger than what is measured a bound may be; random configurations find less than the worst.
SILLY = 40


def chain_errors(kinds, seed, **options):
    """(measured, bound) over a few configurations of a random chain with a box on each link."""
    rng = np.random.default_rng(seed)
    table = random_chain(rng, kinds, **options)
    q = random_rows(rng, kinds, 3)
    bodies = [
        GeometryObject(f"b{i}", "link", np.vstack([random_placement(rng), [0, 0, 0, 1]]), Box((0.2, 0.1, 0.3)))
        for i in range(len(kinds))
    ]
    rounding = KinematicRounding(table, bodies, range(len(kinds)))
    measured = deviation(table, core.Kinematics(*table), bodies, list(range(len(kinds))), q)
    assert max(rounding.bound(row, row) for row in q) <= rounding.bound(q.min(axis=0), q.max(axis=0))
    return measured, max(rounding.bound(row, row) for row in q)


@pytest.mark.parametrize("kind", KINDS)
def test_a_single_joint_of_each_kind_stays_within_the_bound(kind):
    for seed in range(10):
        measured, bound = chain_errors([kind], seed)
        assert measured <= bound


@pytest.mark.parametrize("seed", range(10))
def test_random_chains_of_all_kinds_stay_within_the_bound(seed):
    kinds = np.random.default_rng(100 + seed).integers(0, 12, size=12).tolist()
    measured, bound = chain_errors(kinds, seed)
    assert measured <= bound <= 500 * measured


def row_of_joints(kinds, axes, placements, multipliers, offsets):
    """A table of joints in a row, all of which the first columns move, and a link on the last."""
    n = len(kinds)
    columns = np.tile(np.arange(7, dtype=np.int32), (n, 1))
    columns[np.array(multipliers) == 0] = -1
    every = np.ones((1, 7))
    return JointTable(
        7,
        np.arange(-1, n - 1, dtype=np.int32),
        np.array(kinds, dtype=np.int32),
        np.array(axes, dtype=np.float64),
        np.array(placements, dtype=np.float64),
        columns,
        np.array(multipliers)[:, None] * every,
        np.array(offsets)[:, None] * every,
        np.array([n - 1], dtype=np.int32),
        np.eye(4)[None, :3],
    )


def error_and_bound(table, q, half):
    """(measured, bound) of a cube on the last link, of this half edge in m."""
    body = GeometryObject("cube", "link", np.eye(4), Box((2 * half,) * 3))
    measured = deviation(table, core.Kinematics(*table), [body], [0], q)
    rounding = KinematicRounding(table, [body], [0])
    return measured, max(rounding.bound(row, row) for row in q)


EYE = np.eye(4)[:3]


@pytest.mark.parametrize("kind", [3, 7, 10, 11])
def test_rotations_err_by_most_of_what_is_said_of_them_alone(kind):
    """One joint in the world and a cube of 100 m about it: nothing but the rotation's own rounding is left."""
    rng = np.random.default_rng(kind)
    measured = bound = 0.0
    for _ in range(6):
        table = row_of_joints([kind], [random_axis(rng, kind)], [EYE], [1.0], [0.0])
        q = random_rows(rng, [kind], 60)
        if kind == 11:
            q[:, :3] = 0
        found, said = error_and_bound(table, q, 100.0)
        measured, bound = max(measured, found), max(bound, said)
        assert found <= said
    assert bound < 20 * measured


def test_a_turns_error_counts_along_the_slide_after_it():
    """A turn of 300 rad, of a mimic, is rounded by 3e-14 rad; then the link slides by 100 m."""
    table = row_of_joints([2, 8], [[0, 0, 1], [1, 0, 0]], [EYE, EYE], [1000.1, 100.0], [0.0, 0.0])
    q = np.random.default_rng(1).uniform(0.9, 1.0, (200, 7))
    measured, bound = error_and_bound(table, q, 0.01)
    assert 1e-13 < measured <= bound < 20 * measured


def test_a_slides_value_that_cancels():
    """A million times the leader less a million: the value is small, what rounding left of it is not."""
    table = row_of_joints([8], [[1, 0, 0]], [EYE], [1e6 + 0.1], [-1e6])
    q = np.random.default_rng(1).uniform(1 - 1e-6, 1 + 1e-6, (200, 7))
    measured, bound = error_and_bound(table, q, 0.01)
    assert 1e-11 < measured <= bound < 20 * measured


def test_sums_that_round_the_same_way_at_every_placement():
    """A link 2^20 m away, and 40 placements of 3/4 of the last bit there: each is rounded up."""
    step = EYE.copy()
    step[0, 3] = 0.75 * 2.0**-32
    kinds, axes = [8] * 41, [[1, 0, 0]] * 41
    table = row_of_joints(kinds, axes, [EYE, *[step] * 40], [1.0, *[0.0] * 40], np.zeros(41))
    measured, bound = error_and_bound(table, np.full((1, 7), 2.0**20), 0.01)
    assert 9 * 2.0**-32 < measured <= bound < 20 * measured


def test_joints_held_on_the_world_are_posed_once_and_count_too():
    for seed in range(5):
        measured, bound = chain_errors([3, 2, 8, 0, 1], seed, held=1.0)
        assert 0 < measured <= bound


@pytest.mark.parametrize("name", shipped_robots())
def test_every_shipped_robot_stays_within_a_bound_that_is_not_silly(name):
    robot = pc.Robot.load(name)
    q = robot.random_configurations(4, seed=1)
    measured = deviation_of_robot(robot, q)
    assert measured <= max(map(robot.kinematic_error_at, q)) <= robot.kinematic_error < SILLY * measured
    assert robot.kinematic_error < 1e-14


def test_cosine_and_sine_err_by_what_the_bound_assumes():
    rng = np.random.default_rng(3)
    eighths = np.arange(-200, 200) * (np.pi / 4)
    angles = np.concatenate([rng.uniform(-4, 4, 1000), rng.uniform(-1e6, 1e6, 1000), eighths, 5e4 * eighths / 8])
    eye, rest = np.eye(4)[None, :3], np.zeros((1, 7))
    world, first = np.array([-1], dtype=np.int32), np.zeros(1, dtype=np.int32)
    columns, kinds = np.zeros((1, 7), dtype=np.int32), np.array([2], dtype=np.int32)
    kernel = core.Kinematics(1, world, kinds, np.eye(3)[2:], eye, columns, rest + 1, rest, first, eye)
    poses = kernel.link_poses(angles[:, None], np.ones(1, dtype=np.uint8))[:, 0]
    for computed, function in ((poses[:, 0, 0], CONTEXT.cos), (poses[:, 1, 0], CONTEXT.sin)):
        worst = max(abs(float(function(CONTEXT.mpf(a)) - c)) for a, c in zip(angles, computed, strict=True))
        assert 0.5 < worst * 2**53 <= _SINCOS


def test_bodies_are_composed_as_this_test_does(panda):
    q = panda.random_configurations(5, seed=2)
    placements = np.array([body.pose[:3] for body in panda.bodies])
    links = [panda.link_index(body.link) for body in panda.bodies]
    theirs = pc.Checker(panda).body_poses(q)[:, :, :3]
    ours = np.array([composed(poses[links, :3], placements) for poses in panda.link_poses(q)])
    used = ~np.isnan(theirs)
    assert used.any()
    assert np.array_equal(theirs[used], ours[used])


def test_a_verdict_states_the_bound_at_its_configuration(panda):
    q = panda.random_configurations(1, seed=3)[0]
    ours = pc.Checker(panda).explain(q).kinematic_error
    assert ours == panda.kinematic_error_at(q)
    theirs = pc.Checker(panda, kinematics="pinocchio").explain(q).kinematic_error
    assert ours < theirs < ours + 1e-14  # the kernel's bound, and how far Pinocchio's poses are from the kernel's


def test_the_bound_grows_with_how_far_a_robot_goes(tmp_path):
    urdf = tmp_path / "slide.urdf"
    urdf.write_text(
        """<robot name="slide"><link name="base"/><link name="tip"><collision><geometry><sphere radius="1"/>
        </geometry></collision></link><joint name="slide" type="prismatic"><parent link="base"/><child link="tip"/>
        <origin rpy="0.3 0.2 0.1"/><axis xyz="0.6 0.8 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
        </joint></robot>"""
    )
    robot = pc.Robot.from_urdf(urdf)
    far = np.array([[1e6]])
    assert robot.kinematic_error < 1e-14
    assert 1e-11 < deviation_of_robot(robot, far) <= robot.kinematic_error_at(far[0]) < 1e-8


FAR = """<robot name="far"><link name="base"/><link name="tip"><collision><origin xyz="{far}"/><geometry>
<box size="0.1 0.1 0.1"/></geometry></collision></link><link name="lead"/>
<joint name="lead" type="{kind}"><parent link="base"/><child link="lead"/><axis xyz="0 0 1"/>
<limit lower="-0.4" upper="0.4" effort="1" velocity="1"/></joint>
<joint name="turn" type="{kind}"><parent link="base"/><child link="tip"/><axis xyz="0.6 0.8 0"/>
<limit lower="-99" upper="99" effort="1" velocity="1"/>
<mimic joint="lead" multiplier="{multiplier}" offset="{offset}"/></joint></robot>"""


@pytest.mark.parametrize("multiplier", [1.0, 3.1])
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_a_body_far_from_its_joint(tmp_path, kind, multiplier):
    """100 m away the turn's error counts, and most of it is the rounding of the multiplier's product."""
    urdf = tmp_path / "far.urdf"
    urdf.write_text(
        FAR.format(far="0 100 100" if kind == "revolute" else "0 0 0", kind=kind, multiplier=multiplier, offset=0)
    )
    robot = pc.Robot.from_urdf(urdf, group=["lead"])
    q = robot.random_configurations(200, 1)
    measured = deviation_of_robot(robot, q)
    assert measured <= max(map(robot.kinematic_error_at, q))
    assert robot.kinematic_error < SILLY * measured


@pytest.mark.parametrize(("multiplier", "offset"), [(30.1, 0.0), (1000.1, 0.0), (1.0, 1000.3)])
def test_the_rounding_of_a_mimics_value_is_most_of_the_error(tmp_path, multiplier, offset):
    """The angle is rounded at a size of some hundred rad, the body 100 m away: this alone breaks a bound without it."""
    urdf = tmp_path / "far.urdf"
    urdf.write_text(FAR.format(far="0 100 100", kind="revolute", multiplier=multiplier, offset=offset))
    robot = pc.Robot.from_urdf(urdf, group=["lead"])
    q = robot.random_configurations(300, 1)
    q = q[np.abs(q[:, 0]) > 0.3]
    measured = deviation_of_robot(robot, q)
    assert measured > 0.2 * robot.kinematic_error
    assert measured <= robot.kinematic_error


def test_a_body_of_200_m_about_its_joint(tmp_path):
    """The joint's turn errs, its origin does not: what the corners are off by is the turn times their distance."""
    urdf = tmp_path / "far.urdf"
    text = FAR.format(far="0 0 0", kind="revolute", multiplier=3.1, offset=0)
    urdf.write_text(text.replace('size="0.1 0.1 0.1"', 'size="200 200 200"'))
    robot = pc.Robot.from_urdf(urdf, group=["lead"])
    measured = deviation_of_robot(robot, robot.random_configurations(100, 1))
    assert 1e-15 < measured <= robot.kinematic_error < SILLY * measured


def test_nothing_is_proven_where_pinocchio_has_to_pose():
    robot = pc.Robot.load("ur5")
    robot._forward.kernel = None
    assert robot.kinematic_error == math.inf
    assert pc.Checker(robot).explain(robot.reference).kinematic_error == math.inf


@pytest.mark.parametrize(
    "shape", [Box((1, 2, 3)), Sphere(1), Capsule(1, 2), Cylinder(1, 2), Cone(1, 2), Hull(np.eye(4)[:, :3])]
)
def test_a_radius_holds_all_points_that_a_pose_maps(shape):
    assert np.linalg.norm(vertices_of(shape), axis=1).max() <= radius_of(shape) * (1 + 1e-15)
    for excess in (1e-3, 1.0):
        if isinstance(shape, Cylinder | Cone):
            points = shape.vertices_and_faces(excess)[0]
            assert np.linalg.norm(points, axis=1).max() <= radius_of(shape)


def test_the_distance_between_poses_leaves_out_bodies_without_a_pose():
    bodies = [GeometryObject(name, None, np.eye(4), Box((2, 2, 2))) for name in "ab"]
    poses, others = np.stack([np.eye(4)] * 2), np.stack([np.eye(4)] * 2)
    poses[0], others[1, 0, 3] = np.nan, 0.5
    assert largest_distance(bodies, poses, others) == pytest.approx(0.5)
