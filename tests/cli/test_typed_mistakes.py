"""What strangers type wrong on the command line: a table of commands, each with the line that it gets.

Each ends with exit code 2, one line on the error stream (after argparse's usage, where argparse found the fault), and
nothing on the output.
"""

import re

import numpy as np
import pytest
from broken_files import SRDF, write_all

from plannercheck.cli.main import main

ARM = "--robot arm.urdf"
PLAN = f"plan {ARM} --scene cell.yaml"
MISTAKES = {
    # one kind of file for another
    "validate --robot cell.yaml q.npy": "robot file cell.yaml: is a scene, not a robot",
    f"validate {ARM} --scene arm.urdf q.npy": "scene file 'arm.urdf': .*it is a URDF",
    f"validate {ARM} --scene q.npy q.npy": "scene file 'q.npy': .*it is a numpy array",
    f"validate {ARM} --path cell.yaml": "path file 'cell.yaml': holds no 'path', no 'joint_trajectory' and no 'points'",
    f"validate {ARM} cell.yaml": "file 'cell.yaml': must be one of .npy, .npz, .csv",
    f"validate {ARM} --srdf cell.yaml q.npy": "SRDF cell.yaml does not parse",
    f"validate {ARM} --srdf arm.urdf q.npy": "SRDF arm.urdf is none: it has links and joints, as a URDF has",
    "validate --robot arm.srdf q.npy": "robot 'arm.srdf' must be .* a URDF file; it is an SRDF",
    "verify plan.json": "proof file 'plan.json': is no motion proof",
    f"plan {ARM} --problems folder": "'folder' must hold one problem set",
    f"plan {ARM} --problems missing.tar": "'missing.tar' is neither a folder nor a readable tar .*No such file",
    f"plan {ARM} --scene parking --start 0 --goal 1": "scene 'parking' is planar, robot 'arm.urdf' is not",
    "plan --robot forklift --scene cell.yaml": "'cell.yaml': it is not planar: 'kind: planar' is missing",
    "stress --case missing.json": "'missing.json' is no case of a stress: .*No such file",
    # what is missing, or too much
    "validate q.npy": "the following arguments are required: --robot",
    f"validate {ARM}": "needs either files with configurations or --path",
    f"validate {ARM} q.npy --path plan.json": r"takes files with configurations \(q.npy\) or --path with",
    f"validate {ARM} --path plan.json --certify p.json": r"\(p.json\) or --path .*; --proof FILE says where",
    f"{PLAN}": "scene 'cell' declares no start for robot 'arm': give the start yourself",
    f"{PLAN} --start 0": "scene 'cell' declares no goal for robot 'arm': give the goal yourself",
    "verify sound.proof.json --scene cell.yaml": "--scene needs --robot",
    "acm --states 10": "acm needs --robot",
    f"view {ARM} --q 0 q.npy --html p.html": "FILE, --q and --path exclude each other",
    # names
    f"validate {ARM} --group al q.npy": "unknown joint 'al': valid are hinge",
    f"validate {ARM} --srdf arm.srdf --group al q.npy": "unknown planning group 'al': did you mean 'all'",
    "validate --robot Panda q.npy": "unknown robot 'Panda': did you mean 'panda'",
    "validate --robot panda.urdf q.npy": "robot file panda.urdf does not exist",
    f"validate {ARM} --scene shelf.yaml q.npy": "scene file 'shelf.yaml' does not exist",
    f"{PLAN} --start 0 --goal 1 --planner RRTstarr": "unknown planner 'RRTstarr': did you mean 'RRTstar'",
    f"{PLAN} --start 0 --goal 1 --planner foo": "unknown planner 'foo': valid are ",
    "robots pand": "unknown robot 'pand': did you mean 'panda'",
    "stress --families cubes --motions 10": "unknown family 'cubes': valid are tree",
    "bench stats": "invalid choice: 'stats' .*did you mean states",
    f"validat {ARM} q.npy": "invalid choice: 'validat' .*did you mean validate",
    f"validate {ARM} --sceen cell.yaml q.npy": "unrecognized arguments: --sceen; did you mean --scene",
    f"validate {ARM} --limits eror q.npy": "invalid choice: 'eror' .*did you mean error",
    f"validate {ARM} --columns hinge,elbow q.npy": "--columns must name 1 columns, for hinge; not 2",
    # numbers
    f"validate {ARM} --padding 1cm q.npy": "--padding must be a length in m or 'scene', not '1cm'",
    f"validate {ARM} --padding -1 q.npy": "padding must be a length in m of at least 0, not -1",
    f"validate {ARM} --threads 0 q.npy": "threads must be a whole number of at least 1, not 0",
    f"validate {ARM} --path plan.json --tolerance -1": "tolerance must be a positive length in m, not -1",
    f"{PLAN} --start 0,0 --goal 1": r"start: configurations must have shape \(1,\)",
    f"{PLAN} --start 0 --goal 90": "goal is beyond the limits: hinge is 90, not in .*as degrees it would be within",
    f"{PLAN} --start nan --goal 1": "start: configurations must be finite",
    f"{PLAN} --start 0 --goal 1 --time -3": "time_limit must be a positive time in s, not -3",
    f"{PLAN} --start 0 --goal 1 --seed 0": r"seed must be a whole number from 1 to 2\*\*64 - 1, not 0",
    f"{PLAN} --start 0 --goal 1 --range -1": "must be a length in rad or 0, not -1",
    f"{PLAN} --start 0 --goal 1 --curve dubins": "curves and turning radii are for planar robots",
    f"view {ARM} --q zero --html p.html": "--q must be numbers separated by commas, not 'zero'",
    f"view {ARM} --q 0 --port 99999999": "--port must be from 1 to 65535, not 99999999",
    f"acm {ARM} --states 0": "--states must be at least 1",
    f"acm {ARM} --always 2": r"always within \(0, 1\], not 10000 and 2",
    f"inspect {ARM} --seed -1": "--states must be at least 1 and --seed at least 0",
    "stress --pairs many": "argument --pairs: invalid int value: 'many'",
    # where things are
    f"validate {ARM} --package-dirs nowhere q.npy": "--package-dirs: there is no folder 'nowhere'",
    f"validate {ARM} --output q.txt q.npy": "--output must be one of .npz, .csv, .parquet, not 'q.txt'",
    f"validate {ARM} --output no/where.npz q.npy": "'no/where.npz' can't be written: there is no folder 'no'",
    f"{PLAN} --start 0 --goal 1 --output plan.xlsx": "unknown format of a plan '.xlsx': valid are .json",
    f"view {ARM} --html no/p.html": "'no/p.html' can't be written: there is no folder 'no'",
    f"acm {ARM} --output a.txt --states 10": "--output must end in .srdf or .yaml, not 'a.txt'",
    # xacro
    f"validate {ARM} --xacro-arg side:=left q.npy": "arm.urdf is no .xacro, so that it takes no arguments: side",
    "inspect --robot broken.urdf.xacro --xacro-arg side=left": "--xacro-arg must be NAME:=VALUE, not 'side=left'",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("typed")
    write_all(made)
    (made / "arm.srdf").write_text(SRDF)
    return made


@pytest.mark.parametrize("command", MISTAKES)
def test_each_mistake_gets_a_line_that_names_it(command, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    assert main(command.split()) == 2
    out, err = capsys.readouterr()
    assert out == ""
    errors = [line for line in err.splitlines() if "error: " in line]
    assert len(errors) == 1, err
    assert re.search(MISTAKES[command], errors[0]), err


def test_a_xacro_without_xacro_says_what_to_install(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    monkeypatch.setitem(__import__("sys").modules, "xacro", None)
    assert main(["validate", "--robot", "broken.urdf.xacro", "q.npy"]) == 2
    assert "xacro" in (err := capsys.readouterr().err)
    assert "pip install" in err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--srdf", "other.srdf", "q.npy"], "of links that the URDF does not know: foot, hand"),
        (["degrees.npy"], "as degrees they would not be: angles are in rad"),
        (["--scene", "mm.yaml", "q.npy"], "if these are in millimetres, multiply them by 0.001"),
    ],
)
def test_what_can_be_judged_but_is_hardly_meant_gets_a_warning(arguments, told, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    np.save(folder / "degrees.npy", np.full((30, 1), 90.0))
    (folder / "other.srdf").write_text('<robot name="b"><disable_collisions link1="hand" link2="foot"/></robot>')
    (folder / "mm.yaml").write_text("objects:\n- {name: t, box: {size: [800, 600, 20]}, position: [3000, 0, 0]}\n")
    assert main(["validate", "--robot", "arm.urdf", *arguments]) in (0, 1)
    assert told in capsys.readouterr().err
