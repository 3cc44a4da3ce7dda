"""Several robots as one: columns, names and pairs of a cell, and its verdicts against robots merged by hand."""

import pickle

import numpy as np
import pytest
from merged_robots import Placed, merged
from poses import at
from sample_robots import PANDA, PANDA_SRDF, ROBOTS

import plannercheck as pc
from plannercheck.common.errors import PlannercheckError

UR5 = ROBOTS / "ur_description" / "urdf" / "ur5_robot.urdf"
UR5_SRDF = ROBOTS / "ur_description" / "srdf" / "ur5.srdf"


@pytest.fixture(scope="module")
def cell(panda):
    return pc.Robot.together({"left": panda, "right": (panda, at(0, 0.8))})


# ---- columns and names


def test_a_configuration_is_those_of_the_robots_side_by_side(panda, cell):
    q = panda.random_configurations(5, 0), panda.random_configurations(5, 1)
    both = cell.join({"left": q[0], "right": q[1]})
    assert np.array_equal(both, np.hstack(q))
    assert [part.columns.tolist() for part in cell.parts.values()] == [list(range(7)), list(range(7, 14))]
    assert cell.joint_names[7] == "right/panda_joint1"
    back = cell.split(both)
    assert np.array_equal(back["left"], q[0])
    assert np.array_equal(cell.split(both[0])["right"], q[1][0])
    assert np.array_equal(cell.join({"left": q[0][0], "right": q[1]})[4], np.hstack([q[0][0], q[1][4]]))


def test_each_robot_stands_at_its_pose(panda, cell):
    q = panda.random_configurations(5, 0)
    poses = cell.link_poses(cell.join({"left": q, "right": q}))
    n = len(panda.link_names)
    assert np.array_equal(poses[:, :n], panda.link_poses(q))
    assert np.abs(poses[:, n:] - at(0, 0.8) @ panda.link_poses(q)).max() < 1e-15


def test_a_group_moves_one_robot_and_holds_the_others(panda, cell):
    left = pc.Robot.together({"left": panda, "right": (panda, at(0, 0.8))}, group="left")
    assert (left.group, left.nq) == ("left", 7)
    q = panda.random_configurations(1, 3)[0]
    assert np.array_equal(left.join({"left": q}), q)
    assert left.parts["right"].columns.size == 0
    poses = left.link_poses(q)
    assert np.array_equal(poses, cell.link_poses(cell.join({"left": q, "right": panda.reference})))


def test_parts_hold_what_the_cell_holds_and_move_what_it_moves(panda, cell):
    other = cell.holding({"right/panda_finger_joint1": 0.01}).with_group(["right/panda_joint2", "left/panda_joint7"])
    right = other.parts["right"]
    assert (right.robot.joint_names, right.columns.tolist()) == (("panda_joint2",), [0])
    assert right.robot.expand(right.robot.reference)[7] == 0.01
    assert cell.parts["right"].robot.expand(panda.reference)[7] == 0.04
    held = cell.holding({"right/panda_finger_joint1": 0.02}).parts["right"].robot  # which moves all of its own group
    assert held.expand(panda.reference)[7] == 0.02


def test_robots_without_a_group_get_one_beside_a_robot_with_one(panda, arm):
    cell = pc.Robot.together({"a": panda, "b": (pc.Robot.load(arm[0]), at(3))})
    assert cell.joint_names[7:] == ("b/lift", "b/turn", "b/grip")
    assert cell.mimics["b/pinch"].leader == "b/grip"
    whole = pc.Robot.together({"b": pc.Robot.load(arm[0]), "c": (pc.Robot.load(arm[0]), at(3))})
    assert whole.group is None
    rows = whole.join({"b": [1.0, 0.5, 0.25], "c": [1.0, 0.5, 0.25]})  # one number a joint
    assert rows.shape == (whole.nq,)
    assert np.allclose(whole.link_poses(rows)[6:], at(3) @ whole.link_poses(rows)[:6], atol=1e-15)


def test_cells_of_cells_and_robots_that_do_not_move(panda, cell, tmp_path):
    (tmp_path / "table.urdf").write_text(
        '<robot name="table"><link name="top"><collision><geometry><box size="1 1 0.1"/></geometry></collision></link>'
        "</robot>"
    )
    table = pc.Robot.load(tmp_path / "table.urdf")
    both = pc.Robot.together({"cell": (cell, at(0, 0, 1)), "table": table})
    assert both.nq == 14
    assert both.parts["table"].columns.size == 0
    assert both.parts["cell"].robot.parts["left"].joint_names == cell.parts["left"].joint_names
    assert "cell/right/panda_hand" in both.link_names
    assert set(pickle.loads(pickle.dumps(both)).parts) == {"cell", "table"}


def test_the_planning_frame_is_no_base_that_stands_elsewhere(cell, tmp_path):
    text = (
        "fixed_frame_transforms: [{header: {frame_id: a}, child_frame_id: FRAME, transform: {translation: {x: 1, y: 0, "
        "z: 0}, rotation: {x: 0, y: 0, z: 0, w: 1}}}]\nworld: {collision_objects: []}\n"
    )
    for name, fits in (("left/panda_link0", True), ("right/panda_link0", False)):
        path = tmp_path / "scene.yaml"
        path.write_text(text.replace("FRAME", name))
        scene = pc.Scene.load(path)
        if fits:
            pc.Checker(cell, scene)
        else:
            with pytest.raises(PlannercheckError, match=r"planning frame .* 'right/panda_link0'"):
                pc.Checker(cell, scene)


