"""Contacts by construction against the filters' error bounds: bodies that touch, or overlap by less than the bounds.

The pose is chosen first and the other body laid onto it, so that a filter whose bound is too small calls them apart.
Far from the origin, off rigid as far as poses are accepted, small, on the last double; one state at a time and in
batches. Truth is exact arithmetic.
"""

import itertools

import exact_verdicts
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import plannercheck as pc
from plannercheck.bodies.tuning import pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.stress.body_families import FAMILIES, THIN_FAMILIES
from plannercheck.evaluation.stress.contact_poses import identities, random_directions, turned, turns_onto, unit
from plannercheck.evaluation.stress.random_cases import OFF_RIGID
from plannercheck.evaluation.stress.sample_bodies import prepared

STATES = 256
FREE_FLYER = 11  # JointKind in cpp/robots/kinematics.hpp
CUBE = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))
OCTAHEDRON = np.vstack([np.eye(3), -np.eye(3)])


def checker_of(bodies, links, pairs, placements=None, overlaps=False, **switches):
    """A core checker of bodies on links, -1 being the world; all filters but, unless asked for, the inner shapes."""
    placements = identities(len(bodies)) if placements is None else placements
    nothing, links = np.zeros(0), np.array(links, dtype=np.int32)
    moving = identities(int(links.max()) + 1)
    tuning = pair_options(overlaps=overlaps, **switches)
    cores = [body.core for body in bodies]
    return core.Checker(
        cores, links, placements, np.array(pairs, dtype=np.int32), len(moving), nothing, nothing,
        tuning, core.sampled_poses(moving[None]), [],
    )  # fmt: skip


