"""Obstacles moved, added, removed and attached: the verdicts of a new checker, and nothing prepared twice."""

import copy
import pickle
import warnings
import xml.etree.ElementTree as ElementTree
from weakref import WeakKeyDictionary, WeakValueDictionary

import numpy as np
import pytest
from poses import at

import plannercheck as pc
from plannercheck.bodies.objects import Part
from plannercheck.bodies.shapes import Box, Capsule, Cylinder, Sphere
from plannercheck.checking import prepared_bodies
from plannercheck.common.package_data import example_robot_data
from plannercheck.robots.description import find_description, read_description

HAND = "panda_hand"
FINGERS = ("panda_leftfinger", "panda_rightfinger")


def turned(x, y, z):
    pose = at(x, y, z)
    pose[:3, :3] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    return pose


@pytest.fixture
def scene():
    return pc.Scene.load("bookshelf")


@pytest.fixture(scope="module")
def q(panda):
    return panda.random_configurations(1500, 3)


@pytest.fixture
def preparations(monkeypatch):
    """Names of the bodies that are prepared from now on; nothing that other tests prepared is known any more."""
    names = []

    class Counted(prepared_bodies.Polytope):
        def __init__(self, points, faces=None, inflation_radius=0.0, name="polytope"):
            names.append(name)
            super().__init__(points, faces, inflation_radius, name)

    prepared = prepared_bodies.prepared

    def counted(points, faces=None, inflation_radius=0.0, name="polytope"):
        names.append(name)
        return prepared(points, faces, inflation_radius, name)

    monkeypatch.setattr(prepared_bodies, "Polytope", Counted)
    monkeypatch.setattr(prepared_bodies, "prepared", counted)
    of_boxes = prepared_bodies.polytopes_of_boxes

    def counted_boxes(sizes, radii):
        names.extend(["box"] * len(sizes))
        return of_boxes(sizes, radii)

    monkeypatch.setattr(prepared_bodies, "polytopes_of_boxes", counted_boxes)
    monkeypatch.setattr(prepared_bodies, "_PREPARED", WeakKeyDictionary())
    monkeypatch.setattr(prepared_bodies, "_POLYTOPES", WeakValueDictionary())
    prepared_bodies._lasting.cache_clear()
    return names


def assert_same(found, truth, q):
    """Everything that a checker says is what another one says."""
    np.testing.assert_array_equal(found.pairs, truth.pairs)
    np.testing.assert_array_equal(found.unreachable, truth.unreachable)
    np.testing.assert_array_equal(found.static, truth.static)
    np.testing.assert_array_equal(found.paddings, truth.paddings)
    np.testing.assert_array_equal(found.check_states(q), truth.check_states(q))
    np.testing.assert_array_equal(found.colliding_pairs(q[:100]), truth.colliding_pairs(q[:100]))
    np.testing.assert_array_equal(found.clearances(q[:20]), truth.clearances(q[:20]))
    np.testing.assert_array_equal(found.check_motions(q[:20], q[20:40]), truth.check_motions(q[:20], q[20:40]))
    assert [found.pair_names(k) for k in range(len(found.pairs))] == [
        truth.pair_names(k) for k in range(len(truth.pairs))
    ]
    for row in q[:30]:
        assert found.is_valid(row) == truth.is_valid(row)
        assert found.explain(row) == truth.explain(row)
    for start, end in zip(q[:20], q[20:40], strict=True):
        assert found.check_motion(start, end) == truth.check_motion(start, end)


def test_single_motions_are_judged_in_the_scene_of_their_checker(panda):
    """Before and after an edit, in both directions: what a checker keeps for single motions is its scene's."""
    start = panda.reference
    end = start + 0.1
    empty = pc.Checker(panda, pc.Scene("empty"))
    walled = pc.Scene("walled")
    walled.add_box("wall", [2, 2, 0.5], at(0.5, 0, 0.6))
    assert empty.check_motion(start, end)
    blocked = empty.with_scene(walled)
    assert not blocked.check_motion(start, end)
    assert blocked.with_scene(pc.Scene("empty again")).check_motion(start, end)
    assert empty.check_motion(start, end)
    assert not pickle.loads(pickle.dumps(blocked)).check_motion(start, end)
    assert copy.copy(empty).check_motion(start, end)


