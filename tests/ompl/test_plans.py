"""Plans keep their numbers in files."""

import json

import numpy as np
import pytest

from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.errors import PlannercheckError
from plannercheck.ompl.plans import Plan


@pytest.fixture
def plan() -> Plan:
    path = np.random.default_rng(0).normal(size=(5, 3))
    return Plan(True, path, 1.0 / 3.0, 0.1, 0.2, "RRTConnect", "", ("a", "b", "c"))


def same(p: Plan, q: Plan) -> bool:
    names = ("solved", "length", "time", "simplification_time", "planner", "reason", "joint_names")
    return np.array_equal(p.path, q.path) and all(getattr(p, name) == getattr(q, name) for name in names)


def test_json_gives_the_same_numbers_back(tmp_path, plan):
    plan.save(tmp_path / "plan.json")
    assert same(Plan.load(tmp_path / "plan.json"), plan)


def test_an_unsolved_plan_has_a_path_of_no_rows(tmp_path):
    plan = Plan(False, np.empty((0, 2)), 0.0, 1.0, 0.0, "RRT", "no way", ("a", "b"))
    plan.save(tmp_path / "plan.json")
    assert same(Plan.load(tmp_path / "plan.json"), plan)


def test_npy_and_csv_hold_the_path(tmp_path, plan):
    plan.save(tmp_path / "plan.npy")
    plan.save(tmp_path / "plan.csv")
    assert np.array_equal(np.load(tmp_path / "plan.npy"), plan.path)
    assert (tmp_path / "plan.csv").read_text().splitlines()[0] == "a,b,c"
    assert np.array_equal(np.loadtxt(tmp_path / "plan.csv", delimiter=",", skiprows=1), plan.path)


def test_bad_files(tmp_path, plan):
    with pytest.raises(PlannercheckError, match=r"unknown format of a plan '\.txt'.*\.json, \.npy, \.csv"):
        plan.save(tmp_path / "plan.txt")
    with pytest.raises(PlannercheckError, match=r"no/plan\.json' can't be written"):
        plan.save(tmp_path / "no" / "plan.json")
    (tmp_path / "bad.json").write_text('{"solved": true}')
    for message in ("bad.json' is no plan", "missing.json': can't be read"):
        with pytest.raises(PlannercheckError, match=message):
            Plan.load(tmp_path / message.partition("'")[0])


@pytest.mark.parametrize(
    ("key", "value", "wanted"),
    [
        ("solved", "no", "bool, not 'no'"),
        ("solved", 1, "bool, not 1"),
        ("time", True, "float or int, not True"),
        ("simplification_time", None, "float or int, not None"),
        ("goal", False, "int or null, not False"),
        ("planner", 3, "str, not 3"),
        ("joint_names", "abc", "a list of texts, not 'abc'"),
        ("joint_names", ["a", "b", 3], r"a list of texts, not \['a', 'b', 3\]"),
    ],
)
def test_words_of_a_plan_have_their_types(tmp_path, plan, key, value, wanted):
    plan.save(tmp_path / "plan.json")
    values = json.loads((tmp_path / "plan.json").read_text())
    (tmp_path / "plan.json").write_text(json.dumps(values | {key: value}))
    with pytest.raises(PlannercheckError, match=f"plan.json' is no plan in JSON: '{key}' must be {wanted}"):
        Plan.load(tmp_path / "plan.json")


def test_a_failed_write_leaves_the_old_file(tmp_path):
    file = tmp_path / "out.txt"
    file.write_text("old")

    def fail(aside):
        aside.write_text("half")
        raise RuntimeError("stop")

    with pytest.raises(RuntimeError):
        write_atomically(file, fail)
    assert file.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["out.txt"]


def test_plans_of_joints_of_several_numbers_are_kept(tmp_path):
    """A free body has one name for seven columns: in a table the columns stay without names."""
    rows = np.array([[0.1, 0, 0, 0, 0, 0, 1], [0.2, 0, 0, 0, 0, 1, 0]])
    plan = Plan(True, rows, 1.0, 0.1, 0.2, "RRTConnect", "", ("root_joint",))
    plan.save(tmp_path / "plan.json")
    assert Plan.load(tmp_path / "plan.json").path.tolist() == rows.tolist()
    plan.save(tmp_path / "plan.csv")
    assert np.loadtxt(tmp_path / "plan.csv", delimiter=",").tolist() == rows.tolist()
    unsolved = Plan(False, np.empty((0, 7)), 0.0, 1.0, 0.0, "RRT", "no way", ("root_joint",))
    unsolved.save(tmp_path / "none.json")
    assert Plan.load(tmp_path / "none.json").reason == "no way"
