"""The command line takes of a URDF what Python takes, and what acm writes."""

import numpy as np
import pytest
import yaml
from sample_robots import PANDA, PANDA_SRDF, SHARE

import plannercheck as pc
from plannercheck.cli.main import main

URDF = ("--robot", str(PANDA), "--srdf", str(PANDA_SRDF), "--group", "arm", "--package-dirs", str(SHARE))
READY = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]


@pytest.fixture
def rows(tmp_path):
    np.save(tmp_path / "q.npy", [READY, READY])
    return str(tmp_path / "q.npy")


def test_every_command_takes_an_srdf_and_a_group(rows, tmp_path, capsys):
    page, plan, near = str(tmp_path / "p.html"), str(tmp_path / "plan.json"), ",".join(map(str, READY))
    (tmp_path / "empty.yaml").write_text("objects: []\n")
    scene = ("--scene", str(tmp_path / "empty.yaml"))
    assert main(["validate", *URDF, rows]) == 0
    assert main(["view", *URDF, f"--q={near}", "--html", page]) == 0
    assert main(["view", *URDF, f"--q={near}", "--meshes", "--html", page]) == 0
    assert main(["inspect", *URDF, "--states", "20"]) == 0
    goal = ",".join(str(x + 0.1) for x in READY)
    assert main(["plan", *URDF, *scene, f"--start={near}", f"--goal={goal}", "--seed", "1", "--output", plan]) == 0
    assert main(["validate", *URDF, *scene, "--path", plan, "--certify"]) == 0
    assert main(["verify", str(tmp_path / "plan.proof.json"), *URDF, *scene]) == 0
    assert "model: confirmed" in capsys.readouterr().out
    assert main(["acm", *URDF, "--states", "50", "--audit"]) in (0, 1)
    assert main(["bench", "states", *URDF, "--scene", "none", "--states", "20", "--methods", "boxes"]) == 0


