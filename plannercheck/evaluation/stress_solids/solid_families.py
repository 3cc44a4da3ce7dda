"""Solids for tests of pairs: families of triangle meshes on which such tests differ.

In: a family's name, about how many triangles, a random generator. Out: a `Surface`, about 1 m across. Families on a
lattice have short coordinates, so that contact by construction is exact. Which faults a mesh may have besides, such as
holes, is in `variations`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.package_data import example_robot_data
from plannercheck.evaluation.stress.body_families import MESHES
from plannercheck.evaluation.stress_solids.surfaces import (
    Cells,
    Surface,
    ball,
    circle,
    joined,
    merged,
    of_cells,
    of_grid,
    surface,
    tube,
)

# Steps of the lattice in a metre.
STEPS = 64.0
_TETRAHEDRON = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
_WHOLE_TURN = 2 * np.pi


def centred_cells(cells: Cells, rng: np.random.Generator) -> Surface:
    """The border of cells about the origin, the longest side 1/2 to 1 m."""
    step = 2.0 ** -np.ceil(np.log2(max(cells.shape)))
    found = of_cells(cells, rng)
    return Surface((found.points - np.array(cells.shape) / 2) * step, found.triangles)


def heap(n: int, rng: np.random.Generator) -> Surface:
    """Random cells of a lattice: coplanar faces, cavities, edges and corners that several triangles share."""
    side = int(np.clip(round((n / 8) ** (1 / 3) * 1.3), 2, 12))
    cells = rng.random((side, side, side)) < rng.uniform(0.2, 0.8)
    cells[tuple(rng.integers(0, side, 3))] = True
    return centred_cells(cells, rng)


def comb(n: int, rng: np.random.Generator) -> Surface:
    """A spine with teeth."""
    teeth = int(np.clip(n // 40, 2, 30))
    cells = np.zeros((2 * teeth - 1, int(rng.integers(2, 5)), 1), dtype=bool)
    cells[:, 0], cells[::2] = True, True
    return centred_cells(cells, rng)


def square_ring(n: int, rng: np.random.Generator) -> Surface:
    """A square frame."""
    side = int(rng.integers(3, 6))
    cells = np.ones((side, side, 1), dtype=bool)
    cells[1:-1, 1:-1] = False
    return centred_cells(cells, rng)


def box(low: Floats, high: Floats) -> Surface:
    """An axis-aligned box, m."""
    found = of_cells(np.ones((1, 1, 1), dtype=bool), np.random.default_rng(0))
    return Surface(np.where(found.points == 0, low, high), found.triangles)


def lattice_points(shape: tuple[int, ...], steps: int, rng: np.random.Generator) -> Floats:
    """Points between −1/2 and 1/2 m of a lattice of so many steps, which divide those in a metre."""
    return np.asarray(rng.integers(0, steps + 1, (*shape, 3)) / steps - 0.5)


def boxes(n: int, rng: np.random.Generator) -> Surface:
    """Boxes on, in, beside and across each other, some inside out: faces within faces, corners on faces."""
    parts = []
    for _ in range(max(2, n // 12)):
        low, high = np.sort(lattice_points((2,), int(rng.choice([4, 8])), rng), axis=0)
        part = box(low, np.where(low == high, high + 1 / 8, high))
        parts.append(part.inverted if rng.random() < 0.3 else part)
    return joined(parts)


def nested_boxes(n: int, rng: np.random.Generator) -> Surface:
    """Shells within shells."""
    halves = np.sort(rng.choice(np.arange(1, 33), size=max(2, min(8, n // 12)), replace=False))[::-1] / STEPS
    parts = [box(-half * np.ones(3), half * np.ones(3)) for half in halves]
    return joined([part.inverted if k % 2 else part for k, part in enumerate(parts)])


def crumpled(n: int, rng: np.random.Generator) -> Surface:
    """A sphere's triangles between corners of a small lattice: crosses itself, folded, triangles without area."""
    like = ball(max(8, n))
    return surface(lattice_points((len(like.points),), int(rng.choice([2, 4, 8, 64])), rng), like.triangles)


