"""Curves that controllers run, held against rational arithmetic, SciPy, and the numbers of the controllers' rules."""

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import BSpline, CubicSpline, PPoly

import plannercheck as pc
from plannercheck.trajectories.curve import Curve, bernstein
from plannercheck.validation.formats.paths import read_robot_path

TIMES = np.array([0.5, 1.25, 3.0])
RNG = np.random.default_rng(4)
Q, V, A = RNG.normal(size=(3, 3, 2))
V[-1] = 0


def exact_quintic(q, v, a, h, t):
    """The quintic polynomial of six conditions at t, by its coefficients in rationals (Hermite interpolation)."""
    p, r, v, w, a, b, h, t = map(Fraction, (*q, *v, *a, h, t))
    c = [p, v, a / 2]
    # The rest solves c3 h³ + c4 h⁴ + c5 h⁵ = d0 and its first two derivatives.
    d0, d1, d2 = r - p - v * h - a * h * h / 2, w - v - a * h, b - a
    c += [
        (20 * d0 - 8 * d1 * h + d2 * h * h) / (2 * h**3),
        (-30 * d0 + 14 * d1 * h - 2 * d2 * h * h) / (2 * h**4),
        (12 * d0 - 6 * d1 * h + d2 * h * h) / (2 * h**5),
    ]
    return sum(x * t**i for i, x in enumerate(c))


def test_both_ends_with_accelerations_are_quintic():
    found = pc.Trajectory(TIMES, Q, V, A)
    for k in (0, 1):
        h = TIMES[k + 1] - TIMES[k]
        for t in np.linspace(0, h, 7).tolist():
            for j in range(2):
                exact = exact_quintic(Q[k : k + 2, j], V[k : k + 2, j], A[k : k + 2, j], h, t)
                assert found.position(TIMES[k] + t)[j] == pytest.approx(float(exact), abs=1e-13)


def test_derivatives_at_the_points_are_those_given():
    found = pc.Trajectory(TIMES, Q, V, A)
    np.testing.assert_allclose(found.position(TIMES), Q, atol=1e-15)
    np.testing.assert_allclose(found.velocity(TIMES), V, atol=1e-14)
    np.testing.assert_allclose(found.acceleration(TIMES), A, atol=1e-12)


@pytest.mark.parametrize(
    ("velocities", "accelerations", "degrees"),
    [
        ([1, 1, 1], [1, 1, 1], (5, 5)),
        ([1, 1, 1], [0, 1, 0], (3, 3)),
        ([1, 1, 1], [0, 0, 0], (3, 3)),
        ([1, 0, 1], [1, 0, 1], (1, 1)),
        ([0, 1, 1], [0, 0, 1], (1, 3)),
        ([0, 0, 0], [0, 0, 0], (1, 1)),
    ],
)
def test_a_segment_has_what_both_ends_have(velocities, accelerations, degrees):
    v = np.where(np.array(velocities)[:, None], V, np.nan)
    a = np.where(np.array(accelerations)[:, None], A, np.nan)
    assert tuple(len(piece) - 1 for piece in pc.Trajectory(TIMES, Q, v, a).curve.pieces) == degrees


def test_accelerations_without_velocities_are_refused():
    with pytest.raises(pc.PlannercheckError, match=r"points 0 and 1 have accelerations without velocities.*0 on every"):
        pc.Trajectory(TIMES, Q, None, A)
    with pytest.raises(pc.PlannercheckError, match="UR driver refuses"):
        pc.Trajectory(TIMES, Q, None, A, "ur")


def test_controllers_differ():
    """UR runs positions alone at rest at each point, MotoROS2 ignores accelerations, linear all derivatives."""
    ur, clamped = pc.Trajectory(TIMES, Q, controller="ur"), pc.Trajectory(TIMES, Q, 0 * V)
    assert all(np.array_equal(a, b) for a, b in zip(ur.curve.pieces, clamped.curve.pieces, strict=True))
    moto, cubic = pc.Trajectory(TIMES, Q, V, A, "motoros2"), pc.Trajectory(TIMES, Q, V)
    assert all(np.array_equal(a, b) for a, b in zip(moto.curve.pieces, cubic.curve.pieces, strict=True))
    assert [len(piece) for piece in pc.Trajectory(TIMES, Q, V, A, "linear").curve.pieces] == [2, 2]
    with pytest.raises(pc.PlannercheckError, match="point 0 has no velocities"):
        pc.Trajectory(TIMES, Q, controller="motoros2")
    with pytest.raises(pc.PlannercheckError, match="'jtc'"):
        pc.Trajectory(TIMES, Q, controller="jtx")


