"""`plannercheck bench motions`, `setup` and `plans`: tiny runs write their files, and wrong options are refused."""

import json
import sys
import time
from dataclasses import replace

import numpy as np
import pytest
import yaml

from plannercheck.cli.main import main
from plannercheck.evaluation.bench import plans, set_up, states
from plannercheck.evaluation.bench.methods import methods
from plannercheck.evaluation.bench.motion_methods import METHODS, OURS, MotionMethod, Ready
from plannercheck.evaluation.bench.motion_sets import along_motions, random_sets, recorded_set
from plannercheck.evaluation.bench.motions import measure
from plannercheck.evaluation.bench.planners import Found, Settings
from plannercheck.evaluation.bench.plans import Tally
from plannercheck.evaluation.bench.problems import Task, tasks
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot

START, GOAL = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785], [0.5, -0.5, 0.0, -2.0, 0.0, 1.571, 0.785]
ARM = [f"panda_joint{k}" for k in range(1, 8)]
FINGERS = ["panda_finger_joint1", "panda_finger_joint2"]


@pytest.fixture
def problems(tmp_path):
    """Two problems of which the second starts in a box."""
    folder = tmp_path / "boxes"
    folder.mkdir()
    for number, place in ((1, [0.0, 0.9, 0.3]), (2, [0.3, 0.0, 0.6])):
        pose = {"position": place, "orientation": [0, 0, 0, 1]}
        box = {"id": "box", "primitives": [{"type": "box", "dimensions": [0.2, 0.2, 0.2]}], "primitive_poses": [pose]}
        scene = {"name": f"boxes{number}", "world": {"collision_objects": [box]}}
        goal = [{"joint_name": name, "position": value} for name, value in zip(ARM, GOAL, strict=True)]
        state = {"name": ARM + FINGERS, "position": [*START, 0.03, 0.03]}
        request = {
            "group_name": "panda_arm",
            "start_state": {"joint_state": state},
            "goal_constraints": [{"joint_constraints": goal}],
        }
        (folder / f"scene{number:04d}.yaml").write_text(yaml.safe_dump(scene))
        (folder / f"request{number:04d}.yaml").write_text(yaml.safe_dump(request))
    return folder


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))["rows"]


@pytest.mark.parametrize("length", [0.4, 1.0])
def test_random_motions_are_as_long_as_asked_and_sorted_by_verdict(checker, length):
    free, colliding = random_sets(checker, "bookshelf", length, 30, 1)
    for motions, verdict in ((free, True), (colliding, False)):
        (case,) = motions.cases
        assert len(case.starts) == 30
        assert np.allclose(np.linalg.norm(case.ends - case.starts, axis=1), length)
        assert (checker.check_motions(case.starts, case.ends) == verdict).all()
        assert checker.check_states(case.starts).all()
    assert (free.kind, colliding.kind) == (f"{length:g} rad, free", f"{length:g} rad, colliding")


def test_where_no_motion_collides_there_is_no_such_set():
    alone = Checker(Robot.load("ur5"))
    kinds = [motions.kind for motions in random_sets(alone, "empty", 1e-6, 5, 1)]
    assert kinds == ["1e-06 rad, free"]


def test_states_along_motions_are_on_straight_ways(checker):
    q = checker.robot.random_configurations(128, 0)
    along = along_motions(q)
    assert along.shape == q.shape
    assert np.array_equal(along[[0, 63, 64, 127]], q[[0, 127, 1, 126]])
    assert np.allclose(np.diff(along[:64], axis=0), (q[127] - q[0]) / 63)


def test_recorded_motions_are_what_rrt_connect_asks_for(checker, problems):
    task = next(tasks(problems, checker.robot))
    motions = recorded_set("boxes", [task, task], 0.2, 8)
    first, second = motions.cases
    assert len(first.starts) == len(second.starts) == 4
    assert np.array_equal(first.starts, second.starts)  # seeds are fixed
    lengths = np.linalg.norm(first.ends - first.starts, axis=1)
    assert (lengths <= 0.2 * (1 + 1e-9)).all()
    assert np.isclose(lengths, 0.2).any()
    ends = np.vstack([first.starts[:1], first.ends[:1]])
    assert np.isclose(ends[:, None], [task.start, task.goal]).all(axis=2).any()  # a tree grows from the start or goal
    assert [len(case.starts) for case in motions.first(4)] == [2, 2]


def test_problems_without_a_free_start_are_left_out(checker, problems):
    found = list(tasks(problems, checker.robot))
    assert len(found) == 1
    assert np.allclose(found[0].goal, GOAL)


