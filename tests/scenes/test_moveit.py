"""MoveIt scenes and requests and MotionBenchMaker sets load as they are; what can't be honoured is said."""

import tarfile
import warnings

import numpy as np
import pinocchio
import pytest
import yaml
from poses import at

from plannercheck.bodies.shapes import Box, Cone, Cylinder, Sphere
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot
from plannercheck.scenes.motion_bench_maker import load_problems
from plannercheck.scenes.moveit_request import motion_request, read_request
from plannercheck.scenes.moveit_scene import read_planning_scene
from plannercheck.scenes.scene import Scene
from plannercheck.scenes.scene_paths import FindFile

LISTS = """
robot_model_name: panda
robot_state:
  multi_dof_joint_state:
    transforms: [{translation: [0, 0, 0], rotation: [0, 0, 0, 1]}]
    joint_names: [virtual_joint]
  joint_state: {position: [0], name: [panda_joint1]}
allowed_collision_matrix:
  entry_names: [Can1, panda_hand]
  entry_values:
    - [false, true]
    - [true, false]
fixed_frame_transforms:
  - transform: {translation: [0, 0, 0], rotation: [0, 0, 0, 1]}
    child_frame_id: world
world:
  collision_objects:
    - id: Can1
      primitives:
        - type: cylinder
          dimensions: [0.14, 0.03]
      primitive_poses:
        - position: [0.25, -1.07, 0.3]
          orientation: [0, 0, -0.5233762232815127, 0.8521017127688338]
"""

MESSAGE = """
name: (noname)
robot_state: {is_diff: true, attached_collision_objects: []}
fixed_frame_transforms:
  - header: {frame_id: base}
    child_frame_id: world
    transform: {translation: {x: 1.0, y: 0.0, z: 0.0}, rotation: {x: 0.0, y: 0.0, z: 1.0, w: 0.0}}
allowed_collision_matrix:
  entry_names: [a, b, c]
  entry_values:
    - enabled: [false, true, false]
    - enabled: [true, false, false]
    - enabled: [false, false, false]
  default_entry_names: [c, d]
  default_entry_values: [true, false]
link_padding: []
world:
  octomap: {header: {frame_id: ''}, octomap: {data: []}}
  collision_objects:
    - id: group
      header: {stamp: {sec: 0}, frame_id: base}
      operation: 0
      pose:
        position: {x: 0.0, y: 0.0, z: 0.5}
        orientation: {x: 0.0, y: 0.0, z: 0.7071067811865476, w: 0.7071067811865476}
      primitives:
        - {type: 1, dimensions: [1.0, 2.0, 3.0]}
        - {type: 2, dimensions: [0.5]}
        - {type: 3, dimensions: [0.4, 0.1]}
        - {type: 4, dimensions: [0.4, 0.1]}
      primitive_poses:
        - {position: {x: 1.0, y: 0.0, z: 0.0}, orientation: {x: 0, y: 0, z: 0, w: 1}}
        - {position: {x: 0.0, y: 1.0, z: 0.0}, orientation: {x: 0, y: 0, z: 0, w: 1}}
        - {position: {x: 0.0, y: 0.0, z: 1.0}, orientation: {x: 0.6, y: 0, z: 0, w: 0.8}}
        - {position: {x: 0.0, y: 0.0, z: 0.0}, orientation: {x: 0, y: 0, z: 0, w: 1}}
    - id: wedge
      pose: {position: {x: 0.0, y: 0.0, z: 0.0}, orientation: {x: 0.0, y: 0.0, z: 0.0, w: 0.0}}
      meshes:
        - vertices:
            - {x: 0, y: 0, z: 0}
            - {x: 1, y: 0, z: 0}
            - {x: 0, y: 1, z: 0}
            - {x: 0, y: 0, z: 1}
            - {x: 9, y: 9, z: 9}
          triangles: [{vertex_indices: [0, 1, 2]}, {vertex_indices: [0, 1, 3]}]
      mesh_poses:
        - {position: {x: 0.0, y: 0.0, z: 2.0}, orientation: {x: 0, y: 0, z: 0, w: 1}}
"""

