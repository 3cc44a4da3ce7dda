"""Gates: chunks that pass are free by sampling, the fast path is the plain one, prefixes and stops, reasons, records.

The oracles: states of a checker with padding, `Trajectory` and its proofs, and constant decelerations by hand.
"""

import json
import sys

import numpy as np
import pytest
from long_runs.memory import resident

import plannercheck as pc
from plannercheck.motions.trajectory_checks import TrajectoryChecks
from plannercheck.validation.gates.quick import QuickJudge
from plannercheck.validation.gates.replay import differences, parse_record

TUBE, MARGIN, BRAKE, SPEED = 0.01, 0.005, 5.0, 2.0


@pytest.fixture(scope="module")
def checker():
    return pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))


@pytest.fixture(scope="module")
def gate(checker):
    return pc.Gate(checker, velocity=SPEED, tube=TUBE, margin=MARGIN, brake=BRAKE)


def plain(gate):
    """The same gate without its fast path."""
    made = gate.of(gate.checker)
    made._quick = None
    return made


@pytest.fixture(scope="module")
def chunks(checker):
    """Chunks from free states, fast enough that some break limits and some collide: (positions, q, dq) each."""
    rng = np.random.default_rng(7)
    q = checker.robot.random_configurations(400, 7)
    q = q[checker.check_states(q)][:150]
    times = 0.02 * np.arange(1, 17)[:, None]
    return [
        (row + dq * times + bend * times**2, row, dq)
        for row, dq, bend in zip(q, rng.normal(size=q.shape) * 0.6, rng.normal(size=q.shape) * 0.6, strict=True)
    ]


def stop_by_hand(q, v, brake=BRAKE):
    """The stop as a function of time, joint by joint."""

    def at(t):
        t = np.minimum(t, np.abs(v) / brake)
        return q + v * t - np.sign(v) * brake * t * t / 2

    return at, float((np.abs(v) / brake).max())


def test_chunks_that_pass_keep_tube_and_margin_by_sampling_stop_included(checker, gate, chunks):
    padded = pc.Checker(checker.robot, checker.scene, padding=MARGIN)
    rng = np.random.default_rng(0)
    passed = 0
    for positions, q, dq in chunks:
        if not gate.judge(positions, 50, start=(q, dq)):
            continue
        passed += 1
        rows = np.vstack([q, positions])
        part = rng.random((300, 1))
        k = rng.integers(0, 16, 300)
        on_chunk = rows[k] + part * (rows[k + 1] - rows[k])
        at, lasts = stop_by_hand(rows[-1], (rows[-1] - rows[-2]) * 50)
        on_stop = np.array([at(t) for t in rng.uniform(0, lasts * 1.1, 100)])
        states = np.vstack([on_chunk, on_stop])
        assert padded.check_states(states + rng.choice([-TUBE, TUBE], states.shape)).all()
    assert 40 < passed < len(chunks)


def test_fast_path_and_plain_path_agree(gate, chunks):
    slow = plain(gate)
    for k, (positions, q, dq) in enumerate(chunks):
        fast, full = gate.judge(positions, 50, start=(q, dq)), slow.judge(positions, 50, start=(q, dq))
        assert fast.ok == full.ok
        assert fast.safe_until == full.safe_until
        if k < 20:  # reasons take a while
            assert fast.as_json() == full.as_json()


def test_plain_path_is_the_trajectory_with_its_stop(checker, gate, chunks):
    checks = TrajectoryChecks(checker, TUBE, 1e-4, MARGIN)
    for positions, q, dq in chunks[:60]:
        verdict = gate.judge(positions, 50, start=(q, dq))
        run = pc.Trajectory(np.arange(1, 17) / 50, positions, start=(q, dq))
        at, lasts = stop_by_hand(positions[-1], (positions[-1] - positions[-2]) * 50)
        robot = checker.robot
        expected = (
            not run.limits(robot, SPEED)
            and (np.abs(dq) <= SPEED).all()
            and ((at(lasts) >= robot.lower) & (at(lasts) <= robot.upper)).all()
            and checks.free_pieces(run).all()
        )
        if not expected:
            assert not verdict.ok
        elif not verdict.ok:
            assert all(reason.on_stop for reason in verdict.reasons)


def test_reasons_are_there_where_a_chunk_does_not_pass(gate, chunks):
    kinds = set()
    for positions, q, dq in chunks[:25]:
        verdict = gate.judge(positions, 50, start=(q, dq))
        assert verdict.ok == (not verdict.reasons)
        kinds |= {reason.kind for reason in verdict.reasons}
    assert {"limit", "collision", "unproved"} <= kinds


