"""Planar motions and states that touch by construction must not be called free, whatever was asked before."""

import cmath
import math
from fractions import Fraction

import numpy as np
import pytest
from ompl import base
from planar_contacts import contact_of_branches, contact_with_obstacle, grazing_wedge, posed_vertex

import plannercheck as pc
from plannercheck.ompl import space_of

P = pc.planar
TOLERANCE = 1e-4
CURVES = [("dubins", 6.0), ("reeds_shepp", 6.0)]

# ----- directions are of length 1


def far_bar():
    """4 m long, 8 m off its root; thin, so that its circle is as far out as its corner."""
    return P.Robot([[8, -0.005], [12, -0.005], [12, 0.005], [8, 0.005]])


def bar_and_post():
    scene = P.Scene()
    scene.add_polygon("post", [[12 - 0.02, 0.0]])
    return P.Checker(far_bar(), scene)


THROUGH = [0, 0, -0.09], [0, 0, 0.09]  # 2 cm deep through the post, between two states of the first grid
BEFORE = [-0.05, 0, 0.15], [-0.05, 0, 0]  # leaves a direction of 2 m with the pair


def test_a_motion_through_a_post_is_refused_after_another_motion():
    checker = bar_and_post()
    assert not checker.is_valid([0, 0, 0])
    assert checker.check_motion(*BEFORE)
    assert not checker.check_motion(*THROUGH)
    assert checker.check_motions(
        *(np.array(ends) for ends in zip(BEFORE, THROUGH, BEFORE, THROUGH, strict=True))
    ).tolist() == [True, False, True, False]
    assert not checker.explain_motion(*THROUGH).free


@pytest.mark.parametrize("proofs", [False, True])
@pytest.mark.parametrize(
    ("q0", "q1"),
    [
        (
            [43.92492929133014, 19.685806829974794, -0.07481087512361784, -0.6025155272229211, 0.7566863251630149],
            [43.85650109475948, 19.61220029659322, -1.0933395582812697, -0.9765322422819744, 2.0623148384209014],
        ),
        (
            [41.47617194343312, 6.094791380859727, -1.3775885208460081, -0.23483512473744317, -0.0723638100445112],
            [41.526924551790565, 5.280980340526054, -0.012670025805230356, -0.7359938342163063, -0.6753440566782759],
        ),
    ],
)
def test_the_shipped_truck_and_trailer_is_explained_as_colliding(q0, q1, proofs):
    checker = P.Checker(P.Robot.load("truck_trailer"), P.Scene.load("parking"))
    parts = np.linspace(0, 1, 2001)[:, None]
    assert not checker.check_states((1 - parts) * q0 + parts * np.array(q1)).all()
    verdict = checker.explain_motion(q0, q1, proofs=proofs)
    assert not verdict.free
    assert verdict.collides_at is not None


@pytest.mark.parametrize("height", [0.1, 0.2, 0.3])
def test_the_last_valid_state_is_valid(height):
    """A block stops the bar in the midst of the post, which a direction of 2 m left unseen."""
    scene = P.Scene("two", bounds=[[-20, -20], [20, 20]])
    x = 12 - 0.02
    scene.add_polygon("post", [[x, -0.5], [x + 1, -0.5], [x + 1, 0.5], [x, 0.5]])
    scene.add_box("block", [0.5, 1.0], P.pose_of([9.0, 0.5 + height]))
    checker = P.Checker(far_bar(), scene)
    information = pc.ompl.setup(checker).getSpaceInformation()
    space = space_of(checker)
    assert checker.check_motion([-0.05, 0, -0.15], [-0.05, 0, 0])
    ends = [space.state(information, q) for q in THROUGH]
    last = space.state(information, THROUGH[0])
    valid, part = information.getMotionValidator().checkMotionWithLastValid(*ends, last)
    assert not valid
    assert 0 <= part < 1
    assert checker.is_valid(space.read(last))


