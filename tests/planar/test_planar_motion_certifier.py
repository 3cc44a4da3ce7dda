"""Planar motions that are proved free: bounds against brute force, verdicts against dense sampling and shapely."""

import math

import numpy as np
import pytest
from ompl import base
from planar_cases import chain, cluttered
from planar_motions import KINDS, TOLERANCE, P, arm, clearances, curve_of, motions, posed, states_of

import plannercheck as pc

# Of lengths in m, for what is computed twice.
ROUNDING = 1e-11


def needle():
    """A robot 2 m long and 0.1 mm thick, its origin near one end."""
    return P.Robot([[-0.2, -5e-5], [1.8, -5e-5], [1.8, 5e-5], [-0.2, 5e-5]], name="needle")


CHECKERS = {
    "chain": lambda: P.Checker(chain(), cluttered(count=25)),
    "arm": lambda: P.Checker(arm(), cluttered(seed=1, count=7, reach=4.0)),
    "forklift": lambda: P.Checker(P.Robot.load("forklift"), P.Scene.load("warehouse")),
    "truck_trailer": lambda: P.Checker(P.Robot.load("truck_trailer"), P.Scene.load("parking")),
}


@pytest.fixture(scope="module", params=list(CHECKERS))
def checker(request):
    return CHECKERS[request.param]()


def kinds_for(checker):
    return KINDS if checker.robot.is_free else KINDS[:1]


# ----- proofs


def check_proof(checker, q0, q1, kind, proof):
    """Gaps at both ends are as said, and between them no vertex leaves its chord further than said."""
    inner = np.linspace(proof.start, proof.end, 5)
    states = states_of(checker, q0, q1, inner, kind)
    turns = np.repeat(np.eye(3)[None], len(inner), axis=0)
    if proof.frame is not None:
        turns = checker.robot.link_poses(states)[:, checker.robot.link_index(proof.frame)]
    leaves, extents = [], []
    for sign, body in ((1, proof.first_body), (-1, proof.second_body)):
        seen = (posed(checker, body, states) - turns[:, None, :2, 2]) @ turns[:, :2, :2]
        parts = np.linspace(0, 1, len(inner))[:, None, None]
        chords = (1 - parts) * seen[0] + parts * seen[-1]
        leaves.append(np.linalg.norm(seen - chords, axis=2).max())
        extents.append((sign * seen @ proof.normal).min(axis=1))
    assert sum(leaves) <= proof.chord_deviation + ROUNDING
    gaps = sum(extents)
    assert min(gaps[0], gaps[-1]) >= proof.gap - ROUNDING
    assert proof.gap > proof.chord_deviation
    assert gaps.min() > 0


