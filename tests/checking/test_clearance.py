"""Clearances of configurations and padding, against distances pair by pair."""

import numpy as np
import pytest
from poses import at

import plannercheck as pc
from plannercheck.bodies.shapes import Box, Capsule, Sphere
from plannercheck.bodies.tuning import core_tuning
from plannercheck.common.core import core

EYE = np.eye(4)


@pytest.fixture(scope="module")
def scene():
    scene = pc.Scene("some")
    scene.add_box("shelf", (0.2, 0.8, 0.5), at(0.75, 0, 0.4))
    scene.add_sphere("ball", 0.12, at(0.1, 0.6, 0.7))
    scene.add_cylinder("pole", 0.05, 1.5, at(-0.5, -0.3, 0.75))
    return scene


@pytest.fixture(scope="module")
def samples(panda):
    return panda.random_configurations(40, seed=3)


def pair_clearances(checker, q):
    """Signed distances (pairs,) of one configuration, one call a pair; the checker has no padding."""
    poses = checker.body_poses(q)[0] if np.ndim(q) > 1 else checker.body_poses(q[None])[0]
    out = []
    for a, b in checker.pairs.tolist():
        found = pc.distance(checker.polytopes[a], checker.polytopes[b], poses[a], poses[b])
        out.append(found.distance if found.distance > 0 else found.lower_bound)
    return np.array(out)


def test_clearance_is_the_least_distance(panda, scene, samples):
    checker = pc.Checker(panda, scene)
    found = checker.clearances(samples)
    bounds = checker.clearances(samples, lower_bound=True)
    valid = checker.check_states(samples)
    assert valid.any()
    assert not valid.all()
    np.testing.assert_array_equal(found > 0, valid)
    assert (bounds <= found + 1e-12).all()
    assert (bounds[valid] > 0).any()
    for k, q in enumerate(samples):
        each = pair_clearances(checker, q)
        if valid[k]:
            assert found[k] == pytest.approx(each.min(), rel=1e-8, abs=1e-12)
        else:
            assert found[k] <= 0
            assert found[k] == pytest.approx(each.min(), abs=1e-9)
    assert checker.clearance(samples[0]) == found[0]
    assert checker.nearest_pair(samples).min() >= 0


def test_without_pairs_there_is_no_end(panda):
    checker = pc.Checker(panda, self_collision=False)
    assert checker.clearance(panda.reference) == np.inf
    assert checker.nearest_pair(panda.reference[None])[0] == -1


@pytest.mark.parametrize("padding", [0.003, 0.02])
def test_padding_is_exact(panda, scene, samples, padding):
    """Valid if and only if every distance exceeds the padding, self-collision included."""
    plain, padded = pc.Checker(panda, scene), pc.Checker(panda, scene, padding=padding)
    truth = np.array([pair_clearances(plain, q).min() > padding for q in samples])
    np.testing.assert_array_equal(padded.check_states(samples), truth)
    assert truth.any()
    assert (plain.check_states(samples) & ~truth).any()
    np.testing.assert_array_equal([padded.is_valid(q) for q in samples], truth)
    np.testing.assert_array_equal(~padded.colliding_pairs(samples).any(axis=1), truth)
    unbounded = pc.Checker(
        panda, scene, padding=padding, tuning=pc.Tuning(bounds=False, boxes=False, reach=False, method="exact")
    )
    np.testing.assert_array_equal(unbounded.check_states(samples), truth)


def test_clearance_leaves_padding_out(panda, scene, samples):
    plain, padded = pc.Checker(panda, scene), pc.Checker(panda, scene, padding=0.05)
    free = plain.check_states(samples)
    np.testing.assert_allclose(padded.clearances(samples)[free], plain.clearances(samples)[free], rtol=1e-8, atol=1e-12)


def test_padding_at_the_distance_itself():
    """A distance that equals the padding counts as a collision: exactly, to the last bit."""
    cube = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    for padding in (0.25, 0.1, 1e-3):
        halves = [pc.Polytope(cube, inflation_radius=padding / 2) for _ in range(2)]
        gap = 1.0 + 0.25
        touching = pc.intersects(*halves, at(gap))
        assert touching == (padding >= 0.25)
        assert not pc.intersects(*halves, at(np.nextafter(gap, 2)))


