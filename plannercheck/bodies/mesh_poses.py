"""Poses of objects in mesh files: affine maps of points.

In: maps and points. Out: points. Sums are written out, so that they round alike on every machine; a product of matrices
may fuse its steps.
"""

from __future__ import annotations

import numpy as np

from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.errors import PlannercheckError


def composed(outer: Floats, inner: Floats) -> Floats:
    """The map (4, 4) that applies `inner` first."""
    with np.errstate(over="ignore", invalid="ignore"):
        return np.asarray((outer[:, :, None] * inner[None]).sum(axis=1))


def turned(turn: Floats, points: Floats) -> Floats:
    """Points (n, 3) under a linear map (3, 3)."""
    x, y, z = (points[:, k, None] * turn[:, k] for k in range(3))
    return np.asarray(x + y + z)


def transformed(pose: Floats, points: Floats) -> Floats:
    """Points (n, 3) under a map (4, 4)."""
    if (pose == np.eye(4)).all():
        return points
    with np.errstate(over="ignore", invalid="ignore"):
        moved = turned(pose[:3, :3], points) + pose[:3, 3]
    if not np.isfinite(moved).all():
        raise PlannercheckError("has points that its transforms move beyond all doubles")
    return moved


def facing_as_before(pose: Floats, triangles: Ints64) -> Ints64:
    """Triangles (m, 3) with their outer sides outside under a map, too: one that mirrors turns all of them.

    glTF defines it so (specification 2.0, 3.7.4), and trimesh does so for Collada. Else an object and its mirror image,
    where they overlap, would wind once to either side, and that would be outside of both.
    """
    return triangles[:, ::-1] if np.linalg.slogdet(pose[:3, :3])[0] < 0 else triangles
