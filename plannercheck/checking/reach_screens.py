"""A fast test for all pairs of a robot's bodies: which pairs lever arms can't prove apart.

In: the tree of moving joints with lengths along it, pairs of bodies. Out: the pairs for which a search by the cells of
unreachable_pairs.py can succeed. For all others it would certainly fail.

The idea. Each body of a pair is bounded by a ball, and a proof needs the distance of the balls' centres to exceed the
sum of their radii. A ball stands at the first joint of its branch whose value is unknown. So the distance of the
centres is at most the length of the chain along the known joints, and each radius is the length of the chain beyond. A
cut knows at most the joints of a branch before its third column. If even then the chain between the centres is shorter
than both radii together, no cut proves anything. In a chain of a thousand links, a few neighbours of each link remain
of half a million pairs.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from plannercheck.common.array_types import Bools, Floats, Ints64

# Rounding of lengths, as a part of them and in m: a pair is skipped only if it fails by more than this.
_ROOM, _LEAST_ROOM = 1e-6, 1e-9

_WORLD = 0


class JointTree(NamedTuple):
    """The moving joints: node 0 is the world, the others are joints, parents first.

    Attributes:
        parents: (n,) nodes; the world's is itself.
        columns: (n,) the columns that drive the joints; -1 where a joint can't be cut.
        origins: (n, 3) of the joints' frames before they move, m, in one configuration.
        ways: (n,) lengths along the joints from the world to these origins, m; lengths without a bound count as 0.
        bodies: (b,) the node that each body hangs on.
        centres: (b, 3) centres of the bodies' balls, m.
        body_ways: (b,) lengths from the world to these centres, m.
        radii: (b,) radii of the balls, m.
    """

    parents: Ints64
    columns: Ints64
    origins: Floats
    ways: Floats
    bodies: Ints64
    centres: Floats
    body_ways: Floats
    radii: Floats


class Screen:
    """Looks up pairs in a tree. Jumps are doubled, so a look-up takes as many steps as the depth has bits."""

    def __init__(self, tree: JointTree) -> None:
        self._tree = tree
        self._depth = _depths(tree.parents)
        self._jumps = [tree.parents]  # 1, 2, 4 ... nodes up
        while 1 << len(self._jumps) <= self._depth.max():
            self._jumps.append(self._jumps[-1][self._jumps[-1]])

    def forks(self, pairs: Ints64) -> Ints64:
        """(k,) the last joint that both bodies of each pair (k, 2) hang on, or the world."""
        a, b = (self._tree.bodies[side] for side in pairs.T)
        level = np.minimum(self._depth[a], self._depth[b])
        a, b = self._above(a, level), self._above(b, level)
        for jump in reversed(self._jumps):
            differ = jump[a] != jump[b]
            a, b = np.where(differ, jump[a], a), np.where(differ, jump[b], b)
        return np.asarray(np.where(a == b, a, self._tree.parents[a]))

    def static(self, pairs: Ints64) -> Bools:
        """(k,) whether no joint moves the bodies of each pair against each other."""
        return np.asarray(self._tree.bodies[pairs[:, 0]] == self._tree.bodies[pairs[:, 1]])

    def may_be_proved(self, pairs: Ints64, columns: int) -> Bools:
        """Whether a cut might prove that the bodies of a pair never meet.

        Args:
            pairs: (k, 2) indices of bodies.
            columns: How many columns a cut has at most.

        Returns:
            (k,); False is certain: no cut proves the pair apart. True is not.
        """
        forks = self._depth[self.forks(pairs)]
        sides = [self._side(pairs[:, side], forks, columns) for side in (0, 1)]
        between = np.linalg.norm(sides[0].start - sides[1].start, axis=1) + sides[0].way + sides[1].way
        beyond = sides[0].beyond + sides[1].beyond
        return np.asarray(between * (1 + _ROOM) + _LEAST_ROOM > beyond)

    def _above(self, nodes: Ints64, depths: Ints64) -> Ints64:
        """The ancestors of nodes at these depths; the nodes themselves where they are not deeper."""
        left = np.maximum(self._depth[nodes] - depths, 0)
        for k, jump in enumerate(self._jumps):
            nodes = np.where(left >> k & 1 == 1, jump[nodes], nodes)
        return nodes

    def _side(self, bodies: Ints64, forks: Ints64, columns: int) -> _Side:
        tree = self._tree
        nodes = tree.bodies[bodies]
        first = self._above(nodes, forks + 1)
        still = self._depth[nodes] <= forks  # no joint from the fork to the body
        unknown = self._first_unknown(nodes, forks + 1, columns)
        whole = unknown < 0
        begin = np.where(still, tree.body_ways[bodies], tree.ways[first])
        end = np.where(whole, tree.body_ways[bodies], tree.ways[unknown])
        start = np.where(still[:, None], tree.centres[bodies], tree.origins[first])
        beyond = np.where(whole, 0.0, tree.body_ways[bodies] - end + tree.radii[bodies])
        return _Side(start, end - begin, beyond)

    def _first_unknown(self, nodes: Ints64, depths: Ints64, columns: int) -> Ints64:
        """The first joint from these depths towards the nodes that no cut of so many columns knows; -1 if none."""
        found = np.full(len(nodes), -1, dtype=np.int64)
        seen = np.full((len(nodes), columns), -1, dtype=np.int64)
        left, depth = np.arange(len(nodes)), depths.copy()
        while len(left := left[depth[left] <= self._depth[nodes[left]]]):
            joint = self._above(nodes[left], depth[left])
            column = self._tree.columns[joint]
            new = (seen[left] != column[:, None]).all(axis=1)
            full = new & (seen[left] >= 0).all(axis=1) | (column < 0)
            found[left[full]] = joint[full]
            added = left[new & ~full]
            seen[added, (seen[added] >= 0).sum(axis=1)] = column[new & ~full]
            depth[left] += 1
            left = left[~full]
        return found


class _Side(NamedTuple):
    """One side of k pairs: the start of its branch (k, 3), and its lengths along known joints and beyond, (k,) m."""

    start: Floats
    way: Floats
    beyond: Floats


def _depths(parents: Ints64) -> Ints64:
    """(n,) how many joints there are from the world to each node."""
    depth = [0] * len(parents)
    for node, parent in enumerate(parents.tolist()):
        depth[node] = 0 if node == _WORLD else depth[parent] + 1
    return np.array(depth, dtype=np.int64)


def joint_tree(
    parents: Sequence[int],
    columns: Sequence[int],
    slides: Sequence[float],
    origins: tuple[Floats, Floats],
    bodies: Sequence[int],
    balls: tuple[Floats, Floats],
) -> JointTree:
    """The tree, with lengths along it.

    Args:
        parents: The parent of each of n moving joints, -1 for the world; parents come first.
        columns: The column of each, -1 where it can't be cut.
        slides: How far each takes its frame from where it hangs at most, m; infinite if unknown.
        origins: (n, 3) each, origins of the frames before and after the joints' motions, m.
        bodies: The last moving joint of each body, -1 for the world.
        balls: Centres (b, 3) and radii (b,) of balls around the bodies, m.
    """
    before = np.concatenate([np.zeros((1, 3)), origins[0]])
    after = np.concatenate([np.zeros((1, 3)), origins[1]])
    slide = np.concatenate([[0.0], np.where(np.isfinite(slides), slides, 0.0)])
    above = np.concatenate([[_WORLD], np.asarray(parents, dtype=np.int64) + 1])
    steps = np.where(above > _WORLD, np.linalg.norm(before - after[above], axis=1) + slide[above], 0.0)
    ways = steps.tolist()
    for node, parent in enumerate(above.tolist()):
        ways[node] += 0.0 if node == _WORLD else ways[parent]
    of_body, (centres, radii) = np.asarray(bodies, dtype=np.int64) + 1, balls
    last = np.linalg.norm(centres - after[of_body], axis=1) + slide[of_body]
    body_ways = np.where(of_body > _WORLD, np.array(ways)[of_body] + last, 0.0)
    cut = np.concatenate([[-1], np.asarray(columns, dtype=np.int64)])
    return JointTree(above, cut, before, np.array(ways), of_body, centres, body_ways, radii)
