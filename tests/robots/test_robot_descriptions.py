"""Robots by name from the package robot_descriptions, if it is installed; here one of that name with three robots."""

import sys

import pytest
from sample_robots import PANDA, PANDA_SRDF, SHARE

import plannercheck as pc
from plannercheck.cli.main import main


@pytest.fixture
def package(tmp_path, monkeypatch):
    folder = tmp_path / "site" / "robot_descriptions"
    folder.mkdir(parents=True)
    (folder / "__init__.py").write_text("")
    (folder / "arm_description.py").write_text(
        f"REPOSITORY_PATH = PACKAGE_PATH = {str(SHARE)!r}\nURDF_PATH, SRDF_PATH = {str(PANDA)!r}, {str(PANDA_SRDF)!r}\n"
    )
    (folder / "far_description.py").write_text("raise RuntimeError('no network\\nat all')")
    (folder / "arm_mj_description.py").write_text("USD_PATH = 'arm.usd'")
    monkeypatch.syspath_prepend(str(tmp_path / "site"))
    yield
    for name in [name for name in sys.modules if name.startswith("robot_descriptions")]:
        del sys.modules[name]


@pytest.mark.usefixtures("package")
def test_robots_have_the_names_of_the_packages_modules(capsys):
    robot = pc.Robot.load("arm_description")
    assert robot.name == "panda"
    assert len(robot.self_pairs) == len(pc.Robot.from_urdf(PANDA, PANDA_SRDF, SHARE).self_pairs)
    assert main(["inspect", "--robot", "arm_description", "--group", "arm", "--states", "10"]) == 0
    assert "nq" not in capsys.readouterr().err


@pytest.mark.usefixtures("package")
def test_what_can_not_be_had_is_said():
    with pytest.raises(
        pc.PlannercheckError, match="'far_description' of robot_descriptions can't be fetched: no network at"
    ):
        pc.Robot.load("far_description")
    with pytest.raises(pc.PlannercheckError, match="'arm_mj_description' of robot_descriptions has no URDF"):
        pc.Robot.load("arm_mj_description")
    with pytest.raises(pc.PlannercheckError, match="unknown robot 'leg_description'"):
        pc.Robot.load("leg_description")


def test_without_the_package_names_are_those_of_shipped_robots(monkeypatch):
    monkeypatch.setitem(sys.modules, "robot_descriptions", None)
    with pytest.raises(pc.PlannercheckError, match="unknown robot 'arm_description'"):
        pc.Robot.load("arm_description")
