"""`plannercheck bench`: tiny runs write their files, and stand-in bodies err only on their own side."""

import itertools
import json
import time
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from plannercheck.bodies import exact_reference as exact
from plannercheck.bodies.half_spaces import HalfSpace
from plannercheck.bodies.point_clouds import PointCloud
from plannercheck.bodies.polytope import Polytope
from plannercheck.cli.main import main
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench import bounding_volumes, complexity, truncated_hierarchies
from plannercheck.evaluation.bench import hausdorff as distances
from plannercheck.evaluation.bench.methods import methods
from plannercheck.evaluation.bench.solid_checkers import as_hull, substituted
from plannercheck.evaluation.bench.states import measure
from plannercheck.evaluation.bench.tables import ratio
from plannercheck.evaluation.bench.timing import Contender, least_seconds, measured
from plannercheck.evaluation.stress.body_families import family
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

STATES = 300
BODIES = ("round", "box", "needle", "prism", "cone", "lattice")


@pytest.fixture(scope="module")
def checker():
    """Hulls of every 8th vertex: most of the time goes to outer levels, vertex by vertex."""
    whole = Checker(Robot.load("ur5"), Scene.load("kitchen"))
    points = [polytope.vertices for polytope in whole.polytopes[: len(whole.robot.bodies)]]
    thinned = {k: as_hull(whole.bodies[k], Polytope(of[::8])) for k, of in enumerate(points) if len(of) > 100}
    return substituted(whole, thinned)


@pytest.fixture(params=BODIES)
def body(request):
    return Polytope(family(request.param, 120, 1))


def test_inner_levels_are_nested_within_the_body(body):
    levels = [body, *truncated_hierarchies.inner_levels(body)]
    assert len(levels) > 1
    assert len(levels[-1].vertices) >= 4
    for outer, inner in itertools.pairwise(levels):
        assert {tuple(v) for v in inner.vertices} < {tuple(v) for v in outer.vertices}


def test_outer_levels_contain_the_body(body):
    for outer in truncated_hierarchies.outer_levels(body):
        assert outer.dimension == 3
        assert all(exact.intersects(vertex[None], outer.vertices) for vertex in body.vertices[::8])


def test_levels_start_as_the_core_has_them():
    body = Polytope(family("round", 1000, 1))
    level = np.asarray(body.core.levels(False))
    assert level.max() > 2
    for k, inner in enumerate(truncated_hierarchies.inner_levels(body)[: level.max()], start=1):
        assert {tuple(v) for v in inner.vertices} == {tuple(v) for v in body.vertices[level >= k]}


def test_covers_contain_the_body(body):
    rng = np.random.default_rng(0)
    points = rng.dirichlet(np.full(len(body.vertices), 0.05), 2000) @ body.vertices  # anywhere in the body
    for shape, pose in (bounding_volumes.box_around(body), bounding_volumes.capsule_around(body)):
        local = (np.vstack([body.vertices, points]) - pose[:3, 3]) @ pose[:3, :3]
        if hasattr(shape, "size"):
            assert (np.abs(local) <= np.array(shape.size) / 2).all()
        else:
            local[:, 2] -= np.clip(local[:, 2], -shape.length / 2, shape.length / 2)
            assert (np.linalg.norm(local, axis=1) <= shape.radius).all()
    ball, pose = bounding_volumes.ball_around(body)
    assert (np.linalg.norm(np.vstack([body.vertices, points]) - pose[:3, 3], axis=1) <= ball.radius).all()


def test_distances_are_those_of_exact_arithmetic(body):
    points = np.random.default_rng(1).normal(size=(12, 3))
    for point in points:
        expected = exact.distance(point[None], body.vertices)
        assert distances.furthest(point[None], body) == pytest.approx(expected, abs=1e-12)
        ball = distances.furthest_of_balls(point[None], np.array([0.2]), body)
        if expected > 0:
            assert ball == pytest.approx(expected + 0.2)
        else:
            assert ball <= 0.2


@pytest.mark.usefixtures("hasty")
def test_methods_err_only_on_their_side(checker):
    q = checker.robot.random_configurations(200, 3)
    rows = measure(checker, list(methods(checker)), q, 1)
    kinds = {row.kind for row in rows}
    assert {"exact", "inner", "outer", "spheres", "capsules", "boxes", "coal", "fcl"} <= kinds
    for row in rows:
        assert row.microseconds > 0
        if row.kind in ("exact", "inner"):
            assert row.false_collision == 0, row.method
        if row.kind in ("exact", "outer", "spheres", "capsules", "boxes"):
            assert row.false_free == 0, row.method
        if row.kind in ("inner", "outer", "spheres", "capsules", "boxes"):
            assert 0 < row.error < 1, row.method
    assert rows[0].ratio == 1.0


