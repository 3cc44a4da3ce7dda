"""Clouds, maps and terrains as other libraries have them: coal's octree and height field, python-fcl's octree.

In: our shapes. Out: theirs. An octree has cells where a cloud has balls: of the ball's diameter, in the lattice about
the origin, where a point is. So verdicts about a cloud differ near its surface; those about a map or a terrain do not.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.fcl_bodies import load_fcl
from plannercheck.bodies.height_fields import HeightField
from plannercheck.bodies.lattice_cells import LatticeCells
from plannercheck.bodies.octomap_files import binary_file
from plannercheck.bodies.octrees import Octree
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.point_clouds import PointCloud
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct, distinct_rows
from plannercheck.common.errors import PlannercheckError

# Cells of one step that are handed over at most: coal takes a point for each.
_MOST_CELLS = 20_000_000


def coal_map(shape: PartSet) -> tuple[Any, Floats]:
    """The shape in coal, and the pose (4, 4) of its frame in ours, m.

    Raises:
        PlannercheckError: If coal has no such shape.
    """
    import coal

    match shape:
        case PointCloud():
            return coal.makeOctree(np.asfortranarray(shape.points), _diameter(shape)), np.eye(4)
        case LatticeCells():
            if np.any(shape.origin):
                raise PlannercheckError("octrees of other libraries have their lattice at the origin")
            centres = (_small_cells(shape) + 0.5) * shape.resolution
            return coal.makeOctree(np.asfortranarray(centres), shape.resolution), np.eye(4)
        case HeightField():
            return _coal_heights(shape)
    raise PlannercheckError(f"coal has nothing like {shape!r}")


def fcl_map(shape: PartSet) -> Any:
    """The shape in python-fcl, whose octree takes OctoMap's stream of bits as signed bytes.

    Raises:
        PlannercheckError: If FCL has no such shape.
    """
    tree = _octree(shape)
    keys, sizes = (part.astype(np.int64) for part in tree.cells)
    content = binary_file(keys, sizes, np.ones(len(sizes), dtype=bool), tree.resolution)
    stream = np.frombuffer(content[content.index(_DATA) + len(_DATA) :], dtype=np.int8)
    return load_fcl().OcTree(tree.resolution, stream.tolist())


# After this line of its header, a file of OctoMap's is its tree alone.
_DATA = b"\ndata\n"


def _octree(shape: PartSet) -> Octree:
    if isinstance(shape, Octree):
        return shape
    if isinstance(shape, PointCloud):
        step = _diameter(shape)
        return Octree.from_cells(distinct_rows(np.floor(shape.points / step).astype(np.int32))[0], step)
    raise PlannercheckError(f"python-fcl has nothing like {shape!r}")


def _diameter(cloud: PointCloud) -> float:
    """The diameter of all balls, m."""
    if np.ptp(cloud.radius) > 0:
        raise PlannercheckError("an octree has cells of one size: balls need one radius")
    return 2 * float(cloud.radius[0])


def _small_cells(shape: LatticeCells) -> NDArray[np.int64]:
    """All cells of one step (n, 3)."""
    keys, sizes = shape.cells
    if float((sizes.astype(np.float64) ** 3).sum()) > _MOST_CELLS:
        raise PlannercheckError(f"coal takes a map cell by cell: more than {_MOST_CELLS:,} are left out")
    parts = [np.zeros((0, 3), dtype=np.int64)]
    for size in distinct(sizes).tolist():
        inside = np.stack(np.meshgrid(*[np.arange(size)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        parts.append((keys[sizes == size][:, None].astype(np.int64) + inside).reshape(-1, 3))
    return np.concatenate(parts)


def _coal_heights(shape: HeightField) -> tuple[Any, Floats]:
    """Coal's rows go along -y, its columns along x, about the middle of the field."""
    import coal

    if shape.holes:
        raise PlannercheckError("coal's height fields have no holes")
    edges = (np.array(shape.heights.shape) - 1) * shape.resolution
    rows = np.asfortranarray(shape.heights.T[::-1])
    pose = np.eye(4)
    pose[:2, 3] = np.array(shape.origin) + edges / 2
    return coal.HeightFieldAABB(float(edges[0]), float(edges[1]), rows, float(shape.base)), pose
