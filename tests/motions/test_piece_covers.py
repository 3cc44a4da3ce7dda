"""Straight motions that cover several pieces of a trajectory: contacts by construction, verdicts without them."""

import numpy as np
import pytest
from test_curves import slider, through

import plannercheck as pc
from plannercheck.evaluation.bench.trajectories import free_trajectories
from plannercheck.evaluation.stress_motions.relatives import cut

PLAIN = pc.Tuning(covers=False)


def needle(robot, **settings):
    scene = pc.Scene("needle")
    scene.add_box("needle", (1e-4, 1e-4, 1.0))
    return pc.Checker(robot, scene, **settings)


def dense(points, halvings):
    """The trajectory of a curve in so many halves of halves."""
    pieces = [points]
    for _ in range(halvings):
        pieces = [half for piece in pieces for half in cut(piece, 0.5)]
    return pc.Trajectory.bezier(np.arange(len(pieces) + 1.0), np.array(pieces))


def judged(checker):
    return checker.motion_certifier.statistics()["motions"]


@pytest.mark.parametrize("tube", [0.0, 0.01])
def test_a_dense_curve_through_a_contact_is_never_free(tube, tmp_path):
    """The contact may be at a corner of the tube."""
    checker, rng = needle(slider(tmp_path)), np.random.default_rng(3)
    for _ in range(150):
        angle = rng.uniform(0, 2 * np.pi)
        away = np.array([np.cos(angle), np.sin(angle)])
        state = (0.1 - 1e-6) * away + tube * np.sign(away)
        at = float(rng.choice([0.0, 0.25, 1 / 3, 0.5, 0.7, 1.0]))
        points = through(rng, state, at, int(rng.integers(1, 6)), 10.0 ** rng.uniform(-4, 0))
        assert not checker.check_trajectory(dense(points, int(rng.integers(1, 6))), tube)


def test_verdicts_are_those_without_covers():
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    on, off = pc.Checker(robot, scene), pc.Checker(robot, scene, tuning=PLAIN)
    some = free_trajectories(on, 12, 2)
    before = judged(on), judged(off)
    assert on.check_trajectories(some).all()
    assert off.check_trajectories(some).all()
    assert 4 * (judged(on) - before[0]) < judged(off) - before[1] == 12 * 30
    rng, run = np.random.default_rng(5), []
    for each in some:
        q = each.points.positions
        far = np.linspace(0, 1, len(q))[:, None] * rng.normal(size=robot.nq)
        run.append(pc.Trajectory(each.points.times, q + far, controller="linear"))
    for tube in (0.0, 0.003, 0.03):
        for tolerance in (1e-5, 1e-3, 0.03):
            found = off.check_trajectories(run + some, tube, tolerance)
            assert (on.check_trajectories(run + some, tube, tolerance) == found).all()
            assert [on.check_trajectory(each, tube, tolerance) for each in run] == found[: len(run)].tolist()
            assert [on.explain_trajectory(each, tube, tolerance).free for each in run[:3]] == found[:3].tolist()
    assert 0 < found.sum() < len(found)


def test_a_cover_keeps_the_tolerance(tmp_path):
    """Curves that tremble past the needle: the bounds of each are too wide to prove it nearer than the tolerance."""
    on, off = (needle(slider(tmp_path), tuning=tuning) for tuning in (pc.Tuning(), PLAIN))
    rng, nearer = np.random.default_rng(4), []
    for gap in np.tile([0.0015, 0.02], 30):
        ends = np.stack([np.linspace(-0.3, 0.3, 9), np.full(9, 0.10005 + gap)], axis=1)
        pieces = np.linspace(ends[:-1], ends[1:], 8, axis=1)
        pieces[:, 1:-1, 1] += 9e-5 * rng.choice([-1.0, 1.0], (8, 6))
        run = pc.Trajectory.bezier(np.arange(9), pieces)
        found = off.check_trajectory(run, tolerance=0.01)
        assert on.check_trajectory(run, tolerance=0.01) == found
        nearer.append(found)
    assert all(nearer[1::2])
    assert not all(nearer[::2])


def test_pieces_of_trajectories_that_do_not_meet_have_no_cover(tmp_path):
    """The first trajectory ends in a contact, just where no control point of the second one is."""
    checker = needle(slider(tmp_path))
    first = pc.Trajectory([0, 1], [[0.13, 0.0], [0.1, 0.0]], controller="linear")
    second = pc.Trajectory([0, 1], [[0.125, 0.0], [0.12, 0.0]], controller="linear")
    assert checker.check_trajectories([first, second]).tolist() == [False, True]


def test_a_robot_that_stands_still_or_turns_back_is_covered(tmp_path):
    checker = needle(slider(tmp_path))
    there = np.array([[0.2, 0.0]] * 5 + [[0.19, 0.0], [0.2, 0.0], [0.21, 0.0], [0.2, 0.0]])
    before = judged(checker)
    assert checker.check_trajectory(pc.Trajectory(np.arange(9), there, controller="linear"))
    assert judged(checker) - before == 1
    there[6, 0] = 0.1  # it touches where it turns
    assert not checker.check_trajectory(pc.Trajectory(np.arange(9), there, controller="linear"))
