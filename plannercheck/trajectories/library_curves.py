"""Curves as objects of drake, ndcurves and SciPy.

In: an object, known by its attributes, so that no library is imported. Out: `Curve`.

| object | known by |
| --- | --- |
| drake PiecewisePolynomial | `getPolynomialMatrix`, `get_segment_times`: powers of t − its segment's start |
| drake BsplineTrajectory; SciPy BSpline | `basis().knots()`, `control_points()`; `t`, `c`, `k` |
| drake BezierCurve; ndcurves bezier | `BernsteinBasis`, `control_points()`; `waypoints()`, `min()`, `max()` |
| drake CompositeTrajectory; ndcurves piecewise, exact_cubic | their parts one after the other |
| drake PathParameterizedTrajectory | `path()` of `time_scaling()`, where their breaks let that be polynomials |
| ndcurves polynomial | `coeff()`: powers of t − min() |
| SciPy PPoly and CubicSpline; BPoly | `c` and `x`, falling powers of t − x[k]; Bernstein coefficients |

The curve is compared with the object's values between the breaks, so an object whose attributes mean something else,
e.g. an ndcurves bezier with a factor, is refused.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from math import comb
from typing import Any

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.shown_times import shown_span
from plannercheck.trajectories.curve import MOST_DEGREE, Curve
from plannercheck.trajectories.forms import joined, of_bezier, of_bspline, of_polynomials
from plannercheck.trajectories.limits import extremes
from plannercheck.trajectories.rounding import UNIT

# How far an object's own values may be from the curve, relative to the largest control point: rounding of both.
_AGREEMENT = 1e-9

# How far parts may be apart in time, or a time scaling beyond a break of its path, relative to the whole time.
_INSTANT = 1e-12


def of_library(thing: Any) -> Curve:
    """The curve that an object of a library is.

    Raises:
        PlannercheckError: If it is none of those above, is no vector in time, or is no row of polynomials.
    """
    name = type(thing).__name__
    reader = next((read for attributes, read in _READERS if all(hasattr(thing, each) for each in attributes)), None)
    if reader is None:
        raise PlannercheckError(
            "a curve is given by arrays, or by an object of drake (PiecewisePolynomial, BsplineTrajectory, BezierCurve,"
            " CompositeTrajectory, PathParameterizedTrajectory), ndcurves (bezier, polynomial, piecewise, exact_cubic;"
            f" others by its convert_to_bezier) or SciPy (PPoly, CubicSpline, BPoly, BSpline), not by {name}"
        )
    try:
        curve = reader(thing)
    except PlannercheckError as error:
        raise PlannercheckError(f"{name}: {error}") from None
    _check_agreement(curve, thing, name)
    return curve


def _check_agreement(curve: Curve, thing: Any, name: str) -> None:
    value: Callable[[float], Any] = getattr(thing, "value", thing)
    size = max(float(np.abs(control).max()) for control in curve.pieces)
    for k, control in enumerate(curve.pieces):
        start, end = curve.breaks[k : k + 2]
        times = start + (end - start) * (np.arange(len(control)) + 0.5) / len(control)
        own = np.array([np.ravel(value(time)) for time in times.tolist()], dtype=np.float64)
        found = curve.at(times)
        if own.shape != found.shape or not (np.abs(own - found) <= _AGREEMENT * size).all():
            raise PlannercheckError(
                f"{name}: its own values differ from those that its attributes give from {shown_span(start, end)}"
            )


def _piecewise_polynomial(thing: Any) -> Curve:
    matrices = [thing.getPolynomialMatrix(k) for k in range(thing.get_number_of_segments())]
    if not matrices or matrices[0].shape[1] != 1:
        raise PlannercheckError(f"must be a column of numbers in time, not {thing.rows()} x {thing.cols()}")
    rows = [[np.asarray(cell.GetCoefficients(), dtype=np.float64) for cell in matrix[:, 0]] for matrix in matrices]
    most = max(len(cell) for row in rows for cell in row)
    powers = [[np.pad(cell, (0, most - len(cell))) for cell in row] for row in rows]
    return of_polynomials(thing.get_segment_times(), np.array(powers))


def _drake_bspline(thing: Any) -> Curve:
    points = [np.asarray(point) for point in thing.control_points()]
    if points[0].ndim > 1 and points[0].shape[1] != 1:
        raise PlannercheckError(f"must be a column of numbers in time, not {points[0].shape}")
    return of_bspline(thing.basis().knots(), np.array([np.ravel(point) for point in points]))


def _drake_bezier(thing: Any) -> Curve:
    return of_bezier([thing.start_time(), thing.end_time()], np.asarray(thing.control_points()).T[None])


def _ndcurves_bezier(thing: Any) -> Curve:
    return of_bezier([thing.min(), thing.max()], _rows_of_ndcurves(thing, thing.waypoints()).T[None])


def _ndcurves_polynomial(thing: Any) -> Curve:
    return of_polynomials([thing.min(), thing.max()], _rows_of_ndcurves(thing, thing.coeff())[None])


def _rows_of_ndcurves(thing: Any, values: Any) -> Floats:
    """(nq, n) values, of which eigenpy makes a vector where there is one row or column."""
    return np.asarray(values, dtype=np.float64).reshape(thing.dim(), -1)


def _scipy_bspline(thing: Any) -> Curve:
    points = np.asarray(thing.c)[: len(thing.t) - thing.k - 1]
    return of_bspline(thing.t, points[:, None] if points.ndim == 1 else points)


def _scipy_powers(thing: Any) -> Curve:
    return of_polynomials(thing.x, _columns_of_scipy(thing)[::-1].transpose(1, 2, 0))


def _scipy_bernstein(thing: Any) -> Curve:
    return of_bezier(thing.x, _columns_of_scipy(thing).transpose(1, 0, 2))


def _columns_of_scipy(thing: Any) -> Floats:
    """(degree + 1, m, nq) coefficients."""
    found = np.asarray(thing.c)
    if np.iscomplexobj(found) or not 2 <= found.ndim <= 3:
        raise PlannercheckError(f"must be a row of real numbers in time, not {found.dtype} of shape {found.shape}")
    return np.asarray(found.reshape(*found.shape[:2], -1), dtype=np.float64)


def _composite(thing: Any) -> Curve:
    return _in_a_row([of_library(thing.segment(k)) for k in range(thing.get_number_of_segments())])


def _piecewise(thing: Any) -> Curve:
    return _in_a_row([of_library(thing.curve_at_index(k)) for k in range(thing.num_curves())])


def _exact_cubic(thing: Any) -> Curve:
    return _in_a_row([of_library(thing.getSplineAt(k)) for k in range(thing.getNumberSplines())])


def _in_a_row(parts: list[Curve]) -> Curve:
    if not parts:
        raise PlannercheckError("has no parts")
    span = parts[-1].breaks[-1] - parts[0].breaks[0]
    for k in range(1, len(parts)):
        apart = abs(parts[k].breaks[0] - parts[k - 1].breaks[-1])
        if apart > _INSTANT * span or parts[k].nq != parts[0].nq:
            raise PlannercheckError(f"parts {k - 1} and {k} do not follow each other: {apart:.3g} s between them")
    breaks = np.concatenate([parts[0].breaks[:1], *(part.breaks[1:] for part in parts)])
    error = np.max([part.error for part in parts], axis=0)
    return joined(breaks, [control for part in parts for control in part.pieces], error)


def _path_parameterized(thing: Any) -> Curve:
    path, scaling = of_library(thing.path()), of_library(thing.time_scaling())
    composed = [_composed(path, control, float(scaling.error[0])) for control in scaling.pieces]
    error = path.error + np.max([each for _, each in composed], axis=0)
    return joined(scaling.breaks, [control for control, _ in composed], error)


def _composed(path: Curve, scaling: Floats, scaling_error: float) -> tuple[Floats, Floats]:
    """Control points of a path along one piece of a time scaling (degree + 1, 1), and how far they are off (nq,)."""
    values = [value for _, value in extremes(scaling[:, 0])]
    low, high = min(values), max(values)
    near = _INSTANT * (path.breaks[-1] - path.breaks[0])
    inside = [k for k in range(len(path.pieces)) if path.breaks[k] - near <= low and high <= path.breaks[k + 1] + near]
    if not inside:
        raise PlannercheckError(
            f"a piece of its time scaling runs from {low:g} to {high:g} over breaks of its path, and is no polynomial:"
            " give its path(), which has the same configurations"
        )
    start, end = path.breaks[inside[0] : inside[0] + 2]
    control = path.pieces[inside[0]]
    degree, steps = len(scaling) - 1, len(control) - 1
    if degree * steps > MOST_DEGREE:
        raise PlannercheckError(f"path and time scaling give a degree above {MOST_DEGREE}: give its path()")
    # De Casteljau's algorithm with a polynomial as the parameter.
    share = (scaling - start) / (end - start)
    points = list(control[:, None, :])
    while len(points) > 1:
        points = [_product(first, 1 - share) + _product(second, share) for first, second in pairwise(points)]
    # Each step has some errors of the share, of products, and of sums over the degree that is reached; its terms are at
    # most `growth` larger. Beyond a break the neighbouring piece would count: at most twice the way at full speed.
    growth = float(np.abs(1 - share).max() + np.abs(share).max())
    rounded = steps * (degree * steps + 12) * UNIT * growth**steps * np.abs(control).max(axis=0)
    fastest = np.max([(len(c) - 1) * np.abs(np.diff(c, axis=0)).max(axis=0) for c in path.pieces], axis=0)
    slowest = float(np.diff(path.breaks).min())
    return np.asarray(points[0]), rounded + fastest / slowest * (2 * near + scaling_error)


def _product(values: Floats, factor: Floats) -> Floats:
    """Control points of a polynomial (m + 1, nq) times another one (n + 1, 1)."""
    m, n = len(values) - 1, len(factor) - 1
    found = np.zeros((m + n + 1, values.shape[1]))
    for i in range(m + 1):
        for j in range(n + 1):
            found[i + j] += comb(m, i) * comb(n, j) / comb(m + n, i + j) * values[i] * factor[j]
    return found


# Attributes by which objects are known, and their readers.
_READERS: tuple[tuple[tuple[str, ...], Callable[[Any], Curve]], ...] = (
    (("getPolynomialMatrix", "get_segment_times"), _piecewise_polynomial),
    (("basis", "control_points"), _drake_bspline),
    (("BernsteinBasis", "control_points"), _drake_bezier),
    (("segment", "get_number_of_segments"), _composite),
    (("path", "time_scaling"), _path_parameterized),
    (("waypoints", "nbWaypoints"), _ndcurves_bezier),
    (("coeff", "coeffAtDegree"), _ndcurves_polynomial),
    (("curve_at_index", "num_curves"), _piecewise),
    (("getSplineAt", "getNumberSplines"), _exact_cubic),
    (("t", "c", "k"), _scipy_bspline),
    (("c", "x", "solve"), _scipy_powers),
    (("c", "x", "from_derivatives"), _scipy_bernstein),
)
