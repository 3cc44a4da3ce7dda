"""The fingerprint of a run, so that only the same run can resume its journal.

In: a checker, a `Judge`. Out: a mapping of names to texts. Two runs with the same fingerprint give the same findings
for the same rows; the rows themselves are compared chunk by chunk.
"""

from __future__ import annotations

import hashlib
from dataclasses import asdict

import numpy as np

from plannercheck.bodies.half_spaces import HalfSpace
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.shapes import inflated_hull
from plannercheck.bodies.solids import Solid
from plannercheck.checking.protocols import AnyChecker
from plannercheck.common.version import __version__
from plannercheck.motions.checker import Checker
from plannercheck.planar.checker import Checker as PlanarChecker
from plannercheck.validation.judging import Judge

# Configurations whose poses stand for the kinematics.
_POSED = 5


def fingerprint(checker: AnyChecker, judge: Judge, chunk_rows: int) -> dict[str, str]:
    """Everything that findings depend on: the version, the robot in its scene, and the judge, but not its threads."""
    asked = {name: str(value) for name, value in asdict(judge).items() if name != "threads"}
    return {
        "version": __version__,
        "robot": checker.robot.name,
        "scene": checker.scene.name,
        "pairs of bodies": str(len(checker.pairs)),
        **asked,
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
    for body in checker.bodies:
        digest.update(f"{body.name} {body.link}".encode() + np.ascontiguousarray(body.pose).tobytes())
    _add_shapes(digest, checker)
    return digest.hexdigest()


def _add_shapes(digest: hashlib._Hash, checker: Checker | PlanarChecker) -> None:
    if isinstance(checker, PlanarChecker):
        for polygon in checker.bodies:
            digest.update(np.ascontiguousarray(polygon.vertices).tobytes())
        return
    digest.update(checker.paddings.tobytes())
    for body in checker.bodies:
        points, _, inflation_radius = inflated_hull(body.shape, checker.excess)
        digest.update(np.ascontiguousarray(points).tobytes() + np.float64(inflation_radius).tobytes())
        digest.update(body.shape.digest if isinstance(body.shape, Solid | PartSet | HalfSpace) else b"")
