"""Motions of free bodies as OMPL interpolates: held against OMPL's own states, against screws, and against bounds."""

import dataclasses
import json

import numpy as np
import pinocchio as pin
import pytest
from ompl import base
from proof_cases import free_motions, random_tree, scattered

import plannercheck as pc
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.proof_builder import Builder
from plannercheck.ompl.pose_space import PoseSpace
from plannercheck.proofs import Motion, Proof
from plannercheck.proofs.chains import Chains
from plannercheck.validation.paths import validate_path

BRICK = """<robot name="brick"><link name="brick"><collision><geometry><box size="0.4 0.2 0.1"/></geometry></collision>
</link></robot>"""
# A ball that moves on a floor, a lift on it, and a body that flies from there.
PAIR = """<robot name="pair"><link name="floor"/>
<link name="sled"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
<link name="kite"><collision><origin xyz="0.4 0 0"/><geometry><box size="2 0.6 0.1"/></geometry></collision></link>
<joint name="slide" type="planar"><parent link="floor"/><child link="sled"/><origin xyz="0.1 0 0" rpy="0.3 0.2 0.1"/>
<axis xyz="0 0 1"/></joint>
<link name="lift"/><joint name="rise" type="prismatic"><parent link="sled"/><child link="lift"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="fly" type="floating"><parent link="lift"/><child link="kite"/><origin xyz="0 0 0.2"/></joint></robot>"""
WIDE = np.array([[-20.0] * 3, [20.0] * 3])
TIMES = np.linspace(0, 1, 101)


def robot_of(tmp_path, text, **more):
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    return pc.Robot.from_urdf(path, **more)


def placed(*position):
    return np.vstack([np.column_stack([np.eye(3), position]), [0, 0, 0, 1]])


def scene_of(**spheres):
    scene = pc.Scene("spheres")
    for name, (radius, position) in spheres.items():
        scene.add_sphere(name, radius, placed(*position))
    return scene


def unit(rng, q, start):
    q[:, start : start + 4] = rng.normal(size=(len(q), 4))
    q[:, start : start + 4] /= np.linalg.norm(q[:, start : start + 4], axis=1)[:, None]


def poses(rng, n, spread=0.6):
    """Of the brick, (n, 7)."""
    q = spread * rng.normal(size=(n, 7))
    unit(rng, q, 3)
    return q


def pair_states(rng, n):
    """Of sled and kite, (n, 12), the kite 2 to 5 m from its joint."""
    q = np.zeros((n, 12))
    q[:, 4] = rng.uniform(-0.5, 0.5, n)
    angle = rng.uniform(-3, 3, n)
    q[:, :2], q[:, 2], q[:, 3] = rng.normal(size=(n, 2)), np.cos(angle), np.sin(angle)
    away = rng.normal(size=(n, 3))
    q[:, 5:8] = away / np.linalg.norm(away, axis=1)[:, None] * rng.uniform(2, 5, (n, 1))
    unit(rng, q, 8)
    return q


def interpolated(robot, q0, q1, times=TIMES):
    """(k, nq) of OMPL's own interpolation."""
    space = PoseSpace(robot, WIDE)
    information = base.SpaceInformation(space.ompl_space())
    return space.curve_states(space.state(information, q0), space.state(information, q1), times)


def test_states_are_those_of_ompl(tmp_path):
    rng = np.random.default_rng(1)
    for text, floating, draw in ((BRICK, True, poses), (PAIR, False, pair_states)):
        checker = pc.Checker(robot_of(tmp_path, text, floating=floating), scene_of(ball=(0.1, (9, 9, 9))))
        q0, q1 = draw(rng, 20), draw(rng, 20)
        for a, b in zip(q0, q1, strict=True):
            theirs = checker.robot.link_poses(interpolated(checker.robot, a, b))
            proved = checker.certifier_of("slerp").states(a, b, TIMES)
            sampled = checker.motion_sampler.states(a, b, TIMES, "slerp")
            np.testing.assert_allclose(checker.robot.link_poses(proved), theirs, atol=1e-13)
            np.testing.assert_allclose(checker.robot.link_poses(sampled), theirs, atol=1e-13)


