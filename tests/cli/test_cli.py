"""The command line: exit codes, tables, files, and one line for bad input."""

import json
import re
import subprocess
import sys
import tarfile
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh

from plannercheck.cli.main import main
from plannercheck.common.package_data import shipped_folder
from plannercheck.motions.checker import Checker
from plannercheck.ompl.plans import Plan
from plannercheck.robots.robot import Robot

SAMPLES = shipped_folder("configs") / "bookshelf_panda.npy"
PANDA = ["--robot", "panda", "--scene", "bookshelf"]


def error_of(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> str:
    """The one line that bad input gives."""
    assert main([str(argument) for argument in arguments]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("plannercheck: error: ")
    assert printed.err.count("\n") == 1
    return printed.err


def test_validate_writes_a_verdict_for_each_configuration(tmp_path, capsys, checker):
    samples = np.load(SAMPLES)
    expected = checker.check_states(samples)
    assert main(["validate", *PANDA, str(SAMPLES), str(SAMPLES), "--output", str(tmp_path / "v.npz")]) == 1
    with np.load(tmp_path / "v.npz") as written:
        assert written["valid"].dtype == np.bool_
        assert np.array_equal(written["valid"], np.tile(expected, 2))
        assert np.array_equal(written["first_pair"] < 0, written["valid"])
        assert [tuple(pair) for pair in written["pairs"]] == [checker.pair_names(k) for k in range(len(checker.pairs))]
    assert [path.name for path in tmp_path.iterdir()] == ["v.npz"]
    printed = capsys.readouterr().out
    assert re.search(rf"^valid +{2 * expected.sum()} ", printed, re.MULTILINE)
    assert "shelf" in printed


def test_validate_as_json(tmp_path, capsys, checker):
    np.savetxt(
        tmp_path / "q.csv",
        np.load(SAMPLES)[:50],
        delimiter=",",
        header=",".join(checker.robot.joint_names),
        comments="",
    )
    main(["validate", *PANDA, str(tmp_path / "q.csv"), "--format", "json", "--pairs", "all", "--threads", "2"])
    values = json.loads(capsys.readouterr().out)
    assert values["states"] == 50
    assert values["valid"] + values["invalid"] == 50
    assert values["all_pairs"] is True


def test_exit_codes_of_validate(tmp_path, checker):
    good = np.load(SAMPLES)
    good = good[checker.check_states(good)]
    beyond = checker.robot.reference.copy()
    beyond[6] += 10.0
    for rows, code in ((good, 0), (np.load(SAMPLES), 1), (beyond, 1), (np.empty((0, 7)), 0)):
        np.save(tmp_path / "q.npy", rows)
        assert main(["validate", *PANDA, str(tmp_path / "q.npy")]) == code


def test_self_collision_can_be_left_out(tmp_path, capsys):
    robot = Robot.load("panda")
    q = robot.random_configurations(300, 0)
    np.save(tmp_path / "q.npy", q[~Checker(robot).check_states(q)])
    assert main(["validate", "--robot", "panda", str(tmp_path / "q.npy")]) == 1
    assert main(["validate", "--robot", "panda", str(tmp_path / "q.npy"), "--no-self-collision"]) == 0


def test_reference_fcl(tmp_path, capsys):
    pytest.importorskip("fcl")
    np.save(tmp_path / "q.npy", np.load(SAMPLES)[:40])
    main(["validate", *PANDA, str(tmp_path / "q.npy"), "--reference", "fcl", "--format", "json"])
    values = json.loads(capsys.readouterr().out)
    assert values["fcl"]["passed"] is True
    assert values["fcl"]["configurations"] == 40


def test_bad_sets(tmp_path, capsys):
    np.save(tmp_path / "narrow.npy", np.zeros((5, 6)))
    rows = np.load(SAMPLES)
    rows[123, 4] = np.nan
    np.save(tmp_path / "nan.npy", rows)
    (tmp_path / "cut.npy").write_bytes(SAMPLES.read_bytes()[:-100])
    (tmp_path / "q.csv").write_text("panda_joint1,panda_joint9\n0,0\n")
    for name, message in (
        ("narrow.npy", "must have shape (n, 7), not (5, 6)"),
        ("nan.npy", "row 123 is not finite"),
        ("cut.npy", "no whole npy file"),
        ("q.csv", "no column for joint 'panda_joint2'"),
        ("missing.npy", "does not exist"),
    ):
        error = error_of(capsys, "validate", *PANDA, tmp_path / name)
        assert name in error
        assert message in error


def test_unknown_names(tmp_path, capsys):
    assert "did you mean 'panda'" in error_of(capsys, "validate", "--robot", "pandda", SAMPLES)
    assert "did you mean 'bookshelf'" in error_of(
        capsys, "validate", "--robot", "panda", "--scene", "bookshelv", SAMPLES
    )
    assert "RRTConnect" in error_of(capsys, "plan", *PANDA, "--planner", "RRTT")
    assert "no start for robot 'ur3'" in error_of(capsys, "plan", "--robot", "ur3", "--scene", "bookshelf")
    assert "there is no folder" in error_of(capsys, "validate", *PANDA, SAMPLES, "--output", tmp_path / "no" / "v.npz")
    assert "threads" in error_of(capsys, "validate", *PANDA, SAMPLES, "--threads", "0")


def test_wrong_usage_is_bad_input(capsys):
    assert main(["validate"]) == 2
    assert main(["dance"]) == 2
    assert main([]) == 2
    assert main(["--version"]) == 0
    capsys.readouterr()


def test_plan_writes_json_that_reads_back(tmp_path, capsys, checker):
    file = tmp_path / "plan.json"
    assert main(["plan", *PANDA, "--seed", "1", "--output", str(file)]) == 0
    plan = Plan.load(file)
    assert plan.solved
    assert plan.joint_names == checker.robot.joint_names
    assert np.array_equal(plan.path[0], checker.scene.start("panda"))
    assert np.array_equal(plan.path[-1], checker.scene.goal("panda"))
    plan.save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_text() == file.read_text()
    assert f"length {plan.length:.3f} rad" in capsys.readouterr().out
    for name in ("plan.npy", "plan.csv"):
        plan.save(tmp_path / name)
        assert main(["validate", *PANDA, str(tmp_path / name)]) == 0


def test_plan_takes_ends_that_start_with_a_minus(capsys):
    assert main(["plan", *PANDA, "--start", "-0.1,0,0,0,0,0,0", "--goal", "-1 0 0 -1.5 0 1.5 0"]) == 2
    printed = capsys.readouterr().err
    assert "not planned: start is beyond the limits: panda_joint4 is 0" in printed


def test_plan_takes_several_goals(capsys):
    ends = ["--start=0,-0.785,0,-2.356,0,1.571,0.785", "--goal=9,0,0,0,0,0,0", "--goal=0,-0.785,0,-2.356,0,1.571,0.9"]
    assert main(["plan", "--robot", "panda", "--scene", "empty", *ends]) == 0
    assert "to goal 1" in capsys.readouterr().out
    assert main(["plan", "--robot", "panda", "--scene", "empty", *ends[:2], "--goal=8,0,0,0,0,0,0"]) == 1
    assert "goal 1 is beyond the limits: panda_joint1 is 8" in capsys.readouterr().out


def test_bad_arguments_of_plan(tmp_path, capsys):
    assert "--start must be numbers" in error_of(capsys, "plan", *PANDA, "--start", "1,a")
    assert "start" in error_of(capsys, "plan", *PANDA, "--start", "1,2,3")
    assert "needs --scene" in error_of(capsys, "plan", "--robot", "panda")
    assert "format of a plan" in error_of(capsys, "plan", *PANDA, "--output", tmp_path / "plan.txt")
    assert "exclude each other" in error_of(capsys, "plan", *PANDA, "--problems", tmp_path)
    assert "problem set" in error_of(capsys, "plan", "--robot", "panda", "--problems", tmp_path)


SCENE = """
name: one box
world:
  collision_objects:
    - id: box
      primitives: [{type: box, dimensions: [0.1, 0.1, 0.1]}]
      primitive_poses: [{position: [%s], orientation: [0, 0, 0, 1]}]
"""

REQUEST = """
group_name: arm
start_state:
  joint_state:
    name: [panda_joint1, panda_joint2, panda_joint3, panda_joint4, panda_joint5, panda_joint6, panda_joint7,
           panda_finger_joint1, panda_finger_joint2]
    position: [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785, 0.03, 0.03]
goal_constraints:
  - joint_constraints:
"""


def write_problem(folder: Path, number: int, position: str) -> None:
    goal = [0.5, -0.5, 0.0, -2.0, 0.0, 1.571, 0.785]
    lines = [f"      - {{joint_name: panda_joint{k + 1}, position: {value}}}" for k, value in enumerate(goal)]
    (folder / f"scene{number:04d}.yaml").write_text(SCENE % position)
    (folder / f"request{number:04d}.yaml").write_text(REQUEST + "\n".join(lines) + "\n")


@pytest.fixture(params=["folder", "archive"])
def problems(request, tmp_path) -> Path:
    folder = tmp_path / "boxes"
    folder.mkdir()
    write_problem(folder, 1, "0.0, 0.9, 0.3")
    write_problem(folder, 2, "0.3, 0.0, 0.6")
    if request.param == "folder":
        return folder
    with tarfile.open(tmp_path / "boxes.tar.bz2", "w:bz2") as archive:
        archive.add(folder, "boxes")
    return tmp_path / "boxes.tar.bz2"


def test_a_problem_set_is_planned_and_counted(problems, tmp_path, capsys):
    pytest.importorskip("fcl")
    output = tmp_path / "results.json"
    command = ["plan", "--robot", "panda", "--problems", str(problems), "--seed", "1", "--time", "5"]
    code = main([*command, "--each", "--verify", "fcl", "--output", str(output)])
    printed = capsys.readouterr().out
    results = json.loads(output.read_text())
    assert [result["problem"] for result in results] == ["boxes/0001", "boxes/0002"]
    assert [result["solved"] for result in results] == [True, False]
    assert results[0]["verified"]["passed"] is True
    assert "panda_" in results[1]["start_pairs"][0][0]
    assert results[1]["start_pairs"][0][1] == "box"
    assert "Colliding starts and goals" in printed
    assert code == 1
    assert main([*command, "--first", "1", "--no-simplify"]) == 0


def test_robots_and_inspect_print_tables(capsys):
    assert main(["robots", "panda", "ur5"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 3
    assert main(["inspect", *PANDA, "--states", "100"]) == 0
    printed = capsys.readouterr().out
    assert "panda_link0" in printed
    assert "100 random configurations" in printed
    assert "68 settled beforehand: never meet within the joint limits, by proof" in printed
    assert main(["inspect", "--robot", "talos", "--states", "1"]) == 0
    out = capsys.readouterr().out
    (torso,) = [line.split() for line in out.splitlines() if line.startswith("torso_2_link_0")]
    assert torso[-3:] == ["44891.6", "44888.6", "1.00"]  # cm³, as SciPy has them
    assert "not watertight): torso_1_link_0" in out


def test_the_first_screen_of_inspect_has_the_answer_in_bodies_and_pairs(capsys):
    assert main(["inspect", *PANDA, "--states", "1000"]) == 0
    printed = capsys.readouterr().out
    first = printed.splitlines()[:20]
    assert first[0] == "robot   panda: 7 joints of group 'arm', 17 bodies on 11 links"
    assert first[1] == "scene   bookshelf: 6 objects, 18 bodies"
    assert first[2] == "pairs   332 of bodies are tested: 44 self pairs, 288 with the scene"
    assert any(line.startswith("states  1000 random configurations within the limits: 7") for line in first)
    assert any(line.split()[:2] == ["6", "panda_joint7"] for line in first)
    assert not re.search(r"\.py\b|\bcpp/|robots/|checking/", printed)


def test_the_first_screen_of_inspect_counts_as_brute_force_does(capsys, checker):
    assert main(["inspect", *PANDA, "--states", "300"]) == 0
    printed = capsys.readouterr().out
    hit: dict[tuple[str, str], set[int]] = {}
    for state, pair in np.argwhere(checker.colliding_pairs(checker.robot.random_configurations(300, 0))).tolist():
        hit.setdefault(checker.pair_names(pair), set()).add(state)
    (a, b), states = max(hit.items(), key=lambda item: len(item[1]))
    assert f"pairs that collide most often: {a} – {b} ({len(states) / 3:.1f} %)" in printed
    left_out = [int(count) for count in re.findall(r"^ +(\d+) not tested:", printed, re.MULTILINE)]
    bodies = len(checker.robot.bodies)
    assert len(checker.pairs) + sum(left_out) == bodies * (bodies - 1) // 2 + bodies * len(checker.scene.bodies)


def test_inspect_lists_all_hulls_that_the_warning_counts(tmp_path, capsys):
    """The warning names one link, and says that inspect lists all."""
    cross = trimesh.util.concatenate([trimesh.creation.box([0.3, 0.01, 0.01]), trimesh.creation.box([0.01, 0.3, 0.01])])
    cross.export(tmp_path / "cross.stl")
    mesh = '<collision><geometry><mesh filename="cross.stl"/></geometry></collision>'
    joint = '<joint name="turn" type="continuous"><parent link="a"/><child link="b"/></joint>'
    links = f'<link name="a">{mesh}</link><link name="b">{mesh}</link>'
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm">{links}{joint}</robot>')
    assert main(["inspect", "--robot", str(tmp_path / "arm.urdf"), "--states", "10"]) == 0
    printed = capsys.readouterr()
    assert "plannercheck inspect lists all" in printed.err
    listed = re.findall(r"^  (\S+): the hull is (\S+) times as large as the mesh$", printed.out, re.MULTILINE)
    assert [name for name, _ in listed] == ["a_0", "b_0"]


def test_inspect_names_both_columns_of_a_continuous_joint(tmp_path, capsys):
    (tmp_path / "wheel.urdf").write_text(
        '<robot name="wheel"><link name="base"/>'
        '<link name="rim"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>'
        '<joint name="axle" type="continuous"><parent link="base"/><child link="rim"/></joint></robot>'
    )
    assert main(["inspect", "--robot", str(tmp_path / "wheel.urdf"), "--states", "10"]) == 0
    rows = [line.split()[:3] for line in capsys.readouterr().out.splitlines()]
    assert ["0", "axle", "(cosine)"] in rows
    assert ["1", "axle", "(sine)"] in rows


def test_the_demo_does_the_main_job(capsys):
    began = time.perf_counter()
    assert main(["demo"]) == 0
    assert time.perf_counter() - began < 20
    printed = capsys.readouterr().out
    assert printed.count("$ plannercheck") == 3
    assert "RRTConnect found a path" in printed


def test_help_imports_nothing_heavy():
    script = "import sys; from plannercheck.cli.main import main; main(['--help']); assert 'numpy' not in sys.modules"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert "validate" in done.stdout


@pytest.mark.parametrize(
    "command", ["validate", "verify", "plan", "demo", "view", "robots", "inspect", "export", "stress", "bench"]
)
def test_every_command_has_help(command, capsys):
    assert main([command, "--help"]) == 0
    assert "usage: plannercheck" in capsys.readouterr().out


def test_a_closed_pipe_is_no_traceback():
    script = "import sys; from plannercheck.cli.main import main; sys.exit(main(['robots', 'panda', 'ur5']))"
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert b"Traceback" not in process.stderr.read()


def test_inspect_says_what_each_stage_and_counter_is():
    import plannercheck as pc
    from plannercheck.cli.inspect import PAIR_TEST, STAGES

    planar = pc.planar.Checker(pc.planar.Robot.load("forklift"))
    known = set()
    for checker in (pc.Checker(pc.Robot.load("panda")), planar):
        statistics = checker.statistics()
        known |= statistics.keys()
        assert set(statistics) - {"states", "queries"} <= STAGES.keys()
        assert set(statistics["queries"]) <= PAIR_TEST.keys()
    assert known >= STAGES.keys()
