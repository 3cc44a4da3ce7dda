"""Tables of distances against single pairs, Pinocchio's tangent, and derivatives in 300 bits."""

import pickle
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from gradient_oracle import Differences, scene_around

import plannercheck as pc
from plannercheck.bodies.shapes import Box, Capsule, Sphere

LIMIT = 0.1


def one_body_urdf(joint: str, shape: str = '<box size="0.1 0.2 0.3"/>') -> str:
    """A body on one joint."""
    body = f'<link name="body"><collision><geometry>{shape}</geometry></collision></link>'
    return f'<robot name="one"><link name="base"/>{body}{joint}</robot>'


@pytest.fixture(scope="module")
def panda():
    return pc.Robot.load("panda")


@pytest.fixture(scope="module")
def checker(panda):
    return pc.Checker(panda, scene_around(panda, 0))


@pytest.fixture(scope="module")
def states(panda):
    return panda.random_configurations(150, seed=1)


def rows_of(table):
    return list(zip(table.state.tolist(), table.pair.tolist(), table.distance.tolist(), strict=True))


def test_rows_are_the_pairs_nearer_than_the_limit(checker, states):
    table = checker.distances(states, LIMIT)
    found = {(state, pair): distance for state, pair, distance in rows_of(table)}
    polytopes = [checker._preparation.polytope(k) for k in range(len(checker.bodies))]
    for state in range(0, len(states), 10):
        poses = checker.body_poses(states[state])[0]
        for pair, (a, b) in enumerate(checker.pairs.tolist()):
            single = pc.distance(polytopes[a], polytopes[b], poses[a], poses[b])
            if single.distance <= LIMIT:
                row = found.pop((state, pair))
                assert row == (single.distance if single.distance > 0 else pytest.approx(single.lower_bound, abs=1e-9))
            else:
                assert (state, pair) not in found
    assert not [state for state, _ in found if state % 10 == 0]
    assert (table.lower <= table.distance).all()
    order = np.lexsort((table.pair, table.distance, table.state))
    np.testing.assert_array_equal(order, np.arange(len(table)))


def test_points_are_as_far_apart_as_the_distance_along_the_normal(checker, states):
    table = checker.distances(states)
    apart = table.distance > 0
    between = table.points[:, 0] - table.points[:, 1]
    np.testing.assert_allclose(between[apart], (table.distance[:, None] * table.normal)[apart], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(table.normal, axis=1), 1, atol=1e-12)


@pytest.mark.parametrize(
    "change",
    [
        {"threads": 4},
        {"tuning": pc.Tuning(bounds=False, boxes=False, float_poses=False)},
        {"tuning": pc.Tuning(learning=False, sorted_states=False)},
        {"limit": 1.0},
        {"limit": np.inf},
    ],
)
def test_rows_depend_on_the_configuration_alone(panda, checker, states, change):
    """Whatever the threads, tuning, limit and the other configurations."""
    rng = np.random.default_rng(0)
    order = rng.permutation(len(states))
    tuning = change.pop("tuning", pc.Tuning())
    other = pc.Checker(panda, checker.scene, tuning=tuning)
    table = checker.distances(states, LIMIT)
    again = other.distances(states[order], **{"limit": LIMIT, **change})
    singles = [checker.distances(q, LIMIT) for q in states[:20]]
    near = again.distance <= LIMIT
    expected = {
        (s, p): (d, *g) for s, p, d, g in zip(table.state, table.pair, table.distance, table.gradient, strict=True)
    }
    moved = zip(order[again.state[near]], again.pair[near], again.distance[near], again.gradient[near], strict=True)
    assert {(s, p): (d, *g) for s, p, d, g in moved} == expected
    for state, single in enumerate(singles):
        own = table.state == state
        np.testing.assert_array_equal(single.gradient, table.gradient[own])
        np.testing.assert_array_equal(single.points, table.points[own])


