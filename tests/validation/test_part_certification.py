"""Certificates of verdicts before clouds, grids and height fields: about the shapes as given."""

from dataclasses import replace

import numpy as np
import pytest
from nested_parts import surface
from poses import at

import plannercheck as pc
from plannercheck.bodies.certificates import SharedPoint
from plannercheck.bodies.intersection import certify_posed
from plannercheck.bodies.part_certificates import PartSeparation
from plannercheck.bodies.part_sets import PartSet
from plannercheck.validation.certification import certify_verdicts
from plannercheck.validation.part_proofs import (
    GivenParts,
    given_parts,
    proves_contact_of_parts,
    proves_separation_of_parts,
)
from plannercheck.validation.solid_proofs import GivenMesh

RNG = np.random.default_rng(6)
POINTS = RNG.uniform(-0.5, 0.5, size=(700, 3))
HOLES = RNG.uniform(0.0, 0.4, size=(12, 9))
HOLES[3, 4] = np.nan
FLAT = np.where(RNG.random((6, 6)) < 0.5, 0.0, 0.2)
SHAPES: dict[str, PartSet] = {
    "cloud": pc.PointCloud(POINTS, RNG.uniform(0.005, 0.03, size=700)),
    "few": pc.PointCloud(POINTS[:20], 0.04),
    "grid": pc.VoxelGrid(RNG.random((8, 8, 8)) < 0.15, 0.1 / 0.9, (-0.5, -0.5, -0.5)),
    "map": pc.Octree.from_cells(np.unique(RNG.integers(-4, 4, size=(60, 3)), axis=0), 0.1, unknown="occupied"),
    "heights": pc.HeightField(HOLES, 0.1, -0.1, (-0.5, -0.5)),
    "flat": pc.HeightField(FLAT, 0.15, 0.0, (-0.4, -0.4)),
    "empty": pc.PointCloud(np.zeros((0, 3)), 0.1),
}
HERE = np.eye(4)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("padding", [0.0, 0.02])
def test_all_verdicts_are_certified(name: str, padding: float) -> None:
    robot, scene = pc.Robot.load("panda"), pc.Scene()
    scene.add("sensor", SHAPES[name], at(0.6, 0.1, 0.45))
    scene.attach("held", "panda_hand", parts=pc.PointCloud(POINTS[:15] * 0.1 + np.array([0, 0, 0.2]), 0.01))
    checker = pc.Checker(robot, scene, padding={"sensor": padding})
    q = robot.random_configurations(20, seed=2)
    report = certify_verdicts(checker, q, checker.first_colliding_pair(q))
    assert report.passed
    assert report.states == 20
    assert name == "empty" or report.shared_points > 2


@pytest.mark.parametrize("name", [name for name in SHAPES if name != "empty"])
def test_parts_are_made_as_documented(name: str) -> None:
    shape = SHAPES[name]
    ours, core = given_parts(shape, 0.25), shape.core
    found = [core.part(place) for place in range(core.places) if len(core.part(place)[0])]
    assert len(found) == shape.count == len(ours.radii)
    theirs = sorted(
        (*np.sort(corners.round(12), axis=0).ravel().tolist(), radius + 0.25) for corners, radius, _ in found
    )
    mine = sorted(
        (*np.sort(corners.round(12), axis=0).ravel().tolist(), radius)
        for corners, radius in zip(ours.corners, ours.radii.tolist(), strict=True)
    )
    assert theirs == mine


def certificate_of(shape: PartSet, box_at: np.ndarray) -> tuple[object, GivenParts, GivenMesh]:
    box = pc.Polytope(pc.Box((0.2, 0.2, 0.2)))
    certificate = certify_posed(pc.Polytope(shape), box, HERE, box_at)
    return certificate, given_parts(shape, 0.0), GivenMesh(box.vertices, None, 0.0)


