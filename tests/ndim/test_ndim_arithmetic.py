"""Any dimension: linear algebra in integers, and what is proved in doubles only where rounding leaves it."""

import itertools
from fractions import Fraction

import numpy as np
import pytest
from ndim_pairs import box_halfspaces
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

from plannercheck import ndim
from plannercheck.ndim.exact import ExactSharedPoint, Guess, decide
from plannercheck.ndim.filters import encloses_origin, proves_inside
from plannercheck.ndim.guides import Hint
from plannercheck.ndim.integers import Farkas, Mix, dot, inverse, solve
from plannercheck.ndim.posed import ExactRows, ExactVertices
from plannercheck.ndim.poses import Affine, identity
from plannercheck.ndim.proofs import proves_shared


def test_systems_in_integers_against_a_linear_program():
    rng = np.random.default_rng(0)
    unsolved = 0
    for _ in range(100):
        height, width = int(rng.integers(1, 6)), int(rng.integers(1, 10))
        columns = rng.integers(-3, 4, size=(width, height))
        right = rng.integers(-3, 4, size=height)
        answer = solve(columns.tolist(), right.tolist())
        feasible = linprog(np.zeros(width), A_eq=columns.T, b_eq=right, bounds=(0, None)).status == 0
        assert isinstance(answer, Mix) == feasible
        if isinstance(answer, Mix):
            assert all(w > 0 for w in answer.weights.values())
            mixed = sum(w * columns[k].astype(object) for k, w in answer.weights.items())
            assert list(np.broadcast_to(mixed, height)) == [answer.denominator * int(x) for x in right]
        else:
            assert isinstance(answer, Farkas)
            unsolved += 1
            assert max(dot(answer.row, column) for column in columns.tolist()) <= 0 < dot(answer.row, right.tolist())
    assert 0 < unsolved < 100


def test_inverses_in_integers():
    assert inverse([[1, 2], [2, 4]]) is None
    scaled, denominator = inverse([[0, 2], [-3, 1]])
    assert (np.array([[0, 2], [-3, 1]]) @ np.array(scaled) == denominator * np.eye(2, dtype=int)).all()
    assert denominator > 0


def test_hulls_of_halfspaces_and_points_agree():
    rng = np.random.default_rng(0)
    points = rng.normal(size=(40, 4))
    hull = ConvexHull(points)
    body = ndim.Polytope.from_halfspaces(hull.equations[:, :-1], -hull.equations[:, -1])
    assert len(body.points) == len(hull.vertices)
    assert (body.points >= body.box[0] - 1e-12).all()
    assert (body.points <= body.box[1] + 1e-12).all()
    np.testing.assert_allclose(body.box, [points.min(axis=0), points.max(axis=0)], atol=1e-9)


@pytest.mark.parametrize("dimension", [2, 3, 4])
def test_any_guess_decides_what_touches(dimension):
    """Boxes that share a corner, an edge or a face, from any two vertices, or halfspaces, as the guess."""
    corners = np.array(list(itertools.product((0.0, 1.0), repeat=dimension)))
    normals = np.vstack([np.eye(dimension), -np.eye(dimension)])
    offsets = np.repeat([1.0, 0.0], dimension)
    for along in range(1, dimension + 1):
        shift = np.where(np.arange(dimension) < along, 1.0, 0.5)
        still, moved = identity(dimension), Affine(np.eye(dimension), shift, False)
        for kinds in itertools.product("vr", repeat=2):
            sizes = [2**dimension if kind == "v" else 2 * dimension for kind in kinds]
            for guess in itertools.islice(itertools.product(*map(range, sizes)), 0, None, 2**dimension - 1):
                bodies = [
                    ExactVertices(corners, pose) if kind == "v" else ExactRows(normals, offsets, pose)
                    for kind, pose in zip(kinds, (still, moved), strict=True)
                ]
                found, _ = decide(*bodies, Guess((guess[0],), (guess[1],)))
                assert isinstance(found, ExactSharedPoint)
                point = [Fraction(x, found.denominator) * Fraction(2) ** bodies[0].unit for x in found.point]
                for x, s in zip(point, shift.tolist(), strict=True):
                    assert max(0, Fraction(s)) <= x <= 1


