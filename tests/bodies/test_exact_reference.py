"""The exact oracle against a second exact method and against cases whose answer is plain."""

import math
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from numpy.typing import NDArray
from poses import at, pose_within

from plannercheck.bodies import exact_reference as exact
from plannercheck.common.errors import PlannercheckError

Points = NDArray[np.float64]

UNIT_BOX = np.array(list(product((0.0, 1.0), repeat=3)))


def verdict(p: Points, r: Points, pose_p: Points | None = None, pose_r: Points | None = None) -> bool:
    """The oracle's verdict, its certificate checked, the same with both bodies swapped."""
    certificate = exact.decide(p, r, pose_p, pose_r)
    assert exact.holds(certificate, p, r, pose_p, pose_r)
    collides = isinstance(certificate, exact.ExactSharedPoint)
    assert exact.intersects(r, p, pose_r, pose_p) == collides
    assert (exact.distance(p, r, pose_p, pose_r) == 0) == collides
    return collides


def linear_program(p: Points, r: Points, pose_p: Points, pose_r: Points) -> bool:
    """Whether 0 is a convex combination of differences: phase one of the simplex method with Bland's rule."""
    differences = [
        [a - b for a, b in zip(left, right, strict=True)] for left, right in product(posed(p, pose_p), posed(r, pose_r))
    ]
    columns = [[*difference, Fraction(1)] for difference in differences]
    rows = [[column[k] for column in columns] + [Fraction(int(k == 3))] for k in range(4)]
    basis = [-1, -2, -3, -4]
    while True:
        artificial = [row for row, variable in zip(rows, basis, strict=True) if variable < 0]
        gains = [sum(row[k] for row in artificial) for k in range(len(columns))]
        entering = next((k for k, gain in enumerate(gains) if gain > 0), None)
        if entering is None:
            return sum(row[-1] for row in artificial) == 0
        steps = [(row[-1] / row[entering], basis[k], k) for k, row in enumerate(rows) if row[entering] > 0]
        _, _, leaving = min(steps)
        pivot(rows, leaving, entering)
        basis[leaving] = entering


def posed(points: Points, pose: Points) -> list[list[Fraction]]:
    matrix = [[Fraction(x) for x in row] for row in pose.tolist()]
    return [
        [sum(m * Fraction(x) for m, x in zip(row, point, strict=False)) + row[3] for row in matrix[:3]]
        for point in points.tolist()
    ]


def pivot(rows: list[list[Fraction]], leaving: int, entering: int) -> None:
    factor = rows[leaving][entering]
    rows[leaving] = [x / factor for x in rows[leaving]]
    for k, row in enumerate(rows):
        if k != leaving and row[entering] != 0:
            rows[k] = [x - row[entering] * y for x, y in zip(row, rows[leaving], strict=True)]


def shifted(points: Points, *offset: float) -> Points:
    return points + np.array(offset)


def test_agrees_with_a_linear_program_on_random_bodies() -> None:
    rng = np.random.default_rng(1)
    verdicts = []
    for _ in range(60):
        p, r = rng.normal(size=(rng.integers(1, 8), 3)), rng.normal(size=(rng.integers(1, 8), 3))
        pose_p, pose_r = pose_within(rng, 1.0), pose_within(rng, 1.0)
        verdicts.append(verdict(p, r, pose_p, pose_r))
        assert verdicts[-1] == linear_program(p, r, pose_p, pose_r)
    assert 10 < sum(verdicts) < 50


def test_agrees_with_a_linear_program_on_a_small_grid() -> None:
    # Small integers make every degeneracy frequent: shared points, edges and planes, repeated vertices.
    rng = np.random.default_rng(2)
    verdicts = []
    for _ in range(150):
        p = rng.integers(-2, 3, size=(rng.integers(1, 7), 3)).astype(float)
        r = rng.integers(-2, 3, size=(rng.integers(1, 7), 3)).astype(float) + np.array([2.0, 1.0, 0.0])
        verdicts.append(verdict(p, r))
        assert verdicts[-1] == linear_program(p, r, np.eye(4), np.eye(4))
    assert 20 < sum(verdicts) < 130


