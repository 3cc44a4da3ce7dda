"""No field of `Tuning` changes a verdict: each one off, and all, on states and motions of robots among obstacles."""

import numpy as np
import pinocchio as pin
import pytest
from poses import at
from proof_cases import whole_robot

import plannercheck as pc
from plannercheck.bodies.tuning import core_tuning, tuning_table
from plannercheck.motions import certifier_pairs

TOLERANCES = (1e-6, 1e-4, 2e-2)
SWITCHES = tuple(row.name for row in tuning_table() if row.type == "bool")


ROBOTS = {
    "panda": lambda: pc.Robot.load("panda"),
    "ur5": lambda: pc.Robot.load("ur5"),
    "pr2": lambda: pc.Robot.load("pr2"),  # continuous joints, grippers that mimic
    "tiago whole": lambda: whole_robot("tiago"),  # cosines and sines, a prismatic torso
    "two pandas": lambda: pc.Robot.together(
        {"left": pc.Robot.load("panda"), "right": (pc.Robot.load("panda"), at(0.9))}
    ),
    "go2 floating": lambda: whole_robot("go2", floating=True),
}


def scattered(generator, count, size):
    """A scene of small boxes, spheres and tetrahedra around the robot."""
    scene = pc.Scene("scattered")
    for k in range(count):
        pose = np.eye(4)
        pose[:3, :3] = pin.exp3(generator.normal(size=3))
        angle, far = generator.uniform(0, 2 * np.pi), generator.uniform(0.6, 1.4)
        pose[:3, 3] = far * np.cos(angle), far * np.sin(angle), generator.uniform(0.2, 1.2)
        if k % 3 == 0:
            scene.add_sphere(f"ball{k}", float(generator.uniform(0.01, size / 2)), pose)
        elif k % 3 == 1:
            scene.add_hull(f"tetrahedron{k}", size * generator.normal(size=(4, 3)), pose)
        else:
            scene.add_box(f"box{k}", generator.uniform(0.001, size, 3), pose)
    return scene


