"""Commands on scenes with clouds, octrees, voxel grids and height fields."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from poses import at

import plannercheck as pc
from plannercheck.cli.main import main

START = [0, -0.785, 0, -2.356, 0, 1.571, 0.785]
GOAL = [0.8, 0.3, 0, -1.6, 0, 1.9, 0.785]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("sensed")
    rng, scene = np.random.default_rng(0), pc.Scene("sensed")
    points = rng.uniform(-0.5, 0.5, (2000, 3)) * [0.6, 1.2, 0.0] + np.array([0.6, 0, 0.25])
    behind = at(-0.6, 0.3, 0)
    scene.add("camera", pc.PointCloud(points, 0.01))
    scene.add("map", pc.Octree.from_cells(np.unique(rng.integers(0, 6, (30, 3)), axis=0), 0.05), behind)
    scene.add("grid", pc.VoxelGrid(rng.random((6, 6, 6)) < 0.2, 0.05, (-0.5, -0.9, 0.2)))
    scene.add("ground", pc.HeightField(rng.uniform(-0.3, -0.2, (10, 10)), 0.3, -1, (-1.5, -1.5)))
    scene.set_states("panda", START, GOAL)
    scene.save(made / "sensed.yaml")
    room, corners = pc.Scene("room"), [[0.9, -0.9, -0.2], [0.9, 0.9, 1.4], [-0.9, 0.9, 1.4], [-0.9, -0.9, 1.4]]
    room.add("camera", pc.PointCloud(np.array(corners), 0.01))
    room.save(made / "room.yaml")
    hit = pc.Scene("hit")
    hit.add("camera", pc.PointCloud(np.array([[9, 9, 9], [0.4, 0, 0.5], [0.31, 0, 0.59]]), 0.05))
    hit.set_states("panda", START, GOAL)
    hit.save(made / "hit.yaml")
    np.save(made / "q.npy", pc.Robot.load("panda").random_configurations(60, seed=1))
    np.save(made / "path.npy", np.array([START, GOAL]))
    return made


def run(folder: Path, command: str, scene: str, *more: str) -> int:
    return main([command, "--robot", "panda", "--scene", str(folder / scene), *more])


def test_verdicts_are_given_explained_and_certified(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = folder / "out.csv"
    assert run(folder, "validate", "sensed.yaml", str(folder / "q.npy"), "--explain", "--output", str(out)) == 1
    assert ",camera," in out.read_text()
    assert run(folder, "validate", "sensed.yaml", str(folder / "q.npy"), "--certify") == 1
    found = capsys.readouterr().out
    assert "panda in sensed" in found
    assert "not proved" in found
    assert [line.split()[-1] for line in found.splitlines() if line.startswith("not proved")] == ["0"]


def test_fcl_is_no_reference_for_clouds(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(folder, "validate", "sensed.yaml", str(folder / "q.npy"), "--reference", "fcl") == 2
    assert "FCL is compared with hulls, and 'camera', 'map', 'grid' are something else" in capsys.readouterr().err


def test_motions_are_planned_proved_and_shown(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan, page = str(folder / "plan.csv"), folder / "page.html"
    assert run(folder, "plan", "sensed.yaml", "--output", plan) == 0
    assert run(folder, "validate", "sensed.yaml", "--path", plan, "--certify") == 0
    assert (folder / "plan.proof.json").is_file()
    assert run(folder, "view", "sensed.yaml", "--html", str(page)) == 0
    assert page.stat().st_size > 10_000
    capsys.readouterr()
    assert run(folder, "inspect", "sensed.yaml", "--states", "20") == 0
    shown = capsys.readouterr().out
    assert re.search(r"camera +\(scene\) +pointcloud +[0-9,]+ points +- ", shown), shown
    assert re.search(r"map +\(scene\) +octree +[0-9,]+ cells +- ", shown), shown


def test_a_proof_of_a_path_in_a_room_is_written(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(folder / "path.npy")
    assert run(folder, "validate", "room.yaml", "--path", path, "--certify") == 0
    assert "confirmed in ball arithmetic" in capsys.readouterr().out
    where = ["--robot", "panda", "--scene", str(folder / "room.yaml")]
    assert main(["verify", str(folder / "path.proof.json"), *where]) == 0
    assert "model: confirmed" in capsys.readouterr().out


def test_reports_name_the_point(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(folder, "plan", "hit.yaml") == 2
    assert "start collides: panda_link7 with camera[2], panda_hand with camera[2]" in capsys.readouterr().err
    assert run(folder, "validate", "hit.yaml", "--path", str(folder / "path.npy")) == 1
    assert "collides at 0: panda_link7 with camera[2], which share the point" in capsys.readouterr().out
    assert run(folder, "validate", "hit.yaml", "--path", str(folder / "path.npy"), "--format", "json") == 1
    told = json.loads(capsys.readouterr().out)
    told = told[0] if isinstance(told, list) else told.get("paths", [told])[0]
    assert told["pair"] == ["panda_link7", "camera"]
    assert told["bodies"][1] == "camera[2]"
