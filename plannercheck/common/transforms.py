"""Rigid transforms from the forms in which files write them.

In: positions in m; quaternions x, y, z, w of any length but zero; roll, pitch, yaw in rad about fixed axes x,
then y, then z (as in URDF). Out: 4 x 4 float64 matrices.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.errors import PlannercheckError

Matrix = NDArray[np.float64]

_IDENTITY = np.eye(4)
_IDENTITY_ROWS = _IDENTITY.tolist()


def rotation_of_quaternion(quaternion: Sequence[float]) -> Matrix:
    """Rotation (3, 3) of a quaternion x, y, z, w, which is normalised first."""
    return np.array(_rotation_rows(quaternion))


def pose_of_quaternion(position: Sequence[float], quaternion: Sequence[float]) -> Matrix:
    """Pose (4, 4) of a position and a quaternion x, y, z, w, which is normalised first."""
    (x, y, z), (a, b, c) = position, _rotation_rows(quaternion)
    return np.array([*a, x, *b, y, *c, z, 0.0, 0.0, 0.0, 1.0]).reshape(4, 4)  # rows in rows take twice as long


def _rotation_rows(quaternion: Sequence[float]) -> list[list[float]]:
    norm = math.hypot(*quaternion)
    if not (norm > 0 and math.isfinite(norm)):
        raise PlannercheckError(f"quaternion {list(quaternion)} has no direction: give x, y, z, w")
    x, y, z, w = [c / norm for c in quaternion]
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]


def quaternion_of_rotation(rotation: Matrix) -> list[float]:
    """Quaternion x, y, z, w of a rotation (3, 3), from the largest row of the outer product q q^T."""
    m = rotation
    trace = m[0, 0] + m[1, 1] + m[2, 2]
    diagonal = [1 + 2 * m[k, k] - trace for k in range(3)] + [1 + trace]
    k = int(np.argmax(diagonal))
    symmetric = m + m.T
    skew = [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]]
    row = [*symmetric[k], skew[k]] if k < 3 else [*skew, 0.0]
    row[k] = diagonal[k]
    norm = math.hypot(*row)
    return [float(c / norm) for c in row]


def rotation_of_rpy(rpy: Sequence[float]) -> Matrix:
    """Rotation (3, 3) = Rz(yaw) Ry(pitch) Rx(roll)."""
    (cr, cp, cy), (sr, sp, sy) = ([f(a) for a in rpy] for f in (math.cos, math.sin))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def pose_of(position: Sequence[float] | Matrix, rotation: Matrix | None = None) -> Matrix:
    """Pose (4, 4) of a position and a rotation (3, 3), by default none."""
    pose = _IDENTITY.copy()
    pose[:3, 3] = position
    if rotation is not None:
        pose[:3, :3] = rotation
    return pose


def at_places(places: Matrix) -> Matrix:
    """Poses (n, 4, 4) at places (n, 3), without a turn."""
    poses = np.tile(_IDENTITY, (len(places), 1, 1))
    poses[:, :3, 3] = places
    return poses


def identity() -> Matrix:
    """A new identity (4, 4), in a tenth of np.eye's time."""
    return _IDENTITY.copy()


def is_identity(pose: Matrix) -> bool:
    """Whether a pose (4, 4) is exactly the identity."""
    return bool(pose.tolist() == _IDENTITY_ROWS)


def inverse(pose: Matrix) -> Matrix:
    """The inverse of a rigid transform (4, 4)."""
    out = np.eye(4)
    out[:3, :3] = pose[:3, :3].T
    out[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return out
