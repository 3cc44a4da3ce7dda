"""OMPL's SE(3) and SE(2) for robots with free bodies: states, bounds, what OMPL does near half a turn, and plans."""

import numpy as np
import pytest
from ompl import base
from poses import at

import plannercheck as pc
from plannercheck.common.errors import PlannercheckError
from plannercheck.ompl import setup, space_of
from plannercheck.ompl.pose_parts import has_free_bodies
from plannercheck.ompl.pose_space import PoseSpace

BRICK = """<robot name="brick"><link name="brick"><collision><geometry><box size="0.4 0.2 0.1"/></geometry></collision>
</link></robot>"""
# Of every kind: planar, continuous, bounded and floating.
TRAIN = """<robot name="train"><link name="ground"/><link name="a"/><link name="b"/><link name="c"/>
<link name="d"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="planar" type="planar"><parent link="ground"/><child link="a"/><axis xyz="0 0 1"/></joint>
<joint name="turn" type="continuous"><parent link="a"/><child link="b"/><axis xyz="1 0 0"/></joint>
<joint name="slide" type="prismatic"><parent link="b"/><child link="c"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="2" effort="1" velocity="1"/></joint>
<joint name="fly" type="floating"><parent link="c"/><child link="d"/></joint></robot>"""
BOX = [[-3.0, -3.0, -3.0], [3.0, 3.0, 3.0]]
HERE, TURNED = [-1.0, 0, 0, 0, 0, 0, 1], [1.0, 0, 0, 0, 0, 1, 0]


def robot_of(tmp_path, text=BRICK, floating=True, group=None):
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    return pc.Robot.from_urdf(path, floating=floating, group=group)


def checker_of(tmp_path, *boxes):
    """The brick among boxes, each of a size and a position, m."""
    scene = pc.Scene("boxes")
    for k, (size, position) in enumerate(boxes):
        pose = at(*position)
        scene.add_box(f"box {k}", size, pose)
    return pc.Checker(robot_of(tmp_path), scene)


def states_of(space, *rows):
    information = base.SpaceInformation(space.ompl_space())
    return [space.state(information, np.array(q, dtype=float)) for q in rows]


def test_a_free_body_has_ompls_space(tmp_path):
    space = PoseSpace(robot_of(tmp_path), BOX)
    made = space.ompl_space()
    assert isinstance(made, base.SE3StateSpace)
    assert list(made.getBounds().high) == [3, 3, 3]
    q = [0.1, 0.2, 0.3, 0.5, -0.5, 0.5, 0.5]
    (state,) = states_of(space, q)
    assert (state.getX(), state.getZ(), state.rotation().y, state.rotation().w) == (0.1, 0.3, -0.5, 0.5)
    assert space.read(state) == q
    assert space.rows([state, state]).tolist() == [q, q]


@pytest.mark.parametrize("group", [None, ["planar", "turn", "slide", "fly"], ["fly", "slide"], ["planar"]])
def test_other_joints_stand_beside_it(tmp_path, group):
    robot = robot_of(tmp_path, TRAIN, False, group)
    space = PoseSpace(robot, BOX)
    made = space.ompl_space()
    assert has_free_bodies(robot)
    assert isinstance(made, base.SE2StateSpace if group == ["planar"] else base.CompoundStateSpace)
    made.setup()
    rng = np.random.default_rng(1)
    information = base.SpaceInformation(made)
    state = information.allocState()
    sampler = made.allocStateSampler() if hasattr(made, "allocStateSampler") else None
    for q in robot.random_configurations(20, rng):
        space.write(state, q)
        np.testing.assert_allclose(robot.link_poses(space.read(state)), robot.link_poses(q), atol=1e-14)
        assert made.satisfiesBounds(state)
        if sampler is not None:
            sampler.sampleUniform(state)
            assert robot.check_configurations(space.read(state)).shape == (1, robot.nq)
    q0, q1 = robot.random_configurations(2, rng)
    assert np.isfinite(space.differences(q0, q1)).all()
    assert not space.differences(q0, q0).any()