def test_prefix_is_the_longest_whose_stop_is_proved(checker, gate, chunks):
    checks = TrajectoryChecks(checker, TUBE, 1e-4, MARGIN)
    looked_at = 0
    for positions, q, dq in chunks:
        verdict = gate.judge(positions, 50, start=(q, dq))
        if verdict.ok or not verdict.safe_until:
            continue
        looked_at += 1
        k = round(verdict.safe_until * 50)
        rows = np.vstack([q, positions])
        assert checks.free_pieces(pc.Trajectory(np.arange(1, k + 1) / 50, positions[:k], start=q)).all()
        begun = rows[k], (rows[k] - rows[k - 1]) * 50
        at, lasts = stop_by_hand(*begun)
        stop = verdict.stop
        assert stop is not None
        assert stop.curve.breaks[0] == pytest.approx(verdict.safe_until, abs=1e-12)
        assert stop.duration == pytest.approx(lasts, abs=2e-9)
        for t in np.linspace(0, stop.duration, 9):
            np.testing.assert_allclose(
                stop.position(min(stop.curve.breaks[0] + t, stop.curve.breaks[-1])), at(t), atol=1e-8
            )
        assert checks.free_pieces(stop).all()
        if k < 16:  # one more waypoint breaks a limit, collides, or has no stop that is proved
            longer = gate.judge(positions[: k + 1], 50, start=(q, dq))
            assert not longer.ok
    assert looked_at > 15


def test_stop_of_a_verdict_that_passes_is_behind_the_chunk(gate, chunks):
    positions, q, dq = next(each for each in chunks if gate.judge(each[0], 50, start=each[1:]).ok)
    verdict = gate.judge(positions, 50, start=(q, dq))
    assert verdict.safe_until == 0.32
    assert verdict.reasons == ()
    np.testing.assert_array_equal(verdict.stop.position(verdict.stop.curve.breaks[0]), positions[-1])
    more = TrajectoryChecks(gate.checker, TUBE, 1e-4, MARGIN + verdict.slack)
    assert verdict.slack > 0
    assert more.free_pieces(verdict.trajectory).all()
    assert more.free_pieces(verdict.stop).all()


@pytest.fixture(scope="module")
def home(checker):
    """A state with room around it."""
    q = checker.robot.random_configurations(300, 3)
    q = q[checker.check_states(q)]
    inside = (np.minimum(q - checker.robot.lower, checker.robot.upper - q)).min(axis=1)
    return q[int(np.argmax(np.minimum(checker.clearances(q), inside)))]


def kinds_of(verdict):
    return {reason.kind for reason in verdict.reasons}


def test_a_jump_is_a_reason(gate, home):
    far = gate.judge([home + 0.1], 50, start=home)
    assert kinds_of(far) == {"jump"}
    assert not far
    assert far.safe_until == 0.0
    elsewhere = gate.judge([home + 0.02, home + 0.02], times=[0, 0.5], start=home)
    assert kinds_of(elsewhere) == {"jump"}
    assert elsewhere.reasons[0].value == pytest.approx(0.02)
    assert gate.judge([home + 0.009, home + 0.009], times=[0, 0.5], start=home)  # within the tube


def test_speed_and_acceleration_are_reasons(checker, home):
    gate = pc.Gate(checker, velocity=1.0, acceleration=10.0)
    steady, ahead = np.full(7, 0.25), np.arange(1, 9)[:, None] / 50
    assert gate.judge(home + steady * ahead, 50, start=(home, steady))
    at_once = gate.judge(home + steady * ahead, 50, start=home)
    assert kinds_of(at_once) == {"acceleration"}
    assert at_once.reasons[0].value == pytest.approx(0.25 * 50)
    chunk = home + steady * ahead
    chunk[5:] += 0.02
    assert kinds_of(gate.judge(chunk, 50, start=(home, steady))) == {"speed", "acceleration"}
    assert kinds_of(gate.judge(home + steady * ahead, 50, start=(home, steady * 5))) == {"speed", "acceleration"}


def test_speeds_that_are_clamped_pass(checker, home):
    gate = pc.Gate(checker, velocity=0.2, brake=5.0)
    for rate in (30, 50, 333):
        chunk = home + 0.2 / rate * np.arange(1, 11)[:, None]
        assert gate.judge(chunk, rate, start=(home, np.full(7, 0.2)))
        assert plain(gate).judge(chunk, rate, start=(home, np.full(7, 0.2)))


