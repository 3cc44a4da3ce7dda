"""Closes open meshes: seams between vertices that nearly coincide, and a cap on each loop of the edges that are left.

In: points and triangles of a mesh. Out: triangles to add, and `Caps`, which says what was closed.

The idea: chains of edges. A directed edge counts +1 and its reverse −1; an edge is *open* if its sum is not 0. Each
triangle leaves a vertex as often as it enters it, and so do all triangles together, so the open edges ∂ of a mesh form
closed walks. Two kinds of triangles cancel these edges, both with corners among the mesh's points alone:

- Seams. A vertex w(a) represents each vertex a of an open edge that is within `SEAM`, as a part of the mesh's size, of
  w(a). For each open edge ab the triangles (b, a, w(b)) and (w(b), a, w(a)) have the boundary −ab + w(a)w(b) + [a w(a)]
  − [b w(b)]. Summed over ∂, the terms in brackets cancel, since ∂ enters each vertex as often as it leaves it. So ∂
  becomes w(∂), in which the two sides of a seam cancel. No vertex moves, and no choice of w is wrong.
- Caps. The remaining open edges are split into loops that visit each vertex once; if loops share vertices, the shortest
  loop comes first, so that slits along a rim are closed one by one. The cone of triangles (v, b, a) from a vertex v of
  a loop over its edges ab has the boundary −ab, summed, since the edges at v cancel in the same way.

Then all edges cancel, so the mesh is closed: the set is its triangles and the points about which they wind. This set
holds all given triangles, since none is changed or left out. The hull of the given triangles holds this set: the hull
has all corners, so it has all triangles, and a closed mesh winds 0 times about any point outside of a convex set that
holds the mesh.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np

from plannercheck.common.array_types import Floats, Ints, Ints64
from plannercheck.common.arrays import distinct, distinct_values, grouped

# Vertices of open edges that are closer than this part of the mesh's largest extent are joined by a seam.
SEAM = 1e-6
# Vertices that searches for shortest loops may visit, some seconds; later loops are any loops.
_MOST_VISITS = 1_000_000
# Neighbours of a cell of the grid that finds close vertices, whose three coordinates are bits of one number.
_BITS = 21
_NEIGHBOURS = tuple((x << 2 * _BITS) + (y << _BITS) + z for x in (0, -1, 1) for y in (0, -1, 1) for z in (0, -1, 1))

# Heads of open edges by tail, each with how often the edge is there.
_Heads = dict[int, dict[int, int]]


@dataclass(frozen=True)
class Caps:
    """What closes an open mesh.

    Attributes:
        loops: Number of loops of open edges, each closed by a cap.
        edges: Number of their edges.
        size: The largest extent of a cap along an axis, m.
        seams: Number of open edges whose vertices were joined with others, at most `SEAM` of the mesh's size away.
    """

    loops: int
    edges: int
    size: float
    seams: int

    def __str__(self) -> str:
        count = "1 loop" if self.loops == 1 else f"{self.loops} loops"
        found = f"{count} of {self.edges} edges, largest cap {self.size:.3g} m" if self.loops else ""
        seams = f"{self.seams} edges of seams" if self.seams else ""
        return ", ".join(filter(None, (found, seams)))


def open_edges(triangles: Ints | Ints64) -> Ints64:
    """Directed edges (k, 2) of triangles (m, 3) that occur more often than their reverses, as often as the surplus."""
    return _uncancelled(_edges(triangles))


def closing(points: Floats, edges: Ints64) -> tuple[Ints, Caps]:
    """The triangles (k, 3) that close a mesh of distinct points (n, 3) with such `open_edges`, and what they close."""
    joined = _representatives(points, edges)[edges]
    is_seam = (joined != edges).any(axis=1)
    seams = _seam_triangles(edges[is_seam], joined[is_seam])
    rims = _uncancelled(joined)
    rims, loop, apex = _loops(rims, points)
    caps = _without_repeated_corners(np.column_stack([apex, rims[:, 1], rims[:, 0]]))
    added = np.concatenate([seams, caps]).astype(np.int32)
    assert not len(_uncancelled(np.concatenate([edges, _edges(added)]))), "a closed mesh has open edges"
    count = int(loop.max(initial=-1)) + 1
    return added, Caps(count, len(rims), _largest_extent(points[rims[:, 0]], loop), int(is_seam.sum()))


def _edges(triangles: Ints | Ints64) -> Ints64:
    """Directed edges (3 m, 2) of triangles (m, 3)."""
    return triangles.astype(np.int64)[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)


def _uncancelled(edges: Ints64) -> Ints64:
    """Directed edges (k, 2) less those that their reverses cancel, in order of their vertices."""
    tail, head = edges[edges[:, 0] != edges[:, 1]].T
    count = int(edges.max(initial=0)) + 1
    # Twice the number of an edge's two vertices, whatever its direction, and 1 more for a falling one.
    keys = np.sort((np.minimum(tail, head) * count + np.maximum(tail, head)) * 2 + (tail > head))
    starts = np.flatnonzero(np.diff(keys >> 1, prepend=-1))
    surplus = np.add.reduceat(1 - 2 * (keys & 1), starts) if len(starts) else starts
    low, high = np.divmod(keys[starts[surplus != 0]] >> 1, count)
    times = surplus[surplus != 0]
    found = np.repeat(np.where(times > 0, [low, high], [high, low]).T, np.abs(times), axis=0)
    return found[np.lexsort(found.T[::-1])]


def _representatives(points: Floats, edges: Ints64) -> Ints64:
    """For each point the one that stands for it (n,): of vertices of open edges an earlier one that is close enough.

    A representative stands for itself, so no chain of close vertices becomes longer than `SEAM`.
    """
    found = np.arange(len(points))
    vertices = distinct(edges)
    places = _in_units_of_seam(points)[vertices]
    grid = places.astype(np.int64) + 1
    cells = (grid[:, 0] << 2 * _BITS) + (grid[:, 1] << _BITS) + grid[:, 2]
    by_cell: dict[int, list[tuple[int, list[float]]]] = {}
    for vertex, cell, place in zip(vertices.tolist(), cells.tolist(), places.tolist(), strict=True):
        close = _close_one(by_cell, cell, place)
        if close is None:
            by_cell.setdefault(cell, []).append((vertex, place))
        else:
            found[vertex] = close
    return found


def _close_one(by_cell: dict[int, list[tuple[int, list[float]]]], cell: int, place: list[float]) -> int | None:
    """A vertex within a distance of 1, of those by cell of the grid."""
    for shift in _NEIGHBOURS:
        if cell + shift in by_cell:
            for vertex, at in by_cell[cell + shift]:
                if math.dist(at, place) <= 1:
                    return vertex
    return None


def _in_units_of_seam(points: Floats) -> Floats:
    """Points (n, 3) from the lowest corner of their box on, at most 1 / SEAM; no size of a mesh overflows."""
    extent = np.ptp(points / 2, axis=0).max(initial=0.0)
    halves: Floats = points / 2 - (points / 2).min(axis=0, initial=np.inf)
    return np.minimum(halves / extent, 1.0) / SEAM if extent else np.zeros_like(points)


def _seam_triangles(edges: Ints64, joined: Ints64) -> Ints64:
    """Triangles (k, 3) between open edges (m, 2) and the edges of their representatives."""
    (a, b), (to_a, to_b) = edges.T, joined.T
    both = np.concatenate([np.column_stack([b, a, to_b]), np.column_stack([to_b, a, to_a])])
    return _without_repeated_corners(both)


def _without_repeated_corners(triangles: Ints64) -> Ints64:
    a, b, c = triangles.T
    found: Ints64 = triangles[(a != b) & (b != c) & (c != a)]
    return found


def _loops(edges: Ints64, points: Floats) -> tuple[Ints64, Ints64, Ints64]:
    """Edges (k, 2) by loops: the edges in another order, and for each edge its loop's number and its loop's apex."""
    if not len(edges):
        return edges, np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    first = _first_of_plain_loops(edges)
    is_plain = first >= 0
    branching = list(_loops_of_branches(edges[~is_plain], _in_units_of_seam(points)))
    lengths = [len(loop) for loop in branching]
    tails = list(chain.from_iterable(branching))
    heads = list(chain.from_iterable(loop[1:] + loop[:1] for loop in branching))
    rims = np.concatenate([edges[is_plain], np.array([tails, heads], dtype=np.int64).T])
    numbers = grouped(first[is_plain]).places
    begin = int(numbers.max(initial=-1)) + 1
    number = np.concatenate([numbers, np.repeat(begin + np.arange(len(branching)), lengths)])
    apex = np.concatenate([first[is_plain], np.repeat(np.array(list(map(min, branching)), dtype=np.int64), lengths)])
    return rims, number, apex


def _first_of_plain_loops(edges: Ints64) -> Ints64:
    """The first vertex of each edge's loop (k,), if all vertices of the loop have one edge in and one out; else −1."""
    vertices, numbers = distinct_values(edges)
    count, (tail, head) = len(vertices), numbers.reshape(-1, 2).T
    meets_branch = np.bincount(tail) > 1
    onward, first = np.arange(count), np.arange(count)
    onward[tail] = head
    onward = np.where(meets_branch, first, onward)
    for _ in range(count.bit_length()):  # twice as many vertices ahead each time
        first, meets_branch = np.minimum(first, first[onward]), meets_branch | meets_branch[onward]
        onward = onward[onward]
    return np.where(meets_branch[tail], -1, vertices[first[tail]])


