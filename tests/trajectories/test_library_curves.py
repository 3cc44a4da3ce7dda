"""Curves of drake, ndcurves and SciPy: the same positions and velocities as their own.

The inputs of drake and ndcurves are those of their public tests (drake: common/trajectories/test/*.cc; ndcurves:
python/test/test.py), with the values that stand there where there are any.
"""

import numpy as np
import pytest
from scipy.interpolate import BPoly, BSpline, CubicSpline, PchipInterpolator, PPoly, make_interp_spline

import plannercheck as pc

RNG = np.random.default_rng(1)
TIMES = np.array([0.0, 0.5, 2.0, 3.0])
Q = RNG.normal(size=(4, 3))


def assert_same(found: pc.Trajectory, position, velocity, atol: float = 1e-12) -> None:
    breaks = found.curve.breaks
    at = np.concatenate([np.linspace(breaks[k], breaks[k + 1], 9)[1:-1] for k in range(len(breaks) - 1)])
    size = 1 + max(np.abs(control).max() for control in found.curve.pieces)
    own = np.array([np.ravel(position(t)) for t in at])
    np.testing.assert_allclose(found.position(at), own, atol=atol * size, rtol=0)
    speeds = np.array([np.ravel(velocity(t)) for t in at])
    np.testing.assert_allclose(found.velocity(at), speeds, atol=10 * atol * (size + np.abs(speeds).max()), rtol=0)


@pytest.mark.parametrize(
    "curve",
    [
        CubicSpline(TIMES, Q),
        CubicSpline(TIMES, Q.T, axis=1, bc_type="clamped"),
        CubicSpline(TIMES, Q[:, 0]),
        PchipInterpolator(TIMES, Q),
        PPoly(RNG.normal(size=(6, 1, 2)), [0.5, 2]),
        BPoly(np.stack([Q[:3], Q[1:]]), TIMES),
        BPoly.from_derivatives(TIMES, Q.reshape(4, 3, 1).repeat(2, axis=2).transpose(0, 2, 1)),
        make_interp_spline(TIMES, Q, k=3),
        BSpline(np.arange(9.0), RNG.normal(size=(5, 2)), 3, extrapolate=False),
        BSpline(np.arange(9.0), RNG.normal(size=6), 2),
    ],
    ids=lambda curve: type(curve).__name__,
)
def test_scipy(curve):
    for read in (pc.Trajectory.polynomials, pc.Trajectory.bezier, pc.Trajectory.bspline):
        assert_same(read(curve), curve, lambda t: curve(t, 1))


