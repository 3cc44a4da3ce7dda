"""Pairs that are said never to meet within the limits: held against the full computation, also beyond the limits."""

import itertools

import numpy as np
import pytest
from poses import at

import plannercheck as pc
from plannercheck.bodies.shapes import inflated_hull
from plannercheck.checking.reach_bounds import Chains
from plannercheck.checking.unreachable_pairs import unreachable_pairs
from plannercheck.common.package_data import example_robot_data
from plannercheck.robots.description import find_description, read_description

ROBOTS = {"panda": "bookshelf", "ur5": "kitchen", "baxter": "kitchen", "talos": "table", "tiago": "kitchen"}

# A carriage on a rail, which carries a turning arm, and a follower that mimics the carriage twice as far.
MACHINE = """<robot name="machine"><link name="rail"/>
<link name="carriage"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
<link name="arm"><collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.1 0.1"/></geometry></collision></link>
<link name="tip"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
<link name="follower"><collision><geometry><box size="1e-3 1e-3 1e-3"/></geometry></collision></link>
<joint name="slide" type="prismatic"><parent link="rail"/><child link="carriage"/><axis xyz="1 0 0"/>
<limit lower="{lower}" upper="{upper}" effort="1" velocity="1"/></joint>
<joint name="turn" type="{turn}"><parent link="carriage"/><child link="arm"/><origin xyz="0 0 1"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="bend" type="revolute"><parent link="arm"/><child link="tip"/><origin xyz="1.2 0 0"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="follow" type="prismatic"><parent link="rail"/><child link="follower"/><origin xyz="0 3 0"/>
<axis xyz="1 0 0"/><limit lower="-9" upper="9" effort="1" velocity="1"/><mimic joint="slide" multiplier="2"/></joint>
</robot>"""


@pytest.fixture(scope="module")
def robots():
    loaded = {name: pc.Robot.load(name) for name in ROBOTS}
    description = read_description(find_description("talos"))
    loaded["whole talos"] = pc.Robot.from_urdf(description.urdf, description.srdf, package_dirs=example_robot_data())
    return loaded


@pytest.fixture
def machine(tmp_path):
    def build(lower=-1.0, upper=1.0, turn="revolute", group=("slide", "turn", "bend")):
        path = tmp_path / "machine.urdf"
        path.write_text(MACHINE.format(lower=lower, upper=upper, turn=turn))
        return pc.Robot.from_urdf(path, group=group)

    return build


def crate(x, y, z=1.0, size=0.2):
    """A cube about a point."""
    scene = pc.Scene("crate")
    pose = at(x, y, z)
    scene.add_box("crate", [size, size, size], pose)
    return scene


def names_of_unreachable(checker):
    return {checker.pair_names(k) for k in np.flatnonzero(checker.unreachable)}


def mixed_states(robot, n, seed):
    """Configurations within the limits, and every third beyond some."""
    q = robot.random_configurations(n, seed)
    rng = np.random.default_rng(seed)
    q[::3] += rng.normal(0, 2, q[::3].shape) * (rng.uniform(size=q[::3].shape) < 0.3)
    return q


@pytest.mark.parametrize("name", [*ROBOTS, "whole talos"])
def test_verdicts_are_those_of_the_full_table(robots, name):
    robot, scene = robots[name], pc.Scene.load(ROBOTS.get(name, "empty"))
    checker, full = pc.Checker(robot, scene), pc.Checker(robot, scene, tuning=pc.Tuning(reach=False))
    assert checker.unreachable.any()
    assert not full.unreachable.any()
    q = mixed_states(robot, 600, 5)
    beyond = ((q < robot.lower) | (q > robot.upper)).any(axis=1)
    assert 20 < beyond.sum() < 300
    first = full.first_colliding_pair(q)
    np.testing.assert_array_equal(checker.first_colliding_pair(q), first)
    np.testing.assert_array_equal(checker.check_states(q, threads=2), first < 0)
    assert [checker.is_valid(row) for row in q[:60]] == (first[:60] < 0).tolist()
    assert not full.colliding_pairs(q[~beyond])[:, checker.unreachable].any()


@pytest.mark.parametrize("name", ROBOTS)
def test_motions_are_those_of_the_full_table(robots, name):
    robot, scene = robots[name], pc.Scene.load(ROBOTS[name])
    q = mixed_states(robot, 24, 6)
    ends = q + np.random.default_rng(7).normal(0, 0.1, q.shape)
    found, truth = (
        pc.Checker(robot, scene, tuning=pc.Tuning(reach=on)).check_motions(q, ends, 0.02) for on in (True, False)
    )
    np.testing.assert_array_equal(found, truth)