def test_proofs_hold_against_brute_force(checker):
    for kind in kinds_for(checker):
        proved = 0
        for q0, q1 in zip(*motions(checker, 4, 1), strict=True):
            verdict = checker.explain_motion(q0, q1, proofs=True, **curve_of(kind))
            assert (verdict.free_until == 1.0) == verdict.free == checker.check_motion(q0, q1, **curve_of(kind))
            for proof in verdict.proofs[:: max(1, len(verdict.proofs) // 40)]:
                check_proof(checker, q0, q1, kind, proof)
                proved += 1
        assert proved > 10


def test_proofs_cover_every_pair_up_to_where_the_motion_is_free(checker):
    for kind in kinds_for(checker):
        for q0, q1 in zip(*motions(checker, 3, 2), strict=True):
            verdict = checker.explain_motion(q0, q1, proofs=True, **curve_of(kind))
            covered: dict[tuple[int, int], float] = {}
            for proof in sorted(verdict.proofs, key=lambda p: p.start):
                key = (proof.first_body, proof.second_body)
                if proof.start <= covered.get(key, 0.0):
                    covered[key] = max(covered.get(key, 0.0), proof.end)
            assert min(covered.get(tuple(pair), 0.0) for pair in checker.pairs.tolist()) >= verdict.free_until


# ----- verdicts


def test_verdicts_against_dense_sampling(checker):
    """Accepted motions have no colliding state; of refused ones a state collides or is within the tolerance."""
    verdicts = []
    for kind in kinds_for(checker):
        for q0, q1 in zip(*motions(checker, 25 if kind[1] is None else 12, 3), strict=True):
            free = checker.check_motion(q0, q1, **curve_of(kind))
            verdicts.append(free)
            dense = checker.check_states(states_of(checker, q0, q1, np.linspace(0, 1, 2001), kind)).all()
            assert dense or not free
            verdict = checker.explain_motion(q0, q1, **curve_of(kind))
            assert verdict.free == free
            if free:
                continue
            if verdict.collides_at is None:
                state = states_of(checker, q0, q1, np.array([verdict.near_at]), kind)
                assert clearances(checker, state)[0] <= TOLERANCE
                assert verdict.pair.certificate.gap <= TOLERANCE
            else:
                state = states_of(checker, q0, q1, np.array([verdict.collides_at]), kind)[0]
                assert not checker.is_valid(state)
                assert verdict.free_until <= verdict.collides_at
                assert verdict.pair.certificate.verify()
    assert any(verdicts)
    assert not all(verdicts)


def test_batches_threads_and_single_calls_agree(checker):
    q0, q1 = motions(checker, 60, 4)
    free = checker.check_motions(q0, q1)
    assert (checker.check_motions(q0, q1, threads=3) == free).all()
    assert [checker.check_motion(a, b) for a, b in zip(q0, q1, strict=True)] == free.tolist()
    counts = checker.motion_certifier.statistics()
    assert counts["motions"] >= 3 * len(q0)
    assert checker.check_motions(q0[:0], q1[:0]).shape == (0,)


def grazing(robot, generator):
    """A motion, a part of it, and a wall of 0.1 mm to 1 cm that a corner of the robot passes there at a small gap."""
    alone = P.Checker(robot, self_collision=False)
    bodies = [k for k, body in enumerate(robot.bodies) if body.link > 0 or robot.is_free]
    for _ in range(60):
        q0 = robot.random_configurations(1, generator)[0]
        q1 = q0 + generator.normal(size=robot.nq) * ([1, 1, 1] + [0.5] * (robot.nq - 3) if robot.is_free else 0.8)
        part = float(generator.uniform(0.2, 0.8))
        before, here, after = (
            np.vstack([posed(alone, k, ((1 - t) * q0 + t * q1)[None])[0] for k in bodies])
            for t in (part - 1e-4, part, part + 1e-4)
        )
        k = int(generator.integers(len(here)))
        way, bend = after[k] - before[k], before[k] + after[k] - 2 * here[k]
        normal = np.array([-way[1], way[0]]) / np.linalg.norm(way) * generator.choice([-1, 1])
        if (here @ normal).max() <= here[k] @ normal + 1e-9 and bend @ normal < 0:
            break
    thickness = 10.0 ** generator.uniform(-4, -2)
    offset = thickness / 2 + float(generator.choice([-1, 1, 1, 1])) * 10.0 ** generator.uniform(-5.5, -2)
    scene = P.Scene("wall")
    centre, angle = here[np.argmax(here @ normal)] + offset * normal, math.atan2(normal[1], normal[0])
    scene.add_box("wall", [thickness, 0.1], P.pose_of(centre, angle))
    return P.Checker(robot, scene, self_collision=False), q0, q1, part


@pytest.mark.parametrize("make", [chain, arm, needle, lambda: P.Robot.load("forklift")])
def test_clearances_decide(make):
    """By shapely: never accepted where a state touches, always where the clearance exceeds the tolerance."""
    generator, robot = np.random.default_rng(5), make()
    accepted = refused = close = 0
    for _ in range(16):
        checker, q0, q1, part = grazing(robot, generator)
        (start,), (end,), _ = checker._motion_ends(q0[None], q1[None])
        near, far = np.clip(part + np.linspace(-1e-2, 1e-2, 401), 0, 1), np.linspace(0, 1, 401)
        way = float(checker.motion_sampler.way((end - start)[None])[0])
        least_near, least_far = (
            clearances(checker, states_of(checker, q0, q1, t, KINDS[0])).min() for t in (near, far)
        )
        free = checker.check_motion(q0, q1)
        assert checker.check_motion(q1, q0) == free or least_near < 2 * TOLERANCE
        accepted, refused = accepted + free, refused + (not free)
        close += least_near < 1e-3
        if min(least_near, least_far) == 0:
            assert not free
        # What sampling misses: half a step at the greatest speed.
        elif least_near - way * 2.5e-5 > TOLERANCE and least_far - way * 1.25e-3 > TOLERANCE:
            assert free
    assert min(accepted, refused, close) >= 3


def test_thin_walls_are_never_passed():
    """A wall of 0.1 mm across a needle's way, or a corner's: sampling at 1 cm passes some."""
    generator = np.random.default_rng(6)
    missed = 0
    for robot in (needle(), P.Robot.load("forklift")):
        for _ in range(25):
            q0 = np.append(generator.uniform(-3, 3, 2), generator.uniform(-3, 3))
            q1 = q0 + generator.normal(size=3)
            part = generator.uniform(0.1, 0.9)
            alone = P.Checker(robot)
            corner = posed(alone, 0, ((1 - part) * q0 + part * q1)[None])[0][2]
            scene = P.Scene("wall")
            scene.add_box("wall", [1e-4, 2e-4], P.pose_of(corner, generator.uniform(0, 7)))
            checker = P.Checker(robot, scene)
            assert not checker.check_motion(q0, q1)
            assert not checker.check_motion(q1, q0)
            verdict = checker.explain_motion(q0, q1)
            assert verdict.collides_at is not None
            assert verdict.collides_at <= part + 1e-9
            missed += checker.check_motion(q0, q1, resolution=0.01)
    assert missed > 0


def test_long_rotations_count_in_full():
    """A bar that turns by half a turn passes a post outside the hull of its start and end, or just misses it."""
    bar = P.Robot([[-2, -0.1], [2, -0.1], [2, 0.1], [-2, 0.1]])
    corner = math.hypot(2, 0.1)
    for gap, expected in ((-1e-6, False), (3e-4, True), (1.1e-4, True)):
        scene = P.Scene()
        scene.add_polygon("post", [[0, corner + gap]])
        checker = P.Checker(bar, scene)
        for start in (0.0, -0.3):
            assert checker.check_motion([0, 0, start], [0, 0, start + 3.1]) == expected
        assert checker.check_motion([0, 0, 0], [0, 0, 0.5])
        assert checker.check_motion([0, 0, 0], [0, 0, -0.5])


def test_headings_take_the_short_way_as_ompl_does():
    bar = P.Robot([[0, -0.1], [1, -0.1], [1, 0.1], [0, 0.1]])
    posts = P.Scene()
    posts.add_polygon("left", [[-0.5, 0]])
    checker = P.Checker(bar, posts)
    assert not checker.check_motion([0, 0, 3.0], [0, 0, -3.0])
    assert checker.check_motion([0, 0, 1.0], [0, 0, -1.0])
    assert checker.check_motion([0, 0, 1.0], [0, 0, 2 * math.pi - 1.0])
    assert not checker.check_motion([0, 0, 3.0], [0, 0, -3.0], resolution=0.01)
    space = base.SO2StateSpace()
    a, b, between = (space.allocState() for _ in range(3))
    for first, second in [(-math.pi / 2, math.pi / 2), (math.pi / 2, -math.pi / 2), (0, -math.pi), (2.0, -2.0)]:
        a.value, b.value = first, second
        space.interpolate(a, b, 0.25, between)
        state = states_of(checker, np.array([0, 0, first]), np.array([0, 0, second]), np.array([0.25]), KINDS[0])
        assert math.cos(float(state[0, 2]) - between.value) > 1 - 1e-12


def test_touching_is_refused_and_a_gap_of_the_tolerance_is_free():
    robot = P.Robot([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    scene = P.Scene()
    scene.add_polygon("wall", [[-9, 1], [9, 1], [9, 2], [-9, 2]])
    checker = P.Checker(robot, scene)
    for gap, expected in ((0.0, False), (2e-4, True), (1.01e-4, True), (-1e-9, False)):
        assert checker.check_motion([-5, -gap, 0], [5, -gap, 0]) == expected
    assert checker.check_motion([-5, -1e-5, 0], [5, -1e-5, 0], tolerance=1e-6)
    verdict = checker.explain_motion([-5, -1, 0], [5, 0, 0])
    assert verdict.collides_at == 1.0
    assert verdict.pair.second == "wall"


# ----- input


def test_bad_input_is_named():
    checker = P.Checker(P.Robot.load("forklift"), P.Scene.load("parking"))
    q = np.zeros(3)
    with pytest.raises(pc.PlannercheckError, match="tolerance"):
        checker.check_motion(q, q, tolerance=0)
    with pytest.raises(pc.PlannercheckError, match="turning_radius"):
        checker.check_motion(q, q, curve="dubins")
    with pytest.raises(pc.PlannercheckError, match="reeds_shepp"):
        checker.check_motion(q, q, curve="clothoid", turning_radius=1.0)
    with pytest.raises(pc.PlannercheckError, match="root of 'arm' is fixed"):
        P.Checker(arm()).check_motion([0, 0], [1, 1], curve="dubins", turning_radius=1.0)
    with pytest.raises(pc.PlannercheckError, match="larger tolerance"):
        checker.check_motion(q, [1e12, 0, 0])
    with pytest.raises(pc.PlannercheckError, match="same shape"):
        checker.check_motions(np.zeros((2, 3)), np.zeros((3, 3)))
    with pytest.raises(pc.PlannercheckError, match="threads"):
        checker.check_motions(q, q, threads=0)
