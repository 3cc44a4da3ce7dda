"""Worlds and collision objects of MoveIt alone, as messages in YAML, are scenes."""

import numpy as np
import pytest
import yaml

from plannercheck.common.errors import PlannercheckError
from plannercheck.scenes.moveit_scene import read_planning_scene
from plannercheck.scenes.scene import Scene
from plannercheck.scenes.scene_paths import FindFile

# A world with an object as MotionBenchMaker writes it, in lists, and one as `ros2 topic echo` does.
REAL = """
collision_objects:
  - id: Can1
    primitives: [{type: cylinder, dimensions: [0.14, 0.03]}]
    primitive_poses:
      - {position: [0.25, -1.07, 0.3], orientation: [0, 0, -0.5233762232815127, 0.8521017127688338]}
  - header: {stamp: {sec: 0, nanosec: 0}, frame_id: world}
    pose: {position: {x: 0.1, y: 0.0, z: 0.5}, orientation: {x: 0.0, y: 0.0, z: 0.6, w: 0.8}}
    id: shelf
    type: {key: '', db: ''}
    primitives:
      - {type: 1, dimensions: [1.0, 2.0, 3.0], polygon: {points: []}}
      - {type: 1, dimensions: [0.1, 0.2, 0.3], polygon: {points: []}}
    primitive_poses:
      - {position: {x: 1.0, y: 0.0, z: 0.0}, orientation: {x: 0.0, y: 0.0, z: 0.0, w: 1.0}}
      - {position: {x: 0.0, y: 1.0, z: 0.0}, orientation: {x: 0.0, y: 0.0, z: 0.0, w: 1.0}}
    meshes: []
    mesh_poses: []
    planes: []
    plane_poses: []
    subframe_names: []
    subframe_poses: []
    operation: 0
"""


def assert_same_bodies(found, expected):
    assert [body.name for body in found] == [body.name for body in expected]
    for a, b in zip(found, expected, strict=True):
        assert a.shape == b.shape
        assert np.array_equal(a.pose, b.pose)


@pytest.mark.parametrize("end", ["", "---\n", "\n---"], ids=["plain", "echo", "last line"])
def test_worlds_and_objects_alone_are_what_they_are_in_a_scene(tmp_path, end):
    """`moveit_msgs/PlanningSceneWorld` and `CollisionObject`; `ros2 topic echo` ends messages with dashes."""
    world = yaml.safe_load(REAL)
    whole = Scene()
    read_planning_scene(whole, {"world": world}, FindFile(tmp_path))
    (tmp_path / "w.yaml").write_text(REAL + end)
    found = Scene.load(tmp_path / "w.yaml")
    assert found.name == "w"
    assert_same_bodies(found.bodies, whole.bodies)
    for item in world["collision_objects"]:
        (tmp_path / "o.yaml").write_text(yaml.safe_dump(item) + end)
        bodies = [body for body, name in zip(whole.bodies, whole.body_objects, strict=True) if name == item["id"]]
        assert_same_bodies(Scene.load(tmp_path / "o.yaml").bodies, bodies)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("collision_objects: [{id: a}]", "collision object 'a': has neither primitives nor meshes"),
        ("collision_objects: [{primitives: []}]", "collision object 0: key 'id' is missing"),
        ("{collision_objects: [], colour: 1}", "unknown key 'colour'"),
        ("octomap: {octomap: {data: [1]}}", "world: octomap: id must be 'OcTree'"),
        ("{id: a, primitives: [{type: 9}]}", "collision object 'a': primitives: unknown primitive type '9'"),
        ("{id: a, operation: 1, primitives: []}", "collision object 'a': operation must be 0"),
        ("{primitives: [{type: 2, dimensions: [1]}]}", "collision object 0: key 'id' is missing"),
        ("{planes: [{coef: [0, 0, 1, 0]}], id: a}", "collision object 'a': planes are not supported"),
        ("a: 1\n---\nb: 2\n", "holds 2 YAML documents"),
    ],
)
def test_bad_worlds_and_objects_are_named(tmp_path, text, message):
    (tmp_path / "w.yaml").write_text(text)
    with pytest.raises(PlannercheckError, match=rf"^scene file .*w\.yaml': {message}"):
        Scene.load(tmp_path / "w.yaml")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16-le", "utf-16-be"])
def test_encodings_of_yaml_stay(tmp_path, encoding):
    (tmp_path / "w.yaml").write_bytes(("\ufeff" + REAL).encode(encoding))
    assert Scene.load(tmp_path / "w.yaml").object_names == ("Can1", "shelf")
