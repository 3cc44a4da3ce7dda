"""States in scenes that move, beside a robot whose URDF has the moving body as a floating link."""

import copy
import pickle
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from support.moving_scenes import arm_urdf, random_pose

import plannercheck as pc
from plannercheck.checking.left_out_pairs import left_out_pairs

_SIZE = (0.3, 0.2, 0.25)
_ANGLES = np.arange(61) * 0.1


def _robot(folder: Path, joints: int = 3, seed: int = 0, pallet: bool = False) -> pc.Robot:
    file = folder / f"arm{pallet}.urdf"
    file.write_text(arm_urdf(np.random.default_rng(seed), joints, _SIZE if pallet else None))
    return pc.Robot.from_urdf(file)


def _crossing(outside: str = "refuse") -> pc.Moving:
    """From one side of the arm's base to the other, through it."""
    ends = np.array([np.eye(4)] * 2)
    ends[:, :3, 3] = [[-1, 0, 0.1], [1, 0, 0.1]]
    return pc.Moving([2.0, 4.0], ends, outside=outside)


def _scene(outside: str = "refuse") -> pc.Scene:
    scene = pc.Scene("crossing")
    scene.add_box("table", (0.2, 0.2, 0.2), random_pose(np.random.default_rng(5), np.array([0.5, 0, 0.1])))
    scene.add("pallet", pc.Box(_SIZE), _crossing(outside))
    return scene


def test_screws_are_where_pinocchio_has_them(tmp_path: Path) -> None:
    """Steps that turn and slide, slide, turn, and rest; an arm that moves meanwhile is elsewhere no matter."""
    rng = np.random.default_rng(0)
    poses = [pin.SE3(random_pose(rng)) for _ in range(4)]
    poses.insert(2, pin.SE3(poses[1].rotation, poses[1].translation + 0.1 * np.eye(3)[2]))
    poses.insert(4, pin.SE3(pin.exp3(np.array([0, 0, 0.3])) @ poses[3].rotation, poses[3].translation))
    poses.insert(5, poses[4])
    times, scene, still = np.arange(7.0) ** 1.5, pc.Scene("screws"), pc.Scene("still")
    for each, path in ((scene, "screw"), (still, "slerp")):
        moving = pc.Moving(times, [pose.homogeneous for pose in poses], path=path)
        for name in ("left", "right"):
            each.add(name, pc.Box(_SIZE), moving)
    checker, q = pc.Checker(_robot(tmp_path), scene), np.zeros((1, 3))
    asked = np.linspace(0, times[-1], 60)
    found = checker.body_poses(q, times=asked)
    for time, left, right in zip(asked.tolist(), found[:, -2], found[:, -1], strict=True):
        k = min(int(np.searchsorted(times, time, "right")) - 1, 5)
        share = (time - times[k]) / (times[k + 1] - times[k])
        meant = poses[k] * pin.exp6(share * pin.log6(poses[k].actInv(poses[k + 1])))
        assert np.allclose(left, meant.homogeneous, atol=1e-13)
        assert np.array_equal(left, right)
    assert not np.allclose(pc.Checker(_robot(tmp_path), still).body_poses(q, times=asked), found, atol=1e-3)


def test_screws_that_are_no_bodys_are_refused(tmp_path: Path) -> None:
    """Too many, or about an axis that is too far away."""
    turns = np.array([pin.SE3(pin.exp3(a * np.eye(3)[2]), a * np.eye(3)[0]).homogeneous for a in _ANGLES])
    for count, angle, message in ((60, 1.0, "60 screws, and at most 50"), (2, 1e-9, "poses 0 and 1 of object 'box'")):
        poses = turns[: count + 1].copy()
        poses[1, :3, :3] = pin.exp3(np.array([0, 0, angle * 0.1]))
        scene = pc.Scene("far")
        scene.add("box", pc.Box(_SIZE), pc.Moving(np.arange(count + 1), poses, path="screw"))
        with pytest.raises(pc.PlannercheckError, match=message):
            pc.Checker(_robot(tmp_path), scene)