REQUEST = """
group_name: panda_arm
start_state:
  joint_state:
    name: [panda_joint1, panda_joint2, panda_finger_joint1]
    position: [0, -0.785, 0.065]
goal_constraints:
  - joint_constraints:
      - {joint_name: panda_joint2, position: 1e-1, tolerance_above: 0.001}
      - {joint_name: panda_joint1, position: 0.5}
  - joint_constraints:
      - {joint_name: panda_joint1, position: -0.5}
      - {joint_name: panda_joint2, position: -0.1}
"""


def scene_of(text, folder, **changes):
    document = yaml.safe_load(text)
    for path, value in changes.items():
        node = document
        *parents, last = path.split("__")
        for key in parents:
            node = node[int(key) if isinstance(node, list) else key]
        node[last] = value
    scene = Scene()
    read_planning_scene(scene, document, FindFile(folder))
    return scene


def problem_folder(folder, numbers=("0001", "0002")):
    folder.mkdir()
    for number in numbers:
        (folder / f"scene{number}.yaml").write_text(LISTS)
        (folder / f"request{number}.yaml").write_text(REQUEST)
    (folder / "config.yaml").write_text("a: 1")
    return folder


def test_scenes_with_lists_load(tmp_path):
    (tmp_path / "scene0001.yaml").write_text(LISTS)
    scene = Scene.load(tmp_path / "scene0001.yaml")
    (can,) = scene.bodies
    assert (scene.name, can.name) == ("scene0001", "Can1")
    assert can.shape == Cylinder(radius=0.03, length=0.14)
    expected = pinocchio.XYZQUATToSE3(np.array([0.25, -1.07, 0.3, 0, 0, -0.5233762232815127, 0.8521017127688338]))
    assert np.allclose(can.pose, expected.homogeneous, atol=1e-15)
    assert scene.allowed_pairs == {frozenset(("Can1", "panda_hand"))}


def test_scenes_as_ros_writes_them_load(tmp_path):
    scene = scene_of(MESSAGE, tmp_path)
    assert [b.name for b in scene.bodies] == [*(f"group/{k}" for k in range(4)), "wedge"]
    shapes = [b.shape for b in scene.bodies[:4]]
    assert shapes == [Box((1, 2, 3)), Sphere(0.5), Cylinder(0.1, 0.4), Cone(0.1, 0.4)]


def test_poses_chain_from_frame_over_object_to_primitive(tmp_path):
    bodies = scene_of(MESSAGE, tmp_path).bodies
    frame = pinocchio.XYZQUATToSE3(np.array([1.0, 0, 0, 0, 0, 1, 0]))
    group = pinocchio.XYZQUATToSE3(np.array([0, 0, 0.5, 0, 0, 0.5**0.5, 0.5**0.5]))
    tilted = pinocchio.XYZQUATToSE3(np.array([0, 0, 1, 0.6, 0, 0, 0.8]))
    assert np.allclose(bodies[2].pose, (frame * group * tilted).homogeneous, atol=1e-15)
    assert np.allclose(bodies[0].pose[:3, 3], [1, -1, 0.5])


def test_meshes_use_the_vertices_of_their_triangles(tmp_path):
    wedge = scene_of(MESSAGE, tmp_path).bodies[4]
    assert wedge.shape.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    assert wedge.pose[2, 3] == 2.0


def test_mesh_resources_are_found(tmp_path):
    lines = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "v 0 0 1", "f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"]
    (tmp_path / "pkg").mkdir()
    (tmp_path / "pkg" / "t.obj").write_text("\n".join(lines))
    for resource in ("pkg/t.obj", f"file://{tmp_path}/pkg/t.obj", "package://pkg/t.obj"):
        node = {"id": "t", "meshes": [{"resource": resource, "dimensions": [2, 2, 2]}]}
        path = tmp_path / "s.yaml"
        path.write_text(yaml.dump({"world": {"collision_objects": [node]}}))
        vertices = Scene.load(path, package_dirs=[tmp_path]).bodies[0].shape.vertices
        assert vertices.max() == 2
    path.write_text(path.read_text().replace("t.obj", "u.obj"))
    with pytest.raises(PlannercheckError, match=r"package://pkg/u\.obj' is not found. Searched were the folders above"):
        Scene.load(path)


