"""Scenes look for packages as URDFs do: in package_dirs, then in all folders above the scene's file."""

import pytest
import yaml

import plannercheck as pc
from plannercheck.common.errors import PlannercheckError
from plannercheck.scenes.motion_bench_maker import load_problems

OBJ = "v 0 0 0\nv {0} 0 0\nv 0 {0} 0\nv 0 0 {0}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
ADDRESS = "package://pkg/meshes/t.obj"

MOVEIT = {"world": {"collision_objects": [{"id": "t", "meshes": [{"resource": ADDRESS}]}]}}
OWN = {"objects": [{"name": "t", "mesh": {"file": ADDRESS}}]}
ATTACHED = {
    "world": {},
    "robot_state": {
        "attached_collision_objects": [
            {
                "link_name": "panda_hand",
                "object": {"id": "t", "header": {"frame_id": "panda_hand"}, "meshes": [{"resource": ADDRESS}]},
            }
        ]
    },
}


def mesh(folder, size=1):
    (folder / "pkg" / "meshes").mkdir(parents=True)
    (folder / "pkg" / "meshes" / "t.obj").write_text(OBJ.format(size))


def scene_file(folder, document):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "s.yaml").write_text(yaml.safe_dump(document))
    return folder / "s.yaml"


def size_of(scene):
    (item,) = (*scene.objects, *scene.attached)
    return item.parts[0].shape.vertices.max()


@pytest.mark.parametrize("document", [MOVEIT, OWN, ATTACHED], ids=["moveit", "own", "attached"])
def test_packages_are_found_in_the_folders_above_a_scene(tmp_path, document):
    mesh(tmp_path / "src")
    assert size_of(pc.Scene.load(scene_file(tmp_path / "src" / "other" / "scenes", document))) == 1


@pytest.mark.parametrize("document", [MOVEIT, OWN], ids=["moveit", "own"])
def test_package_dirs_come_before_the_folders_above(tmp_path, document):
    mesh(tmp_path)
    mesh(tmp_path / "elsewhere", 2)
    path = scene_file(tmp_path / "scenes", document)
    assert size_of(pc.Scene.load(path, package_dirs=[tmp_path / "elsewhere"])) == 2
    assert size_of(pc.Scene.load(path)) == 1


def test_a_folder_that_is_linked_is_sought_above_both_its_places(tmp_path):
    """As colcon's symlinks have it: the scene is in the sources, the package beside the link."""
    mesh(tmp_path / "install")
    scene_file(tmp_path / "src" / "scenes", OWN)
    (tmp_path / "install" / "scenes").symlink_to(tmp_path / "src" / "scenes")
    assert size_of(pc.Scene.load(tmp_path / "install" / "scenes" / "s.yaml")) == 1
    mesh(tmp_path / "src", 3)
    assert size_of(pc.Scene.load(tmp_path / "src" / "scenes" / "s.yaml")) == 3


def test_a_path_relative_to_the_working_folder_is_followed_up(tmp_path, monkeypatch):
    mesh(tmp_path)
    scene_file(tmp_path / "scenes", OWN)
    monkeypatch.chdir(tmp_path / "scenes")
    assert size_of(pc.Scene.load("s.yaml")) == 1


def test_problem_sets_find_their_packages(tmp_path):
    mesh(tmp_path)
    (tmp_path / "set").mkdir()
    (tmp_path / "set" / "scene0001.yaml").write_text(yaml.safe_dump(MOVEIT))
    request = {
        "start_state": {"joint_state": {"name": ["j"], "position": [0.0]}},
        "goal_constraints": [{"joint_constraints": [{"joint_name": "j", "position": 1.0}]}],
    }
    (tmp_path / "set" / "request0001.yaml").write_text(yaml.safe_dump(request))
    (problem,) = load_problems(tmp_path / "set")
    assert size_of(problem.scene) == 1


@pytest.mark.parametrize(("document", "name"), [(MOVEIT, "collision object 't'"), (OWN, "object 't'")])
def test_a_package_that_is_nowhere_is_named(tmp_path, document, name):
    path = scene_file(tmp_path, document)
    with pytest.raises(
        PlannercheckError,
        match=rf"s\.yaml': {name}: .*{ADDRESS}' is .*package://NAME/... needs the folder that contains NAME",
    ):
        pc.Scene.load(path)
    with pytest.raises(PlannercheckError, match=f"package_dirs .{tmp_path}"):
        pc.Scene.load(path, package_dirs=[tmp_path])
