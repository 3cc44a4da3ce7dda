"""Robots load as Pinocchio sees them, groups hold what they should, and bad input is named."""

from __future__ import annotations

import pickle
import shutil
import struct
import time

import coal
import numpy as np
import pinocchio as pin
import pytest
from coal_hulls import CoalHulls

from plannercheck import kinematics
from plannercheck.errors import PlannercheckError
from plannercheck.paths import example_robot_data
from plannercheck.robot import Robot
from plannercheck.robot_files import shipped_robots
from plannercheck.self_pairs import self_pairs
from plannercheck.shapes import Box, Capsule, Cone, Cylinder, Hull, Sphere
from plannercheck.urdf import bodies_of, read_geometry, read_model

SHARE = example_robot_data()
ROBOTS = SHARE / "example-robot-data" / "robots"
PANDA = ROBOTS / "panda_description" / "urdf" / "panda.urdf"
PANDA_SRDF = ROBOTS / "panda_description" / "srdf" / "panda.srdf"
PR2 = ROBOTS / "pr2_description" / "urdf" / "pr2.urdf"
PR2_SRDF = ROBOTS / "pr2_description" / "srdf" / "pr2.srdf"
SHIPPED = {"panda", "ur3", "ur5", "ur10", "kinova", "baxter", "pr2", "tiago", "talos", "xarm7", "go2", "g1"}

# Part of the states in which a listed pair must be in contact if its reason says so.
ALWAYS = 0.98

ARM = """<robot name="arm">
<link name="base"><collision><geometry><box size="1 2 3"/></geometry></collision></link>
<link name="upper">
  <collision><origin xyz="0.1 0.2 0.3" rpy="1 0 0"/>
    <geometry><cylinder radius="0.1" length="0.5"/></geometry></collision>
  <collision><geometry><sphere radius="0.2"/></geometry></collision></link>
<link name="lower"><collision><geometry><sphere radius="0.4"/></geometry></collision></link>
<link name="tip">
  <collision><origin xyz="0 0 1"/><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<link name="finger"/><link name="thumb"/>
<joint name="lift" type="prismatic"><parent link="base"/><child link="upper"/><origin xyz="0 0 2"/>
  <axis xyz="0 0 1"/><limit lower="0.5" upper="1.5" effort="1" velocity="1"/></joint>
<joint name="turn" type="continuous"><parent link="upper"/><child link="lower"/><axis xyz="0 1 0"/></joint>
<joint name="weld" type="fixed"><parent link="lower"/><child link="tip"/></joint>
<joint name="grip" type="revolute"><parent link="tip"/><child link="finger"/>
  <axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="pinch" type="revolute"><parent link="tip"/><child link="thumb"/><axis xyz="1 0 0"/>
  <mimic joint="grip" multiplier="-2" offset="0.1"/>
  <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
</robot>"""

SRDF = """<robot name="arm">
<virtual_joint name="root" type="fixed" parent_frame="world" child_link="base"/>
<group name="arm"><chain base_link="base" tip_link="tip"/></group>
<group name="hand"><joint name="pinch"/><link name="finger"/></group>
<group name="backwards">
  <joint name="root"/><group name="hand"/><joint name="turn"/><joint name="lift"/></group>
<group name="across"><chain base_link="finger" tip_link="thumb"/></group>
<group name="endless"><group name="endless"/></group>
<group name="still"><joint name="weld"/></group>
<group name="wrong"><joint name="trun"/></group>
<group_state name="folded" group="arm">
  <joint name="lift" value="0.75"/><joint name="turn" value="2"/></group_state>
<disable_collisions link1="base" link2="lower" reason="User"/>
</robot>"""


@pytest.fixture
def arm(tmp_path):
    """Paths of a small URDF and its SRDF."""
    (tmp_path / "arm.urdf").write_text(ARM)
    (tmp_path / "arm.srdf").write_text(SRDF)
    return tmp_path / "arm.urdf", tmp_path / "arm.srdf"


@pytest.fixture(scope="module")
def shipped():
    return {name: Robot.load(name) for name in shipped_robots()}


def write_yaml(arm, text):
    path = arm[0].with_suffix(".yaml")
    path.write_text(f"urdf: arm.urdf\n{text}")
    return path


def names_of(robot):
    return {tuple(robot.bodies[i].name for i in pair) for pair in robot.self_pairs.tolist()}


