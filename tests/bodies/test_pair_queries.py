"""Queries on pairs through the core's own checks, held against those in Python: verdicts, distances, errors."""

import itertools
import pickle

import numpy as np
import pytest
from poses import at, random_pose

import plannercheck as pc
from plannercheck.bodies.distance import pair_bounds, pair_bounds_checked
from plannercheck.bodies.given_bodies import queries
from plannercheck.bodies.intersection import intersects_checked
from plannercheck.bodies.shapes import RIGID_TOLERANCE, _checked_matrix, checked_pose
from plannercheck.bodies.tuning import pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.stress.body_families import family

CUBE = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
POINTS = {"cube": CUBE, "round": family("round", 60, 1), "flat": CUBE[:4], "point": CUBE[:1]}
BODIES = {name: pc.Polytope(points, inflation_radius=0.1 * (name == "point")) for name, points in POINTS.items()}


def read_only(pose):
    pose = pose.copy()
    pose.setflags(write=False)
    return pose


class Subclass(np.ndarray):
    """NumPy arrays of a class of their own."""


def odd_address(pose):
    memory = np.zeros(pose.nbytes + 1, dtype=np.uint8)
    memory[1:] = np.frombuffer(pose.tobytes(), dtype=np.uint8)
    return memory[1:].view(np.float64).reshape(pose.shape)


# The same numbers in other forms; some are rounded to floats.
FORMS = {
    "as it is": lambda pose: pose,
    "Fortran": np.asfortranarray,
    "backwards": lambda pose: pose[..., ::-1, ::-1].copy()[..., ::-1, ::-1],
    "every other": lambda pose: np.repeat(np.repeat(pose, 2, axis=-1), 2, axis=-2)[..., ::2, ::2],
    "read only": read_only,
    "list": lambda pose: pose.tolist(),
    "float32": lambda pose: pose.astype(np.float32),
    "other byte order": lambda pose: pose.astype(">f8"),
    "subclass": lambda pose: pose.view(Subclass),
    "odd address": odd_address,
}


def with_entry(row, column, value):
    def changed(pose):
        pose = pose.copy()
        pose[..., row, column] = value
        return pose

    return changed


def stretched(factor):
    def changed(pose):
        pose = pose.copy()
        pose[..., :3, :3] *= 1 + factor
        return pose

    return changed


def reflected(pose):
    pose = pose.copy()
    pose[..., :3, 0] *= -1
    return pose


def sheared(pose):
    shear = np.eye(3)
    shear[0, 1] = 1.001 * RIGID_TOLERANCE / np.sqrt(2)  # which makes two entries of M^T M - 1
    pose = pose.copy()
    pose[..., :3, :3] = pose[..., :3, :3] @ shear
    return pose


# One stretch of s makes |M^T M - 1| = 2 sqrt(3) s.
AT_TOLERANCE = RIGID_TOLERANCE / (2 * np.sqrt(3))
FAULTS = {
    "not finite": with_entry(0, 0, np.nan),
    "translation not finite": with_entry(1, 3, np.inf),
    "translation NaN": with_entry(2, 3, np.nan),
    "last row": with_entry(3, 0, 1e-9),
    "last entry": with_entry(3, 3, 2.0),
    "last row NaN": with_entry(3, 1, np.nan),
    "reflection": reflected,
    "zeros": lambda pose: np.zeros_like(pose),
    "off rigid": stretched(1.001 * AT_TOLERANCE),
    "sheared": sheared,
    "wide": lambda pose: pose[..., :3, :],
    "vector": lambda pose: pose[..., 0, 0],
    "text": lambda pose: np.full(pose.shape, "a"),
    "objects": lambda pose: np.full(pose.shape, {}),
}


def error_of(call, *arguments, **named):
    with pytest.raises(Exception) as caught:  # noqa: PT011  # whatever Python's checks raise
        call(*arguments, **named)
    return type(caught.value), str(caught.value)


