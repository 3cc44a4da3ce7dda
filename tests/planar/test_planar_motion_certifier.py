"""Planar motions that are proved free: bounds against brute force, verdicts against dense sampling and shapely."""

import math

import numpy as np
import pytest
import shapely
from ompl import base
from planar_cases import chain, cluttered

import plannercheck as pc
from plannercheck.ompl import plan, space_of
from plannercheck.planar.curves import Curves

P = pc.planar
KINDS = [("straight", None), ("dubins", 1.5), ("reeds_shepp", 2.5)]
TOLERANCE = 1e-4

# Of lengths in m, for what is computed twice.
ROUNDING = 1e-11


def curve_of(kind):
    return {"curve": kind[0], "turning_radius": kind[1]}


def arm():
    """Three links on a fixed foot."""
    return P.Robot(
        [
            P.Link("foot", [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]], anchor=(-1.5, -1, 0.3)),
            P.Link("upper", [[0, -0.05], [1, -0.05], [1, 0.05], [0, 0.05]], "foot", joint="revolute", limits=(-4, 4)),
            P.Link("bend", [[0, 0], [0.3, 0]], "upper", (1, 0, 0.5)),
            P.Link("lower", [[0, 0], [1, 0]], "bend", (0.3, 0, 0), "revolute", (-3, 3)),
        ],
        name="arm",
    )


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


def motions(checker, n, seed, scale=1.0):
    """Motions from valid states, lengths of some metres and radians: (n, nq) to (n, nq)."""
    generator = np.random.default_rng(seed)
    q = checker.robot.random_configurations(30 * n, generator)
    starts = q[checker.check_states(q)][:n]
    ways = generator.normal(size=starts.shape) * generator.uniform(0.05, scale, (len(starts), 1))
    return starts, starts + ways * np.where(np.arange(starts.shape[1]) < 2, 2.0, 0.7)


def kinds_for(checker):
    return KINDS if checker.robot.is_free else KINDS[:1]


def states_of(checker, q0, q1, parameters, kind):
    """States of a motion as the certifier has them."""
    (start,), (end,), _ = checker._motion_ends(q0[None], q1[None], kind[0])
    return checker.motion_certifier.states(start, end, parameters, checker._motions.pieces(start, end, *kind))


def posed(checker, body, states):
    """(k, n, 2): vertices of a body in the world at states (k, nq)."""
    poses = checker.body_poses(states)[:, body]
    return checker.bodies[body].vertices @ poses[:, :2, :2].transpose(0, 2, 1) + poses[:, None, :2, 2]


def clearances(checker, states):
    """(k,) m: least distance of all pairs by shapely, 0 where they touch."""
    least = np.full(len(states), np.inf)
    made = {1: lambda v: shapely.points(v[:, 0]), 2: shapely.linestrings}
    shapes = [
        made.get(len(body.vertices), lambda v: shapely.convex_hull(shapely.multipoints(v)))(posed(checker, k, states))
        for k, body in enumerate(checker.bodies)
    ]
    for a, b in checker.pairs.tolist():
        least = np.minimum(least, shapely.distance(shapes[a], shapes[b]))
    return least


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
    assert sum(leaves) <= proof.bulge + ROUNDING
    gaps = sum(extents)
    assert min(gaps[0], gaps[-1]) >= proof.gap - ROUNDING
    assert proof.gap > proof.bulge
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


# ----- curves


def pose_pairs(seed, n):
    """Poses of many scales, and special ones: equal headings, on a grid, nearly equal."""
    generator = np.random.default_rng(seed)
    for k in range(n):
        size = 10.0 ** generator.uniform(-3, 2)
        a, b = (np.append(generator.uniform(-size, size, 2), generator.uniform(-3.1, 3.1)) for _ in range(2))
        if k % 3 == 0:
            b[2] = a[2]
        if k % 5 == 0:
            a = np.zeros(3)
            b = np.append(generator.integers(-5, 6, 2), generator.integers(-2, 3) * math.pi / 2).astype(float)
        if k % 7 == 0:
            b = a + generator.normal(size=3) * 10.0 ** generator.integers(-9, 0)
        yield a, b


