"""The algorithm in the plane against brute force on integers, and its certificates."""

import numpy as np
import planar_cases as cases
import pytest
from planar_brute_force import share_point

import plannercheck as pc
from plannercheck.common.errors import PlannercheckError
from plannercheck.planar.convexity import convexity_fault
from plannercheck.planar.polygons import METHODS, Polygons

# A pair of a million vertices each takes at most this many rounds: one for each halving of a chain, and the last.
MOST_ROUNDS = 40


def draws(make, count, seed):
    rng = np.random.default_rng(seed)
    return [make(rng) for _ in range(count)]


def verdicts(pairs, method="filtered"):
    a, b, poses_a, poses_b = zip(*pairs, strict=True)
    return pc.planar.intersects_batch(list(a), list(b), np.array(poses_a), np.array(poses_b), method=method)


@pytest.mark.parametrize(
    ("make", "count"),
    [
        (cases.random_pair, 800),
        (lambda rng: cases.random_pair(rng, cases.FLAT), 800),
        (cases.near_pair, 1500),
        (lambda rng: cases.near_pair(rng, 60), 100),
        (lambda rng: cases.near_pair(rng, kinds=cases.FLAT[1:] + cases.ROUND), 500),
        (cases.exact_contact, 500),
        (cases.nested_pair, 200),
    ],
    ids=["random", "flat", "near", "larger", "flat near", "grid", "nested"],
)
def test_verdicts_are_those_of_integers(make, count):
    pairs = draws(make, count, 7)
    truth = [share_point(*pair) for pair in pairs]
    for method in METHODS:
        assert verdicts(pairs, method).tolist() == truth


@pytest.mark.parametrize("n", [6, 15, 16, 17, 1000])
def test_the_start_saves_rounds_and_changes_no_verdict(n):
    """Exact signs start at thirds, doubles where sixteen vertices of each polygon face the other."""
    rng = np.random.default_rng(n)
    poses = np.array([cases.rotation(angle) for angle in rng.uniform(0, 2 * np.pi, 200)])
    poses[:, :2, 2] = poses[:, :2, 0] * rng.uniform(1.3, 2.1, size=(200, 1))
    polygon = cases.regular(n, 0.7)
    plain, started = (pc.planar.count_batch(polygon, polygon, None, poses, method=m) for m in ("exact", "filtered"))
    assert (plain.shared == started.shared).all()
    assert 0 < started.shared.mean() < 1
    assert started.rounds.sum() < 0.6 * plain.rounds.sum()


def test_near_contact_reaches_every_stage():
    a, b, poses_a, poses_b = zip(*draws(cases.exact_contact, 100, 3), strict=True)
    counts = pc.planar.count_batch(list(a), list(b), np.array(poses_a), np.array(poses_b))
    assert counts.double_double.any()
    assert counts.exact.any()
    assert 0 < counts.shared.mean() < 1
    assert not (counts.double_double[counts.exact == 0] == 0).all()


@pytest.mark.parametrize("scale", [2.0**-660, 2.0**-200, 2.0**-10, 2.0**130, 2.0**500])
def test_any_scale(scale):
    pairs = draws(cases.near_pair, 60, 11)
    for a, b, pose_a, pose_b in pairs:
        for pose in (pose_a, pose_b):
            pose[:2, 2] *= scale
        scaled = a * scale, b * scale, pose_a, pose_b
        assert pc.planar.intersects(*scaled) == share_point(*scaled)


def test_scales_that_have_nothing_in_common():
    """Coordinates from subnormal to 1e290 in one pair, some with a corner on a corner."""
    rng = np.random.default_rng(0)
    scales = [1e-310, 1e-150, 1e-60, 1.0, 1e60, 1e150, 1e290]
    shared = 0
    for k in range(200):
        a, b = (cases.ellipse(rng, int(rng.integers(3, 7))) * rng.choice(scales, 2) for _ in range(2))
        poses = [cases.rotation(rng.choice([0, np.pi / 2, rng.uniform(0, 6)])) for _ in range(2)]
        for pose in poses:
            pose[:2, 2] = rng.normal(size=2) * rng.choice(scales, 2)
        if k % 2:
            poses[1][:2, 2] = poses[0][:2] @ [*a[0], 1.0] - poses[1][:2, :2] @ b[1]
        if convexity_fault(a) or convexity_fault(b):
            continue
        truth = share_point(a, b, *poses)
        assert all(pc.planar.intersects(a, b, *poses, method=method) == truth for method in METHODS)
        shared += truth
    assert 20 < shared < 180


