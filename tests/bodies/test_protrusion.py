"""How far pieces stick out of a mesh, beside what geometry and points inside the pieces say."""

import numpy as np
import pytest
import solid_meshes

import plannercheck as pc
from plannercheck.bodies import protrusion as module
from plannercheck.bodies.protrusion import filled, protrusion
from plannercheck.bodies.solids import Solid
from plannercheck.bodies.triangle_meshes import TriangleMesh


def furthest_of_samples(points, solid, count, seed):
    """How far random points of a hull are from a solid at most, by the distance of two bodies."""
    rng = np.random.default_rng(seed)
    drawn = rng.dirichlet(np.full(len(points), 0.3), count) @ points
    body = pc.Polytope(solid.used[0]).of_solid(solid)
    return max(pc.distance(pc.Polytope(each[None]), body).distance for each in drawn)


@pytest.fixture
def coarse(monkeypatch):
    """Boxes of a fiftieth of the mesh's size are fine enough."""
    monkeypatch.setattr(module, "_FINE", 0.02)


def test_the_hull_of_an_angle_sticks_out_into_its_notch():
    """Of the notch's points under the slanted side, (5/3, 5/3) is furthest from both arms."""
    mesh = TriangleMesh.of(*solid_meshes.angle())
    assert 2 / 3 <= protrusion([mesh.points], mesh) <= 1.21 * 2 / 3


def test_what_a_mesh_encloses_is_no_protrusion(coarse):
    mesh = TriangleMesh.of(*solid_meshes.box())
    assert protrusion([mesh.points], mesh) < 0.041
    assert protrusion([0.5 * mesh.points], mesh) < 0.041


def test_boxes_whose_middles_are_inside_may_stick_out():
    """The outermost of the first boxes about the piece have their middles at 0.925, inside the mesh."""
    mesh = TriangleMesh.of(*solid_meshes.box())
    longer = np.where(mesh.points == [[1, 9, 9]], 1.2, mesh.points)
    assert 0.2 <= protrusion([longer], mesh) <= 0.3


def test_pieces_within_hollows_stick_out():
    """A shell one thick about a cavity of 1.2, whose middle is 0.6 from it, and inside the hull of the shell."""
    mesh = TriangleMesh.of(*solid_meshes.both(solid_meshes.box(), solid_meshes.box(0.6), flipped=True))
    assert 0.6 <= protrusion([mesh.points], mesh) <= 0.73


@pytest.mark.parametrize("seed", range(4))
def test_no_point_of_a_piece_is_further_out(seed):
    rng = np.random.default_rng(seed)
    mesh = TriangleMesh.of(*solid_meshes.ring(9, 5, 0.3))
    pieces = [rng.normal(size=(rng.integers(4, 12), 3)) * rng.uniform(0.1, 1.5) for _ in range(3)]
    bound = protrusion(pieces, mesh)
    known = max(furthest_of_samples(points, filled(mesh), 300, seed) for points in pieces)
    assert known <= bound
    known = max(known, *(furthest_of_samples(np.array(points), filled(mesh), 300, seed + 9) for points in pieces))
    assert bound < 2 * known + 0.05


def test_the_bound_holds_if_boxes_are_given_up_early(monkeypatch):
    mesh = TriangleMesh.of(*solid_meshes.angle())
    monkeypatch.setattr(module, "_MOST_BOXES", 3)
    assert 2 / 3 <= protrusion([mesh.points], mesh) < 2


@pytest.mark.parametrize("name", sorted(solid_meshes.meshes()))
def test_filled_meshes_are_closed(name):
    points, triangles = solid_meshes.meshes()[name]
    mesh = TriangleMesh.of(points, triangles)
    solid = filled(mesh)
    assert solid.is_closed
    if mesh.is_watertight:
        assert solid.digest == Solid(mesh.points, mesh.triangles).digest
    rng = np.random.default_rng(5)
    torn = TriangleMesh.of(points, triangles[rng.random(len(triangles)) < 0.7])
    if len(torn.triangles):
        assert filled(torn).is_closed


def test_an_open_mesh_is_bounded_by_what_closes_it(coarse):
    points, triangles = solid_meshes.box()
    mesh = TriangleMesh.of(points, triangles[2:])
    assert not mesh.is_watertight
    assert protrusion([points], mesh) < 0.041


def test_flat_pieces_have_a_bound():
    mesh = TriangleMesh.of(*solid_meshes.box())
    plate = np.array([[0, 0, 0], [3, 0, 0], [0, 3, 0], [3, 3, 0]]) * 1.0
    furthest = np.hypot(2, 2)
    assert furthest <= protrusion([plate], mesh) <= 1.3 * furthest
