"""Verdicts of configurations: the same by every way, and those of the pair test at the poses of the links."""

import itertools
import pickle
import sys
import threading
import warnings

import exact_verdicts
import numpy as np
import pytest

import plannercheck as pc

COUNTED = ("bounds", "overlaps", "boxes", "cached_plane", "box_face", "centre_axis")
SWITCHES = (*COUNTED, "learning", "reach")


@pytest.fixture(scope="module")
def scene():
    return pc.Scene.load("bookshelf")


@pytest.fixture(scope="module")
def checker(panda, scene):
    return pc.Checker(panda, scene)


@pytest.fixture(scope="module")
def samples(scene, panda):
    """States around the scene and anywhere."""
    return np.vstack([scene.samples("panda")[:300], panda.random_configurations(200, 3)])


@pytest.fixture(scope="module")
def verdicts(checker, samples):
    return checker.check_states(samples)


def test_sets_and_single_states_agree(checker, samples, verdicts):
    assert 0.1 < verdicts.mean() < 0.9
    assert verdicts.dtype == bool
    assert [checker.is_valid(q) for q in samples] == verdicts.tolist()
    assert isinstance(checker.is_valid(samples[0]), bool)


def test_configurations_at_odd_addresses(checker, samples):
    """Rows of messages and of packed records need not be aligned; cluster workers got such."""
    rows = np.frombuffer(b"_" + samples.tobytes(), dtype=np.float64, offset=1).reshape(samples.shape)
    assert not rows.flags.aligned
    assert checker.robot.check_configurations(rows).flags.aligned  # what the core reads, where it would not show on x86
    assert checker._judge_row(rows[0]) is None
    assert np.array_equal(checker.check_states(rows), checker.check_states(samples))
    assert [checker.is_valid(q) for q in rows[:50]] == checker.check_states(samples[:50]).tolist()


@pytest.mark.parametrize(
    "form",
    [
        list,
        tuple,
        np.asfortranarray,
        lambda q: np.repeat(q, 2)[::2],
        lambda q: q.astype(">f8"),
        lambda q: q.astype(np.longdouble),
        lambda q: q.view(np.recarray),
        lambda q: np.ma.array(q),
    ],
)
def test_one_configuration_in_any_form(checker, samples, verdicts, form):
    assert [checker.is_valid(form(q)) for q in samples[:40]] == verdicts[:40].tolist()


@pytest.mark.parametrize("form", [list, tuple, lambda q: q.astype(np.longdouble), lambda q: np.repeat(q, 2)[::2]])
def test_what_is_no_array_of_doubles_is_judged_as_fast(checker, samples, verdicts, form, monkeypatch):
    """Lists took the long way through sets of configurations, for 20 times as long."""
    for owner in type(checker).__mro__:
        if "check_states" in vars(owner):
            monkeypatch.delattr(owner, "check_states")
    assert [checker.is_valid(form(q)) for q in samples[:40]] == verdicts[:40].tolist()


@pytest.mark.parametrize(
    "bad", [[], np.zeros(6), np.zeros((2, 7)), np.zeros((1, 6)), np.full(7, np.nan), "1234567", None]
)
def test_what_is_no_configuration(checker, bad):
    with pytest.raises(pc.PlannercheckError, match="configuration"):
        checker.is_valid(bad)


@pytest.mark.parametrize("reach", [True, False])
def test_what_is_too_large_is_refused_one_by_one_as_well(panda, scene, reach):
    checker = pc.Checker(panda, scene, tuning=pc.Tuning(reach=reach))
    q = np.full(7, 1e16)
    for form in (q, q.tolist()):
        with pytest.raises(pc.PlannercheckError, match=r"at most 1e\+15"):
            checker.is_valid(form)


def test_a_judged_row_is_let_go(checker, samples):
    """Whoever holds its buffer holds the array as well."""
    for row in (samples[0].copy(), np.repeat(samples[0], 2)[::2], samples[0].astype(">f8")):
        before = sys.getrefcount(row)
        checker.is_valid(row)
        assert sys.getrefcount(row) == before


@pytest.mark.parametrize("threads", [2, 3, 100])
def test_threads_do_not_matter(checker, samples, threads):
    np.testing.assert_array_equal(
        checker.first_colliding_pair(samples, threads=threads), checker.first_colliding_pair(samples)
    )


def test_order_and_batch_size_do_not_matter(panda, scene, samples, verdicts):
    fresh = pc.Checker(panda, scene)
    order = np.random.default_rng(1).permutation(len(samples))
    np.testing.assert_array_equal(fresh.check_states(samples[order]), verdicts[order])
    for size in (1, 2, 3, 5, 8, 13, 64):
        parts = [fresh.check_states(samples[k : k + size]) for k in range(0, 130, size)]
        np.testing.assert_array_equal(np.concatenate(parts)[:130], verdicts[:130])


