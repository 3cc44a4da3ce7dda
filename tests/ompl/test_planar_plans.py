"""Planning for planar robots with OMPL, and the command line on planar scenes."""

import json
import resource
import sys
from pathlib import Path

import numpy as np
import pytest
from ompl import base

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.ompl import plan, space_of
from plannercheck.planar.spare_states import SpareStates

P = pc.planar
CURVES = [("straight", None), ("dubins", 1.5), ("reeds_shepp", 1.5)]


def forklift():
    return P.Checker(P.Robot.load("forklift"), P.Scene.load("parking"))


@pytest.mark.parametrize(("curve", "radius"), CURVES)
def test_plans_are_valid(curve, radius):
    checker = forklift()
    ends = checker.scene.start("forklift"), checker.scene.goal("forklift")
    found = plan(checker, *ends, time_limit=20, seed=1, curve=curve, turning_radius=radius)
    assert found.solved, found.reason
    assert found.path[0] == pytest.approx(ends[0])
    assert found.path[-1] == pytest.approx(ends[1])
    assert checker.check_states(found.path).all()
    if curve != "straight":
        space = space_of(checker, curve, radius)
        steps = space.differences(found.path[:-1], found.path[1:])
        assert np.hypot(steps[:, 0], steps[:, 1]).max() <= 0.01
        assert (np.abs(steps[:, 2]) <= np.hypot(steps[:, 0], steps[:, 1]) / radius * 1.01 + 1e-6).all()


def test_trailers_plan_in_a_compound():
    checker = P.Checker(P.Robot.load("truck_trailer"), P.Scene.load("parking"))
    name = checker.robot.name
    found = plan(checker, checker.scene.start(name), checker.scene.goal(name), time_limit=20, seed=1)
    assert found.solved, found.reason
    space = space_of(checker)
    for a, b in zip(found.path[:-1], found.path[1:], strict=True):
        assert checker.check_motion(a, a + space.differences(a, b))


@pytest.mark.parametrize(
    ("curve", "radius", "kind"),
    [(*CURVES[0], base.SE2StateSpace), (*CURVES[1], base.DubinsStateSpace), (*CURVES[2], base.ReedsSheppStateSpace)],
)
def test_setup_makes_the_space(curve, radius, kind):
    setup = pc.ompl.setup(forklift(), curve=curve, turning_radius=radius)
    assert isinstance(setup.getStateSpace(), kind)
    assert setup.getSpaceInformation().getMotionValidator() is not None


@pytest.mark.parametrize(("curve", "radius"), CURVES)
def test_states_pass_through(curve, radius):
    """Reading what was written gives the same numbers, and the interpolated ends are the ends."""
    for name in ("forklift", "truck_trailer"):
        checker = P.Checker(P.Robot.load(name), P.Scene.load("parking"))
        space = space_of(checker, curve, radius)
        information = base.SpaceInformation(space.ompl_space())
        q = checker.robot.random_configurations(2, 0)
        states = [space.state(information, row) for row in q]
        assert np.array_equal([space.read(state) for state in states], q)
        if not space.is_straight:
            ends = space.curve_states(*states, np.array([0.0, 1.0]))
            assert space.differences(ends, q) == pytest.approx(np.zeros_like(q), abs=1e-6)


def test_motion_validator_says_how_far():
    checker = forklift()
    for curve, radius in CURVES:
        setup = pc.ompl.setup(checker, curve=curve, turning_radius=radius)
        space = space_of(checker, curve, radius)
        information = setup.getSpaceInformation()
        states = [space.state(information, q) for q in ([4.0, 4.0, 0.0], [40.0, 4.0, 0.0])]  # through parked cars
        validator = information.getMotionValidator()
        assert not validator.checkMotion(*states)
        last = space.state(information, [0, 0, 0])
        free, fraction = validator.checkMotionWithLastValid(*states, last)
        assert not free
        assert 0 < fraction < 1
        assert checker.is_valid(space.read(last))
        assert validator.getInvalidMotionCount() == 2


