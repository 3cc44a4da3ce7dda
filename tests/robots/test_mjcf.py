"""MJCF files through Pinocchio's parser, with limits, masks and excludes as MuJoCo has them; SDF files are refused."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies.shapes import Box, Capsule, Cylinder, Hull, Sphere
from plannercheck.cli.main import main

MJCF = """<mujoco model="arm">
<default><default class="drawn"><geom contype="0" conaffinity="0"/></default>
  <default class="finger"><joint range="0 0.04"/><geom contype="2" conaffinity="4"/></default></default>
<asset><mesh name="tetra" vertex="0 0 0 .1 0 0 0 .1 0 0 0 .1"/></asset>
<worldbody>
  <body name="base" pos="0 0 1"><geom type="box" size="0.1 0.2 0.3"/><geom class="drawn" type="sphere" size="9"/>
    <body name="upper" pos="0 0 1"><joint name="lift" type="slide" axis="0 0 1" range="0 1.5"/>
      <geom type="capsule" fromto="0 0 0 0 0 0.5" size="0.05"/>
      <geom type="cylinder" size="0.1 0.2" pos="0.1 0 0"/>
      <body name="lower" pos="0 0 0.8"><joint name="turn" type="hinge" axis="0 1 0" range="-90 45"/>
        <geom type="sphere" size="0.1" pos="0 0 0.3"/>
        <body name="tip" pos="0 0 0.5"><geom type="mesh" mesh="tetra"/></body>
        <body name="left" pos="0.2 0 0.5"><joint name="grip" type="slide" axis="1 0 0" class="finger"/>
          <geom class="finger" type="box" size=".01 .01 .01"/></body>
      </body>
    </body>
  </body>
