"""Sets of parts in the hollows of solids: verdicts as by whole numbers, each proved, by every public call."""

from dataclasses import replace

import numpy as np
import pytest
from nested_calls import MODES, checker_of, faults_of_bodies, faults_of_checker, told
from nested_parts import SHAPES, UNIT, draw, surface
from poses import at

import plannercheck as pc
from plannercheck.bodies.part_certificates import PartSeparation, PosedParts, PosedTriangles, RangeSeparation
from plannercheck.bodies.solid_certificates import PosedSurface
from plannercheck.validation.certification import certify_verdicts

# Draws of every kind of set, some that meet, some apart, of which each call takes less than a second or so.
CALLED = [(49, "held"), (12, "one link"), (10, "held"), (3, "moving"), (14, "one link"), (18, "moving"), (5, "held")]


def tray() -> pc.Solid:
    """A floor and two walls, which no plane keeps away from what stands between them."""
    walls = np.zeros((5, 5, 5), dtype=bool)
    walls[:, :, 0] = walls[0, :, 2:] = walls[4, :, 2:] = True
    corners, triangles = surface(walls, np.array([8, 8, 8]))
    return pc.Solid(corners * UNIT, triangles)


def sets(size: float) -> dict[str, pc.PointCloud | pc.VoxelGrid | pc.Octree | pc.HeightField]:
    """One of each kind about the origin."""
    return {
        "cloud": pc.PointCloud([[0.0, 0, 0], [0, 0, size / 2]], size / 4),
        "grid": pc.VoxelGrid(np.ones((1, 2, 1), dtype=bool), size / 2, (0, 0, 0)),
        "octree": pc.Octree.from_cells([[0, 0, 0], [-1, 0, 0]], size / 2),
        "heights": pc.HeightField(np.array([[size, 0.0], [size / 2, 0.0]]), size / 2, -size / 4),
    }


@pytest.mark.parametrize("size", [1 / 64, 1 / 8, 1 / 4])
@pytest.mark.parametrize("kind", ["cloud", "grid", "octree", "heights"])
def test_a_set_between_walls_is_proved_apart(kind: str, size: float) -> None:
    """`noplane_min.py`: where a set is in a hollow, no plane separates its last part from the solid."""
    pose = at(20 * UNIT, 20 * UNIT, 22 * UNIT)
    for pair, poses in (
        ((tray(), sets(size)[kind]), (np.eye(4), pose)),
        ((sets(size)[kind], tray()), (pose, np.eye(4))),
    ):
        assert not pc.intersects(*pair, *poses)
        certificate = pc.certify(*pair, *poses)
        assert isinstance(certificate, PartSeparation)
        assert 0 < certificate.gap < 1
        assert certificate.verify()
        assert not replace(certificate, ranges=certificate.ranges[1:]).verify()
        assert not replace(certificate, gap=1.0).verify()


@pytest.mark.parametrize("padding", [0.0, 0.02])
@pytest.mark.parametrize("mode", MODES)
def test_a_cloud_in_the_hole_of_a_ring(tmp_path, mode: str, padding: float) -> None:
    """`set_in_hole.py`: states are explained, certified against the given shapes, and motions proved."""
    case = next(case for case in map(draw, range(0, 700, 7)) if case.kind == "cloud" and not case.meets)
    made = checker_of(case, mode, tmp_path)
    checker = pc.Checker(made.robot, made.scene, padding=padding)
    q = np.zeros((1, made.robot.nq))
    first = checker.first_colliding_pair(q)
    assert checker.explain(q[0]).valid == (first[0] < 0)
    assert certify_verdicts(checker, q, first).passed


@pytest.mark.parametrize("seed", range(2 * len(SHAPES)))
def test_verdicts_about_bodies_are_those_of_whole_numbers(seed: int) -> None:
    case = draw(seed)
    assert told(lambda: faults_of_bodies(case)) == []


@pytest.mark.parametrize(("seed", "mode"), CALLED)
def test_every_call_of_a_checker_agrees(tmp_path, seed: int, mode: str) -> None:
    case = draw(seed)
    assert told(lambda: faults_of_checker(case, mode, tmp_path)) == []


def test_planners_and_commands_agree(tmp_path, capsys) -> None:
    assert told(lambda: faults_of_checker(draw(7), "held", tmp_path, thorough=True)) == []
    assert capsys.readouterr().out


def test_a_set_within_a_solid_collides() -> None:
    corners, triangles = surface(np.ones((2, 2, 2), dtype=bool), np.array([16, 16, 16]))
    cube, pose = pc.Solid(corners * UNIT, triangles), np.eye(4)
    pose[:3, 3] = 0.25
    for kind, shape in sets(1 / 16).items():
        certificate = pc.certify(cube, shape, None, pose)
        assert isinstance(certificate, pc.Enclosure | pc.SharedPoint), kind
        assert certificate.verify()


def test_planes_all_around_do_not_prove_a_part_within_a_solid_apart() -> None:
    """They keep it away from each triangle; the solid winds about it all the same, unless it is open."""
    corners, triangles = surface(np.ones((1, 1, 1), dtype=bool), np.array([64, 64, 64]))
    point = np.full((1, 3), 0.5)
    parts = PosedParts(point, np.array([0, 1]), np.zeros(1), np.eye(4))

    def separation(kept: np.ndarray) -> PartSeparation:
        planes = [pc.certify(pc.Polytope(point), pc.Polytope(corners[each] * UNIT)) for each in kept]
        ranges = tuple(RangeSeparation((0, 1), (k, k + 1), plane) for k, plane in enumerate(planes))
        around = PosedSurface(corners * UNIT, kept.astype(np.int32), np.eye(4))
        return PartSeparation(min(plane.gap for plane in planes), ranges, (parts, PosedTriangles(around, 0.0)))

    assert not separation(triangles).verify()
    assert separation(triangles[1:]).verify()


def test_motions_in_a_hollow_end_at_its_walls_and_take_few_grids(tmp_path) -> None:
    """No plane keeps the set from all of the solid; how far it is from it and how far it goes do."""
    checker = checker_of(draw(6), "moving", tmp_path)
    assert checker.check_motion([0.0, 0.0], [1 / 32, 0.0])
    assert checker.motion_certifier.statistics()["grids"] < 10
    for way in np.linspace(-1, 1, 41):
        samples = np.linspace([0.0, 0.0], [way, 0.0], 400)
        if checker.check_motion(samples[0], samples[-1]):
            assert checker.check_states(samples).all()
    assert not checker.check_motion([-1.0, 0.0], [1.0, 0.0])
