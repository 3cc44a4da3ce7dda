"""Clouds that are thinned: every ball that is left out is inside a larger one that is kept, in exact rationals."""

from collections.abc import Iterator
from fractions import Fraction

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies.thinned_clouds import uncovered


def is_inside(p: np.ndarray, r: float, q: np.ndarray, big: float) -> bool:
    """Whether the ball about p is in the one about q: |p - q| + r <= R, exactly."""
    room = Fraction(float(big)) - Fraction(float(r))
    return (
        room >= 0
        and sum((Fraction(a) - Fraction(b)) ** 2 for a, b in zip(p.tolist(), q.tolist(), strict=True)) <= room**2
    )


def clouds(seed: int, count: int) -> Iterator[tuple[np.random.Generator, float, pc.PointCloud]]:
    """Clouds of all sizes, in lumps, on lattices and with repeated points; of one radius or of many."""
    rng = np.random.default_rng(seed)
    for case in range(count):
        size = 10.0 ** int(rng.integers(-6, 7))
        n = int(rng.choice([1, 2, 30, 120]))
        points = rng.normal(size=(n, 3))
        if case % 3 == 1:
            points = np.round(points * 4) / 4
        if case % 3 == 2:
            points = points[rng.integers(n, size=n)] + rng.normal(size=(n, 3)) * rng.choice([0.0, 1e-9, 0.05])
        radii = rng.uniform(0.05, 0.6, size=n) if case % 2 else np.array([0.1])
        yield rng, size, pc.PointCloud(points * size + rng.normal(size=3) * size * rng.choice([0, 100.0]), radii * size)


def rows_of(cloud: pc.PointCloud) -> np.ndarray:
    """Which rows of the cloud before a thinned one has kept."""
    return np.array([int(cloud.part_name(k)) for k in range(cloud.count)], dtype=np.int64)


def held_by_one(before: pc.PointCloud, after: pc.PointCloud) -> bool:
    """Whether each ball is inside one of the other cloud, exactly; by the nearest first, since that is fast."""
    for p, r in zip(before.points, before.radii, strict=True):
        order = np.argsort(np.linalg.norm(after.points - p, axis=1) - after.radii)
        if not any(is_inside(p, r, after.points[k], after.radii[k]) for k in order):
            return False
    return True


def test_what_is_thinned_is_covered() -> None:
    left_out = 0
    for rng, size, cloud in clouds(1, 60):
        excess = float(size * rng.choice([1e-12, 0.01, 0.1, 1.0]))
        thin, bound = cloud.thinned(excess)
        assert held_by_one(cloud, thin)
        assert 0 <= bound <= excess
        kept = rows_of(thin)
        assert np.array_equal(thin.points, cloud.points[kept])
        assert (thin.radii >= cloud.radii[kept]).all()  # kept ones hold themselves
        for new, old in zip(thin.radii.tolist(), cloud.radii[kept].tolist(), strict=True):
            assert Fraction(new) - Fraction(old) <= Fraction(bound)
        left_out += cloud.count - thin.count
    assert left_out > 200


def test_verdicts_of_a_thinned_cloud_are_on_the_safe_side() -> None:
    seen = set()
    for rng, size, cloud in clouds(2, 40):
        thin, bound = cloud.thinned(0.5 * size)
        grown = pc.PointCloud(cloud.points, cloud.radii + bound * (1 + 1e-12))
        bodies = [pc.Polytope(shape) for shape in (cloud, thin, grown)]
        for _ in range(25):
            at = np.eye(4)
            at[:3, 3] = cloud.points[rng.integers(cloud.count)] + rng.normal(size=3) * 0.4 * size
            box = pc.Polytope(pc.Box((0.2 * size, 0.1 * size, 0.3 * size)))
            verdicts = tuple(pc.intersects(box, body, at) for body in bodies)
            assert list(verdicts) == sorted(
                verdicts
            )  # False before True: cloud, thinned cloud, cloud grown by the bound
            seen.add(verdicts)
    assert seen == {(False, False, False), (False, False, True), (False, True, True), (True, True, True)}


