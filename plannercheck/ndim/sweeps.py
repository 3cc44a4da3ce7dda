"""Moving bodies in space-time: the hull of the set that a body sweeps, one dimension higher.

In: vertices of a body, and its path of straight pieces, each at constant speed and without rotation. Out: a `Polytope`
for each piece, in the coordinates of space followed by time. Two bodies collide at some time if and only if two of
their pieces share a point: a certificate's common point says where and when.

Why that is exact: at any time of a piece, the body is an interpolation between its positions at both ends, so it sweeps
exactly the hull of both. A rotating body sweeps a set that is not convex: cut its motion into short pieces and enlarge
the body a little, or use `Checker.check_motion`.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.arrays import named_numbers
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module
from plannercheck.ndim.bodies import Polytope


@set_module("plannercheck.ndim")
def sweeps(vertices: ArrayLike, waypoints: ArrayLike, times: ArrayLike, name: str = "body") -> list[Polytope]:
    """The sets that a body sweeps on its path, piece by piece.

    Args:
        vertices: (n, d), m; d = 3 in space.
        waypoints: Where its origin is (k, d), m, k at least 2. Vertices at a waypoint are sums of doubles, rounded.
        times: When (k,), s, ascending.
        name: What errors call it.

    Returns:
        k - 1 polytopes in dimension d + 1.
    """
    body, ways = named_numbers(vertices, f"{name}: vertices"), named_numbers(waypoints, f"{name}: waypoints")
    moments = named_numbers(times, f"{name}: times")
    if body.ndim != 2 or ways.ndim != 2 or ways.shape[1] != body.shape[1] or len(ways) < 2:
        raise PlannercheckError(
            f"{name}: vertices (n, d) and at least two waypoints (k, d) are expected, not {body.shape} and {ways.shape}"
        )
    if moments.shape != (len(ways),) or not (np.diff(moments) > 0).all():
        raise PlannercheckError(f"{name}: {len(ways)} waypoints need as many times, ascending, not {moments.tolist()}")
    at = [np.column_stack([body + way, np.full(len(body), time)]) for way, time in zip(ways, moments, strict=True)]
    return [Polytope(np.concatenate(ends), name=f"{name}, piece {k}") for k, ends in enumerate(pairwise(at))]
