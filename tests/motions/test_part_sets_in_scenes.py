"""Robots before clouds, grids and terrain: against the same parts as obstacles of their own, and against sampling."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from poses import at, pose_at

import plannercheck as pc
from plannercheck.bodies.part_sets import PartSet
from plannercheck.common.array_types import Floats


@cache
def panda() -> pc.Robot:
    return pc.Robot.load("panda")


def points_of_a_shelf(count: int, seed: int) -> Floats:
    """On two boards and a wall before the Panda."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.5, 0.5, size=(count, 3)) * [0.6, 1.2, 0.0] + [0.6, 0.0, 0.0]
    points[:, 2] = rng.choice([0.25, 0.75], size=count) + rng.normal(size=count) * 0.002
    wall = rng.random(count) < 0.3
    points[wall, 0], points[wall, 2] = 0.85, rng.uniform(0.2, 1.0, size=int(wall.sum()))
    return points


def cloud_and_balls(count: int, radius: float) -> tuple[pc.Scene, pc.Scene]:
    """A cloud, and the same balls one by one."""
    points, cloud, balls = points_of_a_shelf(count, 3), pc.Scene(), pc.Scene()
    cloud.add("camera", pc.PointCloud(points, radius), None)
    for k, point in enumerate(points):
        balls.add_sphere(f"ball {k}", radius, at(*point))
    return cloud, balls


def motions(count: int, seed: int, length: float) -> tuple[Floats, Floats]:
    rng, robot = np.random.default_rng(seed), panda()
    start = robot.random_configurations(count, seed=seed)
    way = rng.normal(size=start.shape)
    end = start + way * (length / np.linalg.norm(way, axis=1, keepdims=True))
    return start, np.clip(end, robot.lower, robot.upper)


def test_states_are_judged_as_before_balls_of_their_own() -> None:
    cloud, balls = cloud_and_balls(300, 0.02)
    q = panda().random_configurations(4000, seed=5)
    expected = pc.Checker(panda(), balls).check_states(q)
    assert 0.2 < expected.mean() < 0.95
    checker = pc.Checker(panda(), cloud)
    assert np.array_equal(checker.check_states(q), expected)
    assert np.array_equal(checker.check_states(q[::-1], threads=2), expected[::-1])
    assert [checker.is_valid(each) for each in q[:500]] == expected[:500].tolist()


def test_states_do_not_depend_on_switches() -> None:
    cloud, _ = cloud_and_balls(2000, 0.01)
    q = panda().random_configurations(1500, seed=6)
    plain = pc.Checker(panda(), cloud, tuning=pc.Tuning(bounds=False, boxes=False, overlaps=False, learning=False))
    assert np.array_equal(plain.check_states(q), pc.Checker(panda(), cloud).check_states(q))


def test_which_pairs_collide_is_the_same_in_any_order() -> None:
    cloud, balls = cloud_and_balls(200, 0.03)
    q = panda().random_configurations(400, seed=7)
    checker, other = pc.Checker(panda(), cloud), pc.Checker(panda(), balls)
    ours, theirs = checker.colliding_pairs(q), other.colliding_pairs(q)
    for names in {checker.pair_names(k) for k in range(len(checker.pairs))}:
        if names[1] == "camera":
            of_cloud = [k for k in range(len(checker.pairs)) if checker.pair_names(k) == names]
            of_balls = [
                k
                for k in range(len(other.pairs))
                if other.pair_names(k)[0] == names[0] and other.pair_names(k)[1].startswith("ball")
            ]
            assert np.array_equal(ours[:, of_cloud].any(axis=1), theirs[:, of_balls].any(axis=1))


@pytest.mark.parametrize("length", [0.2, 0.5, 1.5])
def test_motions_are_judged_as_before_balls_of_their_own(length: float) -> None:
    cloud, balls = cloud_and_balls(150, 0.02)
    start, end = motions(600, 11, length)
    ours, theirs = (
        pc.Checker(panda(), cloud).check_motions(start, end),
        pc.Checker(panda(), balls).check_motions(start, end),
    )
    assert 0.1 < ours.mean() < 0.95
    assert np.array_equal(ours, theirs)


@pytest.mark.parametrize("kind", ["cloud", "grid", "heights"])
def test_no_proved_motion_has_a_colliding_state(kind: str) -> None:
    scene = pc.Scene()
    scene.add(kind, _shape(kind), at(0.3, -0.2, 0.1))
    checker = pc.Checker(panda(), scene)
    start, end = motions(400, 13, 0.8)
    free = checker.check_motions(start, end)
    assert 0.1 < free.mean() < 0.95
    t = np.linspace(0, 1, 80)[:, None, None]
    states = (start[free] * (1 - t) + end[free] * t).reshape(-1, start.shape[1])
    assert checker.check_states(states).all()