def test_moved_added_and_removed_obstacles_give_the_verdicts_of_a_new_checker(panda, scene, q):
    checker = pc.Checker(panda, scene)
    before = checker.check_states(q)
    scene.move(scene.object_names[0], turned(0.4, 0.2, 0.6))
    scene.remove(scene.object_names[1])
    scene.add_sphere("ball", 0.1, at(-0.3, 0.4, 0.5))
    changed = checker.with_scene(scene)
    assert_same(changed, pc.Checker(panda, scene), q)
    assert not np.array_equal(changed.check_states(q), before)
    np.testing.assert_array_equal(checker.check_states(q), before)
    assert_same(changed.with_scene(None), pc.Checker(panda), q)


def test_a_chain_of_changes_ends_where_a_new_checker_does(panda, q):
    rng = np.random.default_rng(5)
    scene, checker = pc.Scene("changing"), pc.Checker(panda)
    for k in range(12):
        pose = at(*rng.uniform(-0.6, 0.8, 3))
        if k % 3 == 0:
            scene.add_box(f"box {k}", rng.uniform(0.05, 0.4, 3).tolist(), pose)
        elif k % 5 == 4:
            scene.remove(scene.object_names[0])
        else:
            scene.move(scene.object_names[-1], pose)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            checker = checker.with_scene(scene)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        assert_same(checker, pc.Checker(panda, scene), q)


@pytest.mark.parametrize(
    "settings",
    [
        {"padding": 0.03},
        {"padding": {HAND: 0.02, "ball": 0.05}},
        {"kinematics": "pinocchio"},
        {"tuning": pc.Tuning(reach=False)},
        {"self_collision": False},
    ],
)
def test_settings_are_kept(panda, scene, q, settings):
    scene.add_sphere("ball", 0.1, at(0.5, 0.0, 0.4))
    checker = pc.Checker(panda, scene, **settings)
    scene.move("ball", at(0.4, -0.3, 0.3))
    found, truth = checker.with_scene(scene), pc.Checker(panda, scene, **settings)
    np.testing.assert_array_equal(found.pairs, truth.pairs)
    np.testing.assert_array_equal(found.check_states(q), truth.check_states(q))
    scene.remove("ball")
    gone = checker.with_scene(scene)
    np.testing.assert_array_equal(gone.paddings, checker.paddings[:-1])


def test_nothing_is_prepared_twice(panda, scene, q, preparations):
    checker = pc.Checker(panda, scene)
    checker.polytopes  # noqa: B018  # those of unreachable pairs, too
    assert preparations
    preparations.clear()
    name = scene.object_names[0]
    scene.move(name, turned(0.5, 0.1, 0.4))
    moved = checker.with_scene(scene)
    attached = moved.attach(name, None, HAND, at(0, 0, 0.2), FINGERS)
    freed = attached.detach(name, q[0])
    for each in (moved, attached, freed):
        each.check_states(q)
        assert len(each.polytopes) == len(each.bodies)
    assert preparations == []
    freed.attach("can", Cylinder(0.03, 0.1), HAND, at(0, 0, 0.1), FINGERS).polytopes  # noqa: B018
    assert preparations == ["body 'can'"]
    shared = {id(p) for p in checker.polytopes}
    assert {id(p) for p in freed.polytopes} == shared


def test_scenes_change_in_place_and_checkers_do_not(panda):
    scene = pc.Scene("one box")
    scene.add_box("box", [0.2, 0.2, 0.2], at(0.5, 0, 0.5))
    checker, copy = pc.Checker(panda, scene), scene.copy()
    scene.move("box", at(5, 0, 0))
    copy.move("box", at(7, 0, 0))
    copy.allow("box", HAND)
    assert [s.bodies[0].pose[0, 3] for s in (checker.scene, scene, copy)] == [0.5, 5, 7]
    assert scene.bodies[0].shape is copy.bodies[0].shape
    assert not scene.is_allowed("box", HAND)