class TestDrake:
    @pytest.fixture(autouse=True)
    def _drake(self):
        self.d = pytest.importorskip("pydrake.trajectories")

    def same(self, curve, atol: float = 1e-12) -> pc.Trajectory:
        found = pc.Trajectory.polynomials(curve)
        assert_same(found, curve.value, lambda t: curve.EvalDerivative(t, 1), atol)
        assert found.curve.breaks[[0, -1]].tolist() == [curve.start_time(), curve.end_time()]
        return found

    def test_bezier_curves(self):
        constant = self.same(self.d.BezierCurve(0, 1, np.array([[1.0], [2.0]])))
        assert constant.position(0.5).tolist() == [1, 2]
        linear = self.same(self.d.BezierCurve(2, 3, np.array([[1.0, 2], [3, 7]])))
        assert linear.position(2.5).tolist() == [1.5, 5]
        assert linear.velocity(2.5).tolist() == [1, 4]
        quadratic = self.same(self.d.BezierCurve(0, 1, np.array([[1.0, 0, 0], [0, 0, 1]])))
        at = np.arange(0, 1.01, 0.1).clip(max=1)
        np.testing.assert_allclose(quadratic.position(at), np.column_stack([(1 - at) ** 2, at**2]), atol=1e-14)
        np.testing.assert_allclose(quadratic.velocity(at), np.column_stack([-2 * (1 - at), 2 * at]), atol=1e-14)
        assert quadratic.acceleration(0.3).tolist() == [2, 2]

    @pytest.mark.parametrize("order", [2, 4, 6])
    def test_b_splines(self, order: int):
        """A circle by 11 control points, as in bspline_trajectory_test.cc."""
        basis = pytest.importorskip("pydrake.math").BsplineBasis(order, 11)
        turn = np.linspace(0, 2 * np.pi, 11)
        self.same(self.d.BsplineTrajectory(basis, np.stack([np.sin(turn), np.cos(turn)])))

    def test_piecewise_polynomials(self):
        breaks, q = [1.0, 1.5, 4.0, 5.0], RNG.normal(size=(3, 4))
        piecewise = self.d.PiecewisePolynomial
        self.same(piecewise.FirstOrderHold(breaks, q))
        self.same(piecewise.CubicShapePreserving(breaks, q, True))
        self.same(piecewise.CubicHermite(breaks, q, RNG.normal(size=(3, 4))))
        self.same(piecewise.CubicWithContinuousSecondDerivatives(breaks, q, np.zeros(3), np.zeros(3)))
        self.same(piecewise.LagrangeInterpolatingPolynomial(breaks, q), 1e-10)
        with pytest.raises(pc.PlannercheckError, match=r"PiecewisePolynomial: pieces 0 and 1 are .* apart"):
            pc.Trajectory.polynomials(piecewise.ZeroOrderHold(breaks, q))
        with pytest.raises(pc.PlannercheckError, match="must be a column of numbers in time, not 1 x 3"):
            pc.Trajectory.polynomials(piecewise.FirstOrderHold(breaks, [q[:, k : k + 1].T for k in range(4)]))

    def test_composites(self):
        """Line and parabola in a row, as in composite_trajectory_test.cc."""
        parts = [
            self.d.BezierCurve(2, 3, np.array([[1.0, 2], [3, 7]])),
            self.d.BezierCurve(3, 4, np.array([[2.0, 3, 5], [7, 6, 8]])),
        ]
        self.same(self.d.CompositeTrajectory(parts))
        assert len(self.same(self.d.CompositeTrajectory([self.d.CompositeTrajectory(parts)])).curve.pieces) == 2

    def test_path_parameterized(self):
        """The numbers of path_parameterized_trajectory_test.cc: one cubic along two cubic time scalings."""
        piecewise = self.d.PiecewisePolynomial
        scaling = piecewise.CubicShapePreserving([1, 1.5, 2], np.array([[3, 4.5, 5]]), True)
        ends = np.array([[0.3, 1], [0, -1], [-0.5, 3]])
        path = piecewise.CubicShapePreserving([3, 5], ends, True)
        found = self.same(self.d.PathParameterizedTrajectory(path, scaling), 1e-11)
        assert [len(piece) for piece in found.curve.pieces] == [10, 10]
        bent = piecewise.FirstOrderHold([3, 4, 5], np.column_stack([ends, ends[:, 0]]))
        at_its_breaks = piecewise.CubicShapePreserving([1, 1.5, 2], np.array([[3, 4, 5]]), True)
        self.same(self.d.PathParameterizedTrajectory(bent, at_its_breaks))
        with pytest.raises(pc.PlannercheckError, match=r"runs from 3 to 4\.5 over breaks of its path.*give its path"):
            pc.Trajectory.polynomials(self.d.PathParameterizedTrajectory(bent, scaling))

    def test_what_is_no_polynomial_is_refused(self):
        slerp = self.d.PiecewiseQuaternionSlerp()
        with pytest.raises(pc.PlannercheckError, match=r"given by arrays, or by an object of drake.*not by PiecewiseQ"):
            pc.Trajectory.polynomials(slerp)


