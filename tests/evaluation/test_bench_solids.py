"""`plannercheck bench` on solids: coal's meshes have our verdicts where no body is inside another."""

import json

import numpy as np
import pytest
from poses import at

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import Box, Sphere
from plannercheck.bodies.solids import Solid
from plannercheck.cli.main import main
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench import compiled_coal_loop, link_pairs, other_libraries, solid_sizes
from plannercheck.evaluation.bench.coal_loop import COLD_VARIANTS, VARIANTS, CoalLoop, PosedBodies, fastest_loop
from plannercheck.evaluation.bench.methods import methods
from plannercheck.evaluation.bench.solid_checkers import has_solids, is_nested, nested_pairs, with_hulls
from plannercheck.evaluation.stress_solids.solid_families import torus
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot

pytestmark = pytest.mark.usefixtures("hasty")
STATES = 300
COUNTS = ("inside", "refused_apart", "missed", "near")


@pytest.fixture(scope="module")
def checker():
    return Checker(Robot.load("ur5", geometry="solid"))


@pytest.fixture(scope="module")
def compiled():
    try:
        return compiled_coal_loop.library()
    except PlannercheckError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def surfaces(checker):
    """States, and which pairs collide in each otherwise than by one body inside the other."""
    q = checker.robot.random_configurations(STATES, 1)
    colliding = checker.colliding_pairs(q)
    for state in np.flatnonzero(colliding.any(axis=1)).tolist():
        pairs, nested = nested_pairs(checker, q[state])
        colliding[state, pairs[nested]] = False
    assert colliding.any()
    return q, colliding


@pytest.mark.parametrize("boxes", ["OBB", "OBBRSS"])
def test_coals_loop_over_meshes_has_our_verdicts_of_surfaces(compiled, checker, surfaces, boxes):
    q, colliding = surfaces
    loop = CoalLoop.of_checker(checker, boxes)
    assert loop.has_meshes
    states = loop.states(q)
    for variant in (each for each in (*VARIANTS, *COLD_VARIANTS) if each.guess != 2):
        assert np.array_equal(loop.check(states, variant), ~colliding.any(axis=1))
        assert np.array_equal(loop.check_pairs(states, variant), colliding)


@pytest.mark.parametrize("with_tree", [False, True])
def test_pinocchio_with_meshes_has_our_verdicts_of_surfaces(checker, surfaces, with_tree):
    q, colliding = surfaces
    judge = other_libraries.coal(checker, with_tree=with_tree)
    assert np.array_equal(judge(q[:60]), ~colliding[:60].any(axis=1))


def test_a_pair_with_what_stands_still_is_judged_in_every_state(compiled):
    ring = ring_of(400)
    pair = PosedBodies((ring, ring), (None, None), np.array([True, False]), np.array([[0, 1]]), ("a", "b"))
    poses = np.tile(np.eye(4), (3, 1, 1, 1))
    poses[:, 0, 2, 3] = [0.0, 0.1, 5.0]
    loop = CoalLoop(pair, np.tile(np.eye(4), (2, 1, 1)))
    expected = [[True], [bool(ring_meets(ring, 0.1))], [False]]
    assert loop.check_pairs(loop.posed(poses), VARIANTS[0]).tolist() == expected


def ring_of(triangles):
    surface = torus(triangles, np.random.default_rng(0))
    return Polytope(Solid(surface.points, surface.triangles))


def ring_meets(ring, height):
    pose = at(0, 0, height)
    return link_pairs.in_batch((ring, ring), (pose[None], np.eye(4)[None]), "oracle")()[0]


def test_one_body_inside_another_is_free_for_coal_and_counted_apart(compiled):
    ring = ring_of(400)
    grain = Polytope(Box((1e-3, 1e-3, 1e-3)))
    middle = np.eye(4)
    middle[0, 3] = 0.3  # within the tube
    assert is_nested(grain, ring, middle, np.eye(4))
    assert is_nested(ring, grain, np.eye(4), middle)
    assert not is_nested(grain, ring, np.eye(4), np.eye(4))
    pair = PosedBodies((grain, ring), (None, None), np.array([True, True]), np.array([[0, 1]]), ("grain", "ring"))
    loop = CoalLoop(pair, np.tile(np.eye(4), (2, 1, 1)))
    assert loop.check(loop.posed(np.stack([middle, np.eye(4)])[None]), VARIANTS[0]).tolist() == [True]


