"""Proofs that solids are apart whose hulls are not."""

import dataclasses

import numpy as np
from poses import at
from solid_meshes import ring

import plannercheck as pc
from plannercheck.bodies.solid_separations import SolidSeparation


def _box_with_a_hollow() -> pc.Solid:
    """A box of 4 m in which a box of 2 m is left out."""
    points, faces = pc.Box((4.0, 4.0, 4.0)).vertices_and_faces()
    assert faces is not None
    outer = np.concatenate([[[f[0], f[1], f[2]], [f[0], f[2], f[3]]] for f in faces])
    return pc.Solid(np.concatenate([points, points / 2]), np.concatenate([outer, outer[:, ::-1] + len(points)]))


def _linked() -> SolidSeparation:
    """Two rings of a chain."""
    pose = np.array([[1.0, 0, 0, 1], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    links = pc.Solid(*ring(12, 6, 0.25))
    assert not pc.intersects(links, links, None, pose)
    certificate = pc.certify(links, links, None, pose)
    assert isinstance(certificate, SolidSeparation)
    return certificate


def test_linked_rings_are_proved_apart() -> None:
    """Every triangle of one is kept away from every one of the other."""
    certificate = _linked()
    assert certificate.verify()
    assert 0 < certificate.gap < 0.5


def test_a_ball_in_a_hollow_is_proved_apart_and_one_in_the_wall_is_not() -> None:
    """A closed surface around a body does not hold it if it winds about it not at all."""
    box, ball = _box_with_a_hollow(), pc.Sphere(0.5)
    hollow = pc.certify(box, ball)
    assert isinstance(hollow, SolidSeparation)
    assert hollow.verify()
    assert 0 < hollow.gap <= 0.5
    in_the_wall = at(1.5)
    assert not isinstance(pc.certify(box, pc.Sphere(0.25), None, in_the_wall), SolidSeparation)


def test_a_separation_without_one_of_its_patches_is_refused() -> None:
    """Some triangles are then not kept apart."""
    certificate = _linked()
    for k in range(len(certificate.patches)):
        rest = certificate.patches[:k] + certificate.patches[k + 1 :]
        assert not dataclasses.replace(certificate, patches=rest).verify()


def test_a_separation_of_a_moved_body_is_refused() -> None:
    """The planes are held against the given poses, not against those they were found for."""
    certificate = _linked()
    first, second = certificate.bodies
    moved = second.pose.copy()
    moved[0, 3] += 2 * certificate.gap + 0.5
    changed = dataclasses.replace(certificate, bodies=(first, dataclasses.replace(second, pose=moved)))
    assert not changed.verify()


def test_a_larger_gap_is_refused() -> None:
    """The gap is the least of all planes."""
    certificate = _linked()
    assert not dataclasses.replace(certificate, gap=np.nextafter(certificate.gap, 1)).verify()


def test_a_separation_of_a_body_in_another_one_is_refused() -> None:
    """No triangles meet, but once the outer triangles are all turned outwards, they wind about the inner body."""
    box = _box_with_a_hollow()
    outwards = np.asarray(box.triangles[:12])
    turned = outwards.copy()
    turned[5] = turned[5, ::-1]
    certificate = pc.certify(pc.Solid(box.vertices, turned, open="triangles"), pc.Sphere(0.5))
    assert isinstance(certificate, SolidSeparation)
    assert certificate.verify()
    outer, inner = certificate.bodies
    corners = [set(map(tuple, outer.points[t].tolist())) for t in outer.triangles]
    wrong = {tuple(p) for p in box.vertices[turned[5]].tolist()}
    mended = outer.triangles.copy()
    k = corners.index(wrong)
    mended[k] = mended[k, ::-1]
    assert not dataclasses.replace(certificate, bodies=(dataclasses.replace(outer, triangles=mended), inner)).verify()
