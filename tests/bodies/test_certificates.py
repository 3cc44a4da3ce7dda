"""Certificates prove what they say, in exact arithmetic, and stop proving it when anything is changed."""

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any

import exact_verdicts
import numpy as np
import pytest
from poses import at, random_turn

import plannercheck as pc
from plannercheck.bodies import exact_reference as exact
from plannercheck.bodies.certificates import ExactPoint, Mixture, Separation, SharedPoint
from plannercheck.bodies.exact_planes import ExactPlane, PosedBody
from plannercheck.bodies.tuning import METHODS
from plannercheck.common.array_types import Floats

CUBE = np.array(list(product((-1.0, 1.0), repeat=3)))
SQUARE = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
SEGMENT = np.array([[-1.0, 0, 0], [1, 0, 0]])
POINT = np.zeros((1, 3))


def random_points(rng: np.random.Generator) -> Floats:
    """A small body of any dimension, often with coincidences."""
    points = rng.normal(size=(rng.integers(1, 9), 3))
    kind = rng.integers(5)
    if kind == 0:
        return rng.integers(-2, 3, size=points.shape).astype(float)
    if kind == 1:
        return points * [1, 1, 0]
    if kind == 2:
        return np.outer(points[:2, 0], points[0])
    return points[: 1 if kind == 3 else None]


def proved(p: pc.Polytope, r: pc.Polytope, pose_p: Floats, pose_r: Floats) -> Separation | SharedPoint:
    certificate = pc.certify(p, r, pose_p, pose_r)
    assert certificate.verify()
    assert isinstance(certificate, SharedPoint) == pc.intersects(p, r, pose_p, pose_r)
    return certificate


@pytest.mark.parametrize(
    ("p", "r", "pose", "shared"),
    [
        ((CUBE, 0.0), (CUBE, 0.0), at(2, 0, 0), True),  # a facet on a facet
        ((CUBE, 0.0), (CUBE, 0.0), at(2, 2, 2), True),  # a corner on a corner
        ((CUBE, 0.0), (CUBE, 0.0), at(np.nextafter(2, 3), 0, 0), False),  # an ulp apart
        ((CUBE, 0.0), (CUBE / 4, 0.0), at(0, 0, 0), True),  # one in the other
        ((CUBE, 0.0), (CUBE, 0.0), at(0, 0, 0), True),  # the same twice
        ((CUBE, 0.0), (CUBE, 0.0), at(1e9, -1e6, 3), False),
        ((SQUARE, 0.0), (SQUARE, 0.0), at(0, 0, 1e-300), False),  # plates, one right above the other
        ((SQUARE, 0.0), (SEGMENT, 0.0), at(0.5, 0.25, 0), True),
        ((SEGMENT, 0.0), (SEGMENT, 0.0), at(2, 0, 0), True),
        ((POINT, 0.0), (POINT, 0.0), at(0, 0, 0), True),
        ((POINT, 1.0), (POINT, 2.0), at(3, 0, 0), True),  # balls that touch
        ((POINT, 1.0), (POINT, 2.0), at(np.nextafter(3, 4), 0, 0), False),
        ((POINT, 0.5), (CUBE, 0.0), at(0.25, 0.5, 0.5), True),  # a ball in a cube
        ((SEGMENT, 0.5), (SEGMENT, 0.5), at(0, 0, 1, turn=np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])), True),
        ((SQUARE, 0.25), (CUBE, 0.75), at(0, 0, 2), True),
        ((SQUARE, 0.25), (CUBE, 0.75), at(0, 0, np.nextafter(2, 3)), False),
        ((CUBE * 1e6, 0.0), (CUBE * 1e-6, 0.0), at(1e6, 1e5, -3e4), True),
    ],
)
def test_plain_cases(p: tuple[Floats, float], r: tuple[Floats, float], pose: Floats, shared: bool) -> None:
    first, second = (pc.Polytope(points, inflation_radius=inflation_radius) for points, inflation_radius in (p, r))
    assert isinstance(proved(first, second, at(0, 0, 0), pose), SharedPoint) == shared
    assert isinstance(proved(second, first, pose, at(0, 0, 0)), SharedPoint) == shared


