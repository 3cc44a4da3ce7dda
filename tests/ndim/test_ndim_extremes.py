"""Any dimension at the edge of doubles: maps that only exact arithmetic can invert, and certificates that say more."""

import dataclasses
from fractions import Fraction

import numpy as np
import pytest

import plannercheck as pc

SQUARE = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
NORMALS, OFFSETS = np.vstack([np.eye(2), -np.eye(2)]), np.array([1.0, 1, 0, 0])
# Invertible, since fl(1/3) is not 1/3, but of determinant 0 in doubles.
NEARLY_SINGULAR = np.array([[3.0, 1.0], [1.0, 1 / 3]])


def _bodies() -> list[pc.ndim.Polytope]:
    return [pc.ndim.Polytope(SQUARE), pc.ndim.Polytope.from_halfspaces(NORMALS, OFFSETS)]


def _shares(matrix: np.ndarray, shift: np.ndarray) -> bool:
    """Whether the image of the square meets the square, in fractions: that image is nearly a segment."""
    exact = [[Fraction(float(x)) for x in row] for row in matrix]
    corners = [
        [
            sum(m * Fraction(float(x)) for m, x in zip(row, v, strict=True)) + Fraction(float(t))
            for row, t in zip(exact, shift, strict=True)
        ]
        for v in SQUARE
    ]
    square = [[Fraction(float(x)) for x in v] for v in SQUARE]
    directions = [(Fraction(1), Fraction(0)), (Fraction(0), Fraction(1))]
    for k in range(4):
        a, b = corners[k], corners[(k + 1) % 4]
        directions.append((a[1] - b[1], b[0] - a[0]))
    for d in directions:
        p, r = ([d[0] * v[0] + d[1] * v[1] for v in body] for body in (corners, square))
        if min(p) > max(r) or max(p) < min(r):
            return False
    return True


@pytest.mark.parametrize("shift", [(0.0, 0.0), (-2.0, -2 / 3), (0.5, 0.9), (-1.0, 0.9), (-0.1, 1.0), (0.3, 1.0000001)])
def test_a_map_that_doubles_cannot_invert(shift):
    pose = (NEARLY_SINGULAR, np.array(shift))
    truth = _shares(NEARLY_SINGULAR, np.array(shift))
    for p in _bodies():
        for r in _bodies():
            for method in (None, "oracle", "exact", "tree"):
                more = {} if method is None else {"method": method}
                assert pc.ndim.intersects(p, r, pose, **more) == truth
                assert pc.ndim.intersects(r, p, None, pose, **more) == truth
            certificate = pc.ndim.certify(p, r, pose)
            assert (certificate.shares, certificate.verify()) == (truth, True)


def test_halfspaces_that_reach_beyond_doubles_are_refused():
    with pytest.raises(pc.PlannercheckError, match="reaches further than"):
        pc.ndim.Polytope.from_halfspaces(NORMALS * 1e-300, OFFSETS * 1e40 + 1e40)


def _separation():
    return pc.ndim.certify(pc.ndim.Polytope(SQUARE), pc.ndim.Polytope(SQUARE + np.array([3.0, 0.5])))


def _shared():
    return pc.ndim.certify(pc.ndim.Polytope(SQUARE), pc.ndim.Polytope(SQUARE + 0.25))


@pytest.mark.parametrize(
    "change",
    [
        lambda c: {"normal": -c.normal},
        lambda c: {"normal": c.normal + np.array([0.0, 1e-9])},
        lambda c: {"normal": np.append(c.normal, 0.0)},
        lambda c: {"normal": np.full(2, np.nan)},
        lambda c: {"offset": c.offset + 1e-9},
        lambda c: {"offset": np.nan},
        lambda c: {"offset": np.inf},
        lambda c: {"gap": c.gap * 1.01},
        lambda c: {"gap": np.inf},
        lambda c: {"gap": np.nan},
        lambda c: {"gap": -1.0},
        lambda c: {"exact_normal": (*c.exact_normal, Fraction(0))},
        lambda c: {"exact_normal": tuple(-x for x in c.exact_normal)},
        lambda c: {"exact_normal": (Fraction(0), Fraction(0))},
        lambda c: {"exact_offset": c.exact_offset * 3},
    ],
)
def test_a_separation_with_one_thing_wrong_is_not_proved(change):
    certificate = _separation()
    assert certificate.verify()
    assert dataclasses.replace(certificate, **change(certificate)).verify() is False


@pytest.mark.parametrize(
    "change",
    [
        lambda c: {"point": c.point + 1e-9},
        lambda c: {"point": np.append(c.point, 0.0)},
        lambda c: {"point": np.full(2, np.nan)},
        lambda c: {"exact_point": (*c.exact_point, Fraction(0))},
        lambda c: {"exact_point": c.exact_point[:1]},
        lambda c: {"exact_point": (c.exact_point[0] + 5, c.exact_point[1])},
        lambda c: {"weights": ({0: Fraction(3), 1: Fraction(-2)}, c.weights[1])},
        lambda c: {"weights": ({}, c.weights[1])},
    ],
)
def test_a_shared_point_with_one_thing_wrong_is_not_proved(change):
    certificate = _shared()
    assert certificate.verify()
    assert dataclasses.replace(certificate, **change(certificate)).verify() is False