@pytest.mark.parametrize("method", ["oracle", "walk", "exact"])
@pytest.mark.parametrize("off", [(), *itertools.combinations(SWITCHES, 1), SWITCHES])
def test_every_switch_leaves_the_verdicts(panda, scene, checker, samples, method, off):
    few = samples[::8] if method == "exact" and off else samples[::2]
    other = pc.Checker(panda, scene, tuning=pc.Tuning(method=method, **dict.fromkeys(off, False)))
    np.testing.assert_array_equal(other.first_colliding_pair(few), checker.first_colliding_pair(few))
    statistics = other.statistics()
    for switch in set(off) & set(COUNTED):
        assert statistics[switch] == 0
    np.testing.assert_array_equal(other.check_states(few), checker.first_colliding_pair(few) < 0)
    if method == "exact":
        assert statistics["solver"] == 0


def test_switches_do_something(checker, samples):
    checker.check_states(samples)
    statistics = checker.statistics()
    for key in (*COUNTED, "solver", "states", "pairs", "skipped", "unreachable"):
        assert statistics[key] > 0
    stages = ("solver", "nearest_points", "double_double", "exact")
    settled = ("unreachable", *COUNTED, *stages, "trees", "skipped")
    assert sum(statistics[k] for k in settled) == statistics["pairs"]
    assert not checker.check_motions(samples[:-1:20], samples[1::20], resolution=0.05).all()
    statistics = checker.statistics()
    assert sum(statistics[k] for k in settled) == statistics["pairs"]


def test_pinocchio_poses_give_the_same_verdicts(panda, scene, samples, verdicts):
    other = pc.Checker(panda, scene, kinematics="pinocchio")
    np.testing.assert_array_equal(other.check_states(samples, threads=2), verdicts)
    np.testing.assert_allclose(
        other.body_poses(samples[:5]), pc.Checker(panda, scene).body_poses(samples[:5]), atol=1e-12
    )


def test_body_poses_are_link_poses_times_placements(checker, panda, samples):
    found = checker.body_poses(samples[:20])
    links = panda.link_poses(samples[:20])
    for k, body in enumerate(checker.bodies):
        if checker.polytopes[k] is None:
            assert np.isnan(found[:, k]).all()
        elif body.link is None:
            np.testing.assert_array_equal(found[:, k], np.broadcast_to(body.pose, (20, 4, 4)))
        else:
            np.testing.assert_allclose(found[:, k], links[:, panda.link_index(body.link)] @ body.pose, atol=1e-15)


def test_verdicts_are_those_of_exact_arithmetic(checker, samples):
    few = samples[:3]
    poses, colliding = checker.body_poses(few), checker.colliding_pairs(few)
    for state in range(len(few)):
        for k in range(0, len(checker.pairs), 5):
            a, b = checker.pairs[k]
            truth = exact_verdicts.intersects(
                checker.polytopes[a].vertices, checker.polytopes[b].vertices, poses[state, a], poses[state, b]
            )
            assert colliding[state, k] == truth


def test_all_pairs_and_the_first_agree(checker, samples, verdicts):
    colliding = checker.colliding_pairs(samples)
    assert colliding.shape == (len(samples), len(checker.pairs))
    np.testing.assert_array_equal(~colliding.any(axis=1), verdicts)
    first = np.where(colliding.any(axis=1), colliding.argmax(axis=1), -1)
    np.testing.assert_array_equal(checker.first_colliding_pair(samples), first)


def test_explanations_name_the_colliding_pairs(checker, samples):
    for q in samples[:300:40]:
        colliding = checker.colliding_pairs(q)[0]
        verdict = checker.explain(q, separations=True)
        assert verdict.valid == (not colliding.any())
        named = [(v.first, v.second) for v in verdict.collisions]
        assert named == [checker.pair_names(k) for k in np.flatnonzero(colliding)]
        assert all(isinstance(v.certificate, pc.SharedPoint) and v.colliding for v in verdict.collisions)
        assert all(isinstance(v.certificate, pc.Separation) and not v.colliding for v in verdict.separations)
        assert len(verdict.collisions) + len(verdict.separations) == len(checker.pairs)
        assert checker.explain(q).separations == ()


def test_explanations_name_links_and_objects(panda):
    hand = panda.link_poses(panda.reference)[panda.link_index("panda_hand")]
    scene = pc.Scene()
    scene.add_box("crate", [0.05, 0.05, 0.05], hand)
    verdict = pc.Checker(panda, scene).explain(panda.reference)
    assert ("panda_hand", "crate") in {(v.first, v.second) for v in verdict.collisions}
    point = verdict.collisions[0].certificate.point
    assert np.linalg.norm(point - hand[:3, 3]) < 0.3


