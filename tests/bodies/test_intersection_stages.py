"""Stages of the pair test: which one decides what, and no verdict depends on any of them."""

import itertools

import exact_verdicts
import numpy as np
import pytest
from pair_ways import DOUBLE_DOUBLE, EXACT, NEAREST_POINTS, SOLVER, UNIT
from poses import at
from solids import dyadic_poses, solid_of

import plannercheck as pc
from plannercheck.bodies.tuning import METHODS, pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.stress import contact_poses as contacts
from plannercheck.evaluation.stress.body_families import family


@pytest.mark.parametrize(("name", "n"), [("box", 8), ("prism", 12), ("round", 60), ("needle", 60), ("cone", 1000)])
def test_the_oracle_decides_clear_gaps_itself(name, n):
    """Its games may lose their way without a wrong verdict: then later stages would decide."""
    solid, polytope = solid_of(name, n, 0)
    gaps = np.tile([1e-1, 1e-3, -1e-3, -1e-1], 250)
    poses = contacts.contact_poses(solid, solid, gaps, np.random.default_rng(2))
    options = pair_options("oracle", cached_plane=False, centre_axis=False)
    _, stages, _ = core.intersect_batch(polytope.core, poses[0], polytope.core, poses[1], options)
    assert (stages == SOLVER).mean() > 0.99


@pytest.mark.parametrize("name", ["cone", "doubling"])
def test_the_walk_decides_flat_stars_itself(name):
    """Coplanar vertices make degenerate games; the walk leaves none of these gaps to exact arithmetic."""
    solid, polytope = solid_of(name, 1000, 0)
    gaps = np.tile([1e-3, -1e-3], 1000)
    poses = contacts.contact_poses(solid, solid, gaps, np.random.default_rng(1))
    options = pair_options("walk", cached_plane=False, centre_axis=False, nearest_points=False)
    _, stages, _ = core.intersect_batch(polytope.core, poses[0], polytope.core, poses[1], options)
    assert (stages == SOLVER).all()


def test_methods_use_their_own_means():
    (_, P), (_, R) = solid_of("round", 1000, 1), solid_of("round", 1000, 2)
    pose = at(0.5, 0.5, 0.5)[None]
    counters = {
        method: core.intersect_batch(P.core, pose, R.core, np.eye(4)[None], pair_options(method, centre_axis=False))[2]
        for method in METHODS
    }
    assert counters["exact"]["rounds"] == 0
    assert counters["oracle"]["rounds"] > 0
    assert 0 < counters["walk"]["rounds"] <= P.statistics()["inner"]["levels"] + R.statistics()["polar"]["levels"] + 2


