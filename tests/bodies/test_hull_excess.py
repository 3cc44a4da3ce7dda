"""Warnings where a hull, taken by default, is much larger than its mesh, or fills the room between its parts."""

import warnings

import numpy as np
import pytest
import trimesh
from poses import at

import plannercheck as pc
from plannercheck.bodies.hull_excess import hull_between, hull_excess
from plannercheck.bodies.mesh_files import read_mesh
from plannercheck.bodies.pieces import hull_volume

URDF = (
    '<robot name="r"><link name="base"/><link name="arm"><collision><geometry><mesh filename="{}"/></geometry>'
    '</collision></link><joint name="j" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>'
    '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
)


def ring(inner):
    return trimesh.creation.annulus(inner, 1.0, 0.4)


def two_boxes(folder, suffix, apart=1.0):
    scene = trimesh.Scene()
    for name, x in (("left", -apart / 2), ("right", apart / 2)):
        pose = at(x)
        scene.add_geometry(trimesh.creation.box((0.1, 0.1, 0.1)), node_name=name, geom_name=name, transform=pose)
    scene.export(folder / f"two{suffix}")
    return folder / f"two{suffix}"


@pytest.mark.parametrize("inner", np.linspace(0.05, 0.95, 19))
def test_the_ratio_is_a_lower_bound_and_near_the_volumes_of_trimesh(inner):
    mesh = ring(inner)
    truth = mesh.convex_hull.volume / mesh.volume
    words = hull_excess(np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64))
    assert bool(words) == (truth > 2) or 2 < truth < 2.2
    if words:
        said = float(words.split()[3])
        assert 0.88 * truth <= said <= truth + 0.05


@pytest.mark.parametrize("mesh", [trimesh.creation.box((1, 2, 3)), trimesh.creation.icosphere(3), trimesh.Trimesh()])
def test_convex_and_open_meshes_are_not_warned_of(mesh):
    if not len(mesh.faces):
        mesh = ring(0.9)
        mesh.update_faces(np.arange(len(mesh.faces)) > 0)  # open: it has no volume
    assert hull_excess(np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64)) == ""


def test_a_flat_mesh_has_no_volume():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]])
    assert hull_excess(points, np.array([[0, 1, 2], [1, 3, 2]])) == ""
    with pytest.raises(pc.PlannercheckError):
        hull_volume(points[:0])


@pytest.mark.parametrize("suffix", [".glb", ".obj"])
def test_objects_that_are_apart_are_bodies_in_scenes_and_a_warning_of_links(tmp_path, suffix):
    path = two_boxes(tmp_path, suffix)
    assert "its 2 objects ('left', 'right') are apart" in hull_between(read_mesh(path))
    scene = pc.Scene()
    scene.add_mesh("cell", path, mesh_units="metre")
    assert [body.name for body in scene.bodies] == ["cell/left", "cell/right"]
    assert pc.Checker(pc.Robot.load("panda"), scene).scene.bodies[0].name == "cell/left"
    (tmp_path / "r.urdf").write_text(URDF.format(path.name))
    with pytest.warns(RuntimeWarning, match=r"r\.urdf: mesh of link 'arm': its 2 objects .* are apart"):
        robot = pc.Robot.load(tmp_path / "r.urdf", mesh_units="metre")
    assert len(robot.bodies) == 1


@pytest.mark.parametrize("geometry", ["hull", "solid"])
def test_geometry_that_is_asked_for_is_not_warned_of(tmp_path, geometry):
    ring(0.9).export(tmp_path / "ring.stl")
    (tmp_path / "r.urdf").write_text(URDF.format("ring.stl"))
    with pytest.warns(
        RuntimeWarning, match=r"'arm': the hull is [45]\.. times as large as the mesh: geometry=\"solid\""
    ):
        pc.Robot.load(tmp_path / "r.urdf")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pc.Robot.load(tmp_path / "r.urdf", geometry=geometry)


def test_one_object_of_a_file_is_taken_by_its_name_and_kept_in_saved_scenes(tmp_path):
    path = two_boxes(tmp_path, ".obj")
    text = "objects:\n- {name: cell, mesh: {file: two.obj, object: right}}\n- {name: all, mesh: {file: two.obj}}\n"
    (tmp_path / "s.yaml").write_text(text)
    scene = pc.Scene.load(tmp_path / "s.yaml")
    assert [body.name for body in scene.bodies] == ["cell/right", "all/left", "all/right"]
    scene.save(tmp_path / "again.yaml")
    again = pc.Scene.load(tmp_path / "again.yaml")
    assert [body.name for body in again.bodies] == [body.name for body in scene.bodies]
    assert all(
        np.array_equal(a.shape.vertices, b.shape.vertices) for a, b in zip(again.bodies, scene.bodies, strict=True)
    )
    (tmp_path / "s.yaml").write_text(text.replace("right", "rigth"))
    with pytest.raises(pc.PlannercheckError, match=r"two\.obj.*unknown object 'rigth'.*'right'"):
        pc.Scene.load(tmp_path / "s.yaml")
    assert path.exists()