@pytest.mark.parametrize("off", [0.0, 0.003, 0.1, 3.0])
@pytest.mark.parametrize("nearest", [None, 3])
def test_earlier_rows_change_digits_alone(checker, states, off, nearest):
    earlier = checker.distances(states + off * np.random.default_rng(2).normal(size=states.shape), 2 * LIMIT)
    table = checker.distances(states, LIMIT, nearest)
    again = checker.distances(states, LIMIT, nearest, start=earlier, threads=2)
    order, other = np.lexsort((table.pair, table.state)), np.lexsort((again.pair, again.state))
    for name in ("state", "pair", "unique"):
        np.testing.assert_array_equal(getattr(table, name)[order], getattr(again, name)[other])
    np.testing.assert_allclose(table.distance[order], again.distance[other], rtol=0, atol=1e-13)
    apart = table.distance[order] > 0  # else the distance is its lower bound
    assert (again.lower[other] <= table.distance[order])[apart].all()
    assert (table.lower[order] <= again.distance[other])[apart].all()
    own = order[table.unique[order]], other[again.unique[other]]
    np.testing.assert_allclose(table.gradient[own[0]], again.gradient[own[1]], rtol=0, atol=1e-9)
    one = checker.distances(states[:1], LIMIT, nearest, start=checker.distances(states[:1], 2 * LIMIT))
    np.testing.assert_allclose(one.distance, table.distance[table.state == 0], rtol=0, atol=1e-13)


def test_descents_begin_at_the_earlier_corners(checker, states):
    """From its own corners a descent ends where it began, with other digits in some rows."""
    table = checker.distances(states)
    again = checker.distances(states, start=table)
    assert (again.distance != table.distance).any() or (again.points != table.points).any()
    twice = checker.distances(states, start=table, threads=3)
    np.testing.assert_array_equal(again.points, twice.points)
    kept = pickle.loads(pickle.dumps(table))
    np.testing.assert_array_equal(again.points, checker.distances(states, start=kept).points)


@pytest.mark.parametrize("numbers", [[9] * 9, [-1] * 9, [2, 10**6, 0, 0, 0, 0, 0, 0, 0], [1, 0, 0, 0, 0, -5, 0, 0, 0]])
def test_corners_that_are_none_are_passed_over(checker, states, numbers):
    table = checker.distances(states)
    broken = replace(table, _corners=np.tile(np.array(numbers, np.int32), (len(table), 1)))
    np.testing.assert_array_equal(checker.distances(states, start=broken).points, table.points)


