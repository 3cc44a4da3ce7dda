"""Objects of MoveIt scenes stand where MoveIt has them, whatever frame they are posed in; other frames are refused.

The conventions are those of MoveIt's own sources (moveit2, moveit_core): `Transforms::copyTransforms` and
`Transforms::setTransform` in transforms.cpp for fixed frames; `PlanningScene::getFrameTransform`,
`RobotState::getFrameInfo` and `World::getTransform` for the order in which names are looked up;
`PlanningScene::processCollisionObjectAdd` and `processAttachedCollisionObjectMsg` for what happens with the pose.
Expected poses are composed with Pinocchio alone.
"""

import copy
import pickle
import warnings

import numpy as np
import pytest
import yaml
from moveit_messages import (
    EXPORTED,
    IDENTITY,
    MAP,
    OFFSET,
    SHORT,
    STATE,
    TAG,
    ball,
    body_pose,
    configuration,
    fixed,
    link_pose,
    numbers_of,
    pose_node,
    scene_of,
    se3,
    state_of,
)

from plannercheck.cli.main import main
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot
from plannercheck.scenes.moveit_messages import header_frame
from plannercheck.scenes.scene import Scene

# --- fixed frames ---------------------------------------------------------------------------------------------------


def test_transforms_lead_from_the_frame_of_their_header_to_the_planning_frame():
    scene = scene_of(
        ball("here", "panda_link0", OFFSET), ball("mapped", "map", OFFSET), ball("tagged", "vicon/tag/tag", OFFSET)
    )
    found = {body.name: body.pose for body in scene.bodies}
    for name, frame in (("here", IDENTITY), ("mapped", MAP), ("tagged", TAG)):
        np.testing.assert_allclose(found[name], se3(frame) @ se3(OFFSET), atol=1e-15, err_msg=name)


def test_an_exported_scene_keeps_its_collisions(panda, tmp_path):
    """Balls in the hand at 40 states, in a file of the form that MoveIt and robowflex write."""
    rng = np.random.default_rng(5)
    states = panda.random_configurations(40, 5)
    frames = {"panda_link0": np.eye(4), "map": se3(MAP), "vicon/tag/tag": se3(TAG)}
    for q in states:
        values = dict(zip(panda.joint_names, q.tolist(), strict=True)) | {"panda_finger_joint1": 0.04}
        hand = link_pose(panda, "panda_hand", values) @ se3([*rng.uniform(-0.02, 0.02, 2), 0.04, 0, 0, 0, 1])
        for frame, matrix in frames.items():
            document = {
                "name": "(noname)+",
                "robot_model_name": "panda",
                "fixed_frame_transforms": EXPORTED,
                "robot_state": state_of(),
                "world": {"collision_objects": [ball("ball", frame, numbers_of(np.linalg.inv(matrix) @ hand))]},
            }
            file = tmp_path / "scene.yaml"
            file.write_text(yaml.safe_dump(document))
            assert not Checker(panda, Scene.load(file), self_collision=False).is_valid(q)


def test_the_default_header_of_robowflex_is_the_world(panda):
    """robowflex leaves out headers of frame "world" (`isHeaderEmpty` in its yaml.cpp)."""
    without_header = {k: v for k, v in fixed("world", IDENTITY, "base").items() if k != "header"}
    for transforms in ([], [without_header], [fixed("world", IDENTITY, "world")], EXPORTED):
        (body,) = scene_of(ball("a", None, OFFSET), transforms=transforms).bodies
        np.testing.assert_array_equal(body.pose, scene_of(ball("a", "world", OFFSET), transforms=[]).bodies[0].pose)
    moved = [fixed("world", MAP, "base")]
    (body,) = scene_of(ball("a", "world", OFFSET), transforms=moved).bodies
    np.testing.assert_allclose(body.pose, se3(MAP) @ se3(OFFSET), atol=1e-15)
    with pytest.raises(PlannercheckError, match=r"'a': its header names no frame, which could be 'world' or .* 'base'"):
        scene_of(ball("a", None, OFFSET), transforms=moved)


@pytest.mark.parametrize("given", [0, False])
def test_a_frame_that_is_called_0_is_not_left_out(given):
    if given is False:  # YAML's no and off
        with pytest.raises(PlannercheckError, match="'frame_id' must be a text, not False: put it in quotes"):
            header_frame({"header": {"frame_id": given}})
    else:
        assert header_frame({"header": {"frame_id": given}}) == "0"