@pytest.mark.parametrize("seed", range(3))
def test_verdicts_are_those_of_a_floating_link(tmp_path: Path, seed: int) -> None:
    """The URDF with the box on a floating joint is read by hand's rules; rows have its pose appended."""
    rng = np.random.default_rng(seed)
    robot, merged = _robot(tmp_path, 3, seed), _robot(tmp_path, 3, seed, pallet=True)
    poses = np.array([random_pose(rng) for _ in range(3000)])
    moving = pc.Moving(np.arange(len(poses)), poses)
    scene, still = pc.Scene("moving"), pc.Scene("still")
    scene.add("pallet", pc.Box(_SIZE), moving)
    for each in (scene, still):
        each.add_box("table", (0.4, 0.4, 0.4), random_pose(np.random.default_rng(9)))
    still.allow("pallet", "table")
    checker, oracle = pc.Checker(robot, scene), pc.Checker(merged, still)
    q = robot.random_configurations(len(poses), seed)
    rows = np.concatenate([q, moving.rows], axis=1)
    free = oracle.check_states(rows)
    assert 0.02 < free.mean() < 0.98
    assert np.array_equal(checker.check_states(q, times=moving.times), free)
    assert np.array_equal(checker.check_states(q, 2, times=moving.times), free)
    assert np.array_equal(checker.first_colliding_pair(q, times=moving.times) < 0, free)
    assert np.array_equal(~checker.colliding_pairs(q, times=moving.times).any(axis=1), free)
    least = checker.clearances(q, times=moving.times)
    assert np.allclose(least, oracle.clearances(rows), atol=1e-9)
    for k in range(0, 3000, 300):
        assert checker.is_valid(q[k], time=k) == free[k]
        verdict = checker.explain(q[k], time=float(k))
        assert verdict.valid == free[k]
        assert {frozenset(v.names) for v in verdict.collisions} == {
            frozenset(v.names) for v in oracle.explain(rows[k]).collisions
        }


def test_between_its_poses_a_body_goes_straight_and_turns_at_constant_speed(tmp_path: Path) -> None:
    """Beside Pinocchio's interpolation of turns."""
    pin = pytest.importorskip("pinocchio")
    rng = np.random.default_rng(3)
    ends = np.array([random_pose(rng) for _ in range(2)])
    scene = pc.Scene()
    scene.add("pallet", pc.Box(_SIZE), pc.Moving([1.0, 3.0], ends))
    robot = _robot(tmp_path)
    checker = pc.Checker(robot, scene)
    at = checker.body_poses(robot.reference, times=[1.0, 1.5, 3.0])[:, -1]
    turn = pin.Quaternion(ends[0, :3, :3]).slerp(0.25, pin.Quaternion(ends[1, :3, :3])).matrix()
    assert np.allclose(at[[0, 2]], ends, atol=1e-14)
    assert np.allclose(at[1, :3, :3], turn, atol=1e-14)
    assert np.allclose(at[1, :3, 3], 0.75 * ends[0, :3, 3] + 0.25 * ends[1, :3, 3], atol=1e-14)


def test_without_times_a_scene_that_moves_is_an_error(tmp_path: Path) -> None:
    """In every method that judges states or motions."""
    robot = _robot(tmp_path)
    checker, q = pc.Checker(robot, _scene()), robot.reference
    asked = [
        lambda: checker.is_valid(q),
        lambda: checker.is_valid(q.tolist()),
        lambda: checker.check_states(q[None]),
        lambda: checker.first_colliding_pair(q[None]),
        lambda: checker.colliding_pairs(q[None]),
        lambda: checker.body_poses(q),
        lambda: checker.explain(q),
        lambda: checker.explain_pair(0, q),
        lambda: checker.clearance(q),
        lambda: checker.clearances(q[None]),
        lambda: checker.nearest_pair(q[None]),
        lambda: checker.check_motion(q, q),
        lambda: checker.check_motion(q, q, 0.01),
        lambda: checker.check_motions(q[None], q[None]),
        lambda: checker.check_motions(q[None], q[None], path="slerp"),
        lambda: checker.explain_motion(q, q),
        lambda: checker.certify_motions(q[None], q[None]),
        lambda: checker.motion_certifier,
        lambda: checker.state_validity(),
    ]
    for ask in asked:
        with pytest.raises(pc.PlannercheckError, match=r"'pallet' moves, so say when: times="):
            ask()


