"""Points of depth images, as REP 118 of ROS defines these: depth along z in the camera's optical frame.

In: an image, the intrinsics of a camera without distortion, its pose. Out: a point for each pixel. In the optical frame
(REP 103) z is forward, x right and y down; pixel (u, v) looks along ((u - cx) / fx, (v - cy) / fy, 1), with whole
numbers u, v in the middle of a pixel (image_geometry, PinholeCameraModel::projectPixelTo3dRay). Sums are written out,
since those of BLAS differ between machines.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.bodies.shapes import checked_pose
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import real_numbers, shown_array
from plannercheck.common.errors import PlannercheckError

# uint16 is in mm (REP 118, "OpenNI raw representation").
_MILLIMETRES = 1000.0


def points_of_depth(depth: ArrayLike, intrinsics: ArrayLike, pose: ArrayLike | None) -> Floats:
    """The points (h * w, 3) of an image (h, w) in the world, row by row, m; NaN where there is no return.

    Args:
        depth: (h, w) depth along z: floats in m, or uint16 in mm. NaN, 0 and +inf are no return.
        intrinsics: K (3, 3), or (fx, fy, cx, cy), in pixels.
        pose: (4, 4) of the optical frame in the world, m; None is the identity.

    Raises:
        PlannercheckError: If the image is of another type or shape or has negative depths, the intrinsics are none of a
            camera without skew, or the pose is not rigid.
    """
    z = _metres(depth)
    fx, fy, cx, cy = _checked_intrinsics(intrinsics)
    matrix = checked_pose(pose, "a depth image")
    x = (np.arange(z.shape[1]) - cx) / fx * z
    y = ((np.arange(z.shape[0]) - cy) / fy)[:, None] * z
    world = [row[0] * x + row[1] * y + row[2] * z + row[3] for row in matrix[:3]]
    return np.stack(world, axis=-1).reshape(-1, 3)


def _metres(depth: ArrayLike) -> Floats:
    """Depths (h, w) in m, NaN where there is no return."""
    image = _checked_image(depth)
    metres = image / _MILLIMETRES if image.dtype.kind == "u" else image.astype(np.float64)
    near = metres == -np.inf
    if near.any():
        warnings.warn(
            f"depth image: {np.count_nonzero(near)} pixels are -inf, for something too close to measure (REP 117), "
            "which is not in the cloud",
            RuntimeWarning,
            stacklevel=4,
        )
    bad = np.argwhere((metres < 0) & ~near)
    if len(bad):
        v, u = bad[0].tolist()
        raise PlannercheckError(f"depth image: row {v}, column {u} is {metres[v, u]} m; depths must not be negative")
    return np.where(np.isfinite(metres) & (metres > 0), metres, np.nan)


def _checked_image(depth: ArrayLike) -> NDArray[Any]:
    try:
        image = real_numbers(depth)
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"a depth image must be an array (h, w), not {shown_array(depth)}") from None
    if image.ndim != 2:
        raise PlannercheckError(f"a depth image must have shape (h, w), not {image.shape}")
    if image.dtype.kind != "f" and (image.dtype.kind, image.dtype.itemsize) != ("u", 2):  # of any byte order
        raise PlannercheckError(
            f"a depth image must be of floats (m) or uint16 (mm), not {image.dtype}: convert it to m, in floats"
        )
    return image


def _checked_intrinsics(intrinsics: ArrayLike) -> tuple[float, float, float, float]:
    """Focal lengths and principal point, in pixels."""
    try:
        given = np.asarray(real_numbers(intrinsics), dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"intrinsics {shown_array(intrinsics)} must be numbers") from None
    if given.shape == (3, 3):
        fx, fy, cx, cy = given[0, 0], given[1, 1], given[0, 2], given[1, 2]
        if not np.array_equal(given, [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]):
            raise PlannercheckError(f"intrinsics must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], not {given.tolist()}")
    elif given.shape == (4,):
        fx, fy, cx, cy = given
    else:
        raise PlannercheckError(f"intrinsics must be K (3, 3) or (fx, fy, cx, cy), not an array {given.shape}")
    if not (np.isfinite([fx, fy, cx, cy]).all() and fx > 0 and fy > 0):
        raise PlannercheckError(f"intrinsics must be finite, fx and fy above 0, not {[fx, fy, cx, cy]}")
    return float(fx), float(fy), float(cx), float(cy)
