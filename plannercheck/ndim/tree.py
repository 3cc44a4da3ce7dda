"""Hierarchical trees of ε-nets with shell simplices (paper, section "Detecting intersections in higher dimensions").

In: the vertices of a polytope and the simplices of its boundary. Out: `Tree`. A node stands for a set F* of boundary
simplices ("faces"; facets are enough, because a body that meets the boundary meets a facet). It holds a net N of them,
as the vertices of its hull, and children: where a hyperplane tangent to the net's hull at a vertex v has the other body
on its far side, only faces with a vertex beyond the hull's own halfspaces at v can meet that body. They are the child.

Where this departs from the text, and why the bounds hold:

- Of a shell simplex only the d halfspaces at the tangent vertex are used, a cone (`plannercheck.ndim.polar`): its
  complement is smaller than the simplex's.
- First a *star* is tried: all of the net's halfspaces at v at once, one child a vertex instead of one a simplex of the
  normal cone. Its complement holds those of all shell simplices at v, so it is valid; it is taken if it holds at most
  half of the faces. Else v's normal cone is triangulated as in the paper. With bounded degrees the stars need
  |N| children a node where the shell simplices need O(|N|^⌊d/2⌋).
- Nets are random samples of constant size, and what they promise is measured: a child is at most half its parent
  (stars), or smaller (cones); one that is not becomes a leaf, and the tree says so. Equal children are kept once.
- The walk through the trees only guides: whatever rounding does to a tree, verdicts are proved afterwards.

Memory is bounded: nodes are opened largest first, and what is still closed when the bound is reached stays a leaf,
larger than a node should be. Such a tree still gives the right walks, but no longer constant-size nodes: it is not
`complete`.
"""

from __future__ import annotations

import hashlib
import heapq
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Bools, Floats, Ints
from plannercheck.common.arrays import OwnsArrays, distinct_rows, grouped, read_only_copy
from plannercheck.ndim.qhull import FlatError, Hull, convex_hull
from plannercheck.ndim.rounding import FLAT

# Vertices of a net by dimension: constant, and large enough that a star holds at most half of the faces of a random
# polytope and of its polar. A set with no more vertices than LEAF_SIZES is a leaf: a scan of that many is cheaper than
# the levels that it saves, and smaller leaves cost memory.
NET_SIZES = {2: 32, 3: 128}
LEAF_SIZES = {2: 64, 3: 512, 4: 768, 5: 2048, 6: 2560}
_LARGEST_NET = 512
_LARGEST_LEAF = 2560
# A child of a star is at most this part of its parent.
_STAR_SHRINKS = 0.5
# A child of a cone that is more than this part of its parent is not opened any further.
_CONE_SHRINKS = 0.95
# Bytes of a node besides its arrays, with Python's own.
_NODE_BYTES = 400


@dataclass(frozen=True)
class Cones(OwnsArrays):
    """The normal cone of a net's vertex, cut into simplicial cones.

    Attributes:
        inverses: (s, d, d): inverses[k] @ normal is at least 0 exactly if the normal lies in the cone.
        children: The child of each (s,).
    """

    inverses: NDArray[np.float32]
    children: Ints


@dataclass
class Node(OwnsArrays):
    """A set of faces.

    Attributes:
        net: Indices of the net's hull vertices; of all vertices of the faces in a leaf, which may be none.
        children: One for each of the net: a node's number, or cones. Empty in a leaf.
    """

    net: Ints
    children: list[int | Cones] = field(default_factory=list)

    @property
    def is_leaf(self) -> bool:
        """Whether the node holds its faces themselves."""
        return not self.children


