"""First conflicts of robots on one clock, held against numbers and against dense sampling with exact verdicts."""

import math

import numpy as np
import pytest
from crossing_boxes import LEFT, RIGHT, at, gantries, meet, way
from random_trees import random_tree

import plannercheck as pc

pytestmark = pytest.mark.filterwarnings("ignore:.*look like degrees")


@pytest.fixture(name="checker", scope="module")
def _checker(tmp_path_factory) -> pc.Checker:
    return gantries(tmp_path_factory.mktemp("conflicts"), ("left", "right"))


def test_two_that_cross(checker):
    found = pc.first_conflict(checker, {"left": LEFT, "right": RIGHT})
    assert found
    assert not found.free
    assert found.instant == pytest.approx(0.8, abs=1e-12)
    assert found.until == pytest.approx(1.2, abs=1e-12)
    assert found.free_until <= found.instant < found.free_until + 1e-3
    assert found.robots == ("left", "right")
    assert found.pair.names == ("left/tip", "right/tip")
    assert found.certificate.verify()
    assert found.proof is None
    assert "at 0.8 s: left/tip – right/tip, until 1.2 s" in repr(found)
    assert "left/tip" in found._repr_html_()


def test_one_that_waits_long_enough(checker):
    found = pc.first_conflict(checker, {"left": LEFT, "right": RIGHT}, starts={"right": 0.5})
    assert not found
    assert found.free
    assert found.instant is found.until is found.certificate is None
    assert found.robots == ()
    assert 0.05 < found.clearance <= 0.5
    assert "right from 0.5 s" in repr(found)
    assert len(found.proof) == len(found.trajectory.curve.pieces)
    assert all(proof.verify() for proof in found.proof)


def test_one_that_stands_in_the_way(checker):
    found = pc.first_conflict(checker, {"left": LEFT, "right": [0.95, 0.0]})
    assert found.instant == pytest.approx(1.75, abs=1e-12)
    assert math.isinf(found.until)
    assert "to the end" in repr(found)


def test_tubes_by_robot(checker):
    later = {"right": 0.45}
    assert not pc.first_conflict(checker, {"left": LEFT, "right": RIGHT}, later)
    for tube in (0.1, {"left": 0.1, "right": 0.1}, {"left": [0.2, 0.0]}):
        found = pc.first_conflict(checker, {"left": LEFT, "right": RIGHT}, later, tube)
        assert found
        assert found.instant is None
        assert "none found, but not proved after" in repr(found)
    assert not pc.first_conflict(checker, {"left": LEFT, "right": RIGHT}, later, {"left": [0.0, 0.01]})
    with pytest.raises(pc.PlannercheckError, match="unknown robot with a tube 'up'"):
        pc.first_conflict(checker, {"left": LEFT, "right": RIGHT}, later, {"up": 0.1})
    with pytest.raises(pc.PlannercheckError, match="the tube of 'left' must be a number, or 2"):
        pc.first_conflict(checker, {"left": LEFT, "right": RIGHT}, later, {"left": [0.1, 0.1, 0.1]})
    with pytest.raises(pc.PlannercheckError, match="the tube of 'left' must be numbers, not 'wide'"):
        pc.first_conflict(checker, {"left": LEFT, "right": RIGHT}, later, {"left": "wide"})


def test_what_a_robot_carries_belongs_to_it(checker):
    scene, place = pc.Scene("carried"), np.eye(4)
    place[1, 3] = 0.5
    scene.attach("tool", "left/tip", place, parts=pc.Box((0.1, 0.1, 0.1)))
    carrying = checker.with_scene(scene)
    found = pc.first_conflict(carrying, {"left": LEFT, "right": way([1, 0.5], [0.5, 0.5])})
    assert found.pair.names == ("right/tip", "tool")
    assert found.robots == ("right", "left")
    scene.add_box("post", (0.1, 0.1, 0.1), place)
    alone = pc.first_conflict(carrying.with_scene(scene), {"left": LEFT, "right": [5.0, 5.0]})
    assert alone.pair.names == ("tool", "post")
    assert alone.robots == ("left",)


