"""How far hulls are from meshes, and what their filling refuses."""

from __future__ import annotations

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.checking.hull_fidelity import largest_filling, refused_by_filling
from plannercheck.cli.inspect import meshes_of
from plannercheck.cli.main import main
from plannercheck.robots.description import description_of


def test_a_quarter_of_the_ur10s_states_is_refused_by_filling_alone(capsys):
    assert main(["inspect", "--robot", "ur10", "--fidelity", "--states", "1000"]) == 0
    shown = capsys.readouterr().out
    assert "271 of 1000 random configurations (27.1 %) are refused only because hulls fill hollows" in shown
    row = next(line.split() for line in shown.splitlines() if line.startswith("upper_arm_link_0") and "." in line)
    assert row[1] == "upper_arm_link"
    assert "furthest from the mesh, mm" in shown


def test_convex_meshes_refuse_nothing_by_filling():
    checker = pc.Checker(pc.Robot.load("panda"))
    q = checker.robot.random_configurations(500, 0)
    found = refused_by_filling(checker, meshes_of(checker, description_of("panda")), q)
    assert (found.states, found.refused) == (500, int((~checker.check_states(q)).sum()))
    assert found.only_filling <= 0.01 * found.states


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
def test_scenes_of_all_shapes(scene):
    checker = pc.Checker(pc.Robot.load("ur5"), pc.Scene.load(scene))
    found = refused_by_filling(
        checker, meshes_of(checker, description_of("ur5")), checker.robot.random_configurations(200, 0)
    )
    assert found.only_filling < found.refused
