"""Exact collision verdicts for motion planning, for any robot with a URDF.

Convex hulls of links and obstacles are preprocessed once into the hierarchies of Barba and Langerman ("Optimal
detection of intersections between convex polyhedra"); every verdict is exact for the given numbers.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from plannercheck.common.errors import PlannercheckError
from plannercheck.common.model_comparisons import (
    Comparison,
    Followers,
    RobotJoints,
    set_joint_reader,
    set_message_reader,
    set_model_comparison,
    set_path_reader,
)
from plannercheck.common.version import __version__

if TYPE_CHECKING:
    from plannercheck import ndim as ndim
    from plannercheck import ompl as ompl
    from plannercheck import planar as planar
    from plannercheck import view as view
    from plannercheck.bodies.certificates import Separation as Separation
    from plannercheck.bodies.certificates import SharedPoint as SharedPoint
    from plannercheck.bodies.convex_decomposition import Decomposition as Decomposition
    from plannercheck.bodies.distance import Distance as Distance
    from plannercheck.bodies.distance import distance as distance
    from plannercheck.bodies.distance import signed_distance as signed_distance
    from plannercheck.bodies.ellipsoids import Ellipsoid as Ellipsoid
    from plannercheck.bodies.half_spaces import HalfSpace as HalfSpace
    from plannercheck.bodies.height_fields import HeightField as HeightField
    from plannercheck.bodies.intersection import certify as certify
    from plannercheck.bodies.intersection import intersects as intersects
    from plannercheck.bodies.moving import Moving as Moving
    from plannercheck.bodies.objects import Part as Part
    from plannercheck.bodies.octrees import Octree as Octree
    from plannercheck.bodies.part_certificates import PartSeparation as PartSeparation
    from plannercheck.bodies.penetration_depth import Depth as Depth
    from plannercheck.bodies.penetration_depth import depth as depth
    from plannercheck.bodies.placed import Placed as Placed
    from plannercheck.bodies.point_clouds import PointCloud as PointCloud
    from plannercheck.bodies.polytope import Polytope as Polytope
    from plannercheck.bodies.shapes import Box as Box
    from plannercheck.bodies.shapes import Capsule as Capsule
    from plannercheck.bodies.shapes import Cone as Cone
    from plannercheck.bodies.shapes import Cylinder as Cylinder
    from plannercheck.bodies.shapes import Hull as Hull
    from plannercheck.bodies.shapes import Sphere as Sphere
    from plannercheck.bodies.solid_certificates import Enclosure as Enclosure
    from plannercheck.bodies.solid_separations import SolidSeparation as SolidSeparation
    from plannercheck.bodies.solids import Solid as Solid
    from plannercheck.bodies.tuning import Tuning as Tuning
    from plannercheck.bodies.voxel_grids import VoxelGrid as VoxelGrid
    from plannercheck.checking.clearance import distances_along as distances_along
    from plannercheck.checking.distances import Distances as Distances
    from plannercheck.checking.verdicts import ValidityReport as ValidityReport
    from plannercheck.checking.verdicts import Verdict as Verdict
    from plannercheck.coverings.audits import Audit as Audit
    from plannercheck.coverings.audits import AuditedLink as AuditedLink
    from plannercheck.coverings.covering import Covering as Covering
    from plannercheck.motions.checker import Checker as Checker
    from plannercheck.motions.free_boxes import FreeBox as FreeBox
    from plannercheck.motions.free_boxes import FreeBoxes as FreeBoxes
    from plannercheck.robots.robot import Robot as Robot
    from plannercheck.scenes.scene import Scene as Scene
    from plannercheck.timing.conflicts import Conflict as Conflict
    from plannercheck.timing.conflicts import first_conflict as first_conflict
    from plannercheck.timing.least_delay import LeastDelay as LeastDelay
    from plannercheck.timing.least_delay import least_delay as least_delay
    from plannercheck.timing.schedule import Schedule as Schedule
    from plannercheck.timing.schedule import schedule as schedule
    from plannercheck.timing.time_path import UnprovedPathError as UnprovedPathError
    from plannercheck.timing.time_path import time_path as time_path
    from plannercheck.trajectories.trajectory import Trajectory as Trajectory
    from plannercheck.validation.gates.gate import Gate as Gate
    from plannercheck.validation.gates.verdict import GateVerdict as GateVerdict
    from plannercheck.validation.gates.verdict import Reason as Reason

# Loaded on first use, so that `import plannercheck` costs nothing that is not needed.
_HOMES = {
    "Audit": "coverings.audits",
    "AuditedLink": "coverings.audits",
    "Box": "bodies.shapes",
    "Capsule": "bodies.shapes",
    "Checker": "motions.checker",
    "Conflict": "timing.conflicts",
    "Covering": "coverings.covering",
    "Depth": "bodies.penetration_depth",
    "Cone": "bodies.shapes",
    "Cylinder": "bodies.shapes",
    "Decomposition": "bodies.convex_decomposition",
    "Distance": "bodies.distance",
    "Distances": "checking.distances",
    "FreeBox": "motions.free_boxes",
    "FreeBoxes": "motions.free_boxes",
    "Gate": "validation.gates.gate",
    "GateVerdict": "validation.gates.verdict",
    "Ellipsoid": "bodies.ellipsoids",
    "Enclosure": "bodies.solid_certificates",
    "HalfSpace": "bodies.half_spaces",
    "HeightField": "bodies.height_fields",
    "Hull": "bodies.shapes",
    "LeastDelay": "timing.least_delay",
    "Moving": "bodies.moving",
    "Octree": "bodies.octrees",
    "Part": "bodies.objects",
    "PartSeparation": "bodies.part_certificates",
    "Placed": "bodies.placed",
    "PointCloud": "bodies.point_clouds",
    "Polytope": "bodies.polytope",
    "Reason": "validation.gates.verdict",
    "Robot": "robots.robot",
    "Scene": "scenes.scene",
    "Schedule": "timing.schedule",
    "Separation": "bodies.certificates",
    "SharedPoint": "bodies.certificates",
    "Solid": "bodies.solids",
    "SolidSeparation": "bodies.solid_separations",
    "Sphere": "bodies.shapes",
    "Trajectory": "trajectories.trajectory",
    "Tuning": "bodies.tuning",
    "UnprovedPathError": "timing.time_path",
    "ValidityReport": "checking.verdicts",
    "Verdict": "checking.verdicts",
    "VoxelGrid": "bodies.voxel_grids",
    "certify": "bodies.intersection",
    "depth": "bodies.penetration_depth",
    "distance": "bodies.distance",
    "distances_along": "checking.clearance",
    "first_conflict": "timing.conflicts",
    "intersects": "bodies.intersection",
    "least_delay": "timing.least_delay",
    "schedule": "timing.schedule",
    "signed_distance": "bodies.distance",
    "time_path": "timing.time_path",
}
_MODULES = ("ndim", "ompl", "planar", "view")


def _comparison(home: str, name: str = "confirm_model") -> Comparison:
    def compare(*given: Any) -> tuple[str, ...]:
        return tuple(getattr(importlib.import_module(f"plannercheck.{home}"), name)(*given))

    return compare


def _read_path(path: Any, joint_names: Sequence[str], width: int, robot: Any) -> Any:
    return importlib.import_module("plannercheck.validation.formats.paths").read_proved_path(
        path, joint_names, width, robot
    )


def _read_joints(robot: Any) -> RobotJoints:
    return RobotJoints(*importlib.import_module("plannercheck.trajectories.joint_columns").joints_of_robot(robot))


def _read_message(
    path: Any, joint_names: Sequence[str], message: int | None = None, followers: Followers | None = None
) -> Any:
    joints = importlib.import_module("plannercheck.trajectories.joint_columns").joints_of_proof(joint_names, followers)
    return importlib.import_module("plannercheck.trajectories.files").read_points_of(path, joints, message)


# `Proof.verify` with a robot compares the proof's model with files, which takes folders above `proofs`.
set_model_comparison("space", _comparison("motions.proof_confirmation"))
set_model_comparison("pairs", _comparison("motions.proof_confirmation", "confirm_pairs"))
set_model_comparison("plane", _comparison("planar.proof_confirmation"))
set_path_reader(_read_path)
set_message_reader(_read_message)
set_joint_reader(_read_joints)

__all__ = [
    "Audit",
    "AuditedLink",
    "Box",
    "Capsule",
    "Checker",
    "Cone",
    "Conflict",
    "Covering",
    "Cylinder",
    "Decomposition",
    "Depth",
    "Distance",
    "Distances",
    "Ellipsoid",
    "Enclosure",
    "FreeBox",
    "FreeBoxes",
    "Gate",
    "GateVerdict",
    "HalfSpace",
    "HeightField",
    "Hull",
    "LeastDelay",
    "Moving",
    "Octree",
    "Part",
    "PartSeparation",
    "Placed",
    "PlannercheckError",
    "PointCloud",
    "Polytope",
    "Reason",
    "Robot",
    "Scene",
    "Schedule",
    "Separation",
    "SharedPoint",
    "Solid",
    "SolidSeparation",
    "Sphere",
    "Trajectory",
    "Tuning",
    "UnprovedPathError",
    "ValidityReport",
    "Verdict",
    "VoxelGrid",
    "__version__",
    "certify",
    "depth",
    "distance",
    "distances_along",
    "first_conflict",
    "intersects",
    "least_delay",
    "ndim",
    "ompl",
    "planar",
    "schedule",
    "signed_distance",
    "time_path",
    "view",
]


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return importlib.import_module(f"plannercheck.{name}")
    if name in _HOMES:
        found = getattr(importlib.import_module(f"plannercheck.{_HOMES[name]}"), name)
        globals()[name] = found  # this function, which takes 1.4 µs, is asked once for each name
        return found
    raise AttributeError(f"module 'plannercheck' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
