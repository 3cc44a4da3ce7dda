"""Pieces by recipes, TIAGo's: made of the meshes that are there, equal to plainly made pieces, better than hulls."""

import importlib.util
import json
from itertools import combinations

import numpy as np
import pytest
from exact_points import integers

import plannercheck as pc
from plannercheck.bodies import convex_decomposition
from plannercheck.bodies.convex_decomposition import Decomposition, known_pieces, pieces_of
from plannercheck.bodies.piece_recipes import pieces_by_recipe, recipe_text
from plannercheck.bodies.pieces import mesh_hash
from plannercheck.bodies.shipped_pieces import RECIPE, file_name, piece_files, shipped_pieces
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.cli.main import main
from plannercheck.robots.description import description_of
from plannercheck.robots.geometry_choices import of_hulls, of_known_pieces, of_meshes
from plannercheck.robots.loading import collision_meshes

RECIPES = [file for file in piece_files() if file.suffix == RECIPE]
REAL_COACD = convex_decomposition._coacd
SPLIT = ("torso_lift_link_0", "arm_1_link_0")


@pytest.fixture(autouse=True)
def _no_coacd_and_no_cache(monkeypatch):
    monkeypatch.setenv("PLANNERCHECK_CACHE", "0")
    monkeypatch.setattr(convex_decomposition, "_coacd", None)


@pytest.fixture(scope="module")
def meshes():
    """TIAGo's, by name of the body."""
    found = collision_meshes(description_of("tiago"))
    return {name: TriangleMesh.of(mesh.points, mesh.triangles) for name, mesh in found.items()}


def recipe_of(body, mesh):
    name = file_name("tiago", body, mesh_hash(mesh), RECIPE)
    return json.loads(next(file for file in RECIPES if file.name == name).read_text())


def cross(a, b):
    """Of integers beyond 64 bits, which NumPy's own takes from version 2.3 on."""
    (x, y, z), (u, v, w) = a, b
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def extreme_points(points):
    """The vertices of the hull of points (n, 3), by integers: where planes with no point beyond meet in one point."""
    whole = integers(points)
    normals = {k: [] for k in range(len(whole))}
    for corners in combinations(range(len(whole)), 3):
        a, b, c = whole[list(corners)]
        normal = cross(b - a, c - a)
        sides = (whole - a) @ normal
        if any(normal) and (all(sides >= 0) or all(sides <= 0)):
            for k in np.flatnonzero(sides == 0):
                normals[k].append(normal)
    return {tuple(points[k]) for k, found in normals.items() if meet_in_a_point(found)}


def meet_in_a_point(normals):
    first = next(iter(normals), None)
    crosses = [cross(first, each) for each in normals]
    second = next((cross for cross in crosses if any(cross)), None)
    return second is not None and any(second @ each != 0 for each in normals)


@pytest.mark.parametrize("body", SPLIT)
def test_pieces_are_hulls_of_the_corners_of_their_triangles(meshes, body):
    mesh = meshes[body]
    numbers = recipe_of(body, mesh)["piece_of_triangle"]
    pieces = shipped_pieces(mesh)
    assert len(pieces.points) == len(set(numbers)) > 1
    for number, piece in enumerate(pieces.points):
        corners = {
            tuple(mesh.points[k]) for n, t in zip(numbers, mesh.triangles, strict=True) if n == number for k in t
        }
        assert set(map(tuple, piece)) == extreme_points(np.array(sorted(corners)))
        assert len(set(map(tuple, piece))) == len(piece)


def test_one_piece_is_the_hull(meshes):
    mesh = meshes["hand_thumb_abd_link_0"]
    pieces = shipped_pieces(mesh)
    (points,) = pieces.points
    np.testing.assert_array_equal(points, pc.Polytope(mesh.points).vertices)
    assert pieces.volume == pieces.hull_volume > mesh.volume == pieces.mesh_volume


def test_recipes_hold_no_geometry(meshes):
    """A number a triangle, all from 0 on; beside them the hash, and one length."""
    by_key = {mesh_hash(mesh).hex(): mesh for mesh in meshes.values()}
    for file in RECIPES:
        recipe = json.loads(file.read_text())
        assert set(recipe) == {"mesh", "protrusion", "piece_of_triangle"}
        numbers = recipe["piece_of_triangle"]
        assert len(numbers) == len(by_key[recipe["mesh"]].triangles)
        assert all(type(number) is int for number in numbers)
        assert set(numbers) == set(range(max(numbers) + 1))
        assert file.stem.endswith(recipe["mesh"][:16])