def test_sampled_curves_are_looked_at_all_along():
    """A robot of 2 cm and a post of 2 cm on its way, 10 m long: some four of a thousand states collide."""
    half = 0.01
    square = [[-half, -half], [half, -half], [half, half], [-half, half]]
    robot = P.Robot(square)
    for x in np.random.default_rng(3).uniform(1, 9, 12):
        scene = P.Scene("post")
        scene.add_polygon("post", [[x + a, b] for a, b in square])
        checker = P.Checker(robot.with_bounds([-1, -2], [11, 2]), scene)
        information = pc.ompl.setup(checker, 0.005, curve="dubins", turning_radius=0.5).getSpaceInformation()
        space = space_of(checker, "dubins", 0.5)
        states = [space.state(information, q) for q in ([0.0, 0.0, 0.0], [10.0, 0.0, 0.0])]
        assert not information.getMotionValidator().checkMotion(*states)
        short = space.state(information, [x - 0.1, 0.0, 0.0])
        assert information.getMotionValidator().checkMotion(states[0], short)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"curve": "dubins"}, "turning_radius"),
        ({"curve": "straight", "turning_radius": 1.0}, "turning_radius"),
        ({"curve": "dubins", "turning_radius": -1.0}, "positive"),
        ({"curve": "clothoid", "turning_radius": 1.0}, "dubins"),
    ],
)
def test_bad_curves_are_named(arguments, message):
    with pytest.raises(pc.PlannercheckError, match=message):
        pc.ompl.setup(forklift(), **arguments)


def test_unbounded_scenes_are_named():
    with pytest.raises(pc.PlannercheckError, match="bounds"):
        pc.ompl.setup(P.Checker(P.Robot.load("forklift")))


def test_commands(tmp_path, capsys):
    path = tmp_path / "plan.csv"
    where = ["--robot", "forklift", "--scene", "parking"]
    assert main(["plan", *where, "--seed", "1", "--output", str(path)]) == 0
    assert main(["validate", *where, str(path), "--format", "json", "--certify"]) == 0
    report = json.loads(capsys.readouterr().out.split("written to")[1].split("\n", 1)[1])
    assert report["valid"] == report["states"]
    assert report["certificates"]["passed"]
    samples = str(P.Scene.load("parking").states["forklift"].samples)
    output = tmp_path / "out.npz"
    assert main(["validate", *where, samples, "--pairs", "all", "--output", str(output)]) == 1
    assert (np.load(output)["valid"] == forklift().check_states(np.load(samples))).all()
    assert main(["inspect", *where, "--states", "10"]) == 0
    assert main(["validate", *where, "--path", str(path)]) == 0
    assert "proved for all" in capsys.readouterr().out
    through = tmp_path / "through.csv"
    np.savetxt(through, [[4.0, 4.0, 0.0], [40.0, 4.0, 0.0]], delimiter=",")
    assert main(["validate", *where, "--path", str(through), "--format", "json"]) == 1
    (verdict,) = json.loads(capsys.readouterr().out)
    assert 0 < verdict["free_until"] <= verdict["collides_at"] < 1
    assert len(verdict["certificate"]["shared_point"]) == 2
    assert main(["robots", "forklift", "truck_trailer"]) == 0


@pytest.mark.parametrize(
    "arguments",
    [
        ["validate", "--robot", "panda", "--scene", "parking", "x.npy"],
        ["validate", "--robot", "forklift", "--scene", "table", "x.npy"],
        ["plan", "--robot", "forklift", "--scene", "parking", "--verify", "fcl"],
        ["plan", "--robot", "panda", "--scene", "table", "--curve", "dubins", "--turning-radius", "1"],
    ],
)
def test_mixed_kinds_are_bad_input(arguments, capsys):
    assert main(arguments) == 2
    assert capsys.readouterr().err


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_states_to_work_in_are_freed_with_their_space():
    def resident():
        return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()

    space = base.ReedsSheppStateSpace(0.5)
    held = []
    for _ in range(2):
        for _ in range(10_000):
            with SpareStates(space, 3).taken() as states:
                states[0].setX(1.0)
        held.append(resident())
    assert held[1] - held[0] < 1 << 20
