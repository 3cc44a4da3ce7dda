"""Plans as trajectories: proved, within limits, from rest to rest; the curve is SciPy's through the points."""

import sys

import numpy as np
import pytest
from gantries import HALF, gantry
from scipy.interpolate import BPoly

import plannercheck as pc
from plannercheck.ompl.plans import Plan
from plannercheck.timing import timed_section
from plannercheck.timing.time_path import UnprovedPathError

ACCELERATION = np.array([3.75, 1.875, 2.5, 3.125, 3.75, 5, 5])
CORNER = np.array([[0.0, 0], [1, 0], [1, 1]])


@pytest.fixture(scope="module")
def panda():
    scene = pc.Scene.load("bookshelf")
    return pc.Checker(pc.Robot.load("panda"), scene)


def as_run(trajectory):
    """The quintic polynomials through the points, by SciPy."""
    points = trajectory.points
    rows = np.stack([points.positions, points.velocities, points.accelerations], axis=1)
    return BPoly.from_derivatives(points.times, rows)


def check_as_run(checker, trajectory, waypoints, velocity, acceleration):
    """Free and within limits at 10,000 instants, at rest at the waypoints' ends, and stamped by whole nanoseconds."""
    curve = as_run(trajectory)
    times = np.linspace(0, trajectory.duration, 10000)
    assert checker.check_states(curve(times)).all()
    assert (np.abs(curve(times, 1)) <= velocity * (1 + 1e-9)).all()
    assert (np.abs(curve(times, 2)) <= acceleration * (1 + 1e-9)).all()
    assert not [each for each in trajectory.limits(checker.robot, velocity, acceleration) if each.kind != "position"]
    points = trajectory.points
    assert not points.velocities[[0, -1]].any()
    assert not points.accelerations[[0, -1]].any()
    assert np.array_equal(points.positions[0], waypoints[0])
    assert np.array_equal(points.positions[-1], waypoints[-1])
    assert np.array_equal(np.rint(points.times * 1e9) / 1e9, points.times)
    assert trajectory.controller == "jtc"
    assert points.joint_names == checker.robot.joint_names


@pytest.mark.parametrize("seed", range(8))
def test_random_paths_in_the_plane(tmp_path, seed):
    rng = np.random.default_rng(seed)
    checker = gantry(tmp_path)
    path = np.cumsum(rng.normal(size=(2 + seed, 2)) * 10.0 ** rng.uniform(-3, 0.2), axis=0)
    velocity, acceleration = rng.uniform(0.1, 3, 2), rng.uniform(0.1, 9, 2)
    made = pc.time_path(checker, path, velocity, acceleration, blend=10.0 ** rng.uniform(-3, 0))
    check_as_run(checker, made, path, velocity, acceleration)
    assert made.timing.corners == seed
    assert (made.timing.saved > 0) == (seed > 0)


@pytest.mark.parametrize("seed", range(1, 4))
def test_plans_of_the_panda(panda, seed):
    plan = pc.ompl.plan(panda, panda.scene.start("panda"), panda.scene.goal("panda"), seed=seed, planner="RRTConnect")
    made = pc.time_path(panda, plan, None, ACCELERATION)
    check_as_run(panda, made, plan.path, np.array([2.175] * 4 + [2.61] * 3), ACCELERATION)
    assert made.timing.saved > 0.3


def test_blending_is_near_the_optimum_and_stopping_is_slower(tmp_path):
    """A leg of 1 m at 1 m/s and 2 m/s² takes 1.5 s from rest to rest: two take 3 s, and no corner makes 2.5 s less."""
    checker = gantry(tmp_path)
    stopping = pc.time_path(checker, CORNER, 1.0, 2.0, blend=0)
    check_as_run(checker, stopping, CORNER, 1.0, 2.0)
    assert stopping.duration == pytest.approx(3.0, rel=0.06)
    assert stopping.timing == pc.trajectories.Timing(saved=0.0, corners=1, stops=1, cut=0, tolerance=1e-4)
    blended = pc.time_path(checker, CORNER, 1.0, 2.0)
    assert 2.3 < blended.duration < 2.75
    assert blended.timing.saved == pytest.approx(stopping.duration - blended.duration, abs=1e-9)


def inside_corner(room):
    """A box inside the corner of CORNER whose own corner the gantry passes `room` m away along x and y."""
    return 0.2, HALF + room, 1 - HALF - room, 0.9


