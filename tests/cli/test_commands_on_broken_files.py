"""Every command on every broken file: one line that names the file, exit code 2, and nothing half-written."""

from functools import cache

import pytest
from broken_files import BROKEN, FITTING, commands, write_all

from plannercheck.bodies import mjcf_files
from plannercheck.cli.main import main
from plannercheck.common.isolated_process import run_isolated
from plannercheck.robots import xacro

ABSENT = ("folder", "missing.urdf", "missing.srdf", "missing.yaml", "missing.npy", "missing.json")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("broken")
    write_all(made)
    return made


@pytest.fixture(autouse=True, scope="module")
def _workers_are_asked_once():
    """They read files in processes of their own: else one for each of the commands again."""
    run = cache(run_isolated)
    with pytest.MonkeyPatch.context() as patch:
        for module in (mjcf_files, xacro):
            patch.setattr(module, "run_isolated", lambda name, arguments, *more: run(name, tuple(arguments), *more))
        yield


@pytest.mark.parametrize("name", [*BROKEN, *ABSENT])
def test_every_command_says_in_one_line_what_is_wrong_with_a_file(name, folder, monkeypatch, capfd):
    monkeypatch.chdir(folder)
    before = {path.name for path in folder.iterdir()}
    for arguments in commands(name):
        if arguments[max(arguments.index(name) - 1, 0)] in FITTING.get(name, ()):
            continue
        code = main(arguments)
        out, err = capfd.readouterr()
        command = " ".join(arguments)
        errors = [line for line in err.splitlines() if line.startswith("plannercheck: error: ")]
        assert code == 2, f"{command}: {err}"
        assert out == "", command
        assert len(errors) == 1, f"{command}: {err}"
        assert name in errors[0], f"{command}: {err}"
        assert "Traceback" not in err, command
        assert "object is not" not in err, command
    assert {path.name for path in folder.iterdir()} == before


# What a file is called that was handed over for another one.
TOLD = {
    "pointer.urdf": "is a Git LFS pointer, not the file itself: `git lfs pull` fetches it",
    "pointer.srdf": "is a Git LFS pointer",
    "pointer.yaml": "is a Git LFS pointer",
    "pointer.npy": "is a Git LFS pointer",
    "pointer.csv": "is a Git LFS pointer",
    "pointer.h5": "is a Git LFS pointer",
    "picture.npy": "it is a picture",
    "npz.npy": "it is a zip archive, as .npz files are",
    "npy.npz": "it is a numpy array, as .npy files are",
    "sdf_as.urdf": "is an SDF file",
    "mjcf_as.urdf": "MJCF mjcf_as.urdf",
    "page.urdf": "it is a web page",
    "urdf_as.yaml": "it is a URDF",
    "urdf_as.srdf": "it has links and joints, as a URDF has, which --robot takes",
    "srdf_as.urdf": "it is an SRDF, which --srdf takes",
    "xacro_as.urdf": "it is a xacro, which has to be expanded first",
    "broken.urdf.xacro": "can't be expanded: unknown macro name: xacro:arm",
    "picture.png": "a YAML or a URDF file; it is a picture",
    "folder": "a YAML or a URDF file; it is a folder",
}


@pytest.mark.parametrize("name", TOLD)
def test_the_line_says_what_the_file_is(name, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    place = {"srdf": ["--robot", "arm.urdf", "--srdf", name]}.get(name.rpartition(".")[2], ["--robot", name])
    sets = name.rpartition(".")[2] in ("npy", "npz", "csv", "h5")
    assert main(["validate", *(["--robot", "arm.urdf", name] if sets else [*place, "q.npy"])]) == 2
    assert TOLD[name] in capsys.readouterr().err
