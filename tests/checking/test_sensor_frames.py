"""Frames of sensors: the next one replaces the shape alone, and checkers of it judge as new ones do, in any order."""

import pickle
import time
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numpy as np
import pytest
from poses import at

import plannercheck as pc
from plannercheck.bodies.part_sets import PartSet
from plannercheck.common.array_types import Floats


@cache
def panda() -> pc.Robot:
    return pc.Robot.load("panda")


@cache
def states() -> Floats:
    return panda().random_configurations(400, seed=1)


def points_of(frame: int, count: int = 1500) -> Floats:
    """On two boards, that move from frame to frame."""
    rng = np.random.default_rng(frame)
    points = rng.uniform(-0.5, 0.5, size=(count, 3)) * [0.6, 1.2, 0.01] + [0.6 - 0.05 * frame, 0.0, 0.0]
    points[:, 2] += rng.choice([0.25, 0.75], size=count) + 0.02 * frame
    return points


def shape_of(kind: str, frame: int) -> PartSet:
    rng = np.random.default_rng(frame)
    if kind == "cloud":
        return pc.PointCloud(points_of(frame), 0.01)
    if kind == "grid":
        return pc.VoxelGrid(rng.random((12, 12, 12)) < 0.1, 0.07, (0.2, -0.4, 0.0))
    if kind == "heights":
        return pc.HeightField(rng.uniform(0.0, 0.4, size=(20, 20)), 0.05, -0.1, (0.2, -0.5))
    return pc.Octree.from_cells(np.unique(rng.integers(3, 15, size=(120, 3)), axis=0), 0.07)


def frame_of(kind: str, frame: int) -> object:
    """What a sensor gives: numbers, or a whole octree."""
    shape = shape_of(kind, frame)
    if isinstance(shape, pc.PointCloud):
        return shape.points
    if isinstance(shape, pc.VoxelGrid):
        return shape.occupied
    return shape.heights if isinstance(shape, pc.HeightField) else shape


def kitchen(kind: str, frame: int) -> pc.Scene:
    scene, there = pc.Scene("kitchen"), np.eye(4)
    there[:3, 3] = [-0.5, 0.4, 0.3]
    scene.add_box("shelf", (0.3, 0.3, 0.6), there)
    scene.add("sensor", shape_of(kind, frame))
    return scene


@pytest.mark.parametrize("kind", ["cloud", "grid", "heights", "map"])
def test_a_checker_of_the_next_frame_judges_as_a_new_one(kind: str) -> None:
    scene = kitchen(kind, 0)
    checker, q = pc.Checker(panda(), scene), states()
    first = checker.check_states(q)
    for frame in (1, 2, 3):
        scene.update("sensor", frame_of(kind, frame))
        checker = checker.with_scene(scene)
        fresh = pc.Checker(panda(), kitchen(kind, frame))
        assert np.array_equal(checker.check_states(q), fresh.check_states(q))
        assert np.array_equal(checker.check_motions(q[:-1], q[1:]), fresh.check_motions(q[:-1], q[1:]))
        assert np.array_equal(checker.colliding_pairs(q[:50]), fresh.colliding_pairs(q[:50]))
    assert not np.array_equal(first, checker.check_states(q))


def test_earlier_checkers_and_copies_keep_their_frame() -> None:
    scene = kitchen("cloud", 0)
    checker, copied, before = pc.Checker(panda(), scene), scene.copy(), scene.object("sensor")
    expected = checker.check_states(states())
    scene.update("sensor", points_of(3))
    assert np.array_equal(checker.check_states(states()), expected)
    assert copied.object("sensor") is checker.scene.object("sensor") is before
    assert scene.object("sensor") is not before
    assert scene.object("shelf") is copied.object("shelf")
    assert scene.object_names == ("shelf", "sensor")


def test_points_are_copied_and_the_rest_of_a_cloud_stays() -> None:
    scene = pc.Scene()
    pose = at(1, 2, 3)
    scene.add("sensor", pc.PointCloud(points_of(0), 0.03, invalid="drop"), pose)
    given = points_of(1)
    given[2] = np.nan
    scene.update("sensor", given)
    given[:] = 7
    (part,) = scene.object("sensor").parts
    assert isinstance(part.shape, pc.PointCloud)
    assert part.shape.dropped == 1
    assert part.shape.part_name(2) == "3"
    assert part.shape.radius.tolist() == [0.03]
    assert np.array_equal(part.shape.points[0], points_of(1)[0])
    assert np.array_equal(scene.object("sensor").pose, pose)


def test_carried_clouds_are_updated_on_their_link() -> None:
    scene = pc.Scene()
    held = np.random.default_rng(0).normal(size=(50, 3)) * 0.04 + [0, 0, 0.2]
    fingers = ("panda_leftfinger", "panda_rightfinger")
    scene.attach("held", "panda_hand", touch_links=fingers, parts=pc.PointCloud(held, 0.01))
    checker = pc.Checker(panda(), scene)
    scene.update("held", held + np.array([0, 0, 0.1]))
    new = pc.Scene()
    new.attach("held", "panda_hand", touch_links=fingers, parts=pc.PointCloud(held + np.array([0, 0, 0.1]), 0.01))
    ours, theirs = checker.with_scene(scene), pc.Checker(panda(), new)
    assert np.array_equal(ours.check_states(states()), theirs.check_states(states()))
    assert scene.object("held").touch_links == fingers