@pytest.mark.parametrize(("room", "tube", "halvings"), [(0.01, 0, 3), (0.01, 0.003, 4), (0.05, 0, 1), (0.2, 0, 0)])
def test_blends_are_halved_until_they_are_free(tmp_path, room, tube, halvings):
    """The middle of a blend at d from the corner is free if d < √2 room; a tube takes its length for each joint."""
    assert 0.1 * 0.5**halvings < 2**0.5 * room - 2 * tube < 0.1 * 0.5 ** (halvings - 1) or not halvings
    checker = gantry(tmp_path, inside_corner(room))
    made = pc.time_path(checker, CORNER, 1.0, 2.0, tube=tube)
    check_as_run(checker, made, CORNER, 1.0, 2.0)
    nearest = np.linalg.norm(as_run(made)(np.linspace(0, made.duration, 10000)) - CORNER[1], axis=1).min()
    assert nearest == pytest.approx(0.1 * 0.5**halvings, rel=0.01)
    assert (made.timing.cut, made.timing.stops) == (int(halvings > 0), 0)
    assert np.diff(made.points.times).max() > 0.006  # blends are cut before points are set closer


def test_it_stops_at_a_corner_without_room(tmp_path):
    checker = gantry(tmp_path, inside_corner(0.0005))
    made = pc.time_path(checker, CORNER, 1.0, 2.0)
    check_as_run(checker, made, CORNER, 1.0, 2.0)
    assert made.timing == pc.trajectories.Timing(saved=0.0, corners=1, stops=1, cut=1, tolerance=1e-4)


def test_a_path_nearer_than_the_tolerance_is_proved_by_a_finer_one(tmp_path, monkeypatch):
    proved = pc.Checker.check_trajectories

    def check(self, trajectories, tube, tolerance):
        return proved(self, trajectories, tube, tolerance) & (tolerance < 1e-5)

    monkeypatch.setattr(pc.Checker, "check_trajectories", check)
    made = pc.time_path(gantry(tmp_path), CORNER, 1.0, 2.0)
    assert made.timing.tolerance == pytest.approx(1e-6)
    assert made.timing.cut == 0


@pytest.mark.parametrize("blend", [1e-7, 1e-5, 1e-3])
def test_short_blends_do_not_slow_down_the_rest(tmp_path, blend):
    path, acceleration = CORNER * 3, np.array([20.0, 0.5])
    made = pc.time_path(gantry(tmp_path), path, np.inf, acceleration, blend=blend)
    check_as_run(gantry(tmp_path), made, path, np.inf, acceleration)
    assert made.timing.saved >= 0


def test_a_segment_that_is_not_free_is_named(tmp_path):
    path = np.array([[-1.0, 0], [-0.5, 0], [0, 0], [1, 0], [1, 1]])  # the second waypoint is on a line
    checker = gantry(tmp_path, inside_corner(0.01))
    refused = (
        "segment from configuration 0 to 3 is not proved free between tip and box0 with a tube of 0.02: needs a sm"
    )
    with pytest.raises(pc.PlannercheckError, match=refused):
        pc.time_path(checker, path, 1.0, 2.0, tube=0.02)
    refused = "segment from configuration 3 to 4 is not proved free between tip and box0: needs a plan"
    with pytest.raises(pc.PlannercheckError, match=refused):
        pc.time_path(gantry(tmp_path, (0.9, 0.4, 1.1, 0.5)), path, 1.0, 2.0)


@pytest.mark.parametrize("only_blends", [False, True])
def test_curves_that_are_never_proved_end_in_an_error(tmp_path, monkeypatch, only_blends):
    """Legs are proved as straight lines; then what the controller runs is refused, and at last its parts, or not."""

    def check(self, trajectories, **_):
        straight = [all(len(piece) == 2 for piece in each.curve.pieces) for each in trajectories]
        return np.array([each.points is None for each in trajectories] if only_blends else straight)

    monkeypatch.setattr(pc.Checker, "check_trajectories", check)
    with pytest.raises(UnprovedPathError, match=r"segment from configuration 0 to 1 is not proved free"):
        pc.time_path(gantry(tmp_path), CORNER, 1.0, 2.0)


