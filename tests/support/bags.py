"""Bags as ROS 2 records them, with messages of trajectories."""

from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer

import plannercheck as pc
from plannercheck.trajectories.bags import known_types

STORE = known_types()
_EMPTY = {"string": "", "bool": False, "float64": 0.0, "int32": 0, "uint32": 0, "byte": 0, "uint8": 0}


def empty(name: str, **fields: Any) -> Any:
    """A message of rosbags' own classes, whose other fields are empty."""
    for field, (kind, what) in STORE.fielddefs[name][1]:
        if field in fields:
            continue
        if kind.name == "BASE":
            fields[field] = _EMPTY[what[0]]
        elif kind.name == "NAME":
            fields[field] = empty(what)
        else:
            numbers = what[0][0].name == "BASE" and what[0][1][0] == "float64"
            fields[field] = np.zeros(0) if numbers else []
    return STORE.types[name](**fields)


def message_of(trajectory: pc.Trajectory) -> Any:
    """A JointTrajectory of a trajectory's points."""
    given = trajectory.points
    points = [
        empty(
            "trajectory_msgs/msg/JointTrajectoryPoint",
            positions=q,
            velocities=v,
            accelerations=a,
            time_from_start=empty("builtin_interfaces/msg/Duration", sec=int(t), nanosec=round(t % 1 * 1e9)),
        )
        for t, q, v, a in zip(given.times.tolist(), given.positions, given.velocities, given.accelerations, strict=True)
    ]
    return empty("trajectory_msgs/msg/JointTrajectory", joint_names=list(given.joint_names), points=points)


def bag_of(folder: Path, plugin: StoragePlugin, *messages: Any) -> Path:
    """A bag with a topic a message."""
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        for k, message in enumerate(messages):
            kind = message.__msgtype__
            connection = writer.add_connection(f"/topic{k}", kind, typestore=STORE)
            writer.write(connection, k, STORE.serialize_cdr(message, kind))
    return folder