def test_robots_keep_what_they_carry(panda):
    scene = pc.Scene()
    scene.attach("tool", "panda_hand", at(0, 0, 0.2), ["panda_leftfinger"], pc.Box((0.02, 0.02, 0.3)))
    scene.attach("tip", "panda_hand", at(0, 0, 0.5), ["tool"], pc.Sphere(0.01))
    cell = pc.Robot.together({"left": panda.carrying(scene.attached), "right": (panda, at(0.9))})
    assert [item.name for item in cell.carried] == ["left/tool", "left/tip"]
    pairs = {frozenset(cell.bodies[k].name for k in pair) for pair in cell.self_pairs.tolist()}
    assert frozenset(("left/tool", "right/panda_hand_0")) in pairs
    assert frozenset(("left/tool", "left/panda_link3_0")) in pairs
    assert frozenset(("left/tool", "left/panda_leftfinger_0")) not in pairs
    assert frozenset(("left/tool", "left/tip")) not in pairs
    alone = pc.Checker(panda.carrying(scene.attached))
    q = panda.random_configurations(2000, 4)
    far = pc.Robot.together({"left": panda.carrying(scene.attached), "right": (panda, at(9))})
    both = far.join({"left": q, "right": panda.reference})
    assert np.array_equal(pc.Checker(far).check_states(both), alone.check_states(q))
    both = cell.join({"left": q, "right": panda.reference})
    assert pc.Checker(cell).check_states(both).mean() < alone.check_states(q).mean()
    other = pc.Scene()
    other.attach("cup", "right/panda_hand", at(0, 0, 0.1), (), pc.Sphere(0.03))
    pc.Checker(cell, other)


def test_links_that_an_srdf_leaves_out_by_default_meet_no_other_robot(panda, arm):
    text = arm[1].read_text().replace("</robot>", '<disable_default_collisions link="tip"/></robot>')
    arm[1].write_text(text)
    cell = pc.Robot.together({"a": pc.Robot.from_urdf(*arm), "b": (panda, at(1))})
    met = {
        cell.bodies[k].link for pair in cell.self_pairs.tolist() for k in pair if cell.bodies[pair[1]].link[0] == "b"
    }
    assert "a/lower" in met
    assert "a/tip" not in met
    assert cell.default_links == ("a/tip",)


# ---- bad input


@pytest.mark.parametrize(
    ("robots", "message"),
    [
        ({}, "takes robots by name"),
        ([], "takes robots by name"),
        ({"a/b": "panda"}, "without slashes.*'a/b'"),
        ({"a b": "panda"}, "without slashes"),
        ({"all": "panda"}, "not 'all'"),
        ({"": "panda"}, "without slashes"),
        ({1: "panda"}, "without slashes"),
        ({"a": "panda"}, "robot 'a' of a cell must be a Robot"),
        ({"a": None, "b": None}, "'a', 'b' of a cell have no pose"),
        ({"a": None, "b": (None, None)}, "have no pose"),
        ({"a": None, "b": (None, 2 * np.eye(4))}, "pose of robot 'b'"),
        ({"a": None, "b": (None, np.diag([2.0, 1, 1, 1]))}, "pose of robot 'b' is not rigid"),
    ],
)
def test_bad_cells(panda, robots, message):
    if isinstance(robots, dict):
        robots = {name: _with(panda, given) for name, given in robots.items()}
    with pytest.raises(PlannercheckError, match=message):
        pc.Robot.together(robots)


def _with(panda, given):
    return panda if given is None else (panda, given[1]) if isinstance(given, tuple) else given


def test_bad_groups_joins_and_splits(panda, cell):
    with pytest.raises(PlannercheckError, match=r"unknown group of the cell 'lfet'.*'left'"):
        pc.Robot.together({"left": panda}, group="lfet")
    for given, message in (
        ({"left": panda.reference}, "missing: right"),
        ({"left": panda.reference, "rihgt": panda.reference}, "'rihgt'.*'right'"),
        ({"left": panda.reference, "right": [1, 2]}, r"robot 'right': .*\(7,\)"),
        ({"left": np.zeros((2, 7)), "right": np.zeros((3, 7))}, r"\[2, 3\]"),
    ):
        with pytest.raises(PlannercheckError, match=message):
            cell.join(given)
    for single in (lambda: panda.join({}), lambda: panda.split(panda.reference)):
        with pytest.raises(PlannercheckError, match="this is a single robot, and"):
            single()


# ---- verdicts


@pytest.mark.parametrize("second", ["panda", "ur5"])
def test_verdicts_are_those_of_one_urdf_merged_by_hand(second, panda, tmp_path):
    other = pc.Robot.load(second)
    files = {"panda": (PANDA, PANDA_SRDF), "ur5": (UR5, UR5_SRDF)}
    placed = {"left": Placed(*files["panda"]), "right": Placed(*files[second], (0.7, 0.1, 0.05), (0.1, -0.2, 2.5))}
    urdf, srdf = merged(placed, tmp_path)
    one = pc.Robot.from_urdf(urdf, srdf, package_dirs=ROBOTS.parents[1])
    base = one.link_poses(one.reference)[one.link_index(f"right/{other.link_names[0]}")]
    cell = pc.Robot.together({"left": panda, "right": (other, base)})
    held = {name: 0.04 for name in one.joint_names if "finger" in name}
    one = one.with_group(cell.joint_names).holding(held)
    assert {tuple(sorted((one.bodies[a].name, one.bodies[b].name))) for a, b in one.self_pairs} == {
        tuple(sorted((cell.bodies[a].name, cell.bodies[b].name))) for a, b in cell.self_pairs
    }
    q = cell.random_configurations(20_000, 5)
    verdicts = pc.Checker(cell).check_states(q)
    assert np.array_equal(verdicts, pc.Checker(one).check_states(q))
    assert 0.1 < verdicts.mean() < 0.9
