"""Scenes hold what was added, files give the same doubles back, and bad files name file, object and key."""

import errno
from pathlib import Path

import coal
import numpy as np
import pinocchio
import pytest

from plannercheck.bodies.mesh_files import read_mesh
from plannercheck.bodies.objects import Part
from plannercheck.bodies.shapes import Box, Capsule, Cone, Cylinder, Hull, Sphere
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.transforms import pose_of, quaternion_of_rotation, rotation_of_quaternion, rotation_of_rpy
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene, shipped_scenes

TETRAHEDRON = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]

OBJ = """v 0 0 0
v 100 0 0
v 0 200 0
v 0 0 300
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""

EVERYTHING = """
name: everything
objects:
  - name: worktop
    box: {size: [1.2, 0.6, 0.04]}
    position: [0.6, 0.0, 0.8]
    rpy: [0.1, 0.2, 0.3]
  - name: can
    cylinder: {radius: 0.03, length: 0.14}
    quaternion: [0, 0, 2, 2]
  - name: cup
    position: [0.5, -0.2, 0.9]
    rpy: [0, 0, 0.5]
    parts:
      - sphere: {radius: 4e-2}
      - capsule: {radius: 0.01, length: 0.05}
        position: [0.05, 0.0, 0.0]
      - cone: {radius: 0.03, length: 0.1}
  - name: tap
    mesh: {file: tap.obj, scale: 0.001}
  - name: wedge
    hull: {vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}
    matrix: [[1, 0, 0, 0.2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
allowed: [[panda_link0, worktop]]
allowed_by_default: {can: true}
forbidden: [[panda_hand, can]]
states:
  panda:
    start: [0, -0.785, 0, -2.356, 0, 1.571, 0.785]
    goal: [0.5, 0.3, 0, -2.0, 0, 2.3, 0.785]
    samples: everything_panda.npy
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "tap.obj").write_text(OBJ)
    (tmp_path / "everything.yaml").write_text(EVERYTHING)
    np.save(tmp_path / "everything_panda.npy", np.zeros((5, 7)))
    return tmp_path


def random_pose(rng):
    return pose_of(rng.normal(size=3), pinocchio.SE3.Random().rotation)


def loaded(tmp_path, text):
    path = tmp_path / "scene.yaml"
    path.write_text(text)
    return Scene.load(path)


def assert_same(a, b):
    assert [x.name for x in a.bodies] == [x.name for x in b.bodies]
    for x, y in zip(a.bodies, b.bodies, strict=True):
        assert x.pose.tolist() == y.pose.tolist()
        if isinstance(x.shape, Hull):
            assert x.shape.vertices.tolist() == y.shape.vertices.tolist()
        else:
            assert x.shape == y.shape


def test_added_shapes_become_bodies_in_the_world():
    scene = Scene("s")
    pose = random_pose(np.random.default_rng(1))
    scene.add_box("box", (1, 2, 3), pose)
    scene.add_sphere("sphere", 0.1)
    scene.add_cylinder("cylinder", 0.1, 0.2)
    scene.add_capsule("capsule", 0.1, 0.2)
    scene.add_cone("cone", 0.1, 0.2)
    scene.add_hull("hull", TETRAHEDRON)
    expected = [Box((1, 2, 3)), Sphere(0.1), Cylinder(0.1, 0.2), Capsule(0.1, 0.2), Cone(0.1, 0.2)]
    assert [b.shape for b in scene.bodies[:5]] == expected
    assert scene.bodies[5].shape.vertices.tolist() == TETRAHEDRON
    assert all(b.link is None for b in scene.bodies)
    assert scene.bodies[0].pose.tolist() == pose.tolist()
    assert scene.object_names == ("box", "sphere", "cylinder", "capsule", "cone", "hull")


def test_objects_of_several_parts_number_their_bodies():
    scene = Scene()
    scene.add("cup", [Part(Sphere(0.1)), Part(Sphere(0.2))])
    scene.add_sphere("ball", 0.1)
    assert [b.name for b in scene.bodies] == ["cup/0", "cup/1", "ball"]
    assert scene.body_objects == ("cup", "cup", "ball")
    with pytest.raises(PlannercheckError, match="another object is named 'cup/0'"):
        scene.add_box("cup/0", (1, 1, 1))


def test_removed_objects_are_gone_and_their_names_free():
    scene = Scene()
    scene.add("cup", [Part(Sphere(0.1)), Part(Sphere(0.2))])
    scene.remove("cup")
    assert scene.bodies == ()
    scene.add_sphere("cup/0", 0.1)
    with pytest.raises(PlannercheckError, match=r"unknown object 'cap': .*valid are cup/0"):
        scene.remove("cap")


def test_a_name_is_used_once():
    scene = Scene()
    scene.add_sphere("ball", 0.1)
    with pytest.raises(PlannercheckError, match="object 'ball' exists already"):
        scene.add_box("ball", (1, 1, 1))


def test_a_bad_pose_names_the_object():
    with pytest.raises(PlannercheckError, match="object 'ball' is not rigid"):
        Scene().add_sphere("ball", 0.1, 2 * np.eye(4) - np.diag([0, 0, 0, 1.0]))


def test_meshes_are_loaded_and_scaled(folder):
    scene = Scene()
    with pytest.warns(RuntimeWarning, match="millimetres"):
        scene.add_mesh("tap", folder / "tap.obj", scale=(0.001, 0.01, 1.0))
    assert np.ptp(scene.bodies[0].shape.vertices, axis=0).tolist() == [0.1, 2.0, 300.0]


@pytest.mark.parametrize("scale", [0.0, [1, 2], "big", np.nan])
def test_bad_mesh_scales_are_refused(folder, scale):
    with pytest.raises(PlannercheckError, match="mesh scale"):
        read_mesh(folder / "tap.obj", scale)


def test_bad_meshes_name_the_file(folder):
    (folder / "bad.stl").write_text("no mesh")
    with pytest.raises(PlannercheckError, match=r"bad\.stl"):
        read_mesh(folder / "bad.stl")
    with pytest.raises(PlannercheckError, match=r"none\.stl' does not exist"):
        read_mesh(folder / "none.stl")


def test_a_file_holds_every_kind_of_object(folder):
    scene = Scene.load(folder / "everything.yaml")
    assert scene.object_names == ("worktop", "can", "cup", "tap", "wedge")
    worktop, can, ball, grip, _, tap, wedge = scene.bodies
    assert worktop.shape == Box((1.2, 0.6, 0.04))
    assert np.allclose(worktop.pose[:3, :3], pinocchio.rpy.rpyToMatrix(0.1, 0.2, 0.3), atol=1e-15)
    assert np.allclose(can.pose[:2, :2], [[0, -1], [1, 0]])
    assert ball.shape.radius == 0.04
    assert np.allclose(grip.pose[:3, 3], [0.5 + 0.05 * np.cos(0.5), -0.2 + 0.05 * np.sin(0.5), 0.9])
    assert np.ptp(tap.shape.vertices, axis=0) == pytest.approx([0.1, 0.2, 0.3])
    assert wedge.pose[0, 3] == 0.2
    assert scene.start("panda")[1] == -0.785
    assert scene.goal("panda")[0] == 0.5
    assert scene.samples("panda").shape == (5, 7)


def test_what_may_touch(folder):
    scene = Scene.load(folder / "everything.yaml")
    assert scene.allowed_pairs == {frozenset(("panda_link0", "worktop"))}
    assert scene.is_allowed("worktop", "panda_link0")
    assert not scene.is_allowed("worktop", "panda_link1")
    assert scene.is_allowed("panda_link5", "can")
    assert not scene.is_allowed("can", "panda_hand")


def test_saved_scenes_give_the_same_doubles(folder):
    rng = np.random.default_rng(5)
    scene = Scene.load(folder / "everything.yaml")
    for k in range(20):
        scene.add_box(f"box {k}", rng.uniform(1e-5, 1, 3), random_pose(rng))
        scene.add_hull(f"hull {k}", rng.normal(size=(6, 3)), random_pose(rng))
    scene.add("pair", [Part(Capsule(1e-7, 1e5), random_pose(rng)), Part(Sphere(0.1))])
    scene.save(folder / "saved.yaml")
    again = Scene.load(folder / "saved.yaml")
    assert_same(scene, again)
    assert again.name == "everything"
    assert again.allowed == scene.allowed
    assert again.start("panda").tolist() == scene.start("panda").tolist()
    assert again.samples("panda").shape == (5, 7)


def test_quaternions_and_rotations_agree_with_pinocchio():
    rng = np.random.default_rng(2)
    for _ in range(200):
        q = rng.normal(size=4)
        expected = pinocchio.Quaternion(q / np.linalg.norm(q)).toRotationMatrix()
        rotation = rotation_of_quaternion(7.5 * q)
        assert np.allclose(rotation, expected, atol=1e-15)
        assert np.allclose(rotation_of_quaternion(quaternion_of_rotation(rotation)), rotation, atol=2e-15)
        rpy = rng.uniform(-4, 4, 3)
        assert np.allclose(rotation_of_rpy(rpy), pinocchio.rpy.rpyToMatrix(*rpy), atol=1e-15)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("objects: [{name: a, box: {size: [1, 2]}}]", "object 'a': box: 'size' needs 3 numbers, not 2"),
        (
            "objects: [{name: a, box: {size: [1, 2, -3]}}]",
            "object 'a': box: box size z must be finite and not negative",
        ),
        ("objects: [{name: a, box: {width: 1}}]", "unknown key 'width': valid are size"),
        ("objects: [{name: a, sphere: {}}]", "object 'a': sphere: key 'radius' is missing"),
        ("objects: [{name: a, sphere: {radius: .nan}}]", "'radius' must be a finite number"),
        ("objects: [{name: a, sphere: {radius: wide}}]", "'radius' must be a number, not 'wide'"),
        ("objects: [{name: a, sphere: {radius: true}}]", "'radius' must be a finite number, not True"),
        ("objects: [{name: a, ball: {radius: 1}}]", "object 'a': unknown key 'ball'"),
        ("objects: [{name: a}]", "object 'a': needs exactly one of the keys box, sphere"),
        ("objects: [{name: a, sphere: {radius: 1}, parts: []}]", "given are parts and sphere"),
        ("objects: [{sphere: {radius: 1}}]", "object 0: key 'name' is missing"),
        ("objects: [{name: a, sphere: {radius: 1}}, {name: a, sphere: {radius: 1}}]", "'a' exists already"),
        ("objects: [{name: a, sphere: {radius: 1}, quaternion: [0, 0, 0, 0]}]", "'a': quaternion .* no direction"),
        ("objects: [{name: a, sphere: {radius: 1}, quaternion: [0, 0, 1]}]", "'quaternion' needs 4 numbers"),
        ("objects: [{name: a, sphere: {radius: 1}, rpy: [0, 0, 1], quaternion: [0, 0, 0, 1]}]", "leave one out"),
        ("objects: [{name: a, sphere: {radius: 1}, position: [0, .inf, 1]}]", "'position' must be a finite"),
        ("objects: [{name: a, parts: [{sphere: {radius: 1}}, {box: 3}]}]", "'a': part 1: box: it must be a mapping"),
        ("objects: [{name: a, mesh: {file: no.stl}}]", r"'a': mesh: mesh file '.*no\.stl' does not exist"),
        ("objects: [{name: a, hull: {vertices: [[0, 0, 0]]}}]", "'a': hull: .* at least 4 points"),
        ("objects: [{name: a, hull: {vertices: [[0, 0]]}}]", "'vertices row 0' needs 3"),
        ("objects: [{name: a, hull: {file: no.npy}}]", r"no\.npy' can't be read as npy"),
        ("objects: {a: 1}", "'objects' must be a list"),
        ("obstacles: []", "unknown key 'obstacles': .*valid are name, objects"),
        ("objects: []\nallowed: [[a]]", "'allowed' must be two names"),
        (
            "objects: [{name: a, sphere: {radius: 1}}]\nallowed: [[a, b]]\nforbidden: [[b, a]]",
            "'forbidden' names b and a, of whom another entry says the opposite: keep one",
        ),
        ("objects: []\nstates: {panda: {begin: [1]}}", "states of 'panda': unknown key 'begin'"),
        ("objects: []\nstates: {panda: {start: [1, 2], goal: [1]}}", "start has 2 values, goal has 1"),
        ("- just a list", "must be a mapping"),
        ("a: [1", "no valid YAML: .* at line 1"),
    ],
)
def test_bad_files_name_file_object_and_key(tmp_path, text, message):
    with pytest.raises(PlannercheckError, match=rf"scene file '.*scene\.yaml': .*{message}"):
        loaded(tmp_path, text)