def test_stops_that_are_too_long_to_prove_leave_the_shorter_ones(gate, home):
    """The chunk ends so fast that rounding is no small part of its stop; a stop from its start is proved."""
    verdict = gate.judge([home, home + 1e8], rate=50, start=home)
    assert not verdict.ok
    assert verdict.reasons
    assert verdict.safe_until == 0.02
    assert not json.loads(verdict.record())["verdict"]["ok"]


def test_a_stop_beyond_the_limits_is_a_reason(gate, checker, home):
    q, dq = home.copy(), np.zeros(7)
    q[6], dq[6] = checker.robot.upper[6] - 0.05, 1.0
    chunk = np.tile(q, (2, 1))
    chunk[:, 6] += [0.02, 0.04]  # the stop takes another 0.1
    (reason,) = gate.judge(chunk, 50, start=(q, dq)).reasons
    assert (reason.kind, reason.joint, reason.on_stop) == ("limit", "panda_joint7", True)


def wall_at(checker, q, link, size=0.002):
    """The same robot with a small body at the origin of a link at a state."""
    scene, pose = pc.Scene("wall"), checker.robot.link_poses(q)[checker.robot.link_index(link)]
    scene.add("wall", pc.Box((size, size, size)), pose)
    return pc.Checker(checker.robot, scene)


def test_a_stop_into_a_wall_does_not_pass(checker, home):
    dq = np.array([1.5, 0, 0, 0, 0, 0, 0])
    chunk = home + dq * np.arange(1, 4)[:, None] / 50
    rest = chunk[-1] + dq * dq / (2 * BRAKE)
    among = wall_at(checker, rest + 0.05 * np.eye(7)[0], "panda_hand")
    gate = pc.Gate(among, velocity=SPEED, brake=BRAKE)
    for each in (gate, plain(gate)):
        verdict = each.judge(chunk, 50, start=(home, dq))
        assert not verdict.ok
        assert verdict.reasons[0].on_stop
        assert verdict.reasons[0].kind == "collision"


def meets(ends, reach, state):
    """Whether a state (nq,) is within reach (nq,) of a straight motion (2, nq), to 1e-9."""
    begin, way, off = ends[0], ends[1] - ends[0], reach + 1e-9
    still = way == 0
    with np.errstate(divide="ignore", invalid="ignore"):
        parts = np.sort([(state - off - begin) / way, (state + off - begin) / way], axis=0)
    inside = np.abs(state - begin)[still] <= off[still]
    return inside.all() and parts[0, ~still].max(initial=0) <= parts[1, ~still].min(initial=1)


def judged_quickly(gate, rows, dq, refused):
    """The verdict of the fast path, and what it asks for, where each motion is refused whose tube holds a state."""
    asked, tools = [], gate._tools

    def is_free(ends, tube):
        asked.append((ends, tube))
        return not meets(ends, tube[:-1], refused)

    return QuickJudge(tools.settings, tools.limits, tools.proofs, is_free).judge(rows, dq, 50.0)[1], asked


BRAKES = np.array([5.0, 1.5, 3.0, 5.0, 5.0, 5.0, 5.0])


@pytest.mark.parametrize("count", [1, 2, 3, 16, 50])
def test_the_fast_path_covers_the_chunk_and_the_stop(checker, home, count):
    """A chunk does not pass where one state of it, or of its stop, with the tube, is refused; else it does."""
    gate, rng = pc.Gate(checker, velocity=SPEED, tube=TUBE, margin=MARGIN, brake=BRAKES), np.random.default_rng(count)
    for k in range(200):
        dq = rng.uniform(-0.4, 0.4, 7) * (np.arange(7) != 5)
        rows = home + dq * np.arange(count + 1)[:, None] / 50
        rows[1:-1] += 0.003 * rng.normal(size=rows[1:-1].shape) * (np.arange(7) != 5)
        on_stop, part = k % 2 == 0, rng.uniform(0, count)
        at, lasts = stop_by_hand(rows[-1], (rows[-1] - rows[-2]) * 50, BRAKES)
        state = np.array([np.interp(part, np.arange(count + 1), column) for column in rows.T])
        state = at(rng.uniform(0, lasts)) if on_stop else state
        corner = rng.choice([-TUBE, TUBE], 7)
        passes, asked = judged_quickly(gate, rows, dq, state + corner)
        assert not passes
        assert on_stop or passes is False
        assert {float(tube[-1]) for _, tube in asked} <= {MARGIN, MARGIN + 1e-4}
        apart = state + corner * (1 + 0.01 * (np.arange(7) == 5))  # of a joint that stands
        assert judged_quickly(gate, rows, dq, apart)[0] is True


