"""The axis that separates most pairs, turned to where two bodies would face each other if they were ellipsoids."""

import itertools

import numpy as np
import pytest
from poses import at
from scipy.spatial.transform import Rotation
from solids import random_poses

import plannercheck as pc
from plannercheck.bodies.tuning import pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.stress.body_families import family
from plannercheck.evaluation.stress.contact_poses import Solid, contact_poses

CENTRE_AXIS = 2  # stage
LONG = np.array([1.0, 0.1, 0.1])
FLAT = np.array([1.0, 1.0, 0.1])
BODIES = {
    "rod": family("round", 300, 1) * LONG,
    "plate": family("round", 60, 2) * FLAT,
    "small": family("round", 20, 3) * [1.0, 0.7, 0.5],
    "box": family("box", 8, 4),
    "needle": family("needle", 100, 5),
    "polygon": np.array([[0.0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0]]),
    "large": family("round", 5000, 6) * LONG,
}


def verdicts(first, second, poses, **switches):
    options = pair_options(cached_plane=False, **switches)
    shared, stages, _ = core.intersect_batch(first.core, poses[0], second.core, poses[1], options)
    return np.asarray(shared, dtype=bool), np.asarray(stages)


@pytest.mark.parametrize("scale", [1e-20, 1e-3, 1.0, 1e3, 1e20])
@pytest.mark.parametrize("size", [100, 5000])
def test_rods_side_by_side_are_apart_across(scale, size):
    """The line between their centres runs along them, and a plane across it cuts both."""
    rods = pc.Polytope(family("round", size, 1) * LONG * scale), pc.Polytope(family("round", size, 2) * LONG * scale)
    turn = Rotation.random(40, random_state=1).as_matrix()
    first = np.repeat(np.eye(4)[None], 40, axis=0)
    first[:, :3, :3] = turn
    second = first @ at(*np.array([0.8, 0.12, 0.12]) * scale)
    shared, stages = verdicts(*rods, (first, second))
    assert not shared.any()
    assert (stages == CENTRE_AXIS).all()
    shared, stages = verdicts(*rods, (first, second), turned_axis=False)
    assert not shared.any()
    assert (stages != CENTRE_AXIS).all()


@pytest.mark.parametrize(("first", "second"), list(itertools.combinations_with_replacement(BODIES, 2)))
def test_verdicts_do_not_depend_on_it(first, second):
    bodies = pc.Polytope(BODIES[first]), pc.Polytope(BODIES[second], inflation_radius=0.01)
    solids = [Solid("", b.vertices, b.faces.astype(np.int64)) for b in bodies]
    rng = np.random.default_rng(3)
    if "polygon" in (first, second):
        poses = [np.repeat(np.eye(4)[None], 60, axis=0) for _ in bodies]
        for rows in poses:
            rows[:, :3, :3] = Rotation.random(60, random_state=int(rng.integers(100))).as_matrix()
            rows[:, :3, 3] = rng.uniform(-0.7, 0.7, (60, 3))
    else:
        gaps = np.repeat([0.3, 1e-2, 1e-6, 0.0, -1e-3], 8)
        both = zip(contact_poses(*solids, gaps, rng), random_poses(*solids, 20, rng), strict=True)
        poses = [np.concatenate(rows) for rows in both]
    on, _ = verdicts(*bodies, poses)
    off, _ = verdicts(*bodies, poses, turned_axis=False)
    exact, _ = verdicts(*bodies, poses, method="exact")
    np.testing.assert_array_equal(on, exact)
    np.testing.assert_array_equal(off, exact)


@pytest.mark.parametrize("scale", [1e-100, 1e-60, 1e30, 1e45])
def test_where_no_such_axis_can_be_computed(scale):
    """Fifth powers of lengths leave the doubles: the axis between the centres stays."""
    bodies = [pc.Polytope(family("round", 100, seed) * LONG * scale) for seed in (1, 2)]
    poses = [np.repeat(np.eye(4)[None], 30, axis=0) for _ in bodies]
    poses[1][:, :3, :3] = Rotation.random(30, random_state=1).as_matrix()
    poses[1][:, 0, 3] = np.linspace(-3, 3, 30) * scale
    found, _ = verdicts(*bodies, poses)
    exact, _ = verdicts(*bodies, poses, method="exact")
    np.testing.assert_array_equal(found, exact)
    assert 0 < exact.sum() < 30


def test_a_robot_needs_the_solver_less():
    q = pc.Robot.load("panda").random_configurations(2000, 1)
    solver = {}
    for turned in (True, False):
        checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("cage"), tuning=pc.Tuning(turned_axis=turned))
        verdict = checker.check_states(q)
        solver[turned] = verdict, checker.statistics()["solver"]
    np.testing.assert_array_equal(solver[True][0], solver[False][0])
    assert solver[True][1] < 0.8 * solver[False][1]
