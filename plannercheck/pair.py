"""The intersection test for one pair of posed polytopes (paper, section "Detecting intersections in 3D").

In: two prepared bodies and their poses. Out: a verdict, or a verdict with its certificate. The steps are in
cpp/pair_test: cached plane, centre axis, the coupled walk or the double oracle, exact arithmetic.
"""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.certificates import Certificate, SharedPoint, separation
from plannercheck.core import core
from plannercheck.errors import unknown_name
from plannercheck.hull import Polytope
from plannercheck.shapes import checked_pose

Method: TypeAlias = Literal["oracle", "walk", "exact"]

METHODS: tuple[Method, ...] = ("oracle", "walk", "exact")


def pair_options(method: Method = "oracle", cached_plane: bool = True, centre_axis: bool = True) -> Any:
    """The core's switches for the pair test.

    Args:
        method: "oracle" (small active sets on both sides), "walk" (the paper's coupled walk) or "exact" (exact
            arithmetic alone). Verdicts are the same.
        cached_plane: Try the plane that separated the pair last time first.
        centre_axis: Try the axis between the centres before the method.

    Returns:
        A core.PairOptions.
    """
    if method not in METHODS:
        raise unknown_name("method", method, METHODS)
    return core.PairOptions(getattr(core.Solver, method), cached_plane, centre_axis)


def intersects(
    P: Polytope,
    R: Polytope,
    pose_p: ArrayLike | None = None,
    pose_r: ArrayLike | None = None,
    method: Method = "oracle",
) -> bool:
    """Whether two posed polytopes share a point; touching counts.

    Args:
        P: A body.
        R: Another.
        pose_p: Pose (4, 4) of P in the world, m; None is the identity. Used as the affine map that its doubles give.
        pose_r: Pose (4, 4) of R in the world, m.
        method: See `pair_options`.

    Returns:
        The exact verdict for the given numbers.

    Raises:
        PlannercheckError: If a pose is not finite or not rigid.
    """
    pose_p, pose_r = checked_pose(pose_p, "pose_p"), checked_pose(pose_r, "pose_r")
    return bool(core.certify_pair(P.core, pose_p, R.core, pose_r, pair_options(method))["shared"])


def certify(
    P: Polytope,
    R: Polytope,
    pose_p: ArrayLike | None = None,
    pose_r: ArrayLike | None = None,
    method: Method = "oracle",
) -> Certificate:
    """The verdict of `intersects` with what proves it.

    Args:
        P: A body.
        R: Another.
        pose_p: Pose (4, 4) of P in the world, m; None is the identity.
        pose_r: Pose (4, 4) of R in the world, m.
        method: See `pair_options`.

    Returns:
        A `Separation`, its normal from R to P, or a `SharedPoint`; in world coordinates.

    Raises:
        PlannercheckError: If a pose is not finite or not rigid.
    """
    pose_p, pose_r = checked_pose(pose_p, "pose_p"), checked_pose(pose_r, "pose_r")
    found = core.certify_pair(P.core, pose_p, R.core, pose_r, pair_options(method))
    if found["shared"]:
        return SharedPoint(found["point"])
    size = sum(_size_before_posing(*body) for body in ((P, pose_p), (R, pose_r)))
    return separation(found["normal"], posed(P.vertices, pose_p), posed(R.vertices, pose_r), size)


def _size_before_posing(polytope: Polytope, pose: NDArray[np.float64]) -> float:
    return float(np.abs(polytope.vertices).sum(axis=1).max() + np.abs(pose[:3, 3]).sum())


def posed(vertices: NDArray[np.float64], pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vertices (n, 3) under a pose (4, 4), m."""
    return vertices @ pose[:3, :3].T + pose[:3, 3]