def test_entries_of_the_matrix_go_before_defaults(tmp_path):
    scene = scene_of(MESSAGE, tmp_path)
    assert scene.allowed_pairs == {frozenset("ab")}
    assert not scene.is_allowed("a", "c")
    assert scene.is_allowed("c", "link")
    assert not scene.is_allowed("c", "d")
    assert not scene.is_allowed("link", "other")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"world__collision_objects__0__planes": [{"coef": [0, 0, 1, 0]}]}, "'group': planes are not supported"),
        ({"world__collision_objects__0__operation": 1}, "'group': operation must be 0"),
        ({"world__collision_objects__0__primitive_poses": [{}]}, "4 primitives, but 1 primitive_poses"),
        ({"world__collision_objects__0__colour": 1}, "'group': unknown key 'colour'"),
        ({"world__collision_objects__1__id": "group"}, "object 'group' exists already"),
        ({"world__collision_objects__1__meshes": []}, "'wedge': 0 meshes, but 1 mesh_poses"),
        ({"world__collision_objects__0__primitives__0__type": 7}, "unknown primitive type '7': valid are 1 .box"),
        ({"world__collision_objects__0__primitives__0__dimensions": [1]}, "dimensions of a box' needs 3"),
        ({"world__collision_objects__1__meshes__0__triangles": [[0, 1, 7]]}, "there are 5 vertices"),
        (
            {"world__collision_objects__0__primitive_poses__0__orientation": [0, 0, 0, 0]},
            "primitive_poses: quaternion .* has no direction",
        ),
        ({"world__collision_objects__1__meshes__0__triangles": [[0, 1, 2.7]]}, "triangles need whole numbers, not 2.7"),
        ({"world__collision_objects__0__primitive_poses__0__orientation": 0}, "'orientation' must be a list"),
        ({"world__collision_objects__0__primitive_poses__0__orientation": []}, "'orientation' needs 4 numbers"),
        ({"world__collision_objects__0__pose": {"position": 0}}, "'position' must be a list"),
        (
            {
                "world__collision_objects__0__subframe_names": ["t", "t"],
                "world__collision_objects__0__subframe_poses": [{}, {}],
            },
            "subframe_names must differ, but are 't, t'",
        ),
        ({"world__octomap__octomap__data": [1]}, "world: octomap: id must be 'OcTree'"),
        ({"link_padding": [{"link_name": "hand", "pading": 1}]}, "link_padding: unknown key 'pading'.*'padding'"),
        ({"link_scale": [{"link_name": "hand", "Scale": 2}]}, "link_scale: unknown key 'Scale'.*'scale'"),
        ({"allowed_collision_matrix__entry_names": ["a"]}, "allowed_collision_matrix: entry_values must be"),
        (
            {"allowed_collision_matrix__entry_values": [[0, 1, 1], [1, 0, 1], [0, 0, 0]]},
            "entry_values of 'c' with 'a' and of 'a' with 'c' differ",
        ),
        (
            {"allowed_collision_matrix__default_entry_names": ["a", "a"]},
            "default_entry_names must differ, but are 'a, a'",
        ),
        ({"allowed_collision_matrix__default_entry_values": [True]}, "2 default_entry_names, but 1"),
        (
            {"robot_state__multi_dof_joint_state": {"joint_names": ["v"], "transforms": [{"translation": [1, 0, 0]}]}},
            "virtual joint 'v' moves the robot",
        ),
    ],
)
def test_what_would_change_verdicts_is_refused(tmp_path, changes, message):
    with pytest.raises(PlannercheckError, match=message):
        scene_of(MESSAGE, tmp_path, **changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"link_padding": [{"link_name": "hand", "padding": 0.01}]}, "link_padding, for hand, is used if asked for"),
        ({"link_scale": [{"link_name": "hand", "scale": 1.1}]}, "link_scale is ignored, for hand"),
    ],
)
def test_what_is_left_out_is_said(tmp_path, changes, message):
    with pytest.warns(UserWarning, match=message):
        scene_of(MESSAGE, tmp_path, **changes)