@pytest.mark.parametrize(
    ("name", "space"), [("dubins", base.DubinsStateSpace), ("reeds_shepp", base.ReedsSheppStateSpace)]
)
@pytest.mark.parametrize("radius", [0.2, 1.5, 30.0])
def test_pieces_are_ompls_curves(name, space, radius):
    """At random parameters no point within 5 m is further than the pieces say from where OMPL puts it."""
    curves, judge, lever = Curves(name, radius), space(radius), 5.0
    first, last, between = (judge.allocState() for _ in range(3))
    generator, pieces = np.random.default_rng(7), []
    for a, b in pose_pairs(8, 150):
        rows = curves.pieces(a, b, lever)
        pieces.append(len(rows))
        assert rows[:, 10].max() < 0.05 * TOLERANCE
        assert rows[-1, 0] == rows[-1, 1] == 1
        assert (rows[1:, 0] == rows[:-1, 1]).all()
        for state, pose in ((first, a), (last, b)):
            state.setX(pose[0])
            state.setY(pose[1])
            state.setYaw(pose[2])
        for t in generator.uniform(0, 1, 12) if len(rows) > 1 else ():
            row = rows[np.searchsorted(rows[:, 1], t)]
            s = (t - row[0]) / (row[1] - row[0])
            heading = row[6] + s * row[7]
            x = row[2] + s * row[4] + math.cos(heading) * row[8] - math.sin(heading) * row[9]
            y = row[3] + s * row[5] + math.sin(heading) * row[8] + math.cos(heading) * row[9]
            judge.interpolate(first, last, t, between)
            off = math.hypot(x - between.getX(), y - between.getY())
            off += lever * abs(math.remainder(heading - between.getYaw(), 2 * math.pi))
            assert off <= row[10] + 1e-13 * (1 + np.abs(a[:2]).sum() + np.abs(b[:2]).sum() + radius)
    assert np.mean(pieces) < 8


def test_taking_apart_ends():
    """A curve that once was cut off its end again and again, by next to nothing each time."""
    start = np.array([15.592558502436406, 10.188855462532539, 0.183607645053924])
    end = np.array([15.788461045441508, 10.225234388121631, 0.1836076450539233])
    assert len(Curves("reeds_shepp", 6.0).pieces(start, end, 14.0)) <= 6


def test_of_two_curves_of_one_length_ompls_is_judged():
    """The last bit of a heading decides which of two curves OMPL takes."""
    checker = P.Checker(P.Robot.load("truck_trailer"), P.Scene.load("parking"))
    start = [9.18283854822792, 14.764436451613967, -2.941501915011496, 0.6114179705653158, 0.6254121805476937]
    end = [7.538950352634891, 14.964362176130075, 2.195461623990338, 0.44970857656799257, 0.48361853875099486]
    kind, parts = ("reeds_shepp", 6.0), np.linspace(0, 1, 101)
    space = space_of(checker, **curve_of(kind))
    information = pc.ompl.setup(checker, **curve_of(kind)).getSpaceInformation()
    ends = [space.state(information, q) for q in (start, end)]
    space.ompl_space()
    ompls = space.curve_states(*ends, parts)
    ours = states_of(checker, np.array(start), np.array(end), parts, kind)
    assert np.abs(ompls[:, :2] - ours[:, :2]).max() < 1e-9
    assert not checker.check_states(ompls).all()
    assert not checker.check_motion(start, end, **curve_of(kind))
    assert not information.checkMotion(*ends)