# ---- what is shipped


def test_all_promised_robots_are_shipped():
    assert set(shipped_robots()) >= SHIPPED


@pytest.mark.parametrize("name", shipped_robots())
def test_shipped_robots_are_valid_at_their_reference_and_in_a_share_of_random_states(shipped, name):
    robot = shipped[name]
    hulls = CoalHulls(robot, robot.self_pairs)
    states = robot.expand(np.vstack([robot.reference, robot.random_configurations(40, 1)]))
    colliding = hulls.colliding(states)
    links = [[robot.bodies[i].link for i in robot.self_pairs[pair]] for pair in np.flatnonzero(colliding[0])]
    assert not links
    assert 1.0 - colliding.any(axis=1).mean() >= 0.05
    assert (robot.lower <= robot.reference).all()
    assert (robot.reference <= robot.upper).all()


@pytest.mark.parametrize("name", shipped_robots())
def test_shipped_disabled_pairs_have_their_reason(shipped, name):
    robot = shipped[name]
    whole = Robot(**{**robot._arguments(), "group": None, "joints": None})
    assert all(pair.reason for pair in robot.disabled_pairs)
    others = [pair for pair in robot.disabled_pairs if pair.reason != "adjacent"]
    for pair in robot.disabled_pairs:
        adjacent = {pair.link_a, pair.link_b} in [{*link} for link in robot._tree.parents.items()]
        assert adjacent == (pair.reason == "adjacent")
    if not others:
        return
    links = {frozenset((pair.link_a, pair.link_b)): row for row, pair in enumerate(others)}
    bodies = [[i for i, body in enumerate(robot.bodies) if body.link in pair] for pair in links]
    pairs = [(a, b, r) for r, own in enumerate(bodies) for a in own for b in own if _on_links(robot, a, b)]
    table = np.array(pairs, dtype=np.int64).reshape(-1, 3)
    colliding = CoalHulls(robot, table[:, :2]).colliding(whole.random_configurations(60, 2))
    for row, pair in enumerate(others):
        assert colliding[:, table[:, 2] == row].any(axis=1).mean() >= ALWAYS, pair


def _on_links(robot, a, b):
    return a < b and robot.bodies[a].link != robot.bodies[b].link


def test_panda_is_the_arm_with_open_fingers(shipped):
    panda = shipped["panda"]
    assert panda.joint_names == tuple(f"panda_joint{i}" for i in range(1, 8))
    assert panda.nq == 7
    assert len(panda.self_pairs) == 44
    full = panda.expand(np.arange(7.0) / 10)
    assert full.tolist() == [*(np.arange(7.0) / 10), 0.04, 0.04]
    assert panda.link_names[panda.link_index("panda_hand")] == "panda_hand"


def test_loading_is_quick():
    start = time.perf_counter()
    Robot.load("panda")
    assert time.perf_counter() - start < 1.0


# ---- as Pinocchio has it


@pytest.mark.parametrize("floating", [False, True])
@pytest.mark.parametrize("urdf", [PANDA, PR2])
def test_without_a_group_configurations_are_pinocchios(urdf, floating):
    robot = Robot.from_urdf(urdf, package_dirs=[SHARE], floating=floating)
    arguments = [pin.JointModelFreeFlyer()] if floating else []
    model = pin.buildModelFromUrdf(str(urdf), *arguments)
    assert robot.nq == model.nq
    assert robot.joint_names == tuple(model.names)[1:]
    assert robot.link_names == tuple(f.name for f in model.frames if f.type == pin.FrameType.BODY)
    finite = np.isfinite(robot.lower)
    assert np.array_equal(robot.lower[finite], model.lowerPositionLimit[finite])
    assert np.array_equal(robot.upper[finite], model.upperPositionLimit[finite])
    assert (finite | (model.lowerPositionLimit < -1e300)).all()
    q = robot.random_configurations(20, 3)
    assert np.array_equal(robot.expand(q), q)
    assert all(pin.isNormalized(model, row, 1e-12) for row in q)
    data = model.createData()
    for row, poses in zip(q, robot.link_poses(q), strict=True):
        pin.framesForwardKinematics(model, data, row)
        for name, pose in zip(robot.link_names, poses, strict=True):
            assert np.abs(pose - data.oMf[model.getFrameId(name)].homogeneous).max() < 1e-12