def test_large_polygons_in_logarithmic_rounds():
    rng = np.random.default_rng(5)
    polygon = cases.regular(10**6, 0.7)
    poses = np.array([cases.rotation(angle) for angle in rng.uniform(0, 7, 200)])
    poses[:, :2, 2] = 1.7 * poses[:, :2, 0]
    counts = pc.planar.count_batch(polygon, polygon, None, poses)
    assert counts.rounds.max() <= MOST_ROUNDS
    exact = pc.planar.intersects_batch(polygon, polygon, None, poses, method="exact")
    assert (counts.shared == exact).all()


def test_large_polygons_close_by():
    """A corner of one against a corner of the other, on the axes, where the truth is plain."""
    polygon = cases.regular(10**5)
    polygon[50_000, 1] = 0
    pose = np.eye(3)
    for step, truth in ((0.0, True), (2.0**-51, False), (-(2.0**-51), True)):
        pose[0, 2] = polygon[:, 0].max() - polygon[:, 0].min() + step
        assert pc.planar.intersects(polygon, polygon, None, pose) is truth
        assert pc.planar.certify(polygon, polygon, None, pose).verify()


def test_long_run_hides_the_turn():
    """All but one vertex on a line: the way round is found in a few probes, wherever the array starts."""
    run = np.column_stack([np.arange(1000.0), np.zeros(1000)])
    triangle = np.vstack([run, [[500.0, 800.0]]])
    probe = np.array([[500.0, 1.0]])
    for start in range(0, 1001, 37):
        for polygon in (np.roll(triangle, start, axis=0), np.roll(triangle, start, axis=0)[::-1].copy()):
            counts = pc.planar.count_batch(probe, polygon)
            assert counts.shared.all()
            assert counts.vertices[0] < 200
            assert not pc.planar.intersects(probe, polygon, np.array([[1.0, 0, 0], [0, 1, -1.5], [0, 0, 1]]))


@pytest.mark.parametrize("make", [cases.random_pair, cases.near_pair, cases.exact_contact, cases.nested_pair])
def test_certificates(make):
    for a, b, pose_a, pose_b in draws(make, 100, 13):
        certificate = pc.planar.certify(a, b, pose_a, pose_b)
        assert isinstance(certificate, pc.planar.SharedPoint) == pc.planar.intersects(a, b, pose_a, pose_b)
        assert certificate.verify()


def test_false_certificates_do_not_verify():
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    pose = np.eye(3)
    pose[0, 2] = 3
    apart = pc.planar.certify(square, square, None, pose)
    assert isinstance(apart, pc.planar.Separation)
    assert apart.gap == 2
    assert np.array_equal(apart.normal, [-1, 0])
    assert not pc.planar.Separation(-apart.normal, apart.offset, apart.gap, apart.plane).verify()
    assert not pc.planar.Separation(apart.normal, apart.offset, 2.5, apart.plane).verify()
    shared = pc.planar.certify(square, square)
    assert not pc.planar.SharedPoint(shared.point + 3, shared.first, shared.second, shared.place).verify()


def test_prisms_in_space_agree():
    """Prisms of equal height over two polygons share a point if and only if the polygons do."""
    kinds = (cases.ellipse, cases.sliver)
    pairs = [*draws(lambda rng: cases.near_pair(rng, kinds=kinds), 60, 17), *draws(cases.exact_contact, 60, 19)]
    found = verdicts(pairs)
    for (a, b, pose_a, pose_b), shared in zip(pairs, found, strict=True):
        p, r = (pc.Polytope(np.vstack([np.insert(v, 2, z, axis=1) for z in (0.0, 1.0)])) for v in (a, b))
        poses = [np.insert(np.insert(pose, 2, 0, axis=0), 2, 0, axis=1) for pose in (pose_a, pose_b)]
        for pose in poses:
            pose[2, 2] = 1
        for method in ("oracle", "walk", "exact"):
            assert pc.intersects(p, r, *poses, method=method) == shared
    assert 0 < found.mean() < 1


def test_batch_takes_single_and_many():
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    poses = np.array([cases.rotation(0.0)] * 3)
    poses[:, 0, 2] = 0.5, 1.0, 1.5
    assert pc.planar.intersects_batch(square, square, None, poses).tolist() == [True, True, False]
    assert pc.planar.intersects_batch([square] * 3, square, poses).tolist() == [True, True, False]
    assert pc.planar.intersects_batch([square, square + 2], square).tolist() == [True, False]
    assert pc.planar.intersects_batch([], square).tolist() == []
    with pytest.raises(pc.PlannercheckError, match="equally many"):
        pc.planar.intersects_batch([square] * 2, square, poses)


