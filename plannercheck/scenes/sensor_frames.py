"""The next frame of a sensor.

In: the shape of the frame before, and what the sensor sees now. Out: the shape of the new frame.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from numpy.typing import ArrayLike

from plannercheck.bodies.height_fields import HeightField
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.point_clouds import PointCloud
from plannercheck.bodies.shapes import Shape
from plannercheck.bodies.voxel_grids import VoxelGrid
from plannercheck.common.errors import PlannercheckError, with_article


def next_frame(shape: Shape, frame: ArrayLike | PartSet) -> PartSet:
    """The shape that follows another one.

    Args:
        shape: The shape before; what is not in the frame, e.g. a radius, is taken over.
        frame: Points (n, 3), m; cells (i, j, k); heights (i, j), m; or a shape of the same kind.

    Raises:
        PlannercheckError: If the shape before is not a sensed one, or the frame is none of its kind.
    """
    if not isinstance(shape, PartSet):
        raise PlannercheckError(
            f"is {_kind(shape)}: sensors update clouds, octrees, voxel grids, height fields; remove it and "
            "add the other shape"
        )
    if isinstance(frame, PartSet):
        if isinstance(frame, type(shape)):
            return frame
        raise PlannercheckError(
            f"is {_kind(shape)}, which {_kind(frame)} does not update: give {_kind(shape)}, or remove the object and "
            "add the other shape"
        )
    given: Any = frame
    match shape:
        case PointCloud():
            return shape.with_points(given)
        case VoxelGrid():
            return replace(shape, occupied=given)
        case HeightField():
            return replace(shape, heights=given)
    raise PlannercheckError(f"is {_kind(shape)}: give the new one, e.g. pc.Octree.load(path)")


def _kind(shape: Shape) -> str:
    return with_article(type(shape).__name__)
