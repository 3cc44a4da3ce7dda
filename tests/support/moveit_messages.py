"""MoveIt scenes with objects in frames, and where they belong: poses are composed with Pinocchio alone.

In: names of frames, poses as position and quaternion x, y, z, w. Out: nodes of messages, scenes, poses (4, 4).
"""

from pathlib import Path

import numpy as np
import pinocchio as pin
import yaml

from plannercheck.scenes.moveit_scene import read_planning_scene
from plannercheck.scenes.scene import Scene
from plannercheck.scenes.scene_paths import FindFile

STATE = {
    "panda_joint1": 0.3,
    "panda_joint2": -0.4,
    "panda_joint3": 0.2,
    "panda_joint4": -2.0,
    "panda_joint5": 0.5,
    "panda_joint6": 1.8,
    "panda_joint7": 0.9,
    "panda_finger_joint1": 0.02,
}

# Frames off the planning frame, all turned: position, then quaternion x, y, z, w.
MAP = [0.4, -0.7, 0.1, 0.0, 0.0, 0.6, 0.8]
TAG = [-0.2, -0.9, 0.99, 0.48, 0.6, 0.0, 0.64]
OFFSET = [0.05, -0.1, 0.2, 0.6, 0.0, 0.0, 0.8]
SHORT = [0.0, 0.02, 0.03, 0.0, 0.8, 0.0, 0.6]


def se3(numbers):
    return pin.XYZQUATToSE3(np.array(numbers, dtype=float)).homogeneous


def pose_node(numbers):
    return {"position": list(numbers[:3]), "orientation": list(numbers[3:])}


def numbers_of(matrix):
    return pin.SE3ToXYZQUAT(pin.SE3(matrix)).tolist()


def fixed(frame, numbers, planning="panda_link0"):
    """An entry as `Transforms::copyTransforms` writes it: child_frame_id is the planning frame."""
    transform = {"translation": list(numbers[:3]), "rotation": list(numbers[3:])}
    return {"header": {"frame_id": frame}, "child_frame_id": planning, "transform": transform}


IDENTITY = [0, 0, 0, 0, 0, 0, 1]
EXPORTED = [fixed("panda_link0", IDENTITY), fixed("map", MAP), fixed("vicon/tag/tag", TAG)]


def ball(name, frame, numbers, radius=0.02, **more):
    header = {} if frame is None else {"header": {"frame_id": frame}}
    primitives = [{"type": "sphere", "dimensions": [radius]}]
    return {"id": name, **header, "primitives": primitives, "primitive_poses": [pose_node(numbers)], **more}


def state_of(values=STATE, attached=(), **more):
    joints = {"name": list(values), "position": list(values.values())}
    return {"joint_state": joints, "attached_collision_objects": list(attached), **more}


def scene_of(*objects, transforms=EXPORTED, state=None, **more):
    document = {
        "robot_model_name": "panda",
        "fixed_frame_transforms": transforms,
        "robot_state": state or {},
        "world": {"collision_objects": list(objects)},
        **more,
    }
    scene = Scene()
    read_planning_scene(scene, yaml.safe_load(yaml.safe_dump(document)), FindFile(Path()))
    return scene


def link_pose(robot, link, values=STATE):
    """By Pinocchio alone: forward kinematics of the model at values by joint name, followers as they follow."""
    model, q = robot.model, pin.neutral(robot.model)
    values = {**values, **({"panda_finger_joint2": values["panda_finger_joint1"]} if values is STATE else {})}
    for name, value in values.items():
        q[model.joints[model.getJointId(name)].idx_q] = value
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    return data.oMf[model.getBodyId(link)].homogeneous


def configuration(robot, values=STATE):
    return np.array([values[name] for name in robot.joint_names])


def body_pose(checker, name, q):
    names = [body.name for body in checker.bodies]
    return checker.body_poses(q)[0, names.index(name)]


def tray(name, frame, numbers, **more):
    """A box whose own pose is given, with a turned subframe."""
    return {
        "id": name,
        "header": {"frame_id": frame},
        "pose": pose_node(numbers),
        "primitives": [{"type": 1, "dimensions": [0.04, 0.04, 0.01]}],
        "primitive_poses": [pose_node([0, 0, 0.1, 0, 0, 0, 1])],
        "subframe_names": ["rim"],
        "subframe_poses": [pose_node(TAG)],
        **more,
    }