def _loops_of_branches(edges: Ints64, points: Floats) -> Iterator[list[int]]:
    """Loops that together have all edges (k, 2): the vertices of each, the shortest loop through some edge first."""
    heads: _Heads = {}
    for tail, head in edges.tolist():
        of_tail = heads.setdefault(tail, {})
        of_tail[head] = of_tail.get(head, 0) + 1
    place = dict(zip(heads, points[list(heads)].tolist(), strict=True))
    visits = _MOST_VISITS
    for tail in sorted(heads):
        while heads[tail]:
            if visits <= 0:
                yield from _any_loops(heads, tail)
                break
            loop, seen = _shortest_loop(heads, place, next(iter(heads[tail])), tail)
            visits -= seen
            for a, b in zip(loop, [*loop[1:], loop[0]], strict=True):
                _remove(heads, a, b)
            yield loop


def _shortest_loop(heads: _Heads, place: dict[int, list[float]], start: int, goal: int) -> tuple[list[int], int]:
    """The vertices of a shortest loop through the edge from the goal to the start; and how many were visited."""
    queue, before, seen = [(0.0, start, goal)], dict[int, int](), 0
    while queue:
        length, vertex, previous = heapq.heappop(queue)
        seen += 1
        if vertex in before:
            continue
        before[vertex] = previous
        if vertex == goal:
            break
        for head in heads[vertex]:
            if head not in before:
                heapq.heappush(queue, (length + math.dist(place[vertex], place[head]), head, vertex))
    path = [before[goal]]
    while path[-1] != goal:
        path.append(before[path[-1]])
    return path[::-1], seen


def _any_loops(heads: _Heads, start: int) -> Iterator[list[int]]:
    """Loops that a walk closes until the edges from its start are used up; takes their edges away."""
    path, place = [start], {start: 0}
    while heads[path[-1]]:
        following = next(iter(heads[path[-1]]))
        _remove(heads, path[-1], following)
        if following not in place:
            place[following] = len(path)
            path.append(following)
            continue
        loop = path[place[following] :]
        del path[place[following] + 1 :]
        for vertex in loop[1:]:
            del place[vertex]
        yield loop


def _remove(heads: _Heads, tail: int, head: int) -> None:
    """Takes one edge away."""
    if heads[tail][head] == 1:
        del heads[tail][head]
    else:
        heads[tail][head] -= 1


def _largest_extent(points: Floats, loop: Ints64) -> float:
    """The largest extent along an axis of a loop, m: of vertices (k, 3), and the loop that each belongs to."""
    if not len(points):
        return 0.0
    order = np.argsort(loop, kind="stable")
    begin = np.flatnonzero(np.diff(loop[order], prepend=-1))
    extent = np.maximum.reduceat(points[order], begin) - np.minimum.reduceat(points[order], begin)
    return float(extent.max())