def test_angles_that_look_like_degrees_are_said(tmp_path):
    turned = "sphere: {radius: 1}, rpy: [0, 0, 90]"
    for text, place in (
        ("{name: can, %s}", "object 'can'"),
        ("{name: a, sphere: {radius: 1}}, {name: can, parts: [{%s}]}", "object 'can': part 0"),
    ):
        words = rf"^scene file '.*scene\.yaml': {place}: rpy \[0\.0, 0\.0, 90\.0\] looks like degrees: rpy is in rad$"
        with pytest.warns(RuntimeWarning, match=words):
            loaded(tmp_path, f"objects: [{text % turned}]")


def test_missing_scenes_are_named(tmp_path):
    with pytest.raises(PlannercheckError, match=r"none\.yaml' does not exist"):
        Scene.load(tmp_path / "none.yaml")
    (tmp_path / "folder.yaml").mkdir()
    for load in (Scene.load, Scene.from_mjcf, Robot.load):
        with pytest.raises(PlannercheckError, match=r"folder\.yaml'? is a folder: give the path of a file in it$"):
            load(tmp_path / "folder.yaml")
    with pytest.raises(PlannercheckError, match="unknown scene 'bookshelv': did you mean 'bookshelf'"):
        Scene.load("bookshelv")


def test_undeclared_states_are_named(folder):
    scene = Scene.load(folder / "everything.yaml")
    with pytest.raises(PlannercheckError, match="'everything' declares no start for robot 'ur5', but for panda"):
        scene.start("ur5")
    scene.set_states("ur5", start=[0.0] * 6)
    with pytest.raises(PlannercheckError, match="declares no goal for robot 'ur5'"):
        scene.goal("ur5")
    with pytest.raises(PlannercheckError, match="declares no samples for robot 'ur5'"):
        scene.samples("ur5")


