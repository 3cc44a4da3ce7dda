"""Least delays held against numbers, against every delay of a grid by dense sampling, and against permuted input."""

import numpy as np
import pytest
from crossing_boxes import HALF, LEFT, RIGHT, at, gantries, meet, way
from random_trees import random_tree

import plannercheck as pc
from plannercheck.timing.least_delay import _Judge

pytestmark = pytest.mark.filterwarnings("ignore:.*look like degrees")


@pytest.fixture(name="checker", scope="module")
def _checker(tmp_path_factory) -> pc.Checker:
    return gantries(tmp_path_factory.mktemp("delays"), ("left", "right"))


def check_intervals(found: pc.LeastDelay, at_most: float) -> None:
    """In ascending order without gaps; refuted ones reach up to `lower`."""
    ends = [0.0, *(each.end for each in found.intervals)]
    assert [each.start for each in found.intervals] == ends[:-1]
    if found.delay is None:
        assert ends[-1] == at_most
    below = [each for each in found.intervals if each.end <= found.lower]
    assert all(each.settled == "refuted" and each.pair for each in below)
    assert found.lower == (below[-1].end if below else 0.0)


def test_the_least_delay_of_two_that_cross(checker):
    """At 1.2 s left has passed the crossing, where right may arrive: the corners touch at 0.4 s of delay."""
    found = pc.least_delay(checker, {"left": LEFT}, {"right": RIGHT}, resolution=1e-4)
    assert found.lower <= 0.4 <= found.delay
    assert found.loss == found.delay - found.lower
    assert found.loss < 2e-3
    assert found.verdict.free
    assert found.waiting == ("right",)
    assert found.trajectory.duration == pytest.approx(2 + found.delay)
    assert checker.check_trajectory(found.trajectory)
    assert {each.pair for each in found.intervals if each.pair} == {("left/tip", "right/tip")}
    check_intervals(found, 10.0)
    assert "right after 0.4" in repr(found)
    assert "refuted" in found._repr_html_()
    assert found.verdict.proof[0].verify()


@pytest.mark.parametrize("resolution", [1e-3, 1e-5])
def test_a_delay_within_the_tolerance_is_free_by_itself(checker, resolution):
    """Finer pieces than the trajectory's, by which intervals are judged, would be proved at an earlier delay."""
    curved = pc.Trajectory([0, 1, 2], [[0, -1], [0.05, 0], [0, 1]], np.zeros((3, 2)))
    found = pc.least_delay(checker, {"left": LEFT}, {"right": curved}, 3.0, resolution, tolerance=1e-2)
    assert found.verdict.free
    starts = {"right": found.delay}
    assert not pc.first_conflict(checker, {"left": LEFT, "right": curved}, starts, tolerance=1e-2)


def test_no_delay_is_needed(checker):
    found = pc.least_delay(checker, {"left": LEFT}, {"right": way([0, -1], [0, -0.5])})
    assert (found.delay, found.lower, found.loss, found.intervals) == (0.0, 0.0, 0.0, ())
    assert "no delay" in repr(found)


def test_no_delay_helps(checker):
    standing = pc.least_delay(checker, {"left": LEFT}, {"right": way([-0.85, 0], [0, 2])}, at_most=3.0)
    assert standing.delay is standing.loss is standing.trajectory is standing.verdict is None
    assert standing.refuted
    assert len(standing.intervals) < 9  # at one instant, while right stands
    at_end = pc.least_delay(checker, {"left": [1, 0]}, {"right": way([1, -1], [1, 1])}, at_most=5.0)
    assert at_end.delay is None
    assert at_end.refuted
    assert at_end.lower == 5.0
    assert "every delay from 0 to 5 s is refuted" in repr(at_end)
    check_intervals(at_end, 5.0)


def test_a_start_that_is_not_proved(checker):
    """Boxes that touch for as long as right waits: neither free nor refuted with room."""
    found = pc.least_delay(checker, {"left": [0, 0]}, {"right": way([0.2, 0], [1, 0])}, at_most=0.01)
    assert found.delay is None
    assert not found.refuted
    assert "none for right up to 0.01 s is proved free; every delay below 0 s is refuted" in repr(found)


def random_way(rng) -> pc.Trajectory:
    points = rng.uniform(-1, 1, (int(rng.integers(2, 5)), 2))
    times = np.cumsum(rng.uniform(0.2, 1.0, len(points)))
    if rng.random() < 0.5:
        return way(*points, times=times)
    velocities = rng.normal(size=points.shape)
    velocities[-1] = 0.0
    return pc.Trajectory(times, points, velocities)


