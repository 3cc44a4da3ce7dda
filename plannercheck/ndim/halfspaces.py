"""Intersections of halfspaces A x ≤ b: whether they are empty or bounded, and their centre.

In: normals and offsets in doubles, taken as exact. Out: `Examined`, or an error that names a ray or says that the
intersection is empty. Linear programs (HiGHS through SciPy) guess; bounds or integers prove.

Boundedness, proved in doubles: for each of the 2 d unit directions e, multipliers μ ≥ 0 with A'μ about e. If the
residuals are at most 1/2 in the sum norm, no ray fits (its largest entry would be less than itself), and the largest
coordinate is at most max b·μ / (1 - residual). Where that fails, integers decide, and their proof is a ray.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.errors import PlannercheckError
from plannercheck.ndim.exact import ExactSeparation, Guess, decide
from plannercheck.ndim.integers import Farkas, matrix_of, solve
from plannercheck.ndim.posed import ExactRows
from plannercheck.ndim.poses import LARGEST, identity
from plannercheck.ndim.qhull import part_of_scipy
from plannercheck.ndim.rounding import UNDERFLOW, UNIT

# As a part of the body's extent: a smaller Chebyshev radius leaves qhull and polars no room.
_INSIDE = 1e-9


@dataclass(frozen=True)
class Examined(OwnsArrays):
    """A bounded, nonempty intersection of halfspaces.

    Attributes:
        centre: Centre of a largest ball inside (d,), rounded.
        has_inside: Whether that ball is clearly larger than a point.
        box: (2, d): no point is outside, proved.
    """

    centre: Floats
    has_inside: bool
    box: Floats


def examine(normals: Floats, offsets: Floats, name: str) -> Examined:
    """Looks at halfspaces normals (m, d) · x ≤ offsets (m,): their centre and a box.

    Raises:
        PlannercheckError: If the body is empty or unbounded; the error calls it by its name.
    """
    box = _box(normals, offsets, name)
    reach = float(np.abs(box).max())
    centre, radius = _chebyshev(normals, offsets)
    has_inside = radius > _INSIDE * max(reach, 1e-300) and bool((normals @ centre < offsets).all())
    if not has_inside:
        centre = _some_point(normals, offsets, centre, name)
    return Examined(centre, has_inside, box)


def lengths(normals: Floats) -> Floats:
    """Lengths of the normals, 1 for a normal that is 0."""
    sizes = np.linalg.norm(normals, axis=1)
    return np.where(sizes > 0, sizes, 1.0)


def _chebyshev(normals: Floats, offsets: Floats) -> tuple[Floats, float]:
    d = normals.shape[1]
    sizes = np.linalg.norm(normals, axis=1)
    answer = part_of_scipy("optimize").linprog(
        np.append(np.zeros(d), -1.0), A_ub=np.column_stack([normals, sizes]), b_ub=offsets, bounds=(None, None)
    )
    if answer.x is None:
        return np.zeros(d), -1.0
    return np.asarray(answer.x[:d]), float(answer.x[d])


def _some_point(normals: Floats, offsets: Floats, guess: Floats, name: str) -> Floats:
    """A point in all halfspaces, from integers; the error if there is none."""
    close = np.argsort(normals @ guess - offsets)[::-1][: 2 * len(guess) + 2]
    first, second = (ExactRows(normals, offsets, identity(len(guess))) for _ in range(2))
    found, _ = decide(first, second, Guess(tuple(close.tolist()), (int(close[0]),)))
    if isinstance(found, ExactSeparation):
        active = sorted({*found.rows_p, *found.rows_r})
        raise PlannercheckError(f"{name} is empty: no point is in all halfspaces, not even in those of rows {active}")
    return np.array([x / found.denominator for x in found.point])


def _box(normals: Floats, offsets: Floats, name: str) -> Floats:
    """A box around the body (2, d); the error that names a ray if there is none."""
    d = normals.shape[1]
    sizes = lengths(normals)
    residuals, heights = np.zeros(2 * d), np.zeros(2 * d)
    for k, unit in enumerate(np.concatenate([np.eye(d), -np.eye(d)])):
        weights = _multipliers(normals / sizes[:, None], offsets / sizes, unit) / sizes
        used = np.flatnonzero(weights)
        rounding = 2 * (len(used) + 4) * UNIT
        residual = np.abs(weights[used] @ normals[used] - unit) + rounding * (weights[used] @ np.abs(normals[used]) + 1)
        residuals[k] = residual.sum()
        heights[k] = weights[used] @ offsets[used] + rounding * (weights[used] @ np.abs(offsets[used]))
    if residuals.max() < 0.5:
        reach = max(0.0, float(heights.max()) / (1 - float(residuals.max())))
        heights += residuals * reach
    else:
        heights = _exact_heights(normals, offsets, name)
    # Rounded outwards generously: this only bounds.
    heights += 1e-12 * np.abs(heights) + UNDERFLOW
    return np.array([-heights[d:], heights[:d]])


def _multipliers(normals: Floats, offsets: Floats, unit: Floats) -> Floats:
    """Multipliers μ ≥ 0 with A'μ about a unit direction and b·μ least; all 0 if the linear program finds none."""
    answer = part_of_scipy("optimize").linprog(-unit, A_ub=normals, b_ub=offsets, bounds=(None, None))
    return np.zeros(len(offsets)) if answer.status != 0 else np.maximum(-np.asarray(answer.ineqlin.marginals), 0.0)


def _exact_heights(normals: Floats, offsets: Floats, name: str) -> Floats:
    """Bounds of the 2 d coordinates ±x_k, from exact multipliers."""
    d = normals.shape[1]
    columns, unit = matrix_of(normals)
    heights = np.zeros(2 * d)
    for k in range(2 * d):
        right = [0] * d
        right[k % d] = 1 if k < d else -1
        answer = solve(columns, right)
        if isinstance(answer, Farkas):
            raise PlannercheckError(_unbounded(answer, name))
        scale = answer.denominator * Fraction(2) ** unit
        exact = sum((w * Fraction(float(offsets[j])) for j, w in answer.weights.items()), Fraction(0)) / scale
        if abs(exact) > LARGEST:
            raise PlannercheckError(f"{name} reaches further than {LARGEST:g}: scale it to be smaller")
        heights[k] = float(exact)
    return heights


def _unbounded(answer: Farkas, name: str) -> str:
    largest = max(abs(x) for x in answer.row)
    ray = [x / largest for x in answer.row]
    return (
        f"{name} is unbounded: its halfspaces bound no polytope, the ray {ray} stays inside all of them; "
        "add halfspaces that bound it"
    )