def test_judgements_leave_nothing_behind(gate, chunks):
    """Neither Python's blocks nor the process's memory grow; `gate_times.py` says so of 100,000 judgements."""
    for _ in range(2):  # caches are full after the first round
        blocks, memory = sys.getallocatedblocks(), resident()
        for _ in range(30):
            for positions, q, dq in chunks:
                gate.judge(positions, 50, start=(q, dq))
    assert sys.getallocatedblocks() - blocks < 100
    assert resident() - memory < 1 << 20


def test_a_robot_at_rest_stops_where_it_stands(gate, home):
    verdict = gate.judge(np.tile(home, (3, 1)), 50, start=home)
    assert verdict.ok
    np.testing.assert_array_equal(verdict.stop.position(verdict.stop.curve.breaks), [home, home])
    touching = gate.checker.robot.random_configurations(300, 5)
    q = touching[~gate.checker.check_states(touching)][0]
    verdict = gate.judge(np.tile(q, (3, 1)), 50, start=q)
    assert kinds_of(verdict) == {"collision"}
    assert verdict.safe_until is None
    assert verdict.stop is None


@pytest.mark.parametrize("controller", ["linear", "ur", "jtc-upsampled"])
def test_other_controllers(checker, home, controller):
    gate = pc.Gate(checker, controller, velocity=1.0, acceleration=60.0, brake=5.0)
    chunk = home + 0.002 * np.arange(1, 9)[:, None]
    verdict = gate.judge(chunk, 50, start=home)
    assert verdict.ok
    run = pc.Trajectory(np.arange(1, 9) / 50, chunk, controller=controller, start=home)
    np.testing.assert_array_equal(verdict.trajectory.curve.pieces, run.curve.pieces)
    assert not gate.judge(home + 0.03 * np.arange(1, 9)[:, None], 50, start=home)


def test_whole_turns_of_continuous_joints_are_no_jump():
    robot = pc.Robot.load("kinova")
    checker = pc.Checker(robot, pc.Scene())
    q = robot.random_configurations(50, 0)
    q = q[checker.check_states(q)][0]
    gate = pc.Gate(checker, velocity=2.0, brake=5.0)
    chunk = q + 0.004 * np.arange(1, 9)[:, None]
    turned = chunk + 2 * np.pi * np.eye(6)[0]
    verdict = gate.judge(turned, 50, start=q)
    assert verdict.ok
    np.testing.assert_allclose(verdict.trajectory.position(0.0), q + 2 * np.pi * np.eye(6)[0], atol=1e-12)
    assert kinds_of(gate.judge(turned + np.eye(6)[0], 50, start=q)) == {"jump"}


MISTAKES = {
    "empty": ({"chunk": np.empty((0, 7)), "rate": 50}, "chunk must have the shape"),
    "one row": ({"chunk": np.zeros(7), "rate": 50}, "chunk must have the shape"),
    "too narrow": ({"chunk": np.zeros((3, 6)), "rate": 50}, "chunk must have the shape"),
    "texts": ({"chunk": [["a"] * 7], "rate": 50}, "chunk must be numbers"),
    "not a number": ({"chunk": np.full((3, 7), np.nan), "rate": 50}, "chunk must be finite"),
    "not a number beyond a limit": ({"chunk": np.array([[9.0] * 7, [np.nan] * 7]), "rate": 50}, "chunk must be finite"),
    "infinite start": ({"chunk": np.zeros((3, 7)), "rate": 50, "start": np.full(7, np.inf)}, "start must be finite"),
    "velocities": ({"chunk": np.zeros((3, 7)), "rate": 50, "start": (np.zeros(7), np.full(7, np.nan))}, "velocities"),
    "narrow start": ({"chunk": np.zeros((3, 7)), "rate": 50, "start": np.zeros(6)}, "start must have the shape"),
    "rate 0": ({"chunk": np.zeros((3, 7)), "rate": 0}, "rate must be"),
    "negative rate": ({"chunk": np.zeros((3, 7)), "rate": -50}, "rate must be"),
    "rate NaN": ({"chunk": np.zeros((3, 7)), "rate": np.nan}, "rate must be"),
    "true": ({"chunk": np.zeros((3, 7)), "rate": True}, "rate must be"),
    "neither": ({"chunk": np.zeros((3, 7))}, "needs rate= or times="),
    "both": ({"chunk": np.zeros((3, 7)), "rate": 50, "times": [1, 2, 3]}, "needs rate= or times="),
    "falling times": ({"chunk": np.zeros((3, 7)), "times": [1, 3, 2]}, "times must be 3"),
    "early times": ({"chunk": np.zeros((3, 7)), "times": [-1, 3, 4]}, "times must be 3"),
    "few times": ({"chunk": np.zeros((3, 7)), "times": [1, 2]}, "times must be 3"),
    "no motion": ({"chunk": np.zeros((1, 7)), "times": [0]}, "no motion"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_mistakes_in_chunks(gate, name):
    given, words = MISTAKES[name]
    with pytest.raises(pc.PlannercheckError, match=words):
        gate.judge(**{"start": (np.zeros(7), np.zeros(7)), **given})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"brake": None}, "no deceleration"),
        ({"brake": 0}, "brake must be a number more than 0"),
        ({"brake": [1, 2]}, "brake must be a number more than 0"),
        ({"velocity": np.inf}, "no largest speed"),
        ({"velocity": -1}, "velocity must be"),
        ({"acceleration": np.nan}, "acceleration must be"),
        ({"margin": -0.1}, "margin must be"),
        ({"margin": np.nan}, "margin must be"),
        ({"tube": -1}, "tube must be"),
        ({"tolerance": 0}, "tolerance must be"),
        ({"controller": "motoros2"}, "motoros2 refuses"),
        ({"controller": "jtx"}, "did you mean 'jtc'"),
    ],
)
def test_mistakes_in_settings(checker, changes, words):
    with pytest.raises(pc.PlannercheckError, match=words):
        pc.Gate(checker, **{"velocity": SPEED, "brake": BRAKE, **changes})