def test_without_self_collision_only_obstacles_count(panda, scene, samples):
    alone = pc.Checker(panda, scene, self_collision=False)
    whole = pc.Checker(panda, scene)
    assert len(alone.pairs) == len(whole.pairs) - len(panda.self_pairs)
    with_self = whole.colliding_pairs(samples)[:, len(panda.self_pairs) :]
    np.testing.assert_array_equal(alone.colliding_pairs(samples), with_self)


def test_the_scenes_matrix_acts_on_self_pairs_if_asked_for(panda):
    q = next(q for q in panda.random_configurations(200, 1) if not pc.Checker(panda).is_valid(q))
    scene = pc.Scene()
    for pair in pc.Checker(panda).explain(q).collisions:
        scene.allow(pair.first, pair.second)
    assert not pc.Checker(panda, scene).is_valid(q)
    assert pc.Checker(panda, scene, acm="scene").is_valid(q)


def test_an_empty_scene_leaves_self_collision(panda, samples):
    np.testing.assert_array_equal(
        pc.Checker(panda).check_states(samples), pc.Checker(panda, pc.Scene("empty")).check_states(samples)
    )


def test_without_pairs_everything_is_valid(panda, samples):
    checker = pc.Checker(panda, None, self_collision=False)
    assert len(checker.pairs) == 0
    assert checker.check_states(samples).all()
    assert checker.colliding_pairs(samples).shape == (len(samples), 0)
    assert checker.explain(samples[0]).valid
    assert checker.check_motion(samples[0], samples[1])


def test_no_states_are_no_trouble(checker):
    none = np.zeros((0, 7))
    assert checker.check_states(none).shape == (0,)
    assert checker.check_states(none, threads=2).shape == (0,)
    assert checker.colliding_pairs(none).shape == (0, len(checker.pairs))
    assert checker.check_motions(none, none).shape == (0,)


def test_a_base_that_touches_an_obstacle_is_warned_of(panda):
    scene = pc.Scene()
    scene.add_box("floor", [2, 2, 0.2], None)
    with pytest.warns(RuntimeWarning, match=r"'panda_link0'.*fixed to the world.*'floor'") as caught:
        pc.Checker(panda, scene)
    assert caught[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene.allow("panda_link0", "floor")
        pc.Checker(panda, scene)


def test_the_same_with_a_prismatic_and_a_mobile_robot():
    for name in ("tiago", "pr2"):
        robot = pc.Robot.load(name)
        q = robot.random_configurations(40, 1)
        scene = pc.Scene()
        scene.add_box(
            "table", [0.5, 1.0, 0.05], np.array([[1, 0, 0, 0.8], [0, 1, 0, 0], [0, 0, 1, 0.7], [0, 0, 0, 1.0]])
        )
        found = pc.Checker(robot, scene).first_colliding_pair(q)
        walk, plain = {"tuning": pc.Tuning(method="walk")}, {"tuning": pc.Tuning(bounds=False, boxes=False)}
        for other in (walk, plain, {"kinematics": "pinocchio"}):
            np.testing.assert_array_equal(pc.Checker(robot, scene, **other).first_colliding_pair(q), found)


@pytest.mark.parametrize("obstacles", [20, 150])  # tested one by one, and in a tree
def test_blocks_judge_as_single_states_and_as_no_filter(panda, obstacles):
    rng = np.random.default_rng(obstacles)
    scene = pc.Scene()
    for k in range(obstacles):
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = turn * np.linalg.det(turn), rng.uniform(-1, 1, 3)
        scene.add_box(f"box {k}", rng.uniform(0.002, 0.15, 3), pose)
    q = panda.random_configurations(203, 5)
    truth = pc.Checker(
        panda, scene, tuning=pc.Tuning(bounds=False, boxes=False, reach=False, method="walk")
    ).colliding_pairs(q)
    assert 0 < truth.any(axis=1).sum() < len(q)
    for switches in ({}, {"bounds": False}, {"boxes": False}, {"float_poses": False}):
        checker = pc.Checker(panda, scene, tuning=pc.Tuning(**switches))
        np.testing.assert_array_equal(checker.colliding_pairs(q), truth)
        for size in (1, 2, 3, 8, 203):
            parts = [checker.check_states(q[k : k + size]) for k in range(0, len(q), size)]
            np.testing.assert_array_equal(np.concatenate(parts), ~truth.any(axis=1))


def test_moving_and_fixed_pairs_of_a_floating_base():
    from plannercheck.common.package_data import example_robot_data
    from plannercheck.robots.description import find_description, read_description

    description = read_description(find_description("ur5"))
    robot = pc.Robot.from_urdf(description.urdf, package_dirs=example_robot_data(), floating=True)
    scene = pc.Scene()
    scene.add_box("wall", [0.1, 4, 4], None)
    checker = pc.Checker(robot, scene)
    q = robot.random_configurations(60, 2)
    q[:, :3] *= 2
    np.testing.assert_array_equal(
        checker.check_states(q),
        pc.Checker(robot, scene, tuning=pc.Tuning(bounds=False, boxes=False, method="walk")).check_states(q),
    )
    assert 0 < checker.check_states(q).sum() < 60
    q[0, 3:7] *= 1.05  # one by one, too, quaternions have to be of length 1
    with pytest.raises(pc.PlannercheckError, match="quaternion, of length 1"):
        checker.is_valid(q[0])
    assert checker.state_validity() is None


def test_threads_may_share_a_checker(checker, samples, verdicts):
    results = [None] * 4

    def work(k):
        results[k] = checker.check_states(samples)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for result in results:
        np.testing.assert_array_equal(result, verdicts)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"kinematics": "mine"}, "'batch' or 'pinocchio', not 'mine'"),
        ({"acm": "srdf"}, "'robot' or 'scene', not 'srdf'"),
        ({"tuning": {"bounds": False}}, "must be a Tuning"),
        ({"excess": -1.0}, "excess"),
    ],
)
def test_unknown_arguments_are_refused(panda, scene, arguments, message):
    with pytest.raises(pc.PlannercheckError, match=message):
        pc.Checker(panda, scene, **arguments)