@pytest.mark.parametrize("name", [*ROBOTS, "whole talos"])
def test_frames_are_those_of_the_bodies(robots, name):
    robot = robots[name]
    hulls = [inflated_hull(body.shape) for body in robot.bodies]
    chains = Chains(robot, robot.joint_table, robot.bodies, hulls)
    assert chains.is_proved()
    q = robot.random_configurations(5, 1)
    first = 2 * len(robot.joint_table.kinds)
    links = robot.link_poses(q)
    frames = chains.poses(q, range(first, first + len(robot.bodies)))
    for k, body in enumerate(robot.bodies):
        truth = links[:, robot.link_index(body.link)] @ body.pose
        np.testing.assert_allclose(frames[:, first + k], truth, atol=1e-12)


@pytest.mark.parametrize("name", ["ur5", "tiago", "whole talos"])
def test_ends_hold_their_bodies_and_levers_bound_their_ways(robots, name):
    """Whatever the columns that are not cut: the body stays in the ball, and its levers bound the centre's way."""
    robot = robots[name]
    hulls = [inflated_hull(body.shape) for body in robot.bodies]
    chains = Chains(robot, robot.joint_table, robot.bodies, hulls)
    q = robot.random_configurations(40, 2)
    links = robot.link_poses(q)
    rng = np.random.default_rng(3)
    for body in rng.choice(len(robot.bodies), 6, replace=False).tolist():
        chain = chains.chain(body)
        columns = chains.columns(chain)
        for cut in [tuple(columns[:count]) for count in range(len(columns) + 1)]:
            end = chains.end(body, chain, cut)
            centre = chains.poses(q, [end.frame])[:, end.frame, :3] @ np.append(end.centre, 1.0)
            points, _, inflation_radius = hulls[body]
            placed = links[:, robot.link_index(robot.bodies[body].link)] @ robot.bodies[body].pose
            world = np.einsum("nij,kj->nki", placed[:, :3, :3], points) + placed[:, None, :3, 3]
            assert np.linalg.norm(world - centre[:, None], axis=2).max() + inflation_radius <= end.radius + 1e-12
            for column in cut:
                moved = q.copy()
                moved[:, column] = rng.permutation(q[:, column])
                other = chains.poses(moved, [end.frame])[:, end.frame, :3] @ np.append(end.centre, 1.0)
                way = np.linalg.norm(other - centre, axis=1)
                assert (way <= end.levers[column] * np.abs(moved - q)[:, column] + 1e-12).all()


def test_a_pair_that_meets_only_beyond_the_limits_is_found_there(machine):
    robot = machine()
    checker = pc.Checker(robot, crate(1.5, 0.0, 0.0))
    assert ("carriage", "crate") in names_of_unreachable(checker)
    within, beyond = np.array([1.0, 0, 0]), np.array([1.4, 0, 0])
    assert checker.check_states([within, beyond, within]).tolist() == [True, False, True]
    assert checker.check_states([beyond]).tolist() == [False]
    assert checker.is_valid(within)
    assert not checker.is_valid(beyond)
    assert not checker.check_motion(within, beyond)
    for ends in ((within, beyond), (beyond, within)):
        assert not checker.check_motion(*ends, 0.01)
    assert checker.check_motion(-within, within, 0.01)
    k = int(checker.first_colliding_pair([within, beyond])[1])
    assert checker.pair_names(k) == ("carriage", "crate")
    assert not checker.explain(beyond).valid


@pytest.mark.parametrize(("upper", "apart"), [(1.0, True), (1.2, True), (1.31, False), (3.0, False)])
def test_the_limit_decides(machine, upper, apart):
    """The crate begins at 1.4, the carriage ends 0.1 beyond its origin: they touch from 1.3 on.

    The proof takes a ball of 0.174 for the carriage, so nothing is asked of limits from 1.21 to 1.3.
    """
    scene = crate(1.5, 0.0, 0.0)
    scene.add_box("far", [0.1, 0.1, 0.1], np.array([[1.0, 0, 0, 0], [0, 1, 0, 50], [0, 0, 1, 0], [0, 0, 0, 1]]))
    for padding in (0.0, {("carriage", "far"): 1e-3}):  # with one of a pair's own, all is proved the plain way
        checker = pc.Checker(machine(upper=upper), scene, padding=padding)
        assert (("carriage", "crate") in names_of_unreachable(checker)) == apart
    q = np.column_stack([np.linspace(-1, upper, 400), np.zeros((400, 2))])
    assert checker.check_states(q).all() == apart