def test_stand_ins_keep_links_and_pairs(checker):
    again = checker.with_bodies(checker.bodies)
    assert np.array_equal(again.pairs, checker.pairs)
    with pytest.raises(PlannercheckError, match="stand in for"):
        checker.with_bodies(checker.bodies[1:])
    padded = Checker(checker.robot, checker.scene, padding={checker.pair_names(0): 0.01})
    count = len(checker.bodies)
    assert len(padded.bodies) > count
    for bodies in (padded.bodies, padded.bodies[:count]):
        again = padded.with_bodies(bodies)
        assert again.bodies == padded.bodies
        assert np.array_equal(again.paddings, padded.paddings)
    with pytest.raises(PlannercheckError, match="get copies"):
        padded.with_bodies((*padded.bodies[:-1], replace(padded.bodies[-1], name="another")))


def test_stand_ins_are_out_of_reach_only_where_they_are(checker):
    found = next(m for m in methods(checker, ["capsules"]) if m.kind == "capsules").build()  # placed otherwise
    q = checker.robot.random_configurations(5000, 1)
    assert not found.colliding_pairs(q).any(axis=0)[found.unreachable].any()
    assert np.array_equal(found.check_states(q), ~found.colliding_pairs(q).any(axis=1))


def worked(order, name, least):
    """Takes so many seconds of this thread at least."""
    order.append(name)
    began = time.thread_time()
    while time.thread_time() - began < least:
        pass


def test_contenders_take_turns():
    order = []
    work = partial(worked, order)
    seconds = least_seconds({name: lambda name=name: work(name, 2e-3) for name in "abc"}, 3)
    assert "".join(order).startswith("abccbaabc")
    assert len(order) > 9  # so little work goes on until the clock has had time to change
    assert list(seconds) == ["a", "b", "c"]
    order.clear()
    assert 0 < least_seconds({"a": lambda: work("a", 0)}, 1)["a"] < 1e-3
    assert len(order) > 1  # too short for the clock


def test_the_null_control_is_the_same_code_in_other_turns():
    order = []
    work = partial(worked, order)
    contenders = {
        "a": Contender([partial(work, "a", 2e-3)], 4, [partial(work, "o", 1e-3)]),
        "b": Contender([partial(work, "b", 4e-3)]),
    }
    times = measured(contenders, 3)
    assert list(times.seconds) == ["a", "b"]
    assert times.seconds["a"] == pytest.approx(2.5e-4, rel=0.2)
    assert 1 <= times.noise("a", "b") < 1.2
    turns = itertools.count()
    slower = Contender([lambda: work("s", 1e-3 * (1 + next(turns) % 2))])
    assert measured({"slower": slower}, 20).noise("slower") > 1.9


@pytest.mark.parametrize(
    ("value", "noise", "told"),
    [
        (1.0, 1.0, "1"),
        (0.99, 1.02, "1"),
        (1.01, 1.02, "1"),
        (1.03, 1.02, "1.03"),
        (0.5, 1.02, "0.50"),
        (None, 2.0, "-"),
    ],
)
def test_no_ratio_is_told_that_is_noise(value, noise, told):
    assert ratio(value, noise) == told


def test_parts_take_turns_and_add_up():
    order = []
    work = partial(worked, order)
    parts = {"a": [partial(work, k, 2e-3) for k in "123"], "b": partial(work, "b", 2e-3)}
    seconds = least_seconds(parts, 2)
    assert "".join(order).startswith("1b2b3bb1b2b3")
    assert seconds["a"] >= 6e-3
    assert 2e-3 <= seconds["b"] < seconds["a"]


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))["rows"]


@pytest.mark.usefixtures("hasty")
def test_states_command(tmp_path, capsys):
    arguments = ["--robot", "panda", "--scene", "table", "none", "--states", "50", "--rounds", "1"]
    chosen = ["--methods", "boxes", "coal"]
    assert main(["bench", "states", *arguments, *chosen, "--output", str(tmp_path / "new")]) == 0
    rows = read(tmp_path / "new" / "states.json")
    assert {row["scene"] for row in rows} == {"table", "empty"}
    assert {row["kind"] for row in rows} - {"coal loop"} == {"exact", "boxes", "coal"}
    assert {row["which"] for row in rows} == {"random"}
    assert {path.name for path in (tmp_path / "new").iterdir()} == {"states.json", "states.png", "states.svg"}
    printed = capsys.readouterr().out
    assert "coal's tree / batch" in printed
    assert "bounding boxes" in printed


