"""The collision geometries of a robot's file with their meshes as they were delivered, concave as they may be.

In: a robot's description. Out: Pinocchio's geometry model, in the order of the robot's bodies. What the files are
warned of has been said where the robot was loaded.
"""

from __future__ import annotations

import warnings

import pinocchio as pin

from plannercheck.robots.description import RobotDescription
from plannercheck.robots.mjcf import geometry_model, read_mjcf_robot
from plannercheck.robots.urdf import read_geometry, read_model
from plannercheck.robots.urdf_file import MJCF_ROOT


def collision_geometry(description: RobotDescription) -> pin.GeometryModel:
    """Reads the geometries of a URDF, a xacro or an MJCF file, without pairs."""
    file = description.file
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        if file.kind == MJCF_ROOT:
            return geometry_model(read_mjcf_robot(file.path, description.floating))
        return read_geometry(read_model(file, description.floating), file, description.package_dirs)
