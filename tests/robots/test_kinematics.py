"""The compiled kernel poses as Pinocchio does, on every robot at hand, and always with the same bits."""

import hashlib
import os
import subprocess
import sys

import numpy as np
import pinocchio as pin
import pytest

from plannercheck.common.core import available_levels, core
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.package_data import example_robot_data
from plannercheck.robots.configurations import planning_group, whole_robot
from plannercheck.robots.kinematics import AGREEMENT, compiled_kinematics, disagreement, pinocchio_poses
from plannercheck.robots.planning_groups import usable_mimics
from plannercheck.robots.reference_configuration import all_values
from plannercheck.robots.robot import Robot
from plannercheck.robots.urdf import link_tree, read_model

ROBOTS = example_robot_data() / "example-robot-data" / "robots"
URDFS = sorted(ROBOTS.rglob("*.urdf"))


def one_turning_joint():
    """A kernel of one joint about z, its angle the only column."""
    eye = np.eye(4)[None, :3]
    rest = np.zeros((1, 7))
    columns = np.full((1, 7), -1, dtype=np.int32)
    columns[0, 0] = 0
    world, first = np.array([-1], dtype=np.int32), np.zeros(1, dtype=np.int32)
    axis, turn_z = np.array([[0.0, 0.0, 1.0]]), np.array([2], dtype=np.int32)
    return core.Kinematics(1, world, turn_z, axis, eye, columns, rest + 1.0, rest, first, eye)


def poses_of(kinematics, q):
    return kinematics.link_poses(np.ascontiguousarray(q), np.ones(kinematics.link_count, dtype=np.uint8))


