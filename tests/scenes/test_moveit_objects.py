"""Objects of MoveIt scenes in frames of other objects, and objects that are attached to links.

The conventions are those of MoveIt's own sources, see test_moveit_frames.py.
"""

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
    pose_node,
    scene_of,
    se3,
    state_of,
    tray,
)

from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.checker import Checker
from plannercheck.scenes.motion_bench_maker import load_problems
from plannercheck.scenes.moveit_scene import attach_from_state

# --- other objects --------------------------------------------------------------------------------------------------


def test_objects_are_frames_and_so_are_their_subframes():
    scene = scene_of(
        tray("tray", "map", OFFSET), ball("on", "tray", SHORT), ball("rim", "tray/rim", SHORT), ball("x", "rim", SHORT)
    )
    found = {body.name: body.pose for body in scene.bodies}
    base = se3(MAP) @ se3(OFFSET)
    np.testing.assert_allclose(found["on"], base @ se3(SHORT), atol=1e-14)
    np.testing.assert_allclose(found["rim"], base @ se3(TAG) @ se3(SHORT), atol=1e-14)
    np.testing.assert_allclose(found["x"], base @ se3(TAG) @ se3(SHORT) @ se3(SHORT), atol=1e-14)


def test_names_are_looked_up_in_moveits_order():
    """`PlanningScene::getFrameTransform`: attached objects, objects of the world, then fixed frames."""
    transforms = [*EXPORTED, fixed("tray", TAG), fixed("held/rim", TAG)]
    held = {"link_name": "panda_hand", "object": tray("held", "panda_hand", SHORT)}
    scene = scene_of(
        tray("tray", "map", OFFSET),
        ball("a", "tray", SHORT),
        ball("b", "held/rim", SHORT),
        transforms=transforms,
        state=state_of(attached=[held]),
    )
    np.testing.assert_allclose(scene.object("a").pose, se3(MAP) @ se3(OFFSET) @ se3(SHORT), atol=1e-14)
    assert scene.object("b").pose_frame.frame == "panda_hand"
    (body,) = scene_of(ball("c", "tray", SHORT), transforms=transforms).bodies
    np.testing.assert_allclose(body.pose, se3(TAG) @ se3(SHORT), atol=1e-14)


def test_an_objects_frame_is_its_pose_or_if_that_is_left_out_that_of_its_only_shape():
    """As `PlanningScene::shapesAndPosesFromCollisionObjectMessage` has it; ROS 1's all zeros are not left out."""
    zeros = {"pose": {"position": [0, 0, 0], "orientation": [0, 0, 0, 0]}}
    for more, base in (({}, OFFSET), ({"pose": pose_node(IDENTITY)}, OFFSET), (zeros, IDENTITY)):
        scene = scene_of(ball("a", "map", OFFSET, **more), ball("b", "a", SHORT))
        first, second = (body.pose for body in scene.bodies)
        np.testing.assert_allclose(first, se3(MAP) @ se3(OFFSET), atol=1e-14)
        np.testing.assert_allclose(second, se3(MAP) @ se3(base) @ se3(SHORT), atol=1e-14)


def test_objects_in_frames_of_objects_in_frames_of_links(panda):
    held = {"link_name": "panda_hand", "object": tray("held", "panda_hand", SHORT)}
    scene = scene_of(
        tray("tray", "panda_link6", OFFSET),
        ball("a", "tray/rim", SHORT),
        ball("b", "held/rim", SHORT),
        state=state_of(attached=[held]),
    )
    placed = Checker(panda, scene).scene
    sixth, hand = (link_pose(panda, link) for link in ("panda_link6", "panda_hand"))
    expected = {"tray": sixth @ se3(OFFSET), "a": sixth @ se3(OFFSET) @ se3(TAG) @ se3(SHORT)}
    expected["b"] = hand @ se3(SHORT) @ se3(TAG) @ se3(SHORT)
    for name, pose in expected.items():
        np.testing.assert_allclose(placed.object(name).pose, pose, atol=1e-14, err_msg=name)
    assert placed.object_names == tuple(expected)


def test_objects_come_before_those_that_are_posed_in_them():
    for frame in ("b", "b/rim"):
        with pytest.raises(PlannercheckError, match=f"'a': frame '{frame}' is of an object that comes later"):
            scene_of(ball("a", frame, OFFSET), tray("b", "map", OFFSET))
    with pytest.raises(PlannercheckError, match="'a': 1 subframe_names, but 0 subframe_poses"):
        scene_of(tray("a", "map", OFFSET, subframe_poses=[]))


# --- attached objects -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("frame", "base"),
    [
        ("map", lambda robot: se3(MAP)),
        ("panda_link0", lambda robot: np.eye(4)),
        ("panda_hand", lambda robot: link_pose(robot, "panda_hand")),
        ("/panda_link4", lambda robot: link_pose(robot, "panda_link4")),
        ("first/rim", lambda robot: link_pose(robot, "panda_link6") @ se3(SHORT) @ se3(TAG)),
    ],
)
def test_attached_objects_are_where_their_frames_are_at_the_state(panda, frame, base):
    first = {"link_name": "panda_link6", "object": tray("first", "panda_link6", SHORT)}
    second = {"link_name": "panda_hand", "object": ball("second", frame, OFFSET)}
    checker = Checker(panda, scene_of(state=state_of(attached=[first, second])))
    here = configuration(panda)
    np.testing.assert_allclose(body_pose(checker, "second", here), base(panda) @ se3(OFFSET), atol=1e-14)
    there = dict(zip(panda.joint_names, panda.random_configurations(1, 3)[0].tolist(), strict=True))
    carried = np.linalg.inv(link_pose(panda, "panda_hand")) @ base(panda) @ se3(OFFSET)
    moved = link_pose(panda, "panda_hand", {**STATE, **there}) @ carried
    np.testing.assert_allclose(body_pose(checker, "second", configuration(panda, there)), moved, atol=1e-14)