def test_beyond_its_data_an_object_is_refused_or_stands(tmp_path: Path) -> None:
    """The error names the object, its times and the remedy."""
    robot = _robot(tmp_path)
    checker, standing = pc.Checker(robot, _scene()), pc.Checker(robot, _scene("stand"))
    with pytest.raises(pc.PlannercheckError, match=r"'pallet' moves from 2 to 4 s.*not at 4.5 s.*outside='stand'"):
        checker.check_states(robot.reference, times=[2.5, 4.5])
    with pytest.raises(pc.PlannercheckError, match=r"not at 1\.9 s"):
        checker.is_valid(robot.reference, time=1.9)
    poses = standing.body_poses(robot.reference, times=[-9.0, 2.0, 4.0, 9.0])
    assert np.array_equal(poses[0], poses[1])
    assert np.array_equal(poses[2], poses[3])
    for times in ([np.nan], [[2.0]], "soon", [2.0, np.inf], []):
        with pytest.raises(pc.PlannercheckError, match="times must be"):
            standing.check_states(robot.reference, times=times)
    with pytest.raises(pc.PlannercheckError, match=r"one a configuration, \(2,\)"):
        standing.check_states(np.stack([robot.reference] * 2), times=[2, 3, 4])


def test_bodies_fixed_to_the_world_are_tested_against_what_moves(tmp_path: Path) -> None:
    """The pallet goes through the base; the table, which it goes through as well, does not count."""
    robot = _robot(tmp_path)
    checker = pc.Checker(robot, _scene(), self_collision=False)
    q, times = np.repeat(robot.reference[None], 41, axis=0), np.linspace(2, 4, 41)
    names = [checker.pair_names(k) for k in range(len(checker.pairs))]
    assert ("base", "pallet") in names
    assert ("base", "table") not in names
    assert ("table", "pallet") not in names
    base = names.index(("base", "pallet"))
    expected = np.abs(times - 3) <= (0.3 + 0.2) / 2 + 1e-12
    assert np.array_equal(checker.colliding_pairs(q, times=times)[:, base], expected)
    scene = _scene()
    scene.allow("pallet", "base")
    assert ("base", "pallet") not in [
        pc.Checker(robot, scene).pair_names(k) for k in range(len(pc.Checker(robot, scene).pairs))
    ]


def test_objects_that_share_how_they_move_are_on_one_joint(tmp_path: Path) -> None:
    """As are those of a scene that was saved and read, and never tested against each other."""
    robot, scene = _robot(tmp_path), _scene("stand")
    scene.add("load", pc.Sphere(0.1), scene.object("pallet").moving)
    scene.add("other", pc.Sphere(0.1), _crossing())
    checker = pc.Checker(robot, scene)
    assert checker._moving is not None
    assert checker._moving.checker.robot.nq == robot.nq + 2 * 7
    assert checker.robot.nq == robot.nq
    pairs = {frozenset(checker.pair_names(k)) for k in range(len(checker.pairs))}
    assert not pairs & {frozenset(("load", "pallet")), frozenset(("load", "other")), frozenset(("table", "load"))}
    scene.save(tmp_path / "scene.yaml")
    read = pc.Checker(robot, pc.Scene.load(tmp_path / "scene.yaml"))
    q = robot.random_configurations(200, 0)
    times = np.linspace(2, 4, 200)
    assert np.array_equal(checker.check_states(q, times=times), read.check_states(q, times=times))


def test_changed_scenes_pickles_and_copies_agree_with_new_checkers(tmp_path: Path) -> None:
    """From a scene at rest to one that moves, on to others, and back."""
    robot, scene = _robot(tmp_path), _scene("stand")
    q, times = robot.random_configurations(300, 1), np.linspace(1, 5, 300)
    still = pc.Scene("still")
    still.add_box("table", (0.2, 0.2, 0.2), random_pose(np.random.default_rng(5), np.array([0.5, 0, 0.1])))
    slower = _scene("stand")
    slower.remove("pallet")
    slower.add("pallet", pc.Box(_SIZE), pc.Moving([0.0, 9.0], _crossing().poses))
    wider = _scene("stand")
    wider.add_sphere("ball", 0.2, random_pose(np.random.default_rng(2)))
    checker = pc.Checker(robot, still)
    for each in (scene, wider, slower, still, scene):
        checker = checker.with_scene(each)
        fresh = pc.Checker(robot, each)
        expected = fresh.check_states(q, times=times)
        for other in (checker, pickle.loads(pickle.dumps(checker)), copy.copy(checker)):
            assert np.array_equal(other.check_states(q, times=times), expected)
    assert 0 < expected.mean() < 1
    group = checker.with_group(robot.joint_names[:2])
    assert group.check_states(q[:, :2], times=times).shape == (300,)
    assert checker.statistics()["states"] > 0
    assert left_out_pairs(checker)[-1].left >= 0
    assert np.array_equal(checker.with_bodies(checker.bodies).check_states(q, times=times), expected)
    posed = pc.Checker(robot, scene, kinematics="pinocchio")
    assert np.array_equal(posed.check_states(q, times=times), expected)
    plain = pc.Checker(robot, scene, tuning=pc.Tuning(reach=False, apart_cells=False, static_poses=False))
    assert np.array_equal(plain.check_states(q, times=times), expected)
    assert len(checker.polytopes) == len(checker.bodies)


