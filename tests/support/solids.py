"""Bodies of the families as the makers of poses and the core want them."""

from __future__ import annotations

import numpy as np

import plannercheck as pc
from plannercheck.evaluation.stress.body_families import MESHES, family, mesh_points
from plannercheck.evaluation.stress.contact_poses import Solid


def solid_of(name, n, seed):
    points = mesh_points(name) if name in MESHES else family(name, n, seed)
    polytope = pc.Polytope(points)
    return Solid(f"{name} {n}", polytope.vertices, polytope.faces.astype(np.int64)), polytope