@pytest.mark.parametrize("kind", ["cloud", "grid", "heights"])
def test_no_proved_motion_has_a_state_within_the_padding(kind: str) -> None:
    scene = pc.Scene()
    scene.add(kind, _shape(kind), at(0.5, -0.3, 0.1))
    checker = pc.Checker(panda(), scene, padding={kind: 0.05})
    start, end = motions(400, 14, 0.6)
    free = checker.check_motions(start, end)
    assert 0.05 < free.mean() < 0.95
    t = np.linspace(0, 1, 80)[:, None, None]
    states = (start[free] * (1 - t) + end[free] * t).reshape(-1, start.shape[1])
    assert checker.check_states(states).all()


def _shape(kind: str) -> PartSet:
    rng = np.random.default_rng(17)
    if kind == "cloud":
        return pc.PointCloud(points_of_a_shelf(5000, 17), rng.uniform(0.001, 0.02, size=5000))
    if kind == "grid":
        return pc.VoxelGrid(rng.random((12, 12, 12)) < 0.08, 0.07)
    return pc.HeightField(rng.uniform(0.0, 0.3, size=(24, 24)), 0.04, -0.1)


def test_a_collision_names_its_point() -> None:
    points = points_of_a_shelf(3000, 19)
    scene = pc.Scene()
    scene.add("camera", pc.PointCloud(points, 0.02), None)
    checker = pc.Checker(panda(), scene)
    q = panda().random_configurations(50, seed=8)
    named = 0
    for each in q:
        verdict = checker.explain(each)
        assert verdict.valid == checker.is_valid(each)
        for pair in verdict.collisions:
            assert pair.certificate.verify()
            if pair.second == "camera":
                named += 1
                index = int(pair.second_body.split("[")[1].rstrip("]"))
                body = next(b for b in pair.certificate.bodies if len(b.vertices) == 1)
                assert np.array_equal(body.vertices[0], points[index])
    assert named > 5


def test_padding_and_clearance_count_from_the_points() -> None:
    points = points_of_a_shelf(400, 23)
    near, far = pc.Scene(), pc.Scene()
    near.add("camera", pc.PointCloud(points, 0.03), None)
    far.add("camera", pc.PointCloud(points, 0.01), None)
    q = panda().random_configurations(1500, seed=9)
    padded = pc.Checker(panda(), far, self_collision=False, padding={"camera": 0.02})
    assert np.array_equal(padded.check_states(q), pc.Checker(panda(), near, self_collision=False).check_states(q))


def test_a_carried_cloud_is_tested_as_its_balls_are() -> None:
    points = np.random.default_rng(29).normal(size=(60, 3)) * [0.05, 0.05, 0.1] + [0, 0, 0.2]
    q = panda().random_configurations(800, seed=10)
    cloud, balls = pc.Scene(), pc.Scene()
    for scene in (cloud, balls):
        scene.add_box("table", (1.0, 1.0, 0.1), at(0.7, 0.0, 0.3))
    touching = ("panda_leftfinger", "panda_rightfinger")
    cloud.attach("grasped", "panda_hand", touch_links=touching, parts=pc.PointCloud(points, 0.01))
    each = [pc.Part(pc.Sphere(0.01), at(*point)) for point in points]
    balls.attach("grasped", "panda_hand", touch_links=touching, parts=each)
    ours, theirs = (pc.Checker(panda(), scene) for scene in (cloud, balls))
    assert np.array_equal(ours.check_states(q), theirs.check_states(q))
    start, end = motions(200, 31, 0.4)
    assert np.array_equal(ours.check_motions(start, end), theirs.check_motions(start, end))


def test_motions_of_a_carried_cloud_before_a_cloud_are_those_of_its_balls() -> None:
    """Each part of the smaller set is held against the larger one: one by one this took seconds a motion."""
    points = np.random.default_rng(33).normal(size=(25, 3)) * [0.05, 0.05, 0.08] + [0, 0, 0.2]
    cloud, balls = cloud_and_balls(120, 0.02)
    touching = ("panda_leftfinger", "panda_rightfinger")
    cloud.attach("grasped", "panda_hand", touch_links=touching, parts=pc.PointCloud(points, 0.01))
    each = [pc.Part(pc.Sphere(0.01), at(*point)) for point in points]
    balls.attach("grasped", "panda_hand", touch_links=touching, parts=each)
    start, end = motions(150, 35, 0.8)
    ours, theirs = (pc.Checker(panda(), scene).check_motions(start, end) for scene in (cloud, balls))
    assert 0.1 < ours.mean() < 0.95
    assert np.array_equal(ours, theirs)