@pytest.mark.parametrize(("urdf", "srdf"), [(PANDA, PANDA_SRDF), (PR2, PR2_SRDF)])
def test_with_an_srdf_self_pairs_are_exactly_pinocchios(urdf, srdf):
    robot = Robot.from_urdf(urdf, srdf, [SHARE])
    geometry = pin.buildGeomFromUrdf(robot.model, str(urdf), pin.COLLISION, package_dirs=[str(SHARE)])
    geometry.addAllCollisionPairs()
    pin.removeCollisionPairs(robot.model, geometry, str(srdf))
    assert robot.self_pairs.tolist() == [[p.first, p.second] for p in geometry.collisionPairs]
    assert [body.name for body in robot.bodies] == [g.name for g in geometry.geometryObjects]


@pytest.mark.parametrize("name", ["panda", "laikago", "baxter"])
def test_bodies_are_where_pinocchio_has_them(name):
    urdf = next(path for path in ROBOTS.rglob("*.urdf") if path.stem == name)
    robot = Robot.from_urdf(urdf, package_dirs=[SHARE])
    geometry = pin.buildGeomFromUrdf(robot.model, str(urdf), pin.COLLISION, package_dirs=[str(SHARE)])
    data, placements = robot.model.createData(), geometry.createData()
    q = robot.random_configurations(1, 5)[0]
    pin.updateGeometryPlacements(robot.model, data, geometry, placements, q)
    poses = robot.link_poses(q)
    for body, truth in zip(robot.bodies, placements.oMg, strict=True):
        assert np.abs(poses[robot.link_index(body.link)] @ body.pose - truth.homogeneous).max() < 1e-12


def test_primitives_keep_their_sizes(arm):
    robot = Robot.from_urdf(arm[0])
    shapes = {body.name: body.shape for body in robot.bodies}
    assert shapes["base_0"] == Box((1.0, 2.0, 3.0))
    assert shapes["upper_0"] == Cylinder(0.1, 0.5)
    assert shapes["upper_1"] == Sphere(0.2)
    assert shapes["lower_0"] == Sphere(0.4)
    assert [body.link for body in robot.bodies] == ["base", "upper", "upper", "lower", "tip"]


def body_of(shape):
    """The body of one of coal's shapes on a link."""
    model, collection = pin.Model(), pin.GeometryModel()
    frame = model.addBodyFrame("link", 0, pin.SE3.Identity(), -1)
    collection.addGeometryObject(pin.GeometryObject("it", 0, frame, pin.SE3.Identity(), shape))
    return bodies_of(model, collection)[0]


def test_shapes_that_only_coal_knows():
    assert body_of(coal.Capsule(0.1, 0.7)).shape == Capsule(0.1, 0.7)
    assert body_of(coal.Cone(0.3, 0.8)).shape == Cone(0.3, 0.8)
    with pytest.raises(PlannercheckError, match="'it' is a Ellipsoid; known are boxes"):
        body_of(coal.Ellipsoid(1.0, 2.0, 3.0))


def test_collision_shapes_that_urdfdom_drops_are_an_error(arm):
    arm[0].write_text(ARM.replace('<sphere radius="0.4"/>', '<capsule radius="0.4" length="1"/>'))
    with pytest.raises(PlannercheckError, match=r"0 of 1 .*link 'lower' could be read; .*Could not parse collision"):
        Robot.from_urdf(arm[0])


def test_meshes_come_with_their_scale(tmp_path):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], dtype=np.float32)
    facets = [corners[list(f)] for f in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))]
    content = b"".join(struct.pack("<12fH", 0, 0, 0, *facet.ravel(), 0) for facet in facets)
    (tmp_path / "corner.stl").write_bytes(bytes(80) + struct.pack("<I", 4) + content)
    mesh = '<mesh filename="package://corner.stl" scale="2 10 -1"/>'
    (tmp_path / "one.urdf").write_text(
        f'<robot name="one"><link name="a"><collision><geometry>{mesh}</geometry></collision></link></robot>'
    )
    shape = Robot.from_urdf(tmp_path / "one.urdf", package_dirs=tmp_path).bodies[0].shape
    assert isinstance(shape, Hull)
    assert {tuple(v) for v in shape.vertices.tolist()} == {tuple(v) for v in (corners * [2, 10, -1]).tolist()}


