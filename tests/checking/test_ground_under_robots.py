"""Robots over fields of heights: ceilings of cells and looks at the heights under a body change no verdict."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.common.array_types import Floats

URDF = """<robot name="walker">
  <link name="base"><collision><geometry><box size="0.3 0.2 0.1"/></geometry></collision></link>
  <link name="rod"><collision><origin xyz="0 0 -0.15"/><geometry><box size="0.02 0.03 0.3"/></geometry></collision>
    <collision><origin xyz="0 0 -0.32"/><geometry><sphere radius="0.03"/></geometry></collision></link>
  <joint name="hip" type="revolute"><parent link="base"/><child link="rod"/><origin xyz="0.2 0.15 0"/>
    <axis xyz="0 1 0"/><limit lower="-1.5" upper="1.5" effort="1" velocity="1"/></joint>
</robot>"""


@cache
def walker(folder: str) -> pc.Robot:
    path = Path(folder) / "walker.urdf"
    path.write_text(URDF)
    return pc.Robot.from_urdf(path, floating=True)


def rough(rng: np.random.Generator, shape: tuple[int, int], height: float = 0.15) -> Floats:
    return np.asarray(rng.uniform(0.0, height, size=shape))


def with_holes(heights: Floats, rng: np.random.Generator) -> Floats:
    heights[rng.random(heights.shape) < 0.08] = np.nan
    heights[:2] = np.nan  # the box around what is left is smaller than the lattice
    return heights


def smooth(shape: tuple[int, int], step: float) -> Floats:
    x, y = np.meshgrid(*(np.arange(n) * step for n in shape), indexing="ij")
    return np.asarray(0.1 + 0.05 * np.sin(3 * x) * np.cos(2 * y + 0.5))


# The field, and how far it reaches along x and y, m.
FIELDS = {
    "rough": lambda rng: pc.HeightField(rough(rng, (13, 12)), 0.1, -0.2),
    "holes": lambda rng: pc.HeightField(with_holes(rough(rng, (14, 14)), rng), (0.09, 0.11), -0.1, (0.2, -0.3)),
    "smooth": lambda rng: pc.HeightField(smooth((25, 25), 0.05), 0.05, 0.0),
    "wide steps": lambda rng: pc.HeightField(rough(rng, (3, 4), 0.5), 0.6, -0.1),
    "one square": lambda rng: pc.HeightField(rough(rng, (2, 2)), 1.0, -0.1),
    "long": lambda rng: pc.HeightField(rough(rng, (2, 90)), (1.5, 0.02), -0.1),
    "flat as its base": lambda rng: pc.HeightField(np.zeros((9, 9)), 0.15, 0.0),
    "small steps": lambda rng: pc.HeightField(rough(rng, (20, 20), 0.02), 0.004, -0.1),
    "far away": lambda rng: pc.HeightField(rough(rng, (10, 10)), 0.12, -0.2, (3000.0, -2000.0)),
}


def turned(rng: np.random.Generator) -> Floats:
    vector = rng.normal(size=4) * [0.2, 0.2, 1, 1]
    x, y, z, w = vector / np.linalg.norm(vector)
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = rng.uniform(-5, 5, size=3)
    return pose


def around(shape: pc.HeightField, pose: Floats, count: int, rng: np.random.Generator) -> Floats:
    """States of the walker on, in, under and beside the field."""
    ends = (np.array(shape.heights.shape) - 1) * shape.resolution
    places = rng.uniform(-0.4, ends + 0.4, size=(count, 2)) + shape.origin
    heights = rng.choice([0.25, 0.5], count) + rng.uniform(-0.3, 0.3, size=count)
    heights[: count // 20] -= 1
    local = np.column_stack([places, heights])
    turns = rng.normal(size=(count, 4)) * [0.3, 0.3, 1, 1]
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    return np.column_stack([local @ pose[:3, :3].T + pose[:3, 3], turns, rng.uniform(-1.5, 1.5, size=count)])


def scene_of(shape: pc.HeightField, pose: Floats) -> pc.Scene:
    scene = pc.Scene("ground")
    scene.add("ground", shape, pose)
    return scene


@pytest.mark.parametrize("kind", FIELDS)
@pytest.mark.parametrize("padding", [0.0, 0.03])
@pytest.mark.parametrize("is_turned", [False, True])
def test_verdicts_are_those_of_each_prism_by_itself(kind: str, padding: float, is_turned: bool, tmp_path) -> None:
    rng = np.random.default_rng(7)
    shape, pose = FIELDS[kind](rng), turned(rng) if is_turned else np.eye(4)
    robot, scene = walker(str(tmp_path)), scene_of(shape, pose)
    q = around(shape, pose, 200, rng)
    plain = pc.Checker(robot, scene, padding=padding, tuning=pc.Tuning(bounds=False, boxes=False, part_trees=False))
    expected = plain.check_states(q)
    assert 0 < expected.mean() < 1
    pairs = plain.colliding_pairs(q)
    for switches in ({}, {"bounds": False}, {"part_trees": False}, {"boxes": False, "overlaps": False}):
        checker = pc.Checker(robot, scene, padding=padding, tuning=pc.Tuning(**switches))
        assert (checker.check_states(q) == expected).all(), switches
        assert [checker.is_valid(row) for row in q] == expected.tolist(), switches
        assert ((checker.first_colliding_pair(q) < 0) == expected).all(), switches
        assert (checker.colliding_pairs(q) == pairs).all(), switches


def test_bodies_just_above_and_just_below_the_surface(tmp_path) -> None:
    """The box stands on a flat field, by less than what looks have room for: the exact test decides."""
    shape = pc.HeightField(np.full((40, 40), 0.125), 0.0625, 0.0)
    checker = pc.Checker(walker(str(tmp_path)), scene_of(shape, np.eye(4)))
    q = np.tile([1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.5], (7, 1))
    for k, above in enumerate([-1e-3, -1e-6, -1e-12, 0.0, 1e-12, 1e-6, 1e-3]):
        q[k, 2] = 0.125 + 0.05 + above
    pair = next(k for k in range(len(checker.pairs)) if "base" in checker.pair_names(k))
    assert checker.colliding_pairs(q)[:, pair].tolist() == [True] * 4 + [False] * 3


def test_most_bodies_over_the_ground_are_looked_up(tmp_path) -> None:
    """In blocks of states and one by one: no tree is asked for a robot that stands clear of the ground."""
    rng = np.random.default_rng(3)
    shape = pc.HeightField(smooth((200, 200), 0.05), 0.05, 0.0)
    q = around(shape, np.eye(4), 300, rng)
    q[:, :2], q[:, 2] = np.clip(q[:, :2], 0.5, 9.0), 0.75
    checker = pc.Checker(walker(str(tmp_path)), scene_of(shape, np.eye(4)), tuning=pc.Tuning(part_trees=False))
    assert checker.check_states(q).all()
    assert all(checker.is_valid(row) for row in q)
    found = checker.statistics()
    assert found["bounds"] > 0.99 * found["pairs"]
    plain = pc.Checker(
        walker(str(tmp_path)), scene_of(shape, np.eye(4)), tuning=pc.Tuning(bounds=False, part_trees=False)
    )
    plain.check_states(q[:5])
    assert plain.statistics()["bounds"] == 0


def test_lengths_of_quaternions_are_looked_at_in_the_core_and_beyond_it(tmp_path) -> None:
    """Nearly of length 1, all are judged, one by one and in sets; else refused alike."""
    rng = np.random.default_rng(5)
    shape = FIELDS["rough"](rng)
    checker = pc.Checker(walker(str(tmp_path)), scene_of(shape, np.eye(4)))
    q = around(shape, np.eye(4), 200, rng)
    expected = checker.check_states(np.asfortranarray(q))  # not read in place
    for factor in (1.0, 1 + 0.9e-7, 1 + 1.9e-7, 1 - 1.9e-7):
        scaled = q.copy()
        scaled[:, 3:7] *= factor
        assert (checker.check_states(scaled) != expected).mean() < 0.02
        assert [checker.is_valid(row) for row in scaled] == checker.check_states(scaled).tolist()
        assert [checker.is_valid(row.tolist()) for row in scaled] == checker.check_states(scaled).tolist()
    for factor in (1 + 3e-7, 1 - 3e-7, 0.0, 2.0, np.nan):
        scaled = q.copy()
        scaled[7, 3:7] *= factor
        for call in (lambda: checker.check_states(scaled), lambda: checker.is_valid(scaled[7])):  # noqa: B023
            with pytest.raises(pc.PlannercheckError, match=r"length 1|finite"):
                call()
