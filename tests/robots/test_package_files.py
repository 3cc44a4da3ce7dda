"""package:// addresses are found by the name of the package, as ROS finds them."""

import os
import re

import pytest

import plannercheck as pc
from plannercheck.common.package_files import folders_above, package_file

URDF = (
    '<robot name="r"><link name="a"><collision><geometry>'
    '<mesh filename="package://arm_description/meshes/a.stl"/></geometry></collision></link></robot>'
)
CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


@pytest.fixture(autouse=True)
def no_ros(monkeypatch):
    for name in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)


def package(folder, name="arm_description"):
    """A package with a mesh and a URDF; its folder may be called otherwise."""
    (folder / "meshes").mkdir(parents=True)
    (folder / "urdf").mkdir()
    (folder / "package.xml").write_text(f"<?xml version='1.0'?>\n<package>\n  <name> {name} </name>\n</package>\n")
    loops = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*CORNERS[k]) for k in face)
        + "endloop\nendfacet\n"
        for face in FACES
    )
    (folder / "meshes" / "a.stl").write_text(f"solid m\n{loops}endsolid m\n")
    (folder / "urdf" / "r.urdf").write_text(URDF)
    return folder


def alone(folder):
    """A URDF with no package about it."""
    (folder / "elsewhere" / "deep").mkdir(parents=True)
    path = folder / "elsewhere" / "deep" / "r.urdf"
    path.write_text(URDF)
    return path


def assert_found(urdf, **options):
    robot = pc.Robot.from_urdf(urdf, **options)
    assert len(robot.bodies[0].shape.vertices) == 4


def test_the_package_above_the_urdf_has_another_name_than_its_folder(tmp_path):
    assert_found(package(tmp_path / "ws" / "src" / "arm-ros2-main") / "urdf" / "r.urdf")


def test_a_package_beside_that_of_the_urdf(tmp_path):
    package(tmp_path / "src" / "meshes-of-the-arm")
    other = package(tmp_path / "src" / "cell", "cell") / "urdf" / "r.urdf"
    (tmp_path / "src" / "cell" / "meshes" / "a.stl").unlink()
    assert_found(other)


@pytest.mark.parametrize("given", ["", "arm-main", ".."])
def test_package_dirs_are_workspaces_or_packages(tmp_path, given):
    package(tmp_path / "ws" / "src" / "repository" / "arm-main")
    folder = tmp_path / "ws" / "src" / "repository" / given
    assert_found(alone(tmp_path), package_dirs=folder)


def test_ros_package_path(tmp_path, monkeypatch):
    package(tmp_path / "ws" / "src" / "arm-main")
    urdf = alone(tmp_path)
    monkeypatch.setenv("ROS_PACKAGE_PATH", os.pathsep.join(["/nowhere", str(tmp_path / "ws" / "src")]))
    assert_found(urdf)


def test_ament_prefix_path(tmp_path, monkeypatch):
    package(tmp_path / "install" / "share" / "arm_description")
    urdf = alone(tmp_path)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "install"))
    assert_found(urdf)


def test_links_of_a_colcon_workspace_are_followed(tmp_path, monkeypatch):
    source = package(tmp_path / "src" / "arm-main")
    installed = tmp_path / "install" / "arm_description" / "share" / "arm_description"
    (installed / "urdf").mkdir(parents=True)
    (installed / "urdf" / "r.urdf").symlink_to(source / "urdf" / "r.urdf")
    (installed / "meshes").symlink_to(source / "meshes")
    (source / "package.xml").unlink()  # only what is installed says the name
    assert_found(installed / "urdf" / "r.urdf")
    workspace = tmp_path / "links"
    workspace.mkdir()
    (workspace / "arm").symlink_to(package(tmp_path / "far" / "arm"))
    (workspace / "self").symlink_to(workspace)  # a loop
    assert_found(alone(tmp_path), package_dirs=workspace)