def test_joints_make_a_group_and_a_root_floats(rows, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    bare = ("--robot", str(PANDA), "--package-dirs", str(SHARE))
    np.save(tmp_path / "two.npy", [[0.1, -0.5]])
    assert main(["validate", *bare, "--group", "panda_joint1,panda_joint2", str(tmp_path / "two.npy")]) in (0, 1)
    # As `acm --audit --prove` writes it: the SRDF has no such group, and the YAML holds the fingers.
    assert main(["view", "--robot", "panda", "--group", "panda_finger_joint1", "--q=1e-5", "--html", "v.html"]) == 0
    np.save(tmp_path / "free.npy", [[0, 0, 0, 0, 0, 0, 1, *READY, 0.01]])
    assert main(["validate", *bare, "--floating", "--srdf", str(PANDA_SRDF), str(tmp_path / "free.npy")]) == 0
    capsys.readouterr()
    assert main(["validate", *bare, "--srdf", str(PANDA_SRDF), "--group", "arms", rows]) == 2
    assert "unknown planning group 'arms': did you mean 'arm'?" in capsys.readouterr().err
    assert main(["validate", *bare, "--group", "elbow", rows]) == 2
    assert "unknown joint 'elbow'" in capsys.readouterr().err
    assert main(["inspect", "--robot", "forklift", "--floating"]) == 2
    assert "--floating: planar robots have no URDF" in capsys.readouterr().err


def test_what_acm_writes_of_a_urdf_without_a_group_is_taken(tmp_path):
    urdf, out = tmp_path / "lift.urdf", tmp_path / "lift.yaml"
    box = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
    links = "".join(f'<link name="{name}">{box}</link>' for name in ("a", "b", "c"))
    joints = "".join(
        f'<joint name="{a}{b}" type="prismatic"><parent link="{a}"/><child link="{b}"/><axis xyz="0 0 1"/>'
        '<limit lower="1" upper="2" effort="1" velocity="1"/></joint>'
        for a, b in ("ab", "bc")
    )
    urdf.write_text(f'<robot name="lift">{links}{joints}</robot>')
    assert main(["acm", "--robot", str(urdf), "--states", "50", "--output", str(out)]) == 0
    assert main(["inspect", "--robot", str(out), "--states", "20"]) == 0


def test_what_acm_writes_may_be_moved_with_its_files(tmp_path):
    """Paths are relative to the output, wherever that is and wherever the command runs."""
    (tmp_path / "old/urdf").mkdir(parents=True)
    (tmp_path / "old/robots").mkdir()
    (tmp_path / "old/urdf/arm.urdf").write_text(
        '<robot name="arm"><link name="a"/><link name="b"/><joint name="turn" type="continuous">'
        '<parent link="a"/><child link="b"/></joint></robot>'
    )
    (tmp_path / "old/meshes").mkdir()
    out = tmp_path / "old/robots/arm.yaml"
    given = ["--robot", str(tmp_path / "old/urdf/arm.urdf"), "--package-dirs", str(tmp_path / "old/meshes")]
    assert main(["acm", *given, "--mesh-units", "metre", "--states", "10", "--output", str(out)]) == 0
    written = yaml.safe_load(out.read_text())
    assert written["urdf"] == "../urdf/arm.urdf"
    assert written["package_dirs"] == ["../meshes"]
    assert written["mesh_units"] == "metre"
    (tmp_path / "far/away").mkdir(parents=True)
    (tmp_path / "far/away/link").symlink_to(tmp_path / "old/robots")
    linked = tmp_path / "far/away/link/again.yaml"  # in a folder that is a link
    assert main(["acm", *given, "--states", "10", "--output", str(linked)]) == 0
    assert pc.Robot.load(linked).link_names == ("a", "b")
    (tmp_path / "old").rename(tmp_path / "new")
    assert pc.Robot.load(tmp_path / "new/robots/arm.yaml").link_names == ("a", "b")


def test_what_acm_writes_of_a_shipped_robot_names_its_urdf_as_shipped_robots_do(tmp_path):
    out = tmp_path / "mine.yaml"
    assert main(["acm", "--robot", "panda", "--states", "10", "--output", str(out)]) == 0
    assert yaml.safe_load(out.read_text())["urdf"] == "example-robot-data/robots/panda_description/urdf/panda.urdf"
    assert pc.Robot.load(out).nq == 7


@pytest.mark.parametrize("suffix", ["srdf", "yaml"])
def test_what_acm_writes_is_taken_as_it_is(suffix, rows, tmp_path, capsys):
    bare = (
        "--robot",
        str(PANDA),
        "--package-dirs",
        str(SHARE),
        "--group",
        ",".join(f"panda_joint{k}" for k in range(1, 8)),
    )
    out = tmp_path / f"panda.{suffix}"
    assert main(["acm", *bare, "--states", "200", "--output", str(out)]) == 0
    taken = [*bare, "--srdf", str(out)] if suffix == "srdf" else ["--robot", str(out)]
    assert main(["validate", *taken, rows]) == 0
    assert main(["inspect", *taken, "--states", "20"]) == 0
    assert main(["acm", *taken, "--states", "200", "--audit"]) in (0, 1)
    if suffix == "yaml":
        robot, written = pc.Robot.load(out), yaml.safe_load(out.read_text())
        assert robot.joint_names == tuple(f"panda_joint{k}" for k in range(1, 8))
        assert "package_dirs" not in written  # the shipped folder is known to all
        assert all(block["pairs"] for block in written["disabled_pairs"])


TOUCHING = """<robot name="r">
<link name="a"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
<link name="b"/>
<link name="c"><collision><geometry><sphere radius="1"/></geometry></collision></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
  <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="k" type="fixed"><parent link="b"/><child link="c"/></joint></robot>"""


def test_a_robot_of_which_no_state_is_valid_says_why_and_what_mends_it(tmp_path, capsys):
    urdf, srdf = tmp_path / "r.urdf", tmp_path / "r.srdf"
    urdf.write_text(TOUCHING)
    np.save(tmp_path / "q.npy", np.linspace(-1, 1, 30)[:, None])
    for command in (["inspect", "--states", "30"], ["validate", str(tmp_path / "q.npy")]):
        main([command[0], "--robot", str(urdf), *command[1:]])
        said = capsys.readouterr().err
        assert "each time by these pairs: a – c" in said
        assert "`plannercheck acm --robot FILE --output FILE.srdf` writes and --srdf FILE.srdf takes" in said
    assert main(["acm", "--robot", str(urdf), "--states", "20", "--output", str(srdf)]) == 0
    assert main(["validate", "--robot", str(urdf), "--srdf", str(srdf), str(tmp_path / "q.npy")]) == 0