def shared_plainly(P, R, pose_p, pose_r):
    """By the checks in Python alone."""
    poses = [np.ascontiguousarray(_checked_matrix(pose, "it", RIGID_TOLERANCE)) for pose in (pose_p, pose_r)]
    return core.certify_pair(P.core, poses[0], R.core, poses[1], pair_options(), False)["shared"]


@pytest.mark.parametrize("form", FORMS)
def test_poses_in_any_form_give_the_verdict_of_their_numbers(form):
    rng = np.random.default_rng(1)
    for P, R in itertools.product(BODIES.values(), repeat=2):
        for _ in range(5):
            turned, b = random_pose(rng), FORMS[form](random_pose(rng))
            a = FORMS[form](turned.copy())
            turned[:3, 3] = 0  # a rotation alone is rigid by columns, too
            alone = FORMS[form](turned)
            assert pc.intersects(P, pc.Placed(R, b), alone) is shared_plainly(P, R, alone, b)
            expected = shared_plainly(P, R, a, b)
            assert pc.intersects(P, R, a, b) is expected
            assert intersects_checked(P, R, a, b) is expected
            assert pc.intersects(P, R, pose_r=b) is shared_plainly(P, R, np.eye(4), b)
            assert (pc.distance(P, R, a, b).distance == 0) == expected


def test_what_the_core_takes_at_once():
    """Speed: that these forms are looked at by the core, and that no other is."""
    pose, P = random_pose(np.random.default_rng(2)), BODIES["cube"]
    at_once = {form for form, make in FORMS.items() if queries.intersects(P, P, make(pose), None, 1) is not None}
    assert at_once == {"as it is", "Fortran", "backwards", "every other", "read only", "odd address"}
    assert {form for form, make in FORMS.items() if core.is_surely_rigid(make(pose), RIGID_TOLERANCE)} == at_once


@pytest.mark.parametrize("call", [pc.intersects, pc.certify, pc.distance, pc.signed_distance, pc.depth])
@pytest.mark.parametrize("fault", FAULTS)
def test_errors_are_those_of_the_checks_in_python(call, fault):
    rng = np.random.default_rng(3)
    P, R = BODIES["cube"], BODIES["flat"]
    for form in ("as it is", "Fortran", "read only"):
        bad, good = FORMS[form](FAULTS[fault](random_pose(rng))), random_pose(rng)
        for poses, name in (((bad, good), "pose_p"), ((good, bad), "pose_r")):
            expected = error_of(_checked_matrix, bad, name, RIGID_TOLERANCE)
            assert error_of(call, P, R, *poses) == expected
    assert error_of(pc.Placed, P, bad) == error_of(_checked_matrix, bad, "a placed body", RIGID_TOLERANCE)


def is_taken(pose):
    try:
        _checked_matrix(pose, "it", RIGID_TOLERANCE)
    except pc.PlannercheckError:
        return False
    return True


def test_poses_near_the_tolerance_are_judged_in_python():
    rng = np.random.default_rng(4)
    P, R, accepted = BODIES["cube"], BODIES["round"], 0
    for part in [*rng.uniform(0.999999, 1.000001, 200), *rng.uniform(0, 1.5, 300)]:
        pose = stretched(part * AT_TOLERANCE)(random_pose(rng))
        if core.is_surely_rigid(pose, RIGID_TOLERANCE):
            accepted += 1
            assert np.array_equal(_checked_matrix(pose, "it", RIGID_TOLERANCE), pose)
        if is_taken(pose):
            assert pc.intersects(P, R, pose) is shared_plainly(P, R, pose, np.eye(4))
        else:
            expected = error_of(_checked_matrix, pose, "pose_p", RIGID_TOLERANCE)
            assert error_of(pc.intersects, P, R, pose) == expected
    assert accepted > 100


def test_random_matrices_are_surely_rigid_only_if_python_takes_them():
    rng = np.random.default_rng(5)
    for tolerance in (RIGID_TOLERANCE, 3.6e-6, 1e-13):
        for exponent in rng.uniform(-14, 2, 2000):
            pose = random_pose(rng)
            pose[:3, :3] += rng.normal(size=(3, 3)) * 10**exponent
            pose[:3, 3] *= 10.0 ** rng.integers(-300, 300)
            pose[rng.integers(4), rng.integers(4)] *= rng.choice([1, 1, 1, -1, 0])
            if core.is_surely_rigid(pose, tolerance):
                _checked_matrix(pose, "it", tolerance)
    assert not core.is_surely_rigid(np.eye(4), 1e-13)  # rounding may be as large


