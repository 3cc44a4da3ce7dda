"""Convex pieces hold every triangle of the mesh, and robots made of them collide less than their hulls, not more."""

import importlib.util

import numpy as np
import pytest
import solid_meshes

import plannercheck as pc
from plannercheck.bodies import convex_decomposition as decomposition
from plannercheck.bodies import protrusion
from plannercheck.bodies.convex_decomposition import Decomposition, pieces_of
from plannercheck.bodies.exact_coverage import uncovered
from plannercheck.bodies.piece_repair import DEEPEST, repaired
from plannercheck.bodies.pieces import hull_volume
from plannercheck.bodies.triangle_meshes import TriangleMesh

REAL_COACD = decomposition._coacd

needs_coacd = pytest.mark.skipif(importlib.util.find_spec("coacd") is None, reason="CoACD is not installed")


@pytest.fixture(autouse=True)
def _coarse_bounds(monkeypatch):
    """How far pieces stick out is bounded coarsely, which is faster."""
    monkeypatch.setattr(protrusion, "_FINE", 0.05)


def box(low, high):
    """Corners (8, 3) and outward triangles (12, 3)."""
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def angle():
    """The L, as a mesh."""
    return TriangleMesh.of(*solid_meshes.angle())


def surface_points(mesh, n, seed):
    """Random points of the triangles (n, 3)."""
    rng = np.random.default_rng(seed)
    weights = rng.dirichlet([1, 1, 1], n)
    return np.einsum("ni,nij->nj", weights, mesh.points[mesh.triangles[rng.integers(len(mesh.triangles), size=n)]])


def inside(point, points):
    """Whether a point is within 1e-12 of a hull, by the exact pair test with a tiny ball."""
    return pc.intersects(pc.Polytope(points), pc.Polytope(point[None], inflation_radius=1e-12))


def holds(pieces, mesh, n=400):
    return all(any(inside(p, points) for points in pieces) for p in surface_points(mesh, n, 7))


def test_meshes_know_whether_they_are_closed_and_what_they_hold():
    mesh = angle()
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(4.0, abs=1e-12)
    assert hull_volume(mesh.points) == pytest.approx(5.0, abs=1e-12)  # the notch of 2 by 1 is cut slantwise
    assert TriangleMesh(mesh.points, mesh.triangles[:-1]).volume is None
    mirrored = TriangleMesh.of(mesh.points * [-1, 1, 1], mesh.triangles)
    assert mirrored.signed_volume == pytest.approx(-4.0, abs=1e-12)
    assert mirrored.outward.signed_volume == pytest.approx(4.0, abs=1e-12)
    corners, triangles = box((0, 0, 0), (1, 2, 3))
    soup = TriangleMesh.of(corners[triangles].reshape(-1, 3), np.arange(36).reshape(-1, 3))  # as in an STL
    assert len(soup.points) == 8
    assert soup.volume == pytest.approx(6.0)


@pytest.mark.parametrize("gap", [0.0, 1e-6, 1e-3])
def test_pieces_that_leave_something_out_are_repaired(gap):
    mesh = angle()
    pieces = [box((0, gap, 0), (1, 2, 1))[0], box((1 + gap, 0, gap), (3, 1, 1))[0]]
    found = repaired(mesh, pieces, 0.01)
    assert found.excess == pytest.approx(gap, abs=1e-9)
    assert found.excess <= found.growth <= 0.011
    assert holds(found.points, mesh)
    assert gap == 0 or not holds(pieces, mesh)
    assert not len(uncovered(mesh.points[mesh.triangles], found.points, DEEPEST))
    assert 4.0 - 1e-9 < found.volume < 4.2
    assert found.mesh_volume == pytest.approx(4.0)


def test_corners_that_round_outwards_are_added_again():
    """Turned, so that the middles of edges are no doubles: pieces hold the rounded ones, but not yet the edges."""
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    mesh = TriangleMesh.of(angle().points @ turn.T, angle().triangles)
    found = repaired(mesh, [box((0, 0, 0), (1, 2, 1))[0] @ turn.T, box((1, 0, 0), (3, 1, 1))[0] @ turn.T], 0.01)
    assert not len(uncovered(mesh.points[mesh.triangles], found.points, DEEPEST))
    assert found.growth < 0.011


def test_a_large_slack_gives_whole_triangles_to_pieces():
    found = repaired(angle(), [box((0, 0, 0), (1, 2, 1))[0], box((1, 0, 0), (3, 1, 1))[0]], 10.0)
    assert found.growth > 0.1
    assert holds(found.points, angle())


@pytest.mark.filterwarnings("ignore:SRDF")
def test_coacd_that_takes_too_long_leaves_the_hull(gripper):
    """A process that never gets to an end."""
    options = Decomposition(("base",), slack=0.01, time_limit=0.01)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(decomposition, "_coacd", REAL_COACD)
        patched.setattr(importlib.util, "find_spec", lambda name: True)
        with pytest.warns(
            RuntimeWarning, match=r"body 'base_0' keeps its hull: CoACD did not split its 20 triangles.*0.01 s"
        ):
            robot = pc.Robot.from_urdf(
                gripper / "gripper.urdf", gripper / "gripper.srdf", gripper, decomposition=options
            )
    assert [body.name for body in robot.bodies] == ["base_0", "finger_0"]
    assert not robot.pieces


