"""Checkers of solids, and what of their verdicts hulls and surfaces do not share.

In: a robot's name, a checker, a configuration. Out: the checker of a robot's meshes as they are; the same with hulls in
their place; which colliding pairs are one body inside another, which libraries of surfaces call free.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import GeometryObject, Hull
from plannercheck.bodies.solids import Solid
from plannercheck.common.array_types import Bools, Floats, Ints64
from plannercheck.common.arrays import distinct
from plannercheck.common.core import core
from plannercheck.motions.checker import Checker
from plannercheck.robots.description import description_of
from plannercheck.robots.geometry_choices import of_meshes, of_triangles


def checker_of_meshes(robot: str) -> Checker:
    """A robot, by name or file, in no scene: all meshes as they are, open ones closed by caps."""
    return Checker(of_meshes(description_of(robot)))


def checker_of_triangles(robot: str) -> Checker:
    """A robot, by name or file, in no scene: all meshes as they are, open ones as their triangles alone."""
    return Checker(of_triangles(description_of(robot)))


def has_solids(checker: Checker, open_only: bool = False) -> bool:
    """Whether some pair is of a mesh as it is, be it that this is its hull; or of an open one."""
    shapes = [checker.bodies[k].shape for k in distinct(checker.pairs).tolist()]
    return any(isinstance(shape, Solid) and not (open_only and not shape.is_open) for shape in shapes)


def with_hulls(checker: Checker, open_only: bool = False) -> Checker:
    """The same with the hulls of all solids, or of the open ones, in their place."""
    hulls = {}
    for k in distinct(checker.pairs).tolist():
        body, polytope = checker.bodies[k], checker.polytopes[k]
        if isinstance(body.shape, Solid) and polytope is not None and not (open_only and not body.shape.is_open):
            hulls[k] = as_hull(body, polytope)
    return substituted(checker, hulls)


def as_hull(body: GeometryObject, polytope: Polytope) -> GeometryObject:
    """A body as the hull of a polytope's vertices."""
    return GeometryObject(body.name, body.link, body.pose, Hull(polytope.vertices))


def substituted(checker: Checker, substitutes: Mapping[int, GeometryObject]) -> Checker:
    """The same with other bodies, by index, in place of some."""
    bodies = [substitutes.get(k, body) for k, body in enumerate(checker.bodies)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of static pairs, which the exact checker has given
        return checker.with_bodies(bodies)


def nested_pairs(checker: Checker, state: Floats) -> tuple[Ints64, Bools]:
    """The pairs that collide in a state (nq,): their indices (k,), and which are one body inside the other (k,)."""
    (colliding,), (poses,) = checker.colliding_pairs(state[None]), checker.body_poses(state[None])
    found = np.flatnonzero(colliding)
    nested = [is_nested(*posed) for posed in (posed_pair(checker, k, poses) for k in found.tolist())]
    return found, np.array(nested, dtype=bool)


def posed_pair(checker: Checker, pair: int, poses: Floats) -> tuple[Polytope, Polytope, Floats, Floats]:
    """Both bodies of a pair of a checker, and their poses (4, 4), given those of all bodies."""
    a, b = checker.pairs[pair].tolist()
    p, r = checker.polytopes[a], checker.polytopes[b]
    assert p is not None
    assert r is not None
    return p, r, poses[a], poses[b]


def is_nested(p: Polytope, r: Polytope, pose_p: Floats, pose_r: Floats) -> bool:
    """Whether two posed bodies share points although their surfaces do not meet."""
    return core.solids_contact(p.core, pose_p, r.core, pose_r)[0] in ("a in b", "b in a")