ROUNDED_AND_FLAT = [
    (pc.Polytope([[0.0, 0, 0]], inflation_radius=0.5), pc.Polytope([[0.0, 0, -1], [0, 0, 1]], inflation_radius=0.25)),
    (pc.Polytope([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), pc.Polytope([[0.0, 0, 0], [0, 0, 1], [0, 1, 1]])),
    (pc.Polytope(family("round", 60, 3), inflation_radius=0.1), pc.Polytope(family("flat", 60, 4))),
]


@pytest.mark.parametrize(("P", "R"), ROUNDED_AND_FLAT)
def test_nearest_points_change_no_verdict(P, R):
    rng = np.random.default_rng(5)
    turns = contacts.frames(contacts.random_directions(200, rng))
    poses = np.tile(np.eye(4), (200, 1, 1))
    poses[:, :3, :3] = turns
    poses[:, :3, 3] = rng.normal(size=(200, 3))
    still = np.eye(4)[None]
    verdicts, stages = {}, {}
    for on in (True, False):
        verdicts[on], stages[on], _ = core.intersect_batch(
            P.core, poses, R.core, still, pair_options("oracle", nearest_points=on, double_double=False)
        )
    assert (stages[True] == NEAREST_POINTS).any()
    assert not (stages[False] == NEAREST_POINTS).any()
    assert (stages[False] == EXACT).any()
    assert (verdicts[True] == verdicts[False]).all()
    truth = [
        exact_verdicts.intersects(
            P.vertices, R.vertices, p, still[0], inflation_p=P.inflation_radius, inflation_r=R.inflation_radius
        )
        for p in poses
    ]
    assert verdicts[True].astype(bool).tolist() == truth
    assert 0 < sum(truth) < len(truth)


# What stands behind the filter: nearest points in doubles, in double-double, and where these begin.
BEHIND = list(itertools.product((True, False), repeat=3))


def assert_stages_behind_the_filter_agree(P, R, poses_p, poses_r):
    """All switches against the oracle, in both orders; returns the stages by (double_double, warm_start)."""
    truth = [
        exact_verdicts.intersects(P.vertices, R.vertices, p, r, P.inflation_radius, R.inflation_radius)
        for p, r in zip(poses_p, poses_r, strict=True)
    ]
    stages = {}
    for nearest, fine, warm in BEHIND:
        options = pair_options(nearest_points=nearest, double_double=fine, warm_start=warm)
        shared, found, _ = core.intersect_batch(P.core, poses_p, R.core, poses_r, options)
        assert shared.astype(bool).tolist() == truth
        shared, _, _ = core.intersect_batch(R.core, poses_r, P.core, poses_p, options)
        assert shared.astype(bool).tolist() == truth
        assert fine or not (found == DOUBLE_DOUBLE).any()
        stages[fine, warm] = found
    return stages


@pytest.mark.parametrize(
    ("first", "second", "n", "inflation_radius"),
    [
        ("box", "round", 80, 0.0),
        ("cone", "needle", 200, 0.0),
        ("flat", "doubling", 300, 0.0),
        ("round", "box", 40, 0.25),
    ],
)
def test_stages_behind_the_filter_change_no_verdict(first, second, n, inflation_radius):
    (p, P), (r, R) = solid_of(first, n, 21), solid_of(second, n, 22)
    gaps = np.repeat([1e-13, 1e-15, 1e-17, 0.0, -1e-17, -1e-15, -1e-13], 4)
    poses_p, poses_r = contacts.contact_poses(p, r, gaps + inflation_radius, np.random.default_rng(n))
    if inflation_radius:
        P = pc.Polytope(P.vertices, inflation_radius=inflation_radius)
    stages = assert_stages_behind_the_filter_agree(P, R, poses_p, poses_r)
    assert (stages[True, True] == DOUBLE_DOUBLE).any()
    assert (stages[False, True] == EXACT).any()


@pytest.mark.parametrize(("first", "second"), [("box", "box"), ("lattice", "lattice"), ("lattice", "box")])
def test_exact_contacts_are_decided_from_the_vertices_that_filters_found(first, second):
    (p, P), (r, R) = solid_of(first, 60, 23), solid_of(second, 60, 24)
    poses_p, poses_r = dyadic_poses(p, r, 240, np.random.default_rng(25))
    stages = assert_stages_behind_the_filter_agree(P, R, poses_p, poses_r)
    assert (stages[True, True] == EXACT).any()


@pytest.mark.parametrize("power", [-60, -90, -120, -1000])
@pytest.mark.parametrize("unit", [1.0, 2.0**-40, 2.0**150])
def test_gaps_far_below_a_double_between_touching_boxes(power, unit):
    # A pose can hold a gap of any size beside a plane through the origin.
    cube, plate = pc.Polytope(UNIT * unit), pc.Polytope(UNIT[UNIT[:, 0] == 0] * unit)
    gap = unit * 2.0**power
    for other in (cube, plate):
        for sign in (1, 0, -1):
            poses = at(sign * gap)[None], at(-unit)[None] if other is cube else np.eye(4)[None]
            stages = assert_stages_behind_the_filter_agree(cube, other, *poses)
            if unit == 1.0 and sign > 0 and power >= -90:
                assert (stages[True, True] == DOUBLE_DOUBLE).all()
            if sign == 0:
                assert (stages[True, True] == EXACT).all()


@pytest.mark.parametrize("power", [-60, -85, -500])
def test_balls_and_capsules_whose_gaps_are_far_below_a_double(power):
    ball, capsule = (
        pc.Polytope([[0.0, 0, 0]], inflation_radius=3.0),
        pc.Polytope([[0.0, -1, 0], [0, 1, 0]], inflation_radius=2.0),
    )
    for sign in (1, 0, -1):
        capsule_poses = at(-5.0)[None]
        stages = assert_stages_behind_the_filter_agree(ball, capsule, at(sign * 2.0**power)[None], capsule_poses)
        assert (stages[True, True] == (DOUBLE_DOUBLE if sign != 0 and power > -90 else EXACT)).all()
