"""Finds the obstacles that are the floor, so that the floor can be hidden.

In: the meshes of a picture. Out: the same meshes, with the floor's meshes on a separate layer. An obstacle is the floor
if its name says so; without such a name, if it is wide and flat and neither the robot nor another obstacle is below its
top.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.view.model import FLOOR_OPACITY, Mesh

_NAME = re.compile(r"(?:^|[^a-z])(?:floor|ground)(?:[^a-z]|$)", re.IGNORECASE)
# A plate is flat if its height is less than this part of either edge.
_FLAT = 0.125
# What stands on the floor may be pressed into it by this much, m.
_SUNK = 0.01


def with_floor(meshes: Sequence[Mesh]) -> list[Mesh]:
    """The meshes, those of the floor on the layer "floor"."""
    obstacles = [mesh for mesh in meshes if mesh.layer == "obstacle"]
    floor = [mesh for mesh in obstacles if _NAME.search(mesh.owner)]
    if not floor:
        boxes = {id(mesh): _box(mesh) for mesh in meshes}
        floor = [mesh for mesh in obstacles if _is_below_all(mesh, meshes, boxes)]
    chosen = {id(mesh) for mesh in floor}
    return [replace(mesh, layer="floor", opacity=FLOOR_OPACITY) if id(mesh) in chosen else mesh for mesh in meshes]


def _is_below_all(mesh: Mesh, meshes: Sequence[Mesh], boxes: dict[int, tuple[Floats, Floats]]) -> bool:
    low, high = boxes[id(mesh)]
    x, y, z = high - low
    lowest = min((boxes[id(other)][0][2] for other in meshes if other is not mesh), default=np.inf)
    return bool(z < _FLAT * min(x, y) and lowest > high[2] - _SUNK)


def _box(mesh: Mesh) -> tuple[Floats, Floats]:
    """Lower and upper corner (3,) of the box around a mesh at its first frame, m."""
    pose = mesh.pose(0)
    corners = mesh.vertices @ pose[:3, :3].T + pose[:3, 3]
    return corners.min(axis=0), corners.max(axis=0)