def agree(checker, link_poses, expected):
    """Whether one state at a time and all in a batch have the verdicts (n,) that are expected."""
    link_poses = np.ascontiguousarray(link_poses)
    batch = checker.first_of_poses(link_poses, 1)
    single = np.concatenate([checker.first_of_poses(pose[None], 1) for pose in link_poses])
    few = np.concatenate(
        [checker.first_of_poses(part, 1) for part in np.array_split(link_poses, max(1, len(link_poses) // 3))]
    )
    for found in (batch, single, few):
        np.testing.assert_array_equal(found >= 0, expected)


def stretched(turns, rng):
    """Rotations, stretched as far off rigid as poses may be: along one axis, or anyhow."""
    stretch = np.einsum("ki,kj->kij", *[random_directions(len(turns), rng)] * 2)
    stretch *= rng.choice([-1, 1], (len(turns), 1, 1)) * OFF_RIGID / 2 / (1 + OFF_RIGID)
    return turns @ (np.eye(3) + stretch)


def contacts(p, r, rng, distance, off_rigid, depths):
    """Poses (n, 4, 4) of both, features of p on features of r, overlapping by the depths (n,), m."""
    k = len(depths)
    point_p, normal_p = p.features(k, rng)
    point_r, normal_r = r.features(k, rng)
    directions = random_directions(k, rng)
    turn_p, turn_r = turns_onto(normal_p, -directions, rng), turns_onto(normal_r, directions, rng)
    if off_rigid:
        turn_p, turn_r = stretched(turn_p, rng), stretched(turn_r, rng)
    poses_p, poses_r = identities(k), identities(k)
    poses_p[:, :3, :3], poses_r[:, :3, :3] = turn_p, turn_r
    if off_rigid:  # what p has furthest along the normal of r's feature, as it lies now
        directions = unit(np.linalg.solve(np.swapaxes(turn_r, 1, 2), normal_r[..., None])[..., 0])
        point_p = p.support(-np.einsum("kji,kj->ki", turn_p, directions))
    poses_r[:, :3, 3] = distance * random_directions(k, rng)
    touch = poses_r[:, :3, 3] + turned(poses_r, point_r) - turned(poses_p, point_p)
    poses_p[:, :3, 3] = touch + (p.inflation_radius + r.inflation_radius - depths)[:, None] * directions
    return poses_p, poses_r


def just_apart_or_deep(depths, size):
    """Of overlaps by the depths, m: gaps as wide, but every third, which is what balls and boxes inside bodies find."""
    deep = np.arange(len(depths)) % 3 == 0
    return np.where(deep, 0.2 * size, -np.minimum(depths, 0.02 * size))


def free_bodies(poses, stretches):
    """Kinematics of free bodies, whose links are stretched by (bodies, 3, 3), and their configurations at poses."""
    n = len(poses)
    joints, rest = np.arange(n, dtype=np.int32), np.zeros((n, 7))
    placements = identities(n)[:, :3].copy()
    placements[:, :, :3] = stretches
    kinematics = core.Kinematics(
        7 * n, np.full(n, -1, dtype=np.int32), np.full(n, FREE_FLYER, dtype=np.int32), np.zeros((n, 3)),
        identities(n)[:, :3].copy(), np.arange(7 * n, dtype=np.int32).reshape(n, 7), rest + 1, rest, joints, placements,
    )  # fmt: skip
    rows = [np.hstack([pose[:, :3, 3], Rotation.from_matrix(pose[:, :3, :3]).as_quat()]) for pose in poses]
    return kinematics, np.hstack(rows)


def hold_overlaps(p, r, poses, off_rigid, rng):
    """Balls and boxes inside bodies, which find collisions, against exact arithmetic, in batches and one by one.

    Only who asks whether anything collides asks for overlaps: `check_states`, which wants configurations. Returns how
    many collisions were found by overlaps.
    """
    turns = identities(2)[:, :3, :3]
    kinematics, q = free_bodies(poses, stretched(turns, rng) if off_rigid else turns)
    posed = kinematics.link_poses(q, np.ones(2, dtype=np.uint8))
    free = ~truth(p, r, *(np.ascontiguousarray(posed[:, k]) for k in range(2)))
    assert 0.2 < free.mean() < 0.8
    for links in ([0, 1], [1, 0]):
        bodies = [(p.polytope, r.polytope)[k] for k in links]
        checker = checker_of(bodies, links, [[0, 1]], overlaps=True)
        np.testing.assert_array_equal(checker.check_states(kinematics, q, 1).astype(bool), free)
        found = [checker.check_states(kinematics, q[k : k + 3], 1).astype(bool) for k in range(0, len(q), 3)]
        np.testing.assert_array_equal(np.concatenate(found), free)
        single = [checker.check_states(kinematics, row[None], 1)[0] for row in q]
        np.testing.assert_array_equal(np.array(single, dtype=bool), free)
    return checker.statistics()["overlaps"]


def truth(p, r, poses_p, poses_r):
    found = core.intersect_batch(p.polytope.core, poses_p, r.polytope.core, poses_r, pair_options("exact"))
    return found[0].astype(bool)


def specimens(size, rng):
    """Pairs of bodies whose boxes, balls or both are tight."""
    for first, second in (("box", "box"), ("round", "round"), ("box", "round"), ("cone", "plate"), ("needle", "box")):
        points = [(FAMILIES.get(name) or THIN_FAMILIES[name])(12, rng) * size for name in (first, second)]
        yield prepared(first, points[0]), prepared(second, points[1])
    yield prepared("capsule", THIN_FAMILIES["segment"](2, rng) * size, 0.2 * size), prepared("box", CUBE * size)
    yield prepared("ball", np.zeros((1, 3)), 0.5 * size), prepared("ball", np.zeros((1, 3)), 0.3 * size)


CASES = [
    (1.0, 0.0, False),
    (1.0, 0.0, True),
    (1.0, 1e6, False),
    (100.0, 1e6, True),
    (1e-3, 1.0, False),
    (1e-3, 1.0, True),
]


@pytest.mark.parametrize(("size", "distance", "off_rigid"), CASES)
def test_filters_leave_contacts_alone(size, distance, off_rigid):
    rng = np.random.default_rng(round(size * 1e4 + distance + off_rigid))
    sharing, overlaps = [], 0
    # From rounding in doubles to what rounding in floats is where the bodies lie.
    depths = np.geomspace(1e-12, 1e-6, STATES) * size + np.where(np.arange(STATES) % 2, 0, 2e-8 * distance)
    for p, r in specimens(size, rng):
        poses = contacts(p, r, rng, distance, off_rigid, np.minimum(depths, 0.02 * size))
        expected = truth(p, r, *poses)
        assert expected.mean() > 0.5
        sharing.append(expected.mean())
        both = np.stack(poses, axis=1)
        agree(checker_of([p.polytope, r.polytope], [0, 1], [[0, 1]]), both, expected)
        agree(checker_of([p.polytope, r.polytope], [1, 0], [[0, 1]]), both[:, ::-1], expected)
        poses_in_joints = contacts(p, r, rng, distance, False, just_apart_or_deep(depths, size))
        overlaps += hold_overlaps(p, r, poses_in_joints, off_rigid, rng)
        for options in (pair_options(), pair_options("walk"), pair_options(cached_plane=False, centre_axis=False)):
            found = core.intersect_batch(p.polytope.core, poses[0], r.polytope.core, poses[1], options)[0]
            np.testing.assert_array_equal(found.astype(bool), expected)
    assert np.mean(sharing) > 0.8
    assert overlaps > 0 or distance > 1e5 * size  # where floats tell no bodies apart


@pytest.mark.parametrize(("size", "distance", "off_rigid"), CASES)
@pytest.mark.parametrize("obstacles", [1, 5, 80])
def test_filters_leave_contacts_with_obstacles_alone(size, distance, off_rigid, obstacles):
    """Obstacles stand where a mover meets one in each state: alone, in a list, in a tree."""
    rng = np.random.default_rng(round(size * 1e4 + distance + off_rigid) + obstacles)
    for p, r in specimens(size, rng):
        depths = np.geomspace(1e-12, 1e-6, obstacles) * size + 2e-8 * distance * rng.integers(0, 2, obstacles)
        poses_p, poses_r = contacts(p, r, rng, distance, off_rigid, np.minimum(depths, 0.02 * size))
        if off_rigid or distance == 0:  # each obstacle where the first state is, so that they are not all in one place
            poses_r[:, :3, 3] += (apart := 3 * size * np.arange(obstacles)[:, None] * random_directions(1, rng))
            poses_p[:, :3, 3] += apart
        links, pairs = [0] + [-1] * obstacles, [[0, k + 1] for k in range(obstacles)]
        placements = np.concatenate([identities(1), poses_r])
        checker = checker_of([p.polytope, *[r.polytope] * obstacles], links, pairs, placements)
        expected = np.stack([truth(p, r, poses_p, pose[None]) for pose in poses_r], axis=1)
        assert np.diagonal(expected).mean() > 0.5 or obstacles == 1
        agree(checker, poses_p[:, None], expected.any(axis=1))
        found = checker.all_of_poses(np.ascontiguousarray(poses_p[:, None]))
        np.testing.assert_array_equal(np.asarray(found).astype(bool), expected)


@pytest.mark.parametrize("family", ["round", "box", "cone", "cloud", "flat", "needle"])
@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_bounding_balls_hold_every_vertex(family, size):
    """A point obstacle on each vertex, and one just off the body: the ball is as large as its furthest vertices say."""
    rng = np.random.default_rng(12)
    for _ in range(4):
        body = pc.Polytope(FAMILIES[family](12, rng) * size)
        pose = identities(9)
        for vertex in body.vertices:
            point = pc.Polytope(vertex[None])
            checker = checker_of([body, point], [0, -1], [[0, 1]])
            agree(checker, pose[:, None], [True] * 9)
            checker = checker_of([body, point], [0, 1], [[0, 1]])
            agree(checker, np.stack([pose, pose], axis=1), [True] * 9)


@pytest.mark.parametrize("inflation_radius", [0.0, 0.25])
def test_balls_of_stretched_bodies_hold_them(inflation_radius):
    """Two octahedra, corner on corner, along an axis by which poses are stretched: balls grow as their poses do."""
    bodies = pc.Polytope(OCTAHEDRON, inflation_radius=inflation_radius), pc.Polytope(OCTAHEDRON)
    stretch = 1 + OFF_RIGID * 0.49
    pose_p, pose_r = identities(2)
    pose_p[0, 0] = pose_r[0, 0] = stretch
    for gap in (0.0, 1e-9, -1e-9, 4e-7, 1e-5):
        pose_p[0, 3] = 2 * stretch + inflation_radius + gap
        colliding = exact_verdicts.intersects(OCTAHEDRON, OCTAHEDRON, pose_p, pose_r, inflation_radius, 0.0)
        assert colliding == (gap <= 0) or gap == 0
        for options in (pair_options(), pair_options(turned_axis=False), pair_options("walk")):
            arguments = bodies[0].core, pose_p[None], bodies[1].core, pose_r[None], options
            assert core.intersect_batch(*arguments)[0].tolist() == [colliding]
        both = np.repeat(np.stack([pose_p, pose_r])[None], 9, axis=0)
        agree(checker_of(bodies, [0, 1], [[0, 1]]), both, [colliding] * 9)


def test_planes_are_kept_only_as_long_as_they_separate():
    """A plane that touches a ball is asked again in the next states, where the bodies touch."""
    rng = np.random.default_rng(13)
    p, r = prepared("round", FAMILIES["round"](16, rng)), prepared("round", FAMILIES["round"](20, rng))
    poses_p, poses_r = contacts(p, r, rng, 0.0, True, np.geomspace(1e-15, 1e-7, 100))
    apart = poses_p.copy()
    apart[:, :3, 3] *= 1 + 1e-5
    poses_p, poses_r = np.stack([apart, poses_p], axis=1).reshape(-1, 4, 4), np.repeat(poses_r, 2, axis=0)
    expected = truth(p, r, poses_p, poses_r)
    assert 0.3 < expected.mean() < 0.7
    for options in (pair_options(), pair_options("walk")):
        found = core.intersect_batch(p.polytope.core, poses_p, r.polytope.core, poses_r, options)[0]
        np.testing.assert_array_equal(found.astype(bool), expected)


@pytest.mark.parametrize("method", ["oracle", "walk"])
def test_contacts_on_the_last_double_of_what_stands_at_the_origin(method):
    """The body_b's pose is the identity, so that all that the game's bound covers is rounding."""
    rng = np.random.default_rng(14)
    sharing = []
    for names in itertools.product(("round", "cone", "box"), repeat=2):
        p, r = (prepared(name, FAMILIES[name](12, rng) + rng.normal(size=3)) for name in names)
        for first, second in ((p, r), (r, p)):
            point_p, normal_p = first.features(STATES, rng)
            point_r, normal_r = second.features(STATES, rng)
            poses_p, poses_r = identities(STATES), identities(STATES)
            poses_p[:, :3, :3] = turns_onto(normal_p, -normal_r, rng)
            gaps = rng.choice([0.0, 1e-16, -1e-16, 3e-16, -3e-16], (STATES, 1))
            poses_p[:, :3, 3] = point_r - turned(poses_p, point_p) + gaps * normal_r
            expected = truth(first, second, poses_p, poses_r)
            sharing.append(expected.mean())
            options = pair_options(method, cached_plane=False, centre_axis=False)
            found = core.intersect_batch(first.polytope.core, poses_p, second.polytope.core, poses_r, options)[0]
            np.testing.assert_array_equal(found.astype(bool), expected)
    assert 0.2 < np.mean(sharing) < 0.8


def almost_unturned(k, rng):
    """Rotations (k, 3, 3) by 1e-5 to 1e-2: entries round in many ways, and 1-norms along an axis stay about lengths."""
    x, y, z = (rng.normal(size=(k, 3)) * 10.0 ** rng.uniform(-5, -2, (k, 1))).T
    o = np.zeros(k)
    turns, upper = np.linalg.qr(np.eye(3) + np.moveaxis(np.array([[o, -z, y], [z, o, -x], [-y, x, o]]), 2, 0))
    return turns * np.sign(np.einsum("kii->ki", upper))[:, None, :]


@pytest.mark.parametrize("radius", [0.5690558794408735, 0.5425412229054223, 0.5440037981315080])
def test_boxes_of_balls_stretched_as_far_as_links_and_bodies_may_be(radius):
    """A point in a ball, 1e-9 to 6e-8 below its surface: found by a search for what floats round to the worse side.

    The frame of the point is stretched by 1.8e-6 towards the ball, that of the ball shrunk by as much: along the first
    one's axis the distance seems longer and the ball, whose inflation radius no pose stretches, does not.
    """
    rng = np.random.default_rng(21)
    states = 40_000
    of_body = 2.2e-7
    of_link = 1.8e-6 * (1 - 1e-4) - of_body
    placements = identities(2)
    placements[:, 0, 0] += of_body, -of_body
    both = np.stack([identities(states), identities(states)], axis=1)
    turns = almost_unturned(states, rng)
    both[:, 0, :3, :3], both[:, 1, :3, :3] = turns * [1 + of_link, 1, 1], turns * [1 - of_link, 1, 1]
    apart = turns[:, :, 0] * radius * (1 - rng.uniform(1e-9, 6e-8, (states, 1)))
    for share in (0.0, 0.5):  # of the way that the point has from the origin
        both[:, 0, :3, 3], both[:, 1, :3, 3] = -share * apart, (1 - share) * apart
        bodies = [pc.Polytope(np.zeros((1, 3))), pc.Polytope(np.zeros((1, 3)), inflation_radius=radius)]
        for order in ([0, 1], [1, 0]):
            checker = checker_of([bodies[k] for k in order], [0, 1], [[0, 1]], placements[order])
            assert (checker.first_of_poses(np.ascontiguousarray(both[:, order]), 1) == 0).all()
