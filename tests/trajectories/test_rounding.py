"""Bounds of rounding, held against rational arithmetic: of control points, and of the controller's own evaluation."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import BSpline

import plannercheck as pc
from plannercheck.trajectories.curve import Curve

F = Fraction


def exact_at(curve: Curve, k: int, s: Fraction) -> list[Fraction]:
    """A piece's value at parameter s, of its doubles."""
    points = [[F(x) for x in row] for row in curve.pieces[k].tolist()]
    while len(points) > 1:
        points = [[a + (b - a) * s for a, b in zip(p, q, strict=True)] for p, q in pairwise(points)]
    return points[0]


def coefficients(number, degree: int, ends, h):
    """Of powers of t: in rationals the message's polynomial, in doubles joint_trajectory_controller's, in its order."""
    p, q, v, w, a, b = map(number, ends)
    t = [number(1)]
    for _ in range(degree):
        t.append(t[-1] * h)
    if degree == 1:
        return [p, (q - p) / h]
    if degree == 3:
        c2 = (number(-3) * p + number(3) * q - number(2) * v * t[1] - w * t[1]) / t[2]
        return [p, v, c2, (number(2) * p - number(2) * q + v * t[1] + w * t[1]) / t[3]]
    two = number(2)
    c3 = (-20 * p + 20 * q - 3 * a * t[2] + b * t[2] - 12 * v * t[1] - 8 * w * t[1]) / (two * t[3])
    c4 = (30 * p - 30 * q + 3 * a * t[2] - 2 * b * t[2] + 16 * v * t[1] + 14 * w * t[1]) / (two * t[4])
    c5 = (-12 * p + 12 * q - a * t[2] + b * t[2] - 6 * v * t[1] - 6 * w * t[1]) / (two * t[5])
    return [p, v, a / two, c3, c4, c5]


def value(powers, t, number):
    found, power = number(0), number(1)
    for c in powers:
        found += power * c
        power *= t
    return found


def by_motoros2(ends, h, t):
    """In doubles, in the order of MotionControl.c."""
    p, q, v, w = ends
    first = (6 * (q - p) / (h * h)) - (2 * (w + 2 * v) / h)
    second = (-12 * (q - p) / (h * h * h)) + (6 * (w + v) / (h * h))
    return p + v * t + first * t * t / 2 + second * t * t * t / 6


def test_motoros2_and_straight_lines():
    """2,000 segments of whole milliseconds."""
    rng = np.random.default_rng(7)
    worst = 0.0
    for _ in range(2_000):
        late, step = int(rng.integers(0, 10 ** rng.integers(1, 8))), int(rng.integers(1, 10 ** rng.integers(1, 6)))
        q, v = rng.normal(size=(2, 2, 1)) * 10.0 ** rng.integers(-9, 4, (2, 1, 1))
        if rng.random() < 0.3:
            q[1] = q[0] * (1 + rng.normal() * 1e-12)
        v[1] = 0
        times, ends = np.array([late, late + step]) / 1e3, [*q[:, 0].tolist(), *v[:, 0].tolist()]
        cubic, line = (pc.Trajectory(times, q, v, controller=each).curve.error[0] for each in ("motoros2", "linear"))
        exact = coefficients(F, 3, [*ends, 0, 0], F(step, 1000))
        for part in (0, int(rng.integers(0, step + 1)), step):
            t, h = part / 1000.0, step / 1000.0
            off = abs(F(by_motoros2(ends, h, t)) - value(exact, F(part, 1000), F))
            assert off <= F(float(cubic))
            worst = max(worst, float(off / F(float(cubic))) if cubic else 0.0)
            p, r = map(F, ends[:2])
            assert abs(F(ends[0] + (ends[1] - ends[0]) * t / h) - p - (r - p) * F(part, step)) <= F(float(line))
    assert worst > 0.02  # the bound is not idle


def test_points_of_random_messages():
    """2,000 segments: long and short, late, of sizes far apart, with ends that cancel."""
    rng = np.random.default_rng(0)
    worst = 0.0
    for _ in range(2_000):
        degree = int(rng.choice([1, 3, 5]))
        late, step = int(rng.integers(1, 10 ** rng.integers(1, 15))), int(rng.integers(1, 10 ** rng.integers(1, 12)))
        q, v, a = rng.normal(size=(3, 3, 1)) * 10.0 ** rng.integers(-9, 4, (3, 1, 1))
        if rng.random() < 0.3:
            q[1] = q[0] * (1 + rng.normal() * 1e-12)
        v[-1] = a[-1] = 0
        times = np.array([late, late + step, late + step + 10**9]) / 1e9
        made = pc.Trajectory(times, q, v if degree > 1 else None, a if degree > 3 else None)
        # The UR driver's curve is the same, and its bound that of the control points alone.
        control = pc.Trajectory(times, q, v, a if degree > 3 else None, "ur").curve.error[0] if degree > 1 else 0.0
        ends = [float(x) for pair in (q[:2], v[:2], a[:2]) for x in pair[:, 0]]
        h, double = F(step, 10**9), coefficients(float, degree, ends, step / 1e9)
        exact = coefficients(F, degree, ends, h)
        for part in (0, int(rng.integers(0, step + 1)), step):
            truth = value(exact, F(part, 10**9), F)
            ours = exact_at(made.curve, 0, F(part, step))[0]
            theirs = F(value(double, part / 1e9, float))
            bound = F(float(made.curve.error[0]))
            assert abs(ours - truth) <= F(float(control))
            assert abs(theirs - truth) <= bound
            assert abs(ours - theirs) <= bound
            worst = max(worst, float(abs(ours - theirs) / bound) if bound else 0.0)
    assert worst > 0.02  # the bound is not idle