def test_nothing_is_said_of_plain_scenes(tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene_of(MESSAGE, tmp_path)
        scene_of(LISTS, tmp_path)


def test_requests_give_start_and_goals(tmp_path):
    (tmp_path / "request.yaml").write_text(REQUEST)
    request = read_request(tmp_path / "request.yaml")
    assert request.group == "panda_arm"
    assert request.start == {"panda_joint1": 0.0, "panda_joint2": -0.785, "panda_finger_joint1": 0.065}
    assert request.goals == ({"panda_joint2": 0.1, "panda_joint1": 0.5}, {"panda_joint1": -0.5, "panda_joint2": -0.1})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"goal_constraints": []}, "'goal_constraints' is empty"),
        ({"goal_constraints": [{"position_constraints": [{}]}]}, "position_constraints are not supported"),
        ({"goal_constraints": [{}]}, "goal_constraints 0: joint_constraints must name each joint once"),
        ({"goal_constraints": [{"joint_constrains": []}]}, "goal_constraints 0: unknown key 'joint_constrains'"),
        ({"start_state": {"joint_state": {"name": ["a"], "position": []}}}, "'position' needs 1 numbers"),
        ({"start_state": None}, "key 'start_state' is missing"),
    ],
)
def test_bad_requests_are_named(changes, message):
    with pytest.raises(PlannercheckError, match=message):
        motion_request(yaml.safe_load(REQUEST) | changes)


@pytest.mark.parametrize("key", ["path_constraints", "trajectory_constraints"])
def test_constraints_on_the_way_are_said_to_be_left_out(key):
    constraints = {"joint_constraints": [], "constraints": [{"joint_constraints": []}]}
    with pytest.warns(UserWarning, match=f"the request's {key} are ignored"):
        motion_request(yaml.safe_load(REQUEST) | {key: constraints})


def assert_problems(problems, name):
    assert len(problems) == 2
    first, second = problems
    assert [first.name, second.name] == [f"{name}/0001", f"{name}/0002"]
    assert first.joint_names == ("panda_joint2", "panda_joint1")
    assert first.start.tolist() == [-0.785, 0.0]
    assert [g.tolist() for g in first.goals] == [[0.1, 0.5], [-0.1, -0.5]]
    assert first.goal.tolist() == [0.1, 0.5]
    assert first.held == {"panda_finger_joint1": 0.065}
    assert first.scene.object_names == ("Can1",)


def test_problem_sets_load_from_folders_and_archives(tmp_path):
    folder = problem_folder(tmp_path / "cage_panda")
    assert_problems(load_problems(folder), "cage_panda")
    with tarfile.open(tmp_path / "set.tar.bz2", "w:bz2") as archive:
        archive.add(folder, "problems/cage_panda")
    assert_problems(load_problems(tmp_path / "set.tar.bz2"), "cage_panda")


def test_files_of_a_problem_set_may_end_in_yml(tmp_path):
    folder = problem_folder(tmp_path / "cage_panda")
    (folder / "scene0002.yaml").rename(folder / "scene0002.yml")
    assert_problems(load_problems(folder), "cage_panda")
    (folder / "scene0002.yaml").write_text("{}")
    with pytest.raises(PlannercheckError, match=r"scene0002\.yaml and scene0002\.yml have one number: leave one out"):
        load_problems(folder)