def test_objects_of_several_parts_move_as_one():
    scene = pc.Scene()
    scene.add("cup", [Part(Sphere(0.1), at(1, 0, 0)), Part(Box((1, 1, 1)), turned(0, 0, 2))], at(0, 1, 0))
    scene.move("cup", turned(3, 0, 0))
    np.testing.assert_array_equal(scene.bodies[0].pose, turned(3, 0, 0) @ at(1, 0, 0))
    np.testing.assert_array_equal(scene.bodies[1].pose, turned(3, 0, 0) @ turned(0, 0, 2))


def panda_with_a_can(folder, pose, touched):
    """The Panda with a cylinder as a fixed link of the hand, and an SRDF that lets it touch some links."""
    description = read_description(find_description("panda"))
    urdf = ElementTree.parse(description.urdf)
    root = urdf.getroot()
    link = ElementTree.SubElement(root, "link", name="can")
    geometry = ElementTree.SubElement(ElementTree.SubElement(link, "collision"), "geometry")
    ElementTree.SubElement(geometry, "cylinder", radius="0.03", length="0.3")
    joint = ElementTree.SubElement(root, "joint", name="can_joint", type="fixed")
    ElementTree.SubElement(joint, "parent", link=HAND)
    ElementTree.SubElement(joint, "child", link="can")
    ElementTree.SubElement(joint, "origin", xyz=" ".join(map(str, pose[:3, 3].tolist())), rpy="0 0 0")
    srdf = ElementTree.parse(description.srdf)
    for name in (HAND, *touched):
        ElementTree.SubElement(srdf.getroot(), "disable_collisions", link1="can", link2=name, reason="Adjacent")
    urdf.write(folder / "can.urdf")
    srdf.write(folder / "can.srdf")
    joints = [f"panda_joint{k}" for k in range(1, 8)]
    held = {"panda_finger_joint1": 0.04}
    packages = example_robot_data()
    return pc.Robot.from_urdf(folder / "can.urdf", folder / "can.srdf", packages, joints, held)


def test_an_attached_body_is_as_a_fixed_link_of_the_urdf(panda, scene, q, tmp_path):
    pose = at(0.01, 0.02, 0.2)
    welded = pc.Checker(panda_with_a_can(tmp_path, pose, FINGERS), scene)
    carrying = pc.Checker(panda, scene).attach("can", Cylinder(0.03, 0.3), HAND, pose, FINGERS)
    truth, found = welded.check_states(q), carrying.check_states(q)
    np.testing.assert_array_equal(found, truth)
    assert (found != pc.Checker(panda, scene).check_states(q)).sum() > 20
    names = [{frozenset(c.pair_names(k)) for k in range(len(c.pairs))} for c in (welded, carrying)]
    # Pinocchio leaves out what is on the same joint as the can; MoveIt would test it.
    assert names[0] <= names[1]
    for found_pair in carrying.explain(q[np.flatnonzero(~found)[0]]).collisions:
        assert found_pair.certificate.verify()
    ends = np.flatnonzero(truth)[:40]
    np.testing.assert_array_equal(
        carrying.check_motions(q[ends[:20]], q[ends[20:]]), welded.check_motions(q[ends[:20]], q[ends[20:]])
    )
    same = pc.Checker(panda, scene).attach("can", Cylinder(0.03, 0.3), HAND, pose, (*FINGERS, "panda_link7"))
    np.testing.assert_allclose(same.clearances(q[:20]), welded.clearances(q[:20]), atol=1e-9)


