"""Convex pieces that come with plannercheck: found by the meshes' content, without CoACD; they hold the meshes."""

import importlib.util
import os
import warnings

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies import convex_decomposition
from plannercheck.bodies.convex_decomposition import Decomposition, known_pieces, pieces_of
from plannercheck.bodies.exact_coverage import uncovered
from plannercheck.bodies.pieces import Pieces, mesh_hash, packed, unpacked
from plannercheck.bodies.protrusion import filled, protrusion
from plannercheck.bodies.shipped_pieces import PIECES, RECIPE, file_name, piece_files, shipped_pieces
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.robots.decomposed_links import is_concave
from plannercheck.robots.description import description_of
from plannercheck.robots.loading import collision_meshes

ROBOTS = ("ur3", "ur5", "ur10", "pr2", "kinova", "baxter", "tiago")
FILES = piece_files()
# So many of a link are looked at; robots/pieces/make_pieces.py looks at all of them.
TRIANGLES = int(os.environ.get("PLANNERCHECK_TRIANGLES", "30"))


@pytest.fixture(autouse=True)
def _no_coacd_and_no_cache(monkeypatch):
    monkeypatch.setenv("PLANNERCHECK_CACHE", "0")
    monkeypatch.setattr(convex_decomposition, "_coacd", None)


def concave_meshes(name):
    """By name of the body, equal ones once."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        meshes = collision_meshes(description_of(name))
    found = {}
    for body, each in meshes.items():
        mesh = TriangleMesh.of(each.points, each.triangles)
        if is_concave(mesh):
            found.setdefault(mesh_hash(mesh), (body, mesh))
    return dict(found.values())


def suffix_of(name):
    return RECIPE if name == "tiago" else PIECES


@pytest.mark.parametrize("name", ROBOTS)
def test_robots_of_pieces_need_no_coacd(name, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        robot, coarse = pc.Robot.load(name, geometry="pieces"), pc.Robot.load(name)
        q = coarse.random_configurations(2000, 3)
        by_pieces, by_hulls = pc.Checker(robot).check_states(q), pc.Checker(coarse).check_states(q)
    assert robot.pieces
    assert all(pieces.protrusion < 0.1 for pieces in robot.pieces.values())
    assert by_pieces.mean() >= by_hulls.mean()


@pytest.mark.parametrize("name", ROBOTS)
def test_every_triangle_is_in_the_union_exactly(name):
    for body, mesh in concave_meshes(name).items():
        pieces = shipped_pieces(mesh)
        assert pieces is not None, body
        drawn = np.random.default_rng(5).permutation(mesh.triangles)[:TRIANGLES]
        assert not len(uncovered(mesh.points[drawn], pieces.points, 8)), body
        assert file_name(name, body, mesh_hash(mesh), suffix_of(name)) in [file.name for file in FILES]


def test_the_protrusion_in_files_is_that_of_their_pieces():
    for name, mesh in concave_meshes("pr2").items():
        if name in ("base_link_0", "l_upper_arm_roll_link_0"):
            pieces = shipped_pieces(mesh)
            again = protrusion(pieces.points, mesh)
            assert pieces.protrusion == pytest.approx(again, rel=1e-6)


@pytest.mark.parametrize("name", ROBOTS)
def test_no_point_of_a_piece_is_further_out_than_its_file_says(name):
    """Random points of each piece, one query each."""
    rng = np.random.default_rng(4)
    for body, mesh in concave_meshes(name).items():
        pieces, solid = shipped_pieces(mesh), filled(mesh)
        around = pc.Polytope(solid.used[0]).of_solid(solid)
        for points in pieces.points:
            drawn = rng.dirichlet(np.full(len(points), 0.2), 4) @ points
            furthest = max(pc.distance(pc.Polytope(each[None]), around).distance for each in drawn)
            assert furthest <= pieces.protrusion, body


def test_other_options_and_other_meshes_are_not_shipped():
    mesh = next(iter(concave_meshes("ur5").values()))
    assert known_pieces(mesh, Decomposition()) is not None
    assert known_pieces(mesh, Decomposition(("base_link",), time_limit=7.0)) is not None
    for options in (Decomposition(threshold=0.1), Decomposition(slack=0.01), Decomposition(most_pieces=3)):
        assert known_pieces(mesh, options) is None
    moved = TriangleMesh(np.nextafter(mesh.points, 9), mesh.triangles)
    assert known_pieces(moved, Decomposition()) is None
    with pytest.raises(TypeError):  # where CoACD would be called
        pieces_of(moved, Decomposition())


def test_files_are_small_and_say_their_mesh():
    assert sum(file.stat().st_size for file in FILES) < 2_000_000
    cube = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    pieces = Pieces((cube, cube[:4]), 0.1, 0.2, 0.3, None, 1.0, 2.0)
    data = packed(pieces, b"a mesh")
    assert unpacked(data, b"another") is None
    again = unpacked(data, b"a mesh")
    for one, other in zip(pieces.points, again.points, strict=True):
        np.testing.assert_array_equal(one, other)
    assert vars(again) | {"points": ()} == vars(pieces) | {"points": ()}


def test_all_files_are_in_the_table_of_origins():
    text = (FILES[0].parent / "README.md").read_text(encoding="utf-8")
    rows = [line for line in text.splitlines() if line.startswith("| ") and " mm |" in line]
    assert len(rows) == len(FILES)
    assert {row.split("|")[1].strip() for row in rows} == {file.name.partition("_")[0] for file in FILES}