def test_bad_problem_sets_are_named(tmp_path):
    folder = problem_folder(tmp_path / "set")
    (folder / "request0002.yaml").write_text("start_state: {}")
    with pytest.raises(PlannercheckError, match=r"set, request0002\.yaml: key 'goal_constraints' is missing"):
        list(load_problems(folder))
    (folder / "request0002.yaml").unlink()
    with pytest.raises(PlannercheckError, match=r"scene0002\.yaml has no counterpart"):
        load_problems(folder)
    (tmp_path / "empty").mkdir()
    with pytest.raises(PlannercheckError, match="must hold one problem set; found are none"):
        load_problems(tmp_path / "empty")
    (tmp_path / "set.tar.bz2").write_bytes(b"BZh91AY&SY truncated")
    with pytest.raises(PlannercheckError, match=r"set\.tar\.bz2' is neither a folder nor a readable tar"):
        load_problems(tmp_path / "set.tar.bz2")
    with pytest.raises(PlannercheckError, match="No such file"):
        load_problems(tmp_path / "none.tar")


ATTACHED = """
name: picked
robot_state:
  joint_state:
    name: [panda_joint1, panda_joint2, panda_joint3, panda_joint4, panda_joint5, panda_joint6, panda_finger_joint1]
    position: [0.3, -0.4, 0.1, -2.0, -0.2, 1.8, 0.02]
  attached_collision_objects:
    - link_name: panda_hand
      object:
        header: {frame_id: panda_hand}
        id: mug
        pose: {position: {x: 0.0, y: 0.0, z: 0.1}, orientation: {x: 0.0, y: 0.0, z: 0.0, w: 1.0}}
        primitives: [{type: 3, dimensions: [0.1, 0.03]}, {type: 2, dimensions: [0.01]}]
        primitive_poses:
          - {position: {x: 0.0, y: 0.0, z: 0.0}, orientation: {x: 0, y: 0, z: 0, w: 1}}
          - {position: {x: 0.0, y: 0.05, z: 0.0}, orientation: {x: 0, y: 0, z: 0, w: 1}}
      touch_links: [panda_leftfinger, panda_rightfinger]
      weight: 0.2
    - link_name: panda_link5
      object: {id: board}
    - link_name: panda_link4
      object:
        header: {frame_id: panda_link6}
        id: camera
        primitives: [{type: box, dimensions: [0.01, 0.02, 0.03]}]
        primitive_poses: [{position: [0.0, 0.2, 0.0], orientation: [0, 0, 0, 1]}]
world:
  collision_objects:
    - id: board
      pose: {position: [2.0, 1.0, 0.0], orientation: [0, 0, 0.6, 0.8]}
      primitives: [{type: box, dimensions: [0.5, 0.5, 0.01]}]
    - {id: mug, primitives: [{type: sphere, dimensions: [0.1]}]}
allowed_collision_matrix:
  entry_names: [mug, panda_link3]
  entry_values: [[false, true], [true, false]]
  default_entry_names: [camera]
  default_entry_values: [true]
"""


@pytest.mark.filterwarnings("ignore:the scene's link_padding")
def test_the_padding_of_a_link_is_that_of_what_it_carries(tmp_path):
    """CollisionEnvFCL::getAttachedBodyObjects pads attached objects as their links, those of the world not at all."""
    padding = [{"link_name": "panda_hand", "padding": 0.02}, {"link_name": "panda_link5", "padding": 0.01}]
    scene = scene_of(ATTACHED, tmp_path, link_padding=padding)
    assert scene.link_padding == {"panda_hand": 0.02, "panda_link5": 0.01, "mug": 0.02, "board": 0.01}
    checker = Checker(Robot.load("panda"), scene, padding=scene.link_padding)
    names = [body.name for body in checker.bodies]
    assert checker.paddings[[names.index(name) for name in ("mug/0", "board", "camera")]].tolist() == [0.02, 0.01, 0.0]
    later = scene.copy()
    later.detach("mug", None)
    assert "mug" not in later.link_padding
    later.attach("mug", "panda_link5")
    assert later.link_padding["mug"] == 0.01
    assert scene.link_padding["mug"] == 0.02