class Tree:
    """The hierarchical tree of one polytope.

    Attributes:
        points: The vertices (n, d).
        nodes: The root is number 0.
        nbytes: Memory, of the nodes and the points.
        complete: Whether every leaf is of constant size.
        depth: Nodes on the longest path.
    """

    def __init__(
        self, points: Floats, simplices: Ints | None, memory: int, sizes: tuple[int, int] | None = None, seed: int = 0
    ) -> None:
        """Builds the tree.

        Args:
            points: Vertices (n, d), d at least 2, of a body with volume.
            simplices: Its boundary (m, d), as indices into points; not needed if all points are one leaf.
            memory: Bytes at most.
            sizes: Vertices of a net and, at most, of a leaf; by dimension if None.
            seed: Seed of the samples.
        """
        self.points = read_only_copy(points)
        if simplices is None:
            simplices = np.arange(len(points), dtype=np.int32)[:, None]
        builder = _Builder(points, simplices, memory, sizes or default_sizes(points.shape[1]), seed)
        self.nodes = builder.nodes
        self.nbytes = builder.nbytes + points.nbytes
        self.complete = builder.complete
        self.depth = 1 + max(builder.depths)

    @property
    def largest_leaf(self) -> int:
        """Vertices of the largest leaf."""
        return max(len(node.net) for node in self.nodes if node.is_leaf)

    def child(self, number: int, position: int, normal: Floats) -> int:
        """The child of a node to walk to when a hyperplane of outward normal (d,) is tangent to the node's net.

        `position` is that of the tangent vertex in the net.
        """
        found = self.nodes[number].children[position]
        if isinstance(found, Cones):
            inside = (found.inverses @ normal.astype(np.float32)).min(axis=1)
            return int(found.children[int(np.argmax(inside))])
        return found

    def extreme(self, normal: Floats) -> tuple[int, int, int]:
        """A vertex furthest along a normal (d,), by one walk from the root to a leaf; nodes and vertices visited."""
        number, best, height, nodes, visited = 0, -1, -np.inf, 0, 0
        while True:
            node = self.nodes[number]
            if not len(node.net):
                return best, nodes, visited
            heights = self.points[node.net] @ normal
            position = int(np.argmax(heights))
            nodes, visited = nodes + 1, visited + len(heights)
            if heights[position] > height:
                best, height = int(node.net[position]), float(heights[position])
            if node.is_leaf:
                return best, nodes, visited
            number = self.child(number, position, normal)


def default_sizes(dimension: int) -> tuple[int, int]:
    """Vertices of a net and of a leaf."""
    return NET_SIZES.get(dimension, _LARGEST_NET), LEAF_SIZES.get(dimension, _LARGEST_LEAF)


class _Builder:
    """Opens nodes, largest first."""

    def __init__(self, points: Floats, simplices: Ints, memory: int, sizes: tuple[int, int], seed: int) -> None:
        self.points, self.simplices = points, simplices
        self.memory = memory
        self.net_size, self.leaf_size = sizes
        self.rng = np.random.default_rng(seed)
        self.slack = FLAT * float(np.abs(points).max())
        self.nodes: list[Node] = []
        self.depths: list[int] = []
        self.nbytes, self.complete = 0, True
        self.known: dict[bytes, int] = {}
        self.closed: list[tuple[int, int, Ints]] = []
        self._add(np.arange(len(simplices), dtype=np.int32), 0, True)
        self._open_all()

    def _open_all(self) -> None:
        while self.closed:
            if self.nbytes > self.memory:
                self.complete = False
                return
            _, number, faces = heapq.heappop(self.closed)
            if not self._open(number, faces):
                self.complete = False

    def _add(self, faces: Ints, depth: int, shrinks: bool) -> int:
        """A node for some faces, as a leaf; it is opened later if it is large."""
        key = hashlib.blake2b(faces.tobytes(), digest_size=16).digest()
        if key in self.known:
            return self.known[key]
        number = self.known[key] = len(self.nodes)
        node = Node(self._vertices(faces))
        self.nodes.append(node)
        self.depths.append(depth)
        self.nbytes += _NODE_BYTES + node.net.nbytes
        if len(node.net) > self.leaf_size:
            self.complete &= shrinks
            if shrinks:
                heapq.heappush(self.closed, (-len(faces), number, faces))
        return number

    def _vertices(self, faces: Ints) -> Ints:
        used = np.zeros(len(self.points), dtype=bool)
        used[self.simplices[faces].ravel()] = True
        return np.flatnonzero(used).astype(np.int32)

    def _open(self, number: int, faces: Ints) -> bool:
        """Gives a node a net and children; False if its points span no volume."""
        node, vertices = self.nodes[number], self.nodes[number].net
        chosen = self._net(faces)
        try:
            hull = convex_hull(self.points[chosen])
        except FlatError:
            return False
        node.net = chosen[hull.vertices]
        self.nbytes += node.net.nbytes - vertices.nbytes
        step = _Step(
            faces=faces,
            local=np.searchsorted(vertices, self.simplices[faces]),
            vertices=self.points[vertices],
            net=self.points[chosen],
            hull=hull,
            slack=self.slack,
            depth=self.depths[number] + 1,
        )
        node.children = [self._child(step, corner) for corner in hull.vertices]
        return True

    def _net(self, faces: Ints) -> Ints:
        """A random sample of faces, as their vertices."""
        # More faces than these would not add to the net.
        drawn = self.rng.permutation(len(faces))[: 4 * self.net_size]
        corners = self.simplices[faces[drawn]].ravel()
        first = grouped(corners).first
        return np.sort(corners[np.sort(first)[: self.net_size]])

    def _child(self, step: _Step, corner: int) -> int | Cones:
        facets = step.facets_at(corner)
        beyond = step.beyond(facets)
        faces = step.faces_beyond(np.asarray(beyond.any(axis=0)))
        if len(faces) > _STAR_SHRINKS * len(step.faces) and len(facets) > self.points.shape[1]:
            simplices = step.cones_at(corner)
            if len(simplices):  # none only if rounding hides the corner's normal cone
                rows = beyond[np.searchsorted(facets, simplices)]
                return self._cones(step, simplices, np.asarray(rows.any(axis=1)))
        return self._add(faces, step.depth, len(faces) <= _CONE_SHRINKS * len(step.faces))

    def _cones(self, step: _Step, simplices: Ints, beyond: Bools) -> Cones:
        masks, which = distinct_rows(beyond)
        numbers = []
        for mask in masks:
            faces = step.faces_beyond(mask)
            numbers.append(self._add(faces, step.depth, len(faces) <= _CONE_SHRINKS * len(step.faces)))
        inverses = np.linalg.inv(step.hull.normals[simplices].transpose(0, 2, 1)).astype(np.float32)
        self.nbytes += inverses.nbytes + 4 * len(simplices) + _NODE_BYTES
        return Cones(inverses, np.array(numbers, dtype=np.int32)[which.ravel()])