def motions(checker, generator, n):
    """Short and long motions, some of them beyond the limits; most begin at valid states."""
    robot = checker.robot
    starts = robot.random_configurations(n, generator)
    tried = robot.random_configurations(20 * n, generator)
    valid = tried[checker.check_states(tried)]
    if len(valid):
        starts[n // 4 :] = np.resize(valid, (n - n // 4, robot.nq))
    if robot.group is None:
        others = robot.random_configurations(n, generator)
        parts = generator.uniform(0, 1, n)
        ends = [pin.interpolate(robot.model, a, b, t) for a, b, t in zip(starts, others, parts, strict=True)]
        return starts, np.array(ends)
    way = generator.normal(size=starts.shape) * 10.0 ** generator.uniform(-2.5, 0.3, (n, 1))
    ends = starts + way
    inside = generator.uniform(size=n) < 0.7
    ends[inside] = np.clip(ends[inside], robot.lower, robot.upper)
    return starts, ends


def curves(robot, starts, ends, generator):
    """Cubics from starts to ends that swing, and a small tube; unit vectors have none."""
    length = np.abs(ends - starts).max(axis=1)[:, None, None]
    points = np.linspace(starts, ends, 4, axis=1)
    points[:, 1:-1] += 0.3 * length * generator.normal(size=(len(starts), 2, robot.nq))
    tube = np.full(robot.nq, 1e-3)
    for first, past in robot.configuration_map.units:
        tube[first:past] = 0.0
    return [pc.Trajectory.bezier([0, 1], each[None]).of_robot(robot) for each in points], tube


def with_switches(robot, scene, own, switches=SWITCHES):
    """A checker with all switches on, one with each of some off, and one with all of them off."""
    chosen = [(), *((name,) for name in switches), switches]
    return [pc.Checker(robot, scene, self_collision=own, tuning=pc.Tuning().without(*off)) for off in chosen]


# Up to 1,024 obstacles are tested in lanes, more by the tree.
@pytest.mark.parametrize(
    ("name", "obstacles"), [*((name, 5) for name in ROBOTS), ("panda", 1100), ("go2 floating", 1100)]
)
def test_switches_change_no_verdict(name, obstacles):
    generator = np.random.default_rng(len(name) + obstacles)
    robot = ROBOTS[name]()
    scene = scattered(generator, obstacles, 0.2 if obstacles < 50 else 0.02)
    # Without an SRDF some robots always touch themselves.
    own = not name.startswith(("go2", "tiago"))
    few = obstacles < 50 and name != "two pandas"  # of many, and of two robots, those that choose among pairs
    checker, *others = with_switches(robot, scene, own, SWITCHES if few else ("bounds", "boxes", "overlaps"))
    starts, ends = motions(checker, generator, 100)
    pairs = checker.colliding_pairs(ends)
    for other in others:
        assert (other.colliding_pairs(ends) == pairs).all()
        assert (other.check_states(ends) == ~pairs.any(axis=1)).all()
    kinds = []
    for tolerance in TOLERANCES:
        free = checker.check_motions(starts, ends, tolerance=tolerance)
        for other in others:
            assert (other.check_motions(starts, ends, tolerance=tolerance) == free).all()
        kinds.append(free.mean())
        made, tube = curves(robot, starts, ends, generator)
        for around in (0.0, tube):
            free = checker.check_trajectories(made, around, tolerance)
            for other in others:
                assert (other.check_trajectories(made, around, tolerance) == free).all()
            kinds.append(free.mean())
    assert any(0 < kind < 1 for kind in kinds)


def without_halves(tuning):
    """The core's record, a copy of its own, with the one switch that Python's record does not have."""
    made = core_tuning.__wrapped__(tuning)
    made.halves = False
    return made


@pytest.mark.parametrize("name", ["panda", "ur5", "pr2"])
def test_curves_in_halves_and_whole_ones_agree_beyond_the_tolerance(name, monkeypatch):
    """Cubics that swing widely: whole ones take finer grids; nothing that collides is free, nothing clear refused."""
    generator = np.random.default_rng(len(name))
    robot = ROBOTS[name]()
    scene = scattered(generator, 5, 0.2)
    halved, whole = pc.Checker(robot, scene), pc.Checker(robot, scene)
    monkeypatch.setattr(certifier_pairs, "core_tuning", without_halves)
    assert whole.certifier_of("slerp") is not None  # built without, once and for all
    monkeypatch.undo()
    starts, ends = motions(halved, generator, 150)
    made, _ = curves(robot, starts, ends, generator)
    found = []
    for tolerance in TOLERANCES:
        free, plain = (checker.check_trajectories(made, tolerance=tolerance) for checker in (halved, whole))
        for k in np.flatnonzero(free != plain).tolist():
            assert halved.clearances(made[k].position(np.linspace(0, 1, 2000))).min() < 1.1 * tolerance
        for k in np.flatnonzero(free | plain)[:20].tolist():
            assert halved.check_states(made[k].position(np.linspace(0, 1, 200))).all()
        found += free.tolist()
    assert 0.1 < np.mean(found) < 0.95
    states = [checker.certifier_of("slerp").statistics()["states"] for checker in (halved, whole)]
    assert states[0] != states[1]


def test_batches_order_and_threads_do_not_matter():
    generator = np.random.default_rng(5)
    robot = pc.Robot.load("panda")
    scene = pc.Scene.load("bookshelf")
    checker, plain = pc.Checker(robot, scene), pc.Checker(robot, scene, tuning=pc.Tuning().without(*SWITCHES))
    starts, ends = motions(plain, generator, 400)
    free = plain.check_motions(starts, ends)
    order = generator.permutation(len(free))
    assert (checker.check_motions(starts[order], ends[order]) == free[order]).all()
    assert (checker.check_motions(starts, ends, threads=3) == free).all()
    parts = np.split(np.arange(len(free)), np.cumsum([1, 2, 3, 5, 8, 13, 21, 34]))
    assert (np.concatenate([checker.check_motions(starts[part], ends[part]) for part in parts]) == free).all()
    assert [checker.check_motion(a, b) for a, b in zip(starts, ends, strict=True)] == free.tolist()
    made, tube = curves(robot, starts, ends, generator)
    for around in (0.0, tube):
        free = plain.check_trajectories(made, around)
        assert 0 < free.mean() < 1
        assert (checker.check_trajectories([made[k] for k in order], around) == free[order]).all()
        assert (checker.check_trajectories(made, around, threads=3) == free).all()
        assert [checker.check_trajectory(each, around) for each in made] == free.tolist()


ARM = """<robot name="arm"><link name="base"/>
<link name="upper"><collision><origin xyz="0.25 0 0"/><geometry><box size="0.5 0.1 0.1"/></geometry></collision></link>
<link name="lower"><collision><origin xyz="0.25 0 0"/><geometry><box size="0.5 0.1 0.1"/></geometry></collision></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0.6 0 0"/>
<axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""


def test_motions_near_contact(tmp_path):
    """Two boxes turn under plates that are nearly in contact all the way, or only at one end."""
    (tmp_path / "arm.urdf").write_text(ARM)
    robot = pc.Robot.from_urdf(tmp_path / "arm.urdf")
    generator = np.random.default_rng(3)
    starts = generator.uniform(-1, 1, (20, 2))
    ends = starts + generator.uniform(-0.5, 0.5, starts.shape)
    verdicts = []
    for gap in (-1e-6, 0.0, 1e-6, 5e-5, 1e-4, 2e-4, 3e-4, 1e-3):
        for width in (3.0, 0.3):
            pose = at(1.2 if width < 1 else 0, 0, 0.05 + gap + 0.005)
            scene = pc.Scene("plate")
            scene.add_box("plate", [width, width, 0.01], pose)
            found = [c.check_motions(starts, ends).tolist() for c in with_switches(robot, scene, own=True)]
            assert found.count(found[0]) == len(found)
            verdicts += found[0]
    assert 0.1 < np.mean(verdicts) < 0.9


def test_bounds_and_balls_save_work():
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    with_bounds, without_bounds, without_balls = (
        pc.Checker(robot, scene, tuning=pc.Tuning().without(*off)) for off in ((), ("bounds",), ("overlaps",))
    )
    starts, ends = motions(with_bounds, np.random.default_rng(2), 200)
    for checker in (with_bounds, without_bounds, without_balls):
        checker.check_motions(starts, ends)
    pairs, all_pairs = (c.motion_certifier.statistics()["pairs"] for c in (with_bounds, without_bounds))
    assert pairs < 0.8 * all_pairs
    swept, all_swept = (c.motion_certifier.statistics()["swept"] for c in (with_bounds, without_balls))
    assert swept < all_swept


BALLS = """<robot name="balls"><link name="base"/>
<link name="left"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="right"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="left"/><axis xyz="1 0 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="y" type="prismatic"><parent link="base"/><child link="right"/><axis xyz="1 0 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""


def test_balls_that_hardly_move(tmp_path):
    """Bounds of speed and of paths are exact for balls that hardly move."""
    (tmp_path / "balls.urdf").write_text(BALLS)
    robot = pc.Robot.from_urdf(tmp_path / "balls.urdf")
    gaps = np.array([2e-5, 5e-5, 9e-5, 1.5e-4, 3e-4, 1e-3])
    starts = np.stack([np.zeros(len(gaps)), 0.2 + gaps], axis=1)
    found = [c.check_motions(starts, starts + 1e-9).tolist() for c in with_switches(robot, None, own=True)]
    assert found.count(found[0]) == len(found)
    assert all(found[0])


def test_balls_that_pass_through_each_other(tmp_path):
    """Far apart at both ends, which are the only states that are posed: they slide."""
    (tmp_path / "balls.urdf").write_text(BALLS)
    robot = pc.Robot.from_urdf(tmp_path / "balls.urdf")
    for checker in with_switches(robot, None, own=True):
        assert not checker.check_motion(np.array([-1.0, 0.0]), np.array([1.5, 0.0]))


def test_middles_that_collide_do_not_hide_that_rounding_is_too_large():
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    q = robot.random_configurations(400, 1)
    q = q[~pc.Checker(robot, scene).check_states(q)][:10]
    for checker in with_switches(robot, scene, own=True):
        assert not checker.check_motions(q, q).any()
        with pytest.raises(pc.PlannercheckError, match="rounding"):
            checker.check_motions(q, q, tolerance=1e-13)


@pytest.mark.parametrize("way", [30.0, 300.0, 1000.0, 3000.0, 10000.0, 1e5])
def test_middles_of_far_motions_do_not_hide_that_rounding_is_too_large(way):
    """Motions so far that only their curvature decides whether rounding is too large."""
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    q = robot.random_configurations(400, 1)
    q = q[~pc.Checker(robot, scene).check_states(q)][:10]

    for checker in with_switches(robot, scene, own=True):
        if way < 500:
            assert not checker.check_motions(q - way, q + way).any()
        else:
            with pytest.raises(pc.PlannercheckError, match="rounding"):
                checker.check_motions(q - way, q + way)


def test_middles_that_often_collide_are_judged_first():
    """Sets of motions between free ends: many whose middles collide, none, and again many; then paths of ten."""
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    checker, plain = pc.Checker(robot, scene), pc.Checker(robot, scene, tuning=pc.Tuning(middle_states=False))
    starts, ends = (robot.random_configurations(12000, seed) for seed in (1, 2))
    ends = starts + 0.3 * (ends - starts)
    middles = plain.check_states((starts + ends) / 2)
    free = np.flatnonzero(plain.check_motions(starts, ends))
    colliding = np.flatnonzero(~middles)
    assert min(len(colliding), len(free)) > 1000
    grids = []
    for kind, size in ((colliding, 1000), (free, 1000), (colliding, 1000), (free, 10), (colliding, 10)):
        a, b = starts[kind[:1000]], ends[kind[:1000]]
        for _ in range(3):
            before = checker.motion_certifier.statistics()["grids"]
            sets = [slice(k, k + size) for k in range(0, 1000, size)]
            found = np.concatenate([checker.check_motions(a[part], b[part]) for part in sets])
            assert (found == (kind is free)).all()
            grids.append((checker.motion_certifier.statistics()["grids"] - before) / len(a))
    assert max(grids[0], grids[2], grids[8], grids[14]) < 0.05
    assert min(grids[6], grids[12]) > 0  # at first they are taken for motions like those before
    assert max(grids[6], grids[12]) < 0.6
    assert min(grids[3:6] + grids[9:12]) >= 1


def test_late_states_that_often_collide_are_judged_first():
    """Sets of motions with free middles and ends that collide at three quarters; most are refused without a grid."""
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    checker, plain = pc.Checker(robot, scene), pc.Checker(robot, scene, tuning=pc.Tuning(middle_states=False))
    starts, ends = (robot.random_configurations(30000, seed) for seed in (1, 2))
    ends = starts + 0.4 * (ends - starts)
    early, late, last = (plain.check_states(starts + t * (ends - starts)) for t in (0.5, 0.75, 1.0))
    chosen = np.flatnonzero(early & ~late & last)
    assert len(chosen) > 200
    a, b = starts[chosen], ends[chosen]
    for _ in range(3):
        assert not checker.check_motions(a, b).any()
    before = checker.motion_certifier.statistics()["grids"]
    assert not checker.check_motions(a, b).any()
    assert checker.motion_certifier.statistics()["grids"] - before < 0.1 * len(chosen)


def test_motions_of_links_with_several_bodies(tmp_path):
    """Balls, boxes and directions of whole links leave out no pair: two links of several pieces near each other."""
    pieces = "".join(
        f'<collision><origin xyz="{x} 0 {z}" rpy="0.3 {x} 0"/><geometry><box size="0.08 0.05 0.06"/></geometry>'
        "</collision>"
        for x, z in ((0.05, 0), (0.15, 0.02), (0.25, -0.02), (0.35, 0.03))
    )
    joint = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
    <origin xyz="{place}"/><axis xyz="{axis}"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>"""
    joints = [("a", "base", "left", "0 0 0", "0 0 1"), ("b", "base", "yaw", "0 0.3 0", "0 0 1")]
    joints.append(("c", "yaw", "right", "0 0 0", "1 0 0"))
    (tmp_path / "pieces.urdf").write_text(
        f'<robot name="pieces"><link name="base"/><link name="yaw"/><link name="left">{pieces}</link>'
        f'<link name="right">{pieces}</link>'
        + "".join(joint.format(name=n, parent=p, child=c, place=o, axis=x) for n, p, c, o, x in joints)
        + "</robot>"
    )
    robot = pc.Robot.from_urdf(tmp_path / "pieces.urdf")
    scene = pc.Scene("post")
    pose = at(0.4, 0.15, 0)
    scene.add_box("post", [0.05, 0.05, 0.4], pose)
    generator = np.random.default_rng(4)
    checker, *others = with_switches(robot, scene, own=True)
    starts = robot.random_configurations(3000, 5)
    starts = starts[checker.check_states(starts)]
    ends = starts + generator.normal(size=starts.shape) * 10.0 ** generator.uniform(-2, 0, (len(starts), 1))
    for tolerance in (1e-4, 1e-3, 1e-2):
        free = checker.check_motions(starts, ends, tolerance=tolerance)
        assert 0.1 < free.mean() < 0.95
        for other in others:
            assert (other.check_motions(starts, ends, tolerance=tolerance) == free).all()


def test_links_of_several_bodies_that_meet_between_states(tmp_path):
    """An arm of two pieces swings into a wall of two by 0.4 mm, half way between two states of the grid."""

    def box(x, z, size):
        return f'<collision><origin xyz="{x} 0 {z}"/><geometry><box size="{size}"/></geometry></collision>'

    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    arm = box(0.625, 0, "0.25 0.002 0.05") + box(0.875, 0, "0.25 0.002 0.05")
    wall = box(1.0496, -0.1, "0.1 0.5 0.2") + box(1.0496, 0.1, "0.1 0.5 0.2")
    (tmp_path / "wall.urdf").write_text(
        f'<robot name="wall"><link name="base"/><link name="arm">{arm}</link><link name="wall">{wall}</link>'
        '<joint name="swing" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>'
        f'{limit}</joint><joint name="up" type="prismatic"><parent link="base"/><child link="wall"/>'
        f'<axis xyz="0 0 1"/>{limit}</joint></robot>'
    )
    robot = pc.Robot.from_urdf(tmp_path / "wall.urdf")
    for checker in with_switches(robot, None, own=True):
        assert checker.check_states(np.array([[-0.12, 0.0], [-0.04, 0.0], [0.04, 0.0], [0.12, 0.0]])).all()
        assert not checker.is_valid(np.zeros(2))
        assert not checker.check_motion(np.array([-0.12, 0.0]), np.array([0.12, 0.0]))


def test_ends_that_often_collide_are_judged_first():
    """Sets of motions with free middles: many whose ends collide, none, and again many; at last, with others."""
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    checker, plain = pc.Checker(robot, scene), pc.Checker(robot, scene, tuning=pc.Tuning(middle_states=False))
    starts, ends = (robot.random_configurations(12000, seed) for seed in (1, 2))
    ends = starts + 0.3 * (ends - starts)
    valid = [plain.check_states(q) for q in (starts, (starts + ends) / 2, ends)]
    colliding = np.flatnonzero(valid[0] & valid[1] & ~valid[2])
    free = np.flatnonzero(valid[0] & valid[1] & valid[2])
    assert min(len(colliding), len(free)) > 300
    grids = []
    for kind in (colliding, free, colliding):
        a, b = starts[kind[:1000]], ends[kind[:1000]]
        found = checker.check_motions(a, b)
        assert (found == plain.check_motions(a, b)).all()
        assert found.any() == (kind is free)
        before = checker.motion_certifier.statistics()["grids"]
        assert (checker.check_motions(a, b) == found).all()
        grids.append((checker.motion_certifier.statistics()["grids"] - before) / len(a))
    assert max(grids[0], grids[2]) < 0.3 < grids[1]
    blocked = np.flatnonzero(valid[0] & ~valid[1])  # their ends are not judged
    mixed = np.random.default_rng(3).permutation(np.concatenate([colliding[:300], free[:300], blocked[:150]]))
    a, b = starts[mixed], ends[mixed]
    assert (checker.check_motions(a, b) == plain.check_motions(a, b)).all()


def test_tubes_as_thin_as_rounding_change_no_verdict():
    """What a controller runs has such a tube: how far its own evaluation may be off."""
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    generator = np.random.default_rng(8)
    on, off = (pc.Checker(robot, scene, tuning=pc.Tuning(thin_tubes=each)) for each in (True, False))
    starts, ends = motions(on, generator, 200)
    run = [
        pc.Trajectory([0.0, 1.0, 2.0], [a, b, a], [0 * a, generator.normal(size=7), 0 * a])
        for a, b in zip(starts, ends, strict=True)
    ]
    assert min(each.curve.error.min() for each in run) > 0
    for tolerance in TOLERANCES:
        free = on.check_trajectories(run, 0.0, tolerance)
        assert 0 < free.mean() < 1
        assert (off.check_trajectories(run, 0.0, tolerance) == free).all()
