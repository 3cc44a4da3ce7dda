"""Robots of a URDF without a group: a number a joint will do, and joints that follow others do so."""

import json

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.validation.formats.chunks import read_states
from plannercheck.validation.formats.paths import read_robot_path

SMALL = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
URDF = f"""<robot name="r">
<link name="base">{SMALL}</link><link name="wheel">{SMALL}</link><link name="left">{SMALL}</link>
<link name="right">{SMALL}</link>
<joint name="spin" type="continuous"><parent link="base"/><child link="wheel"/><origin xyz="0 0 1"/>
  <axis xyz="0 0 1"/></joint>
<joint name="open" type="prismatic"><parent link="wheel"/><child link="left"/><origin xyz="0.5 0 0"/>
  <axis xyz="1 0 0"/><limit lower="0" upper="0.2" effort="1" velocity="1"/></joint>
<joint name="partner" type="prismatic"><parent link="wheel"/><child link="right"/><origin xyz="-0.5 0 0"/>
  <axis xyz="1 0 0"/><limit lower="-0.2" upper="0.2" effort="1" velocity="1"/>
  <mimic joint="open" multiplier="-1" offset="0.01"/></joint>
</robot>"""

ROWS = np.array([[0.5, 0.1], [-3.0, 0.2]])  # of the joints that move on their own
EVERY = np.column_stack([ROWS, 0.01 - ROWS[:, 1]])
FULL = np.column_stack([np.cos(ROWS[:, 0]), np.sin(ROWS[:, 0]), EVERY[:, 1:]])


@pytest.fixture
def urdf(tmp_path):
    path = tmp_path / "r.urdf"
    path.write_text(URDF)
    return path


@pytest.fixture
def robot(urdf):
    return pc.Robot.load(urdf)


def test_rows_of_one_number_a_joint_become_pinocchios(robot):
    assert robot.nq == 4
    for rows in (ROWS, EVERY, FULL):
        assert np.array_equal(robot.joint_values.configurations(rows), FULL)
    assert np.array_equal(robot.joint_values.configurations(ROWS[0]), FULL[:1])
    assert pc.Robot.load("panda").joint_values.maps == ()


def test_followers_follow_in_random_configurations(robot):
    q = robot.random_configurations(100, 1)
    assert np.array_equal(q[:, 3], 0.01 - q[:, 2])
    assert np.allclose(np.hypot(q[:, 0], q[:, 1]), 1, atol=1e-15)
    assert (q[:, 2] >= 0).all()
    assert q[:, 0].min() < -0.9 < 0.9 < q[:, 0].max()


def test_an_error_says_which_joint_takes_which_columns(robot, urdf):
    message = r"the columns are 0 to 1 spin \(cosine and sine\), 2 open, 3 partner"
    with pytest.raises(pc.PlannercheckError, match=message):
        robot.check_configurations([1.0, 2.0])
    floating = pc.Robot.from_urdf(urdf, floating=True)
    with pytest.raises(pc.PlannercheckError, match=r"0 to 6 root_joint \(x y z, quaternion x, y, z, w\), 7 to 8 spin"):
        floating.check_configurations([1.0])


@pytest.mark.parametrize("rows", [ROWS, EVERY, FULL], ids=["own", "every", "full"])
@pytest.mark.parametrize("suffix", ["npy", "npz", "csv", "parquet"])
def test_sets_may_have_a_column_a_joint(robot, tmp_path, rows, suffix):
    path = tmp_path / f"q.{suffix}"
    write(path, rows)
    found = np.concatenate([chunk.rows for chunk in read_states(path, robot)])
    assert np.array_equal(found, FULL)


def write(path, rows):
    if path.suffix == ".npy":
        np.save(path, rows)
    elif path.suffix == ".npz":
        np.savez(path, q=rows)
    elif path.suffix == ".csv":
        np.savetxt(path, rows, delimiter=",", fmt="%.17g")
    else:
        pyarrow = pytest.importorskip("pyarrow")
        parquet = pytest.importorskip("pyarrow.parquet")
        parquet.write_table(pyarrow.table({"q": list(rows)}), path)


def test_sets_may_name_the_joints(robot, tmp_path):
    (tmp_path / "q.csv").write_text("open,spin\n0.1,0.5\n0.2,-3\n")
    assert np.array_equal(next(read_states(tmp_path / "q.csv", robot)).rows, FULL)


