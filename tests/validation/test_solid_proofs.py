"""Verdicts of sets with solids are proved about the meshes that were given; proofs about others are not taken."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from poses import at

import plannercheck as pc
from plannercheck.validation.certification import certify_verdicts
from plannercheck.validation.solid_proofs import GivenMesh, proves_contact, proves_separation

RING = pc.Solid(*(lambda m: (m.vertices, m.faces))(trimesh.creation.torus(0.5, 0.2, 12, 6)))
BOX = pc.Box((0.1, 0.12, 0.14))
POINTS = BOX.vertices_and_faces()[0]
HERE = np.eye(4)


def given(pose, radius=0.0):
    return (GivenMesh(*RING.used, 0.0), HERE), (GivenMesh(POINTS, None, radius), pose)


def certified(pose, turned=False):
    return pc.certify(BOX, RING, pose, HERE) if turned else pc.certify(RING, BOX, HERE, pose)


@pytest.mark.parametrize("turned", [False, True])
def test_separations_are_of_the_given_meshes(turned):
    pose = at(0.02, 0.01, 0)
    certificate, bodies = certified(pose, turned), given(pose)
    bodies = bodies[::-1] if turned else bodies
    assert isinstance(certificate, pc.SolidSeparation)
    assert proves_separation(certificate, *bodies)
    ring, box = bodies[::-1] if turned else bodies

    def says(ring, box):
        return proves_separation(certificate, *((box, ring) if turned else (ring, box)))

    assert not says((GivenMesh(RING.used[0], RING.used[1][1:], 0.0), HERE), box)  # a triangle less
    assert not says((GivenMesh(1.01 * RING.used[0], RING.used[1], 0.0), HERE), box)
    assert not says(ring, (GivenMesh(POINTS, None, 0.01), pose))  # another radius
    assert not says(ring, (GivenMesh(POINTS, None, 0.0), at(0.02, 0.011, 0)))  # elsewhere
    assert not says(ring, (GivenMesh(np.vstack([POINTS, [[0.5, 0, 0]]]), None, 0.0), pose))  # a larger hull
    parts = replace(certificate, patches=certificate.patches[1:])
    assert not proves_separation(parts, *bodies)


@pytest.mark.parametrize(("pose", "kind"), [(at(0.5, 0, 0), "Enclosure"), (at(0.3, 0, 0), "SharedPoint")])
def test_contacts_are_of_the_given_meshes(pose, kind):
    certificate, (ring, box) = certified(pose), given(pose)
    assert type(certificate).__name__ == kind
    assert proves_contact(certificate, ring, box)
    assert not proves_contact(certificate, (GivenMesh(1.01 * RING.used[0], RING.used[1], 0.0), HERE), box)
    assert not proves_contact(certificate, ring, (GivenMesh(0.9 * POINTS, None, 0.0), pose))
    assert not proves_contact(certificate, ring, (GivenMesh(POINTS, None, 0.0), HERE))
    assert not proves_contact(certificate, (ring[0], pose), box)


def test_sets_of_verdicts_are_proved():
    scene = pc.Scene("ring")
    scene.add("ring", RING, at(0.5, 0.1, 0.4))
    checker = pc.Checker(pc.Robot.load("ur5", geometry={"forearm_link": "solid"}), scene)
    q = checker.robot.random_configurations(15, 2)
    report = certify_verdicts(checker, q, checker.first_colliding_pair(q))
    assert report.passed
    assert report.states == 15
    wrong = np.where(checker.check_states(q), 0, -1).astype(np.int32)
    assert len({each.row for each in certify_verdicts(checker, q[:4], wrong[:4]).unproved}) == 4