class TestNdcurves:
    @pytest.fixture(autouse=True)
    def _ndcurves(self):
        self.n = pytest.importorskip("ndcurves")

    def same(self, curve) -> pc.Trajectory:
        found = pc.Trajectory.bezier(curve)
        assert_same(found, curve, lambda t: curve.derivate(t, 1), 1e-11)
        assert found.curve.breaks[[0, -1]].tolist() == [curve.min(), curve.max()]
        return found

    def test_beziers(self):
        ends = np.array([[1.0, 2, 3], [4, 5, 6]]).T
        self.same(self.n.bezier(ends[:, :1], 0.0, 2.0))
        line = self.n.bezier(ends, 0.0, 3.0)
        np.testing.assert_allclose(self.same(line).position(1.5), [2.5, 3.5, 4.5])
        raised = line.elevate(1)
        assert [len(piece) for piece in self.same(raised).curve.pieces] == [3]
        self.same(self.n.bezier(ends[:, [0, 1, 1, 1, 1]], 0.0, 3.0))
        conditions = self.n.curve_constraints(3)
        conditions.init_vel = conditions.end_vel = np.array([[0.0, 1, 1]]).T
        conditions.init_acc, conditions.end_acc = np.array([[0.0, 1, -1]]).T, np.array([[0.0, 100, 1]]).T
        self.same(self.n.bezier(np.array([[1.0, 4, 2]]), 0.0, 1.0))
        found = self.same(self.n.bezier(ends, conditions))
        np.testing.assert_allclose(found.velocity(0), [0, 1, 1], atol=1e-12)
        np.testing.assert_allclose(found.acceleration(1), [0, 100, 1], atol=1e-10)

    def test_a_factor_that_no_attribute_shows_is_seen(self):
        line = self.n.bezier(np.array([[1.0, 2, 3], [4, 5, 6]]).T, 0.0, 3.0)
        with pytest.raises(pc.PlannercheckError, match="bezier: its own values differ"):
            pc.Trajectory.bezier(line.compute_derivate(1))

    def test_polynomials_of_boundary_conditions(self):
        p0, p1 = np.array([1.0, 3, -2]), np.array([0.6, 2, 2.5])
        v0, v1 = np.array([-6.0, 2, -1]), np.array([10.0, 10, 10])
        a0, a1 = np.array([1.0, -7, 4.5]), np.array([6.0, -1, -4])
        found = self.same(self.n.polynomial(p0, p1, 1.0, 2.5))
        np.testing.assert_allclose(found.position(1.75), (p0 + p1) / 2)
        self.same(self.n.polynomial(p0, v0, p1, v1, 1.0, 2.5))
        found = self.same(self.n.polynomial(p0, v0, a0, p1, v1, a1, 1.0, 2.5))
        np.testing.assert_allclose(found.acceleration([1.0, 2.5]), [a0, a1], atol=1e-9)
        controller = pc.Trajectory([1.0, 2.5], [p0, p1], [v0, 0 * v1], [a0, a1])  # which ends at rest
        peer = self.same(self.n.polynomial(p0, v0, a0, p1, 0 * v1, a1, 1.0, 2.5))
        np.testing.assert_allclose(peer.curve.pieces[0], controller.curve.pieces[0], atol=1e-11)

    def test_curves_in_a_row(self):
        first = self.n.polynomial(np.array([[1.0, 1, 1]]).T, 0.0, 1.0)
        second = self.n.polynomial(np.array([[1.0, 1, 1], [1, 1, 1]]).T, 1.0, 3.0)
        row = self.n.piecewise(first)
        row.append(second)
        assert self.same(row).position(3.0).tolist() == [3, 3, 3]
        self.same(self.n.exact_cubic(RNG.normal(size=(3, 4)), TIMES[:, None]))

    def test_what_shows_no_coefficients_is_refused_until_it_is_converted(self):
        spline = self.n.cubic_hermite_spline(Q[:2].T, Q[2:].T, np.array([[0.0, 1.0]]).T)
        with pytest.raises(pc.PlannercheckError, match=r"others by its convert_to_bezier.*not by cubic_hermite_spline"):
            pc.Trajectory.bezier(spline)
        assert_same(pc.Trajectory.bezier(self.n.convert_to_bezier(spline)), spline, lambda t: spline.derivate(t, 1))
