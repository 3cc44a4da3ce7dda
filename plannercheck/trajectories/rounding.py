"""How far doubles are from the polynomials that a message defines.

In: points, or what a form of curve is made of. Out: bounds for each column, rad and m, of `Curve.error`: at the same
fraction of a segment's time, the curve's doubles are at most this far from the message's polynomial in real numbers,
and from the doubles of the controller that runs the points: joint_trajectory_controller, MotoROS2, or any straight
line p + (q - p) t / h. MotoROS2 then cuts these to whole pulses, one of them off at most: its robot knows how wide
they are. Of "ur" there is no bound: its robot adds up speeds by a closed speedj, from measured positions at each point.

The bounds count relative errors of u = 2⁻⁵³, one for each operation, by the size of the terms it acts on. A segment's
duration h is within u of the message's (stamps.py). Products of such errors are below 2⁻⁴⁰ of a bound; `_bound` adds
them, its own rounding, and what underflow loses.

- Control points. A cubic's p + v·(h/3) has 3 errors in the product and 1 in the sum; a quintic's p + 2v·(h/5) +
  a·(h·h/20) has at most 5 in a product and 2 in sums. So each control point errs by at most 8u (|p| + 2|v|h/5 +
  |a|h²/20), and a Bernstein polynomial errs no more than its control points do.
- joint_trajectory_controller sums c[k]·tᵏ (`interpolate_between_points`). By the absolute terms of c[k]·hᵏ, c[3] of a
  cubic has 2 errors of v·h and 3 of sums, 2 of h³ and 1 of the quotient; t³ has 2, its product 1, the sum at most 3,
  and the two durations 6: 20 in all. For c[5] of a quintic these are 5 and 5, 4 and 1; 4, 1, 5, 10: 35. Lower powers
  have fewer, a straight segment has 6. With FMA there are fewer roundings.
- MotoROS2 sums p + v t + a t t / 2 + b t t t / 6 (MotionControl.c) with a = 6 (q - p) / (h h) - 2 (w + 2 v) / h and
  b = -12 (q - p) / (h h h) + 6 (w + v) / (h h). The terms are those of a cubic; a's have 7 errors and b's 9, products
  of t 4 and 7 more, sums 3: 19 in all.
- Upsampled velocities. The rows of the system, scaled by h₁h₂/(h₁ + h₂), are α v₀ + 2 v₁ + β v₂ = 3 (α s₁ + β s₂), with
  slopes s and α + β = 1. The diagonal exceeds the rest by 1, so velocities are off by at most the largest residual
  (Varah). Ours is computed. The controller's is at most 12u |A||v| by its elimination (Higham, Accuracy and Stability
  of Numerical Algorithms, 9.5 and 9.6), a few u of the entries, and 2u (t₁ + t₂)/h of them by its differences of times.
  Velocities off by d move a cubic by at most d·h/4.
"""

from __future__ import annotations

import numpy as np

from plannercheck.common.array_types import Floats

UNIT = 2.0**-53

# Relative errors of a control point, and of a controller's evaluation by degree.
_CONTROL = 8
_EVALUATED = {1: 7, 3: 22, 5: 37}

# Errors of a solved velocity, beside the sum of the terms of a row.
_SOLVED = 40

# Numbers below the smallest double lose at most this in a bound.
_UNDERFLOW = 1e-270


def _bound(errors: Floats) -> Floats:
    """A bound from its first-order terms."""
    return np.where(errors > 0, errors * (1 + 2.0**-30) + _UNDERFLOW, 0.0)


def hermite_error(q: Floats, v: Floats | None, a: Floats | None, h: float, evaluated: bool) -> Floats:
    """(nq,) of a segment of duration h, s, with positions, velocities and accelerations (2, nq) at its ends.

    With `evaluated`, the controller's own evaluation is covered.
    """
    p, r = np.abs(q)
    if v is None:
        return _bound(_EVALUATED[1] * UNIT * (p + r)) if evaluated else np.zeros_like(p)
    (v0, v1), (a0, a1) = np.abs(v) * h, np.abs(np.zeros_like(v) if a is None else a) * h * h
    largest = np.maximum(p, r) + 0.4 * np.maximum(v0, v1) + np.maximum(a0, a1) / 20
    control = _CONTROL * UNIT * largest
    if not evaluated:
        return _bound(control)
    if a is None:
        terms = 6 * p + 5 * r + 4 * v0 + 2 * v1
        return _bound(control + _EVALUATED[3] * UNIT * terms)
    terms = 32 * p + 31 * r + 18 * v0 + 14 * v1 + 4 * a0 + 2 * a1
    return _bound(control + _EVALUATED[5] * UNIT * terms)


def upsampled_error(times: Floats, steps: Floats, q: Floats, v: Floats) -> Floats:
    """(nq,) what errors of solved velocities (n, nq), ours and the controller's, move the upsampled spline by."""
    if len(times) < 3:
        return np.zeros(q.shape[1])
    slopes = np.diff(q, axis=0) / steps[:, None]
    before, after = steps[:-1, None], steps[1:, None]
    alpha, beta = after / (before + after), before / (before + after)
    residual = alpha * v[:-2] + 2 * v[1:-1] + beta * v[2:] - 3 * (alpha * slopes[:-1] + beta * slopes[1:])
    terms = 3 * (np.abs(v).max(axis=0) + np.abs(slopes).max(axis=0))
    late = 1 + 4 * float(((np.abs(times[:-1]) + np.abs(times[1:])) / steps).max())
    ours = np.abs(residual).max(axis=0) + _SOLVED * UNIT * terms
    theirs = (_SOLVED + late) * UNIT * terms
    return _bound((ours + theirs) * float(steps.max()) / 4)


def turned_error(start: Floats, first: Floats) -> Floats:
    """(nq,) of whole turns that are taken off on the way to the first point: sums of doubles, one after the other."""
    return _bound(12 * UNIT * (np.abs(start) + np.abs(first) + 7))


def powers_error(powers: Floats) -> Floats:
    """(nq,) of the conversion of c[i]·hⁱ (degree + 1, nq) to control points.

    A term has i errors of h, at most 8 of the power, 2 for each of its i binomial ratios, 2 of products, and at most
    degree + 1 of sums.
    """
    degree = len(powers) - 1
    return _bound((4 * degree + 12) * UNIT * np.abs(powers).sum(axis=0))


def blossom_error(points: Floats, degree: int) -> Floats:
    """(…, nq) of de Boor's algorithm: `degree` steps of averages, whose shares have 3 errors, with 9 errors a step."""
    return _bound(9 * degree * UNIT * np.abs(points).max(axis=-2))