def maps_of(model, urdf):
    """Pinocchio's own q, all joints as a group, and the later half of them as a group."""
    mimics = usable_mimics(model, urdf)
    joints = [name for name in list(model.names)[1:] if name not in mimics]
    values = all_values(model, {}, mimics)
    groups = [joints, joints[len(joints) // 2 :]] if joints else []
    return [whole_robot(model), *(planning_group(model, group, values, mimics) for group in groups)]


@pytest.mark.parametrize("reach", [1.0, 10.0, 1e3, 1e5, 9.99e5, 1e9])
def test_sine_and_cosine_are_accurate(reach):
    angles = np.random.default_rng(1).uniform(-reach, reach, 20_000)
    angles[:2000] = np.arange(-1000, 1000) * (np.pi / 2) * max(1, int(reach / 2000))  # near multiples of pi/2
    pose = poses_of(one_turning_joint(), angles[:, None])[:, 0]
    exact = angles.astype(np.longdouble)
    for ours, truth in ((pose[:, 1, 0], np.sin(exact)), (pose[:, 0, 0], np.cos(exact))):
        error = np.abs(ours - truth) / np.spacing(np.abs(truth.astype(np.float64)))
        assert error.max() < 1.1
    assert np.array_equal(pose[:, 0, 1], -pose[:, 1, 0])


def test_every_robot_of_example_robot_data_is_posed_as_pinocchio_does():
    malformed = set()
    for urdf in URDFS:
        for floating in (False, True):
            try:
                model = read_model(urdf, floating)
            except PlannercheckError:
                malformed.add(urdf.name)
                continue
            frames = link_tree(model).frames
            for configurations in maps_of(model, urdf):
                kinematics = compiled_kinematics(model, configurations, frames)
                assert kinematics is not None, urdf
                assert disagreement(kinematics, model, configurations, frames) < AGREEMENT / 100, urdf
    assert malformed == {"ur3.urdf", "alex_psyonic_hands.urdf"}  # no robot; a mimic of a joint that is not there


def hand_made_model():
    """One joint of every kind that the kernel knows, axes in and against all directions, each with a link."""
    slanted = np.array([1.0, -2.0, 3.0]) / np.sqrt(14.0)
    kinds = [
        pin.JointModelFreeFlyer(),
        *(pin.JointModelRX(), pin.JointModelRY(), pin.JointModelRZ(), pin.JointModelRevoluteUnaligned(slanted)),
        *(pin.JointModelRevoluteUnaligned(-axis) for axis in np.eye(3)),
        *(pin.JointModelRUBX(), pin.JointModelRUBY(), pin.JointModelRUBZ()),
        *(pin.JointModelPX(), pin.JointModelPY(), pin.JointModelPZ(), pin.JointModelPrismaticUnaligned(slanted)),
        pin.JointModelPlanar(),
        pin.JointModelSpherical(),
    ]
    model = pin.Model()
    rng = np.random.default_rng(5)
    for index, kind in enumerate(kinds):
        parent = max(0, model.njoints - 1 - int(rng.integers(3)))
        placement = pin.SE3.Random() if index % 3 else pin.SE3.Identity()
        joint = model.addJoint(parent, kind, placement, f"joint{index}")
        model.addJointFrame(joint, -1)
        placement = pin.SE3.Random() if index % 2 else pin.SE3.Identity()
        model.addBodyFrame(f"link{index}", joint, placement, -1)
    return model


SLANTED_AND_FREE = """<robot name="odd">
<link name="a"/><link name="b"/><link name="c"/><link name="d"/>
<link name="e"/><link name="f"/><link name="g"/>
<joint name="slanted" type="continuous"><parent link="a"/><child link="b"/>
  <axis xyz="0.26726124191242440 -0.53452248382484879 0.80178372573727319"/>
  <origin xyz="1 2 3" rpy="1 2 3"/></joint>
<joint name="against_x" type="continuous"><parent link="b"/><child link="c"/><axis xyz="-1 0 0"/></joint>
<joint name="against_y" type="continuous"><parent link="c"/><child link="d"/><axis xyz="0 -1 0"/></joint>
<joint name="against_z" type="continuous"><parent link="d"/><child link="e"/><axis xyz="0 0 -1"/></joint>
<joint name="sliding" type="planar"><parent link="e"/><child link="f"/><axis xyz="0 0 1"/></joint>
<joint name="flying" type="floating"><parent link="f"/><child link="g"/></joint>
</robot>"""


def test_all_joints_of_a_urdf():
    model = pin.buildModelFromXML(SLANTED_AND_FREE)
    names, frames = list(model.names)[1:], link_tree(model).frames
    assert model.joints[1].shortname() == "JointModelRevoluteUnboundedUnaligned"
    values = {**all_values(model, {}, {}), "slanted": np.ones(1), "against_y": np.full(1, 2.0)}
    for configurations in (whole_robot(model), *(planning_group(model, names[k:], values, {}) for k in range(5))):
        kinematics = compiled_kinematics(model, configurations, frames)
        assert disagreement(kinematics, model, configurations, frames) < AGREEMENT / 100


@pytest.mark.parametrize("seed", range(5))
def test_all_kinds_of_joints(seed):
    pin.seed(seed)
    model = hand_made_model()
    frames = link_tree(model).frames
    values = all_values(model, {}, {})
    maps = [whole_robot(model), planning_group(model, list(model.names)[1:], values, {})]
    maps += [planning_group(model, list(model.names)[first::2], values, {}) for first in (1, 2)]
    for configurations in maps:
        kinematics = compiled_kinematics(model, configurations, frames)
        assert disagreement(kinematics, model, configurations, frames) < AGREEMENT / 100


def same_bits_alone(kinematics, q, needed=None):
    """Whether single configurations are posed with the bits of a batch, the signs of zeros among them."""
    needed = np.ones(kinematics.link_count, dtype=np.uint8) if needed is None else needed
    together = kinematics.link_poses(np.ascontiguousarray(q), needed)
    alone = [kinematics.link_poses(np.ascontiguousarray(row[None]), needed) for row in q]
    return together.tobytes() == np.concatenate(alone).tobytes()


def with_odd_values(q):
    """Zeros of both signs, and angles that are reduced in integers, among configurations."""
    rng = np.random.default_rng(9)
    odd = rng.choice([0.0, -0.0, np.pi / 2, -3e7], size=q.shape)
    return np.where(rng.random(q.shape) < 0.3, odd, q)


@pytest.mark.parametrize("seed", range(5))
def test_single_configurations_are_posed_with_the_bits_of_a_batch(seed):
    pin.seed(seed)
    for model in (hand_made_model(), pin.buildModelFromXML(SLANTED_AND_FREE)):
        frames, values = link_tree(model).frames, all_values(model, {}, {})
        names = list(model.names)[1:]
        maps = [whole_robot(model), *(planning_group(model, names[k::2], values, {}) for k in (0, 1))]
        for configurations in maps:
            kinematics = compiled_kinematics(model, configurations, frames)
            assert same_bits_alone(kinematics, with_odd_values(configurations.random(40, seed)))


@pytest.mark.parametrize("name", ["panda", "pr2", "talos", "tiago", "go2", "baxter"])
def test_single_configurations_of_robots_are_posed_with_the_bits_of_a_batch(name):
    robot = Robot.load(name)
    rng = np.random.default_rng(10)
    for part in (1.0, 0.5, 0.1):
        needed = (rng.random(len(robot.link_names)) < part).astype(np.uint8)
        q = with_odd_values(robot.random_configurations(30, 3))
        assert same_bits_alone(robot.kinematics, q, needed)


MIMICS = """<robot name="mimics"><link name="base"/><link name="lead"/><link name="tip"/>
<joint name="lead" type="revolute"><parent link="base"/><child link="lead"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="turn" type="revolute"><parent link="lead"/><child link="tip"/><axis xyz="0.6 0.8 0"/>
<origin xyz="0.3 0.1 0"/><limit lower="-9" upper="9" effort="1" velocity="1"/>
<mimic joint="lead" multiplier="{multiplier}" offset="{offset}"/></joint></robot>"""


@pytest.mark.parametrize(("multiplier", "offset"), [(1, 0.7), (-2.5, 0), (3.1, -0.2)])
def test_mimics_are_posed_alone_as_in_a_batch(tmp_path, multiplier, offset):
    path = tmp_path / "mimics.urdf"
    path.write_text(MIMICS.format(multiplier=multiplier, offset=offset))
    robot = Robot.from_urdf(path, group=["lead"])
    assert same_bits_alone(robot.kinematics, robot.random_configurations(20, 1))


def test_negative_zeros_of_a_first_joint_are_posed_alone_as_in_a_batch():
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([-0.0, 0.3, -0.0])), "turn")
    model.addJointFrame(joint, -1)
    model.addBodyFrame("link", joint, pin.SE3.Identity(), -1)
    configurations = whole_robot(model)
    kinematics = compiled_kinematics(model, configurations, link_tree(model).frames)
    assert same_bits_alone(kinematics, np.array([[0.0], [0.4], [-2.0]]))