# ----- contact by construction

SIZES = [(1.0, 0.0), (1.0, 10.0), (1e-3, 10.0), (1e-3, 0.5), (0.3, 2.0)]  # of bodies, and off their frames; m


@pytest.mark.parametrize(("size", "offset"), SIZES)
@pytest.mark.parametrize("make", [contact_with_obstacle, contact_of_branches])
def test_motions_with_a_contact_are_refused(make, size, offset):
    """Trees of all kinds; also after another motion, the other way round, and with proofs."""
    generator, judged, bent = np.random.default_rng(11), 0, 0
    for _ in range(80):
        case = make(generator, size, offset, 10.0 ** generator.uniform(-1.5, 0.2))
        if case is None:
            continue
        checker = P.Checker(case.robot, case.scene)
        ends = case.q0, case.q1
        nearby = (1 - case.t) * case.q0 + case.t * case.q1 + generator.normal(size=case.robot.nq) * 0.05
        turned = np.abs(case.q1 - case.q0)[checker.robot.angles]
        if (turned > math.pi).any():
            continue  # the motion takes the short way, another one
        judged += 1
        bent += (turned > 0.1).any()
        assert not checker.check_motion(*ends), (judged, ends)
        checker.check_motion(nearby, case.q1 + 0.01)
        assert not checker.check_motion(*ends)
        assert not checker.check_motion(*reversed(ends))
        assert not checker.explain_motion(*ends, proofs=True).free
    assert judged > 30
    assert bent > 15


def test_verdicts_do_not_depend_on_what_was_asked_before():
    """One checker against fresh ones, in two orders and in batches; motions near the tolerance among them."""
    generator, counts = np.random.default_rng(12), [0, 0]
    for _ in range(25):
        case = contact_with_obstacle(generator, 0.3, 6.0, 0.5)
        if case is None:
            continue
        step = np.zeros((12, case.robot.nq))
        step[:, 0] = 10.0 ** generator.uniform(-5, -1, 12) * generator.choice([-1, 1], 12)
        q0, q1 = case.q0 + step, case.q1 + step
        fresh = [P.Checker(case.robot, case.scene).check_motion(a, b) for a, b in zip(q0, q1, strict=True)]
        checker = P.Checker(case.robot, case.scene)
        order = generator.permutation(len(q0))
        assert [checker.check_motion(q0[k], q1[k]) for k in order] == [fresh[k] for k in order]
        assert checker.check_motions(q0, q1).tolist() == fresh
        assert checker.check_motions(q0[::-1], q1[::-1], threads=3).tolist() == fresh[::-1]
        counts[0] += sum(fresh)
        counts[1] += len(fresh) - sum(fresh)
    assert min(counts) > 20


def test_what_a_motion_costs_does_not_depend_on_what_was_asked_before():
    """Nothing is learnt: the same lines and descents, whatever the checker did before."""
    checker = P.Checker(P.Robot.load("truck_trailer"), P.Scene.load("parking"))
    generator = np.random.default_rng(16)
    q = checker.robot.random_configurations(400, generator)
    q0 = q[checker.check_states(q)][:40]
    q1 = q0 + generator.normal(size=q0.shape) * [1, 1, 0.4, 0.2, 0.2]

    def cost(k):
        before = checker.motion_certifier.statistics()
        checker.check_motion(q0[k], q1[k])
        after = checker.motion_certifier.statistics()
        return {name: after[name] - before[name] for name in after}

    first = [cost(k) for k in range(len(q0))]
    assert [cost(k) for k in reversed(range(len(q0)))] == first[::-1]
    assert sum(counted["lines"] for counted in first) > 100