@pytest.mark.parametrize("seed", range(3))
def test_accepted_motions_are_free_at_all_of_ompls_states(tmp_path, seed):
    rng = np.random.default_rng(seed)
    checker = pc.Checker(
        robot_of(tmp_path, BRICK, floating=True), scene_of(a=(0.2, (0.3, 0.2, 0)), b=(0.15, (-0.4, 0, 0.3)))
    )
    q0, q1 = poses(rng, 60), poses(rng, 60)
    free = checker.check_motions(q0, q1, path="slerp")
    assert 5 < free.sum() < 55
    for k in range(len(q0)):
        states = interpolated(checker.robot, q0[k], q1[k])
        if free[k]:
            assert checker.check_states(states).all()
        else:
            verdict = checker.explain_motion(q0[k], q1[k], path="slerp")
            assert not verdict.free
            near = verdict.near if verdict.collides_at is None else verdict.collides_at
            state = checker.certifier_of("slerp").states(q0[k], q1[k], np.array([near]))[0]
            assert checker.clearance(state) <= 1e-4 + 1e-9
        assert checker.check_motion(q0[k], q1[k], path="slerp") == free[k]
    assert (free != checker.check_motions(q0, q1)).any()
    sampled = checker.check_motions(q0, q1, resolution=0.01, path="slerp")
    assert (sampled >= free).all()


def test_contacts_by_construction_are_refused(tmp_path):
    """A ball is put where it just touches a corner of the brick at one of OMPL's states, or just misses it."""
    rng = np.random.default_rng(5)
    robot = robot_of(tmp_path, BRICK, floating=True)
    corner, sharp = np.array([0.2, 0.1, 0.05]), 0
    for _ in range(40):
        a, b = poses(rng, 2, 1.0)
        at = rng.uniform(0.2, 0.8)
        pose = robot.link_poses(interpolated(robot, a, b, np.array([at]))[0])[0]
        out = pose[:3, :3] @ (corner / np.linalg.norm(corner))
        point = pose[:3, :3] @ corner + pose[:3, 3]
        touching = pc.Checker(robot, scene_of(ball=(0.05, point + out * (0.05 - 1e-7))))
        sharp += bool(touching.check_states([a, b]).all())
        assert not touching.check_motion(a, b, path="slerp")
    assert sharp > 20


def test_screws_and_straight_lines_part(tmp_path):
    """A half turn on the way: the screw goes round an arc, the straight line through its middle."""
    start, end = np.array([-1, 0, 0, 0, 0, 0, 1.0]), np.array([1, 0, 0, 0, 0, np.sin(1.5), np.cos(1.5)])
    robot = robot_of(tmp_path, BRICK, floating=True)
    empty = pc.Checker(robot, scene_of(far=(0.1, (9, 9, 9))))
    on_screw = empty.certifier_of("screw").states(start, end, np.array([0.5]))[0, :3]
    assert np.linalg.norm(on_screw) > 0.8
    middle = pc.Checker(robot, scene_of(ball=(0.2, (0, 0, 0))))
    aside = pc.Checker(robot, scene_of(ball=(0.2, on_screw)))
    assert not middle.check_motion(start, end, path="slerp")
    assert middle.check_motion(start, end)
    assert middle.check_motion(start, end, path="screw")
    assert aside.check_motion(start, end, path="slerp")
    assert not aside.check_motion(start, end)
    assert aside.check_motion(start, end, resolution=0.01, path="slerp")
    assert not aside.check_motion(start, end, resolution=0.01)


def test_robots_without_free_bodies_move_alike():
    scene = pc.Scene.load("table")
    checker = pc.Checker(pc.Robot.load("panda"), scene)
    assert checker.certifier_of("slerp") is checker.motion_certifier
    for path in ("screw", "slerp"):
        assert checker.check_motion(scene.start("panda"), scene.start("panda"), path=path)
    with pytest.raises(PlannercheckError, match=r"path 'straight'.*screw, slerp"):
        checker.check_motion(scene.start("panda"), scene.start("panda"), path="straight")