def test_frames_may_be_empty() -> None:
    scene = kitchen("cloud", 0)
    checker = pc.Checker(panda(), scene)
    scene.update("sensor", np.zeros((0, 3)))
    without = kitchen("cloud", 0)
    without.remove("sensor")
    empty = checker.with_scene(scene)
    q = states()
    assert np.array_equal(empty.check_states(q), pc.Checker(panda(), without).check_states(q))
    assert np.array_equal(empty.check_motions(q[:-1], q[1:]), pc.Checker(panda(), without).check_motions(q[:-1], q[1:]))
    assert all(pair.certificate.verify() for pair in empty.explain(q[0], separations=True).separations)
    scene.update("sensor", points_of(2))
    again = empty.with_scene(scene)
    assert np.array_equal(again.check_states(q), pc.Checker(panda(), kitchen("cloud", 2)).check_states(q))


@pytest.mark.parametrize(
    ("name", "frame", "says"),
    [
        ("shelf", points_of(0), "object 'shelf': is a Box: sensors update clouds"),
        ("camera", points_of(0), "unknown object 'camera'"),
        ("sensor", points_of(0)[:, :2], r"object 'sensor': points of a cloud must have shape \(n, 3\)"),
        ("sensor", np.full((2, 3), np.nan), "object 'sensor': points of a cloud: row 0"),
        ("sensor", "points.npy", "object 'sensor': points of a cloud must be numbers"),
        ("two", points_of(0), "object 'two' has 2 shapes: only objects of one are updated"),
        ("map", points_of(0), "object 'map': is an Octree: give the new one"),
        ("map", shape_of("grid", 0), "object 'map': is an Octree, which a VoxelGrid does not update: give an Octree"),
        ("sensor", shape_of("map", 0), "object 'sensor': is a PointCloud, which an Octree does not update"),
        ("egg", points_of(0), "object 'egg': is an Ellipsoid: sensors update clouds"),
    ],
)
def test_bad_frames_are_named_and_change_nothing(name: str, frame: object, says: str) -> None:
    scene = kitchen("cloud", 0)
    scene.add("two", [pc.Part(pc.PointCloud(points_of(0), 0.1)), pc.Part(pc.Box((1, 1, 1)))])
    scene.add("map", shape_of("map", 0))
    scene.add("egg", pc.Ellipsoid((0.1, 0.1, 0.2)))
    before = scene.objects
    with pytest.raises(pc.PlannercheckError, match=says):
        scene.update(name, frame)
    assert scene.objects == before


def test_a_frame_costs_what_its_points_cost_not_what_the_scene_does() -> None:
    """Preparing again what did not change would take seconds here."""
    rng, scene = np.random.default_rng(0), pc.Scene()
    for k in range(60):
        pose = at(*rng.uniform(-1, 1, size=3) + np.array([0, 0, 1.5]))
        scene.add_hull(f"rock {k}", rng.normal(size=(1000, 3)) * 0.05, pose)
    scene.add("sensor", shape_of("cloud", 0))
    checker = pc.Checker(panda(), scene)
    prepared = [polytope for polytope in checker.polytopes if polytope is not None]
    started = time.process_time()
    for frame in range(5):
        scene.update("sensor", points_of(frame))
        checker = checker.with_scene(scene)
        checker.check_states(states()[:10])
    assert time.process_time() - started < 1.0
    kept = {id(polytope) for polytope in checker.polytopes}
    assert sum(id(polytope) not in kept for polytope in prepared) == 1


@pytest.mark.parametrize("kind", ["cloud", "grid", "heights", "map"])
def test_verdicts_do_not_depend_on_order_threads_or_pickling(kind: str) -> None:
    scene = kitchen(kind, 1)
    scene.attach("held", "panda_hand", parts=pc.PointCloud(points_of(0, 20) * 0.05 + [0, 0, 0.15], 0.01))
    checker, q = pc.Checker(panda(), scene), states()
    start, end = q, np.roll(q, 1, axis=0)
    valid, free = checker.check_states(q), checker.check_motions(start, end)
    pairs = checker.colliding_pairs(q)
    assert 0.02 < valid.mean() < 0.98
    order = np.random.default_rng(0).permutation(len(q))
    again = pickle.loads(pickle.dumps(checker))
    for each in (checker, again, again.with_scene(scene)):
        for threads in (1, 2):
            assert np.array_equal(each.check_states(q[order], threads=threads), valid[order])
            assert np.array_equal(each.check_motions(start[order], end[order], threads=threads), free[order])
        assert np.array_equal(each.colliding_pairs(q[order]), pairs[order])
        assert [each.is_valid(row) for row in q[order[:60]]] == valid[order[:60]].tolist()
        assert [each.check_motion(*ends) for ends in zip(start[:30], end[:30], strict=True)] == free[:30].tolist()
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(lambda part: (checker.check_states(q[part]), checker.is_valid(q[part[0]])), [order] * 6))
    assert all(np.array_equal(rows, valid[order]) and first == valid[order[0]] for rows, first in found)
