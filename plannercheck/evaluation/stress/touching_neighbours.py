"""Pairs of bodies that share exactly a face, an edge, a vertex or a part of an edge.

In: the kind of the shared feature, a size, a number of points. Out: two bodies in one frame, and the direction from the
second to the first. Points are on a lattice, so that middles are exact.
"""

from __future__ import annotations

import numpy as np

from plannercheck.evaluation.stress.body_families import FAMILIES
from plannercheck.evaluation.stress.contact_poses import Points, unit
from plannercheck.evaluation.stress.sample_bodies import Specimen, prepared

NEIGHBOURS = ("sharing a face", "a part of a face", "an edge", "a part of an edge", "a vertex")
# Steps of the lattice in a metre.
_STEPS = 2.0**14


def neighbours(kind: str, size: float, n: int, rng: np.random.Generator) -> tuple[Specimen, Specimen, Points]:
    """Two bodies that share something, by a kind in NEIGHBOURS; the larger one has this size, m, and about n points.

    The second to be moved, the first, and the unit direction (3,) from the first to the second. The size is a power of
    two.
    """
    r = prepared(kind, _on_lattice(FAMILIES[str(rng.choice(list(FAMILIES)))](n, rng)))
    face = r.polytope.faces[rng.integers(len(r.polytope.faces))]
    a, b, c = rng.permutation(r.vertices[face], axis=0)
    outward = _outward(kind, r, a, b, c)
    p_points = np.vstack([_shared(kind, a, b, c), _beyond(a, outward, rng)])
    return prepared(kind, p_points * size), prepared(kind, r.vertices * size), outward


def _on_lattice(points: Points) -> Points:
    """Rounded, with a small octahedron at the middle so that there is volume."""
    octahedron = np.vstack([np.eye(3), -np.eye(3)]) * 16
    return np.asarray(np.round(np.vstack([points * _STEPS, points.mean(axis=0) * _STEPS + octahedron])) / _STEPS)


def _shared(kind: str, a: Points, b: Points, c: Points) -> Points:
    return {
        "sharing a face": np.stack([a, b, c]),
        "a part of a face": np.stack([(a + b) / 2, (b + c) / 2, (c + a) / 2, a]),
        "an edge": np.stack([a, b]),
        "a part of an edge": np.stack([(a + b) / 2, b + (b - a) / 2]),
        "a vertex": a[None],
    }[kind]


def _outward(kind: str, r: Specimen, a: Points, b: Points, c: Points) -> Points:
    """A unit direction (3,) in which the shared feature is about extreme."""
    touched = {"an edge": (a, b), "a part of an edge": (a, b), "a vertex": (a,)}.get(kind, (a, b, c))
    corners = r.vertices[r.polytope.faces]
    at_feature = np.all([np.any(np.all(corners == point, axis=2), axis=1) for point in touched], axis=0)
    arms = corners[at_feature]
    normals = np.cross(arms[:, 1] - arms[:, 0], arms[:, 2] - arms[:, 0])
    return np.asarray(unit(unit(normals).sum(axis=0)[None])[0])


def _beyond(a: Points, outward: Points, rng: np.random.Generator) -> Points:
    """A few lattice points (k, 3) ahead of a, near to the outward ray."""
    heights = rng.uniform(0.1, 1, size=(4, 1))
    sideways = rng.uniform(-0.05, 0.05, size=(4, 3))
    return np.asarray(np.round((a + heights * outward + sideways) * _STEPS) / _STEPS)