@pytest.mark.parametrize("offset", [(1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0.5, -0.25), (-1, 0.25, 1)])
def test_boxes_touching_in_a_facet_edge_or_vertex_collide(offset: tuple[float, float, float]) -> None:
    assert verdict(UNIT_BOX, shifted(UNIT_BOX, *offset))


@pytest.mark.parametrize("offset", [(1, 0, 0), (1, 1, 0), (1, 1, 1)])
def test_boxes_one_ulp_apart_are_free(offset: tuple[float, float, float]) -> None:
    # The ulp goes into the pose: above 1 it is 2^-52.
    pose = at(*np.nextafter(offset, np.where(np.array(offset) > 0, 2, 0)))
    assert not verdict(UNIT_BOX, UNIT_BOX, pose_r=pose)
    pose[:3, 3] = np.nextafter(offset, 0)
    assert verdict(UNIT_BOX, UNIT_BOX, pose_r=pose)


def test_a_gap_below_the_rounding_of_the_posed_vertices_counts() -> None:
    # M v = 1 + 2^-60 in exact arithmetic, 1 in doubles.
    pose = at(2.0**-60)
    assert not verdict(UNIT_BOX, shifted(UNIT_BOX, -1, 0, 0), pose_p=pose)
    pose[0, 3] = -(2.0**-60)
    assert verdict(UNIT_BOX, shifted(UNIT_BOX, -1, 0, 0), pose_p=pose)


def test_nested_and_identical_bodies_collide() -> None:
    assert verdict(UNIT_BOX, UNIT_BOX)
    assert verdict(UNIT_BOX, UNIT_BOX * 0.25 + 0.25)
    assert verdict(UNIT_BOX, np.full((1, 3), 0.5))


def test_flat_bodies_segments_and_points() -> None:
    square = UNIT_BOX[UNIT_BOX[:, 2] == 0]
    segment = np.array([[0.5, 0.5, -1.0], [0.5, 0.5, 1.0]])
    assert verdict(square, segment)
    assert not verdict(square, shifted(segment, 0.5 + 2**-30, 0, 0))
    assert verdict(square, shifted(segment, 0.5, 0.5, 1))
    assert not verdict(square, shifted(square, 0, 0, 2.0**-1000))
    assert verdict(square[:1], square[:1])
    assert not verdict(square[:1], square[1:2])


def test_needles_whose_lines_cross_without_meeting() -> None:
    along_x, along_y = np.array([[-1.0, 0, 0], [1, 0, 0]]), np.array([[0, -1.0, 0], [0, 1, 0]])
    assert verdict(along_x, along_y)
    assert not verdict(along_x, shifted(along_y, 0, 0, 5e-324))


def test_scales_far_apart() -> None:
    assert verdict(UNIT_BOX * 1e300, UNIT_BOX * 1e-300)
    assert not verdict(UNIT_BOX * 1e300, shifted(-UNIT_BOX * 1e-300, -1e-300, 0, 0))


@pytest.mark.parametrize("gap", [1e-3, 1e-9, 1e-12, -1e-12, -1e-9, -1e-3])
def test_known_gaps_of_round_bodies(gap: float) -> None:
    # A vertex exactly above the middle of a large facet, both bodies turned together.
    rng = np.random.default_rng(3)
    round_body = rng.normal(size=(200, 3))
    round_body /= np.linalg.norm(round_body, axis=1)[:, None]
    tip = np.concatenate([round_body, [[0.0, 0.0, -2.0]]])
    turn = pose_within(rng, 3.0)
    lift = at(0, 0, 3.0 + gap)
    assert verdict(UNIT_BOX - [0.5, 0.5, 0.0], tip, turn, turn @ lift) == (gap < 0)


def test_distance_is_right_to_the_last_digits() -> None:
    apart = shifted(UNIT_BOX, 2, 3, 1)
    assert exact.distance(UNIT_BOX, apart) == pytest.approx(math.sqrt(5), rel=1e-15)
    assert exact.distance(UNIT_BOX * 1e-200, apart * 1e-200) == pytest.approx(math.sqrt(5) * 1e-200, rel=1e-15)