def test_moving_scenes_are_refused(checker):
    scene = pc.Scene("belt")
    scene.add("pallet", pc.Sphere(0.1), pc.Moving([0, 1], np.array([np.eye(4)] * 2)))
    moving = pc.Checker(checker.robot, scene)
    with pytest.raises(pc.PlannercheckError, match="stands still"):
        pc.Gate(moving, velocity=SPEED, brake=BRAKE)
    with pytest.raises(pc.PlannercheckError, match="stands still"):
        pc.Gate(checker, velocity=SPEED, brake=BRAKE).of(moving)


def test_what_callers_change_later_changes_no_verdict(gate, chunks):
    positions, q, dq = (each.copy() for each in next(c for c in chunks if not gate.judge(c[0], 50, start=c[1:]).ok))
    expected = gate.judge(positions, 50, start=(q, dq)).as_json()
    verdict = gate.judge(positions, 50, start=(q, dq))
    for each in (positions, q, dq):
        each[:] = 0
    assert verdict.as_json() == expected


def test_arrays_and_lists_get_the_same_verdict(gate, chunks):
    positions, q, dq = chunks[0]
    lists = gate.judge(positions.tolist(), 50, start=(q.tolist(), dq.tolist()))
    assert lists.record() == gate.judge(positions, 50, start=(q, dq)).record()


def test_records_are_replayed(checker, gate, chunks):
    for positions, q, dq in chunks[:6]:
        line = gate.judge(positions, 50, start=(q, dq)).record()
        assert differences(parse_record(line), checker) == ()
    by_times = gate.judge(positions, times=np.arange(1, 17) * 0.02, start=q).record()
    assert differences(parse_record(by_times), checker) == ()
    record = json.loads(by_times)
    record["chunk"]["positions"][3][2] += 1e-9
    assert differences(record, checker)[0] == "chunk: not the one that was judged"
    record = json.loads(line)
    record["verdict"]["ok"] = not record["verdict"]["ok"]
    assert any("verdict.ok" in each for each in differences(record, checker))


def test_records_tell_other_scenes_and_robots(checker, gate, chunks):
    record = parse_record(gate.judge(chunks[0][0], 50, start=chunks[0][1:]).record())
    scene = pc.Scene.load("bookshelf")
    scene.add("can", pc.Sphere(0.01), np.block([[np.eye(3), np.full((3, 1), 3.0)], [np.zeros((1, 3)), 1]]))
    assert "scene: not the one that was judged" in differences(record, checker.with_scene(scene))
    alone = pc.Checker(checker.robot, checker.scene, self_collision=False)
    assert "robot: not the one that was judged" in differences(record, alone)
    for line in ("[]", "{}", "{", '{"format": "plannercheck gate 1"}'):
        with pytest.raises(pc.PlannercheckError):
            parse_record(line)
