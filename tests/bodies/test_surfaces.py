"""A solid taken as its surface is the triangles of its mesh: what is inside is free, what meets a triangle collides."""

import pickle

import numpy as np
import pytest
import solid_meshes
from poses import at, pose_within

import plannercheck as pc
from plannercheck.bodies.solids import Solid

BOX = solid_meshes.box(2.0)
SIDE = float(np.abs(BOX[0]).max())
SHELL = Solid(*BOX, open="surface")


def test_the_inside_is_free_and_the_triangles_collide():
    cube = pc.Box((0.5, 0.5, 0.5))
    assert pc.intersects(Solid(*BOX), cube)
    assert not pc.intersects(SHELL, cube)
    assert pc.certify(SHELL, cube).verify()
    touching = at(SIDE - 0.25)
    assert pc.intersects(SHELL, cube, pose_r=touching)
    assert pc.certify(SHELL, cube, pose_r=touching).verify()
    assert not pc.intersects(SHELL, cube, pose_r=at(np.nextafter(SIDE - 0.25, 0)))
    assert pc.distance(SHELL, pc.Sphere(0.25)).distance == pytest.approx(SIDE - 0.25)


def test_what_a_surface_says_of_itself():
    assert (SHELL.kind, SHELL.is_open, SHELL.is_closed, SHELL.caps) == ("surface", False, False, None)
    assert not SHELL.equals_hull
    assert "surface" in repr(SHELL)
    assert len(SHELL.triangles) == len(BOX[1])
    assert SHELL.digest != Solid(*BOX).digest
    assert pickle.loads(pickle.dumps(SHELL)).digest == SHELL.digest
    opened = BOX[0], BOX[1][1:]
    assert Solid(*opened, open="surface").digest == Solid(*opened, open="triangles").digest


@pytest.mark.parametrize("name", sorted(solid_meshes.meshes()))
def test_surfaces_meet_where_their_triangles_do(name):
    meshes = solid_meshes.meshes()[name], solid_meshes.box(0.4)
    surfaces = [Solid(*mesh, open="surface") for mesh in meshes]
    rng = np.random.default_rng(5)
    for _ in range(15):
        pose = pose_within(rng, 0.8)
        met = solid_meshes.triangles_meet(meshes[0], np.eye(4), meshes[1], pose)
        assert pc.intersects(*surfaces, pose_r=pose) == met
        assert pc.certify(*surfaces, pose_r=pose).verify()


def test_a_robot_in_a_surface_is_judged_and_proved_as_without_it(tmp_path):
    scene = pc.Scene()
    scene.add("room", Solid(8 * BOX[0], BOX[1], open="surface"))
    scene.save(tmp_path / "room.yaml")
    robot = pc.Robot.load("panda")
    q = robot.random_configurations(50, 3)
    free = pc.Checker(robot).check_states(q)
    checker = pc.Checker(robot, pc.Scene.load(tmp_path / "room.yaml"))
    np.testing.assert_array_equal(checker.check_states(q), free)
    starts = q[free][:4]
    proofs = checker.certify_motions(starts, starts + 0.01)
    assert any(proofs)
    assert all(proof is None or proof.verify() for proof in proofs)


def test_a_file_says_that_it_is_a_surface(tmp_path):
    import trimesh

    trimesh.Trimesh(*BOX).export(tmp_path / "room.stl")
    assert Solid.load(tmp_path / "room.stl", open="surface").kind == "surface"
    (tmp_path / "cell.yaml").write_text("objects: [{name: room, solid: {file: room.stl, open: surface}}]")
    (room,) = pc.Scene.load(tmp_path / "cell.yaml").objects
    assert room.parts[0].shape.kind == "surface"