def test_an_error_names_all_places(tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_PACKAGE_PATH", "/opt/ros/share")
    message = (
        "package://arm_description/meshes/a.stl could not be found. Searched were the folders above the file, "
        "package_dirs (/nowhere), ROS_PACKAGE_PATH (/opt/ros/share) and AMENT_PREFIX_PATH (not set)"
    )
    with pytest.raises(pc.PlannercheckError, match=re.escape(message)):
        pc.Robot.from_urdf(alone(tmp_path), package_dirs="/nowhere")


def test_other_addresses(tmp_path):
    folder = package(tmp_path / "arm-main")
    mesh, above = folder / "meshes" / "a.stl", folders_above(folder / "urdf" / "r.urdf")
    assert package_file(f"file://{mesh}", ()) == mesh
    assert package_file("meshes/a.stl", (folder,)) == mesh
    assert package_file("model://arm_description/meshes/a.stl", (), above) == mesh
    assert package_file("package://arm_description/meshes/b.stl", (), above) is None
    assert package_file("package://", (), above) is None


def test_a_moveit_scene_looks_above_itself(tmp_path):
    folder = package(tmp_path / "arm-main")
    scene = folder / "scenes" / "s.yaml"
    scene.parent.mkdir()
    scene.write_text(
        "world: {collision_objects: [{id: part, header: {frame_id: world}, operation: 0, meshes: ["
        "{resource: 'package://arm_description/meshes/a.stl'}], mesh_poses: [{position: {x: 0, y: 0, z: 0}, "
        "orientation: {x: 0, y: 0, z: 0, w: 1}}]}]}\n"
    )
    assert len(pc.Scene.load(scene).objects[0].parts[0].shape.vertices) == 4
    scene.write_text(scene.read_text().replace("a.stl", "b.stl"))
    with pytest.raises(pc.PlannercheckError, match=r"b\.stl' is not found\. Searched were the folders above the file"):
        pc.Scene.load(scene)


ADDRESS = "package://arm_description/meshes/a.stl"


def mesh_of(folder):
    return package(folder) / "meshes" / "a.stl"


def test_the_prefix_of_an_installation_is_above_share(tmp_path, monkeypatch):
    """Pinocchio looks there by itself for meshes, but for nothing else."""
    mesh = mesh_of(tmp_path / "install" / "share" / "arm_description")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "install"))
    assert package_file(ADDRESS, ()) == mesh


def test_names_of_packages_are_whole(tmp_path):
    package(tmp_path / "one", "arm_description_old")
    assert package_file(ADDRESS, (tmp_path,)) is None
    mesh = mesh_of(tmp_path / "two")
    assert package_file(ADDRESS, (tmp_path,)) == mesh


def test_a_package_far_above_a_file_is_found(tmp_path):
    folder = package(tmp_path / "arm-main")
    deep = folder / "a" / "b" / "c" / "d" / "e"
    deep.mkdir(parents=True)
    assert package_file(ADDRESS, (), folders_above(deep / "r.urdf")) == folder / "meshes" / "a.stl"


def test_what_is_given_is_before_the_environment(tmp_path, monkeypatch):
    given, above, of_ros, installed = (
        mesh_of(tmp_path / name) for name in ("given/one", "above/two", "ros/three", "install/share/arm_description")
    )
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros"))
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "install"))
    file = above.parent.parent / "urdf" / "r.urdf"
    assert package_file(ADDRESS, (tmp_path / "given",)) == given
    assert package_file(ADDRESS, (), folders_above(file)) == above
    assert package_file(ADDRESS, ()) == of_ros
    monkeypatch.delenv("ROS_PACKAGE_PATH")
    assert package_file(ADDRESS, ()) == installed


def test_a_package_holds_no_others(tmp_path):
    outer = package(tmp_path / "ws" / "outer", "outer")
    mesh_of(outer / "test" / "copy")
    assert package_file(ADDRESS, (tmp_path / "ws",)) is None


def test_folders_above_are_those_of_the_link_and_of_what_it_leads_to(tmp_path):
    source = package(tmp_path / "src" / "arm-main")
    (tmp_path / "install" / "urdf").mkdir(parents=True)
    link = tmp_path / "install" / "urdf" / "r.urdf"
    link.symlink_to(source / "urdf" / "r.urdf")
    above = folders_above(link)
    assert above.index(link.parent) < above.index(source / "urdf")
    assert package_file(ADDRESS, (), above) == source / "meshes" / "a.stl"
