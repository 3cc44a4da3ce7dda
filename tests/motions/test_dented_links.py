"""States and motions of solids that are nearly their hulls: the switch changes nothing, and dents are free."""

import warnings

import numpy as np
import pytest
from carriages import carriage
from poses import at
from solid_meshes import dimpled

import plannercheck as pc


@pytest.fixture(scope="module", params=["panda", "go2"])
def robot(request):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return pc.Robot.load(request.param, geometry="solid")


@pytest.mark.parametrize("padding", [0.0, 0.002])
def test_the_switch_changes_no_verdict(robot, padding):
    with_dents, without = (pc.Checker(robot, padding=padding, tuning=pc.Tuning(dents=each)) for each in (True, False))
    q = robot.random_configurations(600, seed=3)
    assert np.array_equal(with_dents.colliding_pairs(q), without.colliding_pairs(q))
    valid = with_dents.check_states(q)
    assert np.array_equal(valid, without.check_states(q))
    assert np.array_equal(valid, [with_dents.is_valid(row) for row in q])
    start = q[valid][:150]
    end = np.clip(start + 0.1 * np.random.default_rng(4).normal(size=start.shape), robot.lower, robot.upper)
    free = with_dents.check_motions(start, end)
    assert np.array_equal(free, without.check_motions(start, end))
    assert 20 < free.sum() < len(free)


@pytest.mark.parametrize("dents", [True, False])
def test_a_ball_moves_within_a_dent(tmp_path, dents):
    """The dish is a cube of two metres with a dimple of 5 cm, in which there is room above x = z = 0."""
    path = tmp_path / "carriage.urdf"
    path.write_text(carriage("z", 0.02))
    scene = pc.Scene("dish")
    dish = pc.Solid(*dimpled(0.05))
    assert np.isfinite(pc.Polytope(dish).core.dent)
    pose = at(0, 0, -1)
    scene.add("dish", dish, pose)
    checker = pc.Checker(pc.Robot.from_urdf(path), scene, tuning=pc.Tuning(dents=dents))
    free = np.array([[-0.1, -0.02], [0.1, -0.02], [0.0, -0.029], [0.0, 0.1]])
    hits = np.array([[0.0, -0.031], [0.7, 0.001], [0.0, -1.0]])
    assert checker.check_states(free).all()
    assert not checker.check_states(hits).any()
    for start in free:
        for end in free:
            assert checker.check_motion(start, end)
        for end in hits:
            assert not checker.check_motion(start, end)
    assert not checker.check_motion([-1.5, -0.02], [1.5, -0.02])
    hulls = pc.Scene("hull")
    hulls.add("dish", pc.Hull(dish.vertices), pose)
    assert not pc.Checker(pc.Robot.from_urdf(path), hulls).check_states(free[:3]).any()