def test_without_an_srdf_adjacent_links_are_left_out(arm):
    robot = Robot.from_urdf(arm[0])
    assert names_of(robot) == {
        ("base_0", "lower_0"),
        ("base_0", "tip_0"),
        ("upper_0", "tip_0"),
        ("upper_1", "tip_0"),
    }


def test_an_srdf_alone_says_which_pairs_are_left_out(arm):
    pairs = names_of(Robot.from_urdf(*arm))
    assert ("base_0", "upper_0") in pairs
    assert ("base_0", "lower_0") not in pairs


# ---- groups


def test_chains_leave_fixed_joints_out_and_continuous_joints_are_one_angle(arm):
    robot = Robot.from_urdf(*arm, group="arm")
    assert robot.joint_names == ("lift", "turn")
    assert robot.lower.tolist() == [0.5, -np.inf]
    assert robot.upper.tolist() == [1.5, np.inf]
    assert np.allclose(robot.expand([1.0, 0.3]), [1.0, np.cos(0.3), np.sin(0.3), 0.0, 0.1], atol=1e-16)
    q = robot.random_configurations(1000, 0)
    assert np.abs(q[:, 1]).max() <= np.pi
    assert q[:, 0].min() >= 0.5


def test_groups_keep_the_order_of_the_document(arm):
    robot = Robot.from_urdf(*arm, group="backwards")
    assert robot.joint_names == ("grip", "turn", "lift")
    full = robot.expand([[0.5, 0.2, 0.9]])
    assert np.allclose(full, [[0.9, np.cos(0.2), np.sin(0.2), 0.5, -0.9]], atol=1e-15)
    assert Robot.from_urdf(*arm, group="across").joint_names == ("grip",)
    assert Robot.from_urdf(arm[0], group=["turn", "lift"]).joint_names == ("turn", "lift")


def test_the_groups_of_pr2s_srdf():
    robot = Robot.from_urdf(PR2, PR2_SRDF, SHARE, group="right_arm", reference="tuck_left_arm")
    assert robot.joint_names[0] == "r_shoulder_pan_joint"
    assert robot.nq == 7
    state = robot.expand(np.zeros(7))
    index = robot.model.joints[robot.model.getJointId("l_elbow_flex_joint")].idx_q
    assert state[index] == -1.68339


def test_held_joints_are_at_the_reference(arm):
    by_name = Robot.from_urdf(*arm, group=["grip"], reference={"lift": 1.25, "turn": 1.0})
    by_state = Robot.from_urdf(*arm, group=["grip"], reference="folded")
    whole = [0.75, np.cos(2.0), np.sin(2.0), 0.0, 0.1]
    by_array = Robot.from_urdf(*arm, group=["grip"], reference=whole)
    assert np.allclose(by_name.expand([0.0]), [1.25, np.cos(1.0), np.sin(1.0), 0.0, 0.1])
    assert np.allclose(by_state.expand([0.0]), whole)
    assert np.allclose(by_array.expand([0.0]), whole)
    assert by_name.reference.tolist() == [0.0]
    assert by_name.holding({"lift": 7.0}).expand([0.0])[0] == 7.0  # beyond the limit, on request


def test_without_a_reference_joints_are_neutral_within_their_limits(arm):
    robot = Robot.from_urdf(arm[0])
    assert np.allclose(robot.reference, [0.5, 1.0, 0.0, 0.0, 0.1])
    assert Robot.from_urdf(arm[0], group=["lift", "turn"]).reference.tolist() == [0.5, 0.0]


def test_mimics_of_held_joints_follow_or_are_as_given(arm):
    robot = Robot.from_urdf(arm[0], group=["turn"], reference={"grip": 0.5})
    assert robot.expand([0.0])[-2:].tolist() == [0.5, -0.9]
    assert robot.holding({"grip": -0.5}).expand([0.0])[-2:].tolist() == [-0.5, 1.1]
    assert robot.holding({"pinch": 0.3}).expand([0.0])[-2:].tolist() == [0.5, 0.3]


def test_a_floating_base_in_a_group(arm):
    robot = Robot.from_urdf(arm[0], group=["turn", "root_joint"], floating=True)
    assert robot.nq == 8
    q = robot.random_configurations(50, 1)
    assert np.allclose(np.linalg.norm(q[:, 4:], axis=1), 1.0)
    assert np.abs(robot.link_poses(q) - robot.pinocchio_link_poses(q)).max() < 1e-13
    with pytest.raises(PlannercheckError, match=r"quaternion.*row 3"):
        robot.link_poses(np.where(np.arange(50)[:, None] == 3, 2 * q, q))