def test_branches_that_meet_between_two_states_are_refused():
    """Two hands that pass each other fast: far apart at both ends of an interval, and touching within."""
    footprint = [[0.99, -0.01], [1.01, -0.01], [1.01, 0.01], [0.99, 0.01]]
    generator = np.random.default_rng(13)
    for _ in range(200):
        meeting, t = generator.uniform(-1, 1), generator.uniform(0.02, 0.98)
        turn = generator.uniform(0.05, 2.9, 2) * [1, -1]
        links = [
            P.Link("base", [[0.0, 0.0]], joint="free"),
            P.Link("left", footprint, "base", (-1e-3, 0, 0), "revolute"),
            P.Link("right", footprint, "base", (1e-3, 0, 0), "revolute"),
        ]
        checker = P.Checker(P.Robot(links))
        q0 = np.array([0, 0, 0, *(meeting - t * turn)])
        q1 = q0 + np.array([0, 0, 0, *turn])
        assert not checker.check_motion(q0, q1)
        assert not checker.check_motion(q1, q0)


# ----- rounding


def test_contacts_far_from_the_origin_are_refused():
    """A vertex slides along a wall that it touches: 1e3 to 1e6 m away, doubles see gaps that are not there."""
    generator, unsure = np.random.default_rng(14), 0
    for _ in range(300):
        size = 10.0 ** generator.uniform(3, 6)
        start, angle = generator.uniform(-size, size, 2), float(generator.uniform(0, 2 * math.pi))
        way = cmath.exp(1j * angle) * 10.0 ** generator.uniform(-1, 1)
        robot = P.Robot([[0, 0], *([z.real, z.imag] for z in (way * (0.5 + 0.5j), way * (-0.5 + 0.5j)))])
        q0, q1 = np.array([*start, 0.0]), np.array([start[0] + way.real, start[1] + way.imag, 0.0])
        here = (1 - 0.5) * q0 + 0.5 * q1
        scene = P.Scene()
        corners = [0, way * (1 - 0.5j), way * (-1 - 0.5j)]
        scene.add_polygon("wall", [[here[0] + z.real, here[1] + z.imag] for z in corners])
        checker = P.Checker(robot, scene)
        assert not checker.is_valid(here)  # the same doubles
        tolerance = 1e-9 * size
        assert not checker.check_motion(q0, q1, tolerance=tolerance)
        unsure += 1
    assert unsure == 300


def called_free(judge, q0, q1, tolerance, kind):
    """Whether a motion is called free, not refused or too imprecise to be judged."""
    try:
        return judge(q0, q1, tolerance=tolerance, **kind)
    except pc.PlannercheckError as error:
        if "larger tolerance" not in str(error):
            raise
        return False


@pytest.mark.parametrize("far", [1e7, 1e9, 3e11, 1e12, 1e14])
@pytest.mark.parametrize("side", [1, -1])
def test_angles_of_many_turns_count_in_full(far, side):
    """Taking off whole turns rounds the angle; a side of the bar ends in the post all the same."""
    robot = P.Robot([[8, 0.0], [12, 0.0], [12, -side * 1e-6], [8, -side * 1e-6]])
    turn = cmath.exp(1j * far)  # Python's is accurate for any angle
    scene = P.Scene()
    post = 11.9 * turn * cmath.exp(-1j * side * 1e-9)
    scene.add_polygon("wedge", [[z.real, z.imag] for z in (post, post + 0.1 * turn, post + side * 0.1j * turn)])
    checker = P.Checker(robot, scene)
    end = [0.0, 0.0, far]
    start = [0.0, 0.0, math.remainder(far, 2 * math.pi) - side * 0.2]
    assert not checker.is_valid(end)
    for a, b in ((start, end), (end, start)):
        for kind in ({}, {"curve": "dubins", "turning_radius": 1e-3}):
            for tolerance in (1e-4, 1e-6):
                assert not called_free(checker.check_motion, a, b, tolerance, kind)
                assert not called_free(
                    lambda *ends, **k: checker.explain_motion(*ends, **k).free, a, b, tolerance, kind
                )
    if far >= 1e12:
        with pytest.raises(pc.PlannercheckError, match="larger tolerance"):
            checker.check_motion(start, end)