def test_leading_slashes_are_dropped(panda):
    """As `PlanningScene::getFrameTransform` does, all of them."""
    scene = scene_of(ball("a", "//map", OFFSET), ball("b", "/panda_link0", OFFSET), ball("c", "/a", SHORT))
    poses = [body.pose for body in scene.bodies]
    np.testing.assert_allclose(poses[0], se3(MAP) @ se3(OFFSET), atol=1e-15)
    np.testing.assert_allclose(poses[1], se3(OFFSET), atol=1e-15)
    np.testing.assert_allclose(poses[2], se3(MAP) @ se3(OFFSET) @ se3(SHORT), atol=1e-15)


@pytest.mark.parametrize(
    ("transforms", "message"),
    [
        ([fixed("map", MAP), fixed("tag", TAG, "odom")], "fixed_frame_transforms 1: child_frame_id is 'odom', but all"),
        ([fixed("map", MAP), fixed("/map", TAG)], "fixed_frame_transforms 1: frame 'map' has another transform"),
        ([fixed("panda_link0", MAP)], "the planning frame 'panda_link0' must be at the identity"),
        ([fixed("map", MAP, "")], "child_frame_id is '', but all have to name the planning frame"),
        ([{**fixed("map", MAP), "frame_id": "map"}], "unknown key 'frame_id'"),
        ([{**fixed("map", MAP), "header": {"frame": "map"}}], "unknown key 'frame'"),
        ([fixed("map", [0, 0, 0, 0, 0, 0, 0])], "fixed_frame_transforms 0: quaternion .* has no direction"),
    ],
)
def test_transforms_that_contradict_each_other_are_refused(transforms, message):
    with pytest.raises(PlannercheckError, match=message):
        scene_of(transforms=transforms)


def test_the_planning_frame_is_the_root_or_no_link_at_all(panda):
    for planning in ("panda_link0", "odom"):
        Checker(panda, scene_of(transforms=[fixed(planning, IDENTITY, planning)]))
    with pytest.raises(
        PlannercheckError, match=r"planning frame .* is 'panda_hand', a link of 'panda', but not its root"
    ):
        Checker(panda, scene_of(transforms=[fixed("map", MAP, "panda_hand")]))


def test_the_planning_frame_may_be_a_link_that_is_fixed_where_the_root_is():
    for name, link in (("ur10", "base_link"), ("panda", "panda_link0")):
        checker = Checker(Robot.load(name), scene_of(ball("a", link, OFFSET), transforms=[fixed("map", MAP, link)]))
        np.testing.assert_allclose(checker.scene.object("a").pose, se3(OFFSET), atol=1e-15)
    with pytest.raises(PlannercheckError, match="'base', a link of 'ur10'"):  # turned by half a turn
        Checker(Robot.load("ur10"), scene_of(transforms=[fixed("map", MAP, "base")]))


def test_unknown_frames_are_refused_with_those_that_are_known(panda):
    scene = scene_of(ball("a", "map", OFFSET), ball("b", "mop", OFFSET), state=state_of())
    with pytest.raises(
        PlannercheckError, match=r"frame of object 'b' 'mop': did you mean 'map'.* panda_link0, map, .*, a"
    ):
        Checker(panda, scene)


def test_a_name_of_a_frame_and_of_a_link_is_refused(panda):
    """`PlanningScene::getFrameTransform` would take the link, which a file can't know."""
    for scene in (
        scene_of(ball("a", "panda_hand", OFFSET), transforms=[*EXPORTED, fixed("panda_hand", MAP)]),
        scene_of(ball("panda_hand", "map", OFFSET), ball("b", "panda_hand", OFFSET)),
    ):
        with pytest.raises(
            PlannercheckError, match=r"frame 'panda_hand' .* also a link of 'panda', which MoveIt would"
        ):
            Checker(panda, scene)


# --- links ----------------------------------------------------------------------------------------------------------


def test_an_obstacle_in_a_links_frame_stands_where_the_link_is_at_the_scenes_state(panda):
    checker = Checker(panda, scene_of(ball("ball", "panda_hand", SHORT), state=state_of()))
    here = configuration(panda)
    expected = link_pose(panda, "panda_hand") @ se3(SHORT)
    np.testing.assert_allclose(body_pose(checker, "ball", here), expected, atol=1e-14)
    assert not checker.is_valid(here)
    assert {pair.second for pair in checker.explain(here).collisions} == {"ball"}
    away = here + np.array([2.0, 0, 0, 0, 0, 0, 0])
    np.testing.assert_array_equal(body_pose(checker, "ball", away), body_pose(checker, "ball", here))  # it stands still
    assert checker.is_valid(away) == Checker(panda).is_valid(away)


