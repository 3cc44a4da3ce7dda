"""Nearest points of two convex bodies, with counted work: for few points, and by extreme vertices.

In: points, or for each body a function from a direction to its furthest vertex. Out: nearest points as mixtures of
vertices; whether bodies share a point. In doubles and in plain Python, for the baselines of `bench complexity`: no
verdict of the library depends on it.

The point of a hull of points d_k nearest to the origin: the weights w >= 0 that minimise |Σ w_k d_k|² + (1 − Σ w_k)²
are a multiple of the weights of this point, since for any given sum of weights the first term is least there (Lawson
and Hanson 1974; solved by Stark and Parker's bounded least squares, 1995).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeAlias

import numpy as np

from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.errors import PlannercheckError

# From a direction (3,) to the furthest vertex (3,).
Support: TypeAlias = Callable[[Floats], Floats]

# m, for bodies of about 1 m: closer than this is contact. Least squares leave about 1e-13 of a squared distance.
TOUCHING = 1e-6
# Rounding leaves such weights of points that are put aside.
_NO_WEIGHT = 1e-12
# Near contact, rounding may let rounds go on without progress.
_MOST_ROUNDS = 100


@dataclass(frozen=True, eq=False)
class Nearest:
    """The nearest points of two bodies.

    Attributes:
        first: The point of the first body (3,), m.
        second: The point of the second body (3,), m.
        first_vertices: Positions of the points that `first` mixes: all of them on the tangent plane.
        second_vertices: The same for `second`.
    """

    first: Floats
    second: Floats
    first_vertices: Ints64
    second_vertices: Ints64

    @property
    def apart(self) -> Floats:
        """From the second point to the first (3,), m."""
        return np.asarray(self.first - self.second)

    @property
    def distance(self) -> float:
        """Length of `apart`, m."""
        return float(np.linalg.norm(self.apart))

    @property
    def is_contact(self) -> bool:
        """Whether the bodies share a point, as far as doubles can tell."""
        return self.distance < TOUCHING


def nearest_of_few(first: Floats, second: Floats) -> Nearest:
    """The nearest points of the hulls of few points, (n, 3) and (k, 3), m."""
    weights = _weights((first[:, None] - second[None]).reshape(-1, 3)).reshape(len(first), len(second))
    of_first, of_second = weights.sum(axis=1), weights.sum(axis=0)
    return Nearest(of_first @ first, of_second @ second, np.flatnonzero(of_first), np.flatnonzero(of_second))


def share_a_point(first: Support, second: Support, start: Floats) -> tuple[bool, int]:
    """Whether two bodies share a point, by Gilbert, Johnson and Keerthi (1988): stops at the first separating plane.

    It starts with a direction (3,), about from the second to the first, and counts rounds of supports.
    """
    actives = np.zeros((0, 3))
    apart = start
    for rounds in range(1, _MOST_ROUNDS + 1):
        difference = first(-apart) - second(apart)
        if apart @ difference > 0:
            return False, rounds
        actives = np.vstack([actives, difference])
        weights = _weights(actives)
        apart = weights @ actives
        if np.linalg.norm(apart) < TOUCHING:
            return True, rounds
        actives = actives[weights > 0]
    return True, _MOST_ROUNDS


def _weights(points: Floats) -> Floats:
    """Weights of sum 1 that mix the point of a hull nearest to the origin."""
    rows = np.vstack([points.T, np.ones(len(points))])
    # Not `nnls`: SciPy 1.15, the last one for Python 3.10, ends before the optimum.
    weights = _optimize().lsq_linear(rows, np.array([0.0, 0.0, 0.0, 1.0]), (0, np.inf), method="bvls", tol=1e-15).x
    weights[weights < _NO_WEIGHT] = 0
    return np.asarray(weights / weights.sum())


@cache
def _optimize() -> Any:
    """scipy.optimize, which is an extra."""
    try:
        import scipy.optimize
    except ImportError as error:
        raise PlannercheckError("bench complexity needs SciPy: pip install 'plannercheck[bench]'") from error
    return scipy.optimize
