"""How far hulls are from meshes, and what their filling refuses."""

from dataclasses import replace

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies import convex_decomposition
from plannercheck.bodies.hull_excess import largest_filling
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.cli.main import main
from plannercheck.robots import geometry_choices
from plannercheck.robots.description import description_of


def test_a_quarter_of_the_ur10s_states_is_refused_by_filling_alone(capsys):
    assert main(["inspect", "--robot", "ur10", "--fidelity", "--states", "1000"]) == 0
    shown = capsys.readouterr().out
    by_hulls = next(line.split() for line in shown.splitlines() if line.startswith("hulls"))
    assert by_hulls[-4:] == ["27.1", "%", "0.0", "%"]
    assert "--geometry solid takes meshes as they are" in shown
    row = next(line.split() for line in shown.splitlines() if line.startswith("upper_arm_link_0") and "." in line)
    assert row[1] == "upper_arm_link"
    assert "furthest from the mesh, mm" in shown


def test_without_hulls_there_is_no_table_of_them(capsys):
    assert main(["inspect", "--robot", "ur5", "--geometry", "solid", "--fidelity", "--states", "50"]) == 0
    shown = capsys.readouterr().out
    assert "no body is the hull of a mesh" in shown
    assert "furthest from the mesh, mm" not in shown


def test_convex_meshes_refuse_nothing_by_filling():
    description = description_of("panda")
    hulls, meshes = (pc.Checker(of(description)) for of in (geometry_choices.of_hulls, geometry_choices.of_meshes))
    q = hulls.robot.random_configurations(500, 0)
    by_hulls, by_meshes = hulls.check_states(q), meshes.check_states(q)
    assert not (by_hulls & ~by_meshes).any()
    assert (by_meshes & ~by_hulls).mean() <= 0.01


def test_the_mouth_of_a_cup_is_as_far_from_it_as_it_is_deep():
    """A tetrahedron with its top pushed in to the height 0.1: the hull's top facet is 0.9 above it."""
    points = np.array([[1, 0, 1], [-0.5, 0.9, 1], [-0.5, -0.9, 1], [0, 0, 0], [0, 0, 0.1]])
    triangles = np.array([[0, 4, 1], [1, 4, 2], [2, 4, 0], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    found = largest_filling(pc.Polytope(points), TriangleMesh(points, triangles))
    assert 0.35 < found < 0.9


def test_planar_robots_have_no_meshes(capsys):
    assert main(["inspect", "--robot", "forklift", "--fidelity"]) == 2
    assert "planar robots" in capsys.readouterr().err


@pytest.mark.parametrize("scene", ["kitchen", "bookshelf"])
def test_scenes_of_all_shapes(scene, capsys):
    assert main(["inspect", "--robot", "ur5", "--scene", scene, "--fidelity", "--states", "200"]) == 0
    rows, _ = rows_of_geometries(capsys.readouterr().out)
    assert float(rows["hulls"][4]) < 100 - float(rows["hulls"][2])
    assert rows["meshes"][4] == "0.0"


def test_geometries_are_those_that_are_asked_for_whatever_a_yaml_says():
    description = replace(description_of("ur10"), geometry="solid", decomposition=pc.Decomposition(threshold=0.5))
    assert not any(isinstance(body.shape, pc.Solid) for body in geometry_choices.of_hulls(description).bodies)
    meshes = [body for body in geometry_choices.of_meshes(description).bodies if isinstance(body.shape, pc.Solid)]
    assert [body.link for body in meshes if body.shape.kind == "capped"] == ["forearm_link"]
    alone = [body for body in geometry_choices.of_triangles(description).bodies if isinstance(body.shape, pc.Solid)]
    assert [body.link for body in alone if body.shape.kind == "open"] == ["forearm_link"]
    assert len(meshes) == 7
    pieces, unknown = geometry_choices.of_known_pieces(description)
    assert set(pieces.pieces) == {"upper_arm_link_0", "forearm_link_0"}
    assert unknown == ()


def rows_of_geometries(shown):
    lines = shown.splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("links are"))
    rows = [line.split() for line in lines[first + 1 :] if line.startswith(("hulls", "pieces", "meshes", "triangles"))]
    return {row[0]: row for row in rows}, "\n".join(lines[first + 1 + len(rows) :])


@pytest.mark.filterwarnings("ignore:.*open meshes")
def test_states_by_hulls_pieces_and_meshes(capsys, monkeypatch):
    monkeypatch.setattr(convex_decomposition, "_coacd", None)  # it would fail
    assert main(["inspect", "--robot", "ur10", "--fidelity", "--states", "1000"]) == 0
    rows, notes = rows_of_geometries(capsys.readouterr().out)
    robots = {
        "hulls": pc.Robot.load("ur10"),
        "pieces": pc.Robot.load("ur10", geometry="pieces"),
        "meshes": pc.Robot.load("ur10", geometry="solid"),
        "triangles": pc.Robot.load("ur10", geometry="triangles"),
    }
    q = robots["hulls"].random_configurations(1000, 0)
    valid = {name: pc.Checker(robot).check_states(q) for name, robot in robots.items()}
    for name, by in valid.items():
        expected = tuple(f"{x.mean():.1%}" for x in (by, valid["meshes"] & ~by, by & ~valid["meshes"]))
        assert tuple(word + "%" for word in rows[name][2::2]) == expected
        assert int(rows[name][1]) == len(pc.Checker(robots[name]).pairs)
    assert "forearm_link_0" in notes  # its mesh is open
    assert "keep their hulls" not in notes


def test_links_without_known_pieces_keep_their_hulls(capsys, monkeypatch):
    monkeypatch.setattr(geometry_choices, "known_pieces", lambda mesh, options: None)
    assert main(["inspect", "--robot", "ur10", "--fidelity", "--states", "50"]) == 0
    shown = capsys.readouterr().out
    assert "\npieces" not in shown
    assert "as pieces, upper_arm_link, forearm_link keep their hulls" in shown
