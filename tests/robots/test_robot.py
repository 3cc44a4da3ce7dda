"""Robots load as Pinocchio sees them, groups hold what they should, and bad input is named."""

import pickle
import struct
import time

import numpy as np
import pinocchio as pin
import pytest
from coal_hulls import CoalHulls
from sample_robots import PANDA, PANDA_SRDF, PR2, PR2_SRDF, ROBOTS, SHARE, names_of

from plannercheck.bodies.shapes import Box, Cylinder, Hull, Sphere
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots import kinematics
from plannercheck.robots.description import shipped_robots
from plannercheck.robots.joints import CIRCLE, SLIDE, kind_of, number_of
from plannercheck.robots.robot import Robot

SHIPPED = {"panda", "ur3", "ur5", "ur10", "kinova", "baxter", "pr2", "tiago", "talos", "xarm7", "go2", "g1"}

# Part of the states in which a listed pair must be in contact if its reason says so.
ALWAYS = 0.98


@pytest.fixture(scope="module")
def shipped():
    return {name: Robot.load(name) for name in shipped_robots()}


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
    whole = robot._changed(group=None, joints=None)
    assert all(pair.reason for pair in robot.disabled_pairs)
    others = [pair for pair in robot.disabled_pairs if pair.reason != "adjacent"]
    for pair in robot.disabled_pairs:
        adjacent = {pair.link_a, pair.link_b} in [{*link} for link in robot.link_tree.parents.items()]
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
    assert names_of(robot) == {("base_0", "lower_0"), ("base_0", "tip_0"), ("upper_0", "tip_0"), ("upper_1", "tip_0")}


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


def test_followers_that_were_held_apart_follow_what_is_held_anew():
    """robots/panda.yaml gives both fingers: whoever holds the first elsewhere means both, as a trajectory does."""
    panda = Robot.load("panda")
    closed = panda.holding({"panda_finger_joint1": 0.01})
    assert closed.expand(panda.reference)[-2:].tolist() == [0.01, 0.01]
    assert closed.holding({"panda_joint1": 1.0}).expand(panda.reference)[-2:].tolist() == [0.01, 0.01]
    apart = panda.holding({"panda_finger_joint1": 0.01, "panda_finger_joint2": 0.03})
    assert apart.expand(panda.reference)[-2:].tolist() == [0.01, 0.03]
    assert panda.holding({"panda_finger_joint2": 0.03}).expand(panda.reference)[-2:].tolist() == [0.04, 0.03]


def test_a_mimic_of_a_mimic_follows_with_both_multipliers_and_offsets(tmp_path):
    path = tmp_path / "row.urdf"
    mimics = {2: (1, -2.0, 0.25), 3: (2, 3.0, 0.125), 4: (3, 0.5, -1.0)}
    joints = "".join(
        f"""<joint name="j{k}" type="prismatic"><parent link="l{k - 1}"/><child link="l{k}"/><axis xyz="0 0 1"/>
<limit lower="-99" upper="99" effort="1" velocity="1"/>"""
        + (
            f'<mimic joint="j{mimics[k][0]}" multiplier="{mimics[k][1]}" offset="{mimics[k][2]}"/>'
            if k in mimics
            else ""
        )
        + "</joint>"
        for k in (1, 2, 3, 4)
    )
    links = "".join(f'<link name="l{k}"/>' for k in range(5))
    path.write_text(f'<robot name="row">{links}{joints}</robot>')
    robot = Robot.from_urdf(path, group=["j1"])
    for value in (0.0, 1.0, -0.75):
        values = {1: value}
        for k, (leader, multiplier, offset) in mimics.items():
            values[k] = multiplier * values[leader] + offset
        assert robot.expand([value]).tolist() == [values[k] for k in (1, 2, 3, 4)]
        heights = robot.link_poses([value])[:, 2, 3]
        np.testing.assert_array_equal(heights, np.cumsum([0, *values.values()]))


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
    monkeypatch.setattr(kinematics, "number_of", lambda joint: None if kind_of(joint) is SLIDE else number_of(joint))
    robot = Robot.from_urdf(arm[0])
    assert robot.kinematics is None
    q = robot.random_configurations(4, 0)
    assert np.allclose(robot.link_poses(q), truth.link_poses(q), atol=1e-14)


def test_a_kernel_that_disagrees_is_not_used(monkeypatch, arm):
    wrong = {"JointModelRUBY": CIRCLE.first}
    monkeypatch.setattr(kinematics, "number_of", lambda joint: wrong.get(joint.shortname(), number_of(joint)))
    with pytest.warns(RuntimeWarning, match="differs from Pinocchio"):
        robot = Robot.from_urdf(arm[0])
    assert robot.kinematics is None
