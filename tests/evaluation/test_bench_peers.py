"""Other libraries in `plannercheck bench`: coal in a loop of its own, VAMP, MuJoCo; left out where they are missing."""

import sys
from pathlib import Path

import numpy as np
import pytest

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import Box, Sphere
from plannercheck.common.cache import cache_folder, read_cached, write_to_cache
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench import compiled_coal_loop, distances, pairs
from plannercheck.evaluation.bench.coal_loop import COLD_VARIANTS, VARIANTS, CoalLoop, PosedBodies
from plannercheck.evaluation.bench.methods import methods
from plannercheck.evaluation.bench.motion_sets import along_motions
from plannercheck.evaluation.bench.states import measure
from plannercheck.evaluation.bench.vamp_model import VampModel
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot

pytestmark = pytest.mark.usefixtures("hasty")
STATES = 400


@pytest.fixture(scope="module")
def loop(checker):
    try:
        compiled_coal_loop.library()
    except PlannercheckError as error:
        pytest.skip(str(error))
    return CoalLoop.of_checker(checker)


@pytest.mark.parametrize("along", [False, True])
def test_every_variant_of_coals_loop_has_the_exact_verdicts(checker, loop, along):
    q = checker.robot.random_configurations(STATES, 5)
    q = along_motions(q) if along else q
    truth = checker.check_states(q)
    assert truth.any()
    assert not truth.all()
    states = loop.states(q)
    for variant in (*VARIANTS, *COLD_VARIANTS):
        assert np.array_equal(loop.check(states, variant), truth), str(variant)


def test_a_group_of_states_is_free_if_all_of_them_are(checker, loop):
    q = checker.robot.random_configurations(STATES, 6)
    truth, ends = checker.check_states(q), np.array([1, 4, 50, STATES])
    expected = [part.all() for part in np.split(truth, ends[:-1])]
    assert loop.check(loop.states(q), VARIANTS[0], ends).tolist() == expected


def test_the_fastest_variant_is_one_of_those_asked_for(checker, loop):
    states = loop.states(checker.robot.random_configurations(20, 0))
    variant, seconds = loop.fastest(states, variants=VARIANTS[3:5])
    assert variant in VARIANTS[3:5]
    assert 0 < seconds < 1
    assert "guess" in str(variant)


def test_coals_shapes_are_those_of_the_bodies(loop):
    bodies = (Polytope(np.zeros((1, 3)), inflation_radius=1.0), Polytope(Box((2, 2, 2)).vertices_and_faces()[0]))
    pair = PosedBodies(bodies, (Sphere(1.0), Box((2, 2, 2))), np.array([True, False]), np.array([[1, 0]]), ("a", "b"))
    placed = np.tile(np.eye(4), (3, 1, 1, 1))
    placed[:, 0, :3, 3] = [[2.01, 0, 0], [1.99, 0, 0], [1.8, 1.8, 0]]  # the ball misses the box's edge, not its cube
    ball = CoalLoop(pair, np.tile(np.eye(4), (2, 1, 1)))
    assert ball.check(ball.posed(placed), VARIANTS[0]).tolist() == [True, False, True]


