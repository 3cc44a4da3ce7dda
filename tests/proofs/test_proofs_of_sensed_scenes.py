"""Proofs of motions before clouds, grids and height fields: few directions for each interval, whatever is seen."""

import itertools
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from poses import at

import plannercheck as pc
from plannercheck.bodies.part_sets import PartSet
from plannercheck.motions.proof_model import space_model
from plannercheck.proofs.data import PosedBody
from plannercheck.proofs.parts import part_count

START = np.array([0, -0.785, 0, -2.356, 0, 1.571, 0.785])
END = START + np.array([0.3, 0.1, 0, 0.1, 0, 0, 0])
RNG = np.random.default_rng(4)
POINTS = RNG.uniform(-0.2, 0.2, size=(300, 3))
RADII = RNG.uniform(0.001, 0.02, size=300)


@cache
def panda() -> pc.Robot:
    return pc.Robot.load("panda")


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


@pytest.mark.parametrize("shape", FAR)
def test_the_body_of_a_proof_has_the_numbers_of_the_shape(shape: PartSet) -> None:
    """Whatever the pose: the core's corners and radii, and the padding by itself."""
    checker = pc.Checker(panda(), scene_of(shape, at(0.9, -0.5, 0.5)), padding={"camera": 0.1 / 3})
    (body,) = [each for each in space_model(checker).bodies if each.label == "camera"]
    assert body.radius == body.padding == 0.1 / 3
    assert part_count(body) == shape.count
    core = shape.core
    of_core = [core.part(place)[:2] for place in range(core.places) if len(core.part(place)[0])]
    radii = np.broadcast_to(0.0 if body.radii is None else body.radii, shape.count)
    of_proof = zip(corners_of(body), radii, strict=True)
    assert sorted(map(key, of_core)) == sorted(map(key, of_proof))


def corners_of(body: PosedBody) -> list[np.ndarray]:
    """The corners of each part."""
    if body.parts == "balls":
        return list(body.vertices[:, None])
    if body.parts == "boxes":
        return [np.array(list(itertools.product(*both.T))) for both in body.vertices.reshape(-1, 2, 3)]
    flat = np.array([1, 1, 0])
    prisms = body.vertices.reshape(-1, 3, 3)
    return [np.concatenate([each, each * flat + [0, 0, body.base]]) for each in prisms]


def key(part: tuple[np.ndarray, float]) -> tuple:
    """The corners in an order of their own, and the radius."""
    return tuple(sorted(map(tuple, (part[0] + 0.0).tolist()))), float(part[1])


@pytest.mark.parametrize("make", [frame_of_points, hollow_grid, valley])
def test_a_motion_within_the_box_around_a_set_is_proved(make: type) -> None:
    checker = pc.Checker(panda(), scene_of(make()))
    assert checker.check_motion(START, END)
    proof = checker.explain_motion(START, END).proof
    assert proof is not None
    assert proof.verify().proved
    assert any(len(entry.direction) > 3 for entry in proof.entries)


def test_a_carried_cloud_is_proved_too() -> None:
    scene = pc.Scene("held")
    ring = np.array([[x, y, 0.12] for x in (-0.25, 0.25) for y in (-0.25, 0.25)] + [[0.25, 0, -0.2]])
    scene.attach("basket", "panda_hand", parts=pc.PointCloud(ring, 0.005))
    checker = pc.Checker(panda(), scene)
    assert checker.check_motion(START, END)
    (proof,) = checker.certify_motions(START[None], END[None])
    assert proof is not None
    assert proof.verify().proved


def test_an_empty_frame_does_not_stand_in_the_way() -> None:
    checker = pc.Checker(panda(), scene_of(pc.PointCloud(np.zeros((0, 3)), 0.01)))
    (proof,) = checker.certify_motions(START[None], END[None])
    assert proof is not None
    assert proof.verify().proved


def test_a_motion_in_a_shell_of_thousands_takes_few_entries() -> None:
    points = RNG.normal(size=(4000, 3))
    points *= 1.3 / np.linalg.norm(points, axis=1)[:, None]
    scene = pc.Scene("shell")
    scene.add("shell", pc.PointCloud(points + np.array([0, 0, 0.4]), 0.01))
    checker = pc.Checker(panda(), scene)
    assert checker.check_motion(START, END)
    (proof,) = checker.certify_motions(START[None], END[None])
    assert proof is not None
    assert proof.verify().proved
    assert sum(len(entry.direction) for entry in proof.entries) < 3 * 600
