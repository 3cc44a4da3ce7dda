"""The pair test against exact arithmetic in Python integers: every method, every switch, every kind of contact."""

import itertools

import exact_verdicts
import numpy as np
import pytest
from pair_ways import CENTRE_AXIS, NEAR, PAIRS, UNIT, WAYS, assert_all_ways_agree
from poses import at
from solids import dyadic_poses, random_poses, solid_of

import plannercheck as pc
from plannercheck.bodies.tuning import METHODS, pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.stress import body_families as families
from plannercheck.evaluation.stress import contact_poses as contacts
from plannercheck.evaluation.stress.body_families import family
from plannercheck.evaluation.stress.contact_poses import Solid


@pytest.mark.parametrize(("first", "second", "n"), PAIRS)
def test_random_poses(first, second, n):
    (p, P), (r, R) = solid_of(first, n, 1), solid_of(second, n, 2)
    truth = assert_all_ways_agree(P, R, *random_poses(p, r, 24, np.random.default_rng(n)))
    assert 0 < truth.sum() < len(truth)


@pytest.mark.parametrize(("first", "second", "n"), PAIRS)
def test_near_contact(first, second, n):
    (p, P), (r, R) = solid_of(first, n, 3), solid_of(second, n, 4)
    gaps = np.repeat(NEAR, 2)
    truth = assert_all_ways_agree(P, R, *contacts.contact_poses(p, r, gaps, np.random.default_rng(n)))
    assert not truth[gaps >= 1e-9].any()
    assert truth.any()


@pytest.mark.parametrize(
    ("first", "second", "n"), [("box", "box", 8), ("lattice", "lattice", 60), ("lattice", "box", 200)]
)
def test_exact_contact(first, second, n):
    (p, P), (r, R) = solid_of(first, n, 5), solid_of(second, n, 6)
    truth = assert_all_ways_agree(P, R, *dyadic_poses(p, r, 40, np.random.default_rng(n)))
    assert truth.any()


@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e-12, 1e6])
@pytest.mark.parametrize("shift", [(1, 0, 0), (1, 0.5, 0.25), (1, 1, 0), (1, 1, 1), (0.25, 1, -0.5)])
def test_touching_boxes_collide_and_the_next_double_does_not(scale, shift):
    cube = pc.Polytope(UNIT * scale)
    shift = np.array(shift) * scale
    beyond = np.where(shift == scale, np.nextafter(shift, np.inf), shift)
    for method in METHODS:
        assert pc.intersects(cube, cube, at(*shift), method=method)
        assert not pc.intersects(cube, cube, at(*beyond), method=method)
        assert not pc.intersects(cube, cube, None, at(*-beyond), method=method) or (shift < 0).any()


@pytest.mark.parametrize("name", ["box", "round", "flat", "doubling", "lattice"])
def test_identical_and_nested_bodies_collide(name):
    points = family(name, 100, seed=1)
    whole = pc.Polytope(points)
    centre = whole.centre.ravel()
    core_of = pc.Polytope(centre + 1e-3 * (points - centre))
    turned = random_poses(*[Solid("", whole.vertices, whole.faces)] * 2, 1, np.random.default_rng(1))[0]
    for method in METHODS:
        for pose in (None, turned[0]):
            assert pc.intersects(whole, whole, pose, pose, method)
            assert pc.intersects(whole, core_of, pose, pose, method)
            assert pc.intersects(core_of, whole, pose, pose, method)


def test_a_common_vertex_edge_or_facet_is_a_contact():
    corner = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    first = pc.Polytope(corner)
    for mirrored in itertools.product((1, -1), repeat=3):
        second = pc.Polytope(corner * mirrored)
        for method in METHODS:
            assert pc.intersects(first, second, method=method)


@pytest.mark.parametrize("thickness", [1e-6, 1e-10, 1e-13])
def test_thin_bodies(thickness):
    sheet = pc.Polytope(family("box", 8, 1) * [1, 1, thickness])
    solid = Solid("sheet", sheet.vertices, sheet.faces.astype(np.int64))
    gaps = np.array([1e-3, thickness, thickness * 1e-3, 1e-16, 0, -thickness * 0.5])
    assert_all_ways_agree(sheet, sheet, *contacts.contact_poses(solid, solid, gaps, np.random.default_rng(2)))


@pytest.mark.parametrize("distance", [1e3, 1e6, 1e12])
def test_far_from_the_origin(distance):
    (p, P), (r, R) = solid_of("round", 40, 7), solid_of("box", 8, 8)
    rng = np.random.default_rng(3)
    poses_p, poses_r = contacts.contact_poses(p, r, np.array([1e-1, 1e-3, 0, -1e-3, -1e-1] * 3), rng)
    away = rng.normal(size=3) * distance
    poses_p[:, :3, 3] += away
    poses_r[:, :3, 3] += away
    assert_all_ways_agree(P, R, poses_p, poses_r)


def test_vertices_far_from_their_own_origin():
    rng = np.random.default_rng(4)
    offset = np.array([1e6, -3e5, 2e6])
    P, R = pc.Polytope(family("round", 80, 1) + offset), pc.Polytope(family("box", 8, 2))
    p, r = (Solid("", b.vertices, b.faces.astype(np.int64)) for b in (P, R))
    assert_all_ways_agree(P, R, *contacts.contact_poses(p, r, np.array([1e-1, 1e-8, 0, -1e-8, -1e-2] * 3), rng))