def test_upsampling_is_the_clamped_spline_of_scipy():
    times, q = np.cumsum(RNG.uniform(0.1, 1, 9)), RNG.normal(size=(9, 3))
    spline = CubicSpline(times, q, bc_type="clamped")
    found, at = pc.Trajectory(times, q, controller="jtc-upsampled"), np.linspace(times[0], times[-1], 100)
    np.testing.assert_allclose(found.position(at), spline(at), atol=1e-12)


def test_the_way_to_the_first_point_begins_where_the_robot_stands():
    found = pc.Trajectory(TIMES, Q, V, A, start=(np.zeros(2), [0.3, 0.0]))
    np.testing.assert_allclose(found.velocity(0), [0.3, 0], atol=1e-15)
    assert [len(piece) - 1 for piece in found.curve.pieces] == [5, 5, 5]  # its acceleration is 0
    assert [len(piece) for piece in pc.Trajectory(TIMES, Q, start=np.zeros(2)).curve.pieces] == [2, 2, 2]


def test_whole_turns_are_taken_off_on_the_way_to_the_first_point_alone():
    q = np.array([[0.1, 0.1], [7.0, 7.0]])
    found = pc.Trajectory([1, 2], q, start=[6.2, 6.2], continuous=[1])
    np.testing.assert_allclose(found.position(0), [6.2, 6.2 - 2 * np.pi], atol=1e-15)
    np.testing.assert_allclose(found.position(2), [7, 7])


@pytest.mark.parametrize("sign", [1, -1])
def test_half_a_turn_goes_the_way_of_the_numbers(sign):
    found = pc.Trajectory([1, 2], [[sign * np.pi], [sign * np.pi]], start=[0.0], continuous=[0])
    assert found.position(0) == pytest.approx(0, abs=1e-15)


def test_a_first_point_at_once_is_where_the_robot_stands():
    at_once = (np.array([0.0, 1.0]), np.array([[0.0], [1.0]]))
    assert pc.Trajectory(*at_once, start=[0.0]).duration == 1
    with pytest.raises(pc.PlannercheckError, match=r"differs from start by 0\.1 in column 0: the robot would jump"):
        pc.Trajectory(*at_once, start=[0.1])


def test_motoros2_begins_at_the_first_point_and_ur_at_rest():
    found = pc.Trajectory(TIMES + 1.0, Q, V, None, "motoros2", Q[0])
    assert len(found.curve.pieces) == 2  # MotoROS2 waits for nothing
    with pytest.raises(pc.PlannercheckError, match=r"differs from start by 0\.1 .* motoros2 refuses it"):
        pc.Trajectory(TIMES + 1.0, Q, V, None, "motoros2", Q[0] - [0.1, 0.0])
    moving = pc.Trajectory(TIMES + 1.0, Q, V, None, "ur", (Q[0] - 0.1, [0.3, 0.0]))
    np.testing.assert_array_equal(moving.velocity(0), 0.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"times": [0.5, 0.5, 1]}, "times must grow from 0 s on, but point 1 is at 0.5 s"),
        ({"times": [-1, 0.5, 1]}, "point 0 is at -1.0 s"),
        ({"times": [0, np.nan, 1]}, "point 1 is at nan s"),
        ({"times": [0, 1]}, r"not \(2,\) and \(3, 2\)"),
        ({"positions": np.where(np.arange(6).reshape(3, 2) == 3, np.nan, Q)}, "point 1, column 1 has nan"),
        (
            {"velocities": np.where(np.arange(6).reshape(3, 2) == 3, np.nan, V)},
            "NaN for a whole point: point 1, column 1",
        ),
        ({"velocities": V[:2]}, r"shape of positions, \(3, 2\), not \(2, 2\)"),
        ({"velocities": V + np.array([[0], [0], [0.1]])}, "jtc refuses a trajectory that does not end at rest"),
        ({"start": [1.0]}, r"start must be a configuration \(2,\)"),
        ({"times": [1.0], "positions": Q[:1], "velocities": None}, "one point needs start="),
    ],
)
def test_malformed_points_are_named(change, words):
    with pytest.raises(pc.PlannercheckError, match=words):
        pc.Trajectory(**{"times": TIMES, "positions": Q, "velocities": V, **change})


def test_times_outside_are_refused():
    for time in (0.4, 3.1, np.nan):
        with pytest.raises(pc.PlannercheckError, match=r"times must be within 0\.5 and 3\.0 s"):
            pc.Trajectory(TIMES, Q).position(time)


