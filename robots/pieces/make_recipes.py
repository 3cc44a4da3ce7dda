"""Makes the recipes of convex pieces that come with plannercheck: which triangles of a mesh make a piece together.

Run: python robots/pieces/make_recipes.py, a minute. It also writes the table in README.md. It starts from a piece for
each triangle. Again and again, it joins the two touching pieces whose common hull sticks out of the mesh least, as
samples show. A recipe holds no point of the mesh.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import combinations
from typing import TypeAlias

import numpy as np
from make_pieces import BY_RECIPE, FOLDER, concave_meshes, meshes, row, write_table

from plannercheck.bodies.piece_recipes import pieces_by_recipe, recipe_text
from plannercheck.bodies.pieces import mesh_hash
from plannercheck.bodies.protrusion import SolidDistances, filled
from plannercheck.bodies.shipped_pieces import RECIPE, file_name
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.common.array_types import Ints64

# Pieces of bodies. All others stay hulls: as pieces, they take away hardly anything of what hulls refuse in random
# states.
COUNTS = {"torso_lift_link_0": 5, "arm_1_link_0": 3}
# Random points of a hull that are looked at, and the middles between any two vertices.
SAMPLES = 300

Corners: TypeAlias = frozenset[int]  # numbers of points of a mesh


def main() -> None:
    """Makes all files anew, and the table."""
    for robot in BY_RECIPE:
        links = {link for link, _, _ in concave_meshes(robot).values()}
        for body, (link, _, mesh) in meshes(robot).items():
            if link in links:  # whoever names a link takes all its meshes as pieces
                make(robot, body, mesh)
    write_table()


def make(robot: str, body: str, mesh: TriangleMesh) -> None:
    """Makes the recipe of one mesh."""
    key, text = mesh_hash(mesh), recipe_text(mesh, joined(mesh, COUNTS.get(body, 1)))
    file = FOLDER / file_name(robot, body, key, RECIPE)
    file.write_text(text, encoding="ascii")
    pieces = pieces_by_recipe(text, mesh, key)
    assert pieces is not None
    print(file.name, *row(pieces), flush=True)


def joined(mesh: TriangleMesh, count: int) -> Ints64:
    """(m,) the piece of each triangle of a mesh, of so many pieces, or of fewer."""
    if count == 1:
        return np.zeros(len(mesh.triangles), dtype=np.int64)
    excess = excess_of(mesh)
    groups = set(map(frozenset, mesh.triangles.tolist()))
    while len(groups) > count:
        pairs = list(combinations(groups, 2))
        touching = [pair for pair in pairs if len(pair[0] & pair[1]) > 1]  # along an edge
        unions = {one | other for one, other in touching or pairs}
        best = min(unions, key=lambda union: (excess(union), sorted(union)))
        groups = {best} | {each for each in groups if not each <= best}
    ordered = sorted(map(sorted, groups))
    chosen = [next(k for k, group in enumerate(ordered) if set(triangle) <= set(group)) for triangle in mesh.triangles]
    return np.searchsorted(sorted(set(chosen)), chosen).astype(np.int64)


def excess_of(mesh: TriangleMesh) -> Callable[[Corners], float]:
    """How far the hull of some points of a mesh sticks out of it, as samples show, m."""
    distances = SolidDistances(filled(mesh))

    @cache
    def excess(corners: Corners) -> float:
        points = mesh.points[sorted(corners)]
        one, other = np.triu_indices(len(points), 1)
        weights = np.random.default_rng(0).dirichlet(np.full(len(points), 0.3), SAMPLES)
        samples = np.concatenate([(points[one] + points[other]) / 2, weights @ points])
        return float(distances.apart(samples).max())

    return excess


if __name__ == "__main__":
    main()
