"""Robots that no joint moves (fixed grippers, sensors, furniture) have one configuration, of no numbers."""

import h5py
import numpy as np
import pytest

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.validation.formats.chunks import read_chunks

TABLE = """<robot name="table">
<link name="legs"><collision><geometry><box size="1 1 0.1"/></geometry></collision></link>
<link name="top"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="weld" type="fixed"><parent link="legs"/><child link="top"/><origin xyz="0 0 0.5"/></joint></robot>"""

NOTHING = np.zeros(0)


@pytest.fixture
def urdf(tmp_path):
    path = tmp_path / "table.urdf"
    path.write_text(TABLE)
    return path


@pytest.fixture
def checker(urdf):
    scene = pc.Scene()
    scene.add_box("crate", (1, 1, 1), [[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    return pc.Checker(pc.Robot.from_urdf(urdf), scene)


def test_the_one_configuration_is_judged(checker):
    assert checker.is_valid(NOTHING)
    assert checker.check_states(np.zeros((3, 0))).tolist() == [True] * 3
    assert checker.explain([]).valid
    assert checker.check_motion([], [])
    assert checker.check_motions(np.zeros((2, 0)), np.zeros((2, 0)), resolution=0.01).all()
    assert checker.explain_motion([], []).free
    assert checker.robot.link_poses(NOTHING)[1, 2, 3] == 0.5


def test_what_it_touches_is_named(urdf):
    scene = pc.Scene()
    scene.add_sphere("ball", 0.2, [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.6], [0, 0, 0, 1]])
    with pytest.warns(RuntimeWarning, match="'top' of table, which is fixed to the world, touches obstacle 'ball'"):
        assert pc.Checker(pc.Robot.from_urdf(urdf), scene).is_valid([])


def test_numbers_are_too_many(checker):
    with pytest.raises(pc.PlannercheckError, match=r"\(0,\).*no joint moves: a configuration is an empty array"):
        checker.check_states([[1.0]])
    with pytest.raises(pc.PlannercheckError, match="no joint that moves: there is nothing to plan"):
        pc.ompl.setup(checker)


def write_sets(folder):
    np.save(folder / "q.npy", np.zeros((3, 0)))
    np.save(folder / "one.npy", NOTHING)
    np.savez(folder / "q.npz", q=np.zeros((3, 0)))
    with h5py.File(folder / "q.h5", "w") as file:
        file["q"] = np.zeros((3, 0))
    (folder / "q.csv").write_text("\n")


def test_sets_hold_configurations_of_no_numbers(tmp_path):
    write_sets(tmp_path)
    for name, rows in (("q.npy", 3), ("one.npy", 1), ("q.npz", 3), ("q.h5", 3), ("q.csv", 1)):
        assert [chunk.rows.shape for chunk in read_chunks(tmp_path / name, (), 0)] == [(rows, 0)], name


def test_commands_work(urdf, tmp_path, capsys):
    write_sets(tmp_path)
    robot, page, rows = ("--robot", str(urdf)), str(tmp_path / "page.html"), str(tmp_path / "q.npy")
    assert main(["inspect", *robot, "--states", "5"]) == 0
    assert "5 random configurations within the limits: 5 valid" in capsys.readouterr().out
    for what in ([], [rows], ["--path", rows]):
        assert main(["view", *robot, "--html", page, *what]) == 0, what
    assert main(["validate", *robot, rows, "--pairs", "all", "--output", str(tmp_path / "out.csv"), "--explain"]) == 0
    assert main(["validate", *robot, "--path", rows]) == 0
    assert (tmp_path / "out.csv").read_text().count("true") == 3
    capsys.readouterr()
    assert main(["plan", *robot, "--scene", "bookshelf", "--start", "", "--goal", ""]) == 2
    assert "nothing to plan" in capsys.readouterr().err