@needs_coacd
def test_coacd_decomposes_and_the_result_is_cached(tmp_path, monkeypatch):
    monkeypatch.setenv("PLANNERCHECK_CACHE", str(tmp_path))
    mesh = angle()
    first = pieces_of(mesh, Decomposition(slack=0.01))
    assert first is not None
    assert len(first.points) == 2
    assert holds(first.points, mesh)
    assert first.volume < 4.2
    monkeypatch.setattr(decomposition, "_coacd", None)  # it would fail
    second = pieces_of(mesh, Decomposition(slack=0.01))
    assert second is not None
    for one, other in zip(first.points, second.points, strict=True):
        np.testing.assert_array_equal(one, other)
    assert vars(first) | {"points": ()} == vars(second) | {"points": ()}


OBJECT = """<robot name="gripper">
  <link name="base"><collision><geometry><mesh filename="angle.obj"/></geometry></collision></link>
  <link name="finger"><collision><geometry><box size="0.4 0.4 0.4"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="finger"/><axis xyz="0 1 0"/>
    <origin xyz="2 1.3 0.5" rpy="0 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""


@pytest.fixture
def gripper(tmp_path, monkeypatch):
    """The folder of a robot whose finger moves in the notch of its base, which the base's hull fills."""
    monkeypatch.setenv("PLANNERCHECK_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(decomposition, "_coacd", lambda mesh, options, name, remesh: [box(*ends)[0] for ends in HALVES])
    mesh = angle()
    lines = [f"v {x} {y} {z}" for x, y, z in mesh.points.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in mesh.triangles.tolist()]
    (tmp_path / "angle.obj").write_text("\n".join(lines))
    (tmp_path / "gripper.urdf").write_text(OBJECT)
    (tmp_path / "gripper.srdf").write_text(
        '<robot name="gripper"><disable_collisions link1="base" link2="base" reason="x"/></robot>'
    )
    return tmp_path


HALVES = ((0, 0, 0), (1, 2, 1)), ((1, 0, 0), (3, 1, 1))


@pytest.mark.filterwarnings("ignore:SRDF")
def test_robots_of_pieces_move_in_their_notches(gripper):
    folder = gripper
    (folder / "gripper.yaml").write_text(
        "{urdf: gripper.urdf, srdf: gripper.srdf, package_dirs: [.], "
        "convex_decomposition: {links: [base], slack: 0.01}}"
    )
    plain = pc.Robot.from_urdf(folder / "gripper.urdf", folder / "gripper.srdf", folder)
    fine = pc.Robot.load(folder / "gripper.yaml")
    same = pc.Robot.from_urdf(
        folder / "gripper.urdf", folder / "gripper.srdf", folder, decomposition=Decomposition(("base",), slack=0.01)
    )
    assert (
        [b.name for b in fine.bodies]
        == [b.name for b in same.bodies]
        == ["base_0/piece 0", "base_0/piece 1", "finger_0"]
    )
    assert fine.self_pairs.tolist() == [[0, 2], [1, 2]]
    heights = np.linspace(-1, 1, 81)[:, None]
    truth = heights[:, 0] > -0.1  # the finger's lower side is above the base's arm
    near = np.abs(heights[:, 0] + 0.1) < 0.011
    valid = pc.Checker(fine).check_states(heights)
    np.testing.assert_array_equal(valid[~near], truth[~near])
    assert not (valid & ~truth).any()
    assert (~pc.Checker(plain).check_states(heights) & truth).sum() > 10
    assert fine.pieces["base_0"].mesh_volume == pytest.approx(4.0)


def test_mistakes_are_named(gripper, monkeypatch):
    urdf = gripper / "gripper.urdf"
    with pytest.raises(pc.PlannercheckError, match="unknown link to decompose 'bass'"):
        pc.Robot.from_urdf(urdf, package_dirs=gripper, decomposition=Decomposition(("bass",)))
    with pytest.raises(pc.PlannercheckError, match="threshold of a decomposition"):
        Decomposition(threshold=2.0)
    with pytest.raises(pc.PlannercheckError, match="slack of a decomposition"):
        Decomposition(slack=0.0)
    with pytest.raises(pc.PlannercheckError, match="time_limit of a decomposition must be a positive time in s"):
        Decomposition(time_limit=0.0)
    (gripper / "bad.yaml").write_text("urdf: gripper.urdf\nconvex_decomposition: {link: base}\n")
    with pytest.raises(pc.PlannercheckError, match=r"convex_decomposition.*link"):
        pc.Robot.load(gripper / "bad.yaml")
    monkeypatch.undo()
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(pc.PlannercheckError, match=r"pip install 'plannercheck\[coacd\]'"):
        pieces_of(TriangleMesh(angle().points + 1e-3, angle().triangles), Decomposition(seed=99))