def test_a_long_object_is_not_taken_for_the_short_one_that_was_carried_before(panda, q):
    """Of the same name, on the same link: no length of the first may be used for the second."""
    scene = pc.Scene("far")
    rng = np.random.default_rng(2)
    for k in range(12):
        direction = rng.normal(size=3)
        scene.add_box(f"box {k}", [0.1, 0.1, 0.1], at(*(1.4 * direction / np.linalg.norm(direction))))
    checker = pc.Checker(panda, scene).attach("tool", Sphere(0.01), HAND, at(0, 0, 0.12), FINGERS)
    assert checker.unreachable.any()
    for parts, pose in ((Capsule(0.02, 1.2), at(0, 0, 0.7)), (Sphere(0.3), at(0, 0, 0.5)), (Sphere(0.01), at(0, 0, 1))):
        scene.attach("tool", HAND, pose, FINGERS, parts)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            found, truth = checker.with_scene(scene), pc.Checker(panda, scene)
        np.testing.assert_array_equal(found.unreachable, truth.unreachable)
        assert (found.unreachable != checker.unreachable).any()
        np.testing.assert_array_equal(found.check_states(q), truth.check_states(q))
        scene.remove("tool")


@pytest.mark.parametrize("shape", [Sphere(0.1), pc.Box((0.2, 0.2, 0.2))])
def test_a_shape_that_changes_its_name_changes_its_padding(panda, q, shape):
    """The same shape under a padded name, then under one without: nothing prepared for the one serves the other."""
    scene = pc.Scene("names")
    scene.add("padded", shape, at(0.5, 0.2, 0.5))
    checker = pc.Checker(panda, scene, padding={"padded": 0.15})
    scene.remove("padded")
    scene.add("plain", shape, at(0.5, 0.2, 0.5))
    plain = checker.with_scene(scene)
    scene.remove("plain")
    scene.add("padded", shape, at(0.5, 0.2, 0.5))
    padded = plain.with_scene(scene)
    verdicts = checker.check_states(q)
    np.testing.assert_array_equal(padded.check_states(q), verdicts)
    found = plain.check_states(q)
    np.testing.assert_array_equal(found, pc.Checker(panda, plain.scene).check_states(q))
    assert (found & ~verdicts).any()


def test_paddings_that_their_owner_changes_stay_what_they_were(panda, scene, q):
    paddings = {"panda_hand": 0.02}
    checker = pc.Checker(panda, scene, padding=paddings)
    verdicts = checker.check_states(q)
    paddings["panda_hand"] = 0.3
    assert (checker.with_scene(scene).check_states(q) == verdicts).all()
    assert (pc.Checker(panda, scene, padding=paddings).check_states(q) != verdicts).any()


def test_what_a_pairs_own_distance_needed_is_not_taken_for_another_scene(panda, q):
    """Copies of padded bodies stand among the robot's: without them every obstacle has another place."""
    scene = pc.Scene("with a ball")
    scene.add_sphere("ball", 0.1, at(0.5, 0.2, 0.5))
    for k in range(4):  # bars from afar into the robot's reach
        scene.add_box(f"bar {k}", [6.0, 0.05, 0.05], at(3.4, 0.2 * k - 0.3, 0.6))
    padding = {(HAND, "ball"): 0.05, ("panda_link3", "ball"): 0.01}
    checker = pc.Checker(panda, scene, padding=padding)
    scene.remove("ball")
    for k in range(4):  # of what stays where it is, what is known holds
        scene.move(f"bar {k}", at(3.5, 0.3 - 0.2 * k, 0.5))
    found, truth = checker.with_scene(scene), pc.Checker(panda, scene)
    np.testing.assert_array_equal(found.unreachable, truth.unreachable)
    np.testing.assert_array_equal(found.check_states(q), truth.check_states(q))
    scene.add_sphere("ball", 0.1, at(0.5, 0.2, 0.5))
    again = found.with_scene(scene)
    truth = pc.Checker(panda, scene, padding=padding)
    np.testing.assert_array_equal(again.check_states(q), truth.check_states(q))


def picked_up(checker, q):
    return checker.attach("can", None, HAND, q=q, touch_links=FINGERS)


def allowed(checker, q):
    scene = checker.scene.copy()
    scene.allow("can", HAND)
    return checker.with_scene(scene)


def taken_away(checker, q):
    scene = checker.scene.copy()
    scene.remove("can")
    return checker.with_scene(scene)