def test_points_leave_their_chords_by_no_more_than_the_bound(tmp_path):
    """Seen from either body, at random."""
    rng = np.random.default_rng(2)
    checker = pc.Checker(robot_of(tmp_path, PAIR), scene_of(ball=(0.1, (30, 0, 0))))
    q0 = pair_states(rng, 30)
    q1 = q0 + 0.01 * rng.normal(size=q0.shape)
    q1[:, 8:] += 0.5 * rng.normal(size=(30, 4))
    for start, stop in ((2, 4), (8, 12)):
        q1[:, start:stop] /= np.linalg.norm(q1[:, start:stop], axis=1)[:, None]
    found = [each for a, b in zip(q0, q1, strict=True) for each in rooms(checker, a, b)]
    assert len(found) > 30
    assert "kite" in {frame for frame, _ in found}
    assert min(room for _, room in found) >= -1e-9


def test_a_turn_far_away_swings_what_it_is_seen_from(tmp_path):
    """Seen from the kite, which turns 5 m away, the sled swings on an arc towards the kite's own box."""
    far = PAIR.replace('<origin xyz="0.4 0 0"/>', '<origin xyz="7 0 0"/>')
    checker = pc.Checker(robot_of(tmp_path, far), scene_of(ball=(0.1, (30, 0, 0))))
    a = np.array([0, 0, 1, 0, 0, -5, 0, 0, 0, 0, np.sin(-0.2), np.cos(0.2)])
    b = np.array([0, 0, 1, 0, 0, -5, 0.02, 0, 0, 0, np.sin(0.2), np.cos(0.2)])
    found = [room for frame, room in rooms(checker, a, b) if frame == "kite"]
    assert found
    assert min(found) >= -1e-9


def rooms(checker, a, b):
    """Of each proof of a motion, its frame, and how much further apart than it says the bodies are all along, m."""
    robot, out = checker.robot, []
    for proof in checker.explain_motion(a, b, proofs=True, path="slerp").proofs:
        t = np.linspace(proof.start, proof.end, 41)
        links = robot.link_poses(interpolated(robot, a, b, t))
        heights = []
        for body in (proof.first_body, proof.second_body):
            item = checker.bodies[body]
            place = placed(0, 0, 0) if item.link is None else links[:, robot.link_index(item.link)]
            points = corners(item) @ item.pose[:3, :3].T + item.pose[:3, 3]
            world = np.einsum("...ij,kj->...ki", place[..., :3, :3], points) + place[..., None, :3, 3]
            if proof.frame is not None:
                frame = links[:, robot.link_index(proof.frame)]
                world = np.einsum("tji,tkj->tki", frame[:, :3, :3], world - frame[:, None, :3, 3])
            heights.append(np.broadcast_to(world @ proof.normal, (len(t), len(points))))
        gap = heights[0].min(axis=1) - heights[1].max(axis=1)
        out.append((proof.frame, gap.min() - min(gap[0], gap[-1]) + proof.chord_deviation))
    return out


def corners(item):
    """Points of a body whose hull it is, but for its radius."""
    if isinstance(item.shape, pc.Sphere):
        return np.zeros((1, 3))
    return np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * np.array(item.shape.size) / 2


# ----- paths and proofs


@pytest.fixture
def aside(tmp_path):
    """A checker, and a motion that is free on the straight line alone."""
    start, end = np.array([-1, 0, 0, 0, 0, 0, 1.0]), np.array([1, 0, 0, 0, 0, np.sin(1.5), np.cos(1.5)])
    robot = robot_of(tmp_path, BRICK, floating=True)
    on_screw = pc.Checker(robot, scene_of(far=(0.1, (9, 9, 9)))).motion_certifier.states(start, end, np.array([0.5]))
    return pc.Checker(robot, scene_of(ball=(0.2, on_screw[0, :3]))), start, end


def test_paths_are_validated_and_drawn_as_they_were_planned(aside):
    checker, start, end = aside
    assert validate_path(checker, [start, end], motion_path="slerp").passed
    stopped = validate_path(checker, [start, end]).stopped
    assert stopped is not None
    assert not stopped.free
    frames, _ = pc.view.along_path(checker, [start, end], 10, "slerp")
    assert checker.check_states(frames).all()
    assert not frames[:, 1:3].any()
    planar = pc.planar.Checker(pc.planar.Robot.load("forklift"))
    with pytest.raises(PlannercheckError, match="motion paths are of robots in space"):
        validate_path(planar, [[0.0, 0, 0], [1, 0, 0]], motion_path="slerp")


