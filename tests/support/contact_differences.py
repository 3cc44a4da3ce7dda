"""Whether two bodies at given poses surely differ from a contact: too far apart for it, or too deep in each other."""

import exact_verdicts
import numpy as np
from solids import centroid

from plannercheck.bodies import exact_reference as exact
from plannercheck.evaluation.stress.contact_poses import Points, Solid, unit


def differ_from_contact(p: Solid, r: Solid, pose_p: Points, pose_r: Points, gap: float) -> bool:
    """Whether two bodies are further than a gap apart, or overlap by more than about that much, m.

    Shrinking p towards its centroid moves its supporting planes by at most the gap; so if that separates
    colliding bodies, they overlap by at most the gap. No plane lies nearer to the centroid than a quarter of
    the width, so each moves by a fair part of the gap; for a long body that part is small, therefore the overlap
    along the facets' normals has to exceed the gap as well.
    """
    if not exact_verdicts.intersects(p.vertices, r.vertices, pose_p, pose_r):
        return exact.distance(p.vertices, r.vertices, pose_p, pose_r) > gap
    arms = p.vertices - centroid(p)
    part = min(1.0, gap / np.linalg.norm(arms, axis=1).max())
    if overlap_along_facets(p, r, pose_p, pose_r) <= gap:
        return False
    return exact_verdicts.intersects(p.vertices - part * arms, r.vertices, pose_p, pose_r)


def overlap_along_facets(p: Solid, r: Solid, pose_p: Points, pose_r: Points) -> float:
    """The least overlap of two bodies along a normal of a facet of either, m: at least their depth."""
    first, second = (s.vertices @ pose[:3, :3].T + pose[:3, 3] for s, pose in ((p, pose_p), (r, pose_r)))
    overlaps = []
    for solid, pose in ((p, pose_p), (r, pose_r)):
        normals = unit(solid.normals[np.any(solid.normals != 0, axis=1)] @ pose[:3, :3].T)
        for directions in (normals, -normals):
            overlaps.append((directions @ first.T).max(axis=1) - (directions @ second.T).min(axis=1))
    return float(np.concatenate(overlaps).min())