@pytest.mark.parametrize("degree", [0, 1, 3, 5, 7])
def test_polynomials_are_those_of_scipy(degree):
    breaks, powers = np.array([1.0, 1.5, 4.0]), RNG.normal(size=(2, 3, degree + 1))
    ends = [sum(powers[0, j, i] * 0.5**i for i in range(degree + 1)) for j in range(3)]
    powers[1, :, 0] = ends
    found, peer = pc.Trajectory.polynomials(breaks, powers), PPoly(powers.transpose(2, 0, 1)[::-1], breaks)
    at = np.linspace(1, 4, 50)
    for derivative, values in enumerate((found.position(at), found.velocity(at), found.acceleration(at))):
        size = np.abs(peer(at, derivative)).max() + 1
        np.testing.assert_allclose(values, peer(at, derivative), atol=1e-12 * size)


def test_sizes_that_no_robot_has_are_refused():
    with pytest.raises(pc.PlannercheckError, match=r"piece 0 has control points beyond 1e\+15"):
        pc.Trajectory([0, 1], [[0.0], [1e300]])
    with pytest.raises(pc.PlannercheckError, match="piece 1 takes 1e-10 s, less than 1 ns"):
        pc.Trajectory.bezier([0, 1, 1 + 1e-10], [[[0.0], [1.0]], [[1.0], [1.0]]])


def test_limits_with_leading_terms_below_rounding():
    """A parabola as a cubic whose last term is 1e-310: its roots would overflow."""
    robot = pc.Robot.load("panda").with_group(["panda_joint1"])
    found = pc.Trajectory.bezier([0, 1], [[[0.0], [10.0], [10.0], [1e-310]]])
    (excess,) = found.limits(robot)
    assert (excess.kind, excess.value, excess.time) == ("position", 7.5, 0.5)


def test_pieces_must_meet():
    with pytest.raises(pc.PlannercheckError, match="pieces 0 and 1 are 1 apart where they meet"):
        pc.Trajectory.polynomials([0, 1, 2], [[[0.0]], [[1.0]]])


@pytest.mark.parametrize("degree", [1, 2, 3, 5])
@pytest.mark.parametrize("clamped", [True, False])
def test_b_splines_are_those_of_scipy(degree, clamped):
    knots = np.sort(RNG.uniform(0, 5, 8 + 2 * degree))
    if degree > 1:
        knots[degree + 3] = knots[degree + 2]  # a double knot
    if clamped:
        knots[: degree + 1], knots[-degree - 1 :] = 0, 5
    points = RNG.normal(size=(len(knots) - degree - 1, 2))
    found, peer = pc.Trajectory.bspline(knots, points), BSpline(knots, points, degree)
    at = np.linspace(knots[degree], knots[-degree - 1], 200)
    np.testing.assert_allclose(found.position(at), peer(at), atol=1e-12)


def test_bezier_is_its_control_points():
    found = pc.Trajectory.bezier([0, 2], [[[0.0], [1.0], [0.0]]])
    assert found.position(1.0) == 0.5
    assert found.velocity(0.0) == 1.0
    np.testing.assert_allclose(bernstein(np.array([[0.0], [2.0], [-2.0]])), [[0], [1], [0]])


def test_limits_between_the_points_are_found():
    """A cubic that overshoots: from rest and to rest through a point that it passes fast."""
    robot = pc.Robot.load("panda")
    q = np.tile([0.0, 0, 0, -1.5, 0, 1.5, 0], (3, 1))
    q[:, 0] = 2.7, 2.8, 2.7
    v = np.zeros((3, 7))
    v[1, 0] = 1.0
    found = pc.Trajectory([0, 1, 2], q, v)
    excess, *more = found.limits(robot, velocity=5.0)
    assert not more
    assert (excess.joint, excess.kind) == ("panda_joint1", "position")
    sampled = found.position(np.linspace(0, 2, 20001))[:, 0]
    assert excess.value == pytest.approx(sampled.max(), abs=1e-7)
    assert excess.time == pytest.approx(np.linspace(0, 2, 20001)[sampled.argmax()], abs=1e-3)
    kinds = [each.kind for each in found.limits(robot, velocity=0.5, acceleration=1.0)]
    assert kinds == ["position", "velocity", "acceleration"]
    with pytest.raises(pc.PlannercheckError, match="velocity must be a limit of at least 0"):
        found.limits(robot, velocity=-1.0)
    with pytest.raises(pc.PlannercheckError, match=r"acceleration must be .*, or 7, one a joint, not \[1, 2\]"):
        found.limits(robot, acceleration=[1, 2])