def check_refutations(found: pc.LeastDelay, collide) -> None:
    """At each delay of a refuted interval the instant collides, or the one that goes along with the delay."""
    for each in found.intervals:
        if each.settled == "refuted":
            middle = (each.start + each.end) / 2
            delays = np.linspace(each.start, each.end, 9)
            there = all(collide(d, np.array([each.instant]))[0] for d in delays)
            along = all(collide(d, np.array([each.instant + d - middle]))[0] for d in delays)
            assert there or along


@pytest.mark.parametrize("seed", range(3))
def test_every_free_delay_is_free(tmp_path, seed):
    """Intervals of delays that are called free, judged one by one, against many delays in each by numbers."""
    rng, found = np.random.default_rng(4000 + seed), 0
    checker = gantries(tmp_path, ("a", "b"))
    times = np.linspace(0, 10, 4001)
    for _ in range(8):
        runs = {"a": random_way(rng), "b": random_way(rng)}
        judge = _Judge(checker, runs, ("b",), {}, 5.0, 0.0, 1e-4)
        grid = np.linspace(0, 4, 41)
        hit = [meet({"a": at(runs["a"], times), "b": at(runs["b"], times, d)}).any() for d in grid]
        ends = 0.05 + grid[np.flatnonzero(np.diff(hit))]  # where delays begin or cease to collide
        near = [max(0.0, end + share - 0.15) for end in ends for share in (-0.1, 0.1)]
        for start in [*near, *rng.uniform(0, 4, 5)]:
            width = 0.3
            settled = judge.settled(start, start + width)
            if settled.settled == "free":
                found += 1
                for delay in np.linspace(start, start + width, 9):
                    assert not meet({"a": at(runs["a"], times), "b": at(runs["b"], times, delay)}).any()
    assert found > 4


@pytest.mark.parametrize("seed", range(10))
def test_random_gantries(tmp_path, seed):
    rng = np.random.default_rng(seed)
    names, post = ("a", "b", "c")[: int(rng.integers(2, 4))], tuple(rng.uniform(-1, 1, 2))
    checker = gantries(tmp_path, names, post)
    runs = {name: random_way(rng) for name in names}
    starts = {name: float(rng.uniform(0, 1)) for name in names if rng.random() < 0.3}
    count = int(rng.integers(1, len(names)))
    first, waiting = ({name: runs[name] for name in some} for some in (names[:count], names[count:]))
    found = pc.least_delay(checker, first, waiting, at_most=4.0, resolution=5e-3, starts=starts)
    check_intervals(found, 4.0)

    def collide(delay, times):
        begins = {name: starts.get(name, 0.0) + (delay if name in waiting else 0.0) for name in names}
        return meet({name: at(runs[name], times, begins[name]) for name in names}, post, 1e-12)

    times = np.linspace(0, 10, 20_001)
    check_refutations(found, collide)
    for delay in np.arange(0, found.lower, 0.05):
        assert collide(delay, times).any()
    if found.delay is not None:
        assert found.lower <= found.delay
        assert not collide(found.delay, times).any()
        for each in found.intervals:
            if each.settled == "free":
                assert not any(collide(d, times).any() for d in np.linspace(each.start, each.end, 5))
    again = pc.least_delay(checker, dict(reversed(first.items())), dict(reversed(waiting.items())), 4.0, 5e-3, starts)
    assert (again.delay, again.lower) == (found.delay, found.lower)
    assert again.intervals == found.intervals


@pytest.mark.parametrize("seed", range(6))
def test_gantries_beside_a_box_that_moves(tmp_path, seed):
    """The box is where numbers say at each time of the clock, whatever waits."""
    rng = np.random.default_rng(3000 + seed)
    names = ("a", "b")
    still = gantries(tmp_path, names)
    stops, scene = rng.uniform(-1, 1, (4, 2)), pc.Scene("conveyor")
    clock = np.cumsum(rng.uniform(0.5, 2, 4))
    poses = np.tile(np.eye(4), (4, 1, 1))
    poses[:, :2, 3] = stops
    scene.add("pallet", pc.Box((2 * HALF, 2 * HALF, 1.0)), pc.Moving(clock, poses, outside="stand"))
    checker = pc.Checker(still.robot, scene)
    runs = {name: random_way(rng) for name in names}
    found = pc.least_delay(checker, {"a": runs["a"]}, {"b": runs["b"]}, at_most=4.0, resolution=5e-3)
    check_intervals(found, 4.0)

    def collide(delay, times):
        pallet = np.stack([np.interp(times, clock, stops[:, k]) for k in (0, 1)], axis=1)
        return meet({"a": at(runs["a"], times), "b": at(runs["b"], times, delay), "pallet": pallet}, None, 1e-12)

    def times(delay):
        return np.linspace(0, max(runs["a"].curve.breaks[-1], runs["b"].curve.breaks[-1] + delay), 20_001)

    for each in found.intervals:
        if each.settled == "refuted":
            assert each.instant <= times(each.start)[-1]
            assert all(collide(d, np.array([each.instant]))[0] for d in np.linspace(each.start, each.end, 9))
    for delay in np.arange(0, found.lower, 0.05):
        assert collide(delay, times(delay)).any()
    if found.delay is not None:
        assert not collide(found.delay, times(found.delay)).any()
    first = pc.first_conflict(checker, runs)
    hits = times(0.0)[collide(0.0, times(0.0))]
    assert not first.free or not len(hits)
    if first.instant is not None:
        assert collide(0.0, np.array([first.instant]))[0]
        assert first.free_until <= first.instant <= (hits[0] if len(hits) else np.inf) + 1e-3
        if np.isfinite(first.until):
            assert collide(0.0, np.array([first.until]))[0]


