"""Robots from files and bad input: errors name the file, the fault and what would be right."""

import shutil
import warnings
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from sample_robots import PANDA, PR2, PR2_SRDF, ROBOTS, SHARE, names_of, write_yaml

from plannercheck.cli.main import main
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.description import shipped_robots
from plannercheck.robots.link_bodies import read_bodies
from plannercheck.robots.robot import Robot
from plannercheck.robots.self_pairs import self_pairs
from plannercheck.robots.srdf import Srdf, read_srdf
from plannercheck.robots.urdf import read_model
from plannercheck.robots.urdf_file import UrdfFile

# ---- YAML files


def test_a_yaml_file_beside_its_urdf(arm):
    robot = Robot.load(
        write_yaml(
            arm,
            "name: little\nsrdf: arm.srdf\ngroup: arm\n"
            "reference: {turn: 0.5, lift: 1.0}\nheld: {grip: 0.25}\n"
            "disabled_pairs:\n- {reason: a spring between them, pairs: [[tip, base]]}\n",
        )
    )
    assert (robot.name, robot.group) == ("little", "arm")
    assert robot.reference.tolist() == [1.0, 0.5]
    assert robot.expand(robot.reference)[3] == 0.25
    assert ("base_0", "tip_0") not in names_of(robot)
    assert robot.disabled_pairs[0].reason == "a spring between them"


def test_a_urdf_can_be_loaded_directly(arm):
    assert Robot.load(str(arm[0])).name == "arm"
    assert Robot.load(PANDA).nq == 9


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("gruop: arm", "unknown key 'gruop'.*'group'"),
        ("srdf: other.srdf", "other.srdf does not exist"),
        ("group: arm", "without an SRDF"),
        ("group: on", "'group' must be a text, not True: put it in quotes"),
        ("group: 1.10", "planning group '1.10': without an SRDF"),
        ("group: {name: arm}", "'joints' is missing"),
        ("group: {joints: [lift, lift]}", "once"),
        ("group: {joints: [lfit]}", "unknown joint 'lfit'.*'lift'"),
        ("group: {joints: [weld]}", "unknown joint 'weld'"),
        ("group: {joints: [pinch]}", "'pinch' mimics 'grip'"),
        ("reference: {lift: 0.2}", "reference of joint 'lift' is 0.2, beyond its limits 0.5 to 1.5"),
        ("reference: {lift: .nan}", "'lift' needs 1 finite value"),
        ("reference: {lift: [1, 1]}", "'lift' needs 1 finite value"),
        ("reference: {lift: high}", "'lift' needs 1 finite value"),
        ("reference: {lift: true}", "'lift' needs 1 finite value .*not True"),
        ("held: {gripper: 0}", "unknown joint 'gripper'"),
        ("convex_decomposition: {most_pieces: 3.5}", "'most_pieces' must be a whole number, not 3.5"),
        ("held: [grip]", "held must be a mapping"),
        ("held: {turn: 0}", "held joint 'turn' is in the planning group, which moves it"),
        ("group: {joints: [lift, turn]}\nheld: {turn: 0}", "held joint 'turn' is in the planning group"),
        ("group: {joints: [lift]}\nheld: {turn: 0}\nreference: {turn: 1}", "'turn' is in reference and in held"),
        ("floating: maybe", "true or false"),
        ("disabled_pairs: [{pairs: [[base, tip]]}]", "'reason' is missing"),
        ("disabled_pairs: [{reason: r, pairs: [[base]]}]", "two links"),
        ("disabled_pairs: [{reason: r, pairs: [[base, top]]}]", "unknown link.*'top'"),
        ("disabled_pairs: {}", "must be a list"),
        ("name: [", "no valid YAML"),
    ],
)
def test_bad_yaml_names_the_file_and_the_fault(arm, text, message):
    path = write_yaml(arm, text)
    with pytest.raises(PlannercheckError, match=f"(?s)arm.yaml.*{message}"):
        Robot.load(path)


# ---- bad input


def test_unknown_robots_and_files():
    with pytest.raises(PlannercheckError, match="unknown robot 'pandas': did you mean 'panda'"):
        Robot.load("pandas")
    with pytest.raises(PlannercheckError, match=r"missing\.yaml does not exist"):
        Robot.load("missing.yaml")
    with pytest.raises(PlannercheckError, match=r"URDF missing\.urdf does not exist"):
        Robot.from_urdf("missing.urdf")


def test_missing_meshes_name_the_file_and_where_it_was_sought(tmp_path):
    assert len(Robot.from_urdf(PANDA).bodies) == len(Robot.load("panda").bodies)  # they are above the URDF
    alone = shutil.copy(PANDA, tmp_path)
    with pytest.raises(PlannercheckError, match=r"panda\.urdf.*link0\.stl.*package_dirs \(none given\)"):
        Robot.from_urdf(alone)
    with pytest.raises(PlannercheckError, match=r"package_dirs \(/nowhere\)"):
        Robot.from_urdf(alone, package_dirs="/nowhere")


def test_a_malformed_urdf_is_named_and_nothing_is_printed(capfd):
    with pytest.raises(PlannercheckError, match=r"ur3\.urdf has no <link>, nor a name: does it only define macros"):
        Robot.from_urdf(ROBOTS / "ur_description" / "urdf" / "ur3.urdf")
    assert capfd.readouterr() == ("", "")


def test_names_that_are_no_text(arm):
    arm[0].write_bytes(arm[0].read_bytes().replace(b'"turn"', b'"t\xffrn"'))
    with pytest.raises(PlannercheckError, match=r"arm\.urdf is not UTF-8 in line 13"):
        Robot.from_urdf(arm[0])