def test_attached_objects_off_their_link_need_what_moves_between(panda):
    between = {name: STATE[name] for name in ("panda_joint6", "panda_joint7")}
    item = {"link_name": "panda_hand", "object": ball("a", "panda_link5", OFFSET)}
    carried = Checker(panda, scene_of(state=state_of(between, [item]))).scene.object("a").pose
    expected = np.linalg.inv(link_pose(panda, "panda_hand", between)) @ link_pose(panda, "panda_link5", between)
    np.testing.assert_allclose(carried, expected @ se3(OFFSET), atol=1e-14)
    del between["panda_joint6"]
    with pytest.raises(PlannercheckError, match=r"frame 'panda_link5' and carried by .*hand', .* for panda_joint6"):
        Checker(panda, scene_of(state=state_of(between, [item])))
    on_map = {"link_name": "panda_hand", "object": ball("a", "map", OFFSET)}
    with pytest.raises(
        PlannercheckError, match=r"'a' is posed in the planning frame and carried by 'panda_hand', .* for p"
    ):
        Checker(panda, scene_of(state={"attached_collision_objects": [on_map]}))


def test_attached_objects_have_to_name_a_frame_and_be_attached_once():
    item = {"link_name": "panda_hand", "object": ball("a", None, OFFSET)}
    with pytest.raises(
        PlannercheckError, match=r"'a': its header names no frame: give header.frame_id, 'panda_hand' if"
    ):
        scene_of(state=state_of(attached=[item]))
    item = {"link_name": "panda_hand", "object": ball("a", "panda_hand", OFFSET)}
    with pytest.raises(PlannercheckError, match="attached object 1: 'a' is attached twice"):
        scene_of(state=state_of(attached=[item, item]))


@pytest.mark.parametrize("first_says", [True, False])
def test_carried_objects_may_touch_if_either_lists_the_other(panda, first_says):
    """Whichever it is, the first or the second: `collisionCallback` in MoveIt's collision_common.cpp asks both."""

    def attached(link, name, touched):
        return {"link_name": link, "object": ball(name, link, SHORT), "touch_links": touched}

    says = (["b"], []) if first_says else ([], ["a"])
    pairs_of = []
    for first, second in (says, ([], [])):
        items = [attached("panda_hand", "a", first), attached("panda_link4", "b", second)]
        checker = Checker(panda, scene_of(state=state_of(attached=items)))
        pairs_of.append({frozenset(checker.pair_names(k)) for k in range(len(checker.pairs))})
    assert pairs_of[1] - pairs_of[0] == {frozenset("ab")}


def test_a_requests_attached_objects_know_the_scenes_frames_and_come_first(panda):
    item = {"link_name": "panda_hand", "object": ball("a", "map", OFFSET)}
    other = {"link_name": "panda_link4", "object": ball("a", "panda_link4", SHORT)}
    for attached in ([], [other]):
        scene = scene_of(tray("tray", "map", SHORT), state=state_of({}, attached))
        attach_from_state(scene, state_of(attached=[item]), None)
        expected = np.linalg.inv(link_pose(panda, "panda_hand")) @ se3(MAP) @ se3(OFFSET)
        placed = Checker(panda, scene).scene.object("a")
        np.testing.assert_allclose(placed.pose, expected, atol=1e-14)
        assert placed.link == "panda_hand"


def test_what_depends_on_two_states_is_refused():
    scene = scene_of(tray("tray", "panda_link6", OFFSET), state=state_of())
    request = state_of(
        {**STATE, "panda_joint1": 1.0}, [{"link_name": "panda_hand", "object": ball("a", "tray", SHORT)}]
    )
    with pytest.raises(PlannercheckError, match="frame 'tray' is of an object that is placed at another robot state"):
        attach_from_state(scene, request, None)
    request = state_of({**STATE, "panda_joint1": 1.0}, [{"link_name": "panda_hand", "object": {"id": "tray"}}])
    with pytest.raises(PlannercheckError, match="attached object 'tray': is placed at another robot state"):
        attach_from_state(scene, request, None)


def test_problem_sets_place_their_objects_at_the_scenes_state(panda, tmp_path):
    scene = {
        "fixed_frame_transforms": EXPORTED,
        "robot_state": state_of(),
        "world": {"collision_objects": [ball("ball", "panda_hand", SHORT)]},
    }
    start = dict.fromkeys(STATE, 0.0)
    goal = [{"joint_name": name, "position": 0.1} for name in panda.joint_names]
    request = {"start_state": state_of(start), "goal_constraints": [{"joint_constraints": goal}]}
    (tmp_path / "scene0001.yaml").write_text(yaml.safe_dump(scene))
    (tmp_path / "request0001.yaml").write_text(yaml.safe_dump(request))
    (problem,) = load_problems(tmp_path)
    placed = Checker(panda, problem.scene).scene.object("ball").pose
    np.testing.assert_allclose(placed, link_pose(panda, "panda_hand") @ se3(SHORT), atol=1e-14)