def test_bad_samples_are_named(folder):
    scene = Scene.load(folder / "everything.yaml")
    file = folder / "everything_panda.npy"
    file.write_bytes(file.read_bytes()[:-8])
    with pytest.raises(PlannercheckError, match=r"everything_panda\.npy' can't be read as npy"):
        scene.samples("panda")
    np.save(file, np.zeros((5, 6)))
    with pytest.raises(PlannercheckError, match="have 6 columns, start has 7"):
        scene.samples("panda")
    np.save(file, np.full((5, 7), np.nan))
    with pytest.raises(PlannercheckError, match="row 0 has values that are not finite"):
        scene.samples("panda")
    file.unlink()
    with pytest.raises(PlannercheckError, match=r"everything_panda\.npy' can't be read"):
        scene.samples("panda")


def test_shipped_scenes_are_complete():
    assert set(shipped_scenes()) >= {"bookshelf", "cage", "table", "bin", "kitchen", "empty"}
    for name in shipped_scenes():
        scene = Scene.load(name)
        assert scene.name == name
        for robot, nq in (("panda", 7), ("ur5", 6)):
            assert scene.samples(robot).shape == (1000, nq)
            assert len(scene.start(robot)) == len(scene.goal(robot)) == nq


def test_shapes_lie_as_coal_has_them():
    cone, points = coal.Cone(0.1, 0.4), Cone(0.1, 0.4).vertices_and_faces()[0]
    cone.computeLocalAABB()
    assert points[:, 2].min() == pytest.approx(cone.aabb_local.min_[2])
    probe, at_top = coal.Sphere(0.01), coal.Transform3s(np.eye(3), np.array([0.08, 0.0, 0.19]))
    distance = coal.distance(cone, coal.Transform3s(), probe, at_top, coal.DistanceRequest(), coal.DistanceResult())
    assert distance > 0.01


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ("", "objects"),
        ("name: nothing", "objects"),
        (
            "objects: [{name: table, box: {size: [1, 1, 1]}}]\nallowed: [[panda_link0, tabel]]",
            "tabel.*objects are table",
        ),
    ],
)
def test_scene_files_that_say_too_little_are_refused(tmp_path, document, message):
    path = tmp_path / "scene.yaml"
    path.write_text(document)
    with pytest.raises(PlannercheckError, match=message):
        Scene.load(path)