def tetrahedra(n: int, rng: np.random.Generator) -> Surface:
    """Tetrahedra of a small lattice anywhere, any side out."""
    count, steps = max(1, n // 4), int(rng.choice([2, 4, 64]))
    return joined([surface(lattice_points((4,), steps, rng), _TETRAHEDRON) for _ in range(count)])


def triangle_soup(n: int, rng: np.random.Generator) -> Surface:
    """Triangles of a lattice anywhere: not closed."""
    count = max(1, min(n, 30))
    steps = int(rng.choice([4, 64]))
    return surface(lattice_points((3 * count,), steps, rng), np.arange(3 * count))


def one_triangle(n: int, rng: np.random.Generator) -> Surface:
    """One triangle, also a segment or a point."""
    corners = [[0, 1, 2], [0, 1, 2], [0, 1, 2], [0, 1, 1], [0, 0, 0]][rng.integers(5)]
    return surface(lattice_points((3,), int(rng.choice([4, 64])), rng), corners)


def torus(n: int, rng: np.random.Generator) -> Surface:
    """A ring."""
    sides = int(np.clip(round(np.sqrt(n / 4)), 3, 200))
    section = circle(sides, rng.uniform(0.03, 0.2))
    return tube(_ring_path(max(3, n // (2 * sides)), 0.3), section, True, rng)


def _ring_path(corners: int, radius: float) -> Floats:
    return np.column_stack([circle(corners, radius), np.zeros(corners)])


def chain(n: int, rng: np.random.Generator) -> Surface:
    """Rings through one another."""
    count = int(rng.integers(2, 5))
    link = torus(max(24, n // count), rng)
    quarter = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    step = 0.4
    places = (np.arange(count) - (count - 1) / 2) * step
    links = [link.moved(quarter if k % 2 else np.eye(3), np.array([x, 0, 0])) for k, x in enumerate(places)]
    return joined(links).scaled(0.5)


def spring(n: int, rng: np.random.Generator) -> Surface:
    """A wound tube with ends."""
    turns, sides = rng.uniform(1.5, 4), int(rng.integers(3, 6))
    t = np.linspace(0, 1, max(int(8 * turns), n // (2 * sides)))
    angles = _WHOLE_TURN * turns * t
    path = np.stack([0.3 * np.cos(angles), 0.3 * np.sin(angles), t - 0.5], axis=1)
    return tube(path, circle(sides, rng.uniform(0.02, 0.4 / turns)), False, rng)


def screw(n: int, rng: np.random.Generator) -> Surface:
    """A shaft with a thread."""
    sides = int(np.clip(round(np.sqrt(n / 4)), 5, 150))
    rows = max(4, n // (2 * sides))
    z, angle = np.meshgrid(np.linspace(-0.5, 0.5, rows), np.arange(sides) / sides, indexing="ij")
    radius = 0.15 + 0.1 * np.abs((3 * z + angle) % 1 - 0.5)
    points = np.stack([radius * np.cos(_WHOLE_TURN * angle), radius * np.sin(_WHOLE_TURN * angle), z], axis=2)
    side = of_grid(points, (False, True), rng).inverted
    fan = np.stack([np.zeros(sides - 2, dtype=np.int64), np.arange(1, sides - 1), np.arange(2, sides)], axis=1)
    return surface(side.points, np.vstack([side.triangles, fan[:, ::-1], fan + (rows - 1) * sides]))


def round_shells(n: int, rng: np.random.Generator) -> Surface:
    """Spheres within spheres, every other one turned inside out; as many as there are often."""
    count = int(rng.integers(2, 4))
    radii = np.sort(rng.uniform(0.2, 1, count))[::-1]
    shells = [ball(max(8, n // count)).scaled(r) for r in radii]
    return joined([shell.inverted if k % 2 and rng.random() < 0.7 else shell for k, shell in enumerate(shells)])


def bowl(n: int, rng: np.random.Generator) -> Surface:
    """A thick bowl."""
    sides = int(np.clip(round(np.sqrt(n / 2)), 4, 100))
    rows = max(3, n // (4 * sides))
    angles = np.linspace(np.pi, np.pi / 2, rows)
    outer, inner = 0.5, rng.uniform(0.3, 0.49)
    profile = np.vstack(
        [
            np.stack([outer * np.sin(angles), outer * np.cos(angles)], axis=1),
            np.stack([inner * np.sin(angles[::-1]), inner * np.cos(angles[::-1])], axis=1),
        ]
    )
    turns = _WHOLE_TURN * np.arange(sides) / sides
    points = np.stack(
        [profile[:, :1] * np.cos(turns), profile[:, :1] * np.sin(turns), np.repeat(profile[:, 1:], sides, axis=1)],
        axis=2,
    )
    points[[0, -1], :, :2] = 0
    return merged(of_grid(points, (False, True), rng).inverted)


def figure_eight(n: int, rng: np.random.Generator) -> Surface:
    """A ring whose section crosses itself: one half of it is inside out."""
    corners = max(6, round(np.sqrt(n / 4)) * 2)
    t = _WHOLE_TURN * (np.arange(corners) + 0.3) / corners
    section = 0.2 * np.stack([np.sin(t), np.sin(2 * t)], axis=1)
    return tube(_ring_path(max(4, n // (2 * corners)), 0.3), section, True, rng)


def klein_bottle(n: int, rng: np.random.Generator) -> Surface:
    """A figure of eight that is turned over on its way round: one-sided, so its edges do not cancel."""
    columns = max(6, round(np.sqrt(n / 4)) * 2)
    rows = max(6, n // (2 * columns))
    u, v = np.meshgrid(_WHOLE_TURN * np.arange(rows) / rows, _WHOLE_TURN * np.arange(columns) / columns, indexing="ij")
    far = 2 + np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v)
    up = np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v)
    points = np.stack([far * np.cos(u), far * np.sin(u), up], axis=2) / 6
    closing = points[:1, (-np.arange(columns)) % columns]
    return merged(of_grid(np.concatenate([points, closing]), (False, True), rng))


def knot(n: int, rng: np.random.Generator) -> Surface:
    """A trefoil, thin, or so thick that it crosses itself."""
    sides = int(rng.integers(3, 6))
    t = _WHOLE_TURN * np.arange(max(20, n // (2 * sides))) / max(20, n // (2 * sides))
    path = np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1) / 6
    return tube(path, circle(sides, rng.uniform(0.02, 0.2)), True, rng)


def star(n: int, rng: np.random.Generator) -> Surface:
    """A prism over a five-pointed star drawn in one line: its middle is wound around twice."""
    points = np.column_stack([circle(5, 0.5)[[0, 2, 4, 1, 3]], np.zeros(5)])
    hub = np.zeros((1, 3))
    lower, upper = np.vstack([points, hub]), np.vstack([points, hub])
    lower[:, 2], upper[:, 2] = -0.3, 0.3
    k, following = np.arange(5), (np.arange(5) + 1) % 5
    bottom = np.stack([following, k, np.full(5, 5)], axis=1)
    sides = np.vstack([np.stack([k, following, following + 6], axis=1), np.stack([k, following + 6, k + 6], axis=1)])
    return surface(np.vstack([lower, upper]), np.vstack([bottom, bottom[:, ::-1] + 6, sides]))


def spikes(n: int, rng: np.random.Generator) -> Surface:
    """A star-shaped body with long spikes: slivers between them."""
    like = ball(max(8, n))
    return Surface(like.points * rng.choice([0.1, 0.3, 1.0], (len(like.points), 1)), like.triangles)


def terrain(n: int, rng: np.random.Generator) -> Surface:
    """Heights over a grid: not closed."""
    side = max(2, round(np.sqrt(n / 2)) + 1)
    x, y = np.meshgrid(np.arange(side), np.arange(side), indexing="ij")
    heights = rng.integers(0, 16, (side, side)) / STEPS
    return of_grid(np.stack([x / (side - 1) - 0.5, y / (side - 1) - 0.5, heights], axis=2), (False, False), rng)


def robot_mesh(n: int, rng: np.random.Generator) -> Surface:
    """A robot's collision mesh as it is shipped, about its middle and 1 m across; n is what it has."""
    import coal

    path = example_robot_data() / "example-robot-data" / "robots" / MESHES[rng.integers(len(MESHES))]
    mesh = coal.MeshLoader().load(str(path), np.ones(3))
    points = np.array(mesh.vertices())
    corners = [[mesh.tri_indices(k)[j] for j in range(3)] for k in range(mesh.num_tris)]
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    return surface((points - middle) / np.ptp(points, axis=0).max(), corners)


Family = Callable[[int, np.random.Generator], Surface]
# With coordinates on the lattice.
LATTICE_FAMILIES: dict[str, Family] = {
    "heap of cells": heap,
    "comb": comb,
    "square ring": square_ring,
    "boxes": boxes,
    "nested boxes": nested_boxes,
    "crumpled": crumpled,
    "tetrahedra": tetrahedra,
    "triangle soup": triangle_soup,
    "one triangle": one_triangle,
}
ROUND_FAMILIES: dict[str, Family] = {
    "torus": torus,
    "chain": chain,
    "spring": spring,
    "screw": screw,
    "round shells": round_shells,
    "bowl": bowl,
    "figure of eight": figure_eight,
    "Klein bottle": klein_bottle,
    "knot": knot,
    "star": star,
    "spikes": spikes,
    "terrain": terrain,
}
# Rare: thousands of triangles.
LARGE_FAMILIES: dict[str, Family] = {"robot mesh": robot_mesh}
SOLID_FAMILIES: dict[str, Family] = {**LATTICE_FAMILIES, **ROUND_FAMILIES, **LARGE_FAMILIES}