def test_without_pairs_the_clearance_is_infinite():
    robot = pc.Robot.load("panda")
    q = np.tile([0.0, 0, 0, -1.5, 0, 1.5, 0], (2, 1)) + np.array([[0.0], [0.1]])
    verdict = pc.Checker(robot, self_collision=False).explain_trajectory(pc.Trajectory([0, 1], q))
    assert verdict.free
    assert verdict.clearance == np.inf


def test_what_is_no_robot_and_no_list_is_said(tmp_path: Path):
    with pytest.raises(pc.PlannercheckError, match=r"needs a pc\.Robot, not 'panda': pc\.Robot\.load reads one"):
        pc.Trajectory.load(tmp_path / "t.json", "panda")  # type: ignore[arg-type]
    trajectory = pc.Trajectory([0, 1], np.zeros((2, 7)))
    with pytest.raises(pc.PlannercheckError, match="check_trajectory takes one"):
        pc.Checker(pc.Robot.load("panda")).check_trajectories(trajectory)  # type: ignore[arg-type]


def message(names, points):
    return {"header": {"frame_id": "base"}, "joint_names": names, "points": points}


def point(q, at, **more):
    return {"positions": q, "time_from_start": {"sec": int(at), "nanosec": round((at - int(at)) * 1e9)}, **more}


@pytest.mark.parametrize("wrapped", ["alone", "joint_trajectory", "trajectory", "display"])
def test_messages_are_read_in_the_robots_order(tmp_path: Path, wrapped: str):
    robot = pc.Robot.load("panda")
    names = list(reversed(robot.joint_names))
    inner = message(names, [point([float(k)] * 7, 0.25 * k, velocities=[0.1 * k] * 7) for k in (2, 1, 0)][::-1])
    inner["points"][2] |= {"velocities": [0.0] * 7, "positions": [0.0, 1, 2, 3, 4, 5, 6]}
    document = {
        "alone": inner,
        "joint_trajectory": {"joint_trajectory": inner},
        "trajectory": {"trajectory": inner, "goal_tolerance": []},
        "display": {"trajectory": [{"joint_trajectory": inner}]},
    }[wrapped]
    (tmp_path / "t.json").write_text(json.dumps(document))
    (tmp_path / "t.yaml").write_text(json.dumps(document) + "\n---\n")
    for name in ("t.json", "t.yaml"):
        found = pc.Trajectory.load(tmp_path / name, robot)
        assert found.position(0.5).tolist() == [6, 5, 4, 3, 2, 1, 0]
        assert [len(piece) - 1 for piece in found.curve.pieces] == [3, 3]


def test_a_file_without_a_message_is_named(tmp_path: Path):
    (tmp_path / "t.yaml").write_text("# nothing\n")
    with pytest.raises(
        pc.PlannercheckError, match=r"t\.yaml.*holds no JointTrajectory: one has joint_names and points"
    ):
        pc.Trajectory.load(tmp_path / "t.yaml", pc.Robot.load("panda"))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"joint_names": ["a"] * 7}, "unknown joint of panda 'a'.*leave other joints out"),
        ({"joint_names": ["panda_joint1"] * 7}, "names panda_joint1 more than once: give each joint of panda once"),
        ({"points": []}, r"t\.json.*has no points"),
        ({"points": [point([0.0] * 7, 1), point([0.1] * 7, 1)]}, r"t\.json.*times must grow"),
        ({"points": [{"time_from_start": 1}]}, "point 0.*has no positions"),
        ({"points": [point([0.0] * 7, 0, velocities=False)]}, "point 0: 'velocities' must be a list, not False"),
        ({"points": [point([0.0] * 6, 1)]}, "point 0.*positions"),
        ({"points": [point([0.0] * 7, 1, velocity=[0])]}, "velocity"),
        ({"points": [point([0.0] * 7, 1, effort=[1.0])], "stamp": 3}, "stamp"),
    ],
)
def test_malformed_messages_are_named(tmp_path: Path, change: dict, words: str):
    robot = pc.Robot.load("panda")
    file = message(list(robot.joint_names), [point([0.0] * 7, 1), point([0.1] * 7, 2)]) | change
    (tmp_path / "t.json").write_text(json.dumps(file))
    with pytest.raises(pc.PlannercheckError, match=f"(?s){words}"):
        pc.Trajectory.load(tmp_path / "t.json", robot)


_GRIPPER = """<robot name="g"><link name="b"/><link name="l"/><link name="r"/><link name="a"/>
<joint name="lift" type="prismatic"><parent link="b"/><child link="a"/>
<limit lower="0" upper="1" effort="1" velocity="1"/></joint>
<joint name="left" type="prismatic"><parent link="a"/><child link="l"/>
<limit lower="0" upper="1" effort="1" velocity="1"/></joint>
<joint name="right" type="prismatic"><parent link="a"/><child link="r"/>
<limit lower="-9" upper="9" effort="1" velocity="1"/>
<mimic joint="left" multiplier="-3" offset="0.5"/></joint></robot>"""


