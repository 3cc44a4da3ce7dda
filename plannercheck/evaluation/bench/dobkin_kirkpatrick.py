"""The walk of Dobkin and Kirkpatrick (1990), for comparison: the closest pair down both inner hierarchies.

In: prepared bodies with volume, and their poses. Out: whether they share a point, and the visited vertices.

The idea: keep the closest pair of P_i and R_j, and go down one level in P or in R, alternately. The plane through the
pair's point of P, at right angles to the pair, is tangent to P_i; at most one vertex p of the next level lies beyond
it, and it is a neighbour of every vertex on the plane. If there is none, the pair stays. If there is, a closer pair can
only be on p's star, which is of constant size: its closest pair with R_j is found the same way, down the levels of R
from the top to j. So O(log n) steps may each cost O(log m): O(log n log m) in all.

The paper of 1990 leaves open how p is found. A scan of the neighbours that appear at that level, as here, is linear in
the degree, which the degree-doubling polyhedron of the paper (section "Polyhedra in 3D space") makes linear in n.

Only the levels come from the core. All vertices are mapped to the world at once, which is not counted: a fast program
would map only those that it visits. In doubles, contact is a distance below `nearest_points.TOUCHING`.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import distinct
from plannercheck.evaluation.bench.nearest_points import Nearest, nearest_of_few
from plannercheck.evaluation.bench.truncated_hierarchies import alive_levels

# m, for bodies of about 1 m: a vertex so little beyond a plane is on it, as far as doubles can tell.
_BEYOND = 1e-9


class LevelledBody:
    """The inner hierarchy of a body as a stack of levels: what appears at each, and where.

    Attributes:
        vertices: Vertices of the body (n, 3), m.
        top: Indices of the vertices of the coarsest level.
        stars: For each level below the top, coarse to fine, and each vertex that appears there: itself and its
            neighbours at that level.
        appearing: For each level and each vertex: which of its neighbours appear there.
    """

    def __init__(self, body: Polytope) -> None:
        """Finds the edges of every level of a body with volume."""
        self.vertices = body.vertices
        alive = [np.arange(len(body.vertices)), *alive_levels(body)]
        self.top = alive[-1]
        self.stars: list[dict[int, Ints64]] = []
        self.appearing: list[dict[int, list[int]]] = []
        for finer, coarser in zip(alive[-2::-1], alive[:0:-1], strict=True):
            self._add_level(finer, distinct(finer[~np.isin(finer, coarser)]))

    def _add_level(self, alive: Ints64, new: Ints64) -> None:
        is_new = np.zeros(len(self.vertices), dtype=bool)
        is_new[new] = True
        stars: dict[int, list[int]] = {int(v): [int(v)] for v in new}
        appearing: dict[int, list[int]] = defaultdict(list)
        for a, b in _edges(self.vertices, alive):
            if is_new[a]:
                stars[a].append(b)
                appearing[b].append(a)
        self.stars.append({v: np.array(star) for v, star in stars.items()})
        self.appearing.append(dict(appearing))


def _edges(vertices: Floats, alive: Ints64) -> list[tuple[int, int]]:
    """The edges of a level, both ways round, without those within a facet, which triangulation adds."""
    hull = Polytope(vertices[alive])
    apex: dict[tuple[int, int], int] = {}
    for a, b, c in alive[hull.source[hull.faces]].tolist():
        apex |= {(a, b): c, (b, c): a, (c, a): b}
    ends = np.array(list(apex))
    left, right = np.array(list(apex.values())), np.array([apex[b, a] for a, b in apex])
    a, b, c, d = (vertices[k] for k in (ends[:, 0], ends[:, 1], left, right))
    # Nearly flat edges may stay or go by rounding; facets of the families are flat without any.
    bent = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) != 0
    return [(int(start), int(end)) for start, end in ends[bent].tolist()]


@dataclass(frozen=True)
class Walked:
    """How a walk ended.

    Attributes:
        shared: The verdict.
        rounds: Levels passed, those of the walks within the walk included.
        visited: Vertices scanned, and those of the stars whose closest pairs were found.
    """

    shared: bool
    rounds: int
    visited: int


def walk(first: LevelledBody, second: LevelledBody, pose_first: Floats, pose_second: Floats) -> Walked:
    """Whether two bodies share a point at poses (4, 4), m, with counters."""
    return _Walk(_Posed(first, pose_first), _Posed(second, pose_second)).run()


class _Posed:
    """A body in the world; `level` counts the levels below the top that the walk has passed."""

    def __init__(self, body: LevelledBody, pose: Floats) -> None:
        self.body = body
        self.points = body.vertices @ pose[:3, :3].T + pose[:3, 3]
        self.level = 0

    @property
    def is_at_bottom(self) -> bool:
        return self.level == len(self.body.stars)


class _Walk:
    def __init__(self, first: _Posed, second: _Posed) -> None:
        self.sides = first, second
        self.rounds = self.visited = 0

    def run(self) -> Walked:
        pair = self._closest(self.sides[0].body.top, self.sides[1].body.top)
        turn = 0
        while not pair.is_contact and not all(side.is_at_bottom for side in self.sides):
            if not self.sides[turn].is_at_bottom:
                pair = self._step_down(turn, pair)
            turn = 1 - turn
        return Walked(pair.is_contact, self.rounds, self.visited)

    def _step_down(self, turn: int, pair: Nearest) -> Nearest:
        """One level down in one body: the closest pair with that level."""
        side = self.sides[turn]
        found = self._beyond(turn, side.level, pair)
        side.level += 1
        if found is None:
            return pair
        return _nearer(pair, self._from_star(turn, side.body.stars[side.level - 1][found]))

    def _from_star(self, turn: int, star: Ints64) -> Nearest:
        """The closest pair of a star and the other body's current level, down from that body's top."""
        other = self.sides[1 - turn]
        pair = self._closest_with(turn, star, other.body.top)
        for level in range(other.level):
            found = None if pair.is_contact else self._beyond(1 - turn, level, pair)
            if found is not None:
                pair = _nearer(pair, self._closest_with(turn, star, other.body.stars[level][found]))
        return pair

    def _beyond(self, turn: int, level: int, pair: Nearest) -> int | None:
        """The vertex of the next level that lies beyond the plane through the pair's point, if any."""
        self.rounds += 1
        side = self.sides[turn]
        point, tangent, inwards = (
            (pair.first, pair.first_vertices, pair.apart),
            (pair.second, pair.second_vertices, -pair.apart),
        )[turn]
        appearing = min((side.body.appearing[level].get(int(v), []) for v in tangent), key=len)
        self.visited += len(appearing)
        if not appearing:
            return None
        heights = (side.points[appearing] - point) @ (inwards / pair.distance)
        lowest = int(np.argmin(heights))
        return appearing[lowest] if heights[lowest] < -_BEYOND else None

    def _closest_with(self, turn: int, own: Ints64, other: Ints64) -> Nearest:
        return self._closest(own, other) if turn == 0 else self._closest(other, own)

    def _closest(self, first: Ints64, second: Ints64) -> Nearest:
        """The closest pair of two sets of constant size; its vertices are the body's."""
        self.visited += len(first) + len(second)
        found = nearest_of_few(self.sides[0].points[first], self.sides[1].points[second])
        return Nearest(found.first, found.second, first[found.first_vertices], second[found.second_vertices])


def _nearer(pair: Nearest, other: Nearest) -> Nearest:
    return other if other.distance < pair.distance else pair