def test_random_configurations_are_reproducible_and_within_limits(shipped):
    for robot in shipped.values():
        q = robot.random_configurations(200, 7)
        assert q.shape == (200, robot.nq)
        assert np.array_equal(q, robot.random_configurations(200, 7))
        assert not np.array_equal(q, robot.random_configurations(200, 8))
        assert ((robot.lower <= q) & (q <= robot.upper)).all()


def test_with_group_and_pickle_keep_the_robot(shipped):
    for robot in (shipped["tiago"], shipped["panda"].with_group(["panda_joint7", "panda_finger_joint1"])):
        copy = pickle.loads(pickle.dumps(robot))
        q = robot.random_configurations(5, 0)
        assert np.array_equal(copy.link_poses(q), robot.link_poses(q))
        assert copy.joint_names == robot.joint_names
        assert np.array_equal(copy.self_pairs, robot.self_pairs)
        assert [body.name for body in copy.bodies] == [body.name for body in robot.bodies]


def test_pinocchio_poses_robots_that_the_kernel_does_not_know(monkeypatch, arm):
    truth = Robot.from_urdf(arm[0])
    monkeypatch.setattr(kinematics, "_SLIDES", ())
    robot = Robot.from_urdf(arm[0])
    assert robot.kinematics is None
    q = robot.random_configurations(4, 0)
    assert np.allclose(robot.link_poses(q), truth.link_poses(q), atol=1e-14)


def test_a_kernel_that_disagrees_is_not_used(monkeypatch, arm):
    monkeypatch.setitem(kinematics._UNIT_TURNS, "RUBY", 0)
    with pytest.warns(RuntimeWarning, match="differs from Pinocchio"):
        robot = Robot.from_urdf(arm[0])
    assert robot.kinematics is None


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
        ("group: {name: arm}", "'joints' is missing"),
        ("group: {joints: [lift, lift]}", "once"),
        ("group: {joints: [lfit]}", "unknown joint 'lfit'.*'lift'"),
        ("group: {joints: [weld]}", "unknown joint 'weld'"),
        ("group: {joints: [pinch]}", "'pinch' mimics 'grip'"),
        ("reference: {lift: 0.2}", "reference of joint 'lift' is 0.2, beyond its limits 0.5 to 1.5"),
        ("reference: {lift: .nan}", "'lift' needs 1 finite value"),
        ("reference: {lift: [1, 1]}", "'lift' needs 1 finite value"),
        ("reference: {lift: high}", "'lift' needs 1 finite value"),
        ("held: {gripper: 0}", "unknown joint 'gripper'"),
        ("held: [grip]", "held must be a mapping"),
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
    with pytest.raises(PlannercheckError, match=r"ur3\.urdf does not parse: .*No name given"):
        Robot.from_urdf(ROBOTS / "ur_description" / "urdf" / "ur3.urdf")
    assert capfd.readouterr() == ("", "")


def test_names_that_are_no_text(arm):
    arm[0].write_bytes(arm[0].read_bytes().replace(b'"turn"', b'"t\xffrn"'))
    with pytest.raises(PlannercheckError, match=r"arm\.urdf: the name of a link or joint is not UTF-8"):
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
def test_bad_configurations(shipped, q, message):
    for function in (shipped["panda"].link_poses, shipped["panda"].expand):
        with pytest.raises(PlannercheckError, match=message):
            function(q)


def test_unknown_links(shipped):
    with pytest.raises(PlannercheckError, match="unknown link 'panda_hnad': did you mean 'panda_hand'"):
        shipped["panda"].link_index("panda_hnad")


def test_cosine_and_sine_must_have_length_one(arm):
    robot = Robot.from_urdf(arm[0])
    q = robot.random_configurations(3, 0)
    robot.link_poses(q)
    q[1, 1] += 0.1
    with pytest.raises(PlannercheckError, match="columns 1 to 2 are cosine and sine, of length 1; in row 1"):
        robot.link_poses(q)


def test_self_pairs_leave_nothing_else_out(arm):
    model = read_model(arm[0])
    geometry = read_geometry(model, arm[0], ())
    robot = Robot.from_urdf(arm[0])
    pairs = self_pairs(model, geometry, robot.bodies, arm[1], robot._tree, ())
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