@pytest.mark.parametrize("group", [None, ["panda_joint4"], ["panda_finger_joint1", "panda_joint2"]])
def test_the_state_counts_not_where_the_robot_holds_its_joints(panda, group):
    robot = panda if group is None else panda.with_group(group)
    robot = robot.holding({"panda_joint1": -1.0, "panda_finger_joint1": 0.0})
    checker = Checker(robot, scene_of(ball("ball", "panda_leftfinger", SHORT), state=state_of()))
    expected = link_pose(panda, "panda_leftfinger") @ se3(SHORT)
    np.testing.assert_allclose(checker.scene.object("ball").pose, expected, atol=1e-14)


def test_no_warning_is_given_for_what_is_placed(panda):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Checker(panda, scene_of(*(ball(f"b{k}", "panda_hand", SHORT) for k in range(3)), state=state_of()))


def test_states_have_to_say_where_the_link_is(panda):
    below = {name: STATE[name] for name in ("panda_joint1", "panda_joint2", "panda_joint3")}
    scene = scene_of(ball("ball", "panda_link3", SHORT), state=state_of(below))
    np.testing.assert_allclose(
        Checker(panda, scene).scene.object("ball").pose, link_pose(panda, "panda_link3", below) @ se3(SHORT), atol=1e-14
    )
    for state in (state_of(below), {}, {"is_diff": True}):
        with pytest.raises(
            PlannercheckError, match=r"'ball' is posed in frame 'panda_link5', and .* no value for .*joint5"
        ):
            Checker(panda, scene_of(ball("ball", "panda_link5", SHORT), state=state))
    lacking = {name: value for name, value in STATE.items() if name != "panda_joint2"}
    with pytest.raises(
        PlannercheckError, match=r"gives no value for panda_joint2, which says where that is: give it in"
    ):
        Checker(panda, scene_of(ball("ball", "panda_hand", SHORT), state=state_of(lacking)))


def test_followers_follow_and_root_links_need_no_state(panda):
    checker = Checker(panda, scene_of(ball("ball", "panda_rightfinger", SHORT), state=state_of()))
    expected = link_pose(panda, "panda_rightfinger") @ se3(SHORT)
    np.testing.assert_allclose(checker.scene.object("ball").pose, expected, atol=1e-14)
    at_root = Checker(panda, scene_of(ball("ball", "panda_link0", OFFSET), transforms=[]))
    np.testing.assert_allclose(at_root.scene.object("ball").pose, se3(OFFSET), atol=1e-15)


URDF = """<robot name="chain"><link name="base"/><link name="drone"/><link name="arm"/>
<joint name="flight" type="floating"><parent link="base"/><child link="drone"/>
<origin xyz="0 0 1" rpy="0 0 0.5"/></joint>
<joint name="elbow" type="continuous"><parent link="drone"/><child link="arm"/>
<origin xyz="0.5 0 0" rpy="0.1 0 0"/><axis xyz="0 1 0"/></joint></robot>"""


def test_joints_of_several_degrees_of_freedom_have_to_be_given_unless_they_are_the_root(tmp_path):
    (tmp_path / "chain.urdf").write_text(URDF)
    identity = {"translation": [0, 0, 0], "rotation": [0, 0, 0, 1]}
    given = {"joint_names": ["flight"], "transforms": [identity]}
    expected = se3([0, 0, 1, 0, 0, np.sin(0.25), np.cos(0.25)]) @ se3([0.5, 0, 0, np.sin(0.05), 0, 0, np.cos(0.05)])
    expected = expected @ se3([0, 0, 0, 0, np.sin(0.35), 0, np.cos(0.35)]) @ se3(SHORT)
    for floating in (False, True):
        robot = Robot.from_urdf(tmp_path / "chain.urdf", floating=floating)
        state = state_of({"elbow": 0.7})
        if floating:  # the scene's state has the root at the identity, wherever the robot is held
            robot = robot.holding({"root_joint": [1.0, 2.0, 3.0, 0.0, 0.0, 1.0, 0.0]})
        scene = scene_of(ball("a", "arm", SHORT), transforms=[], state={**state, "multi_dof_joint_state": given})
        np.testing.assert_allclose(Checker(robot, scene).scene.object("a").pose, expected, atol=1e-14)
    with pytest.raises(PlannercheckError, match="no value for flight"):
        Checker(robot, scene_of(ball("a", "arm", SHORT), transforms=[], state=state_of({"elbow": 0.7})))


