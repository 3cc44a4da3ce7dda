"""Single states are bounded in lanes over bodies, sets in lanes over states: both find the same pairs."""

from itertools import combinations

import numpy as np
import pytest
from poses import at

import plannercheck as pc


def _boxes(count, size):
    """A shell of boxes around the robot, some of them within its reach."""
    rng = np.random.default_rng(count)
    scene = pc.Scene("shell")
    for k in range(count):
        direction = rng.normal(size=3)
        pose = at(*rng.uniform(0.3, 1.2) * direction / np.linalg.norm(direction))
        scene.add_box(f"box{k}", [size] * 3, pose)
    return scene


# Few obstacles are in lanes, many in a tree; 8, 9, 64 and 65 are where an eight and the list of them end.
@pytest.mark.parametrize("count", [0, 1, 7, 8, 9, 63, 64, 65, 300])
@pytest.mark.filterwarnings("ignore:.*touches obstacle:RuntimeWarning")
@pytest.mark.parametrize("robot", ["panda", "baxter"])
def test_single_states_find_the_same_pairs(robot, count):
    checker = pc.Checker(pc.Robot.load(robot), _boxes(count, 0.05), tuning=pc.Tuning(overlaps=False))
    q = checker.robot.random_configurations(60, seed=count)
    together, before = checker.colliding_pairs(q), checker.statistics()
    alone = np.concatenate([checker.colliding_pairs(row[None]) for row in q])
    after = checker.statistics()
    np.testing.assert_array_equal(alone, together)
    assert [checker.is_valid(row) for row in q] == (~together.any(axis=1)).tolist()
    # The same comparisons, but for the rounding of the balls' centres and for the slices of long bodies.
    assert after["bounds"] - before["bounds"] >= before["bounds"] * (1 - 1e-4)


@pytest.mark.parametrize("place", range(9))
def test_only_the_near_box_is_found(place):
    """One near box among nine, in every place of an eight and in the next one."""
    scene = pc.Scene("one is near")
    for k in range(9):
        pose = at(0, 0, 0.4 if k == place else 50 + k)
        scene.add_box(f"box{k}", [0.1] * 3, pose)
    panda = pc.Robot.load("panda")
    checker = pc.Checker(panda, scene, self_collision=False, tuning=pc.Tuning(reach=False))
    assert not checker.is_valid(panda.reference)
    counted = checker.statistics()
    assert counted["bounds"] >= 8 * len(panda.bodies) - 8
    assert (
        checker.bodies[checker.pairs[checker.first_colliding_pair(panda.reference[None])[0]][1]].name == f"box{place}"
    )


ROD, BODY = (0.05, 0.05, 0.6), (0.05, 0.05, 0.05)  # sizes, m


def _rods(*bodies):
    """A robot of two rods, 1 m apart, and small bodies at places (x, y, z); everything turns about axes of the base."""
    parts = ['<link name="base"/>']
    for name, x in (("rod0", 0), ("rod1", 1)):
        parts.append(_box(name, ROD, (x, 0, 0)) + _joint("base", name, (1, 0, 0)))
    for k, (place, axis) in enumerate(bodies):
        parts.append(_box(f"body{k}", BODY, place) + _joint("base", f"body{k}", axis))
    return '<robot name="rods">' + "".join(parts) + "</robot>"


def _box(name, size, place):
    shape = f'<box size="{" ".join(map(str, size))}"/>'
    origin = f'<origin xyz="{" ".join(map(str, place))}"/>'
    return f'<link name="{name}"><collision>{origin}<geometry>{shape}</geometry></collision></link>'


def _joint(parent, child, axis):
    return (
        f'<joint name="{child}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<axis xyz="{" ".join(map(str, axis))}"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
    )


def _meeting_balls(robot, q, places):
    """In how many pairs of bodies the balls around them meet, in all states together."""
    poses = robot.link_poses(q)
    centres = {name: (poses[:, robot.link_index(name)] @ [*place, 1])[:, :3] for name, place in places.items()}
    radii = {name: np.linalg.norm(ROD if name.startswith("rod") else BODY) / 2 for name in places}
    return sum(
        np.count_nonzero(np.linalg.norm(centres[a] - centres[b], axis=1) <= radii[a] + radii[b])
        for a, b in combinations(places, 2)
    )


@pytest.mark.parametrize("seed", range(4))
def test_slices_of_rods_leave_out_no_pair(tmp_path, seed):
    rng = np.random.default_rng(seed)
    path = tmp_path / "rods.urdf"
    bodies = [(rng.uniform(-0.4, 0.4, 3), rng.normal(size=3)) for _ in range(12)]
    path.write_text(_rods(*bodies))
    robot = pc.Robot.from_urdf(path)
    # Cells would take most pairs, and none would be left for slices.
    on, off = {"overlaps": False, "apart_cells": False}, {"overlaps": False, "bounds": False}
    single, together, plain = (pc.Checker(robot, tuning=pc.Tuning(**switches)) for switches in (on, on, off))
    q = robot.random_configurations(400, seed=seed)
    valid = plain.check_states(q).tolist()
    assert 10 < sum(valid) < 390
    assert [single.is_valid(row) for row in q] == valid
    assert together.check_states(q).tolist() == valid
    # A ball around a rod meets most bodies, its slices few.
    places = {"rod0": (0, 0, 0), "rod1": (1, 0, 0)} | {f"body{k}": place for k, (place, _) in enumerate(bodies)}
    whole = _meeting_balls(robot, q, places)
    for checker in (single, together):
        counted = checker.statistics()
        assert counted["pairs"] - counted["unreachable"] - counted["bounds"] < whole - 2 * len(q)


@pytest.mark.parametrize(
    ("gap", "padding", "free"), [(0.02, 0.0, True), (0.02, 0.019, True), (0.02, 0.021, False), (-0.001, 0.0, False)]
)
@pytest.mark.parametrize("height", np.linspace(-0.3, 0.3, 7).round(2))
@pytest.mark.parametrize("x", [0, 1])
def test_every_slice_of_a_rod_is_found(tmp_path, x, height, gap, padding, free):
    """One body beside a rod, at any height; others are further away, so that slices are worth it."""
    path = tmp_path / "rods.urdf"
    others = [((k, y, z), (1, 0, 0)) for k in (0, 1) for y in (-0.16, 0.16) for z in (-0.25, 0.25)]
    path.write_text(_rods(((x, 0.05 + gap, height), (1, 0, 0)), *others))
    robot = pc.Robot.from_urdf(path)
    home = np.zeros(robot.nq)
    away = np.where(np.arange(robot.nq) == 2, 2.0, home)  # the body is turned away from the rod
    checker = pc.Checker(robot, padding=padding, tuning=pc.Tuning(overlaps=False, apart_cells=False))
    assert checker.is_valid(home) == free
    assert checker.check_states(home[None])[0] == free
    assert checker.check_states(np.array([away] * 11 + [home] + [away] * 11))[11] == free
