"""Planar robots in planar scenes: kinematics against many digits, verdicts against shapely and integers, switches."""

import math

import numpy as np
import planar_cases as cases
import pytest
import shapely
from mpmath import mp, mpf
from planar_brute_force import share_point
from planar_cases import chain, cluttered

import plannercheck as pc
from plannercheck.planar.polygons import METHODS
from plannercheck.planar.robot_files import shipped_planar
from plannercheck.validation.planar_certification import certify_verdicts

P = pc.planar
SHIPPED = [("warehouse", "forklift"), ("parking", "truck_trailer"), ("parking", "forklift")]


@pytest.fixture(scope="module")
def checker():
    return P.Checker(chain(), cluttered())


def test_link_poses_and_their_error(checker):
    robot = checker.robot
    for q in robot.random_configurations(50, 1):
        with mp.workdps(40):
            x, y, angle = mpf(float(q[0])), mpf(float(q[1])), mpf(float(q[2]))
            exact = [(x, y, angle)]
            for link, turn in zip(robot.links[1:], [*map(float, q[3:]), 0.0], strict=True):
                c, s = mp.cos(angle), mp.sin(angle)
                dx, dy, da = map(float, link.anchor)
                x, y, angle = x + c * dx - s * dy, y + s * dx + c * dy, angle + da + turn
                exact.append((x, y, angle))
            bound = checker.explain(q).kinematic_error
            assert bound < 1e-11
            for body in robot.bodies:
                pose, (x, y, angle) = robot.link_poses(q)[body.link], exact[body.link]
                for u, v in body.vertices.tolist():
                    off_x = mpf(pose[0, 0]) * u + mpf(pose[0, 1]) * v + pose[0, 2]
                    off_y = mpf(pose[1, 0]) * u + mpf(pose[1, 1]) * v + pose[1, 2]
                    off_x -= x + mp.cos(angle) * u - mp.sin(angle) * v
                    off_y -= y + mp.sin(angle) * u + mp.cos(angle) * v
                    assert mp.hypot(off_x, off_y) <= bound


def test_verdicts_are_shapelys(checker):
    q = checker.robot.random_configurations(400, 2)
    colliding, poses = checker.colliding_pairs(q), checker.body_poses(q)
    for row in range(len(q)):
        posed = [
            shapely.Polygon(b.vertices @ p[:2, :2].T + p[:2, 2])
            if len(b.vertices) > 2
            else shapely.LineString(b.vertices @ p[:2, :2].T + p[:2, 2])
            for b, p in zip(checker.bodies, poses[row], strict=True)
        ]
        expected = shapely.intersects(*(np.array(posed, dtype=object)[checker.pairs[:, k]] for k in (0, 1)))
        assert (colliding[row] == expected).all()
    assert 0.1 < (~colliding.any(axis=1)).mean() < 0.9


