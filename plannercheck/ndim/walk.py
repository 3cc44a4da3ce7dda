"""The alternating test (paper, section "Testing intersection in higher dimensions").

In: the tree of P, the tree of the polar Q of R about a point inside R, and the affine map from P's frame to that of R.
Out: a verdict in doubles with the hyperplanes (separation invariant) or points (inverse separation invariant) found.

Each round plays the game between two nets, P_N and Q_N, and steps one level down in one tree:

- value above 1: some q in Q_N ⊂ Q has q·x > 1 on P_N, while R is on q·x ≤ 1. The faces of P that can meet R are those
  with a vertex beyond P_N at the vertex that the hyperplane touches: P steps down. At a leaf, no face of P meets R.
- value at most 1: some x in P_N ⊂ P has q·x ≤ 1 on Q_N. In the polar, x·y = 1 keeps Q_N off ρ∞(P_N) ⊃ ρ∞(P): Q steps
  down. At a leaf, no face of Q meets ρ∞(P), and the bodies share a point.

So there are at most as many rounds as both depths together, O(log n + log m), each of constant cost.

A case that the text leaves out: it prunes faces of P, and if R lies strictly inside P, no face of P meets R although
they intersect. So the walk first asks whether the point inside R is in P, by one walk down the tree of P's own polar.
(Q has no such case: ρ∞(P) is unbounded and Q is not.)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.ndim.game import play
from plannercheck.ndim.poses import solved
from plannercheck.ndim.tree import Tree


@dataclass(frozen=True)
class Walked:
    """How a walk ended; a guide, up to rounding.

    Attributes:
        shares: The verdict.
        hyperplanes: Hyperplanes of the rounds with the separation invariant: q (k, d), in R's frame about its centre.
        points: Points of the rounds with the inverse one: x (k, d), likewise.
        rounds: Rounds of the game.
        nodes: Visited, in all trees.
        visited: Vertices in them.
    """

    shares: bool
    hyperplanes: Floats
    points: Floats
    rounds: int
    nodes: int
    visited: int


@dataclass(frozen=True)
class Side:
    """What the walk needs of P: its two trees, and the map y = linear x + shift into R's frame about R's centre."""

    tree: Tree
    polar_tree: Tree
    centre: Floats
    linear: Floats
    shift: Floats


def walk(p: Side, r_polar: Tree) -> Walked:
    """Walks down the trees of the first body, in the second's frame, and of the second's polar about its origin."""
    origin = solved(p.linear, -p.shift) - p.centre
    best, nodes, visited = p.polar_tree.extreme(origin)
    if p.polar_tree.points[best] @ origin <= 1.0:
        none = np.zeros((0, len(origin)))
        return Walked(True, none, none, 0, nodes, visited)
    return _Walk(p, r_polar, nodes, visited).run()


class _Walk:
    def __init__(self, p: Side, r_polar: Tree, nodes: int, visited: int) -> None:
        self.p, self.q = p, r_polar
        self.at_p = self.at_q = 0
        self.nodes, self.visited, self.rounds = nodes, visited, 0
        self.hyperplanes: list[Floats] = []
        self.points: list[Floats] = []
        self.net_p, self.net_q = self._enter_p(0), self._enter_q(0)

    def run(self) -> Walked:
        while (verdict := self._step()) is None:
            pass
        d = len(self.p.shift)
        return Walked(
            verdict,
            np.array(self.hyperplanes).reshape(-1, d),
            np.array(self.points).reshape(-1, d),
            self.rounds,
            self.nodes,
            self.visited,
        )

    def _step(self) -> bool | None:
        """One round; the verdict if it was the last."""
        if not len(self.net_p) or not len(self.net_q):
            return len(self.net_p) > 0
        self.rounds += 1
        played = play(self.net_p, self.net_q)
        if played.separates:
            self.hyperplanes.append(played.q)
            if self.p.tree.nodes[self.at_p].is_leaf:
                return False
            outward = -(played.q @ self.p.linear)
            self.net_p = self._enter_p(self.p.tree.child(self.at_p, played.lowest, outward))
            return None
        self.points.append(played.x)
        if self.q.nodes[self.at_q].is_leaf:
            return True
        self.net_q = self._enter_q(self.q.child(self.at_q, played.highest, played.x))
        return None

    def _enter_p(self, number: int) -> Floats:
        self.at_p = number
        net = self.p.tree.nodes[number].net
        self._count(len(net))
        return np.asarray(self.p.tree.points[net] @ self.p.linear.T + self.p.shift)

    def _enter_q(self, number: int) -> Floats:
        self.at_q = number
        net = self.q.nodes[number].net
        self._count(len(net))
        return np.asarray(self.q.points[net])

    def _count(self, visited: int) -> None:
        self.nodes += 1
        self.visited += visited