</worldbody>
<contact><exclude body1="upper" body2="tip"/></contact>
</mujoco>"""


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(MJCF)
    return path


def links_of(robot, pairs):
    return {frozenset(robot.bodies[k].link for k in pair) for pair in pairs}


def test_bodies_joints_and_limits_are_mujocos(path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        robot = pc.Robot.load(path)
    assert robot.name == "arm"
    assert robot.joint_names == ("lift", "turn", "grip")
    assert np.allclose(robot.lower, [0, -np.pi / 2, 0])
    assert np.allclose(robot.upper, [1.5, np.pi / 4, 0.04])  # lengths are no degrees
    shapes = {(body.link, type(body.shape)): body.shape for body in robot.bodies}
    assert shapes["base", Box] == Box((0.2, 0.4, 0.6))
    assert shapes["upper", Capsule] == Capsule(0.05, 0.5)
    assert shapes["upper", Cylinder] == Cylinder(0.1, 0.4)
    assert shapes["lower", Sphere] == Sphere(0.1)
    assert len(shapes["tip", Hull].vertices) == 4
    assert len(robot.bodies) == 6
    poses = robot.link_poses([0.25, np.pi / 2, 0.0])
    assert np.allclose(poses[robot.link_index("tip"), :3, 3], [0.5, 0, 3.05])
    assert np.allclose(poses[robot.link_index("left"), :3, 3], [0.5, 0, 2.85])


def box_pose(robot):
    return next(body for body in robot.bodies if body.link == "base").pose


def test_a_root_without_joints_is_where_the_file_has_it(path):
    path.write_text(MJCF.replace('pos="0 0 1"><geom type="box"', 'pos="1 2 3" quat="0 0 0 2"><geom type="box"'))
    robot = pc.Robot.load(path)
    poses = robot.link_poses([0.25, np.pi / 2, 0.0])
    assert np.allclose(poses[robot.link_index("base"), :3, 3], [1, 2, 3])
    assert np.allclose(poses[robot.link_index("tip"), :3, 3], [0.5, 2, 5.05])
    assert np.allclose(box_pose(robot), np.eye(4))
    aside = MJCF.replace('pos="0 0 1"><geom type="box"', 'pos="1 2 3" quat="0 0 0 2"><geom type="box"')
    path.write_text(aside.replace('name="upper" pos="0 0 1"', 'name="upper" pos="0.5 0 1"'))
    robot = pc.Robot.load(path)  # half a turn about z: the root's x is the world's -x
    upper = robot.link_poses([0.25, 0.0, 0.0])[robot.link_index("upper")]
    assert np.allclose(upper[:3, 3], [0.5, 2, 4.25])
    path.write_text(MJCF.replace('pos="0 0 1"><geom type="box"', 'euler="0 0 90"><geom type="box"'))
    with pytest.raises(pc.PlannercheckError, match="root body 'base': give its orientation as quat=, not euler="):
        pc.Robot.load(path)


@pytest.mark.parametrize(
    ("extra", "message"),
    [
        ('<body name="target"/>', r"the worldbody has 2 bodies \(target, base\), of which one would be read"),
        ('<frame pos="0 0 1"><body name="x"/></frame>', "<frame> is not read: save the model as MuJoCo has compiled"),
        ('<include file="other.xml"/>', "<include> is not read"),
    ],
)
def test_what_pinocchio_passes_over_is_refused(path, extra, message):
    path.write_text(MJCF.replace("<worldbody>", f"<worldbody>{extra}"))
    with pytest.raises(pc.PlannercheckError, match=message):
        pc.Robot.load(path)


def test_pairs_heed_neighbours_excludes_and_masks(path):
    robot = pc.Robot.load(path)
    assert [(pair.link_a, pair.link_b) for pair in robot.disabled_pairs] == [("upper", "tip")]
    pairs = links_of(robot, robot.self_pairs)
    assert pairs == {frozenset(("base", "lower")), frozenset(("base", "tip"))}  # no bit of the finger's meets another's
    path.write_text(MJCF.replace('contype="2" conaffinity="4"', 'contype="2" conaffinity="3"'))
    robot = pc.Robot.load(path)
    fingers = {frozenset(("left", link)) for link in ("base", "upper", "tip")}
    assert links_of(robot, robot.self_pairs) == pairs | fingers


def test_geoms_of_the_world_are_obstacles(path):
    path.write_text(MJCF.replace("<worldbody>", '<worldbody><geom name="floor" type="plane" size="5 5 1"/>'))
    with pytest.warns(RuntimeWarning, match=r"arm\.xml: floor of the worldbody: left out, since obstacles belong into"):
        robot = pc.Robot.load(path)
    assert len(robot.bodies) == 6


def test_a_floating_root_is_the_files(path):
    text = MJCF.replace('<body name="base" pos="0 0 1">', '<body name="base" pos="0 0 1"><freejoint name="root"/>')
    path.write_text(text)
    robot = pc.Robot.load(path)
    assert robot.nq == 10
    assert np.isclose(np.linalg.norm(robot.random_configurations(1, 0)[0, 3:7]), 1)
    with pytest.raises(pc.PlannercheckError, match="give the root body a <freejoint/>"):
        pc.Robot.from_urdf(path, floating=True)


def test_commands_take_them(path, tmp_path):
    np.save(tmp_path / "q.npy", [[0.5, 0.1, 0.02]])
    robot = ("--robot", str(path))
    assert main(["inspect", *robot, "--states", "20"]) == 0
    assert main(["validate", *robot, str(tmp_path / "q.npy")]) == 0
    assert main(["view", *robot, "--html", str(tmp_path / "page.html")]) == 0
    assert main(["acm", *robot, "--states", "20", "--output", str(tmp_path / "arm.srdf")]) == 0
    assert main(["validate", *robot, "--srdf", str(tmp_path / "arm.srdf"), str(tmp_path / "q.npy")]) == 0


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('<asset><mesh name="tetra"', '<asset><mesh name="other"', r"MJCF .*arm\.xml"),
        ('type="hinge" axis="0 1 0"', 'type="screw" axis="0 1 0"', r"MJCF .*arm\.xml: can't be read"),
    ],
)
def test_what_can_not_be_read_is_named(path, old, new, message):
    path.write_text(MJCF.replace(old, new))
    with pytest.raises(pc.PlannercheckError, match=message):
        pc.Robot.load(path)


def test_ellipsoids_are_read(path):
    path.write_text(MJCF.replace('type="sphere" size="0.1"', 'type="ellipsoid" size="0.1 0.2 0.3"'))
    assert pc.Ellipsoid((0.1, 0.2, 0.3)) in [body.shape for body in pc.Robot.load(path).bodies]


def test_a_ball_joint_beside_others_is_refused(path):
    path.write_text(MJCF.replace('<joint name="turn"', '<joint name="ball" type="ball"/><joint name="turn"'))
    with pytest.raises(pc.PlannercheckError, match="holds a ball joint beside others: give it a body of its own"):
        pc.Robot.load(path)


def test_sdf_files_are_refused_with_what_to_do(tmp_path, capsys):
    path = tmp_path / "r.sdf"
    path.write_text('<?xml version="1.0"?><sdf version="1.9"><model name="r"><link name="a"/></model></sdf>')
    with pytest.raises(pc.PlannercheckError, match=r"r\.sdf is an SDF file, .*: convert it into a URDF"):
        pc.Robot.load(path)
    assert main(["inspect", "--robot", str(path)]) == 2
    assert "convert it into a URDF" in capsys.readouterr().err


def test_a_proof_is_confirmed_for_an_mjcf_file(path, tmp_path, capsys):
    """`verify --robot` reads a robot as `validate` does."""
    states, proof = tmp_path / "path.npy", tmp_path / "path.proof.json"
    np.save(states, [[1.0, 0.0, 0.01], [1.2, -0.3, 0.02]])
    assert main(["validate", "--robot", str(path), "--path", str(states), "--certify", "--proof", str(proof)]) == 0
    capsys.readouterr()
    assert main(["verify", str(proof), "--robot", str(path)]) == 0
    assert "model: confirmed" in capsys.readouterr().out
    for old, new, fault in (
        ('pos="0 0 0.8"', 'pos="0 0 0.9"', "joint turn is not as the MJCF has it"),
        ('axis="0 1 0"', 'axis="1 0 0"', "joint turn is not as the MJCF has it"),
        ('body name="tip"', 'body name="top"', "links of the proof and of the MJCF differ"),
        ('size="0.1" pos="0 0 0.3"', 'size="0.2" pos="0 0 0.3"', "has another shape than in the files"),
    ):
        other = tmp_path / "other.xml"
        changed = MJCF.replace(old, new)
        other.write_text(changed.replace('body2="tip"', 'body2="top"') if "top" in new else changed)
        assert main(["verify", str(proof), "--robot", str(other)]) == 1, new
        assert fault in capsys.readouterr().out