def test_loading_prints_nothing(capfd):
    Robot.from_urdf(PR2, PR2_SRDF, SHARE, group="right_arm")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("group", "message"),
    [
        ("amr", "unknown planning group 'amr'.*'arm'"),
        ("endless", "contains itself"),
        ("still", "no joint that moves"),
        ("wrong", "unknown joint of group 'wrong' 'trun'.*'turn'"),
        (["turn", "trun"], "unknown joint 'trun'"),
        ([], "once"),
    ],
)
def test_bad_groups(arm, group, message):
    with pytest.raises(PlannercheckError, match=message):
        Robot.from_urdf(*arm, group=group)


def test_bad_references_and_srdfs(arm):
    with pytest.raises(PlannercheckError, match=r"unknown group state 'flat'.*folded"):
        Robot.from_urdf(*arm, reference="flat")
    with pytest.raises(PlannercheckError, match="no SRDF"):
        Robot.from_urdf(arm[0], reference="folded")
    with pytest.raises(PlannercheckError, match=r"\(5,\), not \(3,\)"):
        Robot.from_urdf(arm[0], reference=np.zeros(3))
    arm[1].write_text("<robot")
    with pytest.raises(PlannercheckError, match=r"arm\.srdf does not parse"):
        Robot.from_urdf(*arm)


@pytest.mark.parametrize(
    ("q", "message"),
    [
        (np.zeros(6), r"\(7,\) or \(n, 7\), not \(6,\)"),
        (np.zeros((2, 8)), r"not \(2, 8\)"),
        (np.zeros((1, 2, 7)), r"not \(1, 2, 7\)"),
        (1.0, r"not \(\)"),
        ("left", "must be numbers"),
        ([[0.0] * 7, [0.0] * 6], "must be numbers"),
        (np.where(np.eye(3, 7, 2) > 0, np.nan, 0.0), "finite.*; row 0"),
        (np.where(np.eye(3, 7, -2) > 0, np.inf, 0.0), "finite.*; row 2"),
    ],
)
def test_bad_configurations(panda, q, message):
    for function in (panda.link_poses, panda.expand):
        with pytest.raises(PlannercheckError, match=message):
            function(q)


def test_unknown_links(panda):
    with pytest.raises(PlannercheckError, match="unknown link 'panda_hnad': did you mean 'panda_hand'"):
        panda.link_index("panda_hnad")


def test_cosine_and_sine_must_have_length_one(arm):
    robot = Robot.from_urdf(arm[0])
    q = robot.random_configurations(3, 0)
    robot.link_poses(q)
    q[1, 1] += 0.1
    with pytest.raises(PlannercheckError, match="columns 1 to 2 are cosine and sine, of length 1; in row 1"):
        robot.link_poses(q)


def test_a_planar_joint_is_two_positions_then_cosine_and_sine(tmp_path):
    (tmp_path / "cart.urdf").write_text(
        """<robot name="cart"><link name="floor"/>
<link name="cart"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
<joint name="drive" type="planar"><parent link="floor"/><child link="cart"/><axis xyz="0 0 1"/>
<limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>"""
    )
    robot = Robot.from_urdf(tmp_path / "cart.urdf")
    assert robot.check_configurations([5.0, 7.0, 0.6, 0.8]).shape == (1, 4)
    assert np.allclose(robot.link_poses([5.0, 7.0, 0.6, 0.8])[robot.link_index("cart"), :2, 3], [5, 7])
    for bad in ([5.0, 0.6, 0.8, 7.0], [0.6, 0.8, 5.0, 7.0], [0.6, 0.8, 0.6, 0.81]):
        with pytest.raises(PlannercheckError, match="columns 2 to 3 are cosine and sine"):
            robot.check_configurations(bad)
    q = robot.random_configurations(50, 1)
    assert np.allclose(np.linalg.norm(q[:, 2:], axis=1), 1, atol=1e-12)


@pytest.mark.parametrize("use", ["load", "a group and a state", "audit", "proposal"])
def test_an_srdf_is_parsed_once(use, arm, monkeypatch):
    parsed, parse = [], ElementTree.parse
    monkeypatch.setattr(ElementTree, "parse", lambda source: parsed.append(str(source)) or parse(source))
    if use == "load":
        Robot.from_urdf(*arm)
    elif use == "a group and a state":
        Robot.from_urdf(*arm, group="arm", reference="folded")
    else:
        how = ["--audit"] if use == "audit" else ["--output", str(arm[0].with_suffix(".new.srdf"))]
        main(["acm", "--robot", str(arm[0]), "--srdf", str(arm[1]), "--states", "10", *how])
    assert parsed.count(str(arm[1])) == 1


def test_self_pairs_leave_nothing_else_out(arm):
    model = read_model(arm[0])
    robot = Robot.from_urdf(arm[0])
    joints = read_bodies(model, UrdfFile.read(arm[0]), ()).joints
    pairs = self_pairs(joints, robot.bodies, Srdf(arm[1], read_srdf(arm[1])), robot.link_tree, ())
    assert len(pairs) == 10 - 2 - 1  # of five bodies: two pairs on one joint each, one disabled


def test_limits_the_wrong_way_round_are_named(tmp_path):
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(
        '<robot name="arm"><link name="base"/><link name="hand"/><joint name="elbow" type="revolute">'
        '<parent link="base"/><child link="hand"/><axis xyz="0 0 1"/>'
        '<limit lower="1" upper="-1" effort="1" velocity="1"/></joint></robot>'
    )
    with pytest.raises(PlannercheckError, match=r"elbow.*lower limit"):
        Robot.from_urdf(urdf)


@pytest.mark.parametrize("name", shipped_robots())
def test_shipped_robots_load_without_a_warning(name):
    """A stranger can do nothing about a warning on a file that comes with the package."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Robot.load(name)
