"""The pair test against exact arithmetic in Python integers: every method, every switch, every kind of contact."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest
from solids import solid_of

import plannercheck as pc
from plannercheck.bodies import exact_reference as exact
from plannercheck.bodies.intersection import METHODS, pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.stress import body_families as families
from plannercheck.evaluation.stress import contact_poses as contacts
from plannercheck.evaluation.stress.body_families import MESHES, family
from plannercheck.evaluation.stress.contact_poses import Solid

# All ways to decide a pair; the first is the default.
WAYS = list(itertools.product(METHODS, (True, False), (True, False)))
NEAR = (1e-1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-14, 1e-15, 1e-16, 0.0, -1e-16, -1e-15, -1e-13, -1e-9, -1e-4, -1e-1)
# Numbers of stages in cpp/narrow_phase/pair_frame.hpp.
CENTRE_AXIS, SOLVER, NEAREST_POINTS, DOUBLE_DOUBLE, EXACT = 1, 3, 4, 5, 6
UNIT = np.array(list(itertools.product((0.0, 1.0), repeat=3)))


def assert_all_ways_agree(first, second, poses_p, poses_r):
    """All methods and switches, in both orders, against the oracle; returns the verdicts."""
    truth = np.array(
        [exact.intersects(first.vertices, second.vertices, p, r) for p, r in zip(poses_p, poses_r, strict=True)]
    )
    poses_p, poses_r = np.ascontiguousarray(poses_p), np.ascontiguousarray(poses_r)
    for way in WAYS:
        options = pair_options(*way)
        shared, _, _ = core.intersect_batch(first.core, poses_p, second.core, poses_r, options)
        np.testing.assert_array_equal(shared.astype(bool), truth, err_msg=f"{way}")
        shared, _, _ = core.intersect_batch(second.core, poses_r, first.core, poses_p, options)
        np.testing.assert_array_equal(shared.astype(bool), truth, err_msg=f"{way} swapped")
    return truth


PAIRS = [
    ("box", "box", 8),
    ("box", "round", 80),
    ("round", "round", 30),
    ("round", "cloud", 200),
    ("flat", "needle", 40),
    ("flat", "flat", 100),
    ("prism", "cone", 60),
    ("fan", "doubling", 100),
    ("lattice", "lattice", 60),
    (MESHES[0], MESHES[2], 0),
    (MESHES[3], "box", 8),
]


@pytest.mark.parametrize(("first", "second", "n"), PAIRS)
def test_random_poses(first, second, n):
    (p, P), (r, R) = solid_of(first, n, 1), solid_of(second, n, 2)
    truth = assert_all_ways_agree(P, R, *contacts.random_poses(p, r, 24, np.random.default_rng(n)))
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
    truth = assert_all_ways_agree(P, R, *contacts.dyadic_poses(p, r, 40, np.random.default_rng(n)))
    assert truth.any()


def moved(x, y=0.0, z=0.0):
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e-12, 1e6])
@pytest.mark.parametrize("shift", [(1, 0, 0), (1, 0.5, 0.25), (1, 1, 0), (1, 1, 1), (0.25, 1, -0.5)])
def test_touching_boxes_collide_and_the_next_double_does_not(scale, shift):
    cube = pc.Polytope(UNIT * scale)
    shift = np.array(shift) * scale
    beyond = np.where(shift == scale, np.nextafter(shift, np.inf), shift)
    for method in METHODS:
        assert pc.intersects(cube, cube, moved(*shift), method=method)
        assert not pc.intersects(cube, cube, moved(*beyond), method=method)
        assert not pc.intersects(cube, cube, None, moved(*-beyond), method=method) or (shift < 0).any()


@pytest.mark.parametrize("name", ["box", "round", "flat", "doubling", "lattice"])
def test_identical_and_nested_bodies_collide(name):
    points = family(name, 100, seed=1)
    whole = pc.Polytope(points)
    centre = whole.centre.ravel()
    core_of = pc.Polytope(centre + 1e-3 * (points - centre))
    turned = contacts.random_poses(*[Solid("", whole.vertices, whole.faces)] * 2, 1, np.random.default_rng(1))[0]
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
        assert pc.intersects(P, R, pose_p, pose_r) == exact.intersects(P.vertices, R.vertices, pose_p, pose_r)


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
        shared, stages, _ = core.intersect_batch(P.core, poses, R.core, np.eye(4)[None], pair_options(*way))
        verdicts[way] = shared.tolist()
        assert (0 in stages) == (way[0] != "exact" and way[1])
    assert len({tuple(v) for v in verdicts.values()}) == 1


@pytest.mark.parametrize(("first", "second"), [("point", "point"), ("round", "point"), ("box", "needle")])
def test_bodies_within_their_swells(first, second):
    """Centres and nearest vertices join swollen bodies without a game; the same verdicts without that."""
    p, r = (np.zeros((1, 3)) if name == "point" else family(name, 40, 31) for name in (first, second))
    P, R = pc.Polytope(p, swell=0.3), pc.Polytope(r, swell=0.2)
    rng = np.random.default_rng(32)
    poses = contacts.identities(200)
    poses[:, :3, 3] = contacts.unit(rng.normal(size=(200, 3))) * rng.uniform(0, 2, size=(200, 1))
    poses[:4, :3, 3] = [[0.5, 0, 0], [np.nextafter(0.5, 1), 0, 0], [0, 0, 0], [0, np.nextafter(0.5, 0), 0]]
    fixed = np.eye(4)[None]
    truth = [exact.intersects(P.vertices, R.vertices, pose, fixed[0], P.swell, R.swell) for pose in poses]
    for centre_axis in (True, False):
        options = pair_options(centre_axis=centre_axis)
        shared, stages, _ = core.intersect_batch(P.core, poses, R.core, fixed, options)
        assert shared.astype(bool).tolist() == truth
        assert set(shared[stages == CENTRE_AXIS].tolist()) == ({0, 1} if centre_axis else set())


def test_the_point_of_spheres_is_in_both():
    P, R = pc.Polytope(np.zeros((1, 3)), swell=0.3), pc.Polytope(np.zeros((1, 3)), swell=0.2)
    for x in (0.0, 0.1, 0.4999):
        found = core.certify_pair(P.core, moved(x, 0, 0), R.core, np.eye(4), pair_options(), False)
        assert found["stage"] == "centre axis"
        assert np.linalg.norm(found["point"] - [x, 0, 0]) <= P.swell
        assert np.linalg.norm(found["point"]) <= R.swell


@pytest.mark.parametrize("scale", [1.0, 1e-3, 3e5])
@pytest.mark.parametrize(
    ("options", "stage"),
    [
        ({}, "nearest points"),
        ({"nearest_points": False}, "double-double"),
        ({"nearest_points": False, "double_double": False}, "exact"),
    ],
)
def test_the_point_of_two_swollen_bodies_is_in_both(options, stage, scale):
    """Their hulls are apart by nearly both swells, which differ: it divides that way as the swells do."""
    rng = np.random.default_rng(36)
    names = [("point", "box"), ("needle", "round"), ("segment", "segment"), ("flat", "point")]
    for (first, second), swells in itertools.product(names, ((0.3, 0.02), (0.01, 0.4), (0.2, 0.2), (0.25, 0.0))):
        points = [
            families.THIN_FAMILIES[name](20, rng) if name in families.THIN_FAMILIES else family(name, 20, 37)
            for name in (first, second)
        ]
        bodies = [pc.Polytope(p * scale, swell=s * scale) for p, s in zip(points, swells, strict=True)]
        pose_p, pose_r = contacts.identities(2)
        pose_p[:3, :3], pose_r[:3, :3] = contacts.frames(contacts.random_directions(2, rng))
        pose_p[:3, 3] = 9 * scale * contacts.random_directions(1, rng)[0]
        apart = pc.distance(*bodies, pose_p, pose_r)
        pose_p[:3, 3] += (1 + 0.01 * sum(swells) * scale / apart.distance) * (apart.point_r - apart.point_p)
        for a, b in ((0, 1), (1, 0)):
            poses = [pose_p, pose_r] if a == 0 else [pose_r, pose_p]
            arguments = bodies[a].core, poses[0], bodies[b].core, poses[1]
            found = core.certify_pair(*arguments, pair_options(centre_axis=False, **options), False)
            assert (found["shared"], found["stage"]) == (True, stage)
            for body, pose in zip((bodies[a], bodies[b]), poses, strict=True):
                beyond = exact.distance(found["point"][None], body.vertices, None, pose, swell_r=body.swell)
                assert beyond <= 1e-13 * scale


def test_a_plane_found_by_balls_is_no_wider_than_the_host():
    """Kept for the next pose, it must not separate bodies that overlap on the same side."""
    (_, P), (_, R) = solid_of("round", 80, 33), solid_of("box", 8, 34)
    directions = contacts.unit(np.random.default_rng(35).normal(size=(60, 3)))
    poses = contacts.identities(120)
    poses[0::2, :3, 3], poses[1::2, :3, 3] = 3 * directions, 0.7 * directions
    truth = [exact.intersects(P.vertices, R.vertices, pose, np.eye(4)) for pose in poses]
    assert sum(truth) > 30
    for a, b in ((P, R), (R, P)):
        turned = poses if a is P else np.linalg.inv(poses)
        shared, stages, _ = core.intersect_batch(a.core, turned, b.core, np.eye(4)[None], pair_options())
        assert shared.astype(bool).tolist() == truth
        assert (stages[0::2] == CENTRE_AXIS).all()


@pytest.mark.parametrize(("name", "n"), [("box", 8), ("prism", 12), ("round", 60), ("needle", 60), ("cone", 1000)])
def test_the_oracle_decides_clear_gaps_itself(name, n):
    """Its games may lose their way without a wrong verdict: then later stages would decide."""
    solid, polytope = solid_of(name, n, 0)
    gaps = np.tile([1e-1, 1e-3, -1e-3, -1e-1], 250)
    poses = contacts.contact_poses(solid, solid, gaps, np.random.default_rng(2))
    options = pair_options("oracle", cached_plane=False, centre_axis=False, facet_plane=False)
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
    pose = moved(0.5, 0.5, 0.5)[None]
    counters = {
        method: core.intersect_batch(P.core, pose, R.core, np.eye(4)[None], pair_options(method, centre_axis=False))[2]
        for method in METHODS
    }
    assert counters["exact"]["rounds"] == 0
    assert counters["oracle"]["rounds"] > 0
    assert 0 < counters["walk"]["rounds"] <= P.statistics()["inner"]["levels"] + R.statistics()["polar"]["levels"] + 2


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        (np.eye(4) * np.nan, "pose_p.*not finite"),
        (moved(np.inf), "pose_p.*not finite"),
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


def posed_fractions(vertices, pose):
    matrix = [[Fraction(x) for x in row] for row in pose.tolist()]
    return [
        [sum(m * Fraction(x) for m, x in zip(row, v, strict=False)) + row[3] for row in matrix[:3]]
        for v in vertices.tolist()
    ]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("first", "second", "n"), PAIRS[:9])
def test_certificates_prove_their_verdicts(first, second, n, method):
    (p, P), (r, R) = solid_of(first, n, 11), solid_of(second, n, 12)
    for pose_p, pose_r in zip(*contacts.contact_poses(p, r, np.array(NEAR), np.random.default_rng(n)), strict=True):
        certificate = pc.certify(P, R, pose_p, pose_r, method)
        truth = exact.intersects(P.vertices, R.vertices, pose_p, pose_r)
        assert isinstance(certificate, pc.SharedPoint) == truth
        if truth:
            assert_shared(certificate.point, P, R, pose_p, pose_r)
        else:
            assert_separates(certificate, P, R, pose_p, pose_r)


def assert_separates(plane, P, R, pose_p, pose_r):
    """The exact plane separates; its gap, from below, is one of the distance."""
    assert plane.verify()
    normal = plane.exact().normal
    above = min(sum(a * b for a, b in zip(normal, v, strict=True)) for v in posed_fractions(P.vertices, pose_p))
    below = max(sum(a * b for a, b in zip(normal, v, strict=True)) for v in posed_fractions(R.vertices, pose_r))
    assert above > below
    assert (above - below) ** 2 >= Fraction(plane.gap) ** 2 * sum(x * x for x in normal)
    assert plane.gap <= exact.distance(P.vertices, R.vertices, pose_p, pose_r) * (1 + 1e-15)


def assert_shared(point, P, R, pose_p, pose_r):
    """The point is in both bodies, up to the rounding of posing and mixing it."""
    for body, pose in ((P, pose_p), (R, pose_r)):
        size = np.abs(body.vertices).max() + np.abs(pose[:3, 3]).max()
        ball = 1e-14 * size * (UNIT * 2 - 1)
        assert exact.intersects(point + ball, body.vertices, None, pose)


def test_a_separations_normal_points_from_second_to_first():
    cube = pc.Polytope(UNIT)
    for method in METHODS:
        plane = pc.certify(cube, cube, moved(3), None, method)
        assert plane.normal[0] > 0.5
        assert 1.0 < plane.offset < 3.0
        assert 0 < plane.gap <= 2.0
        assert pc.certify(cube, cube, None, moved(3), method).normal[0] < -0.5


ROUNDED_AND_FLAT = [
    (pc.Polytope([[0.0, 0, 0]], swell=0.5), pc.Polytope([[0.0, 0, -1], [0, 0, 1]], swell=0.25)),
    (pc.Polytope([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), pc.Polytope([[0.0, 0, 0], [0, 0, 1], [0, 1, 1]])),
    (pc.Polytope(family("round", 60, 3), swell=0.1), pc.Polytope(family("flat", 60, 4))),
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
    truth = [exact.intersects(P.vertices, R.vertices, p, still[0], swell_p=P.swell, swell_r=R.swell) for p in poses]
    assert verdicts[True].astype(bool).tolist() == truth
    assert 0 < sum(truth) < len(truth)


# What stands behind the filter: nearest points in doubles, in double-double, and where these begin.
BEHIND = list(itertools.product((True, False), repeat=3))


def assert_stages_behind_the_filter_agree(P, R, poses_p, poses_r):
    """All switches against the oracle, in both orders; returns the stages by (double_double, warm_start)."""
    truth = [
        exact.intersects(P.vertices, R.vertices, p, r, P.swell, R.swell) for p, r in zip(poses_p, poses_r, strict=True)
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
    ("first", "second", "n", "swell"),
    [
        ("box", "round", 80, 0.0),
        ("cone", "needle", 200, 0.0),
        ("flat", "doubling", 300, 0.0),
        ("round", "box", 40, 0.25),
    ],
)
def test_stages_behind_the_filter_change_no_verdict(first, second, n, swell):
    (p, P), (r, R) = solid_of(first, n, 21), solid_of(second, n, 22)
    gaps = np.repeat([1e-13, 1e-15, 1e-17, 0.0, -1e-17, -1e-15, -1e-13], 4)
    poses_p, poses_r = contacts.contact_poses(p, r, gaps + swell, np.random.default_rng(n))
    if swell:
        P = pc.Polytope(P.vertices, swell=swell)
    stages = assert_stages_behind_the_filter_agree(P, R, poses_p, poses_r)
    assert (stages[True, True] == DOUBLE_DOUBLE).any()
    assert (stages[False, True] == EXACT).any()


@pytest.mark.parametrize(("first", "second"), [("box", "box"), ("lattice", "lattice"), ("lattice", "box")])
def test_exact_contacts_are_decided_from_the_vertices_that_filters_found(first, second):
    (p, P), (r, R) = solid_of(first, 60, 23), solid_of(second, 60, 24)
    poses_p, poses_r = contacts.dyadic_poses(p, r, 240, np.random.default_rng(25))
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
            poses = moved(sign * gap)[None], moved(-unit)[None] if other is cube else np.eye(4)[None]
            stages = assert_stages_behind_the_filter_agree(cube, other, *poses)
            if unit == 1.0 and sign > 0 and power >= -90:
                assert (stages[True, True] == DOUBLE_DOUBLE).all()
            if sign == 0:
                assert (stages[True, True] == EXACT).all()


@pytest.mark.parametrize("power", [-60, -85, -500])
def test_balls_and_capsules_whose_gaps_are_far_below_a_double(power):
    ball, capsule = pc.Polytope([[0.0, 0, 0]], swell=3.0), pc.Polytope([[0.0, -1, 0], [0, 1, 0]], swell=2.0)
    for sign in (1, 0, -1):
        capsule_poses = moved(-5.0)[None]
        stages = assert_stages_behind_the_filter_agree(ball, capsule, moved(sign * 2.0**power)[None], capsule_poses)
        assert (stages[True, True] == (DOUBLE_DOUBLE if sign != 0 and power > -90 else EXACT)).all()


@pytest.mark.parametrize("power", [-60, -90, -300])
def test_certificates_of_gaps_far_below_a_double(power):
    cube = pc.Polytope(UNIT)
    slanted = np.eye(4)
    slanted[:3, :3] = contacts.frames(np.array([[1.0, 2.0, 3.0]]) / np.sqrt(14))[0]
    for turn in (np.eye(4), slanted):
        for sign in (1, 0, -1):
            certificate = pc.certify(cube, cube, turn @ moved(sign * 2.0**power), turn @ moved(-1.0))
            assert certificate.verify()
            if turn is not slanted:
                assert isinstance(certificate, pc.Separation) == (sign > 0)


@pytest.mark.parametrize("power", [-60, -90])
def test_the_plane_of_double_double_is_exact(power):
    cube = pc.Polytope(UNIT)
    found = core.certify_pair(cube.core, moved(2.0**power), cube.core, moved(-1.0), pair_options(), True)
    assert found["stage"] == "double-double"
    assert not found["shared"]
    assert len(found["exact_normal"]) == 3