def test_random_small_bodies_of_all_dimensions() -> None:
    # All solvers agree with the oracle, all certificates hold, and the gap is below the true distance.
    rng = np.random.default_rng(7)
    verdicts = []
    for _ in range(300):
        scale, inflation_radii = 10.0 ** rng.integers(-6, 7), rng.choice([0, 0.5, 1e-9, rng.uniform()], 2)
        bodies = [(random_points(rng) * scale, float(inflation_radius * scale)) for inflation_radius in inflation_radii]
        poses = [at(*rng.uniform(-1, 1, 3) * scale, turn=random_turn(rng)) for _ in range(2)]
        arguments = bodies[0][0], bodies[1][0], *poses, bodies[0][1], bodies[1][1]
        truth = exact_verdicts.intersects(*arguments)
        p, r = (pc.Polytope(points, inflation_radius=inflation_radius) for points, inflation_radius in bodies)
        assert [pc.intersects(p, r, *poses, method=method) for method in METHODS] == [truth] * len(METHODS)
        certificate = proved(p, r, *poses)
        verdicts.append(isinstance(certificate, SharedPoint))
        assert verdicts[-1] == truth
        if isinstance(certificate, Separation):
            assert 0 <= certificate.gap <= exact.distance(*arguments) * (1 + 1e-15)
            assert np.linalg.norm(certificate.normal) == pytest.approx(1, abs=1e-15)
    assert 50 < sum(verdicts) < 250


@pytest.mark.parametrize("swapped", [False, True])
def test_a_direction_of_entries_2_to_the_1094_apart(swapped: bool) -> None:
    """A triangle rises by one denormal along 2^20 m; a segment under it meets its edge, or stays below it."""
    rise, far = 2.0**-1074, 2.0**20
    triangle = pc.Polytope(np.array([[0, 0, 0], [0, 1, 0], [far, 0.5, rise]]))
    for start in (-1.0, 0.0, rise, 1.0):
        for y in (0.25, 0.5, 0.75):
            ends = np.array([[start, y, 0], [far / 2, y, 0]])[:: -1 if swapped else 1]
            segment = pc.Polytope(ends)
            truth = exact_verdicts.intersects(triangle.vertices, ends)
            assert truth == (start <= 0)
            for method in METHODS:
                assert pc.intersects(triangle, segment, method=method) == truth
                assert pc.intersects(segment, triangle, method=method) == truth
            assert isinstance(proved(triangle, segment, at(0, 0, 0), at(0, 0, 0)), SharedPoint) == truth


def test_far_from_the_origin_a_gap_below_rounding_is_proved() -> None:
    rng = np.random.default_rng(8)
    p = pc.Polytope(rng.normal(size=(100, 3)))
    turn = random_turn(rng)
    pose = at(1e6, -1e6, 1e6, turn=turn)
    assert isinstance(proved(p, p, pose, pose), SharedPoint)
    for shift in np.geomspace(1e-12, 10, 14):
        proved(p, p, pose, pose + at(shift, 0, 0) - np.eye(4))


def test_gap_and_offset_are_those_of_the_inflated_bodies_along_the_normal() -> None:
    ball, capsule = pc.Polytope(POINT, inflation_radius=0.5), pc.Polytope(SEGMENT, inflation_radius=0.25)
    certificate = proved(ball, capsule, at(5, 4, 0), at(0, 0, 0))
    assert isinstance(certificate, Separation)
    low, high = np.array([5, 4, 0]) @ certificate.normal - 0.5, (SEGMENT @ certificate.normal).max() + 0.25
    assert certificate.gap == pytest.approx(low - high, rel=1e-14)
    assert certificate.gap <= np.sqrt(32) - 0.75
    assert certificate.offset == pytest.approx((low + high) / 2, rel=1e-14)


def test_exact_forms_are_fractions_that_round_to_the_doubles() -> None:
    apart = proved(pc.Polytope(CUBE), pc.Polytope(CUBE), at(3, 0, 0), at(0, 0, 0))
    assert isinstance(apart, Separation)
    plane = apart.exact()
    assert all(isinstance(x, Fraction) for x in (*plane.normal, plane.length, plane.offset, plane.gap))
    assert (float(plane.gap), float(plane.offset / plane.length)) == (apart.gap, apart.offset)
    shared = proved(pc.Polytope(CUBE), pc.Polytope(SQUARE), at(0.3, 0, 0), at(0, 0, 0.1))
    assert isinstance(shared, SharedPoint)
    place = shared.exact()
    assert [float(x) for x in place.point] == shared.point.tolist()
    assert sum(place.first) == sum(place.second) == 1
    assert len(place.first) == len(shared.first.vertices) <= 4
    mixed = sum(
        w * Fraction(float(CUBE[pc.Polytope(CUBE).source[v], 1]))
        for v, w in zip(shared.first.vertices, place.first, strict=True)
    )
    assert mixed == place.point[1]


