"""Bodies of the families as the makers of poses and the core want them, and poses that are no contacts."""

from functools import cache

import numpy as np

import plannercheck as pc
from plannercheck.evaluation.stress.body_families import MESHES, family, mesh_points
from plannercheck.evaluation.stress.contact_poses import (
    Points,
    Solid,
    identities,
    quarter_turns,
    random_directions,
    turned,
    turns_onto,
)

# Directions taken at once against all vertices, to bound memory.
BLOCK = 200


def solid_of(name, n, seed):
    points = mesh_points(name) if name in MESHES else family(name, n, seed)
    polytope = pc.Polytope(points)
    return Solid(f"{name} {n}", polytope.vertices, polytope.faces.astype(np.int64)), polytope


def centroid(solid: Solid) -> Points:
    """The centre of volume, (3,), m."""
    middle = solid.vertices.mean(axis=0)
    corners = solid.vertices[solid.faces] - middle
    volumes = np.linalg.det(corners)
    return np.asarray(middle + volumes @ corners.sum(axis=1) / (4 * volumes.sum()))


@cache
def width(solid: Solid) -> float:
    """The least extent along a facet's normal, m: at least the true width, and equal to it for a box.

    0 for bodies without facets, inflated or not.
    """
    if len(solid.faces) == 0:
        return 0.0
    directions = np.unique(np.round(solid.normals[np.any(solid.normals != 0, axis=1)], 6), axis=0)
    some = directions[:: max(1, len(directions) // 2000)]
    blocks = np.array_split(some, 1 + len(some) // BLOCK)
    return float(min(np.ptp(block @ solid.vertices.T, axis=1).min() for block in blocks))


def random_poses(p: Solid, r: Solid, k: int, rng: np.random.Generator) -> tuple[Points, Points]:
    """Poses at random distances, of which about half collide for round bodies; (k, 4, 4) each, m."""
    pose_p, pose_r = identities(k), identities(k)
    pose_p[:, :3, :3] = turns_onto(random_directions(k, rng), random_directions(k, rng), rng)
    pose_r[:, :3, :3] = turns_onto(random_directions(k, rng), random_directions(k, rng), rng)
    pose_r[:, :3, 3] = rng.uniform(-1, 1, size=(k, 3))
    centre_p, centre_r = p.vertices.mean(axis=0), r.vertices.mean(axis=0)
    apart = random_directions(k, rng) * rng.uniform(0, 0.6 * (p.size + r.size), size=(k, 1))
    pose_p[:, :3, 3] = pose_r[:, :3, 3] + turned(pose_r, centre_r) - turned(pose_p, centre_p) + apart
    return pose_p, pose_r


def dyadic_poses(p: Solid, r: Solid, k: int, rng: np.random.Generator) -> tuple[Points, Points]:
    """Poses (k, 4, 4) without rounding: quarter turns, a vertex of p on a vertex or an edge's middle of r, m.

    Bodies with short coordinates touch exactly, or miss or overlap by a few units in the last place.
    """
    pose_p, pose_r = identities(k), identities(k)
    pose_p[:, :3, :3] = quarter_turns(k, rng)
    pose_r[:, :3, :3] = quarter_turns(k, rng)
    corners = r.faces[rng.integers(0, len(r.faces), k)]
    second = np.where(rng.integers(0, 2, k) == 0, corners[:, 0], corners[:, 1])
    target = turned(pose_r, (r.vertices[corners[:, 0]] + r.vertices[second]) / 2)
    offset = target - turned(pose_p, p.vertices[rng.integers(0, len(p.vertices), k)])
    pose_p[:, :3, 3] = offset + rng.integers(-1, 2, size=(k, 3)) * np.spacing(np.abs(offset))
    return pose_p, pose_r