def test_gradients_are_those_of_300_bits(checker, states):
    table = checker.distances(states)
    differences, chosen = Differences(checker), np.flatnonzero(table.unique)
    assert table.unique.mean() > 0.9
    overlaps = np.flatnonzero(table.unique & (table.distance < 0))
    for k in [*chosen[:: len(chosen) // 20].tolist(), *overlaps[:5].tolist()]:
        found, apart = differences.gradients(
            states[table.state[k]], int(table.pair[k]), table.normal[k], table.distance[k]
        )
        assert abs(apart - table.distance[k]) < 1e-13
        np.testing.assert_allclose(found, [table.gradient[k]], atol=1e-12)


JOINTS = {
    "floating": '<joint name="j" type="floating"><parent link="base"/><child link="body"/></joint>',
    "planar": '<joint name="j" type="planar"><parent link="base"/><child link="body"/><axis xyz="0 0 1"/></joint>',
    "continuous": '<joint name="j" type="continuous"><parent link="base"/><child link="body"/><axis xyz="0.6 0 0.8"/>'
    '<origin xyz="0.3 0 0"/></joint>',
}


@pytest.mark.parametrize("kind", JOINTS)
def test_gradients_are_in_pinocchios_tangent(tmp_path, kind):
    """The distance changes along each tangent direction, by Pinocchio's integration, as the gradient says."""
    path = tmp_path / "one.urdf"
    path.write_text(one_body_urdf(JOINTS[kind]))
    robot = pc.Robot.from_urdf(path)
    scene, pose = pc.Scene("ball"), np.eye(4)
    pose[:3, 3] = 0.5, 0.2, -0.1
    scene.add("ball", Sphere(0.05), pose)
    checker = pc.Checker(robot, scene)
    model = robot.model
    for q in robot.random_configurations(20, seed=2):
        (table,) = [checker.distances(q, np.inf)]
        assert table.gradient.shape == (1, model.nv)
        if not table.unique[0] or table.distance[0] < 0.01:
            continue
        full = robot.configuration_map.expand(q[None])[0]
        for k, direction in enumerate(np.eye(model.nv)):
            ends = [self_configuration(robot, pin.integrate(model, full, step * direction)) for step in (1e-6, -1e-6)]
            apart = [checker.clearance(end) for end in ends]
            assert (apart[0] - apart[1]) / 2e-6 == pytest.approx(table.gradient[0, k], abs=1e-7)


def test_mimic_joints_and_slides_have_gradients(tmp_path):
    """Fingers that slide together, one as the other's mimic with a multiplier."""
    path = tmp_path / "hand.urdf"
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    finger = '<collision><geometry><box size="0.02 0.04 0.1"/></geometry></collision>'
    path.write_text(
        f'<robot name="hand"><link name="palm"/><link name="left">{finger}</link><link name="right">{finger}</link>'
        f'<joint name="open" type="prismatic"><parent link="palm"/><child link="left"/>'
        f'<axis xyz="1 0 0"/>{limit}</joint>'
        f'<joint name="follow" type="prismatic"><parent link="palm"/><child link="right"/><axis xyz="1 0 0"/>{limit}'
        '<origin xyz="0.01 0.01 0"/><mimic joint="open" multiplier="-0.5" offset="-0.2"/></joint></robot>'
    )
    checker = pc.Checker(pc.Robot.from_urdf(path, group=["open"]))
    table = checker.distances([[0.1], [0.3]], np.inf)
    # the left finger is at x, the right one at 0.01 - 0.5 x - 0.2
    np.testing.assert_allclose(table.distance, [0.1 + 0.24 - 0.02, 0.3 + 0.34 - 0.02], atol=1e-12)
    np.testing.assert_allclose(table.gradient, [[1.5], [1.5]], atol=1e-12)


def self_configuration(robot, full):
    """The group's configuration from Pinocchio's: a continuous joint's angle from its cosine and sine."""
    if robot.nq == len(full):
        return full
    return np.array([np.arctan2(full[1], full[0])])


SIDE = 0.2
CUBE, ROD = Box((SIDE, SIDE, SIDE)), Capsule(0.05, SIDE)


@pytest.mark.parametrize(
    ("shape", "shift"),
    [(CUBE, (0.3, 0.05, 0.02)), (CUBE, (0.3, 0.3, 0.05)), (ROD, (0.3, 0.1, 0.05))],
    ids=["faces", "edges", "capsules"],
)
def test_what_is_parallel_up_to_rounding_is_not_unique(tmp_path, shape, shift):
    """Two bodies that are turned alike, face to face or edge along edge, whatever the turn rounds to."""
    path = tmp_path / "one.urdf"
    text = f'<box size="{SIDE} {SIDE} {SIDE}"/>' if shape is CUBE else f'<capsule radius="0.05" length="{SIDE}"/>'
    path.write_text(one_body_urdf(JOINTS["floating"], text))
    robot, rng = pc.Robot.from_urdf(path), np.random.default_rng(0)
    half = pin.AngleAxis(np.pi, np.array([1.0, 0.0, 0.0])).matrix()  # its axes are off by 1e-16
    for _ in range(30):
        quaternion = rng.normal(size=4)
        quaternion /= np.linalg.norm(quaternion)
        turn = pin.Quaternion(*quaternion[[3, 0, 1, 2]]).matrix()
        scene, pose = pc.Scene("box"), np.eye(4)
        pose[:3, :3], pose[:3, 3] = turn @ half, rng.normal(size=3)
        scene.add("box", shape, pose)
        table = pc.Checker(robot, scene).distances([*(pose[:3, 3] + turn @ shift), *quaternion], np.inf)
        assert not table.unique[0]
        assert table.gap[0] > 0.01
        rates = [table.directional(0, dq) for dq in (np.eye(6)[4], -np.eye(6)[4])]
        assert sum(rates) < -0.01  # it gets nearer by a turn either way


def test_the_limit_is_that_of_the_distance(tmp_path):
    """Spheres, whose filters leave no room."""
    slide = '<joint name="x" type="prismatic"><parent link="base"/><child link="body"/><axis xyz="1 0 0"/>'
    path = tmp_path / "slide.urdf"
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
    path.write_text(one_body_urdf(slide + limit, '<sphere radius="0.25"/>'))
    scene, pose = pc.Scene("ball"), np.eye(4)
    pose[0, 3] = 1.0
    scene.add("ball", Sphere(0.25), pose)
    checker = pc.Checker(pc.Robot.from_urdf(path), scene)
    q = np.linspace(0.4 - 2e-9, 0.4 + 2e-9, 41)[:, None]  # 10 cm apart in the middle
    table = checker.distances(q, 0.1)
    exact = 0.5 - q[:, 0]
    assert set(np.flatnonzero(exact < 0.1 - 1e-15)) <= set(table.state)
    assert set(table.state) <= set(np.flatnonzero(exact <= 0.1 + 1e-15))


def parallel_boxes(tmp_path):
    """A box that slides and turns over a larger one, face to face."""
    joints = (
        '<joint name="z" type="prismatic"><parent link="base"/><child link="lift"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint><link name="lift"/>'
        '<joint name="tilt" type="revolute"><parent link="lift"/><child link="body"/><axis xyz="0 1 0"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
    )
    path = tmp_path / "lift.urdf"
    path.write_text(one_body_urdf(joints, '<box size="0.2 0.2 0.2"/>'))
    scene, pose = pc.Scene("floor"), np.eye(4)
    pose[2, 3] = -0.5
    scene.add("floor", Box((1.0, 1.0, 1.0)), pose)
    return pc.Checker(pc.Robot.from_urdf(path), scene)


def test_parallel_faces_have_derivatives_along_directions_only(tmp_path):
    checker = parallel_boxes(tmp_path)
    flat = checker.distances([0.15, 0.0])
    assert not flat.unique[0]
    assert flat.gap[0] == np.inf
    for direction in ([0.0, 1.0], [0.0, -1.0], [1.0, 0.3]):
        found = flat.directional(0, direction)
        steps = [checker.clearance(np.array([0.15, 0.0]) + h * np.array(direction)) for h in (0, 1e-7)]
        assert found == pytest.approx((steps[1] - steps[0]) / 1e-7, abs=1e-6)
    tilted = checker.distances([0.15, 0.2])
    assert not tilted.unique[0]  # an edge over a face
    assert checker.distances([0.15, 0.2], np.inf).distance[0] == tilted.distance[0]


def test_nearest_pairs_are_the_first_ones_of_all(checker, states):
    everything = checker.distances(states[:30], np.inf, gradients=False)
    nearest = checker.distances(states[:30], nearest=3)
    for state in range(30):
        own, all_own = nearest.state == state, everything.state == state
        assert own.sum() == 3
        np.testing.assert_allclose(nearest.distance[own], everything.distance[all_own][:3], rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(checker.clearances(states[:30]), checker.distances(states[:30], nearest=1).distance)
    np.testing.assert_array_equal(checker.nearest_pair(states[:30]), checker.distances(states[:30], nearest=1).pair)


def test_padding_is_left_out(panda, checker, states):
    padded = pc.Checker(panda, checker.scene, padding=0.02)
    plain = {row[:2]: row[2] for row in rows_of(checker.distances(states))}
    for state, pair, distance in rows_of(padded.distances(states)):
        names = padded.pair_names(pair)
        (other,) = [
            k
            for k in range(len(checker.pairs))
            if checker.pair_names(k) == names and (state, k) in plain and abs(plain[state, k] - distance) < 1e-9
        ][:1]
        assert plain[state, other] == pytest.approx(distance, abs=1e-9)


def test_pinocchios_poses_give_the_same_rows_without_gradients(panda, checker, states):
    by_pinocchio = pc.Checker(panda, checker.scene, kinematics="pinocchio")
    table, other = checker.distances(states, gradients=False), by_pinocchio.distances(states, gradients=False)
    np.testing.assert_array_equal(table.pair, other.pair)
    np.testing.assert_allclose(table.distance, other.distance, atol=1e-9)
    with pytest.raises(pc.PlannercheckError, match="Pinocchio poses"):
        by_pinocchio.distances(states)


def test_moving_obstacles_are_measured_at_their_times(panda):
    scene, start, end = pc.Scene("moves"), np.eye(4), np.eye(4)
    start[:3, 3], end[:3, 3] = (0.6, 0.0, 0.5), (0.6, 1.0, 0.5)
    scene.add("ball", Sphere(0.1), pc.Moving([0.0, 10.0], [start, end]))
    moving, q = pc.Checker(panda, scene), panda.reference[None].repeat(3, axis=0)
    table = moving.distances(q, np.inf, times=[0.0, 5.0, 10.0])
    assert table.gradient.shape[1] == panda.nq
    for k, y in enumerate((0.0, 0.5, 1.0)):
        still, pose = pc.Scene("still"), start.copy()
        pose[1, 3] = y
        still.add("ball", Sphere(0.1), pose)
        alone = pc.Checker(panda, still).distances(q[:1], np.inf)
        # the ball is a pair with the base as well, which never moves in the other scene
        np.testing.assert_allclose(table.distance[table.state == k][:20], alone.distance[:20], atol=1e-12)
    with pytest.raises(pc.PlannercheckError, match="time= for one"):
        moving.distance_function(1.0)(q[0])
    distance, jacobian = moving.distance_function(1.0, time=5.0)(q[0])
    rows = (table.state == 1) & (table.distance < 1.0)
    np.testing.assert_array_equal(distance[table.pair[rows]], table.distance[rows])
    np.testing.assert_array_equal(jacobian[table.pair[rows]], table.gradient[rows])
    along = pc.distances_along(moving, pc.Trajectory([0.0, 1.0], q[:2]), at=[0.0, 1.0], limit=np.inf, start_time=5.0)
    assert along.distance.min() == pytest.approx(table.distance[table.state == 1].min(), abs=0.11)


def test_a_function_for_optimisers_has_a_row_for_each_pair(checker, states):
    f = checker.distance_function(0.2)
    distance, jacobian = f(states[0])
    table = checker.distances(states[:1], 0.2)
    assert distance.shape == (len(checker.pairs),)
    np.testing.assert_array_equal(distance[table.pair], table.distance)
    np.testing.assert_array_equal(jacobian[table.pair], table.gradient)
    assert (np.delete(distance, table.pair) == 0.2).all()
    assert not np.delete(jacobian, table.pair, axis=0).any()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"limit": 0}, "limit must be positive"),
        ({"limit": -1.0}, "limit must be positive"),
        ({"limit": float("nan")}, "limit must be positive"),
        ({"limit": "near"}, "limit must be positive"),
        ({"limit": None}, "limit must be positive"),
        ({"limit": np.array([0.1, 0.2])}, "limit must be positive"),
        ({"nearest": 0}, "nearest must be"),
        ({"nearest": True}, "nearest must be"),
        ({"threads": 0}, "threads must be"),
        ({"start": 0.5}, "start must be this checker's table of 1 configurations"),
    ],
)
def test_bad_arguments_are_named(checker, states, arguments, message):
    with pytest.raises(pc.PlannercheckError, match=message):
        checker.distances(states[:1], **arguments)
    if "limit" in arguments:
        with pytest.raises(pc.PlannercheckError, match=message):
            checker.distance_function(**arguments)