def test_coal_is_not_given_triangles_without_area(compiled):
    """Named case: a cap of tiago's hand. coal takes a sphere near the box of such a triangle as in contact with it."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 1]])
    solid = Polytope(Solid(points, [[0, 1, 3], [0, 1, 4], [0, 1, 2]], open="triangles"))
    beside = at(1.5, -0.09, -0.09)
    ball = Sphere(0.1)
    pair = PosedBodies((Polytope(ball), solid), (ball, None), np.array([True, True]), np.array([[0, 1]]), ("a", "b"))
    loop = CoalLoop(pair, np.tile(np.eye(4), (2, 1, 1)))
    assert loop.check(loop.posed(np.stack([beside, np.eye(4)])[None]), VARIANTS[0]).tolist() == [True]


def test_the_fastest_loop_is_sought_among_the_kinds_of_boxes(compiled, checker):
    made = []

    def make(boxes):
        made.append(boxes)
        return CoalLoop.of_checker(checker, boxes)

    q = checker.robot.random_configurations(3, 0)
    loop, variant = fastest_loop(make, lambda loop, first: loop.states(q[:first]), VARIANTS[:6])
    assert sorted(made) == ["OBB", "OBBRSS"]
    assert loop.mesh_boxes in made
    assert variant in VARIANTS[:4]  # those after that start from boxes


def test_hulls_in_place_of_solids_refuse_more(checker):
    hulls = with_hulls(checker)
    q = checker.robot.random_configurations(STATES, 2)
    assert has_solids(checker)
    assert not has_solids(checker, open_only=True)
    assert not has_solids(hulls)
    valid, by_hulls = checker.check_states(q), hulls.check_states(q)
    assert not (by_hulls & ~valid).any()
    assert (valid & ~by_hulls).any()


def test_stand_ins_for_hulls_are_refused_with_solids(checker):
    with pytest.raises(PlannercheckError, match="spheres, fcl: these are compared on hulls, solids with coal"):
        list(methods(checker, ["spheres", "coal", "fcl"]))


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))["rows"]


def test_states_command_with_solids(tmp_path, capsys):
    arguments = ["--robot", "ur5", "--scene", "none", "--geometry", "solid", "--states", "40", "--rounds", "1"]
    assert main(["bench", "states", *arguments, "--output", str(tmp_path)]) == 0
    rows = read(tmp_path / "states.json")
    assert {row["kind"] for row in rows} - {"coal loop"} == {"exact", "hulls", "coal"}
    for row in rows:
        assert row["false_free"] == row["false_free_inside"], row["method"]
        assert row["kind"] == "hulls" or row["false_collision"] == 0, row["method"]
    printed = capsys.readouterr().out
    assert "the faster way of Pinocchio + coal / batch" in printed
    assert "coal's meshes are surfaces" in printed


def test_link_pairs_command(compiled, tmp_path, capsys):
    arguments = ["--robot", "ur5", "--states", "60", "--most", "5", "--rounds", "1"]
    assert main(["bench", "link-pairs", *arguments, "--output", str(tmp_path)]) == 0
    rows = read(tmp_path / "solid_link_pairs.json")
    assert {row["meet"] for row in rows} == {True, False}
    assert all(row["false_free"] == row["inside"] and row["false_collision"] == 0 for row in rows)
    assert "coal's time over ours, by pair" in capsys.readouterr().out


def test_the_mean_over_queries_needs_every_row():
    row = link_pairs.LinkPairRow("r", "a", "b", (4, 4), True, 3, 2.0, 5.0, 1.0, 0, 0, 0, "")
    other = link_pairs.LinkPairRow("r", "a", "c", (4, 4), True, 1, 6.0, None, 1.0, 0, 0, 0, "")
    assert link_pairs.mean([row, other], lambda each: each.microseconds) == 3.0
    assert link_pairs.mean([row, other], lambda each: each.coal) is None
    assert link_pairs.mean([], lambda each: each.coal) is None


def test_triangles_command(compiled, tmp_path, capsys):
    arguments = ["--triangles", "100,200", "--pairs", "4", "--rounds", "1"]
    assert main(["bench", "triangles", *arguments, "--output", str(tmp_path)]) == 0
    rows = read(tmp_path / "solid_triangles.json")
    assert {row["shape"] for row in rows} == set(solid_sizes.SHAPES)
    assert all(row["wrong"] == 0 for row in rows)
    assert any(row["meet"] < 1 for row in rows if row["gap"] > 0)
    assert all(row["meet"] > 0 for row in rows if row["gap"] < 0)
    assert "time grows" in capsys.readouterr().out


def test_fidelity_command(compiled, tmp_path, capsys):
    assert main(["bench", "fidelity", "--robot", "ur5", "baxter", "--states", "60", "--output", str(tmp_path)]) == 0
    rows = read(tmp_path / "solid_fidelity.json")
    assert [row["robot"] for row in rows] == ["ur5", "baxter", "baxter", "baxter"]  # whose torso is open
    for row in rows:
        assert row["valid"] == pytest.approx(row["valid_hulls"] + row["filling"])
        assert [row["refused_apart"], row["missed"]] == [0, 0]
    assert "only hulls refuse" in capsys.readouterr().out


def test_solid_costs_command(tmp_path, capsys):
    arguments = ["--robot", "panda", "ur5", "--states", "60", "--rounds", "1"]
    assert main(["bench", "solid-costs", *arguments, "--output", str(tmp_path)]) == 0
    rows = read(tmp_path / "solid_costs.json")
    assert [row["robot"] for row in rows] == ["panda"] * 4 + ["ur5"] * 4
    assert len({row["work"] for row in rows}) == 4
    for row in rows:
        assert row["ratio"] == pytest.approx(row["of_solids"] / row["of_hulls"])
        assert (row["concave"] > 0) == (row["robot"] == "ur5")
    assert all(row["dented"] > 4 and 1e-3 < row["deepest"] < 0.02 for row in rows[:4])
    assert "by hulls" in capsys.readouterr().out


def test_bad_sizes_are_one_line(capsys):
    assert main(["bench", "triangles", "--triangles", "3"]) == 2
    assert "at least 100" in capsys.readouterr().err
