"""Checks that a proved motion is OMPL's motion: the same states between the same ends.

In: random numbers. Out: a `Judged`. OMPL interpolates in its own space; poses of links are compared with those on the
motion that the checker judges, mimic joints included.
"""

from __future__ import annotations

import numpy as np
from ompl import base

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress_motions.draws import FAMILIES, STRAIGHT
from plannercheck.evaluation.stress_motions.outcomes import ASTRAY, Judged
from plannercheck.evaluation.stress_motions.recipes import robot_of
from plannercheck.evaluation.stress_motions.subjects import SpaceSubject
from plannercheck.evaluation.stress_motions.trees import random_tree
from plannercheck.ompl.joint_space import JointSpace
from plannercheck.ompl.pose_parts import has_free_bodies
from plannercheck.ompl.pose_space import PoseSpace
from plannercheck.robots.robot import Robot

OMPL_FAMILY = "ompl"
_MOTIONS, _STATES = 40, 5
# Links agree up to this, m per m.
_SAME = 1e-9
# Where free bodies may be, m: wherever they are drawn.
_BOX = np.array([[-1e6] * 3, [1e6] * 3])


def judge_ompl_paths(rng: np.random.Generator) -> Judged:
    """A tree with mimics, and one with free bodies, as OMPL moves them and as they are proved."""
    judged = Judged()
    for family in ("mimic", STRAIGHT):
        recipe = random_tree(FAMILIES[family], rng)
        recipe["bodies"].append({"link": "base", "shape": ["sphere", 0.1], "pose": np.eye(4).tolist()})
        recipe["path"] = "slerp"
        robot = robot_of(recipe)
        judged.counts["motions"] += _MOTIONS
        try:
            space: JointSpace | PoseSpace
            space = PoseSpace(robot, _BOX) if has_free_bodies(robot) else JointSpace(robot)
        except PlannercheckError:  # says which joint OMPL has no space for
            judged.counts["declined"] += _MOTIONS
            continue
        _compare(space, SpaceSubject(recipe, robot), judged, rng)
    return judged


def _compare(space: JointSpace | PoseSpace, subject: SpaceSubject, judged: Judged, rng: np.random.Generator) -> None:
    q0, q1 = (subject.robot.random_configurations(_MOTIONS, rng) for _ in range(2))
    parameters = rng.random(_STATES)
    for row in range(_MOTIONS):
        theirs = _interpolated(space, q0[row], q1[row], parameters)
        ours = subject.states(q0[row], q1[row], parameters)
        if _apart(subject.robot, ours, theirs) > _SAME:
            judged.add(ASTRAY, -1, f"OMPL goes another way from {q0[row].tolist()} to {q1[row].tolist()}")


def _interpolated(space: JointSpace | PoseSpace, q0: Floats, q1: Floats, parameters: Floats) -> Floats:
    """(k, nq) as OMPL interpolates."""
    made = space.ompl_space()
    information = base.SpaceInformation(made)
    start, end = space.state(information, q0), space.state(information, q1)
    between = space.state(information, q0)
    out = []
    for t in parameters.tolist():
        made.interpolate(start, end, t, between)
        out.append(space.read(between))
    return np.array(out)


def _apart(robot: Robot, a: Floats, b: Floats) -> float:
    """How far links are apart at most, over their distance from the origin."""
    first, second = robot.link_poses(a), robot.link_poses(b)
    return float(np.abs(first - second).max() / (1 + np.abs(first).max()))