@pytest.mark.usefixtures("hasty")
def test_methods_that_judge_motions_agree_where_nothing_is_near(checker):
    for motions in random_sets(checker, "bookshelf", 0.4, 12, 2):
        rows = measure(motions, 1)
        assert rows[0].method == OURS
        assert rows[0].ratio == 1
        for row in rows:
            assert row.microseconds > 0, row.method
            assert row.free == (1 if motions.kind.endswith("free") else 0)
            if row.method.startswith("plannercheck"):
                assert row.false_free == row.false_collision == 0
            elif not row.method.startswith("VAMP"):
                assert row.false_collision == 0, row.method  # sampled on the same hulls: only collisions are missed
        assert {row.method for row in rows} <= {method.name for method in METHODS}


def spin(seconds, verdicts):
    """Takes so long in this thread."""
    end = time.thread_time() + seconds
    while time.thread_time() < end:
        pass
    return verdicts


def test_what_a_call_takes_with_nothing_to_judge_is_taken_off(checker):
    free, _ = random_sets(checker, "bookshelf", 0.4, 4, 1)
    said = np.array([True, True, False, True])
    slow = Ready([lambda: spin(8e-3, said)], [lambda: spin(4e-3, said)], "how")
    rows = measure(free, 2, methods=[METHODS[0], MotionMethod("slow", lambda cases: slow)])
    assert rows[1].microseconds == pytest.approx(1000, rel=0.2)
    assert (rows[1].false_free, rows[1].false_collision, rows[1].note) == (0, 0.25, "how")


def test_the_same_is_taken_off_states(checker):
    exact = next(methods(checker, []))
    slow = replace(
        exact,
        name="slow",
        judge=lambda built, q: spin(8e-3, np.ones(len(q), bool)),
        overhead=lambda built, q: spin(4e-3, 0),
    )
    q = checker.robot.random_configurations(4, 1)
    rows = states.measure(checker, [exact, slow], q, 2)
    assert rows[1].microseconds == pytest.approx(4000, rel=0.2)  # each state is a part of its own


@pytest.mark.usefixtures("hasty")
def test_motions_command(problems, tmp_path, capsys):
    sizes = ["--motions", "6", "--rounds", "1", "--lengths", "0.3", "--ranges", "0.5"]
    assert main(["bench", "motions", *sizes, "--problems", str(problems), "--output", str(tmp_path / "out")]) == 0
    rows = read(tmp_path / "out" / "motions.json")
    kinds = {(row["where"], row["kind"]) for row in rows}
    assert kinds == {
        ("bookshelf", "0.3 rad, free"),
        ("bookshelf", "0.3 rad, colliding"),
        ("boxes", "RRTConnect, range 0.5 rad"),
    }
    record = json.loads((tmp_path / "out" / "motions.json").read_text("utf-8"))
    assert record["measurement"] == "motions"
    assert len(record["rows"]) == len(rows)
    printed = capsys.readouterr().out
    assert "6 motions, 100% free" in printed
    assert "plannercheck, OMPL validator" in printed


@pytest.mark.usefixtures("hasty")
def test_setup_command(tmp_path, capsys):
    options = ["--robot", "ur5", "--scene", "table", "--rounds", "1", "--output", str(tmp_path / "out")]
    assert main(["bench", "setup", *options]) == 0
    rows = read(tmp_path / "out" / "setup.json")
    assert {row["scene"] for row in rows} == {"table"}
    steps = {row["what"] for row in rows}
    assert {"Scene.load", "Checker(...)", "attach", "fresh process: Checker(...), nothing cached"} <= steps
    assert {f"with_scene, one {change}" for change in ("box more", "object moved", "object gone")} <= steps
    assert all(row["prepared"] in (None, 0) for row in rows)
    assert all(row["first_motion"] > 0 for row in rows if row["what"].startswith(("with_scene", "Checker")))
    assert "first verdict ms" in capsys.readouterr().out


@pytest.mark.usefixtures("hasty")
def test_setup_without_a_scene_has_nothing_to_load_or_move(monkeypatch):
    monkeypatch.setattr(set_up, "_fresh_rows", lambda *arguments: [])
    notes = []
    steps = [
        row.what for row in set_up.measure("ur5", None, 1, 0, notes.append) if row.what.startswith(("S", "C", "w"))
    ]
    assert steps == ["Checker(...)", "with_scene, one box more"]
    assert any("VAMP" in note for note in notes)


