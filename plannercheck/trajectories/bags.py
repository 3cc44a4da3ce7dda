"""Trajectories in bags that ROS records.

In: the folder or file of a bag. Out: its JointTrajectory messages with their topics, as plain data.

Bags are read by rosbags, in Python alone. A bag of ROS 2 before Iron in SQLite has no definitions of its messages: then
those of MoveIt are taken from here.
"""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from plannercheck.common.checked_yaml import Node, mapping
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.optional_imports import extra_module
from plannercheck.trajectories.messages import joint_trajectories

# Types whose messages hold trajectories, without their packages.
_TYPES = ("JointTrajectory", "RobotTrajectory", "DisplayTrajectory", "FollowJointTrajectoryActionGoal")

# MoveIt's messages that rosbags does not know, fields as `type name`.
_DEFINITIONS = {
    "object_recognition_msgs/msg/ObjectType": "string key, string db",
    "moveit_msgs/msg/CollisionObject": "std_msgs/Header header, geometry_msgs/Pose pose, string id, "
    "object_recognition_msgs/ObjectType type, shape_msgs/SolidPrimitive[] primitives, "
    "geometry_msgs/Pose[] primitive_poses, shape_msgs/Mesh[] meshes, geometry_msgs/Pose[] mesh_poses, "
    "shape_msgs/Plane[] planes, geometry_msgs/Pose[] plane_poses, string[] subframe_names, "
    "geometry_msgs/Pose[] subframe_poses, byte operation",
    "moveit_msgs/msg/AttachedCollisionObject": "string link_name, moveit_msgs/CollisionObject object, "
    "string[] touch_links, trajectory_msgs/JointTrajectory detach_posture, float64 weight",
    "moveit_msgs/msg/RobotState": "sensor_msgs/JointState joint_state, "
    "sensor_msgs/MultiDOFJointState multi_dof_joint_state, "
    "moveit_msgs/AttachedCollisionObject[] attached_collision_objects, bool is_diff",
    "moveit_msgs/msg/RobotTrajectory": "trajectory_msgs/JointTrajectory joint_trajectory, "
    "trajectory_msgs/MultiDOFJointTrajectory multi_dof_joint_trajectory",
    "moveit_msgs/msg/DisplayTrajectory": "string model_id, moveit_msgs/RobotTrajectory[] trajectory, "
    "moveit_msgs/RobotState trajectory_start",
}


def read_bag(path: Path) -> list[tuple[str, Node]]:
    """The JointTrajectory messages of a bag, in the order of their time, with topic and type in words."""
    reading = extra_module("rosbags.highlevel", "rosbags", "bags")
    if path.is_dir() and not (path / "metadata.yaml").exists():
        raise PlannercheckError("is no bag: a folder without metadata.yaml")
    try:
        with reading.AnyReader([path], default_typestore=known_types()) as reader:
            chosen = [c for c in reader.connections if c.msgtype.rpartition("/")[2] in _TYPES]
            messages = [
                (f"{connection.topic} ({connection.msgtype})", _plain(reader.deserialize(data, connection.msgtype)))
                for connection, _, data in (reader.messages(connections=chosen) if chosen else ())
            ]
            topics = sorted({f"{c.topic} ({c.msgtype})" for c in reader.connections})
    except Exception as error:  # of rosbags, of SQLite, of decompressors
        raise PlannercheckError(f"is no bag that rosbags reads: {type(error).__name__}: {error!s:.300}") from None
    if not messages:
        raise PlannercheckError(f"has no messages of {', '.join(_TYPES)}; its topics: {', '.join(topics) or 'none'}")
    return [(topic, found) for topic, message in messages for found in joint_trajectories(_without_goal(message))]


def known_types() -> Any:
    """Types of ROS 2 and MoveIt, for bags without definitions."""
    systems = extra_module("rosbags.typesys", "rosbags", "bags")
    store = systems.get_typestore(systems.Stores.ROS2_HUMBLE)
    for name, listed in _DEFINITIONS.items():
        store.register(systems.get_types_from_msg("\n".join(listed.split(", ")), name))
    return store


def _plain(value: Any) -> Any:
    """A message as mappings, lists and numbers."""
    if is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value) if field.name[0] != "_"}
    if isinstance(value, np.ndarray):
        return value.tolist()
    return [_plain(item) for item in value] if isinstance(value, list) else value


def _without_goal(message: Any) -> Node:
    node = mapping(message, "a message")
    return mapping(node["goal"], "'goal'") if "goal" in node else node