LOLLIPOP = """<robot name="lollipop"><link name="rail"/>
<link name="tip"><collision>{pose}<geometry>{shape}</geometry></collision>
<collision><origin xyz="0 0 5"/><geometry><box size="0.5 0.5 0.5"/></geometry></collision></link>
<joint name="slide" type="prismatic"><parent link="rail"/><child link="tip"/><axis xyz="1 0 0"/>
<limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>"""


ROUND = {"ball": Sphere(0.25), "capsule": Capsule(0.25, 0.5), "box": Box((0.5, 0.5, 0.5))}


@pytest.mark.parametrize("own", ["ball", "capsule"])
@pytest.mark.parametrize("other", list(ROUND))
def test_padding_adds_to_the_radius_of_a_ball_or_capsule(tmp_path, own, other):
    """All numbers are dyadic: the bodies keep the padding exactly, from either side, also where it is the smaller."""
    path = tmp_path / "lollipop.urdf"
    path.write_text(LOLLIPOP.format(shape='<box size="0.25 0.25 0.25"/>', pose='<origin xyz="0 0 9"/>'))
    robot = pc.Robot.from_urdf(path)
    scene = pc.Scene("other")
    scene.add("other", ROUND[other], at(2))
    scene.attach("tip's", "tip", at(0), (), ROUND[own])
    for padding in (0.125, 0.5, {"other": 0.125}, {"tip's": 0.5}, {("tip's", "other"): 0.25}):
        checker = pc.Checker(robot, scene, padding=padding)
        room = padding if isinstance(padding, float) else next(iter(padding.values()))
        contact = 1.5 - room
        q = np.array([[np.nextafter(contact, 0)], [contact], [contact + 0.01]])
        assert checker.check_states(q).tolist() == [True, False, False]
        assert [checker.is_valid(row) for row in q] == [True, False, False]


def test_a_body_of_a_link_has_a_padding_of_its_own(tmp_path):
    """The link's second body stands 5 m above the first; a part by the body's name counts instead of the link's."""
    path = tmp_path / "lollipop.urdf"
    path.write_text(LOLLIPOP.format(shape='<sphere radius="0.25"/>', pose=""))
    robot = pc.Robot.from_urdf(path)
    names = [body.name for body in robot.bodies]
    assert len(names) == 2
    scene = pc.Scene("two")
    scene.add_box("low", (0.5, 0.5, 0.5), at(2))
    scene.add_box("high", (0.5, 0.5, 0.5), at(2, 0, 5))
    for padding, parts in (
        ({names[1]: 0.5}, [0.0, 0.5, 0.0, 0.0]),
        ({names[0]: 0.25, "tip": 0.125}, [0.25, 0.125, 0.0, 0.0]),
        ({"tip": 0.125, names[1]: 0.0}, [0.125, 0.0, 0.0, 0.0]),
    ):
        checker = pc.Checker(robot, scene, padding=padding)
        np.testing.assert_array_equal(checker.paddings, parts)
        contact = 1.5 - max(parts)
        assert checker.is_valid([np.nextafter(contact, 0)])
        assert not checker.is_valid([contact])


def test_a_name_of_two_bodies_is_no_name_of_a_padding(tmp_path):
    path = tmp_path / "lollipop.urdf"
    path.write_text(LOLLIPOP.format(shape='<sphere radius="0.25"/>', pose=""))
    robot, scene = pc.Robot.from_urdf(path), pc.Scene()
    scene.add_sphere(robot.bodies[0].name, 0.1, at(2))
    pc.Checker(robot, scene, padding={"tip": 0.1})
    for padding in ({robot.bodies[0].name: 0.1}, {("tip", robot.bodies[0].name): 0.1}):
        with pytest.raises(pc.PlannercheckError, match="would count twice, for it and for a body of 'tip'"):
            pc.Checker(robot, scene, padding=padding)


def test_padding_by_name(panda, scene, samples):
    by_name = pc.Checker(panda, scene, padding={"shelf": 0.03, "panda_hand": 0.01})
    plain = pc.Checker(panda, scene)
    for q in samples[:15]:
        each = pair_clearances(plain, q)
        names = [plain.pair_names(k) for k in range(len(plain.pairs))]
        room = np.array([0.03 * ("shelf" in pair) + 0.01 * ("panda_hand" in pair) for pair in names])
        assert by_name.is_valid(q) == bool((each > room).all())


def required(names, padding):
    """What a pair of labels has to keep."""
    whole = [length for pair, length in padding.items() if isinstance(pair, tuple) and sorted(pair) == sorted(names)]
    return whole[-1] if whole else sum(padding.get(name, 0.0) for name in names)