def closed_parts(mesh):
    """The triangles of each connected part whose edges all have their reverse."""
    label = np.arange(len(mesh.points))
    for _ in mesh.points:
        np.minimum.at(label, mesh.triangles, label[mesh.triangles].min(axis=1, keepdims=True))
    for part in np.unique(label[mesh.triangles[:, 0]]):
        rows = np.flatnonzero(label[mesh.triangles[:, 0]] == part)
        if TriangleMesh(mesh.points, mesh.triangles[rows]).is_watertight:
            yield rows


@pytest.mark.parametrize("body", SPLIT)
def test_pieces_hold_what_the_closed_parts_enclose(meshes, body):
    """The complement of at most three convex bodies is connected (by Alexander duality, since the nerve of three sets
    has no cycles of dimension two), so a closed surface in their union has winding number 0 about all points off it."""
    mesh = meshes[body]
    numbers, pieces = np.array(recipe_of(body, mesh)["piece_of_triangle"]), shipped_pieces(mesh)
    hulls = [pc.Polytope(points) for points in pieces.points]
    rng, point, inside = np.random.default_rng(6), pc.Polytope(np.zeros((1, 3))), 0
    parts = list(closed_parts(mesh))
    assert sum(map(len, parts)) >= len(mesh.triangles) - 4  # TIAGo's torso has two open rectangles
    for rows in parts:
        held_by = np.unique(numbers[rows])
        assert len(held_by) <= 3
        solid = pc.Solid(mesh.points, mesh.triangles[rows])
        around = pc.Polytope(solid.used[0])
        low, high = around.vertices.min(axis=0), around.vertices.max(axis=0)
        poses = np.tile(np.eye(4), (1000, 1, 1))
        poses[:, :3, 3] = rng.uniform(low, high, (1000, 3))
        is_in = np.asarray(pc.intersects(point, around.of_solid(solid), poses))
        held = np.any([pc.intersects(point, hulls[k], poses) for k in held_by], axis=0)
        assert not (is_in & ~held).any()
        inside += int(is_in.sum())
    assert inside > 100


def test_other_versions_of_a_mesh_have_no_recipe(meshes, monkeypatch):
    mesh = meshes["arm_1_link_0"]
    points = mesh.points.copy()
    points[7, 1] = np.nextafter(points[7, 1], 9)
    others = [
        TriangleMesh(points, mesh.triangles),
        TriangleMesh(mesh.points, mesh.triangles[1:]),
        TriangleMesh(mesh.points, mesh.triangles[::-1]),
        TriangleMesh(mesh.points, np.roll(mesh.triangles, 1, axis=1)),
    ]
    assert known_pieces(mesh, Decomposition()) is not None
    text = recipe_text(mesh, np.zeros(len(mesh.triangles), dtype=np.int64))
    assert len(pieces_by_recipe(text, mesh, mesh_hash(mesh)).points) == 1
    for other in others:
        assert known_pieces(other, Decomposition()) is None
        assert pieces_by_recipe(text, other, mesh_hash(other)) is None
    monkeypatch.setattr(convex_decomposition, "_coacd", REAL_COACD)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(pc.PlannercheckError, match=r"arm: no pieces of this mesh come with .*'plannercheck\[coacd\]'"):
        pieces_of(others[0], Decomposition(), "arm")


def test_what_hulls_alone_refuse_is_free_by_pieces():
    description = description_of("tiago")
    pieces, unknown = of_known_pieces(description)
    assert not unknown
    assert set(pieces.pieces) == set(SPLIT)
    assert set(pc.Robot.load("tiago", geometry="pieces").pieces) == set(SPLIT)
    hulls, meshes = of_hulls(description), of_meshes(description)
    q = hulls.random_configurations(10_000, 7)
    by_hulls, by_pieces, by_meshes = (pc.Checker(robot).check_states(q) for robot in (hulls, pieces, meshes))
    assert not (by_pieces & ~by_meshes).any()
    assert (by_meshes & ~by_hulls).sum() > 100
    assert (by_meshes & ~by_pieces).sum() < 0.05 * (by_meshes & ~by_hulls).sum()


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_commands_take_them_and_say_how_far_they_stick_out(capsys):
    assert main(["inspect", "--robot", "tiago", "--geometry", "pieces", "--states", "200", "--fidelity"]) == 0
    shown = capsys.readouterr().out
    held = "they hold all its triangles, and stick out of it by at most"
    assert f"torso_lift_link_0: 5 convex pieces; {held} 2.83 mm" in shown
    assert "arm_1_link_0: 3 convex pieces, " in shown
    assert "\npieces " in shown
    assert "keep their hulls: their pieces are not shipped" not in shown