def test_coal_refuses_a_flat_hull(loop):
    flat = Polytope([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    pair = PosedBodies((flat, flat), (None, None), np.array([True, True]), np.array([[0, 1]]), ("plate", "plate"))
    with pytest.raises(PlannercheckError, match="no shape for plate"):
        CoalLoop(pair, np.tile(np.eye(4), (2, 1, 1)))


def test_without_a_compiler_coals_loop_is_left_out_with_a_note(checker, monkeypatch):
    compiled_coal_loop.library.cache_clear()
    monkeypatch.setenv("CXX", "no-such-compiler")
    notes = []
    chosen = [method for method in methods(checker, ["coal"]) if method.kind != "coal"]
    rows = measure(checker, chosen, checker.robot.random_configurations(20, 0), 1, notes.append)
    assert {row.kind for row in rows} == {"exact"}
    assert notes == ["coal at its best is left out: there is no C++ compiler: looked for no-such-compiler"]


def test_a_loop_that_does_not_compile_says_why(tmp_path, monkeypatch):
    compiled_coal_loop.library.cache_clear()
    broken = tmp_path / "coal_loop.cpp"
    broken.write_text("#error broken on purpose")
    monkeypatch.setattr(compiled_coal_loop, "_SOURCE", broken)
    monkeypatch.setenv("PLANNERCHECK_CACHE", str(tmp_path))
    with pytest.raises(PlannercheckError, match=r"does not compile: .*broken on purpose"):
        compiled_coal_loop.library()
    assert not list(tmp_path.glob("*.so"))


def test_a_library_that_others_may_have_written_is_not_loaded(loop, tmp_path, monkeypatch):
    shared, name = cache_folder(), Path(compiled_coal_loop.library()._name).name
    known = None if shared is None else read_cached(shared / name)
    monkeypatch.setenv("PLANNERCHECK_CACHE", str(tmp_path))
    if known is not None:  # compiling takes long
        write_to_cache(tmp_path / name, known)
    compiled_coal_loop.library.cache_clear()
    compiled_coal_loop.library()
    content = read_cached(tmp_path / name)
    assert content
    (tmp_path / name).write_bytes(b"no library")
    monkeypatch.setattr(compiled_coal_loop, "_compile", lambda command, file: file.write_bytes(content))
    compiled_coal_loop.library.cache_clear()
    assert compiled_coal_loop.library()
    assert read_cached(tmp_path / name) == content


def test_missing_libraries_are_left_out_with_notes(checker, monkeypatch):
    for name in ("fcl", "vamp", "mujoco"):
        monkeypatch.setitem(sys.modules, name, None)
    notes = []
    q = checker.robot.random_configurations(20, 0)
    rows = measure(checker, list(methods(checker, ["fcl", "vamp"])), q, 1, notes.append)
    assert {row.kind for row in rows} == {"exact"}
    assert [note.split(" is left out")[0] for note in notes] == ["python-fcl", "VAMP, in C++", "VAMP, from Python"]
    notes.clear()
    monkeypatch.setitem(sys.modules, "coal", None)
    compiled_coal_loop.library.cache_clear()
    found = {row.method for row in pairs.measure([8], 3, 1, notes.append, ellipsoids=True)}
    assert {name.partition(",")[0] for name in found} == {"plannercheck"}
    assert {pairs.FROM_PYTHON, pairs.IN_ONE_CALL} < found
    assert len(notes) == 4


def test_mujoco_decides_pairs_beyond_its_rounding():
    pytest.importorskip("mujoco")
    rows = [row for row in pairs.measure([40], 30, 1) if row.method.startswith("MuJoCo")]
    assert [row.wrong for row in rows] == [0, 0, 0]


@pytest.fixture(scope="module")
def vamp(checker):
    pytest.importorskip("vamp")
    return VampModel(checker)


def test_vamp_judges_the_same_robot_and_scene(checker, vamp):
    q = checker.robot.random_configurations(2000, 7)
    truth, found = checker.check_states(q), vamp.free(vamp.paths(q, q))
    assert np.array_equal(found, vamp.states_free(vamp.rows(q)))
    assert (found != truth).mean() < 0.05  # its balls are not the hulls, and it has boxes for other hulls
    assert (found & ~truth).any()
    assert vamp.copying(3) == [True] * 3


def test_vamp_plans_from_start_to_goal(checker, vamp):
    q = checker.robot.random_configurations(200, 8)
    start, goal = q[checker.check_states(q) & vamp.free(vamp.paths(q, q))][:2]
    found = vamp.search(start, goal, 2)()
    assert found.path is not None
    assert np.allclose(found.path[[0, -1]], [start, goal], atol=1e-6)
    assert found.seconds > 0


def test_vamp_has_only_its_own_robots():
    pytest.importorskip("vamp")
    with pytest.raises(PlannercheckError, match="VAMP has no robot 'talos'"):
        VampModel(Checker(Robot.load("talos")))


def test_other_libraries_measure_the_distances_of_the_same_pairs(checker):
    left_out: list[str] = []
    rows = distances.measure(checker, 60, 1, 0, left_out.append)
    assert {row.states for row in rows} == {"at random", "along motions"}
    assert {row.method for row in rows} >= {"distances", "Pinocchio, all pairs", "coal, near pairs"}
    assert all((row.error is not None) == row.method.startswith("coal") for row in rows)
    assert max(row.error or 0 for row in rows) < 1e-5
    assert all("drake" in reason for reason in left_out)
    q = distances.free_states(checker, 20, 1)
    found, table = distances.coal_distances(checker, q)(), checker.distances(q, distances.LIMIT)
    np.testing.assert_allclose(found, table.distance, atol=1e-5)
