"""Plans on which an equation holds: each configuration satisfies it, each motion is proved free."""

import subprocess
import sys

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.ompl import plan_constrained, planner_names

TOLERANCE = 1e-3


@pytest.fixture(scope="module")
def checker():
    """A Panda before a post, over which it can go."""
    scene, pose = pc.Scene("post"), np.eye(4)
    pose[:3, 3] = [0.33, 0.0, 0.3]
    scene.add_box("post", [0.1, 0.1, 0.6], pose)
    return pc.Checker(pc.Robot.load("panda"), scene)


def tilt(checker):
    """How far the hand leans, as x and y of its own z axis, which points straight down at the reference."""
    robot, k = checker.robot, checker.robot.link_index("panda_hand")
    return lambda q: robot.link_poses(q)[:, k, :2, 2]


@pytest.fixture(scope="module")
def ends():
    """The hand points down, left of the post and right of it."""
    down = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
    return down + np.eye(7)[0] * 0.6, down - np.eye(7)[0] * 0.6


def test_the_constraint_holds_all_along_and_all_motions_are_free(checker, ends):
    straight = np.linspace(*ends, 200)
    assert not checker.check_states(straight).all(), "the post must be in the way"
    found = plan_constrained(checker, *ends, tilt(checker), tolerance=TOLERANCE, seed=1, time_limit=40)
    assert found.solved, found.reason
    assert np.array_equal(found.path[[0, -1]], ends)
    assert np.linalg.norm(tilt(checker)(found.path), axis=1).max() <= TOLERANCE
    assert checker.check_motions(found.path[:-1], found.path[1:]).all()
    assert np.linalg.norm(np.diff(found.path, axis=0), axis=1).max() <= 2 * 0.05
    assert (found.path >= checker.robot.lower).all()
    assert (found.path <= checker.robot.upper).all()
    between = (found.path[:-1] + found.path[1:]) / 2
    assert np.linalg.norm(tilt(checker)(between), axis=1).max() < 0.01


def test_a_given_jacobian_is_used(checker, ends):
    """One equation whose derivatives are known: the elbow and the wrist bend alike."""
    asked = []

    def derivatives(q):
        asked.append(q)
        return np.array([[0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0]])

    def values(q):
        return q[:, 3:4] + q[:, 5:6] + 0.785

    found = plan_constrained(checker, *ends, values, derivatives, time_limit=20, seed=2, simplify=False)
    assert found.solved, found.reason
    assert asked
    assert np.abs(found.path[:, 3] + found.path[:, 5] + 0.785).max() <= TOLERANCE


@pytest.mark.parametrize("name", planner_names())
def test_every_planner_holds_to_the_constraint(checker, ends, name):
    arguments = (checker, *ends, lambda q: q[:, 3:4] + q[:, 5:6] + 0.785)
    found = plan_constrained(*arguments, planner=name, time_limit=0.15, seed=3)
    assert np.abs(found.path[:, 3] + found.path[:, 5] + 0.785).max(initial=0.0) <= TOLERANCE
    assert checker.check_motions(found.path[:-1], found.path[1:]).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"start": np.array([0.6, -0.785, 0.0, -2.356, 0.0, 1.8, 0.785])},
            r"start does not satisfy.*over the tolerance",
        ),
        ({"constraint": lambda q: q}, r"k from 1 to 6: of 3 configurations it gave \(3, 7\)"),
        ({"constraint": lambda q: 0.0}, r"it gave \(\)"),
        ({"step": 0.0}, "step must be a positive number"),
        ({"step": True}, "step must be a positive number"),
        ({"checker": None}, "checker must be a pc.Checker, not None"),
        ({"constraint": None}, "constraint and jacobian must be functions"),
        ({"planner": "RRTConect"}, "did you mean 'RRTConnect'"),
    ],
)
def test_bad_input(checker, ends, change, message):
    arguments = {"checker": checker, "start": ends[0], "goal": ends[1], "constraint": tilt(checker), **change}
    with pytest.raises(pc.PlannercheckError, match=message):
        plan_constrained(**arguments)


def test_steps_may_be_longer_than_ompl_takes(checker, ends):
    assert plan_constrained(pc.Checker(checker.robot), *ends, tilt(checker), step=1.5, seed=1).solved


def test_ends_that_collide_are_reasons(checker, ends):
    middle = (ends[0] + ends[1]) / 2
    found = plan_constrained(checker, ends[0], middle, tilt(checker))
    assert not found.solved
    assert "goal collides" in found.reason


def test_angles_are_not_for_constraints():
    kinova = pc.Checker(pc.Robot.load("kinova"))
    q = kinova.robot.reference
    with pytest.raises(pc.PlannercheckError, match="bounded joints only, not for j2s6s200_joint_1"):
        plan_constrained(kinova, q, q, lambda q: q[:, :1])


PROGRAM = """
import plannercheck as pc
checker = pc.Checker(pc.Robot.load("panda"))
start = [0.3, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
goal = [-0.3, *start[1:]]
found = pc.ompl.plan_constrained(checker, start, goal, lambda q: q[:, 3:4] + q[:, 5:6] + 0.785, seed=1)
assert found.solved
"""


def test_a_program_leaves_no_leaks():
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    assert done.stderr == ""
