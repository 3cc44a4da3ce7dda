"""Curves in the forms of other libraries: powers, B-splines, Bézier curves.

In: arrays. Out: `Curve`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import named_numbers
from plannercheck.common.errors import PlannercheckError
from plannercheck.trajectories.curve import MOST_DEGREE, Curve, bernstein, check_size
from plannercheck.trajectories.rounding import UNIT, blossom_error, powers_error

# How far pieces may be apart where they meet, relative to the largest coefficient: rounding of whoever made them.
_JOINT = 1e-9


def of_polynomials(breaks: ArrayLike, coefficients: ArrayLike) -> Curve:
    """Pieces in powers of t − breaks[k].

    Args:
        breaks: (m + 1,) s, growing.
        coefficients: (m, nq, degree + 1), of 1, t − breaks[k], its square and so on.
    """
    ends = checked_breaks(breaks)
    powers = _checked(coefficients, "coefficients", ("m", "nq", "degree + 1"))
    if len(powers) != len(ends) - 1:
        raise PlannercheckError(f"{len(ends)} breaks are of {len(ends) - 1} pieces, but there are {len(powers)}")
    _check_degree(powers.shape[2] - 1)
    scales = np.diff(ends)[:, None] ** np.arange(powers.shape[2])
    scaled = [(row * scale).T for row, scale in zip(powers, scales, strict=True)]
    error = np.max([powers_error(each) for each in scaled], axis=0)
    return joined(ends, [bernstein(each) for each in scaled], error)


def of_bezier(breaks: ArrayLike, points: ArrayLike) -> Curve:
    """Bézier curves with control points (m, degree + 1, nq), in a row between breaks (m + 1,), s, growing."""
    ends = checked_breaks(breaks)
    control = _checked(points, "points", ("m", "degree + 1", "nq"))
    if len(control) != len(ends) - 1:
        raise PlannercheckError(f"{len(ends)} breaks are of {len(ends) - 1} pieces, but there are {len(control)}")
    _check_degree(control.shape[1] - 1)
    return joined(ends, list(control), np.zeros(control.shape[2]))


def of_bspline(knots: ArrayLike, points: ArrayLike) -> Curve:
    """A B-spline of control points (n, nq), from the first knot at which its basis is complete to the last.

    The knots (n + degree + 1,), s, are not falling.
    """
    places, control = _checked(knots, "knots", ("n + degree + 1",)), _checked(points, "points", ("n", "nq"))
    degree = len(places) - len(control) - 1
    if degree < 1 or len(control) <= degree:
        raise PlannercheckError(
            f"{len(places)} knots and {len(control)} points are no B-spline: with n points, there are n + degree + 1"
            " knots, the degree is at least 1 and less than n"
        )
    _check_degree(degree)
    if (np.diff(places) < 0).any():
        raise PlannercheckError(f"knots must not fall, but knot {int(np.argmax(np.diff(places) < 0)) + 1} does")
    spans = [k for k in range(degree, len(control)) if places[k] < places[k + 1]]
    if not spans:
        raise PlannercheckError("knots must span some time")
    breaks = np.array([places[spans[0]], *(places[k + 1] for k in spans)])
    pieces = [_bezier_of_span(places, control, k, degree) for k in spans]
    return joined(breaks, pieces, blossom_error(control, degree))


def checked_breaks(breaks: ArrayLike) -> Floats:
    """(m + 1,) breaks that grow."""
    ends = _checked(breaks, "breaks", ("m + 1",))
    if len(ends) < 2 or not (np.diff(ends) > 0).all():
        raise PlannercheckError("breaks must be at least two times that grow")
    return ends


def joined(breaks: Floats, pieces: list[Floats], error: Floats) -> Curve:
    """A curve without jumps, of control points of pieces of degree 1 at least; breaks (m + 1,) are in s.

    What rounding leaves between two pieces goes into the later one, and into the error (nq,) of the control points.
    """
    pieces = [np.repeat(piece, 2, axis=0) if len(piece) == 1 else piece for piece in pieces]
    check_size(breaks, pieces)
    moved = np.zeros_like(error)
    for k in range(1, len(pieces)):
        before, after = pieces[k - 1][-1], pieces[k]
        size = max(np.abs(pieces[k - 1]).max(), np.abs(after).max())
        gap = np.abs(before - after[0])
        if (gap > _JOINT * size).any():
            raise PlannercheckError(
                f"pieces {k - 1} and {k} are {gap.max():.3g} apart where they meet: no robot can jump"
            )
        pieces[k] = np.concatenate([before[None], after[1:]])
        moved = np.maximum(moved, gap * (1 + 2 * UNIT))
    return Curve(breaks, tuple(pieces), error + moved)


def _bezier_of_span(knots: Floats, points: Floats, k: int, degree: int) -> Floats:
    """Control points on the span from knot k: values of the polar form at its two ends."""
    return np.stack(
        [_polar_form(knots, points, k, [knots[k]] * (degree - j) + [knots[k + 1]] * j) for j in range(degree + 1)]
    )


def _polar_form(knots: Floats, points: Floats, k: int, arguments: list[float]) -> Floats:
    """The B-spline's polar form on the span from knot k (de Boor's algorithm with an argument of its own each step)."""
    degree = len(arguments)
    d = [points[j] for j in range(k - degree, k + 1)]
    for r, u in enumerate(arguments, 1):
        for j in range(degree, r - 1, -1):
            low, high = knots[k - degree + j], knots[k + 1 + j - r]
            share = (u - low) / (high - low)
            d[j] = (1 - share) * d[j - 1] + share * d[j]
    return np.asarray(d[degree])


def _check_degree(degree: int) -> None:
    if not 0 <= degree <= MOST_DEGREE:
        raise PlannercheckError(f"the degree must be at most {MOST_DEGREE}, not {degree}")


def _checked(values: ArrayLike, name: str, shape: tuple[str, ...]) -> Floats:
    array = named_numbers(values, name)
    if array.ndim != len(shape) or 0 in array.shape:
        raise PlannercheckError(f"{name} must be ({', '.join(shape)}), not {array.shape}")
    if not np.isfinite(array).all():
        raise PlannercheckError(f"{name} must be finite")
    return array