def test_what_the_robot_carries_is_tested_against_what_moves(tmp_path: Path) -> None:
    """A pallet far from the arm hits what it carries."""
    robot, scene = _robot(tmp_path, 1), pc.Scene()
    far = np.array([np.eye(4)] * 2)
    far[:, :3, 3] = [[-1, 3, 0], [1, 3, 0]]
    scene.add("pallet", pc.Box(_SIZE), pc.Moving([0.0, 1.0], far))
    checker = pc.Checker(robot, scene, self_collision=True)
    carrying = checker.attach("pole", pc.Box((0.02, 8, 0.02)), "base")
    assert checker.is_valid(robot.reference, time=0.5)
    assert carrying.is_valid(robot.reference, time=0.0)
    verdict = carrying.explain(robot.reference, time=0.5)
    assert {"pole", "pallet"} in [set(pair.names) for pair in verdict.collisions]
    released = carrying.detach("pole", q=robot.reference)
    assert released.is_valid(robot.reference, time=0.5) or {"pole", "pallet"} not in [
        set(pair.names) for pair in released.explain(robot.reference, time=0.5).collisions
    ]
    with pytest.raises(pc.PlannercheckError, match="'pallet' moves by itself"):
        checker.attach("pallet", None, "base")


def test_all_kinds_of_bodies_move(tmp_path: Path) -> None:
    """A solid, a cloud and parts give the verdicts of the same bodies at rest, where they are then."""
    rng = np.random.default_rng(8)
    robot = _robot(tmp_path, 2)
    pose = random_pose(rng, np.array([0.1, 0.1, 0.3]))
    ends = np.array([pose, pose])
    ends[:, 0, 3] += [-0.4, 0.4]
    corners = np.array([[0, 0, 0], [0.3, 0, 0], [0, 0.3, 0], [0, 0, 0.3]])
    solid = pc.Solid(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    shapes = {
        "solid": solid,
        "cloud": pc.PointCloud(rng.uniform(-0.2, 0.2, (40, 3)), radius=0.02),
        "parts": [pc.Part(pc.Sphere(0.1), random_pose(rng)), pc.Part(pc.Box((0.1, 0.2, 0.3)))],
        "mesh": pc.Hull(corners),
    }
    q = robot.random_configurations(100, 3)
    for name, shape in shapes.items():
        moving = pc.Scene()
        moving.add(name, shape, pc.Moving([0.0, 2.0], ends))
        moving.allow("base", name)
        checker = pc.Checker(robot, moving, self_collision=False)
        for time in (0.0, 0.5, 1.0):
            there = ends[0].copy()
            there[0, 3] += 0.4 * time
            still = pc.Scene()
            still.add(name, shape, there)
            expected = pc.Checker(robot, still, self_collision=False).clearances(q)
            assert np.allclose(checker.clearances(q, times=time), expected, atol=1e-7)


def test_an_object_rides_on_a_link_of_another_robot(tmp_path: Path) -> None:
    """The other robot's bodies do not count; the object is where the link is."""
    robot, other = _robot(tmp_path, 2), pc.Robot.load("panda")
    base = random_pose(np.random.default_rng(1), np.array([0.5, 0, 0.2]))
    ways = np.stack([other.reference, other.reference + 0.5])
    trajectory = pc.Trajectory([0.0, 3.0], ways, controller="linear")
    scene = pc.Scene()
    scene.add("tool", pc.Box((0.1, 0.1, 0.1)), pc.Moving.along(trajectory, "panda_hand", (other, base), 1.0))
    scene.add("elbow", pc.Sphere(0.1), pc.Moving.along(trajectory, "panda_link4", (other, base), 1.0, "refuse"))
    checker = pc.Checker(robot, scene)
    poses = checker.body_poses(robot.reference, times=2.5)[0]
    there = base @ other.link_poses(trajectory.position(1.5))
    for k, link in ((-2, "panda_hand"), (-1, "panda_link4")):
        assert np.allclose(poses[k], there[other.link_index(link)], atol=1e-12)
    assert checker._moving is not None
    assert checker._moving.checker.robot.nq == robot.nq + other.nq
    restored = pickle.loads(pickle.dumps(checker))
    assert np.array_equal(restored.body_poses(robot.reference, times=2.5)[0], poses)
    with pytest.raises(pc.PlannercheckError, match=r"'tool' moves from 1 to 4 s"):
        checker.is_valid(robot.reference, time=0.0)
    with pytest.raises(pc.PlannercheckError, match="no scene file"):
        scene.save(tmp_path / "scene.yaml")
    for faulty, message in (
        (pc.Moving.along(trajectory, "panda_foot", other), "link that 'tool' rides on"),
        (pc.Moving.along(trajectory, "panda_hand", robot), "which has 7 columns"),
        (pc.Moving.along("up", "panda_hand", other), "takes a pc.Trajectory"),
    ):
        scene = pc.Scene()
        scene.add("tool", pc.Sphere(0.1), faulty)
        with pytest.raises(pc.PlannercheckError, match=message):
            pc.Checker(robot, scene)


def test_a_robot_without_a_group_keeps_its_columns_beside_one_with_held_joints(tmp_path: Path) -> None:
    """Continuous joints take two numbers in the one and an angle in the other."""
    text = arm_urdf(np.random.default_rng(0), 2).replace('type="revolute"', 'type="continuous"')
    (tmp_path / "turning.urdf").write_text(text)
    whole = pc.Robot.from_urdf(tmp_path / "turning.urdf")
    held = pc.Robot.from_urdf(tmp_path / "turning.urdf", group=["j1"], reference={"j0": 0.3})
    trajectory = pc.Trajectory([0.0, 1.0], [[0.1], [2.0]], controller="linear")
    scene = pc.Scene()
    scene.add("tool", pc.Box((0.1, 0.1, 0.1)), pc.Moving.along(trajectory, "l1", (held, None)))
    checker = pc.Checker(whole, scene)
    q = whole.random_configurations(50, 0)
    poses = checker.body_poses(q, times=0.5)
    assert np.allclose(poses[:, -1], held.link_poses(trajectory.position(0.5))[held.link_index("l1")], atol=1e-12)
    assert np.allclose(
        checker.check_states(np.zeros((3, 2)), times=0.5), checker.check_states([[1, 0, 1, 0]] * 3, times=0.5)
    )


def test_names_of_links_are_refused(tmp_path: Path) -> None:
    """A moving object has a link of its own."""
    scene = pc.Scene()
    scene.add("base", pc.Box(_SIZE), _crossing())
    with pytest.raises(pc.PlannercheckError, match="'base' moves, but a link or joint"):
        pc.Checker(_robot(tmp_path), scene)


def test_an_object_whose_carrier_has_names_of_others(tmp_path: Path) -> None:
    """Pinocchio finds a link by the first of its name: an object 'a' on 'l0' would ride on 'a/l0' of the cell."""
    (tmp_path / "arm.urdf").write_text(arm_urdf(np.random.default_rng(0), 2))
    arm, base = pc.Robot.from_urdf(tmp_path / "arm.urdf"), np.eye(4)
    base[0, 3] = 2.0
    cell = pc.Robot.together({"a": arm, "b": (arm, base)})
    ride = pc.Moving.along(pc.Trajectory([0, 1], np.zeros((2, 2))), "l0", (arm, base))
    poses = np.tile(np.eye(4), (2, 1, 1))
    for names, twice in (
        (("a",), "'a/j0' would be that of two joints"),
        (("m", "m/l0"), "'m/l0' would be that of two l"),
    ):
        scene = pc.Scene("riding")
        for name, moving in zip(names, (ride, pc.Moving([0, 1], poses)), strict=False):
            scene.add(name, pc.Sphere(0.1), moving)
        with pytest.raises(pc.PlannercheckError, match=twice):
            pc.Checker(cell, scene)