def test_checked_poses_keep_their_numbers_and_belong_to_nobody_else():
    pose = random_pose(np.random.default_rng(6))
    for form in FORMS.values():
        given = form(pose)
        checked = checked_pose(given, "it")
        assert np.array_equal(checked, np.asarray(given, dtype=np.float64))
        assert not checked.flags.writeable
        assert type(checked) is np.ndarray
        assert not np.shares_memory(checked, given) or not isinstance(given, np.ndarray)


def test_bodies_that_are_no_polytopes_are_made_into_some():
    class Named(pc.Polytope):
        pass

    pose = at(1.0)
    for body in (CUBE, pc.Box((1, 1, 1)), Named(CUBE), CUBE.tolist()):
        assert pc.intersects(body, BODIES["cube"], pose)
        assert pc.intersects(BODIES["cube"], body, pose_r=pose)
    assert error_of(pc.intersects, None, BODIES["cube"])[0] is pc.PlannercheckError
    assert error_of(pc.intersects, pc.Polytope.__new__(pc.Polytope), BODIES["cube"])[0] is AttributeError


@pytest.mark.parametrize("method", ["oracle", "walk", "exact"])
def test_methods_agree(method):
    rng = np.random.default_rng(7)
    for _ in range(20):
        a, b = random_pose(rng), random_pose(rng)
        assert pc.intersects(BODIES["cube"], BODIES["round"], a, b, method) is shared_plainly(
            BODIES["cube"], BODIES["round"], a, b
        )
    assert "method" in error_of(pc.intersects, BODIES["cube"], BODIES["cube"], method="else")[1]


def test_distances_are_those_of_the_checks_in_python():
    rng = np.random.default_rng(8)
    for P, R in itertools.product(BODIES.values(), repeat=2):
        a, b = random_pose(rng), random_pose(rng)
        (overlap, found), (expected_overlap, expected) = (
            bounds(P, R, a, b, depths=True) for bounds in (pair_bounds, pair_bounds_checked)
        )
        assert overlap == expected_overlap
        assert all(np.array_equal(*values) for values in zip(found, expected, strict=True))


# ----- bodies that keep their poses


def test_placed_bodies_answer_as_bodies_at_their_poses():
    rng = np.random.default_rng(9)
    for P, R in itertools.product(BODIES.values(), repeat=2):
        a, b = random_pose(rng), FORMS["Fortran"](random_pose(rng))
        placed, other = pc.Placed(P, a), pc.Placed(R, b)
        expected = pc.intersects(P, R, a, b)
        for pair, poses in (((placed, other), ()), ((placed, R), (None, b)), ((P, other), (a,))):
            assert pc.intersects(*pair, *poses) is expected
            assert pc.distance(*pair, *poses).lower_bound == pc.distance(P, R, a, b).lower_bound
            assert pc.certify(*pair, *poses) == pc.certify(P, R, a, b)
            assert pc.depth(*pair, *poses).depth == pc.depth(P, R, a, b).depth


def test_placed_bodies_keep_their_own_poses():
    pose, P = random_pose(np.random.default_rng(10)), BODIES["cube"]
    placed, before = pc.Placed(P, pose), pose.copy()
    pose[:] = np.nan
    assert np.array_equal(placed.pose, before)
    assert not placed.pose.flags.writeable
    assert placed.polytope is P
    again = pickle.loads(pickle.dumps(placed))
    assert np.array_equal(again.pose, before)
    assert pc.intersects(again, placed)
    assert np.array_equal(pc.Placed(P).pose, np.eye(4))
    with pytest.raises(AttributeError):
        placed.pose = np.eye(4)
    assert "8 vertices" in repr(placed)