def test_leaving_covered_balls_out_keeps_the_set() -> None:
    left_out = verdicts = 0
    for rng, size, cloud in clouds(3, 60):
        thin = cloud.without_covered()
        kept = rows_of(thin)
        assert np.array_equal(thin.points, cloud.points[kept])
        assert np.array_equal(thin.radii, cloud.radii[kept])
        assert held_by_one(cloud, thin)
        assert thin.count == len(uncovered(thin.points, thin.radii)) or thin.count < cloud.count
        left_out += cloud.count - thin.count
        whole, part = pc.Polytope(cloud), pc.Polytope(thin)
        for _ in range(10):
            at = np.eye(4)
            at[:3, 3] = cloud.points[rng.integers(cloud.count)] + rng.normal(size=3) * 0.4 * size
            box = pc.Polytope(pc.Box((0.2 * size, 0.1 * size, 0.3 * size)))
            expected = pc.intersects(box, whole, at)
            assert pc.intersects(box, part, at) == expected
            verdicts += expected
    assert left_out > 300
    assert 100 < verdicts < 500


def test_a_ball_that_only_touches_from_inside_may_stay_and_one_outside_must() -> None:
    radii = np.array([1.0, 0.5])
    inside = pc.PointCloud([[0, 0, 0], [0.25, 0, 0]], radii)
    touching = pc.PointCloud([[0, 0, 0], [0.5, 0, 0]], radii)
    outside = pc.PointCloud([[0, 0, 0], [np.nextafter(0.5, 1), 0, 0]], radii)
    assert [cloud.without_covered().count for cloud in (inside, touching, outside)] == [1, 2, 2]


def test_names_are_those_of_the_points_given() -> None:
    points = np.array([[np.nan, 0, 0], [0, 0, 0], [0, 0, 0], [5, 0, 0], [np.inf, 0, 0], [5.01, 0, 0]])
    cloud = pc.PointCloud(points, 0.1, invalid="drop")
    assert [cloud.part_name(k) for k in range(4)] == ["1", "2", "3", "5"]
    assert [cloud.without_covered().part_name(k) for k in range(3)] == ["1", "3", "5"]
    thin, bound = cloud.thinned(0.1)
    assert [thin.part_name(k) for k in range(2)] == ["1", "3"]
    assert (thin.dropped, 0.01 < bound < 0.0101) == (2, True)


@pytest.mark.parametrize("excess", [0, -1.0, np.nan, np.inf, "x", None])
def test_an_excess_that_is_none(excess: object) -> None:
    with pytest.raises(pc.PlannercheckError, match="excess of a thinned cloud must be a length"):
        pc.PointCloud([[0, 0, 0]], 0.1).thinned(excess)  # type: ignore[arg-type]


def test_an_empty_cloud_is_thinned() -> None:
    empty = pc.PointCloud(np.zeros((0, 3)), 0.1)
    thin, bound = empty.thinned(0.1)
    assert (thin.count, bound, empty.without_covered().count) == (0, 0.0, 0)


def test_clouds_of_extreme_extent() -> None:
    for scale in (1e-300, 1e-150, 1e40):
        points = np.array([[0, 0, 0], [1, 1, 1], [1, 1, 1], [-3, 2, 1.0]]) * scale
        cloud = pc.PointCloud(points, np.array([0.1, 0.1, 0.2, 0.1]) * scale)
        assert cloud.without_covered().count == 3
        for excess in (1e-310, 1e-3 * scale, 10 * scale):
            if 0 < excess < 1e49:
                thin, bound = cloud.thinned(excess)
                assert held_by_one(cloud, thin)
                assert bound <= excess


def test_thirty_thousand_points_are_thinned_at_once() -> None:
    """By pairs it would take hours."""
    rng = np.random.default_rng(4)
    cloud = pc.PointCloud(rng.uniform(-0.2, 0.2, size=(30_000, 3)), rng.uniform(0.001, 0.02, size=30_000))
    assert cloud.thinned(0.05)[0].count < 10_000
    assert cloud.without_covered().count < 28_000