@pytest.mark.parametrize(
    ("at", "start_time", "message"),
    [("soon", 0.0, "at must be"), ([[0.0, 1.0]], 0.0, "at must be instants"), (0.5, None, "start_time must be")],
)
def test_instants_that_are_none_are_named(checker, at, start_time, message):
    still = pc.Trajectory([0.0, 1.0], np.stack([checker.robot.reference] * 2), controller="linear")
    with pytest.raises(pc.PlannercheckError, match=message):
        pc.distances_along(checker, still, at, start_time=start_time)


def test_earlier_rows_are_of_as_many_configurations(panda, checker, states):
    with pytest.raises(pc.PlannercheckError, match="start must be this checker's table of 1 configurations"):
        checker.distances(states[:1], start=checker.distances(states))
    with pytest.raises(pc.PlannercheckError, match="start must be this checker's table"):
        pc.Checker(panda).distances(states[:1], start=checker.distances(states[:1], np.inf))
    for edit in ("another name", "another place in the order"):
        scene = pc.Scene()
        names = [item.name for item in checker.scene.objects]
        names[:2] = ["else", names[1]] if edit == "another name" else reversed(names[:2])
        for name, item in zip(names, checker.scene.objects, strict=True):
            scene.add(name, item.parts, item.pose)
        other = pc.Checker(panda, scene)
        assert len(other.pairs) == len(checker.pairs)
        with pytest.raises(pc.PlannercheckError, match="start must be this checker's table"):
            other.distances(states[:1], start=checker.distances(states[:1]))
    again = pc.Checker(panda, checker.scene)
    assert len(again.distances(states[:1], np.inf, start=checker.distances(states[:1]))) == len(checker.pairs)
    slow = pc.Checker(panda, checker.scene, kinematics="pinocchio")
    with pytest.raises(pc.PlannercheckError, match="start needs the compiled kinematics"):
        slow.distances(states[:1], gradients=False, start=checker.distances(states[:1]))


def test_so_many_nearest_pairs_as_there_are(checker, states):
    table = checker.distances(states[:1], nearest=10**30)
    assert np.array_equal(np.sort(table.pair), np.arange(len(checker.pairs)))


def test_directions_are_checked(tmp_path, checker, states):
    table = checker.distances(states)
    with pytest.raises(pc.PlannercheckError, match="7 finite numbers"):
        table.directional(0, [1.0])
    for row in (len(table.distance), -1, None, slice(0, 1)):
        with pytest.raises(pc.PlannercheckError, match="row must be one of"):
            table.directional(row, np.ones(7))
    with pytest.raises(pc.PlannercheckError, match="dq must be numbers"):
        table.directional(0, "forward")
    with pytest.raises(pc.PlannercheckError, match="overlap"):
        parallel_boxes(tmp_path).distances([0.05, 0.0]).directional(0, np.ones(2))
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(table)).gradient, table.gradient)
    with pytest.raises(pc.PlannercheckError, match="no gradients, or comes from a pickle"):
        checker.distances(states, gradients=False).directional(0, np.ones(7))