def inflated_verdict(
    p: Points, r: Points, inflation_p: float, inflation_r: float, pose_r: Points | None = None
) -> bool:
    """The oracle's verdict on inflated bodies, its certificate checked, the same with both bodies swapped."""
    certificate = exact.decide(p, r, None, pose_r, inflation_p, inflation_r)
    assert exact.holds(certificate, p, r, None, pose_r, inflation_p, inflation_r)
    collides = isinstance(certificate, exact.ExactSharedPoint)
    assert exact.intersects(r, p, pose_r, None, inflation_r, inflation_p) == collides
    assert (exact.distance(p, r, None, pose_r, inflation_p, inflation_r) == 0) == collides
    return collides


def test_balls_touch_where_the_radii_add_up_to_the_distance() -> None:
    # Pythagorean distances are exact in doubles, and so is one ulp less.
    centre = np.zeros((1, 3))
    for offset, distance in (((2, 3, 6), 7), ((1, 4, 8), 9), ((0.75, 1, 0), 1.25)):
        ball = shifted(centre, *offset)
        assert inflated_verdict(centre, ball, distance - 0.5, 0.5)
        assert not inflated_verdict(centre, ball, np.nextafter(distance - 0.5, 0), 0.5)
        assert inflated_verdict(centre, ball, distance, 0)
        assert not inflated_verdict(centre, ball, distance, -0.0, np.diag([1 + 2**-50] * 3 + [1]))


def test_a_inflation_radius_counts_to_the_last_bit_whatever_its_unit() -> None:
    centre = np.zeros((1, 3))
    pose = at(1.0)
    assert inflated_verdict(centre, centre, 1.0, 0, pose)
    assert not inflated_verdict(centre, shifted(centre, 5e-324, 0, 0), 1.0, 0, pose)
    assert inflated_verdict(centre, shifted(centre, 5e-324, 0, 0), 1.0, 5e-324, pose)


def test_a_ball_and_a_box() -> None:
    centre = np.zeros((1, 3))
    corner = shifted(centre, 1 + 2, 1 + 3, 1 + 6)
    assert inflated_verdict(UNIT_BOX, corner, 0, 7)
    assert not inflated_verdict(UNIT_BOX, corner, 0, np.nextafter(7, 0))
    edge, facet = shifted(centre, 0.5, 4, 5), shifted(centre, 0.25, 0.75, -1.5)
    assert inflated_verdict(UNIT_BOX, edge, 0, 5)
    assert not inflated_verdict(UNIT_BOX, edge, 0, np.nextafter(5, 0))
    assert inflated_verdict(UNIT_BOX, facet, 0.25, 1.25)
    assert not inflated_verdict(UNIT_BOX, facet, 0.25, np.nextafter(1.25, 0))
    assert inflated_verdict(UNIT_BOX, np.full((1, 3), 0.5), 0, 0.1)


def test_capsules() -> None:
    along_x, along_y = np.array([[-1.0, 0, 0], [1, 0, 0]]), np.array([[0, -1.0, 0], [0, 1, 0]])
    # Crossing, side by side, end to end, and askew with an end against an end.
    for other, distance in (
        (shifted(along_y, 0.5, 0.5, 2), 2.0),
        (shifted(along_x, 1.5, 0, 2), 2.0),
        (shifted(along_x, 4, 0, 0), 2.0),
        (shifted(along_y, 3, 5, 6), math.sqrt(4 + 16 + 36)),
    ):
        assert inflated_verdict(along_x, other, distance * 0.75, distance * 0.2500001)
        assert not inflated_verdict(along_x, other, distance * 0.75, distance * 0.2499999)
        assert exact.distance(along_x, other, inflation_p=0.25, inflation_r=0.5) == pytest.approx(
            distance - 0.75, rel=1e-15
        )


