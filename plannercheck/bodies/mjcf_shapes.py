"""The geoms of a compiled MJCF file as our shapes.

In: a compiled file and a geom's number. Out: the shape with its pose on the geom's body. MuJoCo's sizes are half
lengths. Meshes have MuJoCo's vertices, in single precision; a mesh is their hull, as for MuJoCo, or a solid.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from plannercheck.bodies.ellipsoids import Ellipsoid
from plannercheck.bodies.half_spaces import HalfSpace
from plannercheck.bodies.height_fields import HeightField
from plannercheck.bodies.mjcf_files import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    HFIELD,
    MESH,
    PLANE,
    SDF,
    SPHERE,
    Integers,
    MjcfFile,
)
from plannercheck.bodies.shapes import Box, Capsule, Cylinder, Hull, Shape, Sphere
from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import error_context

# The shapes of geoms that are their kind and three sizes, m.
_SIZED: dict[int, Callable[[float, float, float], Shape]] = {
    PLANE: lambda x, y, z: HalfSpace((0.0, 0.0, 1.0)),
    SPHERE: lambda x, y, z: Sphere(x),
    CAPSULE: lambda x, y, z: Capsule(x, 2 * y),
    ELLIPSOID: lambda x, y, z: Ellipsoid((x, y, z)),
    CYLINDER: lambda x, y, z: Cylinder(x, 2 * y),
    BOX: lambda x, y, z: Box((2 * x, 2 * y, 2 * z)),
}


def check_flexes(file: MjcfFile) -> None:
    """Raises for a flex that can collide: no shape deforms, and none is as thick as a flex all around."""
    found = np.flatnonzero((file.flex_contype | file.flex_conaffinity) != 0)
    if len(found):
        raise file.refused(
            "flex",
            int(found[0]),
            'can\'t be taken, as it deforms: give it contype="0" conaffinity="0" to leave it out, or give a mesh',
        )


def shape_of_geom(file: MjcfFile, geom: int) -> Shape:
    """The shape of a geom in its own frame; a mesh's hull.

    Raises:
        PlannercheckError: If no shape is what MuJoCo tests, or its numbers make no body; the error names the geom.
    """
    kind = int(file.geom_type[geom])
    if kind == SDF:
        raise file.refused("geom", geom, 'is an sdf, given by a function of MuJoCo\'s: give it as type="mesh"')
    x, y, z = file.geom_size[geom].tolist()
    with error_context(f"MJCF {file.path}: geom {file.names['geom'][geom]!r}"):
        if kind == MESH:
            return Hull(mesh_of_geom(file, geom)[0])
        if kind == HFIELD:
            return _height_field(file, int(file.geom_dataid[geom]))
        return _SIZED[kind](x, y, z)


def mesh_of_geom(file: MjcfFile, geom: int) -> tuple[Floats, Integers]:
    """Vertices (n, 3) in the geom's frame, m, and triangles (m, 3) of a geom that is a mesh."""
    mesh = file.geom_dataid[geom]
    first, face = file.mesh_vertadr[mesh], file.mesh_faceadr[mesh]
    vertices = file.mesh_vert[first : first + file.mesh_vertnum[mesh]]
    return vertices, file.mesh_face[face : face + file.mesh_facenum[mesh]]


def _height_field(file: MjcfFile, number: int) -> HeightField:
    """Heights over the whole size along x and y; each square has MuJoCo's diagonal (mjc_ConvexHField)."""
    rows, columns, first = file.hfield_nrow[number], file.hfield_ncol[number], file.hfield_adr[number]
    x, y, top, base = file.hfield_size[number].tolist()
    heights = file.hfield_data[first : first + rows * columns].reshape(rows, columns).T * top
    steps = 2 * x / (int(columns) - 1), 2 * y / (int(rows) - 1)
    return HeightField(np.ascontiguousarray(heights), steps, -base, (-x, -y))
