"""Pictures draw solids as their triangles, and what two of them share."""

import numpy as np
import trimesh
from poses import at

import plannercheck as pc
from plannercheck.view.picture import picture
from plannercheck.view.surfaces import surface_of

RING = trimesh.creation.torus(0.5, 0.1, major_sections=12, minor_sections=6)


def test_solids_are_drawn_as_their_triangles():
    points, triangles = surface_of(pc.Solid(RING.vertices, RING.faces), "ring")
    assert len(triangles) == len(RING.faces)
    drawn = trimesh.Trimesh(points, triangles, process=False)
    assert drawn.is_watertight
    assert abs(drawn.volume - RING.volume) < 1e-9


def test_contacts_and_planes_of_solids():
    scene = pc.Scene("ring")
    pose = at(0.6, 0.1, 0.5)
    scene.add("ring", pc.Solid(RING.vertices, RING.faces), pose)
    checker = pc.Checker(pc.Robot.load("ur5", geometry="solid"), scene)
    q = checker.robot.random_configurations(40, 0)
    drawn = picture(checker, q, planes=2)
    collides = ~checker.check_states(q)
    seen = {witness.frame for witness in drawn.witnesses}
    assert seen == set(np.flatnonzero(collides).tolist())
    assert drawn.planes
    for witness in drawn.witnesses:
        assert any(set(witness.pair) == set(pair) for pair in drawn.collisions[witness.frame])
    (mesh,) = [each for each in drawn.meshes if each.name == "ring"]
    assert len(mesh.faces) == len(RING.faces)