@pytest.mark.parametrize("seed", range(6))
def test_random_arms(tmp_path, seed):
    """Arms of all kinds of joints, mimics among them; verdicts of single configurations are exact."""
    rng = np.random.default_rng(2000 + seed)
    arms = {}
    for name in ("left", "right"):
        (tmp_path / name).mkdir()
        tree = random_tree(rng, int(rng.integers(2, 5)), sizes=(0.3, 0.2, 0.15), reach=0.4, placed=True)
        place = np.eye(4)
        place[:3, 3] = rng.uniform(-0.8, 0.8, 3)
        arms[name] = tree.robot(tmp_path / name), place
    cell = pc.Robot.together(arms)
    checker = pc.Checker(cell, self_collision=True)
    runs = {}
    for name, (robot, _) in arms.items():
        points = robot.random_configurations(3, rng)
        runs[name] = pc.Trajectory(np.cumsum(rng.uniform(0.2, 1, 3)), points, np.zeros_like(points))
    found = pc.least_delay(checker, {"left": runs["left"]}, {"right": runs["right"]}, at_most=3.0, resolution=0.02)
    check_intervals(found, 3.0)

    def collide(delay, times):
        q = cell.join({"left": at(runs["left"], times), "right": at(runs["right"], times, delay)})
        return ~checker.check_states(q)

    times = np.linspace(0, 7, 4001)
    check_refutations(found, collide)
    for delay in np.arange(0, found.lower, 0.1):
        assert collide(delay, times).any()
    if found.delay is not None:
        assert not collide(found.delay, times).any()
        for each in found.intervals:
            if each.settled == "free":
                assert not any(collide(d, times).any() for d in np.linspace(each.start, each.end, 5))
    turned = pc.Checker(pc.Robot.together(dict(reversed(arms.items()))))
    again = pc.least_delay(turned, {"left": runs["left"]}, {"right": runs["right"]}, at_most=3.0, resolution=0.02)
    assert again.delay == found.delay


@pytest.mark.parametrize(
    ("first", "waiting", "options", "words"),
    [
        ({"left": LEFT}, {"left": LEFT, "right": RIGHT}, {}, "left can't both go first and wait"),
        ({"left": LEFT}, {}, {}, "no trajectory of right"),
        ({"left": LEFT, "right": RIGHT}, {}, {}, "nothing waits"),
        ({"left": LEFT}, {"right": [0, 0]}, {}, "what waits has a trajectory: right"),
        ({"left": LEFT}, {"rihgt": RIGHT}, {}, "did you mean 'right'"),
        ({"left": LEFT}, {"right": RIGHT}, {"at_most": 0.0}, "at_most must be more than 0 s"),
        ({"left": LEFT}, {"right": RIGHT}, {"at_most": np.nan}, "at_most must be a time"),
        ({"left": LEFT}, {"right": RIGHT}, {"at_most": -1}, "at_most must be a time"),
        ({"left": LEFT}, {"right": RIGHT}, {"resolution": 0}, "resolution must be more than 0 s"),
        ({"left": LEFT}, {"right": RIGHT}, {"starts": {"right": -1.0}}, "the start of 'right' must be a time"),
        ({"left": way([0], [1])}, {"right": RIGHT}, {}, "has 1 columns, but the robot has 2"),
        (LEFT, {"right": RIGHT}, {}, "first holds trajectories by robot"),
        ({"left": LEFT}, RIGHT, {}, "waiting holds trajectories by robot"),
    ],
)
def test_bad_input(checker, first, waiting, options, words):
    with pytest.raises(pc.PlannercheckError, match=words):
        pc.least_delay(checker, first, waiting, **options)
