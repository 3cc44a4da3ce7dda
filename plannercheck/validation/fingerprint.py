"""The fingerprint of a run, so that only the same run can resume its journal.

In: a checker, a `Judge`. Out: a mapping of names to texts. Two runs with the same fingerprint give the same findings
for the same rows; the rows themselves are compared chunk by chunk.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from plannercheck.bodies.half_spaces import HalfSpace
from plannercheck.bodies.moving import Ride
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.shapes import GeometryObject, checked_pose, inflated_hull
from plannercheck.bodies.solids import Solid
from plannercheck.checking.protocols import AnyChecker
from plannercheck.common.version import __version__
from plannercheck.motions.checker import Checker
from plannercheck.planar.checker import Checker as PlanarChecker
from plannercheck.planar.links import GeometryObject as PlanarObject
from plannercheck.validation.judging import Judge

# Configurations whose poses stand for the kinematics.
_POSED = 5


def fingerprint(checker: AnyChecker, judge: Judge, chunk_rows: int) -> dict[str, str]:
    """Everything that findings depend on: the version, the robot in its scene, and the judge, but not its threads."""
    asked = {name: str(value) for name, value in asdict(judge).items() if name not in ("threads", "times")}
    return {
        "version": __version__,
        "robot": checker.robot.name,
        "scene": checker.scene.name,
        "pairs of bodies": str(len(checker.pairs)),
        **asked,
        "times": hashlib.sha256(np.array(judge.times).tobytes()).hexdigest(),
        "rows of a chunk": str(chunk_rows),
        "bodies, poses and pairs": content_hash(checker),
    }


def content_hash(checker: AnyChecker) -> str:
    """A hash of everything that verdicts depend on: bodies, pairs, limits, and poses of the links."""
    robot = checker.robot
    digest = hashlib.sha256(" ".join(robot.joint_names).encode())
    for array in (checker.pairs, robot.lower, robot.upper):
        digest.update(np.ascontiguousarray(array).tobytes())
    for names in sorted({checker.pair_names(k) for k in range(len(checker.pairs))}):
        digest.update(repr(names).encode())
    assert isinstance(checker, Checker | PlanarChecker)
    digest.update(np.ascontiguousarray(checker.robot.link_poses(robot.random_configurations(_POSED, 0))).tobytes())
    _add_names(digest, checker.bodies)
    if isinstance(checker, PlanarChecker):
        for polygon in checker.bodies:
            digest.update(np.ascontiguousarray(polygon.vertices).tobytes())
    else:
        digest.update(checker.paddings.tobytes())
        _add_shapes(digest, checker.bodies, checker.excess)
        for item in checker.scene.moving:
            assert item.moving is not None
            digest.update(repr((item.name, item.moving.path, item.moving.outside)).encode())
            digest.update(item.moving.times.tobytes() + item.moving.poses.tobytes())
            if item.moving.ride is not None:
                _add_ride(digest, item.moving.ride)
    return digest.hexdigest()


def robot_hash(checker: Checker) -> str:
    """A hash of a robot as a checker has it: its joints, limits and bodies, and the pairs of these that are tested."""
    robot, count = checker.robot, len(checker.robot.bodies)
    digest = hashlib.sha256(" ".join(robot.joint_names).encode())
    own = checker.pairs[(checker.pairs < count).all(axis=1)]
    poses = robot.link_poses(robot.random_configurations(_POSED, 0))
    for array in (own, robot.lower, robot.upper, poses):
        digest.update(np.ascontiguousarray(array).tobytes())
    _add_names(digest, checker.bodies[:count])
    _add_shapes(digest, checker.bodies[:count], checker.excess)
    return digest.hexdigest()


def scene_hash(checker: Checker) -> str:
    """A hash of a scene as a checker has it: its bodies, the pairs that these are in, and the paddings of all pairs."""
    count = len(checker.robot.bodies)
    digest = hashlib.sha256(checker.paddings.tobytes())
    digest.update(np.ascontiguousarray(checker.pairs[(checker.pairs >= count).any(axis=1)]).tobytes())
    _add_names(digest, checker.bodies[count:])
    _add_shapes(digest, checker.bodies[count:], checker.excess)
    return digest.hexdigest()


def _add_names(digest: hashlib._Hash, bodies: Sequence[GeometryObject | PlanarObject]) -> None:
    for body in bodies:
        digest.update(f"{body.name} {body.link}".encode() + np.ascontiguousarray(body.pose).tobytes())


def _add_ride(digest: hashlib._Hash, ride: Ride) -> None:
    """The curve that a robot runs, and where its link, on which an object rides, is for some configurations."""
    robot, base = ride.robot if isinstance(ride.robot, tuple) else (ride.robot, None)
    curve, links = ride.trajectory.curve, robot.link_poses(robot.random_configurations(_POSED, 0))
    digest.update(repr((ride.link, ride.start_time, curve.counts.tolist(), curve.units)).encode())
    for part in (curve.breaks, *curve.pieces, checked_pose(base, "base"), links[:, robot.link_index(ride.link)]):
        digest.update(np.ascontiguousarray(part).tobytes())


def _add_shapes(digest: hashlib._Hash, bodies: Sequence[GeometryObject], excess: float) -> None:
    for body in bodies:
        points, _, inflation_radius = inflated_hull(body.shape, excess)
        digest.update(np.ascontiguousarray(points).tobytes() + np.float64(inflation_radius).tobytes())
        digest.update(body.shape.digest if isinstance(body.shape, Solid | PartSet | HalfSpace) else b"")