def test_attached_objects_are_carried_where_the_state_has_them(tmp_path):
    scene = scene_of(ATTACHED, tmp_path)
    assert scene.object_names == ()  # both are attached now
    assert [(item.name, item.link) for item in scene.attached] == [
        ("mug", "panda_hand"),
        ("camera", "panda_link4"),
        ("board", "panda_link5"),
    ]
    panda = Robot.load("panda")
    checker = Checker(panda, scene)
    q = np.array([0.3, -0.4, 0.1, -2.0, -0.2, 1.8, panda.reference[6]])  # nothing depends on the seventh
    links = panda.link_poses(q)
    found = dict(zip((body.name for body in checker.bodies), checker.body_poses(q)[0], strict=True))
    hand, upper = links[panda.link_index("panda_hand")], links[panda.link_index("panda_link6")]
    expected = {
        "mug/0": hand @ at(0, 0, 0.1),
        "mug/1": hand @ at(0, 0.05, 0.1),
        "board": pinocchio.XYZQUATToSE3(np.array([2.0, 1.0, 0, 0, 0, 0.6, 0.8])).homogeneous,
    }
    for name, pose in expected.items():
        np.testing.assert_allclose(found[name], pose, atol=1e-14, err_msg=name)
    item = checker.scene.object("camera")
    np.testing.assert_allclose(links[panda.link_index("panda_link4")] @ item.pose, upper @ at(0, 0.2, 0), atol=1e-14)
    pairs = [checker.pair_names(k) for k in range(len(checker.pairs))]
    assert not any("camera" in pair for pair in pairs)  # allowed by default
    partners = {name for pair in pairs for name in pair if "mug" in pair} - {"mug"}
    fingers = {"panda_leftfinger", "panda_rightfinger"}
    assert partners == {body.link for body in panda.bodies} - {"panda_hand", "panda_link3"} - fingers | {"board"}


def test_scenes_with_anchored_objects_are_saved_once_their_links_are_posed(tmp_path):
    scene = scene_of(ATTACHED, tmp_path)
    with pytest.raises(PlannercheckError, match="'camera' is posed in frame 'panda_link6' at a state of the robot"):
        scene.save(tmp_path / "scene.yaml")
    checker = Checker(Robot.load("panda"), scene)
    checker.scene.save(tmp_path / "scene.yaml")
    again = Checker(Robot.load("panda"), Scene.load(tmp_path / "scene.yaml"))
    for one, other in zip(checker.bodies, again.bodies, strict=True):
        np.testing.assert_array_equal(one.pose, other.pose)


def test_requests_attach_what_their_start_states_carry(tmp_path):
    folder = problem_folder(tmp_path / "set", ("0001",))
    request = yaml.safe_load(REQUEST)
    request["start_state"]["attached_collision_objects"] = yaml.safe_load(ATTACHED)["robot_state"][
        "attached_collision_objects"
    ][:1]
    (folder / "request0001.yaml").write_text(yaml.dump(request))
    (problem,) = load_problems(folder)
    assert [item.name for item in problem.scene.attached] == ["mug"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"object": {"id": "gone"}}, "unknown object to attach, without shapes of its own, 'gone'"),
        ({"link_name": None}, "link_name"),
        ({"objects": 1}, "objects"),
    ],
)
def test_bad_attached_objects_are_named(tmp_path, changes, message):
    node = {"link_name": "panda_hand", "object": {"id": "mug"}, **changes}
    with pytest.raises(PlannercheckError, match=message):
        scene_of(ATTACHED, tmp_path, robot_state__attached_collision_objects=[node])


def test_attached_objects_need_links_and_frames_that_the_robot_has(tmp_path):
    panda = Robot.load("panda")
    node = yaml.safe_load(ATTACHED)["robot_state"]["attached_collision_objects"][2]
    for change, message in (
        ({"link_name": "tool0"}, "unknown link that carries 'camera' 'tool0'"),
        ({"object": {**node["object"], "header": {"frame_id": "odom"}}}, "unknown frame of object 'camera' 'odom'"),
    ):
        scene = scene_of(ATTACHED, tmp_path, robot_state__attached_collision_objects=[{**node, **change}])
        with pytest.raises(PlannercheckError, match=message):
            Checker(panda, scene)
