"""Goals that are poses reach the user's inverse kinematics as MoveIt means them, and become goals in joint space.

moveit2, moveit_core/kinematic_constraints/src/utils.cpp, `constructGoalConstraints(link_name, pose, ...)`:

    pcm.link_name = link_name;
    pcm.target_point_offset.x = 0; ...
    bv.type = shape_msgs::msg::SolidPrimitive::SPHERE; ...
    // orientation of constraint region does not affect anything, since it is a sphere
    pcm.constraint_region.primitive_poses[0].position = pose.pose.position;
    ...
    ocm.orientation = pose.pose.orientation;

and kinematic_constraint.cpp, `PositionConstraint::decide`:

    Eigen::Vector3d pt = state.getGlobalLinkTransform(link_model_) * offset_;
    ...  constraint_region_[i]->containsPoint(pt, true);

`OrientationConstraint::configure`: `if (fabs(q.norm() - 1.0) > 1e-3)` ... "Assuming identity instead."
"""

import copy

import numpy as np
import pinocchio
import pytest
import yaml

import plannercheck as pc
from plannercheck.common.errors import PlannercheckError
from plannercheck.scenes.motion_bench_maker import load_problems
from plannercheck.scenes.moveit_goals import PoseGoal
from plannercheck.scenes.moveit_request import motion_request, read_request

JOINTS = [f"panda_joint{k}" for k in range(1, 8)]
START = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
GOAL = [0.5, 0.3, 0.1, -2.0, 0.2, 2.3, 0.785]
LINK = "panda_hand"


def pose_constraints(pose, frame="world", offset=(0.0, 0.0, 0.0)):
    """What MoveIt writes for a point on the link, `offset` in its frame, to be at a pose."""
    quaternion = pinocchio.Quaternion(pose[:3, :3]).coeffs()
    x, y, z = (float(v) for v in pose[:3, 3])
    position = {
        "header": {"frame_id": frame},
        "link_name": LINK,
        "target_point_offset": dict(zip("xyz", offset, strict=True)),
        "constraint_region": {
            "primitives": [{"type": 2, "dimensions": [0.001]}],
            "primitive_poses": [
                {"position": {"x": x, "y": y, "z": z}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 0}}
            ],
            "meshes": [],
            "mesh_poses": [],
        },
        "weight": 1.0,
    }
    orientation = {
        "header": {"frame_id": frame},
        "orientation": dict(zip("xyzw", map(float, quaternion), strict=True)),
        "link_name": LINK,
        "absolute_x_axis_tolerance": 0.01,
        "absolute_y_axis_tolerance": 0.01,
        "absolute_z_axis_tolerance": 0.01,
        "parameterization": 1,
        "weight": 1.0,
    }
    return {
        "name": "",
        "joint_constraints": [],
        "position_constraints": [position],
        "orientation_constraints": [orientation],
    }


def request(*goals):
    return {
        "group_name": "panda_arm",
        "start_state": {"joint_state": {"name": JOINTS, "position": START}},
        "goal_constraints": [copy.deepcopy(goal) for goal in goals],
    }


@pytest.fixture(scope="module")
def robot():
    return pc.Robot.load("panda")


def hand(robot, q):
    return robot.link_poses(np.array(q))[robot.link_names.index(LINK)]


def answer(*goals):
    """An inverse kinematics that says the same whatever it is asked, and what it was asked."""
    asked = []

    def ik(goal):
        asked.append(goal)
        return goals[0] if len(goals) == 1 else list(goals)

    return ik, asked


VALUES = dict(zip(JOINTS, GOAL, strict=True))


@pytest.mark.parametrize("offset", [(0.0, 0.0, 0.0), (0.01, -0.02, 0.1)])
def test_the_pose_is_the_links_whatever_point_of_it_is_given(robot, tmp_path, offset):
    wanted = hand(robot, GOAL)
    point = wanted.copy()
    point[:3, 3] = wanted[:3, :3] @ offset + wanted[:3, 3]  # where the constraint has that point of the link
    (tmp_path / "r.yaml").write_text(yaml.safe_dump(request(pose_constraints(point, offset=offset))))
    ik, asked = answer(VALUES)
    read = read_request(tmp_path / "r.yaml", ik)
    assert read.goals == (VALUES,)
    (goal,) = asked
    assert isinstance(goal, PoseGoal)
    assert (goal.link, goal.frame, goal.group) == (LINK, "world", "panda_arm")
    assert goal.start == dict(zip(JOINTS, START, strict=True))
    assert np.abs(goal.pose - wanted).max() < 1e-14


def test_several_solutions_are_several_goals_and_joint_goals_stay(robot):
    joints = {"joint_constraints": [{"joint_name": name, "position": 0.25} for name in JOINTS]}
    other = {name: value + 0.1 for name, value in VALUES.items()}
    ik, _ = answer(VALUES, other)
    read = motion_request(request(joints, pose_constraints(hand(robot, GOAL))), ik)
    assert read.goals == (dict.fromkeys(JOINTS, 0.25), VALUES, other)