def mutated_separations(c: Separation) -> Iterator[Separation]:
    plane = c.plane
    yield replace(c, normal=-c.normal)
    yield replace(c, normal=c.normal + np.array([0, 1e-12, 0]))
    yield replace(c, normal=np.full(3, np.nan))
    yield replace(c, offset=c.offset + 1e-9)
    yield replace(c, offset=float("nan"))
    yield replace(c, gap=np.nextafter(c.gap, np.inf))
    yield replace(c, gap=-1.0)
    yield replace(c, plane=replace(plane, gap=plane.gap * 2), gap=c.gap * 2)
    yield replace(c, plane=replace(plane, gap=-plane.gap), gap=0.0)
    for factor in (2, -1, Fraction(1, 2)):
        yield replace(c, plane=replace(plane, length=plane.length * factor))
    yield replace(c, plane=replace(plane, normal=(Fraction(0),) * 3))
    yield replace(c, plane=replace(plane, normal=(plane.normal[1], plane.normal[0], plane.normal[2])))
    for side in (-1, 1):
        # On the border of a body, and a little further: within its inflation where it has one.
        for part in (Fraction(1, 2), Fraction(51, 100)):
            offset = plane.offset + side * part * plane.gap * plane.length
            yield replace(c, plane=replace(plane, offset=offset), offset=float(offset / plane.length))
    yield replace(c, bodies=c.bodies[::-1])
    first, second = c.bodies
    away = np.linalg.norm(c.normal) * 3
    moved = np.array(first.vertices)
    moved[0] -= away * c.normal @ first.pose[:3, :3]
    yield replace(c, bodies=(replace(first, vertices=moved), second))
    yield replace(c, bodies=(first, replace(second, inflation_radius=second.inflation_radius + 3)))


def mutated_points(c: SharedPoint) -> Iterator[SharedPoint]:
    place = c.place
    weights, k = place.first, len(place.first)
    yield replace(c, point=np.nextafter(c.point, np.inf))
    yield replace(c, point=np.full(3, np.nan))
    far = tuple(x + 5 for x in place.point)
    yield replace(c, point=np.array([float(x) for x in far]), place=replace(place, point=far))
    yield replace(c, first=replace(c.first, weights=c.first.weights * (1 - 1e-12)))
    yield replace(c, place=replace(place, first=tuple(w * (1 + Fraction(1, 10**30)) for w in weights)))
    yield replace(c, first=Mixture(c.first.vertices + 1000, c.first.weights))
    yield replace(c, first=Mixture(c.first.vertices - 1000, c.first.weights))
    yield replace(c, first=Mixture(np.zeros(0, dtype=np.int64), np.zeros(0)), place=replace(place, first=()))
    yield replace(c, first=Mixture(c.first.vertices[:-1], c.first.weights))
    # More vertices than four.
    split = tuple(w / 5 for w in weights for _ in range(5))
    many = Mixture(np.repeat(c.first.vertices, 5), np.array([float(w) for w in split]))
    yield replace(c, first=many, place=replace(place, first=split))
    # All weight on another place.
    second = c.bodies[1]
    pose = np.array(second.pose)
    pose[:3, 3] += 50
    yield replace(c, bodies=(c.bodies[0], replace(second, pose=pose)))
    if k > 1:
        turned = (*weights[1:], weights[0])
        if turned != weights:
            mixture = Mixture(c.first.vertices, np.array([float(w) for w in turned]))
            yield replace(c, first=mixture, place=replace(place, first=turned))


@pytest.mark.parametrize("inflation_radius", [0.0, 0.25])
def test_mutated_separations_are_rejected(inflation_radius: float) -> None:
    rng = np.random.default_rng(9)
    for _ in range(10):
        p = pc.Polytope(rng.normal(size=(12, 3)), inflation_radius=inflation_radius)
        c = proved(p, p, at(6, 5, 1, turn=random_turn(rng)), at(0, 0, 0, turn=random_turn(rng)))
        assert isinstance(c, Separation)
        for k, mutant in enumerate(mutated_separations(c)):
            assert not mutant.verify(), k


@pytest.mark.parametrize("inflation_radius", [0.0, 1e-9])
def test_mutated_shared_points_are_rejected(inflation_radius: float) -> None:
    rng = np.random.default_rng(10)
    for _ in range(10):
        p = pc.Polytope(rng.normal(size=(12, 3)), inflation_radius=inflation_radius)
        c = proved(p, p, at(0.7, 0.2, 0.1, turn=random_turn(rng)), at(0, 0, 0, turn=random_turn(rng)))
        assert isinstance(c, SharedPoint)
        for k, mutant in enumerate(mutated_points(c)):
            assert not mutant.verify(), k


