"""The intersection test for one pair of posed polytopes (paper, section "Detecting intersections in 3D").

In: two prepared bodies and their poses. Out: a verdict, or a verdict with its certificate. The stages are in
cpp/narrow_phase/intersection: cached plane, centre axis, the coupled walk or the double oracle, exact arithmetic.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.certificates import Certificate, UnprovedVerdictError, mixed_point, separation
from plannercheck.bodies.exact_planes import Bodies, Point, direction_of
from plannercheck.bodies.given_bodies import GivenBody, are_poses, given_polytope, given_polytope_at_poses, queries
from plannercheck.bodies.half_space_certificates import certified_body, certify_half_space
from plannercheck.bodies.kinds import Kind, are_bounded, have_parts, pair_kind
from plannercheck.bodies.part_certificates import PartSeparation, certify_parts
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import POSED_TOLERANCE, checked_pose
from plannercheck.bodies.solid_certificates import Enclosure, contact_certificate
from plannercheck.bodies.solid_separations import SolidSeparation, separate_solids
from plannercheck.bodies.tuning import METHODS, Method, pair_options
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.exact_numbers import exact_number
from plannercheck.common.public_names import set_module
from plannercheck.common.threads import MOST_THREADS, checked_threads

SolidCertificate: TypeAlias = Certificate | Enclosure | SolidSeparation | PartSeparation


@set_module("plannercheck")
def intersects(
    P: GivenBody,
    R: GivenBody,
    pose_p: ArrayLike | None = None,
    pose_r: ArrayLike | None = None,
    method: Method = "oracle",
    *,
    threads: int = 1,
) -> bool | Bools:
    """Whether two posed bodies share a point; touching counts. One pair of poses, or many in one call.

    Args:
        P: A body: a `Polytope`; or a shape such as `Box`, points (n, 3) in m, a trimesh.Trimesh, or a geometry of coal
            or python-fcl, from which a `Polytope` is made (points and meshes become hulls). For many tests, make it
            once yourself. Or a `Placed`, which has its pose.
        R: Another body.
        pose_p: Pose (4, 4) of P in the world, m; None is the identity. Used as the affine map that its doubles give.
            Or n poses (n, 4, 4).
        pose_r: Pose (4, 4) of R in the world, m; or as many as of P; one pose goes with all of the other body's.
        method: See `Tuning`.
        threads: How many to use for many poses.

    Returns:
        The exact verdict for the given numbers, True or False; (n,) verdicts where n poses are given.

    Raises:
        PlannercheckError: If a pose is not finite or not rigid (of many, the error names the first such row), or both
            bodies have many poses, but not equally many.
    """
    count = 1 if threads == 1 else checked_threads(threads, MOST_THREADS)
    known: bool | Bools | None = queries.intersects(P, R, pose_p, pose_r, count) if method == "oracle" else None
    return intersects_checked(P, R, pose_p, pose_r, method) if known is None else known


def intersects_checked(
    P: GivenBody,
    R: GivenBody,
    pose_p: ArrayLike | None = None,
    pose_r: ArrayLike | None = None,
    method: Method = "oracle",
) -> bool | Bools:
    """`intersects` for whatever users give: converted, and checked in Python, whose errors say what is wrong."""
    if are_poses(pose_p) or are_poses(pose_r):
        return _intersects_at_poses(P, R, pose_p, pose_r, method)
    P, pose_p = given_polytope(P, pose_p, "P")
    R, pose_r = given_polytope(R, pose_r, "R")
    return bool(_shared(P, R, pose_p[None], pose_r[None], method)[0])


def _intersects_at_poses(
    P: GivenBody, R: GivenBody, pose_p: ArrayLike | None, pose_r: ArrayLike | None, method: Method
) -> Bools:
    (p, poses_p), (r, poses_r) = given_polytope_at_poses(P, pose_p, "P"), given_polytope_at_poses(R, pose_r, "R")
    counts = {len(poses) for poses, given in ((poses_p, pose_p), (poses_r, pose_r)) if are_poses(given)}
    if len(counts) > 1:
        raise PlannercheckError(
            f"pose_p and pose_r must be one pose or equally many, not {len(poses_p)} and {len(poses_r)}"
        )
    if counts == {0}:
        return np.zeros(0, dtype=bool)
    return _shared(p, r, poses_p, poses_r, method)


def _shared(p: Polytope, r: Polytope, poses_p: Floats, poses_r: Floats, method: Method) -> Bools:
    are_bounded(p, r)  # which refuses two half-spaces
    shared, _, _ = core.intersect_batch(p.core, poses_p, r.core, poses_r, pair_options(method))
    return np.asarray(shared).view(bool)


@set_module("plannercheck")
def certify(
    P: GivenBody,
    R: GivenBody,
    pose_p: ArrayLike | None = None,
    pose_r: ArrayLike | None = None,
    method: Method = "oracle",
) -> SolidCertificate:
    """The verdict of `intersects` with its proof.

    Args:
        P: A body, as for `intersects`.
        R: Another body.
        pose_p: Pose (4, 4) of P in the world, m; None is the identity.
        pose_r: Pose (4, 4) of R in the world, m.
        method: See `Tuning`.

    Returns:
        A `Separation`, its normal from R to P, or a `SharedPoint`; in world coordinates. Of solids the point is one of
        two triangles, which are then the certificate's bodies; where one body is inside the other, an `Enclosure`;
        where only their hulls meet, a `SolidSeparation`. Of sets of parts, the point is one of two parts; else, where
        one plane is not enough, the proof is a `PartSeparation`.

    Raises:
        PlannercheckError: If a pose is not finite or not rigid.
    """
    P, pose_p = given_polytope(P, pose_p, "P")
    R, pose_r = given_polytope(R, pose_r, "R")
    return certify_posed(P, R, pose_p, pose_r, method)


def certify_posed(
    P: Polytope, R: Polytope, pose_p: ArrayLike, pose_r: ArrayLike, method: Method = "oracle"
) -> SolidCertificate:
    """`certify` of bodies on links, whose poses may be less rigid than given ones (robots/unit_lengths.py)."""
    pose_p, pose_r = (checked_pose(pose, "a body on a link", POSED_TOLERANCE) for pose in (pose_p, pose_r))
    return _CERTIFIED[pair_kind(P, R)](P, R, pose_p, pose_r, method)


def _certify_hulls(P: Polytope, R: Polytope, pose_p: Floats, pose_r: Floats, method: Method) -> Certificate:
    bodies = certified_body(P, pose_p), certified_body(R, pose_r)
    for stage in (method, METHODS[-1]):
        found = core.certify_pair(P.core, pose_p, R.core, pose_r, pair_options(stage), True)
        certificate = mixed_point(found, bodies) if found["shared"] else _separation(found, bodies)
        # A filter's plane is rounded when it is mapped to the world, so close calls use the exact plane.
        if certificate is not None:
            return certificate
    raise UnprovedVerdictError("the core finds two bodies to be apart, but its plane does not separate them")


def _certify_solids(P: Polytope, R: Polytope, pose_p: Floats, pose_r: Floats, _: Method) -> SolidCertificate:
    contact = contact_certificate(P, R, pose_p, pose_r)
    return separate_solids(P, R, pose_p, pose_r, certify_posed) if contact is None else contact


def _certify_parts(P: Polytope, R: Polytope, pose_p: Floats, pose_r: Floats, _: Method) -> SolidCertificate:
    found: SolidCertificate = certify_parts(P, R, pose_p, pose_r, certify_posed)
    return found


def _certify_over_plane(P: Polytope, R: Polytope, pose_p: Floats, pose_r: Floats, method: Method) -> SolidCertificate:
    if have_parts(P, R):
        return _certify_parts(P, R, pose_p, pose_r, method)
    return certify_half_space(P, R, pose_p, pose_r)


# The proof of a verdict, by the kind of the pair.
_CERTIFIED: dict[Kind, Callable[[Polytope, Polytope, Floats, Floats, Method], SolidCertificate]] = {
    "hull": _certify_hulls,
    "solid": _certify_solids,
    "part_set": _certify_parts,
    "half_space": _certify_over_plane,
}


def _separation(found: dict[str, Any], bodies: Bodies) -> Certificate | None:
    certificate = separation(direction_of(found["normal"]), bodies)
    if certificate is None and "exact_normal" in found:
        certificate = separation(_vector(found["exact_normal"]), bodies)
    return certificate


def _vector(numbers: Sequence[tuple[str, int]]) -> Point:
    x, y, z = (exact_number(number) for number in numbers)
    return x, y, z