@pytest.mark.parametrize(("lower", "upper"), [(-1.0, 0.5), (-0.5, 1.0)])
def test_limits_need_not_be_symmetric(machine, lower, upper):
    """A crate where the carriage gets on one side only."""
    for x in (-1.05, 1.05):
        checker = pc.Checker(machine(lower, upper), crate(x, 0.0, 0.0))
        assert (("carriage", "crate") in names_of_unreachable(checker)) == (not lower - 0.2 <= x <= upper + 0.2)


def test_mimics_are_followed(machine):
    """The follower, of 1 mm, goes twice as far as its leader: to 2 m. No ball's slack hides what half a cell is."""
    for x, apart in ((1.9, False), (2.0, False), (2.01, True)):
        checker = pc.Checker(machine(), crate(x, 3.0, 0.0, size=1e-3))
        assert (("follower", "crate") in names_of_unreachable(checker)) == apart
    still = pc.Checker(machine(group=("turn", "bend")), crate(0.0, 3.3, 0.0))
    assert ("follower", "crate") in names_of_unreachable(still)


def test_held_joints_make_resting_pairs(machine):
    robot = machine(group=("turn", "bend"))
    near = pc.Checker(robot, crate(0.15, 0.0, 0.0))
    k = [near.pair_names(k) for k in range(len(near.pairs))].index(("carriage", "crate"))
    assert near.static[k]
    assert not near.unreachable[k]  # it collides always
    assert not near.check_states(robot.random_configurations(20, 1)).any()
    far = pc.Checker(robot, crate(0.21, 0.0, 0.0))
    assert far.static[k]
    assert far.unreachable[k]


def test_joints_without_limits_are_turned_all_around(machine):
    """A continuous joint is not cut; its arm may be anywhere within 1.25 m (and 0.05 m at its end)."""
    for x, apart in ((-2.0, False), (-2.5, True)):
        checker = pc.Checker(machine(turn="continuous"), crate(x, 0.0))
        assert (("tip", "crate") in names_of_unreachable(checker)) == apart


def test_nothing_is_said_where_nothing_is_proved(robots):
    description = read_description(find_description("ur5"))
    floating = pc.Robot.from_urdf(description.urdf, package_dirs=example_robot_data(), floating=True)
    assert not pc.Checker(floating, pc.Scene.load("kitchen")).unreachable.any()
    assert not pc.Checker(robots["ur5"], pc.Scene.load("kitchen"), kinematics="pinocchio").unreachable.any()
    assert not unreachable_pairs(robots["ur5"], robots["ur5"].bodies, np.zeros((0, 2), dtype=np.int32), []).is_proved


def test_states_within_the_limits_take_the_live_pairs_alone(robots):
    checker = pc.Checker(robots["baxter"], pc.Scene.load("kitchen"))
    prepared = sum(polytope is not None for polytope in checker.prepared)
    checker.check_states(checker.robot.random_configurations(50, 1))
    counted = checker.statistics()
    assert counted["unreachable"] == 50 * checker.unreachable.sum()
    assert counted["pairs"] == 50 * len(checker.pairs)
    assert sum(polytope is not None for polytope in checker.prepared) == prepared
    checker.check_states(checker.robot.upper[None] + 0.1)
    assert checker.statistics()["unreachable"] == counted["unreachable"]
    assert checker.statistics()["pairs"] == 51 * len(checker.pairs)
    assert sum(polytope is not None for polytope in checker.polytopes) >= prepared


@pytest.mark.parametrize("group", [None, ("turn",), ("turn", "bend")])  # limits are compared two at a time
def test_one_step_of_a_double_beyond_a_limit_is_beyond(machine, group):
    """Counted by the pairs that are left out: none is beyond the limits, in a batch of any size or alone."""
    robot = machine() if group is None else machine(group=group)
    checker = pc.Checker(robot, crate(1.5, 0.0, 0.0))
    left_out = int(checker.unreachable.sum())
    assert left_out
    judge = checker.state_validity()
    for column in range(robot.nq):
        for limit, outwards in ((robot.lower, -np.inf), (robot.upper, np.inf)):
            at_limit = np.zeros(robot.nq)
            at_limit[column] = limit[column]
            beyond = at_limit.copy()
            beyond[column] = np.nextafter(limit[column], outwards)
            for q, expected in ((at_limit, left_out), (beyond, 0)):
                for ask in (checker.is_valid, lambda q: checker.check_states(q[None]), lambda q: judge(State(*q))):
                    before = checker.statistics()["unreachable"]
                    ask(q)
                    assert checker.statistics()["unreachable"] - before == expected
            mixed = np.array([at_limit, beyond] * 9)
            before = checker.statistics()["unreachable"]
            checker.check_states(mixed)
            assert checker.statistics()["unreachable"] - before == 9 * left_out
            for row in (0, 7, 8, 15, 16, 18):  # in lanes, and behind the last full ones
                one_beyond = np.tile(at_limit, (19, 1))
                one_beyond[row] = beyond
                before = checker.statistics()["unreachable"]
                checker.check_states(one_beyond)
                assert checker.statistics()["unreachable"] - before == 18 * left_out


