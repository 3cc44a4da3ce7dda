"""The concave puzzles of configs/puzzles: hulls see no way, solids have one, which is planned and proved."""

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.common.package_data import shipped_folder
from plannercheck.ompl.plans import Plan

FOLDER = shipped_folder("configs") / "puzzles"
PUZZLES = {"ring": "hook", "lock": "key", "pipe": "panda"}
# The plans take seconds at most; a loaded machine gets more.
TIME = 120.0
# Short motions: longer ones seldom get through a keyhole.
RANGE = 0.3


def robot_file(scene):
    name = PUZZLES[scene]
    return name if name == "panda" else FOLDER / f"{name}.yaml"


def checker_of(scene, kind="solid"):
    robot = robot_file(scene)
    given = {} if PUZZLES[scene] == "panda" else {"geometry": kind}
    return pc.Checker(pc.Robot.load(robot, **given), pc.Scene.load(FOLDER / f"{scene}.yaml", meshes=kind))


def ends(checker):
    return checker.scene.start(checker.robot.name), checker.scene.goal(checker.robot.name)


@pytest.mark.parametrize("scene", PUZZLES)
def test_meshes_are_closed_and_concave(scene):
    checker = checker_of(scene)
    shapes = [body.shape for body in checker.bodies if isinstance(body.shape, pc.Solid)]
    assert len(shapes) == (1 if scene == "pipe" else 2)
    for shape in shapes:
        assert shape.is_closed
        assert not shape.equals_hull
        assert len(shape.triangles) < 500


@pytest.mark.parametrize("scene", PUZZLES)
def test_hulls_see_no_way(scene):
    checker = checker_of(scene, "hull")
    found = pc.ompl.plan(checker, *ends(checker))
    assert not found.solved
    assert "collides" in found.reason
    assert not checker.check_states(ends(checker)).all()


@pytest.mark.parametrize("scene", PUZZLES)
def test_solids_have_a_way_and_no_straight_one(scene):
    checker = checker_of(scene)
    start, goal = ends(checker)
    assert checker.check_states([start, goal]).all()
    assert not checker.check_motion(start, goal, path="slerp")
    found = pc.ompl.plan(checker, start, goal, seed=1, time_limit=TIME, longest_motion=RANGE)
    assert found.solved, found.reason
    assert len(found.path) > 2
    assert checker.check_motions(found.path[:-1], found.path[1:], path="slerp").all()
    for a, b in zip(found.path[:-1], found.path[1:], strict=True):
        states = checker.motion_sampler.states(a, b, np.linspace(0, 1, 50), "slerp")
        assert checker.check_states(states).all()


def test_a_command_plans_one(capsys, tmp_path):
    where = ["--robot", str(robot_file("ring")), "--scene", str(FOLDER / "ring.yaml")]
    plan, solid = ["plan", *where, "--seed", "1", "--time", str(TIME)], ["--scene-meshes", "solid"]
    file = tmp_path / "plan.json"
    assert main([*plan, *solid, "--output", str(file)]) == 0
    assert "found a path" in capsys.readouterr().out
    validate = ["validate", *where, *solid, "--path", str(file)]
    assert main([*validate, "--motion-path", "slerp"]) == 0
    assert main([*plan, "--geometry", "hull"]) == 2
    assert "start collides: hook with ring" in capsys.readouterr().err
    assert main([*plan, *solid, "--bounds", "1,2,3"]) == 2
    assert "--bounds takes six numbers" in capsys.readouterr().err


def test_a_saved_plan_of_a_free_body_is_validated_along_the_path_that_was_planned(tmp_path, capsys):
    """OMPL turns by slerp. On a screw the same states may collide."""
    plan = str(tmp_path / "plan.json")
    given = ["--robot", str(robot_file("lock")), "--scene", str(FOLDER / "lock.yaml"), "--scene-meshes", "solid"]
    planned = ["plan", *given, "--geometry", "solid", "--time", str(TIME), "--seed", "3", "--output", plan]
    assert main(planned) == 0
    assert Plan.load(plan).motion_path == "slerp"
    assert main(["validate", *given, "--geometry", "solid", "--path", plan]) == 0
    assert "proved for all" in capsys.readouterr().out


def test_plans_of_arms_have_no_slerp():
    checker = checker_of("pipe")
    assert pc.ompl.plan(checker, *ends(checker), time_limit=TIME, seed=1).motion_path == "screw"