def test_problem_sets_take_an_inverse_kinematics_and_know_the_scenes_frames(robot, tmp_path):
    frame = pinocchio.XYZQUATToSE3(np.array([1.0, 2, 3, 0, 0, 0.6, 0.8])).homogeneous
    q = frame[:3, 3].tolist(), [0.0, 0.0, 0.6, 0.8]
    scene = {
        "fixed_frame_transforms": [
            {
                "header": {"frame_id": "table"},
                "child_frame_id": "world",
                "transform": {"translation": q[0], "rotation": q[1]},
            }
        ],
        "world": {"collision_objects": []},
    }
    wanted = hand(robot, GOAL)
    goal = pose_constraints(np.linalg.inv(frame) @ wanted, "table")
    (tmp_path / "scene0001.yaml").write_text(yaml.safe_dump(scene))
    (tmp_path / "request0001.yaml").write_text(yaml.safe_dump(request(goal)))
    ik, asked = answer(VALUES)
    (problem,) = load_problems(tmp_path, ik)
    assert problem.goal.tolist() == GOAL
    assert (asked[0].frame, problem.joint_names) == ("world", tuple(JOINTS))
    assert np.abs(asked[0].pose - wanted).max() < 1e-14
    with pytest.raises(PlannercheckError, match=r"request0001\.yaml: goal_constraints 0: position_constraints are not"):
        list(load_problems(tmp_path))


def test_an_ik_that_solves_reaches_the_pose(robot):
    """The whole way round: MoveIt's goal, damped least squares by Pinocchio, and the link is where MoveIt wants it."""
    model, data = robot.model, robot.model.createData()
    frame = model.getFrameId(LINK)

    def ik(goal):
        target, q = pinocchio.SE3(goal.pose), robot.expand(np.array([goal.start[name] for name in JOINTS]))
        for _ in range(200):
            pinocchio.framesForwardKinematics(model, data, q)
            error = pinocchio.log(data.oMf[frame].actInv(target)).vector
            jacobian = pinocchio.computeFrameJacobian(model, data, q, frame)[:, :7]
            step = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 1e-9 * np.eye(6), error)
            q[:7] += step
        return dict(zip(JOINTS, q[:7], strict=True))

    wanted = hand(robot, GOAL)
    (found,) = motion_request(request(pose_constraints(wanted)), ik).goals
    assert np.abs(hand(robot, [found[name] for name in JOINTS]) - wanted).max() < 1e-9


def changed(*path, value):
    goal = pose_constraints(np.eye(4))
    node = goal
    for key in path[:-1]:
        node = node[key]
    node[path[-1]] = value
    return goal


P, R = ("position_constraints", 0), ("orientation_constraints", 0)
REGION = (*P, "constraint_region")


@pytest.mark.parametrize(
    ("goal", "message"),
    [
        (changed("orientation_constraints", value=[]), "of orientation_constraints there are 0"),
        (changed("position_constraints", value=[]), "of position_constraints there are 0"),
        (changed("joint_constraints", value=[{"joint_name": "a", "position": 1}]), "either joint_constraints or"),
        (changed("visibility_constraints", value=[{}]), "visibility_constraints are not supported"),
        (changed(*R, "link_name", value="panda_link8"), "the orientation of link 'panda_link8'"),
        (changed(*R, "header", value={"frame_id": "map"}), "both must be of one link in one frame"),
        (changed(*R, "orientation", value=[0, 0, 0, 1.01]), "of length 1, not 1.01: MoveIt takes the identity"),
        (changed(*R, "orientation", value=[0, 0, 0, 0]), "quaternion of length 1, not 0"),
        (changed(*R, "colour", value=1), "orientation_constraints: unknown key 'colour'"),
        (changed(*P, "link_name", value=None), "position_constraints: key 'link_name' is missing"),
        (changed(*P, "target_point_offset", value=[0, 0]), "'target_point_offset' needs 3 numbers"),
        (changed(*REGION, "primitives", value=[{}, {}]), "given are 2 primitives, 1 primitive_poses, 0 meshes"),
        (changed(*REGION, "meshes", value=[{}]), "constraint_region: it must be one of primitives"),
        (changed(*REGION, "primitive_poses", value=[{"position": "here"}]), "'position' must be a list"),
    ],
)
def test_poses_that_are_none_are_named(goal, message):
    with pytest.raises(PlannercheckError, match=f"^goal_constraints 0: .*{message}"):
        motion_request(request(goal), answer(VALUES)[0])


@pytest.mark.parametrize(
    ("found", "message"),
    [
        (None, "the inverse kinematics finds no joint values for link 'panda_hand'"),
        ([], "finds no joint values"),
        ({}, "must return values by joint name"),
        ([1.0, 2.0], "must return values by joint name, several such mappings, or None, not 1.0"),
        (np.ones(7), "must return values by joint name"),
        (1.0, "must return values by joint name"),
        ({"panda_joint1": float("nan")}, "'panda_joint1' must be a finite number"),
    ],
)
def test_what_an_ik_must_not_return_is_named(found, message):
    with pytest.raises(PlannercheckError, match=f"goal_constraints 0: .*{message}"):
        motion_request(request(pose_constraints(np.eye(4))), lambda goal: found)


def test_poses_without_an_ik_say_where_one_is_given():
    with pytest.raises(PlannercheckError, match=r"without an inverse kinematics, .* read_request\(path, ik=function"):
        motion_request(request(pose_constraints(np.eye(4))))