def changed(proof, **changes):
    fields = {field.name: getattr(proof, field.name) for field in dataclasses.fields(proof)}
    return Proof(**{**fields, "motion": dataclasses.replace(proof.motion, **changes)})


def test_proofs_name_their_path_and_hold_for_no_other(aside):
    checker, start, end = aside
    (proof,) = checker.certify_motions(start[None], end[None], path="slerp")
    assert proof.motion.path == "slerp"
    assert proof.verify()
    assert not changed(proof, path="screw").verify()
    assert "path is 'arc'" in changed(proof, path="arc").verify().fault
    explained = checker.explain_motion(start, end, path="slerp").proof
    assert explained.motion == proof.motion
    assert explained.verify()
    assert checker.certify_motions(start[None], end[None]) == (None,)


@pytest.mark.parametrize("suffix", [".json", ".npz"])
def test_files_keep_the_path(aside, tmp_path, suffix):
    checker, start, end = aside
    (proof,) = checker.certify_motions(start[None], end[None], path="slerp")
    proof.save(tmp_path / f"proof{suffix}")
    again = Proof.load(tmp_path / f"proof{suffix}")
    assert again.motion == proof.motion
    assert again.verify()


def test_files_without_a_path_are_of_screws(aside, tmp_path):
    checker, start, _ = aside
    (proof,) = checker.certify_motions(start[None], start[None])
    file = tmp_path / "proof.json"
    proof.save(file)
    assert "path" not in json.loads(file.read_text())["motions"][0]["motion"]
    assert Proof.load(file).motion.path == "screw"


@pytest.mark.parametrize("seed", range(6))
def test_random_trees_are_proved(seed, tmp_path):
    generator = np.random.default_rng(seed)
    kinds = ("planar", "floating", "revolute", "continuous")
    robot = pc.Robot.from_urdf(random_tree(generator, tmp_path, links=4, kinds=kinds), floating=bool(seed % 2))
    checker = pc.Checker(robot, scattered(generator))
    q0, q1 = free_motions(checker, 2, seed)
    for proof in checker.certify_motions(q0, q1, path="slerp"):
        assert proof is None or proof.verify(), proof.verify().fault


def test_jets_hold_poses_and_derivatives(tmp_path):
    """The verifier's second-order jets, over intervals, beside poses of OMPL's states and their differences."""
    rng = np.random.default_rng(8)
    robot = robot_of(tmp_path, PAIR)
    checker = pc.Checker(robot, scene_of(ball=(0.1, (30, 0, 0))))
    a, b = pair_states(rng, 2)
    model, ends = Builder(checker)._model, (tuple(a.tolist()), tuple(b.tolist()))
    chains, step = Chains(model, Motion(*ends, ends[1], "slerp")), 2.0**-10
    joint = next(k for k, joint in enumerate(model.joints) if joint.name == "fly")
    lift = robot.model.getJointId("fly")
    for low, high in ((0.25, 0.375), (0.5, 0.53125)):
        jet = chains.jet((low, high), model.joints[joint].parent, joint)
        for t in np.linspace(low + step, high - step, 4):
            states = interpolated(robot, a, b, np.array([t - step, t, t + step]))
            x, y, z = (robot.model.jointPlacements[lift].homogeneous @ pose_of(q[5:12]) for q in states)
            differences = y, (z - x) / (2 * step), (z - 2 * y + x) / step**2
            for part, numbers, slack in zip(jet, differences, (1e-12, 1e-4, 1e-2), strict=True):
                room = slack * (1 + np.abs(numbers).max())
                for ball, number in zip(part.entries(), numbers.ravel().tolist(), strict=True):
                    assert float(ball.lower()) - room <= number <= float(ball.upper()) + room


def pose_of(q):
    """(4, 4) of x, y, z and a quaternion."""
    return pin.XYZQUATToSE3(q).homogeneous