def test_hinges_of_many_turns_count_in_full():
    links = [
        P.Link("base", [[0.0, 0.0]], joint="fixed"),
        P.Link("arm", [[8, 0.0], [12, 0.0], [12, -1e-6], [8, -1e-6]], "base", joint="revolute"),
    ]
    for far in (1e12, -1e12, 3e13, -3e13):
        for side in (1, -1):
            bar = [[8, 0.0], [12, 0.0], [12, -side * 1e-6], [8, -side * 1e-6]]
            robot = P.Robot([links[0], P.Link("arm", bar, "base", joint="revolute")])
            turn = cmath.exp(1j * far)
            post, scene = 11.9 * turn * cmath.exp(-1j * side * 1e-9), P.Scene()
            scene.add_polygon("wedge", [[z.real, z.imag] for z in (post, post + side * 0.1j * turn)])
            checker = P.Checker(robot, scene)
            assert not checker.is_valid([far])
            start = [math.remainder(far, 2 * math.pi) - side * 0.2]
            with pytest.raises(pc.PlannercheckError, match="larger tolerance"):
                checker.check_motion(start, [far])
            assert not checker.check_motion(start, [far], tolerance=1e4)


@pytest.mark.parametrize("far", [0.0, 1.0, 1e3, 1e6])
def test_states_with_a_contact_are_invalid(far):
    """A speck of a few last doubles at a body's furthest vertex; single, in a batch, and on a motion."""
    generator, judged = np.random.default_rng(18), 0
    for _ in range(250):
        size = 10.0 ** generator.uniform(-4, 1)
        footprint = size * (generator.normal(size=2) + np.array([[0, 0], [1, 0.2], [0.3, 0.9]]))
        robot = P.Robot(footprint)
        q = generator.uniform(-1, 1, 3) * [far + size, far + size, 3]
        pose, vertices = robot.link_poses(q)[0], robot.bodies[0].vertices
        middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
        vertex = vertices[np.argmax(np.hypot(*(vertices - middle).T))]
        exact = [
            Fraction(pose[k, 0]) * Fraction(vertex[0])
            + Fraction(pose[k, 1]) * Fraction(vertex[1])
            + Fraction(pose[k, 2])
            for k in range(2)
        ]
        low, high = ([np.nextafter(float(value), way) for value in exact] for way in (-np.inf, np.inf))
        assert all(Fraction(a) <= value <= Fraction(b) for a, value, b in zip(low, exact, high, strict=True))
        scene = P.Scene()
        scene.add_polygon("speck", [low, [high[0], low[1]], high, [low[0], high[1]]])
        checker = P.Checker(robot, scene)
        assert not checker.is_valid(q)
        batch = np.vstack([q + np.array([50 * size, 0, 0]), *[q] * 9, q])
        assert checker.check_states(batch).tolist() == [True, *[False] * 10]
        assert not checker.check_motion(q, q + np.array([size, size, 0.1]), tolerance=max(1e-4, 1e-9 * far))
        judged += 1
    assert judged == 250


