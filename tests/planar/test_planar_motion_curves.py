"""Planar motions on Dubins and Reeds-Shepp curves: the pieces are OMPL's, and OMPL's planners run on their verdicts."""

import math

import numpy as np
import pytest
from ompl import base
from planar_motions import KINDS, TOLERANCE, P, clearances, curve_of, motions, states_of

import plannercheck as pc
from plannercheck.ompl import plan, space_of
from plannercheck.planar.curves import Curves

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