def test_no_cell(checker):
    alone = pc.Checker(checker.robot.parts["left"].robot)
    with pytest.raises(pc.PlannercheckError, match="is a single robot: make a cell"):
        pc.first_conflict(alone, {"left": LEFT})
    with pytest.raises(pc.PlannercheckError, match=r"needs a pc\.Checker of a cell"):
        pc.first_conflict(alone.robot, {"left": LEFT})
    untested = pc.Checker(checker.robot, self_collision=False)
    with pytest.raises(pc.PlannercheckError, match="without self-collision no pair between two robots"):
        pc.first_conflict(untested, {"left": LEFT, "right": RIGHT})
    with pytest.raises(pc.PlannercheckError, match="without self-collision no pair between two robots"):
        pc.least_delay(untested, {"left": LEFT}, {"right": RIGHT})


def random_way(rng) -> pc.Trajectory:
    points = rng.uniform(-1, 1, (int(rng.integers(2, 5)), 2))
    times = np.cumsum(rng.uniform(0.2, 1.5, len(points)))
    if rng.random() < 0.5:
        return way(*points, times=times)
    velocities = rng.normal(size=points.shape)
    velocities[-1] = 0.0
    return pc.Trajectory(times, points, velocities)


@pytest.mark.parametrize("seed", range(25))
def test_random_gantries(tmp_path, seed):
    rng = np.random.default_rng(seed)
    names, post = ("a", "b", "c")[: int(rng.integers(2, 4))], tuple(rng.uniform(-1, 1, 2))
    checker = gantries(tmp_path, names, post)
    runs = {name: random_way(rng) for name in names}
    starts = {name: float(rng.uniform(0, 2)) for name in names if rng.random() < 0.5}
    found = pc.first_conflict(checker, runs, starts)
    end = max(starts.get(name, 0.0) + run.curve.breaks[-1] for name, run in runs.items())
    times = np.linspace(0, end, 20_001)
    hits = times[meet({name: at(run, times, starts.get(name, 0.0)) for name, run in runs.items()}, post)]
    if found.free:
        assert not len(hits)
        return
    if found.instant is None:
        assert found.clearance == 0.0
        return
    here = {name: at(run, [found.instant], starts.get(name, 0.0)) for name, run in runs.items()}
    assert meet(here, post, 1e-12)[0]
    assert found.certificate.verify()
    if len(hits):
        assert found.free_until <= hits[0] + 1e-12
        assert found.instant <= hits[0] + 1e-3
    assert found.free_until <= found.instant
    backwards = dict(reversed(runs.items()))
    again = pc.first_conflict(checker, backwards, dict(reversed(starts.items())))
    assert (again.instant, again.until, again.free_until) == (found.instant, found.until, found.free_until)


@pytest.mark.parametrize("seed", range(8))
def test_random_arms(tmp_path, seed):
    """Arms of all kinds of joints; sampled instants with exact verdicts of configurations that nobody merged."""
    rng = np.random.default_rng(1000 + seed)
    arms = {}
    for name in ("left", "right"):
        (tmp_path / name).mkdir()
        tree = random_tree(rng, int(rng.integers(2, 5)), sizes=(0.2, 0.15, 0.1), reach=0.4, placed=True)
        place = np.eye(4)
        place[:3, 3] = rng.uniform(-0.6, 0.6, 3)
        arms[name] = tree.robot(tmp_path / name), place
    cell = pc.Robot.together(arms)
    checker = pc.Checker(cell)
    runs = {}
    for name, (robot, _) in arms.items():
        points = robot.random_configurations(3, rng)
        runs[name] = pc.Trajectory(np.cumsum(rng.uniform(0.2, 2, 3)), points, np.zeros_like(points))
    starts = {"right": float(rng.uniform(0, 3))}
    found = pc.first_conflict(checker, runs, starts)
    times = np.linspace(0, found.trajectory.duration, 4001)
    q = cell.join({name: at(run, times, starts.get(name, 0.0)) for name, run in runs.items()})
    hits = times[~checker.check_states(q)]
    if found.free:
        assert not len(hits)
    elif found.instant is not None:
        assert found.certificate.verify()
        assert not len(hits) or found.free_until <= hits[0] + 1e-9
        assert not len(hits) or found.instant <= hits[0] + 1e-3
