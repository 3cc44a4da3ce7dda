"""Files that are not there, or are folders: each reader names the file once, and says why."""

from collections.abc import Callable
from pathlib import Path

import pytest

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.ompl.plans import Plan
from plannercheck.proofs import load_proofs
from plannercheck.scenes.moveit_request import read_request

PANDA = pc.Robot.load("panda")
READERS: dict[str, Callable[[str], object]] = {
    "x.json": load_proofs,
    "x.npz": load_proofs,
    "robot.yaml": pc.planar.Robot.load,
    "scene.yaml": pc.planar.Scene.load,
    "cell.yaml": pc.Scene.load,
    "arm.yaml": pc.Robot.load,
    "arm.urdf": pc.Robot.load,
    "plan.json": Plan.load,
    "request.yaml": read_request,
    "mesh.stl": pc.Solid.load,
    "cloud.pcd": lambda path: pc.PointCloud.load(path, 0.01),
    "map.bt": pc.Octree.load,
    "x.body": pc.Polytope.load,
    "heights.npy": lambda path: pc.HeightField.load(path, 0.1, 0.0),
    "trajectory.yaml": lambda path: pc.Trajectory.load(path, PANDA),
    "trajectory.json": lambda path: pc.Trajectory.load(path, PANDA),
}


@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize("is_folder", [False, True])
def test_what_can_not_be_read_is_named_once(tmp_path: Path, name: str, is_folder: bool) -> None:
    path = tmp_path / name
    if is_folder:
        path.mkdir()
    with pytest.raises(pc.PlannercheckError) as caught:
        READERS[name](str(path))
    assert str(caught.value).count(name) == 1, caught.value


@pytest.mark.parametrize("command", ["verify x.json", "validate --robot panda --path x.json", "view --robot x.urdf"])
@pytest.mark.parametrize("is_folder", [False, True])
def test_so_do_commands(
    tmp_path: Path, command: str, is_folder: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    if is_folder:
        (tmp_path / command.split()[-1]).mkdir()
    assert main(command.split()) == 2
    assert capsys.readouterr().err.count(command.split()[-1]) == 1