def of_weights(weights: tuple[Fraction, ...]) -> Mixture:
    return Mixture(np.arange(len(weights)), np.array([float(w) for w in weights]))


def test_weights_below_0_mix_nothing() -> None:
    """Their sum is 1, and what they mix is the point; but it is beyond the vertices. Two cubes, 4 m apart."""
    far = at(5, 0, 0)
    bodies = PosedBody(CUBE[[0, 4]], at(0, 0, 0)), PosedBody(CUBE[[0, 4]], far)  # x = -1 and x = 1
    beyond, within = (Fraction(-3, 2), Fraction(5, 2)), (Fraction(1), Fraction(0))
    point = (Fraction(4), Fraction(-1), Fraction(-1))
    for first, second in ((beyond, within), ((Fraction(-2), Fraction(3)), (Fraction(1, 2), Fraction(1, 2)))):
        x = first[1] - first[0]
        place = ExactPoint((x, *point[1:]), first, second)
        c = SharedPoint(np.array([float(x), -1, -1]), of_weights(first), of_weights(second), place, bodies)
        assert not c.verify()
        turned = SharedPoint(c.point, c.second, c.first, replace(place, first=second, second=first), bodies[::-1])
        assert not turned.verify()
    # The same with weights of at least 0, of cubes that meet there.
    near = PosedBody(CUBE[[0, 4]], at(1.5, 0, 0))
    place = ExactPoint((Fraction(1, 2), *point[1:]), (Fraction(1, 4), Fraction(3, 4)), within)
    halves = SharedPoint(np.array([0.5, -1, -1]), of_weights(place.first), of_weights(within), place, (bodies[0], near))
    assert halves.verify()


def test_a_length_below_that_of_the_normal_separates_nothing() -> None:
    """Two balls that overlap by 0.5 m: with half the length their radii would count half."""
    bodies = PosedBody(POINT, at(1.5, 0, 0), 1.0), PosedBody(POINT, at(0, 0, 0), 1.0)
    for length in (Fraction(1, 2), Fraction(7, 10)):
        normal, offset = (Fraction(1), Fraction(0), Fraction(0)), Fraction(3, 4)
        gap = Fraction(3, 2) / length - 2
        assert gap > 0
        plane = ExactPlane(normal, length, offset, gap)
        doubles = np.array([float(1 / length), 0, 0]), float(offset / length), float(gap) * (1 - 1e-15)
        assert not Separation(*doubles, plane, bodies).verify()


@pytest.mark.parametrize(
    "shift", [Fraction(1, 10**20), Fraction(1, 4), Fraction(9, 10), Fraction(-1, 4), Fraction(-9, 10)]
)
def test_a_plane_within_the_inflation_separates_nothing(shift: Fraction) -> None:
    """Two balls of 1 m, 1 m apart: the plane may lie anywhere between, but not in one of them."""
    bodies = PosedBody(POINT, at(3, 0, 0), 1.0), PosedBody(POINT, at(0, 0, 0), 1.0)
    normal, one = (Fraction(1), Fraction(0), Fraction(0)), Fraction(1)
    for inside in (False, True):
        border = Fraction(2) if shift > 0 else one
        offset = border + (shift if inside else -shift) * (1 if inside else Fraction(1, 2))
        plane = ExactPlane(normal, one, offset, one)
        c = Separation(np.array([1.0, 0, 0]), float(offset), 1.0, plane, bodies)
        assert c.verify() == (not inside)


def test_equality_and_words_leave_the_bodies_out() -> None:
    for distance in (3.0, 1.0):
        first, second = (pc.certify(pc.Polytope(CUBE), pc.Polytope(CUBE), at(distance, 0, 0)) for _ in range(2))
        assert first == second
        assert replace(first, bodies=(PosedBody(CUBE, at(9, 9, 9)),) * 2) == first
        assert "PosedBody" not in repr(first)
        assert first != pc.certify(pc.Polytope(CUBE), pc.Polytope(CUBE), at(distance + 0.5, 0.25, 0))


def test_a_checker_explains_with_certificates_that_hold() -> None:
    robot, scene = pc.Robot.load("panda"), pc.Scene()
    scene.add_sphere("ball", 0.1, at(0.4, 0, 0.5))
    scene.add_box("table", (1.0, 1.0, 0.02), at(0.5, 0, -0.05))
    checker = pc.Checker(robot, scene)
    for q in robot.random_configurations(5, seed=3):
        verdict = checker.explain(q, separations=True)
        certificates: list[Any] = [pair.certificate for pair in (*verdict.collisions, *verdict.separations)]
        assert len(certificates) == len(checker.pairs)
        assert all(certificate.verify() for certificate in certificates)
