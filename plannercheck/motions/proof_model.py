"""A checker's robot, scene and pairs as the plain data of a proof.

In: a checker in space. Out: `Model`: the kernel's joint table in the URDF's terms, the bodies of all pairs with the
vertices of their hulls, and all of the checker's pairs, unreachable ones included.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import GeometryObject
from plannercheck.common.array_types import Floats, Ints
from plannercheck.motions.sampling import MotionSampler
from plannercheck.proofs.data import JOINT_VALUES, WORLD, Joint, Link, Model, PosedBody
from plannercheck.robots.kinematics import JointTable
from plannercheck.robots.robot import Robot

# Kinds of joints in a proof, by the kernel's kind (JointKind in cpp/robots/kinematics.hpp).
_KINDS = ("turn",) * 4 + ("circle",) * 4 + ("slide", "planar", "ball", "free")

# Rounds in which a ball's centre moves towards the furthest vertex, by a shrinking step.
_BALL_ROUNDS = 200

# Balls are enlarged by this part: far above the rounding of doubles.
_BALL_ROOM = 1 + 1e-12


class PosedPairs(Protocol):
    """The attributes of a checker from which its model is made; see `Checker`."""

    robot: Robot
    bodies: tuple[GeometryObject, ...]
    pairs: Ints
    paddings: Floats

    @property
    def motion_sampler(self) -> MotionSampler:
        """Whose whole turns a motion leaves out."""

    @property
    def polytopes(self) -> tuple[Polytope | None, ...]:
        """The hulls of `bodies`, None where no pair needs one."""


def space_model(checker: PosedPairs) -> Model:
    """The model of a checker whose robot the compiled kernel poses."""
    robot, table = checker.robot, checker.robot.joint_table
    assert table is not None
    used = np.unique(checker.pairs)
    pairs = np.searchsorted(used, checker.pairs).tolist()
    names = list(robot.model.names)[1:]
    return Model(
        tuple(_joint(table, k, names[k]) for k in range(len(table.parents))),
        tuple(
            Link(name, joint, _rows(placement))
            for name, joint, placement in zip(
                robot.link_names, table.link_joints.tolist(), table.link_placements, strict=True
            )
        ),
        tuple(_body(checker, k) for k in used.tolist()),
        tuple((a, b) for a, b in pairs),
        tuple(checker.motion_sampler.whole_turns.tolist()),
        robot.nq,
    )


def _joint(table: JointTable, k: int, name: str) -> Joint:
    kind = _KINDS[int(table.kinds[k])]
    count = JOINT_VALUES[kind]
    return Joint(
        name,
        kind,
        int(table.parents[k]),
        _rows(table.placements[k]),
        tuple(table.axes[k].tolist()),
        tuple(table.columns[k, :count].tolist()),
        tuple(table.multipliers[k, :count].tolist()),
        tuple(table.offsets[k, :count].tolist()),
    )


def _body(checker: PosedPairs, k: int) -> PosedBody:
    body, polytope = checker.bodies[k], checker.polytopes[k]
    assert polytope is not None
    link = WORLD if body.link is None else checker.robot.link_index(body.link)
    centre, reach = ball_around(polytope.vertices)
    return PosedBody(
        body.name,
        body.label,
        link,
        _rows(body.pose[:3]),
        polytope.vertices,
        polytope.inflation_radius,
        min(float(checker.paddings[k]), polytope.inflation_radius),
        tuple(centre.tolist()),
        reach,
    )


def _rows(matrix: Floats) -> tuple[float, ...]:
    return tuple(np.asarray(matrix, dtype=np.float64).ravel().tolist())


def ball_around(points: Floats) -> tuple[Floats, float]:
    """Centre (3,) and radius of a small ball that holds points (n, 3), m."""
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    best, least = centre, np.inf
    for step in range(2, _BALL_ROUNDS):
        offsets = points - centre
        distances = np.linalg.norm(offsets, axis=1)
        furthest = int(np.argmax(distances))
        if distances[furthest] < least:
            best, least = centre, float(distances[furthest])
        centre = centre + offsets[furthest] / step**1.5
    return best, least * _BALL_ROOM + 1e-280