@pytest.mark.parametrize("name", ["s.yaml", "s.scene"])
def test_a_file_that_can_not_be_written_stays_as_it_was(tmp_path, monkeypatch, name):
    scene = Scene("s")
    scene.add_box("a", (1, 1, 1))
    scene.save(tmp_path / name)
    before = (tmp_path / name).read_text()

    def full(path, text, **options):
        with path.open("w") as file:
            file.write(text[:10])
        raise OSError(errno.ENOSPC, "No space left on device")

    scene.add_box("b", (1, 1, 1))
    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(PlannercheckError, match=f"scene file '.*{name}' can't be written: No space left on device"):
        scene.save(tmp_path / name)
    assert (tmp_path / name).read_text() == before
    with pytest.raises(
        PlannercheckError, match=r"scene file '.*nowhere.*' can't be written: No such file or directory"
    ):
        scene.save(tmp_path / "nowhere" / name)


def test_notebooks_show_a_table_of_the_objects(folder):
    scene = Scene.load(folder / "everything.yaml")
    scene.add_box("<script>alert(1)</script>", (1, 1, 1))
    scene.attach("mug", "panda_hand", pose_of([0, 0, 0.1]), parts=Cylinder(0.03, 0.1))
    shown = scene._repr_html_()
    assert "<td>worktop</td><td>box 1.2 × 0.6 × 0.04</td><td>0.6, 0, 0.8</td><td>the world</td>" in shown
    assert "<td>mug</td><td>cylinder of radius 0.03, length 0.1</td><td>0, 0, 0.1</td><td>panda_hand</td>" in shown
    assert "sphere of radius 0.04, capsule of radius 0.01, length 0.05, cone of radius 0.03, length 0.1" in shown
    assert "<td>hull of 4 points</td>" in shown
    assert "<script>" not in shown
    assert shown.count("<tr>") == 1 + len(scene.objects) + len(scene.attached)
    for k in range(100):
        scene.add_sphere(f"ball {k}", 0.1)
    assert "… and 67 more" in scene._repr_html_()
    assert scene._repr_html_().count("<tr>") == 42
