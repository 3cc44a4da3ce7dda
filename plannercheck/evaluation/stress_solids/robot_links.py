"""Draws of the stress of solids from robots: two links of a pair that is tested, turned as in a random state.

In: a seed and a number. Out: a `Draw`: a mesh as it is, and another or a convex body, at poses about moments at which
they begin to touch.

Random states rarely come near contact, so the first link is moved until both begin to touch: every state of a robot is
at some offset from such a contact.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from plannercheck.bodies.solids import Solid
from plannercheck.evaluation.stress_solids.bodies import Body
from plannercheck.evaluation.stress_solids.draws import Draw
from plannercheck.evaluation.stress_solids.placing import OFFSETS, Place, around_contact
from plannercheck.evaluation.stress_solids.surfaces import surface
from plannercheck.motions.checker import Checker
from plannercheck.robots.description import description_of, shipped_robots
from plannercheck.robots.geometry_choices import of_meshes

# Moments of contact of the same two links.
_CONTACTS = 2


def link_draw(seed: int, number: int) -> Draw:
    """The `number`-th draw of a seed, which can be made again alone; the shipped robots take turns."""
    rng = np.random.default_rng([seed, number])
    robots = shipped_robots()
    robot = robots[number % len(robots)]
    checker = _checker(robot)
    pairs = _pairs(robot)
    a, b = rng.permutation(pairs[rng.integers(len(pairs))]).tolist()
    p, r = _body(robot, a), _body(robot, b)
    poses = []
    for state in checker.robot.random_configurations(_CONTACTS, int(rng.integers(2**31))):
        (posed,) = checker.body_poses(state[None])
        poses.append(around_contact(p, r, Place(posed[a, :3, :3], posed[b]), rng))
    label = f"{robot}: {checker.bodies[a].name} | {checker.bodies[b].name}"
    poses_p, poses_r = (np.concatenate(part) for part in zip(*poses, strict=True))
    return Draw(robot, label, p, r, poses_p, poses_r, tuple(OFFSETS) * _CONTACTS)


@cache
def _checker(robot: str) -> Checker:
    return Checker(of_meshes(description_of(robot)))


@cache
def _pairs(robot: str) -> list[list[int]]:
    """Those that are tested, of a mesh and another one, or a body with facets."""
    checker = _checker(robot)
    is_mesh = np.array([isinstance(body.shape, Solid) for body in checker.bodies])
    has_facets = np.array([polytope is not None and polytope.dimension == 3 for polytope in checker.polytopes])
    taken = is_mesh[checker.pairs].any(axis=1) & (is_mesh | has_facets)[checker.pairs].all(axis=1)
    return list(checker.pairs[taken].tolist())


@cache
def _body(robot: str, k: int) -> Body:
    checker = _checker(robot)
    shape, polytope = checker.bodies[k].shape, checker.polytopes[k]
    if isinstance(shape, Solid):
        return Body(robot, surface(*shape.used))
    assert polytope is not None
    return Body(robot, surface(polytope.vertices, polytope.faces), polytope.inflation_radius, is_convex=True)