@pytest.mark.parametrize("change", [picked_up, allowed, taken_away])
@pytest.mark.parametrize(
    "pairs",
    [
        {("can", HAND): 0.002},
        {(HAND, "can"): 0.002, ("can", "panda_link5"): 0.03, "can": 0.001},
        {("can", finger): 0.004 for finger in FINGERS} | {("can", HAND): 0.0, HAND: 0.01},
    ],
)
def test_paddings_of_pairs_that_a_scene_does_not_test_come_back_with_the_pair(panda, scene, q, pairs, change):
    """Picking up an object from which the hand keeps a distance (pair_padding_attach)."""
    start = scene.start("panda")
    scene.add("can", Cylinder(0.02, 0.1), panda.link_poses(start)[panda.link_index(HAND)] @ at(0, 0, 0.15))
    checker = pc.Checker(panda, scene, padding=pairs)
    changed = change(checker, start)
    tested = {frozenset(changed.pair_names(k)) for k in range(len(changed.pairs))}
    assert frozenset(("can", HAND)) not in tested
    named = set().union(*tested)
    for k, pair in enumerate(changed.pairs):
        a, b = changed.pair_names(k)
        whole = [length for of, length in pairs.items() if of in ((a, b), (b, a))]
        assert changed.paddings[pair].sum() == (whole or [pairs.get(a, 0.0) + pairs.get(b, 0.0)])[-1]
    fits = {of: x for of, x in pairs.items() if of in named or (not isinstance(of, str) and frozenset(of) in tested)}
    truth = pc.Checker(panda, changed.scene, padding=fits)
    np.testing.assert_array_equal(changed.check_states(q), truth.check_states(q))
    back = changed.with_scene(scene)
    np.testing.assert_array_equal(back.paddings[back.pairs], checker.paddings[checker.pairs])
    np.testing.assert_array_equal(back.check_states(q), checker.check_states(q))


def test_either_of_two_carried_objects_may_list_the_other_as_a_touch_link(panda):
    for first, second in (((), ("a",)), (("b",), ())):
        scene = pc.Scene("two carried")
        scene.attach("a", HAND, at(0, 0, 0.2), (*FINGERS, *first), Sphere(0.02))
        scene.attach("b", "panda_link5", at(0, 0.2, 0), second, Sphere(0.02))
        checker = pc.Checker(panda, scene)
        assert {"a", "b"} not in [set(checker.pair_names(k)) for k in range(len(checker.pairs))]


def test_attaching_in_any_way_is_attaching_in_the_scene(panda, scene, q):
    scene.attach("can", HAND, at(0, 0, 0.2), FINGERS, Cylinder(0.03, 0.3))
    whole = pc.Checker(panda, scene)
    scene.remove("can")
    attached = pc.Checker(panda, scene).attach("can", Cylinder(0.03, 0.3), HAND, at(0, 0, 0.2), FINGERS)
    assert_same(attached, whole, q)
    again = pc.Checker(attached.robot, attached.scene)
    assert_same(again, whole, q)
    assert again.detach("can").robot.bodies == panda.bodies
    assert_same(attached.detach("can"), pc.Checker(panda, scene), q)


def test_a_grasped_object_moves_with_the_hand_and_is_put_down_elsewhere(panda, q):
    scene = pc.Scene("grasp")
    hand = panda.link_poses(q[0])[panda.link_index(HAND)]
    scene.add("can", Capsule(0.02, 0.1), hand @ turned(0, 0, 0.3))
    checker = pc.Checker(panda, scene)
    grasped = checker.attach("can", None, HAND, q=q[0], touch_links=FINGERS)
    assert grasped.scene.object_names == ()
    (can,) = [k for k, body in enumerate(grasped.bodies) if body.carried == "can"]
    for row in q[:5]:
        truth = panda.link_poses(row)[panda.link_index(HAND)] @ turned(0, 0, 0.3)
        np.testing.assert_allclose(grasped.body_poses(row)[0, can], truth, atol=1e-14)
    put_down = grasped.detach("can", q[3])
    np.testing.assert_allclose(
        put_down.scene.bodies[0].pose, panda.link_poses(q[3])[panda.link_index(HAND)] @ turned(0, 0, 0.3), atol=1e-14
    )
    assert put_down.robot.bodies == panda.bodies


