"""Guesses for pairs in which a body is given by halfspaces: by the game, or by a linear program.

In: two bodies and their poses. Out: `Hint`: a verdict to prove, the vertices and halfspaces that decide it, and a point
to try. Nothing here is trusted; `plannercheck.ndim.pair` proves it, in doubles or in integers.

The game (points against halfspaces, `plannercheck.ndim.game`) needs a point strictly inside the halfspaces. For two
bodies of halfspaces, and for bodies without interior, a linear program (HiGHS through SciPy) finds the point deepest
inside all halfspaces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.ndim.bodies import Polytope
from plannercheck.ndim.game import play
from plannercheck.ndim.halfspaces import lengths
from plannercheck.ndim.poses import Affine, rounded_inverse
from plannercheck.ndim.qhull import part_of_scipy

# Actives of a linear program: weights and prices above this part of the largest.
_ACTIVE = 1e-9


@dataclass(frozen=True)
class Hint:
    """What a guide found.

    Attributes:
        shares: The verdict to prove.
        active_p: Vertices or halfspaces of the first body that decide.
        active_r: The same of the second.
        point: To try as a common point, in the world (d,).
        weights_p: That mix the point from vertices of the body that is given by them, by index; empty if none is.
        weights_r: Multipliers of the other body's halfspaces if they separate; empty if not known.
        multipliers_p: The same of the first body's, if both are given by halfspaces.
        rounds: Rounds of the method.
        visited: Vertices and halfspaces looked at.
        method: "oracle" or "linear program".
    """

    shares: bool
    active_p: tuple[int, ...]
    active_r: tuple[int, ...]
    point: Floats
    weights_p: dict[int, float]
    weights_r: dict[int, float]
    multipliers_p: dict[int, float]
    rounds: int
    visited: int
    method: str


def game_hint(p: Polytope, r: Polytope, pose_p: Affine, pose_r: Affine) -> Hint:
    """Plays vertices of the first body against halfspaces of the second, which has an inside; poses in the world."""
    assert p.vertices is not None, "the first body is given by vertices"
    assert r.normals is not None, "the second body is given by halfspaces"
    assert r.offsets is not None, "halfspaces have offsets"
    depths = r.offsets - r.normals @ r.centre
    points = in_frame(pose_p.of(p.vertices), pose_r) - r.centre
    played = play(points, r.normals / depths[:, None])
    # A row that is 0 · x ≤ b bounds nothing; it has weight 0, or a polar point at the origin.
    multipliers = {k: w / float(depths[k]) for k, w in played.weights_q.items()}
    return Hint(
        shares=not played.separates,
        active_p=tuple({**played.weights_p, played.lowest: 0.0}),
        active_r=tuple({**played.weights_q, played.highest: 0.0}),
        point=pose_r.of((played.x + r.centre)[None])[0],
        weights_p=played.weights_p,
        weights_r=multipliers if played.separates else {},
        multipliers_p={},
        rounds=played.rounds,
        visited=(played.rounds + 1) * (len(points) + len(depths)),
        method="oracle",
    )


def in_frame(points: Floats, pose: Affine) -> Floats:
    """World points (n, d) in a body's frame, rounded."""
    if pose.is_identity:
        return points
    return np.asarray((points - pose.shift) @ rounded_inverse(pose.matrix).T)


def program_hint(p: Polytope, r: Polytope, pose_p: Affine, pose_r: Affine) -> Hint:
    """Asks a linear program for the point deepest inside both bodies, whose poses are in the world."""
    program = _Program(p.dimension)
    for body, pose in ((p, pose_p), (r, pose_r)):
        program.add(body, pose)
    return program.solve()


class _Program:
    """Unknowns: the point x, the depth s, then the weights of vertices of either body."""

    def __init__(self, dimension: int) -> None:
        self.d = dimension
        self.rows: list[tuple[Floats, Floats]] = []
        self.vertices: list[Floats] = []
        self.sizes: list[Floats] = []
        self.bodies: list[tuple[str, int]] = []

    def add(self, body: Polytope, pose: Affine) -> None:
        if body.vertices is not None:
            self.vertices.append(pose.of(body.vertices))
            self.bodies.append(("vertices", len(body.vertices)))
            return
        assert body.normals is not None, "a body has vertices or halfspaces"
        assert body.offsets is not None, "halfspaces have offsets"
        normals = body.normals @ rounded_inverse(pose.matrix)
        sizes = lengths(normals)
        offsets = body.offsets + normals @ pose.shift
        self.sizes.append(sizes)
        self.rows.append((normals / sizes[:, None], offsets / sizes))
        self.bodies.append(("rows", len(offsets)))

    def solve(self) -> Hint:
        count = sum(len(v) for v in self.vertices)
        cost = np.zeros(self.d + 1 + count)
        cost[self.d] = -1.0
        normals = np.concatenate([n for n, _ in self.rows])
        upper = np.zeros((len(normals), len(cost)))
        upper[:, : self.d] = normals
        upper[:, self.d] = 1.0
        equal, right = self._mixtures(len(cost))
        bounds = [(None, None)] * self.d + [(None, self._size())] + [(0, None)] * count
        answer = part_of_scipy("optimize").linprog(
            cost, A_ub=upper, b_ub=np.concatenate([b for _, b in self.rows]), A_eq=equal, b_eq=right, bounds=bounds
        )
        if answer.x is None:
            return Hint(True, (0,), (0,), np.zeros(self.d), {}, {}, {}, 0, 0, "linear program")
        return self._hint(answer.x, -np.asarray(answer.ineqlin.marginals))

    def _size(self) -> float:
        return 1.0 + max(float(np.abs(b).max()) for _, b in self.rows)

    def _mixtures(self, width: int) -> tuple[Floats | None, Floats | None]:
        if not self.vertices:
            return None, None
        blocks, right, column = [], [], self.d + 1
        for points in self.vertices:
            block = np.zeros((self.d + 1, width))
            block[: self.d, : self.d] = -np.eye(self.d)
            block[: self.d, column : column + len(points)] = points.T
            block[self.d, column : column + len(points)] = 1.0
            blocks.append(block)
            right.append(np.append(np.zeros(self.d), 1.0))
            column += len(points)
        return np.concatenate(blocks), np.concatenate(right)

    def _hint(self, solution: Floats, prices: Floats) -> Hint:
        shares = bool(solution[self.d] >= 0)
        masses = solution[self.d + 1 :]
        parts: list[tuple[int, ...]] = []
        weights: list[dict[int, float]] = []
        multipliers: list[dict[int, float]] = []
        for kind, size in self.bodies:
            values, rest = (prices, prices[size:]) if kind == "rows" else (masses, masses[size:])
            values = values[:size]
            prices, masses = (rest, masses) if kind == "rows" else (prices, rest)
            active = np.flatnonzero(values > _ACTIVE * max(float(values.max()), 0.0)).tolist()
            parts.append(tuple(active))
            if kind == "rows":
                multipliers.append({k: float(values[k] / self.sizes[len(multipliers)][k]) for k in active})
            else:
                weights.append({k: float(values[k]) for k in active})
        first, second = multipliers if len(multipliers) == 2 and not shares else ({}, {})
        mixture = weights[0] if len(weights) == 1 else {}
        visited = sum(size for _, size in self.bodies)
        point = solution[: self.d].copy()
        return Hint(shares, parts[0], parts[1], point, mixture, second, first, 1, visited, "linear program")