def test_random_balls_capsules_and_plates_against_their_closed_forms() -> None:
    rng = np.random.default_rng(4)
    verdicts = []
    for _ in range(200):
        ends, ball, (first, second) = rng.normal(size=(2, 3)), rng.normal(size=3), rng.uniform(0, 1, 2)
        along = np.clip((ball - ends[0]) @ (ends[1] - ends[0]) / ((ends[1] - ends[0]) @ (ends[1] - ends[0])), 0, 1)
        distance = np.linalg.norm(ends[0] + along * (ends[1] - ends[0]) - ball)
        verdicts.append(inflated_verdict(ends, ball[None], first, second))
        assert verdicts[-1] == (distance <= first + second)
        beyond = ball - np.clip(ball, [0, 0, 0], [1, 1, 0])
        plate = UNIT_BOX[UNIT_BOX[:, 2] == 0]
        assert inflated_verdict(plate, ball[None], first, second) == (np.linalg.norm(beyond) <= first + second)
    assert 40 < sum(verdicts) < 160


def test_the_distance_of_inflated_bodies_does_not_cancel() -> None:
    centre = np.zeros((1, 3))
    assert exact.distance(centre, shifted(centre, 7, 0, 0), inflation_p=np.nextafter(7, 0)) == 2.0**-50
    assert exact.distance(centre, shifted(centre, 2, 3, 6), inflation_p=3.0, inflation_r=3.999999) == 7 - 3 - 3.999999


@pytest.mark.parametrize("inflation_radius", [-1.0, math.nan, math.inf])
def test_bad_inflation_radii_are_named(inflation_radius: float) -> None:
    with pytest.raises(PlannercheckError, match="inflation radius"):
        exact.decide(UNIT_BOX, UNIT_BOX, inflation_r=inflation_radius)


def test_a_wrong_certificate_of_inflated_bodies_does_not_hold() -> None:
    centre, apart = np.zeros((1, 3)), np.array([[3.0, 4, 0]])
    assert exact.holds(exact.ExactSeparation((-3, -4, 0)), centre, apart, inflation_p=4.9)
    assert not exact.holds(exact.ExactSeparation((-3, -4, 0)), centre, apart, inflation_p=5)
    assert not exact.holds(exact.ExactSeparation((-1, 0, 0)), centre, apart, inflation_p=4.9)
    assert exact.holds(exact.ExactSharedPoint((0,), (0,), (3,)), centre, apart, inflation_p=4, inflation_r=1)
    assert not exact.holds(exact.ExactSharedPoint((0,), (0,), (3,)), centre, apart, inflation_p=4, inflation_r=0.9)


def test_a_wrong_certificate_does_not_hold() -> None:
    apart = shifted(UNIT_BOX, 1.5, 0, 0)
    assert exact.holds(exact.ExactSeparation((-1, 0, 0)), UNIT_BOX, apart)
    assert not exact.holds(exact.ExactSeparation((1, 0, 0)), UNIT_BOX, apart)
    assert not exact.holds(exact.ExactSeparation((0, 0, 0)), UNIT_BOX, apart)
    assert not exact.holds(exact.ExactSharedPoint((0,), (0,), (1,)), UNIT_BOX, apart)
    assert exact.holds(exact.ExactSharedPoint((0,), (0,), (1,)), UNIT_BOX, UNIT_BOX)
    assert not exact.holds(exact.ExactSharedPoint((), (), ()), UNIT_BOX, UNIT_BOX)


@pytest.mark.parametrize("vertices", [np.zeros((0, 3)), np.zeros((4, 2)), np.full((4, 3), np.nan), np.zeros(3)])
def test_bad_vertices_are_named(vertices: Points) -> None:
    with pytest.raises(PlannercheckError, match="vertices"):
        exact.decide(vertices, UNIT_BOX)


def test_bad_poses_are_named() -> None:
    with pytest.raises(PlannercheckError, match="pose"):
        exact.decide(UNIT_BOX, UNIT_BOX, np.eye(3))
    with pytest.raises(PlannercheckError, match="pose"):
        exact.decide(UNIT_BOX, UNIT_BOX, np.full((4, 4), np.inf))
