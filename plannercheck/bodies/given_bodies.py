"""Bodies of pair queries as users give them: prepared bodies, at poses or not, and the shapes of `given_shapes`.

In: any of these, with a pose or many. Out: a prepared `Polytope` and its poses in the world.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.given_shapes import GivenShape, given_shape, in_frame, is_geometry, points_given
from plannercheck.bodies.placed import Placed
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import RIGID_TOLERANCE, checked_pose, checked_poses, inflated_hull
from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError

# What a query on a pair takes as one of its bodies.
GivenBody: TypeAlias = Polytope | Placed | GivenShape

# Queries on a pair in one call of the core, which checks bodies and poses itself: the answer for `Polytope` and
# `Placed` with poses in NumPy arrays of doubles that are surely rigid, else None: then arguments are converted here.
queries: Any = core.PairQueries(Polytope, Placed, RIGID_TOLERANCE)


def given_polytope(value: GivenBody, pose: ArrayLike | None, name: str) -> tuple[Polytope, Floats]:
    """A prepared body and its pose (4, 4) in the world, m; a `Polytope` is taken as it is.

    Args:
        value: A `Polytope`, or what `given_shape` takes; cylinders and cones are the polytopes around them. Or a
            `Placed`, which has its pose.
        pose: The body's pose in the world; None is the identity.
        name: The argument's name in errors: "P", whose pose is called "pose_p".
    """
    if isinstance(value, Placed):
        if pose is not None:
            raise PlannercheckError(f"{name} is a Placed, which has its pose: leave pose_{name.lower()} out")
        return value.polytope, value.pose
    placed = checked_pose(pose, f"pose_{name.lower()}")
    if isinstance(value, Polytope):
        return value, placed
    if not is_geometry(value):
        with error_context(name):
            points = points_given(value)
        return Polytope(points, name=name), placed
    shape, own = given_shape(value, name)
    body = Polytope.of_shape(shape, 0.0, lambda: Polytope(*inflated_hull(shape), name=name))
    return body, in_frame(placed, own, name)


def given_polytope_at_poses(value: GivenBody, poses: ArrayLike | None, name: str) -> tuple[Polytope, Floats]:
    """The same for many poses (n, 4, 4), m, which come back in C order; or for one pose, and n is 1."""
    if poses is None or not are_poses(poses):
        polytope, pose = given_polytope(value, poses, name)
        return polytope, np.ascontiguousarray(pose[None])
    polytope, own = given_polytope(value, poses if isinstance(value, Placed) else None, name)
    rows = checked_poses(poses, f"pose_{name.lower()}")
    return polytope, np.array([in_frame(row, own, name) for row in rows], dtype=np.float64).reshape(-1, 4, 4)


def are_poses(poses: ArrayLike | None) -> bool:
    """Whether these are many poses, not one: an array of three dimensions, whatever its numbers."""
    try:
        return poses is not None and np.ndim(poses) == 3
    except (TypeError, ValueError):  # e.g. lists of different lengths
        return False
