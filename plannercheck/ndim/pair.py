"""The intersection test for one pair of posed polytopes in any dimension.

In: two `Polytope`s and their poses. Out: a verdict, or a verdict with its certificate. Steps: the trees or the double
oracle find a verdict in doubles; a filter with a proved bound confirms it; where it can't, integers decide.

What is exact: a body given by points is their hull, a body given by halfspaces is their intersection, and a pose is the
affine map that its doubles give. The verdict is that of these sets, touching included, without tolerance. Hulls,
polars, trees and corners are rounded and only guide.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, TypeAlias

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.public_names import set_module
from plannercheck.ndim.bodies import Polytope, check_bodies
from plannercheck.ndim.certificates import Certificate, Effort, PosedShape, Shapes, certificate_of
from plannercheck.ndim.exact import ExactSharedPoint, Guess, decide
from plannercheck.ndim.filters import Posed
from plannercheck.ndim.guides import Hint, game_hint, in_frame, program_hint
from plannercheck.ndim.nearest import nearest
from plannercheck.ndim.posed import Exact
from plannercheck.ndim.poses import Pose, affine_of, rounded_inverse, solved
from plannercheck.ndim.proofs import proves_apart, proves_shared
from plannercheck.ndim.walk import Side, Walked, walk

Method: TypeAlias = Literal["auto", "tree", "oracle", "exact"]

METHODS: tuple[Method, ...] = ("auto", "tree", "oracle", "exact")


@set_module("plannercheck.ndim")
def intersects(P: Polytope, R: Polytope, pose_p: Pose = None, pose_r: Pose = None, method: Method = "auto") -> bool:
    """Says whether two polytopes share a point.

    Args:
        P: The first polytope.
        R: The second polytope, of the same dimension d.
        pose_p: Where the first is: None, a (d + 1, d + 1) matrix, or a pair (M, t); any invertible affine map.
        pose_r: The same for the second.
        method: "oracle" (double oracle over plain supports), "tree" (the paper's hierarchical trees; built at first
            use, which can take minutes; a body that has none within its memory takes the oracle, and `Effort` says
            so), "exact" (integers alone), or "auto": what answers fastest, which is the oracle at all sizes whose trees
            fit in memory, so it never builds any. Verdicts are the same.

    Returns:
        True if they share a point, also if they only touch.
    """
    return verdict(P, R, pose_p, pose_r, method)[0]


@set_module("plannercheck.ndim")
def verdict(
    P: Polytope, R: Polytope, pose_p: Pose = None, pose_r: Pose = None, method: Method = "auto"
) -> tuple[bool, Effort]:
    """Like `intersects`, and says how the verdict was found: `Effort` with the method, rounds and vertices visited."""
    pair = _Pair(P, R, pose_p, pose_r, method)
    if pair.proved is not None:
        return pair.proved, pair.effort
    found, games = decide(*pair.exact(), guess=pair.guess)
    return isinstance(found, ExactSharedPoint), pair.effort_of_exact(games)


@set_module("plannercheck.ndim")
def certify(P: Polytope, R: Polytope, pose_p: Pose = None, pose_r: Pose = None, method: Method = "auto") -> Certificate:
    """Says whether two polytopes share a point, with the proof.

    Args:
        P: The first polytope.
        R: The second polytope.
        pose_p: As for `intersects`.
        pose_r: As for `intersects`.
        method: As for `intersects`; `effort` of the certificate says which one it was.

    Returns:
        A `Separation` or a `SharedPoint`; their `verify` proves them in fractions.
    """
    pair = _Pair(P, R, pose_p, pose_r, method)
    bodies = pair.exact()
    found, games = decide(*bodies, guess=pair.guess)
    effort = pair.effort if pair.proved is not None else pair.effort_of_exact(games)
    trail = pair.trail(isinstance(found, ExactSharedPoint))
    return certificate_of(found, bodies, pair.shapes, effort, trail)


class _Pair:
    """One query: the verdict if doubles prove it, where exact arithmetic may start, and what it took."""

    def __init__(self, P: Polytope, R: Polytope, pose_p: Pose, pose_r: Pose, method: Method) -> None:
        if method not in METHODS:
            raise unknown_name("method", method, METHODS)
        check_bodies(P, R)
        if P.dimension != R.dimension:
            raise PlannercheckError(
                f"{P.name} has dimension {P.dimension} and {R.name} {R.dimension}: the same is expected"
            )
        self.P, self.R = P, R
        self.pose_p, self.pose_r = (
            affine_of(pose, P.dimension, name) for pose, name in ((pose_p, "pose_p"), (pose_r, "pose_r"))
        )
        self.walked: Walked | None = None
        self.proved: bool | None = None
        self.guess: Guess | None = None
        self.effort = Effort("exact", "exact")
        if method != "exact":
            self._prove(self._walk() if method == "tree" else "")

    @property
    def shapes(self) -> Shapes:
        """The bodies as given."""
        return (
            PosedShape(self.pose_p, self.P.vertices, self.P.normals, self.P.offsets),
            PosedShape(self.pose_r, self.R.vertices, self.R.normals, self.R.offsets),
        )

    def exact(self) -> tuple[Exact, Exact]:
        """Both bodies in integers."""
        first, second = self.shapes
        return first.exact(), second.exact()

    def effort_of_exact(self, games: int) -> Effort:
        """The effort, with the games that integers played."""
        return replace(self.effort, proof="exact", games=games)

    def trail(self, shares: bool) -> Floats:
        """What the walk found on the way to the verdict, in the world: hyperplanes (q, b), or points (x, 1)."""
        if self.walked is None:
            return np.zeros((0, self.P.dimension + 1))
        if shares:
            points = self.pose_r.of(self.walked.points + self.R.centre)
            return np.column_stack([points, np.ones(len(points))])
        normals = solved(self.pose_r.matrix.T, self.walked.hyperplanes.T).T
        centre = self.pose_r.of(self.R.centre[None])[0]
        return np.column_stack([normals, 1.0 + normals @ centre])

    def _walk(self) -> str:
        """Walks the trees; says why not if a body has none."""
        tree, inner, polar = self.P.tree, self.P.polar_tree, self.R.polar_tree
        if tree is None or inner is None or polar is None:
            return "; ".join(f"{body.name}: {body.tree_note}" for body in (self.P, self.R) if body.tree_note)
        linear = rounded_inverse(self.pose_r.matrix) @ self.pose_p.matrix
        shift = in_frame(self.pose_p.shift[None], self.pose_r)[0] - self.R.centre
        self.walked = walk(Side(tree, inner, self.P.centre, linear, shift), polar)
        return ""

    def _prove(self, note: str) -> None:
        if self.P.vertices is not None and self.R.vertices is not None:
            self._by_vertices(note)
        else:
            self._by_halfspaces(note)

    def _by_vertices(self, note: str) -> None:
        assert self.P.vertices is not None, "both bodies are given by vertices"
        assert self.R.vertices is not None, "both bodies are given by vertices"
        p = Posed(self.P.vertices, self.pose_p, self.P.reach)
        r = Posed(self.R.vertices, self.pose_r, self.R.reach)
        found = nearest(p, r, self._directions())
        self.proved, self.guess = found.shares, Guess(found.active_p, found.active_r)
        self._set_effort("oracle", found.rounds, found.visited, note)

    def _directions(self) -> list[Floats]:
        """Directions from the second body to the first to try: of the walk, the last first, or between the centres."""
        if self.walked is not None and not self.walked.shares:
            normals = solved(self.pose_r.matrix.T, self.walked.hyperplanes[::-1].T).T
            if len(normals):
                return list(normals)
        return [self.pose_p.of(self.P.centre[None])[0] - self.pose_r.of(self.R.centre[None])[0]]

    def _by_halfspaces(self, note: str) -> None:
        hint = self._hint()
        self.guess = Guess(hint.active_p, hint.active_r)
        if self._is_proved(hint):
            self.proved = hint.shares
        self._set_effort(hint.method, hint.rounds, hint.visited, note)

    def _hint(self) -> Hint:
        if self.P.vertices is not None and self.R.has_inside:
            return game_hint(self.P, self.R, self.pose_p, self.pose_r)
        if self.R.vertices is not None and self.P.has_inside:
            hint = game_hint(self.R, self.P, self.pose_r, self.pose_p)
            return replace(hint, active_p=hint.active_r, active_r=hint.active_p)
        return program_hint(self.P, self.R, self.pose_p, self.pose_r)

    def _is_proved(self, hint: Hint) -> bool:
        mixed, body_b = ((self.P, self.pose_p), (self.R, self.pose_r))
        if self.P.vertices is None and self.R.vertices is not None:
            mixed, body_b = body_b, mixed
        if hint.shares:
            return proves_shared(hint, mixed, body_b)
        return bool(hint.weights_r) and proves_apart(hint, mixed, body_b)

    def _set_effort(self, method: str, rounds: int, visited: int, note: str) -> None:
        if self.walked is None:
            self.effort = Effort(method, rounds=rounds, visited=visited, note=note)
            return
        w = self.walked
        self.effort = Effort("tree", rounds=w.rounds, nodes=w.nodes, visited=w.visited, checked=visited, note=note)