def test_curves_that_leave_between_the_ends_are_refused():
    """A Dubins car that turns round sweeps over a post beside its straight way."""
    robot, scene = P.Robot([[0, -0.1], [0.5, -0.1], [0.5, 0.1], [0, 0.1]]), P.Scene()
    scene.add_polygon("post", [[1.0, 1.3]])
    checker = P.Checker(robot, scene)
    ends = [0, 0, 0], [0, 2.0, math.pi]
    assert checker.check_motion(*ends)
    assert not checker.check_motion(*ends, curve="dubins", turning_radius=1.0)
    verdict = checker.explain_motion(*ends, curve="dubins", turning_radius=1.0)
    assert verdict.pair.second == "post"
    assert 0.3 < verdict.free_until <= verdict.collides_at < 0.6
    assert not checker.check_motion(*ends, 0.01, curve="dubins", turning_radius=1.0)
    assert checker.check_motion(ends[0], ends[0], curve="reeds_shepp", turning_radius=1.0)


def test_short_curves_are_judged_whatever_the_tolerance():
    robot, scene = P.Robot([[0, -0.1], [5, -0.1], [5, 0.1], [0, 0.1]]), P.Scene()
    scene.add_polygon("post", [[5.001, 0.0]])
    checker, generator = P.Checker(robot, scene), np.random.default_rng(10)
    for _ in range(60):
        ends = np.zeros(3), generator.normal(size=3) * 10.0 ** generator.uniform(-9, -5)
        for name in ("dubins", "reeds_shepp"):
            curves = Curves(name, 1.5).pieces(*ends, 5.1)
            free = checker.check_motion(*ends, tolerance=1e-8, curve=name, turning_radius=1.5)
            states = checker.motion_certifier.states(*ends, np.linspace(0, 1, 500), curves)
            clearance = clearances(checker, states).min()
            assert free == (clearance > 0) or 0 < clearance < 1e-4


# ----- OMPL


@pytest.mark.parametrize("kind", KINDS)
def test_validators_prove(kind):
    """Verdicts and places are the checker's, for robots with and without trailers; the counters count."""
    for name in ("forklift", "truck_trailer"):
        checker = P.Checker(P.Robot.load(name), P.Scene.load("parking"))
        setup = pc.ompl.setup(checker, **curve_of(kind))
        space = space_of(checker, **curve_of(kind))
        information = setup.getSpaceInformation()
        validator = information.getMotionValidator()
        found = []
        for q0, q1 in zip(*motions(checker, 12, 9), strict=True):
            q1 = np.clip(q1, checker.robot.lower, checker.robot.upper)
            states = [space.state(information, q) for q in (q0, q1)]
            free = checker.check_motion(q0, q1, **curve_of(kind))
            found.append(free)
            assert information.checkMotion(*states) == free
            last = space.state(information, q0)
            valid, part = validator.checkMotionWithLastValid(*states, last)
            assert valid == free
            assert checker.is_valid(space.read(last))
            assert part == 1.0 or checker.explain_motion(q0, q1, **curve_of(kind)).free_until == pytest.approx(part)
        assert validator.getValidMotionCount() == 2 * sum(found)
        assert validator.getInvalidMotionCount() == 2 * (len(found) - sum(found))


@pytest.mark.parametrize("planner", ["RRTConnect", "BKPIECE1", "BITstar", "PRM", "RRTstar"])
def test_planners_run_through_it(planner):
    checker = P.Checker(P.Robot.load("forklift"), P.Scene.load("warehouse"))
    ends = checker.scene.start("forklift"), checker.scene.goal("forklift")
    found = plan(checker, *ends, planner=planner, time_limit=1.0 if planner in ("BITstar", "RRTstar") else 15.0, seed=2)
    if not found.solved:
        assert planner in ("BKPIECE1", "BITstar", "RRTstar", "PRM"), found.reason  # not all find it in time
        return
    assert checker.check_motions(found.path[:-1], found.path[1:]).all()
    for a, b in zip(found.path[:-1], found.path[1:], strict=True):
        assert checker.check_motion(a, b, resolution=1e-3)


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