def test_a_placed_body_takes_no_other_pose():
    placed = pc.Placed(BODIES["cube"])
    for call in (pc.intersects, pc.certify, pc.distance, pc.signed_distance, pc.depth):
        for pose in (np.eye(4), [[1]]):
            assert error_of(call, placed, placed, pose) == (
                pc.PlannercheckError,
                "P is a Placed, which has its pose: leave pose_p out",
            )
            assert "leave pose_r out" in error_of(call, placed, placed, None, pose)[1]
    assert "leave pose_p out" in error_of(pc.intersects, placed, placed, np.tile(np.eye(4), (3, 1, 1)))[1]
    assert "pc.Polytope" in error_of(pc.Placed, CUBE)[1]


# ----- many poses


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(("first", "second"), [("cube", "round"), ("round", "cube"), ("flat", "point")])
def test_many_poses_get_the_verdicts_of_single_calls(form, first, second):
    rng = np.random.default_rng(11)
    P, R = BODIES[first], BODIES[second]
    a, b = (FORMS[form](np.array([random_pose(rng) for _ in range(40)])) for _ in range(2))
    expected = [pc.intersects(P, R, x, y) for x, y in zip(a, b, strict=True)]
    for threads in (1, 2, 100):
        found = pc.intersects(P, R, a, b, threads=threads)
        assert found.dtype == bool
        assert found.shape == (40,)
        assert found.tolist() == expected
    for method in ("walk", "exact"):
        assert pc.intersects(P, R, a, b, method).tolist() == expected
    alone = [pc.intersects(P, R, x, b[3]) for x in a]
    assert pc.intersects(P, R, a, b[3]).tolist() == alone
    assert pc.intersects(P, pc.Placed(R, b[3]), a).tolist() == alone
    assert pc.intersects(R, P, b[3], a).tolist() == alone
    assert pc.intersects(P, R, a).tolist() == [pc.intersects(P, R, x) for x in a]
    assert pc.intersects(P, R, a[::2], b[::2]).tolist() == expected[::2]
    assert pc.intersects(P, R, a[::-1], b[::-1]).tolist() == expected[::-1]


def test_many_poses_of_large_bodies_get_the_verdicts_of_single_calls():
    rng = np.random.default_rng(12)
    P, R = (pc.Polytope(family("round", 5000, seed)) for seed in (1, 2))
    a, b = (np.array([random_pose(rng) for _ in range(60)]) for _ in range(2))
    found = pc.intersects(P, R, a, b)
    assert found.tolist() == [pc.intersects(P, R, x, y) for x, y in zip(a, b, strict=True)]
    assert 0 < found.sum() < 60
    a[33, 0, 0] = np.nan
    assert "pose_p[33]" in error_of(pc.intersects, P, R, a, b)[1]


@pytest.mark.parametrize("fault", FAULTS)
def test_a_bad_pose_of_many_is_named(fault):
    rng = np.random.default_rng(13)
    P, R = BODIES["cube"], BODIES["round"]
    poses = np.array([random_pose(rng) for _ in range(9)])
    bad = FAULTS[fault](poses[6])
    if bad.shape != (4, 4) or bad.dtype.kind != "f":  # not one row of numbers among others
        assert error_of(pc.intersects, P, R, FAULTS[fault](poses))[0] is pc.PlannercheckError
        return
    poses[6] = bad
    text = error_of(_checked_matrix, bad, "pose_p[6]", RIGID_TOLERANCE)
    assert error_of(pc.intersects, P, R, poses) == text
    assert error_of(pc.intersects, P, R, poses, poses, threads=3) == text
    assert error_of(pc.intersects, R, P, poses.tolist()) == text
    assert error_of(pc.intersects, P, R, poses[:5], bad) == error_of(_checked_matrix, bad, "pose_r", RIGID_TOLERANCE)


@pytest.mark.parametrize("fault", ["translation NaN", "last row", "last row NaN", "reflection", "off rigid", "sheared"])
def test_a_bad_pose_is_found_wherever_it_is(fault):
    """Poses are looked at four at a time, those left over singly."""
    rng = np.random.default_rng(16)
    P, R = BODIES["cube"], BODIES["round"]
    good = np.array([random_pose(rng) for _ in range(7)])
    for place in range(len(good)):
        poses = good.copy()
        poses[place] = FAULTS[fault](poses[place])
        for arguments in ((P, R, poses, good), (R, P, poses, good[0])):
            assert f"pose_p[{place}]" in error_of(pc.intersects, *arguments)[1]