def test_differences_are_lengths_and_angles(tmp_path):
    space = PoseSpace(robot_of(tmp_path), BOX)
    half = np.sin(0.25), np.cos(0.25)
    found = space.differences(np.array(HERE), np.array([0, 2, 0, half[0], 0, 0, half[1]]))
    np.testing.assert_allclose(found, [1, 2, 0, 0.5])
    assert space.differences(np.array(HERE), -np.array(HERE) - [2, 0, 0, 0, 0, 0, 0])[3] == 0  # the same turn


def test_alike_turns_are_judged_as_ompl_goes_them(tmp_path):
    """OMPL keeps a turn that differs by less than 1e-4 rad to the end of the motion, and jumps there."""
    space = PoseSpace(robot_of(tmp_path), BOX)
    small = 3e-5
    a, b, c = states_of(
        space, HERE, [1, 0, 0, np.sin(small / 2), 0, 0, np.cos(small / 2)], [1, 0, 0, np.sin(2e-4), 0, 0, np.cos(2e-4)]
    )
    assert space.curve_states(a, b, np.array([0.99]))[0, 3:].tolist() == [0, 0, 0, 1]
    starts, ends, *others = space.pieces(a, b)
    assert len(starts) == 1
    assert ends[0].tolist() == space.read(b)
    assert others[0].tolist() == [space.read(a)]
    assert others[1].tolist() == [[1, 0, 0, 0, 0, 0, 1]]
    assert space.curve_states(a, c, np.array([0.99]))[0, 3] > 0
    assert not len(space.pieces(a, c)[2])


@pytest.mark.parametrize("sign", [1, -1])
def test_half_a_turn_goes_the_way_that_ompl_goes(tmp_path, sign):
    """A box is where the brick's end swings on one of the two ways."""
    checker = checker_of(tmp_path, ((0.1, 0.1, 0.3), (0, 0.2, 0)))
    found = setup(checker, bounds=BOX)
    information, space = found.getSpaceInformation(), space_of(checker, bounds=BOX)
    space.ompl_space()
    still = [0, -0.1, 0.0]
    for tiny in (0.0, 1e-17, -1e-17, 1e-12, -1e-12, 1e-3, -1e-3):
        end = np.array([*still, 0, 0, sign, tiny])
        end[3:] /= np.linalg.norm(end[3:])
        a, b = (space.state(information, np.array(q)) for q in ([*still, 0, 0, 0, 1.0], end))
        starts, ends, *_ = space.pieces(a, b)
        assert len(starts) == (1 if abs(tiny) == 1e-3 else 2)
        states = space.curve_states(a, b, np.linspace(0, 1, 200))
        way = checker.certifier_of("slerp").states
        on_pieces = [way(*piece, np.linspace(0, 1, 100)) for piece in zip(starts, ends, strict=True)]
        poses, ours = checker.robot.link_poses(states), checker.robot.link_poses(np.concatenate(on_pieces))
        nearest = np.abs(poses[:, None] - ours[None]).max(axis=(2, 3, 4)).min(axis=1)
        assert nearest.max() < 0.03
        assert information.checkMotion(a, b) <= checker.check_states(states).all()


def test_validators_follow_ompl(tmp_path):
    checker = checker_of(tmp_path, ((0.1, 2, 2), (0.5, 0, 0)))
    for resolution in (None, 0.01):
        found = setup(checker, resolution, bounds=BOX)
        information, space = found.getSpaceInformation(), space_of(checker, bounds=BOX)
        start, beyond, beside = (
            space.state(information, np.array(q, dtype=float))
            for q in (HERE, TURNED, [-1, 1, 0, 0, 0, np.sin(1), np.cos(1)])
        )
        assert information.checkMotion(start, beside)
        assert not information.checkMotion(start, beyond)
        validator = information.getMotionValidator()
        last = information.allocState()
        free, part = validator.checkMotionWithLastValid(start, beyond, last)
        assert not free
        assert 0.5 < part < 0.65
        assert checker.is_valid(space.read(last))
        np.testing.assert_allclose(space.read(last), space.curve_states(start, beyond, np.array([part]))[0], atol=1e-9)
        assert validator.checkMotionWithLastValid(start, beside) == (True, 1.0)