def test_quaternions_are_used_as_they_are():
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "base")
    model.addJointFrame(joint, -1)
    model.addBodyFrame("link", joint, pin.SE3.Identity(), -1)
    configurations, frames = whole_robot(model), link_tree(model).frames
    q = configurations.random(10, 3)
    q[:, 3:] *= 1.0 + 1e-5
    ours = poses_of(compiled_kinematics(model, configurations, frames), q)
    assert np.abs(ours - pinocchio_poses(model, configurations, frames, q)).max() < 1e-14


def test_a_joint_that_the_kernel_does_not_know():
    model = pin.Model()
    model.addJoint(0, pin.JointModelSphericalZYX(), pin.SE3.Identity(), "ball")
    assert compiled_kinematics(model, whole_robot(model), link_tree(model).frames) is None


@pytest.mark.parametrize("name", ["panda", "pr2", "talos"])
def test_poses_do_not_depend_on_the_batch(name):
    robot = Robot.load(name)
    q = robot.random_configurations(37, 2)
    together = robot.link_poses(q)
    for n in range(1, 10):
        assert np.array_equal(robot.link_poses(q[:n]), together[:n])
    assert np.array_equal(np.stack([robot.link_poses(row) for row in q]), together)


def test_poses_do_not_depend_on_which_links_are_needed():
    robot = Robot.load("talos")
    q = robot.random_configurations(9, 2)
    everything = robot.link_poses(q)
    for link in range(len(robot.link_names)):
        needed = np.zeros(len(robot.link_names), dtype=np.uint8)
        needed[link] = 1
        poses = robot.kinematics.link_poses(q, needed)
        assert np.array_equal(poses[:, link], everything[:, link])
        assert not poses[:, needed == 0].any()


@pytest.mark.parametrize("name", ["panda", "pr2", "tiago", "baxter", "go2"])
def test_poses_do_not_depend_on_what_is_held(name):
    robot = Robot.load(name)
    joints = [j for j in robot.model.names if j != "universe" and j not in robot.mimics]
    widened = robot.with_group(joints)
    q = robot.random_configurations(5, 8)
    wide = np.tile(widened.reference, (5, 1))
    wide[:, [joints.index(j) for j in robot.joint_names]] = q
    assert np.array_equal(robot.link_poses(q), widened.link_poses(wide))


def test_an_empty_batch_has_no_poses():
    robot = Robot.load("ur5")
    assert robot.link_poses(np.empty((0, 6))).shape == (0, len(robot.link_names), 4, 4)


HASH_OF_POSES = """
import hashlib, numpy as np
from plannercheck.robots.robot import Robot
digest = hashlib.sha256()
for name in ("panda", "kinova", "talos"):
    robot = Robot.load(name)
    digest.update(robot.link_poses(20 * robot.random_configurations(11, 4)).tobytes())
print(digest.hexdigest())
"""


def test_every_instruction_set_gives_the_same_bits():
    levels = available_levels()
    if len(levels) < 2:
        pytest.skip("only one level is built or runs here")
    runs = [
        subprocess.run(
            [sys.executable, "-c", HASH_OF_POSES],
            env={**os.environ, "PLANNERCHECK_LEVEL": level},
            capture_output=True,
            text=True,
            check=True,
        )
        for level in levels
    ]
    hashes = {run.stdout.strip() for run in runs}
    assert len(hashes) == 1
    assert len(hashes.pop()) == hashlib.sha256().digest_size * 2


def test_kinematics_refuses_the_wrong_width():
    kinematics = one_turning_joint()
    with pytest.raises(ValueError, match="width"):
        kinematics.link_poses(np.zeros((3, 2)), np.ones(1, dtype=np.uint8))
    with pytest.raises(ValueError, match="links"):
        kinematics.link_poses(np.zeros((3, 1)), np.ones(2, dtype=np.uint8))