def test_padding_of_pairs(panda, scene, samples):
    """Obstacles and links; a pair's own distance counts instead of the parts, also where it is less."""
    padding = {
        "panda_hand": 0.04,
        "shelf": 0.01,
        ("shelf", "panda_hand"): 0.002,
        ("panda_link5", "shelf"): 0.06,
        ("panda_link7", "panda_link1"): 0.1,
        ("panda_hand", "panda_link2"): 0.0,
        ("panda_link3", "ball"): 0.07,
    }
    plain, padded = pc.Checker(panda, scene), pc.Checker(panda, scene, padding=padding)
    assert len(padded.bodies) > len(plain.bodies)
    rooms = np.array([required(plain.pair_names(k), padding) for k in range(len(plain.pairs))])
    assert {0.002, 0.06, 0.1, 0.07, 0.04, 0.01} <= set(rooms.tolist())
    np.testing.assert_array_equal(padded.paddings[padded.pairs].sum(axis=1), rooms)
    distances = np.array([pair_clearances(plain, q) for q in samples])
    np.testing.assert_array_equal(padded.colliding_pairs(samples), distances <= rooms)
    np.testing.assert_array_equal(padded.check_states(samples), (distances > rooms).all(axis=1))
    assert (plain.check_states(samples) & ~padded.check_states(samples)).any()
    free = plain.check_states(samples)
    np.testing.assert_allclose(padded.clearances(samples)[free], plain.clearances(samples)[free], rtol=1e-8, atol=1e-12)
    whole = pc.Checker(panda, scene, padding=padding, tuning=pc.Tuning(reach=False))
    np.testing.assert_array_equal(whole.check_states(samples), padded.check_states(samples))
    np.testing.assert_array_equal(
        whole.check_motions(samples[:-1], samples[1:]), padded.check_motions(samples[:-1], samples[1:])
    )
    assert [padded.pair_names(k) for k in range(len(padded.pairs))] == [
        plain.pair_names(k) for k in range(len(plain.pairs))
    ]


def test_of_several_pairs_that_fit_the_last_counts(panda, scene):
    padding = {("panda_hand", "shelf"): 0.1, ("panda_hand", "pole"): 0.05, ("shelf", "panda_hand"): 0.2}
    checker = pc.Checker(panda, scene, padding=padding)
    kept = {checker.pair_names(k): checker.paddings[pair].sum() for k, pair in enumerate(checker.pairs)}
    assert kept["panda_hand", "shelf"] == 0.2
    assert kept["panda_hand", "pole"] == 0.05
    assert kept["panda_hand", "ball"] == 0


@pytest.mark.parametrize(
    ("pair", "message"),
    [
        (("panda_hand", "no such"), "no such"),
        (("panda_link1", "panda_link2"), "is tested"),
        (("panda_hand",), "pair of names"),
        (3, "pair of names"),
    ],
)
def test_padding_of_pairs_has_to_name_pairs(panda, scene, pair, message):
    with pytest.raises(pc.PlannercheckError, match=message):
        pc.Checker(panda, scene, padding={pair: 0.01})


def test_reach_keeps_padding(panda, scene):
    """What limits keep apart by less than the padding is tested."""
    plain, padded = pc.Checker(panda, scene), pc.Checker(panda, scene, padding=0.3)
    assert (padded.unreachable <= plain.unreachable).all()
    assert padded.unreachable.sum() < plain.unreachable.sum()


def test_motions_keep_padding(panda, scene, samples):
    """A motion proved free with padding has no state within it; one that has is refused."""
    plain, padded = pc.Checker(panda, scene), pc.Checker(panda, scene, padding=0.02)
    good = samples[padded.check_states(samples)]
    starts = np.repeat(good[:-1], 2, axis=0)
    ends = starts + np.tile([0.1, 1.0], len(good) - 1)[:, None] * np.repeat(good[1:] - good[:-1], 2, axis=0)
    free = padded.check_motions(starts, ends)
    assert free.any()
    assert not free.all()
    t = np.linspace(0, 1, 200)[:, None]
    for q0, q1, passed in zip(starts, ends, free, strict=True):
        least = plain.clearances((1 - t) * q0 + t * q1).min()
        if passed:
            assert least > 0.02
        elif least > 0.03:
            raise AssertionError("a motion far from everything is refused")