class State:
    """As OMPL's states are read."""

    def __init__(self, *values):
        self.values = [float(value) for value in values]

    def __getitem__(self, part):
        return self.values[part]


def test_planners_states_beyond_the_limits_are_judged_with_all_pairs(machine):
    judge = pc.Checker(machine(), crate(1.5, 0.0, 0.0)).state_validity()
    assert judge is not None
    assert judge(State(1.0, 0.0, 0.0))
    assert not judge(State(1.4, 0.0, 0.0))


@pytest.mark.parametrize("padding", [0.0, {("dot", "far"): 1e-3}], ids=["cells", "plainly"])
def test_stretched_obstacles_touch_where_they_are(tmp_path, padding):
    """A pose may stretch by 1e-6: of a box of 2 km that is 0.5 mm, more than what the carriage's way leaves.

    Where a pair has a padding of its own, all is proved the plain way.
    """
    path = tmp_path / "small.urdf"
    path.write_text(
        """<robot name="small"><link name="rail"/>
<link name="dot"><collision><geometry><box size="1e-5 1e-5 1e-5"/></geometry></collision></link>
<joint name="slide" type="prismatic"><parent link="rail"/><child link="dot"/><axis xyz="0 1 0"/>
<limit lower="-1e-5" upper="1e-5" effort="1" velocity="1"/></joint></robot>"""
    )
    robot = pc.Robot.from_urdf(path)
    for side in (-1, 1):
        scene, pose = pc.Scene("wall"), np.eye(4)
        pose[0, 0] = 1 + 4.9e-7
        pose[0, 3] = side * (1000 * pose[0, 0])
        scene.add_box("wall", [2000, 1, 1], pose)
        scene.add_box("far", [1, 1, 1], np.array([[1.0, 0, 0, 0], [0, 1, 0, 50], [0, 0, 1, 0], [0, 0, 0, 1]]))
        checker = pc.Checker(robot, scene, padding=padding)
        assert not checker.check_states([[0.0]])[0]
        assert ("dot", "wall") not in names_of_unreachable(checker)


def test_what_a_short_chain_carries_is_looked_at_anew(machine):
    """All columns that move the carriage can be cut: where its tool's middle gets is known, and of this tool alone."""
    robot, scene = machine(), pc.Scene("crates")
    for k, (x, y) in enumerate(itertools.product((-3, -1, 0, 1, 3), (-1, 0, 1))):
        pose = at(x, y, 0.5)
        scene.add_box(f"crate{k}", [0.1, 0.1, 0.1], pose)
    checker = pc.Checker(robot, scene)
    for place in ((0, 1, 0.5), (0, -1, 0.5), (2, 0, 0.5), (0, 0, 5.0)):
        pose = at(*place)
        scene.attach("tool", "carriage", pose, (), pc.Box([0.05, 0.05, 0.05]))
        checker = checker.with_scene(scene)
        np.testing.assert_array_equal(checker.unreachable, pc.Checker(robot, scene).unreachable)
        scene.remove("tool")


def test_pairs_that_one_of_two_cuts_settles(tmp_path):
    """Found by the stress of motions: nothing was left for the second cut, which failed."""
    link = (
        '<link name="{0}"><collision><origin xyz="{1} 0 0"/><geometry><sphere radius="0.05"/></geometry></collision>'
        "</link>"
    )
    joint = (
        '<joint name="j{0}" type="revolute"><parent link="base"/><child link="{0}"/><origin xyz="{1} 0 0"/>'
        '<axis xyz="0 0 1"/><limit lower="-0.3" upper="0.3" effort="1" velocity="1"/></joint>'
    )
    parts = [link.format("a", -1), link.format("b", 1), joint.format("a", 0), joint.format("b", 1.8)]
    urdf = tmp_path / "arms.urdf"
    urdf.write_text(f'<robot name="arms"><link name="base"/>{"".join(parts)}</robot>')
    checker = pc.Checker(pc.Robot.from_urdf(urdf))
    assert len(checker.pairs) == 1
    assert checker.unreachable.all()