@pytest.mark.parametrize(
    ("names", "rows", "words"),
    [
        (["left", "right"], [[0.1, 0.2], [0.2, -0.1]], None),
        (["left", "right"], [[0.1, 0.2 + 1e-12], [0.1, 0.2]], None),
        (["left", "right"], [[0.1, 0.2], [0.2, 0.2]], "point 1: joint 'right' follows 'left'.*positions -0.1, not 0.2"),
        (["left", "right"], [[0.1, 0.3], [0.1, 0.3]], "point 0: joint 'right' follows 'left'.*positions 0.2, not 0.3"),
        (
            ["lift", "right"],
            [[0.1, 0.2], [0.1, 0.3]],
            "moves right, outside the planning group: choose a group with left$",
        ),
    ],
)
@pytest.mark.parametrize("read", [pc.Trajectory.load, read_robot_path])
def test_joints_that_follow_others_do_so_in_messages(tmp_path: Path, read, names, rows, words):
    (tmp_path / "g.urdf").write_text(_GRIPPER)
    robot = pc.Robot.from_urdf(tmp_path / "g.urdf").with_group(names[:1])
    file = message(names, [point(row, k) for k, row in enumerate(rows)])
    (tmp_path / "t.json").write_text(json.dumps(file))
    if words:
        with pytest.raises(pc.PlannercheckError, match=rf"t\.json.*{words}"):
            read(tmp_path / "t.json", robot)
        return
    found = read(tmp_path / "t.json", robot)
    path = isinstance(found, pc.Trajectory)
    assert (found.points.positions if path else found.states).tolist() == [row[:1] for row in rows]
    assert (found.points.held if path else found.others) == {}


def test_velocities_of_joints_that_follow_others_do_so(tmp_path: Path):
    (tmp_path / "g.urdf").write_text(_GRIPPER)
    robot = pc.Robot.from_urdf(tmp_path / "g.urdf").with_group(["left"])
    for speed in (-0.3, 0.3):
        ends = [point([0.1, 0.2], 0, velocities=[0.1, speed]), point([0.2, -0.1], 1, velocities=[0, 0])]
        (tmp_path / "t.json").write_text(json.dumps(message(["left", "right"], ends)))
        if speed < 0:
            assert pc.Trajectory.load(tmp_path / "t.json", robot).points.velocities.tolist() == [[0.1], [0]]
            continue
        with pytest.raises(pc.PlannercheckError, match=r"point 0: joint 'right'.*velocities -0.3, not 0.3: correct"):
            pc.Trajectory.load(tmp_path / "t.json", robot)


def test_several_trajectories_in_a_row_are_refused(tmp_path: Path):
    robot = pc.Robot.load("panda")
    one = {"joint_trajectory": message(list(robot.joint_names), [point([0.0] * 7, 1), point([0.1] * 7, 2)])}
    (tmp_path / "t.json").write_text(json.dumps({"trajectory": [one, one]}))
    with pytest.raises(pc.PlannercheckError, match="holds 2 JointTrajectory messages"):
        pc.Trajectory.load(tmp_path / "t.json", robot)


def test_a_start_that_is_not_looked_at_is_said(tmp_path: Path):
    robot = pc.Robot.load("panda")
    inner = message(list(robot.joint_names), [point([0.0] * 7, 1), point([0.1] * 7, 2)])
    file = {"trajectory_start": {"joint_state": {"name": ["a"]}}, "trajectory": [{"joint_trajectory": inner}]}
    (tmp_path / "t.json").write_text(json.dumps(file))
    with pytest.warns(UserWarning, match=r"t\.json.*trajectory_start is not looked at: give start="):
        pc.Trajectory.load(tmp_path / "t.json", robot)


@pytest.mark.parametrize(
    ("pieces", "words"),
    [
        ([[[0.0]]], "2 to 21 control points, not 1"),
        ([np.zeros((22, 1))], "2 to 21 control points, not 22"),
        ([[[0.0], [np.nan], [1.0]]], "beyond"),
        ([[[0.0], [1.0]], [[1.0 + 1e-15], [2.0]]], "pieces 0 and 1 do not meet"),
    ],
)
def test_a_curve_that_no_robot_runs_is_refused(pieces, words: str):
    curve = Curve(np.arange(len(pieces) + 1.0), tuple(np.array(piece) for piece in pieces), np.zeros(1))
    with pytest.raises(pc.PlannercheckError, match=words):
        pc.Trajectory.of_curve(curve)