@pytest.mark.parametrize("padding", [-0.01, np.nan, np.inf, True, "1 cm", {"shelf": -1.0}, {"no such": 0.1}])
def test_padding_has_to_be_a_length(panda, scene, padding):
    with pytest.raises(pc.PlannercheckError, match="padd"):
        pc.Checker(panda, scene, padding=padding)


def test_ompl_maximises_the_least_clearance(panda, scene):
    geometric = pytest.importorskip("ompl.geometric")
    checker = pc.Checker(panda, scene)
    setup = pc.ompl.setup(checker)
    objective = pc.ompl.clearance_objective(checker, setup)
    space = setup.getStateSpace()
    a, b = space.allocState(), space.allocState()
    q0, q1 = panda.reference, panda.reference + 0.1
    for state, q in ((a, q0), (b, q1)):
        for k, value in enumerate(q):
            state[k] = float(value)
    judge = setup.getSpaceInformation().getStateValidityChecker()
    assert judge.clearance(a) == checker.clearance(q0)
    path = geometric.PathGeometric(setup.getSpaceInformation(), a, b)
    assert path.clearance() == pytest.approx(checker.clearances(np.array([q0, q1])).mean())  # OMPL's own, in C++
    assert objective.stateCost(a).value() == pytest.approx(-checker.clearance(q0))
    t = np.linspace(0, 1, 30)[:, None]
    fine = checker.clearances((1 - t) * q0 + t * q1).min()
    assert objective.motionCost(a, b).value() == pytest.approx(-fine, abs=5e-3)


def test_a_motion_costs_its_least_clearance_and_a_path_its_costliest_part(tmp_path):
    """A ball that passes a post half-way: the ends are 1 m from it, the middle 0.25 m; a joint turns the short way."""
    path = tmp_path / "ball.urdf"
    path.write_text(
        """<robot name="ball"><link name="base"/><link name="arm"/>
<link name="ball"><collision><geometry><sphere radius="0.25"/></geometry></collision></link>
<joint name="turn" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint>
<joint name="slide" type="prismatic"><parent link="arm"/><child link="ball"/><axis xyz="1 0 0"/>
<limit lower="0.5" upper="9" effort="1" velocity="1"/></joint></robot>"""
    )
    scene = pc.Scene("post")
    scene.add_sphere("post", 0.25, at(-3))
    checker = pc.Checker(pc.Robot.from_urdf(path, group=["turn", "slide"]), scene)
    setup = pc.ompl.setup(checker)
    objective = pc.ompl.clearance_objective(checker, setup)
    space, information = pc.ompl.space_of(checker), setup.getSpaceInformation()

    def cost(q0, q1):
        a, b = (space.state(information, np.array(q)) for q in (q0, q1))
        return objective.motionCost(a, b).value()

    assert cost((3.0, 2.0), (-3.0, 2.0)) == pytest.approx(-0.5, abs=1e-3)  # by way of pi, where the post is
    assert cost((0.5, 2.0), (-0.5, 2.0)) == pytest.approx(-checker.clearance([0.5, 2.0]), abs=1e-9)  # by way of 0
    assert cost((np.pi, 2.0), (np.pi, 1.0)) == pytest.approx(-0.5, abs=1e-6)  # the least is at the first end
    assert cost((np.pi, 1.0), (np.pi, 2.0)) == pytest.approx(-0.5, abs=1e-6)
    base = pytest.importorskip("ompl.base")
    costs = [base.Cost(-0.5), base.Cost(-0.25)]
    for first, second in (costs, costs[::-1]):
        assert objective.combineCosts(first, second).value() == -0.25
    assert objective.combineCosts(objective.identityCost(), costs[0]).value() == -0.5


def test_clearances_of_the_core_skip_only_what_is_further():
    """The same with every order of pairs."""
    cube = pc.Polytope([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    poses = np.array([[at(3.0 * k + 0.3 * k * k) for k in range(5)]])
    pairs = np.array([(a, b) for a in range(5) for b in range(a)], dtype=np.int32)
    on_links = np.arange(5, dtype=np.int32), np.repeat(EYE[None], 5, axis=0)
    for order in (pairs, pairs[::-1].copy()):
        sampled, tuning = core.sampled_poses(poses), core_tuning()
        distances = core.Distances([cube.core] * 5, np.zeros(5), *on_links, order, 5, np.inf, tuning, sampled)
        _, nearest, found, *_ = distances.of_poses(poses, 1, 0, 1)
        assert found[0] == pytest.approx(2.3)
        assert set(order[nearest[0]].tolist()) == {0, 1}