@pytest.mark.parametrize("dimension", [2, 3, 4, 6])
def test_what_rounding_may_move_out_is_not_enclosed(dimension):
    """A simplex with a face nearer to the origin than what its corners may be off is not proved to hold it."""
    rng = np.random.default_rng(dimension)
    rounding = np.full(dimension, 2.0)
    for _ in range(40):
        corners = np.vstack([-np.eye(dimension), np.ones(dimension)]) + rng.uniform(
            -0.1, 0.1, (dimension + 1, dimension)
        )
        turn = np.linalg.qr(rng.normal(size=(dimension, dimension)))[0]
        corners = corners - corners[:-1].mean(axis=0)  # the origin is on the face of all corners but the last
        for height, enclosed in ((1e-6, True), (1e-16, False), (0.0, False), (-1e-6, False)):
            moved = (corners - height * corners[-1]) @ turn
            assert encloses_origin(moved, rounding) == enclosed


@pytest.mark.parametrize("dimension", [2, 3, 5])
def test_a_point_is_proved_inside_only_where_rounding_leaves_it(dimension):
    """A turned box, and points just within and beyond its faces, some of them moved by an error."""
    rng = np.random.default_rng(dimension)
    normals, offsets = np.vstack([np.eye(dimension), -np.eye(dimension)]), np.repeat([1.0, 1.0], dimension)
    none = np.zeros(dimension)
    for _ in range(30):
        turn = np.linalg.qr(rng.normal(size=(dimension, dimension)))[0]
        shift = rng.uniform(-3, 3, dimension)
        face = rng.uniform(-0.9, 0.9, dimension)
        for depth_below, proved in ((1e-9, True), (1e-16, False), (0.0, False), (-1e-9, False)):
            face[0] = 1 - depth_below
            point = turn @ face + shift
            assert proves_inside(normals, offsets, Affine(turn, shift, False), point, none) == proved
            assert proves_inside(normals, offsets, identity(dimension), face, none) == proved
            assert not proves_inside(normals, offsets, Affine(turn, shift, False), point, none + 1e-8)
        inside = turn @ (0.5 * face) + shift
        assert proves_inside(normals, offsets, Affine(turn, shift, False), inside, none + 1e-3)


@pytest.mark.parametrize("dimension", [2, 3, 5])
def test_a_mixture_is_proved_inside_only_where_posing_it_leaves_it(dimension):
    """An edge 1e6 from its own origin, which its pose brings near to a box: its middle, about on one of its faces."""
    rng = np.random.default_rng(dimension)
    body_b = ndim.Polytope.from_halfspaces(*box_halfspaces(-np.ones(dimension), np.ones(dimension)))
    proofs = []
    for number in range(300):
        ends = 1e6 * rng.normal(size=dimension) + rng.normal(size=(2, dimension))
        turn = np.linalg.qr(rng.normal(size=(dimension, dimension)))[0]
        middle = rng.uniform(-0.9, 0.9, dimension)
        middle[0] = 1 - (1e-6 if number % 10 == 0 else rng.uniform(-1e-10, 1e-10))
        pose = Affine(turn, middle - turn @ ends.mean(axis=0), False)
        hint = Hint(True, (0, 1), (), middle, {0: 0.5, 1: 0.5}, {}, {}, 1, 1, "oracle")
        proofs.append(proves_shared(hint, (ndim.Polytope(ends), pose), (body_b, identity(dimension))))
        mixed = [sum(map(Fraction, column)) / 2 for column in ends.T.tolist()]
        rows = [[Fraction(x) for x in (*row, s)] for row, s in zip(turn.tolist(), pose.shift.tolist(), strict=True)]
        place = [sum(m * x for m, x in zip(row[:-1], mixed, strict=True)) + row[-1] for row in rows]
        assert max(map(abs, place)) <= 1 or not proofs[-1], number
    assert all(proofs[::10])
    assert not all(proofs)