@pytest.mark.usefixtures("hasty")
def test_pairs_command(tmp_path, capsys):
    sizes = ["--vertices", "8,150,200", "--pairs", "4", "--rounds", "1"]
    assert main(["bench", "pairs", *sizes, "--output", str(tmp_path)]) == 0
    rows = read(tmp_path / "pairs.json")
    assert {(row["vertices"], row["gap"]) for row in rows} == {(n, g) for n in (8, 150, 200) for g in (0.5, 1e-4, -0.3)}
    assert all(row["wrong"] == 0 for row in rows if row["method"].startswith("plannercheck"))
    assert {path.name for path in tmp_path.iterdir()} == {"pairs.json", "pairs.png", "pairs.svg"}
    assert "from 150 to 200 vertices" in capsys.readouterr().out


@pytest.mark.usefixtures("hasty")
def test_switches_command(tmp_path, capsys):
    assert main(["bench", "switches", "--states", "130", "--rounds", "1", "--output", str(tmp_path)]) == 0
    rows = read(tmp_path / "switches.json")
    assert all(row["wrong"] == 0 for row in rows)
    assert {row["states"] for row in rows} == {"random", "along motions"}
    assert {"all on", "all on, again", "bounds", "boxes", "cached_plane"} <= {row["off"] for row in rows}
    assert all(row["noise"] >= 1 for row in rows)
    assert "null control: the same code twice" in capsys.readouterr().out


@pytest.mark.usefixtures("hasty")
def test_scale_command(tmp_path, capsys):
    assert (
        main(["bench", "scale", "--boxes", "100,150", "--states", "50", "--rounds", "1", "--output", str(tmp_path)])
        == 0
    )
    rows = read(tmp_path / "scale.json")
    assert [row["boxes"] for row in rows] == [100, 150]
    assert all(row["bytes_a_vertex"] > 0 for row in rows)
    assert "bytes a vertex" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["round", "prism", "cone", "doubling"])
def test_baselines_that_are_counted_are_right(name):
    rows = [row for row in complexity._in_space(name, 150, 8, 1) if row.method != "brute force"]
    assert {row.shared for row in rows} == {4}  # gaps alternate
    assert all(0 < row.visited_mean <= row.visited_worst for row in rows)


@pytest.mark.usefixtures("hasty")
def test_complexity_command(tmp_path, capsys):
    assert main(["bench", "complexity", "--most", "300", "--queries", "4", "--output", str(tmp_path)]) == 0
    rows = read(tmp_path / "complexity.json")
    assert {row["where"] for row in rows} == {"space", "plane", "trees, d = 2", "trees, d = 3"}
    assert {row["shared"] for row in rows} == {2}
    grown = {(row["family"], row["method"]): row["exponent"] for row in read(tmp_path / "complexity_growth.json")}
    assert grown["ellipse", "brute force"] == pytest.approx(1)
    assert {path.name for path in tmp_path.iterdir()} == {
        "complexity.json",
        "complexity.png",
        "complexity.svg",
        "complexity_growth.json",
    }
    assert "a doubling" in capsys.readouterr().out


def test_bad_input_is_one_line(capsys):
    assert main(["bench", "pairs", "--vertices", "3"]) == 2
    assert "at least 4" in capsys.readouterr().err
    assert main(["bench", "states", "--scene", "nowhere"]) == 2
    assert "nowhere" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["states", "motions"])
@pytest.mark.parametrize(
    ("shape", "kind"),
    [(HalfSpace([0, 0, 1], -1), "HalfSpace"), (PointCloud(np.array([[1, 0, 0.5]]), 0.1), "PointCloud")],
)
def test_scenes_in_which_a_stand_in_would_be_another_body_are_refused(tmp_path, capsys, command, shape, kind):
    scene = Scene("sensed")
    scene.add("thing", shape)
    scene.save(tmp_path / "scene.yaml")
    assert main(["bench", command, "--robot", "ur5", "--scene", str(tmp_path / "scene.yaml")]) == 2
    assert f"is a {kind}: `bench clouds`" in capsys.readouterr().err