SLIDING = """<robot name="two boxes">
<link name="base"/>
<link name="arm">
<collision><geometry><box size="0.02 0.02 0.02"/></geometry></collision>
<collision><origin xyz="{place!r} 0 0"/><geometry><box size="0.02 0.02 0.02"/></geometry></collision>
</link>
<joint name="slide" type="prismatic">
<parent link="base"/><child link="arm"/><axis xyz="1 0 0"/><limit lower="-1e12" upper="1e12" effort="1" velocity="1"/>
</joint>
</robot>"""


@pytest.mark.parametrize("part", [0.2, 0.4])
def test_verdicts_far_away_do_not_depend_on_boxes(part: float, tmp_path: Path) -> None:
    """So far away that both boxes' places are rounded, one by half of 2^-15 m, to where the second meets the ball."""
    step, far = 2.0**-15, 2.0**37
    (tmp_path / "two.urdf").write_text(SLIDING.format(place=0.02 + part * step))
    scene, near = pc.Scene(), 1638 * step
    ball = pc.PointCloud([[0.031 + 0.5 * step - near, 0.0, 0.0]], 0.001)
    scene.add("ball", ball, at(far + near, 0.0, 0.0))
    box, there = pc.Box((0.02, 0.02, 0.02)), at(far + (0.02 + part * step), 0.0, 0.0)
    shared = pc.intersects(box, ball, there, at(far + near, 0.0, 0.0))
    assert shared
    for boxes in (True, False):
        checker = pc.Checker(pc.Robot.load(tmp_path / "two.urdf"), scene, tuning=pc.Tuning(boxes=boxes))
        assert checker.is_valid([far]) != shared


def test_ways_to_save_work_change_no_verdict_before_a_cloud() -> None:
    """Singly the middle state comes first, in batches ends may; with all of it off, states are judged by no box."""
    scene, _ = cloud_and_balls(400, 0.03)
    start, end = motions(60, 41, 0.8)
    saving = pc.Checker(panda(), scene)
    free = saving.check_motions(start, end)
    assert 0.1 < free.mean() < 0.9
    assert np.array_equal(free, [saving.check_motion(a, b) for a, b in zip(start, end, strict=True)])
    switches = ("bounds", "overlaps", "middle_states", "boxes", "learning")
    for off in (*({name: False} for name in switches), dict.fromkeys(switches, False)):
        plain = pc.Checker(panda(), scene, tuning=pc.Tuning(**off))
        assert np.array_equal(free, plain.check_motions(start, end)), off
        assert np.array_equal(saving.check_states(end), plain.check_states(end)), off


def sensed(kind: str, rng: np.random.Generator) -> tuple[PartSet, Floats]:
    """A set around the Panda that leaves some of its states free, and its pose."""
    pose = pose_at(rng, 0.1)
    if kind == "cloud":
        return pc.PointCloud(points_of_a_shelf(3000, 7), rng.uniform(0.001, 0.02, size=3000)), pose
    if kind == "cells":
        occupied = rng.random((20, 20, 12)) < 0.004
        return pc.VoxelGrid(occupied, 0.1, [-1.0, -1.0, 0.0]), pose
    field = rng.uniform(-0.5, -0.1, size=(30, 30))
    field[15, 4:9] = 0.9
    return pc.HeightField(field, (0.08, 0.08), -0.6, (-1.2, -1.2)), np.eye(4)


@pytest.mark.parametrize("kind", ["cloud", "cells", "heights"])
@pytest.mark.parametrize("padding", [0.0, 0.02])
def test_clearances_that_are_looked_up_change_no_verdict(kind: str, padding: float) -> None:
    """Nor do looks at all poses of a motion at once."""
    scene = pc.Scene()
    scene.add("camera", *sensed(kind, np.random.default_rng(11)))
    saving, plain = (
        pc.Checker(panda(), scene, padding=padding, tuning=pc.Tuning(bounds=bounds)) for bounds in (True, False)
    )
    q = panda().random_configurations(3000, seed=12)
    free = saving.check_states(q)
    assert 0.05 < free.mean() < 0.98
    assert np.array_equal(free, plain.check_states(q))
    start, end = motions(150, 13, 0.5)
    free = saving.check_motions(start, end)
    assert 0.02 < free.mean() < 0.98
    assert np.array_equal(free, plain.check_motions(start, end))
