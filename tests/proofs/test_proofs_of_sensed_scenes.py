"""Proofs of motions before clouds, grids and height fields: of what holds the whole set, or none at all."""

from __future__ import annotations

import time
from fractions import Fraction
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies.part_sets import PartSet
from plannercheck.motions.proof_model import space_model
from plannercheck.proofs.data import PosedBody

START = np.array([0, -0.785, 0, -2.356, 0, 1.571, 0.785])
END = START + np.array([0.3, 0.1, 0, 0.1, 0, 0, 0])
RNG = np.random.default_rng(4)
POINTS = RNG.uniform(-0.2, 0.2, size=(300, 3))
RADII = RNG.uniform(0.001, 0.02, size=300)


@cache
def panda() -> pc.Robot:
    return pc.Robot.load("panda")


def at(*place: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = place
    return pose


def frame_of_points(count: int = 4) -> PartSet:
    """Points at the corners of a room: the robot moves in the box around them."""
    corners = np.array([[0.9, -0.9, 0.3], [0.9, 0.9, 1.4], [-0.9, 0.9, 1.4], [-0.9, -0.9, 1.4]])
    return pc.PointCloud(corners[:count], 0.02)


def hollow_grid() -> PartSet:
    full = np.zeros((20, 20, 16), dtype=bool)
    full[[0, -1]] = full[:, [0, -1]] = full[:, :, [-1]] = True
    return pc.VoxelGrid(full, 0.1, (-1, -1, 0.2))


def valley() -> PartSet:
    heights = np.full((20, 20), -0.5)
    heights[0] = 1.5
    return pc.HeightField(heights, 0.1, -1, (-1, -1))


def scene_of(shape: PartSet, pose: np.ndarray | None = None) -> pc.Scene:
    scene = pc.Scene("sensed")
    scene.add("camera", shape, pose)
    return scene


FAR = [
    pc.PointCloud(POINTS, RADII),
    pc.PointCloud(POINTS[:1], 0.1),
    pc.PointCloud(POINTS[:2], 0.1),
    pc.VoxelGrid(RNG.random((5, 5, 5)) < 0.3, 0.08, (-0.2, -0.2, -0.2)),
    pc.Octree.from_cells(np.unique(RNG.integers(-2, 2, size=(30, 3)), axis=0), 0.1),
    pc.HeightField(RNG.uniform(0, 0.2, size=(5, 5)), 0.1, -0.1, (-0.2, -0.2)),
]


@pytest.mark.parametrize("shape", FAR)
@pytest.mark.parametrize("padding", [0.0, 0.01])
def test_motions_beside_a_set_are_proved(tmp_path: Path, shape: PartSet, padding: float) -> None:
    checker = pc.Checker(panda(), scene_of(shape, at(0.9, -0.5, 0.5)), padding={"camera": padding})
    (proof,) = checker.certify_motions(START[None], END[None])
    assert proof is not None
    assert proof.verify().proved
    if padding == 0:
        checker.scene.save(tmp_path / "sensed.yaml")
        assert proof.verify(robot="panda", scene=str(tmp_path / "sensed.yaml")).proved
        other = pc.Scene("sensed")
        other.add("camera", pc.PointCloud(POINTS, 0.05), at(0.9, -0.5, 0.5))
        other.save(tmp_path / "other.yaml")
        assert not proof.verify(robot="panda", scene=str(tmp_path / "other.yaml")).proved


def parts_of(shape: PartSet) -> tuple[np.ndarray, np.ndarray]:
    """Points of all parts in their frame, and how far the set reaches around each."""
    if isinstance(shape, pc.PointCloud):
        return shape.points, shape.radii
    core = shape.core
    points = np.concatenate([core.part(place)[0] for place in range(core.places) if len(core.part(place)[0])])
    return points, np.zeros(len(points))


@pytest.mark.parametrize("shape", FAR)
def test_the_body_of_a_proof_holds_the_whole_set(shape: PartSet) -> None:
    """At any affine pose: points are in the hull of the vertices, and radii are no larger than the body's."""
    checker = pc.Checker(panda(), scene_of(shape, at(0.9, -0.5, 0.5)), padding={"camera": 0.1 / 3})
    (body,) = [each for each in space_model(checker).bodies if each.label == "camera"]
    points, radii = parts_of(shape)
    low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
    assert is_box(body)
    assert ((low <= points) & (points <= high)).all()
    assert all(Fraction(float(radius)) + Fraction(0.1 / 3) <= Fraction(body.radius) for radius in radii)


def is_box(body: PosedBody) -> bool:
    """Whether the vertices are all corners of the box around them."""
    corners = {tuple(row) for row in body.vertices.tolist()}
    edges = [sorted({corner[axis] for corner in corners}) for axis in range(3)]
    return corners == {(x, y, z) for x in edges[0] for y in edges[1] for z in edges[2]}


@pytest.mark.parametrize("make", [frame_of_points, hollow_grid, valley])
def test_a_motion_within_the_box_around_a_set_has_no_proof(make: type) -> None:
    checker = pc.Checker(panda(), scene_of(make()))
    assert checker.check_motion(START, END)
    verdict = checker.explain_motion(START, END)
    assert verdict.free
    for prove in (lambda: verdict.proof, lambda: checker.certify_motions(START[None], END[None])):
        with pytest.raises(pc.PlannercheckError, match=r"of panda_.* and camera: proofs know .* by the box"):
            prove()


def test_a_carried_cloud_is_named_too() -> None:
    scene = pc.Scene("held")
    ring = np.array([[x, y, 0.12] for x in (-0.25, 0.25) for y in (-0.25, 0.25)] + [[0.25, 0, -0.2]])
    scene.attach("basket", "panda_hand", parts=pc.PointCloud(ring, 0.005))
    checker = pc.Checker(panda(), scene)
    assert checker.check_motion(START, END)
    with pytest.raises(pc.PlannercheckError, match=r"no proof .*\bbasket\b.* proofs know a set of parts by the box"):
        checker.certify_motions(START[None], END[None])


def test_an_empty_frame_does_not_stand_in_the_way() -> None:
    checker = pc.Checker(panda(), scene_of(pc.PointCloud(np.zeros((0, 3)), 0.01)))
    (proof,) = checker.certify_motions(START[None], END[None])
    assert proof is not None
    assert proof.verify().proved


def test_a_motion_in_a_shell_of_thousands_is_refused_soon() -> None:
    """Pieces of planes between a link and the box around it were sought for minutes."""
    points = RNG.normal(size=(4000, 3))
    points *= 1.3 / np.linalg.norm(points, axis=1)[:, None]
    scene = pc.Scene("shell")
    scene.add("shell", pc.PointCloud(points + np.array([0, 0, 0.4]), 0.01))
    checker = pc.Checker(panda(), scene)
    assert checker.check_motion(START, END)
    began = time.process_time()
    with pytest.raises(pc.PlannercheckError, match="shell: proofs know a set of parts by the box around it"):
        checker.certify_motions(START[None], END[None])
    assert time.process_time() - began < 20