@pytest.mark.usefixtures("hasty")
def test_setup_of_very_many_boxes(tmp_path, monkeypatch):
    monkeypatch.setattr("plannercheck.evaluation.bench.set_up.measure", lambda *_: [])
    monkeypatch.setattr("plannercheck.cli.bench_planning._print_setup", lambda rows: None)
    assert main(["bench", "setup", "--boxes", "300", "--output", str(tmp_path)]) == 0
    rows = read(tmp_path / "boxes.json")
    assert [row["where"] for row in rows] == ["in a slab around the robot", "all within reach"]
    assert all(row["checker"] > 0 and row["checker_mb"] >= row["scene_mb"] for row in rows)


@pytest.mark.usefixtures("hasty")
def test_setup_from_files_to_a_path(problems, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("plannercheck.evaluation.bench.set_up.measure", lambda *arguments: [])
    monkeypatch.setattr("plannercheck.cli.bench_planning._print_setup", lambda rows: None)
    assert main(["bench", "setup", "--rounds", "1", "--problems", str(problems), "--output", str(tmp_path)]) == 0
    (row,) = read(tmp_path / "from_files.json")
    assert (row["set"], row["problems"], row["solved"]) == ("boxes", 2, 1)
    parts = sum(float(row[name]) for name in ("read", "checker", "plan"))
    assert parts == pytest.approx(row["total"], rel=1e-6)  # of one problem, medians add up
    assert "from files to a path" in capsys.readouterr().out


@pytest.mark.usefixtures("hasty")
def test_plans_command(problems, tmp_path, capsys):
    sets = ["--problems", str(problems), str(problems), "--seeds", "1", "2", "--rounds", "2"]
    assert main(["bench", "plans", *sets, "--output", str(tmp_path / "out")]) == 0
    rows = read(tmp_path / "out" / "plans.json")
    ours = [row for row in rows if row["planner"] == "plannercheck"]
    assert [(row["set"], row["solved"], row["refused"]) for row in ours] == [
        ("boxes", 2, 0),
        ("boxes", 2, 0),
        ("all", 4, 0),
    ]
    assert all(row["call_median_ms"] > row["median_ms"] > 0 for row in ours)
    assert "Pinocchio + coal" in capsys.readouterr().out


def test_a_plan_through_an_obstacle_counts_as_colliding_by_its_depth(checker):
    rng = np.random.default_rng(0)
    while True:
        start, end = checker.robot.random_configurations(2, rng)
        if checker.check_states([start, end]).all() and not checker.check_motion(start, end):
            break
    tally = Tally()
    tally.add(checker, Found(0.002, 0.003, np.array([start, end])))
    tally.add(checker, Found(0.001, None, None))
    row = tally.row("set", "someone")
    assert (row.tried, row.solved, row.refused, row.colliding) == (2, 1, 1, 1)
    assert row.median_ms == pytest.approx(2)
    assert row.call_median_ms == pytest.approx(3)
    assert 0 < row.deepest_mm < 1000


@pytest.mark.usefixtures("hasty")
def test_planners_that_cannot_be_had_are_left_out_once(checker, monkeypatch):
    monkeypatch.setitem(sys.modules, "vamp", None)
    q = checker.robot.random_configurations(100, 3)
    start, goal = q[checker.check_states(q)][:2]
    notes = []
    found = plans.measure([Task(checker, start, goal)] * 2, [1], Settings(0.5, 5.0), 1, notes.append)
    assert list(found) == ["plannercheck", "Pinocchio + coal"]
    assert len(notes) == 1
    assert "VAMP is left out" in notes[0]
    assert found["plannercheck"].refused == 0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["motions", "--lengths", "0"], "not a number above 0"),
        (["motions", "--motions", "0"], "not at least 1"),
        (["plans"], "--problems"),
        (["plans", "--problems", "nowhere", "--range", "nan"], "not a number above 0"),
        (["plans", "--problems", "nowhere", "--seeds", "0"], "not at least 1"),
        (["setup", "--group", "arm"], "unrecognized arguments"),
    ],
)
def test_wrong_options_are_refused(arguments, says, capsys):
    assert main(["bench", *arguments]) == 2
    assert says in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["motions", "--scene", "nowhere"], "nowhere"),
        (["setup", "--robot", "nobody"], "nobody"),
        (["plans", "--problems", "nowhere"], "nowhere"),
    ],
)
def test_what_is_not_there_is_one_line(arguments, says, capsys):
    assert main(["bench", *arguments]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert "Traceback" not in error