@pytest.mark.parametrize("defect", [1e-12, 1e-9, 9e-7])
def test_poses_off_rigid_are_the_affine_maps_that_they_are(defect):
    (p, P), (r, R) = solid_of("round", 100, 9), solid_of("lattice", 40, 9)
    rng = np.random.default_rng(5)
    gaps = np.concatenate([[1e-2, 3 * defect, defect, 1e-16, 0, -defect, -1e-2]] * 2)
    poses_p, poses_r = contacts.contact_poses(p, r, gaps, rng)
    for poses in (poses_p, poses_r):
        poses[:, :3, :3] += rng.uniform(-1, 1, (len(gaps), 3, 3)) * defect / 8
    assert_all_ways_agree(P, R, poses_p, poses_r)
    for pose_p, pose_r in zip(poses_p, poses_r, strict=True):
        assert pc.intersects(P, R, pose_p, pose_r) == exact_verdicts.intersects(P.vertices, R.vertices, pose_p, pose_r)


@pytest.mark.parametrize("name", ["cone", "prism", "doubling", "round"])
def test_large_bodies(name):
    points = families.degree_doubling(10)[0] if name == "doubling" else family(name, 3000, 1)
    (r, R) = solid_of("round", 300, 2)
    P = pc.Polytope(points)
    p = Solid(name, P.vertices, P.faces.astype(np.int64))
    gaps = np.array([1e-1, 1e-4, 1e-8, 1e-12, 0, -1e-12, -1e-6, -1e-2])
    assert_all_ways_agree(P, R, *contacts.contact_poses(p, r, gaps, np.random.default_rng(6)))


def test_neighbouring_poses_use_the_cached_plane_and_agree():
    (_, P), (_, R) = solid_of("round", 200, 1), solid_of("round", 200, 2)
    steps = np.linspace(1.05, 0.9, 200)
    poses = np.tile(np.eye(4), (200, 1, 1))
    poses[:, 0, 3], poses[:, 1, 3] = steps, 0.3 * np.sin(9 * steps)
    verdicts = {}
    for way in WAYS:
        shared, stages, _ = core.intersect_batch(
            P.core, poses, R.core, np.eye(4)[None], pair_options(way[0], cached_plane=way[1], centre_axis=way[2])
        )
        verdicts[way] = shared.tolist()
        assert (0 in stages) == (way[0] != "exact" and way[1])
    assert len({tuple(v) for v in verdicts.values()}) == 1


@pytest.mark.parametrize(("first", "second"), [("point", "point"), ("round", "point"), ("box", "needle")])
def test_bodies_within_their_inflation_radii(first, second):
    """Centres and nearest vertices join inflated bodies without a game; the same verdicts without that."""
    p, r = (np.zeros((1, 3)) if name == "point" else family(name, 40, 31) for name in (first, second))
    P, R = pc.Polytope(p, inflation_radius=0.3), pc.Polytope(r, inflation_radius=0.2)
    rng = np.random.default_rng(32)
    poses = contacts.identities(200)
    poses[:, :3, 3] = contacts.unit(rng.normal(size=(200, 3))) * rng.uniform(0, 2, size=(200, 1))
    poses[:4, :3, 3] = [[0.5, 0, 0], [np.nextafter(0.5, 1), 0, 0], [0, 0, 0], [0, np.nextafter(0.5, 0), 0]]
    fixed = np.eye(4)[None]
    truth = [
        exact_verdicts.intersects(P.vertices, R.vertices, pose, fixed[0], P.inflation_radius, R.inflation_radius)
        for pose in poses
    ]
    for centre_axis in (True, False):
        options = pair_options(centre_axis=centre_axis)
        shared, stages, _ = core.intersect_batch(P.core, poses, R.core, fixed, options)
        assert shared.astype(bool).tolist() == truth
        assert set(shared[stages == CENTRE_AXIS].tolist()) == ({0, 1} if centre_axis else set())


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        (np.eye(4) * np.nan, "pose_p.*not finite"),
        (at(np.inf), "pose_p.*not finite"),
        (np.eye(3), r"pose_p.*\(4, 4\)"),
        (np.diag([1.0, 1, 1 + 1e-5, 1]), "pose_p.*not rigid"),
        (np.diag([1.0, 1, -1, 1]), "pose_p"),
        (np.diag([2.0, 2, 2, 1]), "pose_p.*not rigid"),
        (np.diag([1.0, 1, 1, 2]), "pose_p.*last row"),
        ("up", "pose_p"),
    ],
)
def test_bad_poses_are_refused(pose, message):
    cube = pc.Polytope(UNIT)
    for test in (pc.intersects, pc.certify):
        with pytest.raises(pc.PlannercheckError, match=message):
            test(cube, cube, pose)
        with pytest.raises(pc.PlannercheckError, match=message.replace("pose_p", "pose_r")):
            test(cube, cube, None, pose)


def test_unknown_methods_are_named():
    cube = pc.Polytope(UNIT)
    with pytest.raises(pc.PlannercheckError, match="unknown method 'wlak': did you mean 'walk'"):
        pc.intersects(cube, cube, method="wlak")