@pytest.mark.parametrize("call", ["check_states", "colliding_pairs", "first_colliding_pair", "body_poses"])
def test_bad_configurations_are_named_by_row(checker, samples, call):
    bad = samples[:9].copy()
    bad[6, 2] = np.nan
    with pytest.raises(pc.PlannercheckError, match="row 6"):
        getattr(checker, call)(bad)
    with pytest.raises(pc.PlannercheckError, match=r"\(n, 7\), not \(9, 6\)"):
        getattr(checker, call)(samples[:9, :6])
    with pytest.raises(pc.PlannercheckError, match="numbers"):
        getattr(checker, call)([["a"] * 7])


def test_single_states_must_be_single(checker, samples):
    for call in (checker.is_valid, checker.explain):
        with pytest.raises(pc.PlannercheckError, match=r"\(7,\), not \(2, 7\)"):
            call(samples[:2])
    with pytest.raises(pc.PlannercheckError, match="finite"):
        checker.is_valid(np.full(7, np.inf))


@pytest.mark.parametrize("threads", [0, -1, 1.5, "two"])
def test_bad_thread_counts_are_refused(checker, samples, threads):
    with pytest.raises(pc.PlannercheckError, match="threads"):
        checker.check_states(samples, threads=threads)


def test_more_threads_than_an_integer_holds(checker, samples, verdicts):
    np.testing.assert_array_equal(checker.check_states(samples[:4], threads=2**40), verdicts[:4])


def test_a_flat_obstacle_gets_verdicts(panda):
    scene = pc.Scene()
    scene.add_hull("sheet", np.array([[-1, -1, 0.5], [1, -1, 0.5], [-1, 1, 0.5], [1, 1, 0.5]]), None)
    verdict = pc.Checker(panda, scene).explain(panda.reference)
    assert {pair.second for pair in verdict.collisions} == {"sheet"}
    assert all(pair.certificate.verify() for pair in verdict.collisions)


def test_limits_are_not_looked_at(panda):
    beyond = panda.upper + 0.3
    assert pc.Checker(panda).check_states(beyond[None]).shape == (1,)


def test_later_changes_of_the_scene_do_not_matter(panda, scene, samples, verdicts):
    own = pickle.loads(pickle.dumps(scene))
    checker = pc.Checker(panda, own)
    for name in list(own.object_names):
        own.remove(name)
    np.testing.assert_array_equal(checker.check_states(samples), verdicts)
    assert len(checker.bodies) == len(panda.bodies) + len(scene.bodies)


def test_touching_obstacles_count_as_collisions():
    # A box on a slide along x comes to touch another exactly: every number is a short one.
    urdf = """<robot name="slide"><link name="rail"/>
    <link name="block"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
    <joint name="x" type="prismatic"><parent link="rail"/><child link="block"/><axis xyz="1 0 0"/>
    <limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>"""
    import pathlib
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "slide.urdf"
        path.write_text(urdf)
        robot = pc.Robot.from_urdf(path)
    scene = pc.Scene()
    scene.add_box("wall", [1, 1, 1], None)
    for method in ("oracle", "walk", "exact"):
        checker = pc.Checker(robot, scene, tuning=pc.Tuning(method=method))
        near = np.array([[1.0], [np.nextafter(1, 2)], [-1.0], [np.nextafter(-1, -2)], [0.0], [3.0]])
        assert checker.check_states(near).tolist() == [False, True, False, True, False, True]


def test_a_name_is_no_scene(panda):
    with pytest.raises(pc.PlannercheckError, match=r"Scene\.load"):
        pc.Checker(panda, "cage")