def test_touch_links_and_allowed_collisions_leave_pairs_out(panda):
    scene = pc.Scene("two carried")
    scene.add_box("table", [1, 1, 0.1], at(0.8, 0, 0))
    scene.attach("a", HAND, at(0, 0, 0.2), FINGERS, Sphere(0.02))
    scene.attach("b", HAND, at(0, 0, 0.22), FINGERS, Sphere(0.02))
    scene.attach("c", "panda_link5", at(0, 0.2, 0), (), Sphere(0.02))

    def partners(name):
        checker = pc.Checker(panda, scene)
        pairs = [checker.pair_names(k) for k in range(len(checker.pairs))]
        return {x for pair in pairs for x in pair if name in pair and x != name}

    links = {body.link for body in panda.bodies}
    assert partners("a") == links - {HAND, *FINGERS} | {"c", "table"}
    assert partners("c") == links - {"panda_link5"} | {"a", "b", "table"}
    scene.allow("a", "table")
    scene.allow("a", "panda_link7")
    scene.allow("a", "c")
    assert partners("a") == links - {HAND, *FINGERS, "panda_link7"}
    scene.allowed.defaults["b"] = True
    assert partners("b") == set()


def test_robots_that_carry_something_are_pickled_and_held_elsewhere(panda, scene, q):
    carrying = pc.Checker(panda, scene).attach("can", Cylinder(0.03, 0.3), HAND, at(0, 0, 0.2), FINGERS).robot
    for other in (pickle.loads(pickle.dumps(carrying)), carrying.holding({"panda_finger_joint1": 0.04})):
        assert [body.name for body in other.bodies] == [body.name for body in carrying.bodies]
        np.testing.assert_array_equal(other.self_pairs, carrying.self_pairs)
    truth = pc.Checker(panda, scene).attach("can", Cylinder(0.03, 0.3), HAND, at(0, 0, 0.2), FINGERS)
    np.testing.assert_array_equal(pc.Checker(carrying, scene).check_states(q), truth.check_states(q))
    assert carrying.carrying(()).bodies == panda.bodies
    assert carrying.kinematic_error > panda.kinematic_error


def test_planners_take_what_is_carried_into_account(panda, scene):
    plain = pc.Checker(panda, scene)
    carrying = plain.attach("rod", Capsule(0.02, 0.6), HAND, at(0, 0, 0.35), FINGERS)
    start = scene.start("panda")
    rows = panda.random_configurations(300, 8)
    state = pc.ompl.setup(carrying).getStateSpace().allocState()
    judge = pc.ompl.setup(carrying).getSpaceInformation()
    for row in (start, *rows):
        for k, value in enumerate(row.tolist()):
            state[k] = value
        assert judge.isValid(state) == carrying.is_valid(row)
    assert plain.check_states(rows).sum() > carrying.check_states(rows).sum()


def test_what_is_carried_and_always_touches_is_said(panda):
    checker = pc.Checker(panda)
    with pytest.warns(RuntimeWarning, match="'can'.*touches 'panda_leftfinger' at every configuration.*touch_links"):
        bad = checker.attach("can", Cylinder(0.05, 0.1), HAND, at(0, 0, 0.1))
    assert not bad.check_states(panda.random_configurations(20, 1)).any()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        bad.with_scene(bad.scene)  # it has been said


def renamed(scene, name):
    """The scene with its box under another name."""
    other = scene.copy()
    other.remove("box")
    other.add_box(name, [0.2, 0.2, 0.2], at(2, 0, 0.5))
    return other