@pytest.mark.parametrize("name", ["cloud", "grid", "heights"])
def test_a_shared_point_of_another_part_proves_nothing(name: str) -> None:
    shape = SHAPES[name]
    place = given_parts(shape, 0.0).corners[0].mean(axis=0)
    certificate, parts, mesh = certificate_of(shape, at(*place))
    assert isinstance(certificate, SharedPoint)
    given = (parts, HERE), (mesh, at(*place))
    assert proves_contact_of_parts(certificate, *given)
    part, other = certificate.bodies
    for changed in (
        replace(part, vertices=part.vertices + 2.0**-40),
        replace(part, inflation_radius=part.inflation_radius + 2.0**-40),
        replace(part, pose=at(2.0**-40, 0, 0)),
    ):
        assert not proves_contact_of_parts(replace(certificate, bodies=(changed, other)), *given)
    fewer = GivenParts(parts.corners[::2], parts.radii[::2]), GivenParts(parts.corners[1::2], parts.radii[1::2])
    assert [proves_contact_of_parts(certificate, (each, HERE), given[1]) for each in fewer].count(True) == 1


@pytest.mark.parametrize("name", ["cloud", "grid"])
def test_planes_that_leave_parts_out_prove_nothing(name: str) -> None:
    shape = SHAPES[name]
    free = next(
        place
        for place in np.random.default_rng(0).uniform(-0.3, 0.3, size=(4000, 3))
        if not pc.intersects(pc.Polytope(shape), pc.Polytope(pc.Box((0.02, 0.02, 0.02))), HERE, at(*place))
    )
    box = pc.Polytope(pc.Box((0.02, 0.02, 0.02)))
    certificate = certify_posed(pc.Polytope(shape), box, HERE, at(*free))
    assert isinstance(certificate, PartSeparation)
    parts, mesh = given_parts(shape, 0.0), GivenMesh(box.vertices, None, 0.0)
    given = (parts, HERE), (mesh, at(*free))
    assert proves_separation_of_parts(certificate, *given)
    first, second = certificate.bodies
    count = parts.corners.shape[1]
    fewer = replace(first, corners=first.corners[count:], start=first.start[:-1], radii=first.radii[1:])
    moved = replace(first, corners=first.corners + 2.0**-40)
    thinner = replace(first, radii=first.radii * 0.5 - 2.0**-40)
    for changed in (fewer, moved, thinner):
        assert not proves_separation_of_parts(replace(certificate, bodies=(changed, second)), *given)
    larger = GivenMesh(box.vertices * 40, None, 0.0)
    assert not proves_separation_of_parts(certificate, given[0], (larger, at(*free)))
    assert not proves_separation_of_parts(replace(certificate, ranges=certificate.ranges[1:]), *given)


def test_another_solid_is_no_proof_of_this_one() -> None:
    """A plane to each triangle of the certificate proves something about these triangles alone."""
    cells = np.zeros((3, 3, 3), dtype=bool)
    cells[0], cells[2], cells[:, :, 0] = True, True, True
    corners, triangles = surface(cells, np.array([1, 1, 1]))
    solid, cloud = pc.Solid(corners * 1.0, triangles), pc.PointCloud([[1.5, 1.5, 2.0]], 0.125)
    certificate = certify_posed(pc.Polytope(cloud), pc.Polytope(solid), HERE, HERE)
    assert isinstance(certificate, PartSeparation)
    parts = given_parts(cloud, 0.0), HERE
    points, used = solid.used
    assert proves_separation_of_parts(certificate, parts, (GivenMesh(points, used, 0.0), HERE))
    moved = np.where(points == 3.0, 4.0, points)
    for other in (GivenMesh(moved, used, 0.0), GivenMesh(points, used[1:], 0.0), GivenMesh(points, used, 1.0)):
        assert not proves_separation_of_parts(certificate, parts, (other, HERE))
    assert not proves_separation_of_parts(certificate, parts, (GivenMesh(points, used, 0.0), at(0.125, 0, 0)))
