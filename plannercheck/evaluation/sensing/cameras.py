"""Pinhole cameras: which way each pixel looks, and the points of a depth image.

In: sizes in pixels, poses, depth images in m. Out: directions, points in m. A camera looks along z, x is to the right
and y down, as in ROS's optical frames. The depth of a pixel is measured along z, as depth cameras give it; 0 means that
nothing was seen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats

# The field of view across the image of a usual depth camera, rad: 65 degrees.
USUAL_FIELD = 1.134


@dataclass(frozen=True)
class DepthCamera:
    """A camera without distortion, its principal point in the middle.

    Width and height are in pixels; the field of view across the width is in rad.
    """

    width: int
    height: int
    field: float = USUAL_FIELD

    @property
    def focal_length(self) -> float:
        """In pixels."""
        return float(self.width / (2 * np.tan(self.field / 2)))

    @property
    def directions(self) -> Floats:
        """Where each pixel looks: (height, width, 3) in the camera's frame, of depth 1."""
        x = (np.arange(self.width) + 0.5 - self.width / 2) / self.focal_length
        y = (np.arange(self.height) + 0.5 - self.height / 2) / self.focal_length
        return np.stack([*np.meshgrid(x, y), np.ones((self.height, self.width))], axis=-1)

    def points(self, depth: Floats, pose: Floats) -> Floats:
        """The points (n, 3) in the world of a depth image (height, width) by a camera at a pose (4, 4), m.

        They are row by row, without the pixels of depth 0, which saw nothing.
        """
        seen = depth > 0
        local = self.directions[seen] * depth[seen][:, None]
        return local @ pose[:3, :3].T + pose[:3, 3]


def looking(eye: ArrayLike, target: ArrayLike) -> Floats:
    """The pose (4, 4) of a camera at a point that looks at another one, m; the image is upright as z is up."""
    place, aim = np.asarray(eye, dtype=np.float64), np.asarray(target, dtype=np.float64)
    forward = (aim - place) / np.linalg.norm(aim - place)
    upright = np.array([0.0, 0.0, 1.0]) if abs(forward[2]) < 0.999 else np.array([0.0, 1.0, 0.0])
    right = np.cross(forward, upright)
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([right, np.cross(forward, right), forward])
    pose[:3, 3] = place
    return pose