def carrying_twice(scene, checker):
    scene.attach("mug", HAND, parts=Sphere(0.1))
    return checker.robot.carrying([*scene.attached, *scene.attached])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda s, c: s.move("mug", None), "unknown object 'mug'"),
        (lambda s, c: s.attach("mug", HAND), "unknown object to attach 'mug'"),
        (lambda s, c: s.move(["box"], None), r"unknown object \"\['box'\]\""),
        (lambda s, c: s.attach("box", HAND, touch_links="panda_link1"), "must be a list of names"),
        (lambda s, c: s.attach("box", HAND, touch_links=None), "must be a list of names, not None"),
        (lambda s, c: s.attach("box", HAND, touch_links=[["panda_link1"]]), "must be a list of names"),
        (lambda s, c: s.attach("box", None), "'box' is attached to a link by its name, not None"),
        (lambda s, c: s.add_sphere(7, 1.0), "name of an object must be a text, not 7"),
        (lambda s, c: s.allow("box", HAND, "no"), "allow takes two names, and True or False, not 'box', .* and 'no'"),
        (lambda s, c: s.allow("box", [HAND]), "allow takes two names"),
        (lambda s, c: carrying_twice(s, c), "carries two objects named 'mug'"),
        (lambda s, c: pc.Checker(c.attach("mug", Sphere(0.1), HAND).robot, renamed(s, "mug")), "that 'panda' carries"),
        (lambda s, c: c.robot.carrying([Sphere(1)]), "carries a list of attached objects, e.g. scene.attached, not"),
        (lambda s, c: s.attach("box", HAND, parts=Sphere(1)), "'box' exists already"),
        (lambda s, c: s.detach("box", None), "unknown attached object 'box'"),
        (lambda s, c: s.add("new", ["sphere"]), "object 'new': a body must be a shape such as Box"),
        (lambda s, c: c.with_scene(renamed(s, HAND)), "object 'panda_hand' has the name of a link of 'panda'"),
        (lambda s, c: pc.Checker(c.robot, renamed(s, HAND)), "object 'panda_hand' has the name of a link of 'panda'"),
        (lambda s, c: c.attach("box", None, "panda_hnad"), "unknown link that carries 'box' 'panda_hnad'"),
        (lambda s, c: c.attach(HAND, Sphere(1), HAND), "a link or body of the robot is named 'panda_hand'"),
        (lambda s, c: c.attach("box", None, HAND, at(0, 0, 0), q=np.zeros(7)), "not both"),
        (lambda s, c: c.detach("box"), "unknown attached object 'box'"),
        (lambda s, c: c.with_scene("bookshelf"), "with_scene takes a Scene, not str"),
        (lambda s, c: pc.Checker(c.robot, s).with_bodies(pc.Checker(c.robot, s).bodies).with_scene(s), "stand-ins"),
    ],
)
def test_mistakes_are_named(panda, change, message):
    scene = pc.Scene("one box")
    scene.add_box("box", [0.2, 0.2, 0.2], at(2, 0, 0.5))
    with pytest.raises(pc.PlannercheckError, match=message):
        change(scene, pc.Checker(panda, scene))


def test_unknown_touch_links_are_said(panda):
    with pytest.warns(RuntimeWarning, match="touch links gripper of 'can' are no links of the robot"):
        pc.Checker(panda).attach("can", Sphere(0.01), HAND, at(0, 0, 0.3), ["gripper"])


def test_scene_files_keep_attached_objects_and_frames(panda, tmp_path):
    scene = pc.Scene("kept")
    scene.add("cup", [Part(Sphere(0.1), at(1, 0, 0)), Part(Box((1, 1, 1)))], turned(0, 1, 0))
    scene.attach("can", HAND, turned(0, 0, 0.2), FINGERS, Cylinder(0.03, 0.3))
    scene.allow("can", "cup")
    scene.save(tmp_path / "kept.yaml")
    again = pc.Scene.load(tmp_path / "kept.yaml")
    for one, other in zip((*scene.objects, *scene.attached), (*again.objects, *again.attached), strict=True):
        assert (one.name, one.link, one.touch_links) == (other.name, other.link, other.touch_links)
        np.testing.assert_array_equal(one.pose, other.pose)
        for a, b in zip(one.bodies, other.bodies, strict=True):
            assert (a.name, a.shape, a.link, a.carried) == (b.name, b.shape, b.link, b.carried)
            np.testing.assert_array_equal(a.pose, b.pose)
    assert again.is_allowed("can", "cup")