def test_closing_vertex_is_dropped():
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1], [0, 0]])
    assert pc.planar.intersects(square, square[:1], validate=True)
    assert not pc.planar.intersects(square, square + 1.5)


@pytest.mark.parametrize(
    ("vertices", "message"),
    [
        ([[0, 0], [1, 0], [0.2, 0.2], [0, 1]], "turns the other way at vertex 2"),
        ([[0, 0], [1, 0], [1, 0], [0, 1]], "vertex 1 is repeated"),
        ([[0, 0], [1, np.nan], [0, 1]], "vertex 1 is not finite"),
        (cases.regular(5)[[0, 2, 4, 1, 3]], "more than once"),
        ([[0, 0], [2, 0], [1, 0], [3, 0]], "more than once"),
        (np.zeros((0, 2)), "n > 0"),
        (np.zeros((3, 3)), r"\(n, 2\)"),
    ],
)
def test_faults_are_named(vertices, message):
    with pytest.raises(pc.PlannercheckError, match=message):
        pc.planar.intersects(vertices, [[0, 0]], validate=True)


def test_convexity_is_exact():
    nearly = np.array([[0.0, 0], [1, 0], [0.5, 0.5 + 2.0**-53], [0, 1]])
    assert convexity_fault(nearly) is None
    nearly[2] = 0.5, 0.5 - 2.0**-54
    assert convexity_fault(nearly) is not None
    for make in cases.ROUND + cases.FLAT:
        for seed in range(20):
            assert (
                convexity_fault(cases.shuffled(np.random.default_rng(seed), make(np.random.default_rng(seed), 9)))
                is None
            )


def test_not_finite_is_an_error():
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, np.inf]])
    with pytest.raises(pc.PlannercheckError, match="finite"):
        pc.planar.intersects(square, square)


@pytest.mark.parametrize(
    ("change", "message"),
    [((0, 0, 1.1), "rigid"), ((0, 0, -1.0), "rigid"), ((2, 0, 1.0), "last row"), ((0, 2, np.nan), "finite")],
)
def test_poses_must_be_rigid(change, message):
    pose = np.eye(3)
    pose[change[0], change[1]] = change[2]
    with pytest.raises(pc.PlannercheckError, match=message):
        pc.planar.intersects([[0, 0]], [[0, 0]], pose)


def test_repeated_vertices_change_no_verdict():
    rng = np.random.default_rng(19)
    differs = 0
    for _ in range(600):
        polygons = [ellipse_like(rng, int(rng.integers(3, 12))) for _ in range(2)]
        shift = rng.normal(size=2) * 0.9
        a, b = polygons[0], polygons[1] + shift
        repeated = [np.repeat(p, rng.integers(1, 5, size=len(p)), axis=0) for p in (a, b)]
        truth = pc.planar.intersects(a, b)
        assert pc.planar.intersects(*repeated) == truth
        assert pc.planar.intersects_batch([repeated[0]], [repeated[1]]).tolist() == [truth]
        assert pc.planar.intersects_batch(Polygons([repeated[0]]), Polygons([repeated[1]])).tolist() == [truth]
        differs += pc.planar.intersects(*repeated, scan=False) != truth
    assert differs, "repeated vertices mislead the algorithm, or this test says nothing"


def ellipse_like(rng, n):
    angles = np.sort(rng.uniform(0, 2 * np.pi, n))
    return np.stack([np.cos(angles), np.sin(angles)], axis=1) * rng.uniform(0.2, 1, size=2)


@pytest.mark.parametrize("n", [3, 100, 5000])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_no_number_that_is_none_goes_unseen(n, bad):
    angles = np.linspace(0, 2 * np.pi, n, endpoint=False)
    polygon = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for k in {0, n // 3, n // 2, n - 1}:
        broken = polygon.copy()
        broken[k, 1] = bad
        for ask in (
            lambda broken=broken: pc.planar.intersects(broken, polygon),
            lambda broken=broken: pc.planar.intersects_batch(polygon, [broken, polygon]),
            lambda broken=broken: Polygons([broken]),
        ):
            with pytest.raises(PlannercheckError, match=f"vertex {k} is .*must be finite"):
                ask()
