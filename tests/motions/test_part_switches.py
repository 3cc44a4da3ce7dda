"""Trees of sets of parts and all that spares parts a test change no verdict: against each part tested by itself."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import plannercheck as pc

RNG = np.random.default_rng(11)


@cache
def panda():
    return pc.Robot.load("panda")


def cloud(count, low=0.002, high=0.03):
    """Balls before the arm, some of which it reaches."""
    points = RNG.uniform((0.25, -0.6, 0.0), (0.8, 0.6, 1.0), size=(count, 3))
    return pc.PointCloud(points, RNG.uniform(low, high, size=count))


def octree():
    cells = np.random.default_rng(2).integers((4, -10, 0), (14, 10, 14), size=(90, 3))
    return pc.Octree.from_cells(np.unique(cells, axis=0), 0.06)


def field():
    heights = RNG.uniform(-0.2, 0.1, size=(9, 9))
    heights[2, 3] = np.nan
    return pc.HeightField(heights, 0.15, -0.3, (-0.6, -0.6))


SETS = {
    "cloud": lambda: cloud(60),
    "one ball": lambda: cloud(1, 0.2, 0.3),
    "coplanar": lambda: pc.PointCloud(cloud(40).points * [1, 1, 0] + [0, 0, 0.4], 0.02),
    "octree": octree,
    "field": field,
}


def scene_of(shape, pose=None):
    scene = pc.Scene("sensed")
    scene.add("camera", shape, pose)
    for link in ("panda_link0", "panda_link1"):
        scene.allow("camera", link)
    return scene


def tilted():
    pose = np.eye(4)
    pose[:3, :3] = [[np.cos(0.2), 0, np.sin(0.2)], [0, 1, 0], [-np.sin(0.2), 0, np.cos(0.2)]]
    pose[:3, 3] = 0.02, 0.01, 0.03
    return pose


def states(count, seed):
    return panda().random_configurations(count, seed=seed)


def motions(count, seed, length):
    rng = np.random.default_rng(seed)
    start = states(count, seed)
    way = rng.normal(size=start.shape)
    end = start + way * (length / np.linalg.norm(way, axis=1, keepdims=True))
    return start, np.clip(end, panda().lower, panda().upper)


@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("others", [{}, {"bounds": False, "boxes": False, "overlaps": False}])
@pytest.mark.parametrize("padding", [0.0, 0.02])
def test_verdicts_of_states(name, others, padding):
    scene = scene_of(SETS[name](), tilted())
    on, off = (
        pc.Checker(panda(), scene, padding=padding, tuning=pc.Tuning(part_trees=each, **others))
        for each in (True, False)
    )
    q = states(400, 3)
    valid = on.check_states(q)
    assert (off.check_states(q) == valid).all()
    assert [off.is_valid(row) for row in q[:60]] == valid[:60].tolist()
    beside = pc.Checker(panda(), None, padding=padding).check_states(q)
    assert (beside & ~valid).any()  # the set decides
    assert valid.any()


@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("length", [0.1, 0.7])
@pytest.mark.parametrize("bounds", [True, False])
def test_verdicts_of_motions(name, length, bounds):
    scene = scene_of(SETS[name](), tilted())
    on, off = (
        pc.Checker(panda(), scene, self_collision=False, tuning=pc.Tuning(part_trees=each, bounds=bounds))
        for each in (True, False)
    )
    start, end = motions(120, 5, length)
    free, plainly = on.check_motions(start, end), off.check_motions(start, end)
    for k in np.flatnonzero(free != plainly):  # either may refuse what comes within the tolerance
        along = on.motion_certifier.states(start[k], end[k], np.linspace(0, 1, 400))
        assert on.clearances(along).min() < 2e-4
    assert (free != plainly).mean() < 0.02
    assert 0 < plainly.mean() < 1
    for q0, q1 in zip(start[plainly], end[plainly], strict=True):
        assert on.check_states(on.motion_certifier.states(q0, q1, np.linspace(0, 1, 40))).all()


def test_verdicts_of_two_sets():
    """A carried set before another one: parts of both, each with each."""
    scene = scene_of(cloud(40))
    held = pc.PointCloud(RNG.normal(size=(12, 3)) * 0.05 + [0, 0, 0.12], 0.01)
    scene.attach("held", "panda_hand", parts=held)
    for finger in ("panda_hand", "panda_leftfinger", "panda_rightfinger", "panda_link7", "panda_link8"):
        scene.allow("held", finger)
    on, off = (pc.Checker(panda(), scene, tuning=pc.Tuning(part_trees=each)) for each in (True, False))
    q = states(400, 9)
    valid = on.check_states(q)
    assert (off.check_states(q) == valid).all()
    assert 0 < valid.mean() < 1
    start, end = motions(60, 2, 0.2)
    assert (on.check_motions(start, end) == off.check_motions(start, end)).all()


def test_verdicts_of_solids_before_a_cloud():
    robot = pc.Robot.load("ur10", geometry={"upper_arm_link": "solid"})
    scene = pc.Scene("sensed")
    points = np.random.default_rng(0).uniform((-1, -1, -0.2), (1, 1, 1.2), size=(25, 3))
    scene.add("camera", pc.PointCloud(points, 0.04))
    on, off = (
        pc.Checker(robot, scene, tuning=pc.Tuning(part_trees=each), self_collision=False) for each in (True, False)
    )
    q = robot.random_configurations(300, seed=1)
    valid = on.check_states(q)
    assert (off.check_states(q) == valid).all()
    assert 0 < valid.mean() < 1


def test_the_switch_does_something():
    """Off, no part is left out: links are asked for their support far more often."""
    counts = []
    for each in (True, False):
        checker = pc.Checker(
            panda(), scene_of(octree()), self_collision=False, tuning=pc.Tuning(bounds=False, part_trees=each)
        )
        assert not checker.check_states(states(300, 6)).all()
        queries = checker.statistics()["queries"]
        counts.append(queries["queries_a"] + queries["queries_b"])
    assert counts[1] > 2 * counts[0]


@pytest.mark.parametrize("height", [0.05, 0.2])
def test_the_filter_before_half_spaces_has_its_switch(height):
    """Balls above planes are part of `bounds`."""
    scene = pc.Scene("floor")
    scene.add("floor", pc.HalfSpace((0.1, 0.0, 1.0), height))
    for link in ("panda_link0", "panda_link1"):
        scene.allow("floor", link)
    on, off = (
        pc.Checker(panda(), scene, tuning=pc.Tuning(bounds=each), self_collision=False) for each in (True, False)
    )
    q = states(500, 4)
    valid = on.check_states(q)
    assert (off.check_states(q) == valid).all()
    assert 0 < valid.mean() < 1