@pytest.mark.parametrize("far", [0.0, 1e3, 1e6])
def test_branches_with_a_contact_far_from_the_origin_are_invalid(far):
    """A speck on a second branch at a furthest vertex: circles are posed in doubles that are far too coarse for it."""
    generator, size = np.random.default_rng(19), 1e-4
    for _ in range(150):
        corners = size * (generator.uniform(-1, 1, 2) + np.array([[0, 0], [1, 0.2], [0.3, 0.9]]))
        base = P.Link("base", [[0.0, 0.0]], joint="free")
        branches = [
            P.Link(name, corners, "base", (*generator.uniform(-size, size, 2), 0.1), "revolute")
            for name in ("one", "two")
        ]
        q = generator.uniform(-1, 1, 5) * [far, far, 3, 3, 3]
        _, one, two = P.Robot([base, *branches]).link_poses(q)
        middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
        vertex = corners[np.argmax(np.hypot(*(corners - middle).T))]
        m, n = ([[Fraction(value) for value in row] for row in pose[:2].tolist()] for pose in (one, two))
        way = [m[k][0] * Fraction(vertex[0]) + m[k][1] * Fraction(vertex[1]) + m[k][2] - n[k][2] for k in range(2)]
        det = n[0][0] * n[1][1] - n[0][1] * n[1][0]
        x = float((way[0] * n[1][1] - way[1] * n[0][1]) / det)
        y = float((way[1] * n[0][0] - way[0] * n[1][0]) / det)
        speck = [x, y] + 1e-14 * size * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        robot = P.Robot([base, branches[0], P.Link("two", speck, "base", branches[1].anchor, "revolute")])
        checker = P.Checker(robot)
        assert not checker.is_valid(q)
        assert not checker.check_states(np.repeat(q[None], 9, axis=0)).any()


def test_tiny_bodies_that_touch_are_never_apart():
    """Squares of lengths about 1e-162 m are a few of the least doubles."""
    for scale in (1e-140, 1e-155, 1e-161, 1.5e-162, 1.6e-162, 1.8e-162, 5e-163, 1e-200, 1e-310):
        for k in range(10):
            a = scale * (1 + k / 10)
            for x, y in ((a, a), (a, -a), (-a, 0.3 * a), (0.9 * a, a)):
                scene = P.Scene()
                scene.add_polygon("point", [[0.0, 0.0]])
                assert not P.Checker(P.Robot([[0, 0], [2 * x, 2 * y]]), scene).is_valid([0, 0, 0])
                links = [
                    P.Link("base", [[9.0, 9.0]], joint="free"),
                    P.Link("one", [[0, 0], [2 * x, 2 * y]], "base", joint="revolute"),
                    P.Link("two", [[0, 0], [-x, -y]], "base", joint="revolute"),
                ]
                assert not P.Checker(P.Robot(links)).is_valid(np.zeros(5))


def test_directions_of_any_length_are_normalised():
    """Gaps in a motion's proofs are along directions of length 1, as exact fractions tell."""
    generator, seen = np.random.default_rng(15), 0
    for scale in (1e-170, 1e-160, 1e-120, 1e-3, 1.0, 1e3):
        robot = P.Robot(scale * np.array([[-1, -0.5], [1, -0.5], [0.9, 0.5]]))
        scene = P.Scene()
        scene.add_polygon("post", scale * np.array([[3.0, 4.0], [3.1, 4.2], [2.9, 4.3]]))
        q = generator.uniform(-1, 1, 3) * [scale, scale, 1]
        verdict = P.Checker(robot, scene).explain_motion(
            q, q + np.array([0, 0, 0.1]), proofs=True, tolerance=1e-4 * max(scale, 1)
        )
        for proof in verdict.proofs:
            x, y = (Fraction(float(value)) for value in proof.normal)
            assert abs(x * x + y * y - 1) < Fraction(1, 2**48)
            seen += 1
    assert seen >= 2


# ----- curves


@pytest.mark.parametrize(("curve", "radius"), CURVES)
def test_hinges_move_while_the_root_stands(curve, radius):
    """A trailer swings through a post; the truck's pose is the same at both ends."""
    scene = P.Scene()
    scene.add_polygon("post", [[-6.0, 0.0]])
    checker = P.Checker(P.Robot.load("truck_trailer"), scene)
    kind = {"curve": curve, "turning_radius": radius}
    for root in ([0, 0, 0.0], [0.0, 0.0, 2 * math.pi]):
        q0, q1 = [0, 0, 0, -1.0, 0.0], [*root, 1.0, 0.0]
        assert checker.is_valid(q0)
        assert checker.is_valid(q1)
        assert not checker.check_motion(q0, q1, **kind)
        assert not checker.check_motion(q0, q1, 0.01, **kind)
        assert checker.explain_motion(q0, q1, **kind).collides_at == pytest.approx(0.25, abs=0.25)
        assert checker.check_motion(q0, [*root, -0.9, 0.0], **kind)
    assert not checker.check_motion([0, 0, 0, 0.0, 0], [0, 0, 0, 1.0, 0], **kind)  # the start collides


