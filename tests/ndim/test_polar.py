"""The paper's lemmas and theorem on polarity, as properties, in dimensions 2 to 5."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

import plannercheck as pc
from plannercheck.ndim import polar

SLACK = 1e-9
dimensions = st.integers(2, 5)
seeds = st.integers(0, 2**32 - 1)
runs = settings(max_examples=60, deadline=None, derandomize=True)


def around_origin(rng, d):
    """Points whose hull has the origin well inside."""
    cross = np.concatenate([np.eye(d), -np.eye(d)]) * rng.uniform(0.5, 1.5, size=(2 * d, 1))
    return np.concatenate([cross, rng.normal(size=(int(rng.integers(1, 8)), d))])


def beside_origin(rng, d):
    """Points whose hull misses the origin."""
    points = rng.normal(size=(int(rng.integers(d + 1, d + 8)), d))
    points[:, 0] = 0.2 + np.abs(points[:, 0])
    return points


def inside(rng, points):
    return rng.dirichlet(np.ones(len(points))) @ points


def lowest_over(halfspaces, direction):
    """Minimises direction · y over ρ₀ or ρ∞, by a linear program; None if it is unbounded or empty."""
    sign = 1.0 if halfspaces.side == "zero" else -1.0
    rows, right = sign * halfspaces.normals, sign * np.ones(len(halfspaces.normals))
    answer = linprog(direction, A_ub=rows, b_ub=right, bounds=(None, None))
    return None if answer.x is None else answer.x


@runs
@given(dimensions, seeds)
def test_points_and_hyperplanes_trade_places(d, seed):
    """Lemma "polarity property": x ∈ h₀ iff ρ(h) ∈ ρ₀(x), likewise ∞ and on the plane; ρ is its own inverse."""
    rng = np.random.default_rng(seed)
    x, normal, offset = rng.normal(size=d), rng.normal(size=d), rng.uniform(0.1, 2.0)
    z = polar.polar_of_hyperplane(normal, offset)
    np.testing.assert_allclose(polar.polar_of_point(z), z)
    for of_plane, of_point in ((polar.rho_zero, polar.rho_zero), (polar.rho_infinity, polar.rho_infinity)):
        assert of_plane(z[None]).holds(x) == of_point(x[None]).holds(z)
    on_plane = x + (1 - z @ x) / (z @ z) * z
    assert abs(on_plane @ z - 1) < SLACK


@runs
@given(dimensions, seeds)
def test_polar_of_the_polar(d, seed):
    """Lemma "Polar of the polar": ρ₀(ρ₀(P)) = P with the origin inside."""
    points = around_origin(np.random.default_rng(seed), d)
    back = polar.vertices_of(polar.rho_zero(polar.vertices_of(polar.rho_zero(points))))
    extreme = points[np.unique(polar.convex_hull(points).simplices)]
    gaps = np.abs(back[:, None] - extreme[None]).max(axis=2)
    assert len(back) == len(extreme)
    assert gaps.min(axis=0).max() < 1e-7


@runs
@given(dimensions, seeds)
def test_points_of_polars_are_halfspaces_that_hold_the_polytope(d, seed):
    """Lemma "Polarizations of polyhedra": x ∈ ρ₀(P) iff P ⊆ ρ₀(x), and x ∈ ρ∞(P) iff P ⊆ ρ∞(x)."""
    rng = np.random.default_rng(seed)
    points = around_origin(rng, d) if seed % 2 else beside_origin(rng, d)
    for x in rng.normal(size=(20, d)) * rng.choice([0.3, 1.0, 5.0], size=(20, 1)):
        assert polar.rho_zero(points).holds(x) == polar.rho_zero(x[None]).holds(points).all()
        assert polar.rho_infinity(points).holds(x) == polar.rho_infinity(x[None]).holds(points).all()


@runs
@given(dimensions, seeds)
def test_points_of_the_polytope_bound_its_polars(d, seed):
    """Lemma "Result for Shell-simplices": x ∈ P gives ρ₀(P) ⊆ ρ₀(x) and ρ∞(P) ⊆ ρ∞(x)."""
    rng = np.random.default_rng(seed)
    points = around_origin(rng, d)
    x = inside(rng, points)
    assert (polar.vertices_of(polar.rho_zero(points)) @ x <= 1 + SLACK).all()
    points = beside_origin(rng, d)
    x = inside(rng, points)
    lowest = lowest_over(polar.rho_infinity(points), x)
    assert lowest is not None
    assert lowest @ x >= 1 - SLACK


@runs
@given(dimensions, seeds)
def test_tangents_of_polars_are_boundary_points(d, seed):
    """Lemma "A tangent polarizes to a point inside": tangent to ρ₀(P) or ρ∞(P), its polar is on the boundary of P."""
    rng = np.random.default_rng(seed)
    for points, make, sense in (
        (around_origin(rng, d), polar.rho_zero, -1.0),
        (beside_origin(rng, d), polar.rho_infinity, 1.0),
    ):
        # A direction that is bounded on the polar: towards P for ρ∞.
        direction = inside(rng, points) if sense > 0 else rng.normal(size=d)
        touched = lowest_over(make(points), sense * direction)
        gamma = direction / (direction @ touched)
        hull = polar.convex_hull(points)
        violation = (hull.normals @ gamma - hull.offsets).max()
        assert abs(violation) < 1e-7


@runs
@given(dimensions, seeds)
def test_polars_reverse_inclusion(d, seed):
    """Lemma "Inverse of inclusion": P ⊆ Q gives ρ₀(Q) ⊆ ρ₀(P) and ρ∞(Q) ⊆ ρ∞(P)."""
    rng = np.random.default_rng(seed)
    larger = around_origin(rng, d) if seed % 2 else beside_origin(rng, d)
    smaller = np.array([inside(rng, larger) for _ in range(d + 3)])
    for x in rng.normal(size=(50, d)):
        for make in (polar.rho_zero, polar.rho_infinity):
            assert not make(larger).holds(x) or make(smaller).holds(x, SLACK)


@runs
@given(dimensions, seeds)
def test_polarity_theorem(d, seed):
    """Theorem "Polarity of polyhedra": P meets ρ₀(Q) iff a hyperplane separates ρ∞(P) from Q; (1) and (2)."""
    rng = np.random.default_rng(seed)
    points, q = beside_origin(rng, d), around_origin(rng, d) * rng.choice([0.3, 1.0, 3.0])
    # x in P ∩ ρ₀(Q), by a linear program over mixtures of P with the largest q·x least.
    k = len(points)
    rows = np.column_stack([q @ points.T, -np.ones(len(q))])
    answer = linprog(
        np.append(np.zeros(k), 1.0),
        A_ub=rows,
        b_ub=np.zeros(len(q)),
        A_eq=[[1.0] * k + [0.0]],
        b_eq=[1.0],
        bounds=[(0, None)] * k + [(None, None)],
    )
    x = answer.x[:k] @ points
    lowest = lowest_over(polar.rho_infinity(points), x)
    if answer.fun <= 1 - 1e-6:  # (1): ρ(x) separates ρ∞(P) from Q
        assert (q @ x <= 1).all()
        assert lowest @ x >= 1 - SLACK
        gamma = x / (lowest @ x)  # (2): the parallel plane that touches ρ∞(P) is a common point
        hull = polar.convex_hull(points)
        assert (hull.normals @ gamma <= hull.offsets + 1e-7).all()
        assert polar.rho_zero(q).holds(gamma, 1e-7)
    elif answer.fun >= 1 + 1e-6:  # no plane separates: some point of Q is in ρ∞(P)
        weights = -answer.ineqlin.marginals
        shared = weights @ q / weights.sum()
        assert polar.rho_infinity(points).holds(shared, 1e-7)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(dimensions, seeds)
def test_shell_simplices(d, seed):
    """Lemma "Simplex lemma": they hold P, and every hyperplane tangent to P is tangent to one of them."""
    rng = np.random.default_rng(seed)
    points = around_origin(rng, d)
    shells = polar.shell_simplices(points)
    assert (shells.normals @ points.T <= 1 + 1e-7).all()
    for normal in rng.normal(size=(10, d)):
        sides = shells.normals[shells.simplices[shells.tangent(normal)]]
        best = linprog(-normal, A_ub=sides, b_ub=np.ones(d), bounds=(None, None))
        assert best.x is not None
        assert -best.fun <= (points @ normal).max() + 1e-6


def test_the_origin_on_the_boundary_breaks_the_polar_of_the_polar():
    """The text says "0 ∈ P"; [-1, 1] × [0, 1] shows that it has to be strictly inside."""
    points = np.array([[-1.0, 0], [1, 0], [1, 1], [-1, 1]])
    with pytest.raises(pc.PlannercheckError, match="unbounded"):
        polar.vertices_of(polar.rho_zero(points))
    with pytest.raises(pc.PlannercheckError, match="strictly inside"):
        polar.facet_polars(points)


def test_a_cube_and_a_cross():
    cube = np.array(np.meshgrid(*[[-1.0, 1.0]] * 4)).reshape(4, -1).T
    polars = polar.facet_polars(cube)
    assert len(polars) == 8
    assert np.abs(polars).sum(axis=1).tolist() == [1.0] * 8


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: polar.polar_of_point([0.0, 0.0]), "origin has no polar"),
        (lambda: polar.polar_of_hyperplane([1.0, 0.0], 0.0), "through the origin"),
        (lambda: polar.vertices_of(polar.rho_infinity([[1.0, 1.0]])), "only ρ₀"),
    ],
)
def test_errors(call, words):
    with pytest.raises(pc.PlannercheckError, match=words):
        call()
