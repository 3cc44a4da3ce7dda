"""Two bodies made in one frame, so that they share features exactly, at any pose that both have.

In: a relation's name. Out: two surfaces about 1 m across: parts of one heap of cells on either side of a cut, a body
and itself, a part of itself or half of it, a body in a cavity that it fills or nearly fills.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from plannercheck.evaluation.stress_solids.solid_families import (
    LATTICE_FAMILIES,
    ROUND_FAMILIES,
    STEPS,
    box,
    boxes,
    crumpled,
    heap,
    nested_boxes,
    square_ring,
)
from plannercheck.evaluation.stress_solids.surfaces import Surface, joined, of_cells, surface

# Size of what is small, m.
_SMALL = 2.0**-9

Partners = tuple[Surface, Surface]


def neighbouring_cells(n: int, rng: np.random.Generator) -> Partners:
    """Cells of one lattice that belong to one body or the other: faces, edges and corners are shared."""
    side = int(np.clip(round((n / 8) ** (1 / 3) * 1.6), 2, 8))
    owner = rng.integers(0, int(rng.integers(2, 6)), (side, side, side))
    owner[0, 0, 0], owner[-1, -1, -1] = 0, 1
    first, second = owner == 0, owner == 1
    step = 2.0 ** -np.ceil(np.log2(side))
    p, r = (of_cells(cells, rng).scaled(step) for cells in (first, second))
    return p, r


def identical(n: int, rng: np.random.Generator) -> Partners:
    """A body and itself, maybe inside out."""
    body = _any(n, rng)
    return body, body.inverted if rng.integers(2) else body


def part_of_itself(n: int, rng: np.random.Generator) -> Partners:
    """A body and some of its triangles."""
    body = _any(n, rng)
    some = rng.permutation(len(body.triangles))[: int(rng.integers(1, 4))]
    return surface(body.points, body.triangles[some]), body


def halved(n: int, rng: np.random.Generator) -> Partners:
    """A body and the same one, half as large, about a vertex of it."""
    body = _any(n, rng)
    centre = body.points[body.triangles[rng.integers(len(body.triangles)), 0]]
    return Surface((body.points + centre) / 2, body.triangles), body


def mirrored(n: int, rng: np.random.Generator) -> Partners:
    """A body and its image in a plane through its lowest or highest vertex, or through 0."""
    body = _any(n, rng)
    axis = int(rng.integers(3))
    planes = [body.used_points[:, axis].min(), body.used_points[:, axis].max(), 0.0]
    image = body.points.copy()
    image[:, axis] = 2 * planes[rng.integers(3)] - image[:, axis]
    return Surface(image, body.triangles), body


def in_a_cavity(n: int, rng: np.random.Generator) -> Partners:
    """A box in the cavity of another, which it fills, touches from within or leaves."""
    inner = np.array([-0.25, 0.25])
    shell = joined([box(-np.full(3, 0.5), np.full(3, 0.5)), box(*(np.full(3, x) for x in inner)).inverted])
    room = rng.choice([0.0, 2.0**-6, 2.0**-40], (2, 3))
    filling = box(-0.25 + room[0], 0.25 - room[1])
    return (filling.inverted if rng.integers(2) else filling), shell


def small_inside(n: int, rng: np.random.Generator) -> Partners:
    """A small tetrahedron at a lattice point of a body's box, from which rays along axes meet edges and corners.

    It is inside, in a cavity, outside or across the surface.
    """
    families = [heap, nested_boxes, boxes, square_ring, crumpled]
    body = families[int(rng.integers(len(families)))](n, rng)
    low, high = body.used_points.min(axis=0), body.used_points.max(axis=0)
    place = np.round((low + (high - low) * rng.integers(1, 16, 3) / 16) * STEPS) / STEPS
    corners = np.vstack([np.zeros(3), np.eye(3)]) * rng.choice([-1, 1], 3) * _SMALL
    return surface(corners + place, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]), body


def _any(n: int, rng: np.random.Generator) -> Surface:
    families = LATTICE_FAMILIES if rng.random() < 0.6 else ROUND_FAMILIES
    return families[str(rng.choice(list(families)))](n, rng)


PARTNERS: dict[str, Callable[[int, np.random.Generator], Partners]] = {
    "neighbouring cells": neighbouring_cells,
    "identical": identical,
    "part of itself": part_of_itself,
    "halved": halved,
    "mirrored": mirrored,
    "in a cavity": in_a_cavity,
    "small inside": small_inside,
}