@pytest.mark.parametrize(
    ("curve", "space"), [("dubins", base.DubinsStateSpace), ("reeds_shepp", base.ReedsSheppStateSpace)]
)
@pytest.mark.parametrize(("radius", "offset"), [(0.3, 0.0), (0.3, 5.0), (4.0, 0.0), (20.0, 2.0)])
def test_curves_with_a_contact_are_refused(curve, space, radius, offset):
    """A vertex at a state of OMPL's own curve, on the outside of its way or anywhere, also on a trailer."""
    generator, ompls = np.random.default_rng(17), space(radius)
    states, judged = [ompls.allocState() for _ in range(3)], 0
    for _ in range(80):
        links = [P.Link("car", offset + 0.01 * np.array([[0, 0], [1, 0], [0.5, 1]]), joint="free")]
        if generator.random() < 0.5:
            links.append(
                P.Link("trailer", -offset - 0.01 * np.array([[0, 0], [1, 0], [0.5, 1]]), "car", (-1, 0, 0), "revolute")
            )
        robot = P.Robot(links)
        q0, q1 = generator.uniform(-1, 1, (2, robot.nq)) * [2 * radius, 2 * radius, 3, *[1] * (robot.nq - 3)]
        q1[3:] = q0[3:] + 0.3 * q1[3:]
        t, link = float(generator.uniform(0.02, 0.98)), links[-1]
        vertex = link.footprint[int(generator.integers(3))]

        def place(s, q0=q0, q1=q1, links=links, link=link, vertex=vertex):
            for state, q in zip(states, (q0, q1), strict=False):
                state.setX(q[0])
                state.setY(q[1])
                state.setYaw(q[2])
            ompls.interpolate(*states[:2], s, states[2])
            root = states[2].getX(), states[2].getY(), states[2].getYaw()
            return posed_vertex(links, link.name, vertex, [*root, *((1 - s) * q0[3:] + s * q1[3:])])

        here, before, after = place(t), place(t - 1e-4), place(t + 1e-4)
        if abs(before + after - 2 * here) > 0.1 * abs(after - before):
            continue  # a cusp
        scene = P.Scene()
        scene.add_polygon("post", grazing_wedge(here, before, after, generator))
        checker = P.Checker(robot, scene)
        kind = {"curve": curve, "turning_radius": radius}
        assert not checker.check_motion(q0, q1, **kind)
        assert not checker.explain_motion(q0, q1, proofs=True, **kind).free
        judged += 1
    assert judged > 50


@pytest.mark.parametrize("slip", [1e-3, 1e-2, 1e-6])
def test_the_slip_of_a_piece_counts(slip):
    """A piece that may be off by its slip is not free at a gap of less."""
    robot, scene = P.Robot([[-1, -1], [1, -1], [1, 1], [-1, 1]]), P.Scene()
    scene.add_polygon("wall", [[-9, 1], [9, 1], [9, 2], [-9, 2]])
    checker = P.Checker(robot, scene)
    for gap, turn, free in ((0.9 * slip, 0.0, False), (6 * slip + 3e-4, 0.0, True), (0.9 * slip, 1e-9, False)):
        q0, q1 = np.array([-5, -gap, 0.0]), np.array([5, -gap, turn])
        pieces = np.array([[0.0, 1.0, -5, -gap, 10, 0, 0, turn, 0, 0, slip]])
        assert checker.motion_certifier.is_free(q0, q1, 1e-7, pieces) == free
        assert checker.motion_certifier.motion_result(q0, q1, 1e-7, pieces=pieces).free == free