@pytest.mark.parametrize("far", [0.0, 1.0, 1e4, 1e9, 1e11])
@pytest.mark.parametrize("off", [1e-15, 1e-9, 1e-5, 1e-2, 1.0])
def test_pairs_whose_balls_nearly_touch_get_the_verdicts_of_single_calls(off, far):
    """Of four pairs at a time, the far ones are told by their balls; fewer than four pairs are tested one by one."""
    rng = np.random.default_rng(17)
    bodies = [pc.Polytope([point], inflation_radius=0.1) for point in ((0.3, -0.2, 0.5), (0.0, 0.1, -0.7))]
    centres = [body.vertices[0] for body in bodies]
    a, b = (np.array([random_pose(rng) for _ in range(203)]) for _ in range(2))
    directions = rng.normal(size=(203, 3))
    directions *= (0.2 * (1 + off * rng.uniform(-1, 1, 203)) / np.linalg.norm(directions, axis=1))[:, None]
    a[:, :3, 3] = far * rng.normal(size=(203, 3))
    b[:, :3, 3] = a[:, :3, 3] + a[:, :3, :3] @ centres[0] + directions - b[:, :3, :3] @ centres[1]
    expected = [pc.intersects(*bodies, x, y) for x, y in zip(a, b, strict=True)]
    assert pc.intersects(*bodies, a, b).tolist() == expected
    assert pc.intersects(*bodies[::-1], b, a).tolist() == expected
    assert 0 < sum(expected) < len(expected)
    for k in range(10):
        alone = [pc.intersects(*bodies, a[k], y) for y in b[: 8 * k]]
        assert pc.intersects(*bodies, a[k], b[: 8 * k]).tolist() == alone


def test_more_poses_than_are_looked_at_at_a_time():
    rng = np.random.default_rng(18)
    poses = np.array([random_pose(rng) for _ in range(2500)])
    poses[:, :3, 3] *= 3
    for P, R in ((BODIES["cube"], BODIES["round"]), (BODIES["flat"], BODIES["cube"])):
        found = pc.intersects(P, R, poses)
        assert found.tolist() == intersects_checked(P, R, poses).tolist()
        assert 0 < found.sum() < 1000


def test_numbers_of_poses_must_agree():
    P, poses = BODIES["cube"], np.tile(np.eye(4), (3, 1, 1))
    assert "equally many, not 3 and 2" in error_of(pc.intersects, P, P, poses, poses[:2])[1]
    assert "equally many, not 1 and 3" in error_of(pc.intersects, P, P, poses[:1], poses)[1]
    assert pc.intersects(P, P, poses[:1], poses[0]).tolist() == [True]
    for empty in (pc.intersects(P, P, poses[:0]), pc.intersects(P, P, poses[:0], poses[:0].tolist() or poses[:0])):
        assert empty.shape == (0,)
        assert empty.dtype == bool
    assert intersects_checked(P, P, poses[:0]).shape == (0,)
    assert "threads" in error_of(pc.intersects, P, P, poses, threads=0)[1]
    for call in (pc.certify, pc.distance, pc.signed_distance, pc.depth):
        assert "(4, 4), not (3, 4, 4)" in error_of(call, P, P, poses)[1]


def test_shapes_with_poses_of_their_own_at_many_poses():
    import coal

    own, rng = random_pose(np.random.default_rng(14)), np.random.default_rng(15)
    item = coal.CollisionObject(coal.Box(1, 1, 1), coal.Transform3s(own[:3, :3], own[:3, 3]))
    poses = np.array([random_pose(rng) for _ in range(20)])
    found = pc.intersects(item, BODIES["cube"], poses)
    assert found.tolist() == [pc.intersects(item, BODIES["cube"], pose) for pose in poses]