def test_a_set_of_another_width_is_refused_with_all_ways(robot, tmp_path):
    np.save(tmp_path / "q.npy", np.zeros((5, 7)))
    message = (
        r"\(n, 4\), not \(5, 7\); the columns are 0 to 1 spin .*; or a number a joint: 3 \(spin, open, partner\) or 2"
    )
    with pytest.raises(pc.PlannercheckError, match=message):
        list(read_states(tmp_path / "q.npy", robot))


def test_paths_may_give_a_number_a_joint(robot, tmp_path):
    np.save(tmp_path / "p.npy", ROWS)
    (tmp_path / "p.json").write_text(json.dumps({"joint_names": ["spin", "open"], "path": ROWS.tolist()}))
    (tmp_path / "q.json").write_text(
        json.dumps({"joint_names": ["partner", "spin", "open"], "path": EVERY[:, [2, 0, 1]].tolist()})
    )
    for name in ("p.npy", "p.json", "q.json"):
        assert np.array_equal(read_robot_path(tmp_path / name, robot).states, FULL), name
    np.save(tmp_path / "p.npy", np.zeros((2, 6)))
    with pytest.raises(
        pc.PlannercheckError, match=r"\(n, 4\), not \(2, 6\); the columns are 0 to 1 spin .*; or a number a joint"
    ):
        read_robot_path(tmp_path / "p.npy", robot)


def test_the_command_line_takes_angles(urdf, tmp_path, capsys):
    robot, rows, plan = ("--robot", str(urdf)), str(tmp_path / "q.csv"), str(tmp_path / "plan.json")
    np.savetxt(tmp_path / "q.csv", np.degrees(ROWS) * [1, 0] + ROWS * [0, 1], delimiter=",", fmt="%.17g")
    assert main(["validate", *robot, "--degrees", rows]) == 0
    assert main(["view", *robot, "--q", "0.5,0.1", "--html", str(tmp_path / "page.html")]) == 0
    (tmp_path / "empty.yaml").write_text("objects: []\n")
    scene = ("--scene", str(tmp_path / "empty.yaml"))
    assert main(["plan", *robot, *scene, "--start", "0.5,0.1", "--goal=-3,0.2", "--output", plan, "--seed", "1"]) == 0
    assert json.loads((tmp_path / "plan.json").read_text())["joint_names"] == ["spin", "open"]
    assert main(["validate", *robot, "--path", plan]) == 0
    capsys.readouterr()
    assert main(["view", *robot, "--q", "1", "--html", str(tmp_path / "page.html")]) == 2
    assert "the columns are 0 to 1 spin (cosine and sine), 2 open, 3 partner" in capsys.readouterr().err


@pytest.mark.parametrize("rows", [ROWS, EVERY], ids=["own", "every"])
def test_checkers_and_link_poses_take_a_number_a_joint(robot, rows):
    checker = pc.Checker(robot)
    np.testing.assert_array_equal(robot.link_poses(rows), robot.link_poses(FULL))
    np.testing.assert_array_equal(robot.expand(rows[0]), robot.expand(FULL[0]))
    np.testing.assert_array_equal(checker.check_states(rows), checker.check_states(FULL))
    np.testing.assert_array_equal(checker.clearances(rows), checker.clearances(FULL))
    assert checker.is_valid(rows[0]) == checker.is_valid(FULL[0])
    assert checker.check_motion(*rows) == checker.check_motion(*FULL)
    assert checker.explain(list(rows[0])).valid == checker.explain(FULL[0]).valid
    assert checker.explain_motion(*rows).free == checker.explain_motion(*FULL).free
    assert checker.clearance(rows[0]) == checker.clearance(FULL[0])
    np.testing.assert_array_equal(
        checker.check_motions(rows, rows[::-1], 0.01), checker.check_motions(FULL, FULL[::-1], 0.01)
    )


def test_joints_that_follow_may_be_left_out_where_no_joint_turns(tmp_path):
    path = tmp_path / "slides.urdf"
    path.write_text(URDF.replace("continuous", "fixed"))
    checker = pc.Checker(pc.Robot.load(path))
    assert checker.check_motion([0.1], [0.2]) == checker.check_motion([0.1, -0.09], [0.2, -0.19])
    assert checker.explain([0.1]).valid == checker.is_valid([0.1, -0.09])
    for wrong in ([0.1, 0.2, 0.3], []):
        with pytest.raises(pc.PlannercheckError, match=r"shape \(2,\) or \(n, 2\)"):
            checker.check_motion(wrong, [0.2, -0.19])