def test_touching_is_decided_exactly():
    """Parked against a wall, and one step of a double off it."""
    robot = P.Robot([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    scene = P.Scene()
    scene.add_polygon("wall", [[2, -5], [3, -5], [3, 5], [2, 5]])
    checker = P.Checker(robot, scene)
    assert checker.check_states([[1, 0, 0], [np.nextafter(1, 0), 0, 0], [np.nextafter(1, 2), 0, 0]]).tolist() == [
        False,
        True,
        False,
    ]
    rng = np.random.default_rng(4)
    angles = rng.uniform(0, 7, 200)
    q = np.column_stack([2 - np.abs(np.cos(angles)) - np.abs(np.sin(angles)), np.zeros(200), angles])
    poses = checker.body_poses(q)[:, 0]
    expected = [share_point(robot.bodies[0].vertices, scene.bodies[0].vertices, pose) for pose in poses]
    assert (checker.check_states(q) == ~np.array(expected)).all()
    assert 0 < np.mean(expected) < 1


def test_switches_and_batches_agree(checker):
    q = checker.robot.random_configurations(301, 3)
    first = checker.first_colliding_pair(q)
    for method in METHODS:
        for bounds in (True, False):
            other = P.Checker(chain(), checker.scene, method=method, bounds=bounds)
            rows = slice(None) if method == "filtered" else slice(40)
            assert (other.first_colliding_pair(q[rows]) == first[rows]).all()
    every = checker.colliding_pairs(q)
    assert (np.where(every.any(axis=1), every.argmax(axis=1), -1) == first).all()
    assert (checker.first_colliding_pair(q, threads=3) == first).all()
    assert [checker.is_valid(row) for row in q] == checker.check_states(q).tolist()
    assert checker.check_states(np.zeros((0, 5))).shape == (0,)


def test_statistics_count_every_pair_once():
    checker = P.Checker(chain(), cluttered())
    checker.check_states(checker.robot.random_configurations(101, 3))
    counts = checker.statistics()
    assert counts["states"] == 101
    assert counts["pairs"] == 101 * len(checker.pairs)
    assert counts["pairs"] == counts["bounds"] + counts["tests"] + counts["skipped"]
    assert counts["queries"]["rounds"] >= counts["tests"] > 0


def test_explain_names_and_proves():
    checker = P.Checker(chain(), cluttered(count=8, reach=8.0))
    for q in checker.robot.random_configurations(6, 5):
        verdict = checker.explain(q, separations=True)
        assert verdict.valid == checker.is_valid(q) == (not verdict.collisions)
        assert len(verdict.collisions) + len(verdict.separations) == len(checker.pairs)
        assert all(found.certificate.verify() for found in (*verdict.collisions, *verdict.separations))
    assert all(found.first in checker.robot.link_names for found in verdict.separations)


def test_certification_proves_all():
    checker = P.Checker(chain(), cluttered(count=8, reach=10.0))
    q = checker.robot.random_configurations(8, 6)
    report = certify_verdicts(checker, q, checker.first_colliding_pair(q))
    valid = int(checker.check_states(q).sum())
    assert report.passed
    assert report.shared_points == len(q) - valid
    assert report.planes == valid * len(checker.pairs)


def test_motions_are_those_of_states(checker):
    q = checker.robot.random_configurations(30, 7)
    ends = q + np.random.default_rng(8).normal(size=q.shape) * 0.3
    free = checker.check_motions(q, ends)
    for a, b, verdict in zip(q, ends, free, strict=True):
        steps = int(checker.motion_sampler.steps(a[None], b[None], None)[0])
        states = checker.motion_sampler.states(a, b, np.arange(steps + 1) / steps)
        assert verdict == checker.check_states(states).all() == checker.check_motion(a, b)
        moved = [
            np.hypot(*np.diff(body.vertices @ poses[:, :2, :2].transpose(0, 2, 1) + poses[:, None, :2, 2], axis=0).T)
            for body in checker.robot.bodies
            for poses in [checker.robot.link_poses(states)[:, body.link]]
        ]
        assert max(step.max() for step in moved) <= 0.01
    assert 0 < free.mean() < 1


def test_self_pairs_leave_out_neighbours():
    robot = chain()
    pairs = {(robot.bodies[a].link, robot.bodies[b].link) for a, b in robot.self_pairs()}
    assert pairs == {(0, 2), (0, 3)}  # the mast is fixed to the second trailer, a neighbour of the first
    fewer = P.Robot(robot.links, disabled_pairs=[("truck", "mast")])
    assert {(fewer.bodies[a].link, fewer.bodies[b].link) for a, b in fewer.self_pairs()} == {(0, 2)}
    folded = np.array([0, 0, 0, 1.2, 3.0])
    assert not P.Checker(robot).is_valid(folded) or P.Checker(robot, self_collision=False).is_valid(folded)
    assert len(P.Checker(robot, self_collision=False).pairs) == 0


def test_a_fixed_root_is_an_arm():
    arm = P.Robot(
        [
            P.Link("foot", [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]], anchor=(1, 0, 0)),
            P.Link("upper", [[0, 0], [1, 0]], "foot", joint="revolute", limits=(-2, 2)),
            P.Link("lower", [[0, 0], [1, 0]], "upper", (1, 0, 0), "revolute"),
        ]
    )
    assert arm.joint_names == ("upper_joint", "lower_joint")
    assert not arm.is_free
    scene = P.Scene()
    scene.add_polygon("point", [[2, 1]])
    scene.add_polygon("at the foot", [[1, 0]])
    checker = P.Checker(arm, scene)  # the foot does not move, so it is not tested
    assert checker.pair_names(int(checker.first_colliding_pair([[0, math.pi / 2]])[0])) == ("upper", "at the foot")
    assert P.Checker(arm).is_valid([0, 0])


def test_pieces_cover_what_they_split():
    rng = np.random.default_rng(9)
    for _ in range(20):
        angles = np.sort(rng.uniform(0, 2 * np.pi, 12))
        star = np.column_stack([np.cos(angles), np.sin(angles)]) * rng.uniform(0.2, 1, (12, 1))
        pieces = P.convex_pieces(star)
        assert sum(shapely.Polygon(piece).area for piece in pieces) == pytest.approx(shapely.Polygon(star).area)
        assert {tuple(v) for piece in pieces for v in piece.tolist()} == {tuple(v) for v in star.tolist()}
    square = cases.regular(4)
    assert np.array_equal(P.convex_pieces(square)[0], square)
    with pytest.raises(pc.PlannercheckError, match="no simple polygon"):
        P.convex_pieces([[0, 0], [1, 1], [1, 0], [0, 1]])


@pytest.mark.parametrize(("scene", "robot"), SHIPPED)
def test_shipped_scenes_round_trip(scene, robot, tmp_path):
    given = P.Scene.load(scene)
    given.save(tmp_path / "copy.yaml")
    copy = P.Scene.load(tmp_path / "copy.yaml")
    first, second = (P.Checker(P.Robot.load(robot), s) for s in (given, copy))
    samples = given.samples(robot)
    assert samples.shape == (1000, first.robot.nq)
    verdicts = first.check_states(samples)
    assert (verdicts == second.check_states(samples)).all()
    assert 0.05 < verdicts.mean() < 0.95
    assert first.check_states([given.start(robot), given.goal(robot)]).all()
    assert ((samples >= first.robot.lower) & (samples <= first.robot.upper)).all()


def test_shipped_names():
    assert set(shipped_planar("robots")) >= {"forklift", "truck_trailer"}
    assert set(shipped_planar("configs")) >= {"warehouse", "parking"}


@pytest.mark.parametrize(
    ("links", "message"),
    [
        ([P.Link("a", [[0, 0]]), P.Link("a", [[0, 0]], "a")], "name of its own"),
        ([P.Link("a", [[0, 0]]), P.Link("b", [[0, 0]], "c")], "hangs on one before it"),
        ([P.Link("a", [[0, 0]], joint="free"), P.Link("b", [[0, 0]], "a", joint="free")], "only the first"),
        ([P.Link("a", [[0, 0]], joint="prismatic")], "revolute"),
        ([P.Link("a", [[0, 0]], joint="revolute", limits=(1, 0))], "limits"),
        ([P.Link("a", [[0, 0]], joint="revolute", limits=(1,))], "limits"),
        ([P.Link("a", [[0, 0]], limits=(-1, 1))], "limits go with a revolute joint, not with a fixed one"),
        ([P.Link("a", [[0, 0]], anchor=(0, math.nan, 0))], "anchor"),
        ([P.Link("a", [[0, 0]], anchor="xyz")], "'a': anchor must be numbers"),
        ([P.Link("a", [[0, 0]], joint=["free"])], "must be texts"),
        ([P.Link("a", [[[0, 0], [1]]])], "footprint 0 of 'a' must be numbers"),
    ],
)
def test_bad_links_are_named(links, message):
    with pytest.raises(pc.PlannercheckError, match=message):
        P.Robot(links)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("objects: []", "not planar"),
        ("kind: planar\nobjects: [{name: a}]", "exactly one of the keys"),
        ("kind: planar\nobjects: [{name: a, box: {size: [1, -1]}}]", "two positive lengths"),
        ("kind: planar\nbounds: [[1, 1], [0, 0]]", "bounds"),
        ("kind: planar\nobjects: [{name: a, polygon: [[0, 0, 0]]}]", "needs 2 numbers"),
        ("kind: planar\nwalls: []", "walls"),
    ],
)
def test_bad_scene_files_are_named(text, message, tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text(text)
    with pytest.raises(pc.PlannercheckError, match=message):
        P.Scene.load(path)


def test_bad_calls_are_named(checker):
    with pytest.raises(pc.PlannercheckError, match="shape"):
        checker.check_states(np.zeros((3, 4)))
    with pytest.raises(pc.PlannercheckError, match="finite"):
        checker.check_states(np.full((1, 5), np.nan))
    with pytest.raises(pc.PlannercheckError, match=r"planar\.Robot"):
        P.Checker("forklift")
    with pytest.raises(pc.PlannercheckError, match="truck_trailer"):
        P.Robot.load("fork")


SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: P.intersects(None, SQUARE), "A must be numbers"),
        (lambda: P.intersects(SQUARE, SQUARE, "abc"), "pose_a must be numbers"),
        (lambda: P.intersects_batch(np.array(SQUARE) + 1j, SQUARE), "A must be numbers, not an array of dtype complex"),
        (lambda: P.intersects_batch([SQUARE, "abc"], SQUARE), "A: polygon 1 must be numbers"),
        (lambda: P.intersects_batch([[[0, 0], [1]], SQUARE], SQUARE), "A: polygon 0 must be numbers"),
        (lambda: P.Polygons(None), "polygons must be several"),
        (lambda: P.Robot(SQUARE, disabled_pairs=["ab"]), "a disabled pair must be two links"),
        (lambda: P.Robot(SQUARE).with_bounds([], [1, 1]), "the least and the largest"),
        (lambda: P.Robot(SQUARE).with_bounds([1, 1], [0, 0]), "the least and the largest"),
        (lambda: P.Scene("s", "abc"), "bounds must be numbers"),
        (lambda: P.Checker(P.Robot.load("forklift"), self_collision=None), "self_collision must be True or False"),
        (lambda: P.Scene().add("a", None), "at least one polygon"),
        (lambda: P.Scene().add_box("a", [1, 1, 1]), "two positive lengths"),
        (lambda: P.Scene().add_box("a", "abc"), "'a': size must be numbers"),
        (lambda: P.pose_of("ab"), "position must be numbers"),
        (lambda: P.pose_of((0, 0, 1)), "x and y and an angle"),
        (lambda: P.pose_of((0, 0), math.inf), "all finite"),
        (lambda: P.Checker(P.Robot(SQUARE)).check_motion([0, 0, 0], [1, 0, 0], "1"), "resolution must be a positive"),
        (
            lambda: P.Checker(P.Robot(SQUARE)).check_motion([0] * 3, [1] * 3, curve="dubins", turning_radius="1"),
            "turning_radius must be a positive",
        ),
    ],
)
def test_what_is_no_number_is_named(call, message):
    with pytest.raises(pc.PlannercheckError, match=message):
        call()


@pytest.mark.parametrize("limits", [(2, math.inf), (-math.inf, -2), (-math.inf, 0.5)])
def test_random_angles_keep_a_single_limit(limits):
    robot = P.Robot([P.Link("a", SQUARE, joint="revolute", limits=limits)])
    q = robot.random_configurations(100, seed=0)
    assert (q >= robot.lower).all()
    assert (q <= robot.upper).all()
    assert np.ptp(q) > 0.5