def test_motions_are_proved_where_ompl_goes(tmp_path):
    """A nearly half turn on the way: the screw would pass the box on an arc."""
    checker = checker_of(tmp_path, ((0.1, 0.1, 0.1), (0, 0, 0)))
    information, space = setup(checker, bounds=BOX).getSpaceInformation(), space_of(checker, bounds=BOX)
    a, b = (space.state(information, np.array(q)) for q in (HERE, [1, 0, 0, 0, 0, np.sin(1.5), np.cos(1.5)]))
    assert checker.check_motion(space.read(a), space.read(b))
    assert not information.checkMotion(a, b)
    assert not information.checkMotion(b, a)


def test_states_that_are_no_turns_are_refused(tmp_path):
    checker = checker_of(tmp_path, ((0.1, 2, 2), (0.5, 0, 0)))
    information, space = setup(checker, bounds=BOX).getSpaceInformation(), space_of(checker, bounds=BOX)
    a, b = (space.state(information, np.array(HERE)) for _ in range(2))
    b.rotation().w = 1 + 1e-8
    assert information.isValid(b)
    assert information.checkMotion(a, b)
    b.rotation().w = 1 + 1e-6
    with pytest.raises(PlannercheckError, match="quaternion, of length 1"):
        information.isValid(b)
    with pytest.raises(PlannercheckError, match="quaternion, of length 1"):
        information.checkMotion(a, b)


def test_bounds_are_around_everything_unless_they_are_given(tmp_path):
    empty, checker = checker_of(tmp_path), checker_of(tmp_path, ((0.1, 2, 2), (0.5, 0, 0)))
    with pytest.raises(PlannercheckError, match=r"'root_joint'.*by bounds="):
        setup(empty)
    bounds = setup(checker).getStateSpace().getBounds()
    reach = np.linalg.norm([0.2, 0.1, 0.05])
    np.testing.assert_allclose(bounds.low, np.array([0.45, -1, -1]) - 2 * reach)
    np.testing.assert_allclose(bounds.high, np.array([0.55, 1, 1]) + 2 * reach)
    for wrong in ([1, 2, 3], [[0, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, np.inf]], "wide"):
        with pytest.raises(PlannercheckError, match=r"bounds must be the least and the largest x, y, z"):
            setup(checker, bounds=wrong)
    with pytest.raises(PlannercheckError, match="beyond the bounds"):
        pc.ompl.plan(checker, [9, 0, 0, 0, 0, 0, 1], HERE, bounds=BOX)
    with pytest.raises(PlannercheckError, match="bounds are for robots with a floating"):
        setup(pc.Checker(pc.Robot.load("panda")), bounds=BOX)


@pytest.mark.parametrize("planner", ["RRTConnect", "KPIECE1", "PRM"])
def test_a_brick_is_planned_around_a_wall(tmp_path, planner):
    checker = checker_of(tmp_path, ((0.1, 1, 1), (0, 0, 0)))
    found = pc.ompl.plan(checker, HERE, TURNED, planner, time_limit=120, seed=2, bounds=np.array(BOX) / 2)
    assert found.solved
    np.testing.assert_array_equal(found.path[[0, -1]], [HERE, TURNED])
    assert checker.check_motions(found.path[:-1], found.path[1:], path="slerp").all()
    proofs = checker.certify_motions(found.path[:-1], found.path[1:], path="slerp")
    assert all(proof is not None and proof.verify() for proof in proofs)


def test_half_turns_of_a_path_have_a_state_in_their_middle(tmp_path):
    checker = checker_of(tmp_path, ((0.1, 1, 1), (0, 9, 0)))
    found = pc.ompl.plan(checker, HERE, TURNED, time_limit=120, seed=1, bounds=BOX, longest_motion=100.0)
    assert found.solved
    assert (np.abs((found.path[:-1, 3:] * found.path[1:, 3:]).sum(axis=1)) > 0.1).all()


def test_clearance_is_measured_where_ompl_goes(tmp_path):
    checker = checker_of(tmp_path, ((0.1, 0.1, 0.1), (0, 0.5, 0)))
    found = setup(checker, bounds=BOX)
    objective = pc.ompl.clearance_objective(checker, found)
    space = space_of(checker, bounds=BOX)
    a, b = (space.state(found.getSpaceInformation(), np.array(q)) for q in (HERE, TURNED))
    states = space.curve_states(a, b, np.linspace(0, 1, 400))
    assert objective.motionCost(a, b).value() == pytest.approx(-checker.clearances(states).min(), abs=0.02)