@pytest.mark.parametrize(
    ("state", "message"),
    [
        ({"joint_state": {"name": ["a", "a"], "position": [1, 2]}}, "joint_state names a joint twice"),
        ({"joint_state": {"name": ["a"], "position": []}}, "joint_state: 'position' needs 1 numbers"),
        ({"joint_states": {}}, "robot_state: unknown key 'joint_states'"),
        (
            {"multi_dof_joint_state": {"joint_names": ["v"], "transforms": []}},
            "robot_state: multi_dof_joint_state: 1 joint_names, but 0 transforms",
        ),
        (
            {
                "multi_dof_joint_state": {
                    "header": {"frame_id": "map"},
                    "joint_names": ["v"],
                    "transforms": [{"translation": [0, 0, 0], "rotation": [0, 0, 0, -1]}],
                }
            },
            "multi_dof_joint_state is in frame 'map': only the planning frame 'panda_link0'",
        ),
    ],
)
def test_bad_states_are_named(state, message):
    with pytest.raises(PlannercheckError, match=message):
        scene_of(ball("ball", "panda_hand", SHORT), state=state)


# --- scenes before and after ----------------------------------------------------------------------------------------


def test_scenes_without_a_robot_say_what_is_not_placed_yet(panda, tmp_path):
    scene = scene_of(ball("ball", "panda_hand", SHORT), ball("post", "map", OFFSET), state=state_of())
    assert repr(scene) == "Scene('', 2 objects, 2 bodies)"
    assert scene.body_objects == scene.object_names == ("ball", "post")
    said = r"object 'ball' is posed in frame 'panda_hand' at a state of the robot: build a checker, whose scene"
    for ask in (lambda: scene.bodies, lambda: scene.save(tmp_path / "s.yaml")):
        with pytest.raises(PlannercheckError, match=said):
            ask()
    expected = Checker(panda, scene).scene.object("ball").pose
    for other in (scene.copy(), copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        np.testing.assert_array_equal(Checker(panda, other).scene.object("ball").pose, expected)
    assert scene.object("ball").pose_frame is not None  # a checker has a copy
    scene.move("ball", se3(OFFSET))
    np.testing.assert_array_equal(scene.bodies[0].pose, se3(OFFSET))


def test_checkers_scenes_are_placed_for_good(panda, tmp_path):
    scene = scene_of(ball("ball", "panda_hand", SHORT), ball("post", "map", OFFSET), state=state_of())
    checker = Checker(panda, scene)
    checker.scene.save(tmp_path / "scene.yaml")
    again = Checker(panda, Scene.load(tmp_path / "scene.yaml"))
    followed = Checker(panda).with_scene(scene)
    unpickled = pickle.loads(pickle.dumps(checker))
    q = np.vstack([configuration(panda), panda.random_configurations(200, 1)])
    for other in (again, followed, unpickled, checker.with_scene(checker.scene)):
        for one, two in zip(checker.bodies, other.bodies, strict=True):
            np.testing.assert_array_equal(one.pose, two.pose)
        np.testing.assert_array_equal(checker.check_states(q), other.check_states(q))
    held = checker.attach("ball", None, "panda_hand", q=configuration(panda))
    np.testing.assert_allclose(held.scene.object("ball").pose, se3(SHORT), atol=1e-14)


def test_commands_place_objects(tmp_path, capsys):
    document = {"robot_state": state_of(), "world": {"collision_objects": [ball("ball", "panda_hand", SHORT)]}}
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(document))
    np.save(tmp_path / "q.npy", configuration(Robot.load("panda"))[None])
    chosen = ("--robot", "panda", "--scene", str(tmp_path / "scene.yaml"))
    assert main(["validate", *chosen, str(tmp_path / "q.npy")]) == 1
    assert main(["inspect", *chosen, "--states", "10"]) == 0
    assert main(["view", *chosen, str(tmp_path / "q.npy"), "--html", str(tmp_path / "page.html")]) in (0, 1)
    capsys.readouterr()


# --- other fields ---------------------------------------------------------------------------------------------------


def test_a_byte_is_an_operation():
    """As `ros2 topic echo` writes it."""
    document = yaml.safe_load("operation: !!binary |\n  AA==\n")
    assert scene_of(ball("a", "map", OFFSET, **document)).object_names == ("a",)
    for code in (1, 2, 3, b"\1"):
        with pytest.raises(PlannercheckError, match="'a': operation must be 0"):
            scene_of(ball("a", "map", OFFSET, operation=code))


def test_prisms_and_poses_of_planes_are_refused():
    with pytest.raises(PlannercheckError, match="unknown primitive type '5'"):
        scene_of({"id": "a", "primitives": [{"type": 5, "dimensions": [1.0], "polygon": {"points": []}}]})
    with pytest.raises(PlannercheckError, match="planes are not supported"):
        scene_of(ball("a", "map", OFFSET, plane_poses=[pose_node(OFFSET)]))


def test_diffs_are_warned_of_once():
    with pytest.warns(UserWarning, match=r"the scene is a diff \(is_diff\)") as said:
        scene_of(ball("a", "map", OFFSET), ball("b", "map", OFFSET), is_diff=True)
    assert len(said) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene_of(ball("a", "map", OFFSET), is_diff=False)