@dataclass(eq=False)
class _Step:
    """What opening one node works with.

    Attributes:
        faces: The node's faces.
        local: Their corners, as positions among the node's vertices.
        vertices: The node's vertices (n, d).
        net: The net's points.
        hull: Hull of the net.
        slack: How far beyond a facet a vertex has to be to count.
        depth: Depth of the children.
    """

    faces: Ints
    local: NDArray[np.intp]
    vertices: Floats
    net: Floats
    hull: Hull
    slack: float
    depth: int

    def facets_at(self, corner: int) -> NDArray[np.intp]:
        """The net's facets at one of its vertices."""
        return np.flatnonzero((self.hull.simplices == corner).any(axis=1))

    def beyond(self, facets: NDArray[np.intp]) -> Bools:
        """Which of the node's vertices are beyond which of some facets (facets, vertices)."""
        heights = self.hull.normals[facets] @ self.vertices.T
        return np.asarray(heights > self.hull.offsets[facets, None] + self.slack)

    def faces_beyond(self, beyond: Bools) -> Ints:
        """The faces with a vertex among those."""
        return self.faces[beyond[self.local].any(axis=1)]

    def cones_at(self, corner: int) -> Ints:
        """The shell simplices at a vertex: rows of d facets of the net's hull."""
        simplices, corners = self._triangulated_polar
        found = simplices[corners == corner]
        at_corner = np.isin(found, self.facets_at(corner)).all(axis=1)
        found = found[at_corner]
        has_volume = np.abs(np.linalg.det(self.hull.normals[found])) > FLAT
        return np.asarray(found[has_volume])

    @cached_property
    def _triangulated_polar(self) -> tuple[Ints, Ints]:
        inside = self.net[self.hull.vertices].mean(axis=0)
        polars = self.hull.normals / (self.hull.offsets - self.hull.normals @ inside)[:, None]
        try:
            polar_hull = convex_hull(polars)
        except FlatError:  # qhull gives up on some polars; stars, which need none, are valid, too
            none = np.zeros((0, polars.shape[1]), dtype=np.int32)
            return none, none[:, 0]
        heights = polar_hull.normals @ (self.net[self.hull.vertices] - inside).T
        return polar_hull.simplices, self.hull.vertices[np.argmax(heights, axis=1)]