def spline(times, q, number):
    """Velocities of the clamped spline, by elimination as joint_trajectory_controller has it."""
    h = [b - a for a, b in pairwise(times)]
    shares, found = [number(0)], [number(0)]
    for k in range(1, len(h)):
        low, high = 1 / h[k - 1], 1 / h[k]
        right = 3 * ((q[k + 1] - q[k]) * high**2 + (q[k] - q[k - 1]) * low**2)
        pivot = 2 * (low + high) - low * shares[-1]
        shares.append(high / pivot)
        found.append((right - low * found[-1]) / pivot)
    found.append(number(0))
    for k in range(len(h) - 1, 0, -1):
        found[k] -= shares[k] * found[k + 1]
    return found


def test_upsampled_splines():
    rng = np.random.default_rng(1)
    for _ in range(300):
        n = int(rng.integers(3, 8))
        ns = rng.integers(0, 10**13) + np.cumsum(rng.integers(1, 10 ** rng.integers(6, 10, n)))
        q = rng.normal(size=(n, 1))
        made = pc.Trajectory(ns / 1e9, q, controller="jtc-upsampled")
        times = [F(int(each), 10**9) for each in ns]
        rows = q[:, 0].tolist()
        exact, rounded = spline(times, list(map(F, rows)), F), spline((ns / 1e9).tolist(), rows, float)
        bound = F(float(made.curve.error[0]))
        for k in range(n - 1):
            step = int(ns[k + 1] - ns[k])
            truth = coefficients(F, 3, [*rows[k : k + 2], *exact[k : k + 2], 0, 0], F(step, 10**9))
            double = coefficients(float, 3, [*rows[k : k + 2], *rounded[k : k + 2], 0, 0], step / 1e9)
            for part in (step // 3, step // 2, step - step // 6):
                right = value(truth, F(part, 10**9), F)
                assert abs(exact_at(made.curve, k, F(part, step))[0] - right) <= bound
                assert abs(F(value(double, part / 1e9, float)) - right) <= bound


@pytest.mark.parametrize("degree", [1, 2, 3, 5, 7])
def test_powers(degree: int):
    rng = np.random.default_rng(degree)
    for _ in range(200):
        start, end = np.sort(rng.uniform(0, 10, 2)).tolist()
        powers = rng.normal(size=degree + 1) * 10.0 ** rng.integers(-4, 5, degree + 1)
        made = pc.Trajectory.polynomials([start, end], powers[None, None])
        h = F(end) - F(start)
        for s in (F(0), F(2, 7), F(1)):
            truth = value([F(float(c)) for c in powers], s * h, F)
            assert abs(exact_at(made.curve, 0, s)[0] - truth) <= F(float(made.curve.error[0]))


def exact_b_spline(knots, points, degree: int, k: int, t):
    """De Boor's recursion in rationals."""
    d = [points[j] for j in range(k - degree, k + 1)]
    for r in range(1, degree + 1):
        for j in range(degree, r - 1, -1):
            low, high = knots[j + k - degree], knots[j + 1 + k - r]
            d[j] = d[j - 1] + (d[j] - d[j - 1]) * (t - low) / (high - low)
    return d[degree]


@pytest.mark.parametrize("degree", [1, 3, 5])
def test_b_splines(degree: int):
    rng = np.random.default_rng(degree)
    for _ in range(30):
        knots = np.sort(rng.uniform(0, 5, 8 + degree))
        points = rng.normal(size=(7, 1))
        made = pc.Trajectory.bspline(knots, points)
        peer = BSpline(knots, points, degree)
        exact = [F(float(x)) for x in knots], [F(float(x)) for x in points[:, 0]]
        for k in range(len(made.curve.pieces)):
            start, end = exact[0][degree + k], exact[0][degree + k + 1]
            t = start + (end - start) / 3
            truth = exact_b_spline(*exact, degree, degree + k, t)
            assert float(truth) == pytest.approx(peer(float(t))[0])
            assert abs(exact_at(made.curve, k, F(1, 3))[0] - truth) <= F(float(made.curve.error[0]))


def test_what_is_exact_has_no_error():
    assert pc.Trajectory.bezier([0, 1], [[[0.1], [0.3], [0.7]]]).curve.error == 0
    apart = pc.Trajectory.bezier([0, 1, 2], [[[0.1], [0.3]], [[0.3 + 1e-12], [0.7]]])
    assert apart.curve.error == pytest.approx(1e-12, rel=1e-3)


def test_motoros2_cuts_times_to_ms():
    found = pc.Trajectory([0.0, 0.5005, 1.0019], [[0.0], [0.1], [0.2]], [[0.0], [0.1], [0.0]], controller="motoros2")
    assert found.curve.breaks.tolist() == [0, 0.5, 1.001]
    with pytest.raises(pc.PlannercheckError, match="points 1 and 2 are at the same ms: motoros2 cuts"):
        pc.Trajectory([0, 0.5001, 0.5009], [[0.0], [0.1], [0.2]], np.zeros((3, 1)), controller="motoros2")
    with pytest.raises(pc.PlannercheckError, match=r"velocity 0\.01 in column 0: motoros2 refuses"):
        pc.Trajectory([0, 1], [[0.0], [0.1]], [[0.0], [0.01]], controller="motoros2")