def test_points_are_set_closer_where_the_curve_leaves_the_path(tmp_path, monkeypatch):
    """Points 0.4 s apart cut the corner by some mm; the room outside it is 0.1 mm."""
    outside = (-0.5, -0.5, 1.5, -HALF - 1e-4), (1 + HALF + 1e-4, -0.4, 1.5, 1.5)
    checker = gantry(tmp_path, *outside)
    monkeypatch.setattr(timed_section, "STEP", 0.4)
    monkeypatch.setattr(timed_section, "_SLOWER", 9.0)
    far = pc.time_path(gantry(tmp_path), CORNER, 1.0, 2.0)
    assert not checker.check_states(as_run(far)(np.linspace(0, far.duration, 10000))).all()
    near = pc.time_path(checker, CORNER, 1.0, 2.0)
    assert len(near.points.times) > 1.5 * len(far.points.times)
    assert near.timing.cut == 0
    check_as_run(checker, near, CORNER, 1.0, 2.0)


def test_continuous_joints_go_the_short_way():
    robot = pc.Robot.load("kinova")
    column = int(np.flatnonzero(robot.configuration_map.turning_columns())[-1])
    path = np.zeros((3, robot.nq))
    path[:, column] = 3.0, -3.0, -2.5
    made = pc.time_path(pc.Checker(robot, pc.Scene(), self_collision=False), path, 1.0, 1.0)
    assert made.points.positions[-1, column] == pytest.approx(2 * np.pi - 2.5, abs=1e-12)
    assert (np.diff(made.points.positions[:, column]) >= 0).all()


def test_limits_come_from_the_urdf_and_from_moveits_file(tmp_path):
    checker = gantry(tmp_path)
    file = tmp_path / "joint_limits.yaml"
    limit = "{has_velocity_limits: true, max_velocity: 0.25, has_acceleration_limits: true, max_acceleration: 0.5}"
    file.write_text(f"joint_limits: {{x: {limit}, y: {limit}}}")
    fast = pc.time_path(checker, CORNER, None, 1.0, blend=0)
    speeds = np.abs(as_run(fast)(np.linspace(0, fast.duration, 5000), 1)).max(axis=0)
    np.testing.assert_allclose(speeds, [1.0, 0.5], rtol=0.03)  # x speeds up half its way, y is at its limit
    slow = pc.time_path(checker, CORNER, file, str(file), blend=0)
    assert slow.duration == pytest.approx(2 * (1 / 0.25 + 0.5), rel=0.02)
    file.write_text("joint_limits: {x: {has_acceleration_limits: true, max_acceleration: 1.0}}")
    pc.time_path(checker, CORNER[:2], None, file)
    with pytest.raises(pc.PlannercheckError, match=r"joint 'y' moves and has no acceleration limit"):
        pc.time_path(checker, CORNER, None, file)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"path": CORNER[:1]}, "stays where it is"),
        ({"path": CORNER[:0]}, "path has no configurations"),
        ({"path": CORNER[[0, 0, 0]]}, "path of 3 configurations stays where it is"),
        ({"path": np.zeros((3, 5))}, "5"),
        ({"path": CORNER * np.nan}, "finite"),
        ({"path": Plan(False, np.empty((0, 2)), 0, 0, 0, "RRT", "no time")}, "no path: no time"),
        ({"velocity": 0.0}, "velocity must be a number more than 0, or 2, one a joint, not"),
        ({"velocity": [1.0, 2.0, 3.0]}, "velocity must be"),
        ({"acceleration": np.nan}, "acceleration must be"),
        ({"acceleration": np.inf}, "joint 'x' moves and has no acceleration limit"),
        ({"blend": -0.1}, "blend must be at least 0, not -0.1"),
        ({"blend": np.nan}, "blend must be at least 0, not nan"),
    ],
)
def test_what_can_not_be_timed_is_said(tmp_path, change, words):
    given = {"path": CORNER, "velocity": 1.0, "acceleration": 2.0, **change}
    with pytest.raises(pc.PlannercheckError, match=words):
        pc.time_path(gantry(tmp_path), **given)


def test_toppra_is_asked_for(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "toppra", None)
    with pytest.raises(pc.PlannercheckError, match=r"timed plans need toppra.*pip install 'plannercheck\[timing\]'"):
        pc.time_path(gantry(tmp_path), CORNER, 1.0, 2.0)
