"""The double oracle over plain supports: small active sets of both bodies, enlarged until a proof is found.

In: two posed sets of vertices. Out: a verdict that is proved in doubles, or none, with the vertices that decide.

The idea: the actives are pairs of vertices, as differences p - r; the game between the two hulls is won by the
direction of the differences' point nearest to the origin (Wolfe's method; GJK in three dimensions). Each round finds
both bodies' extreme vertices along that direction. Either their gap exceeds its error bound, or the pair joins the
actives, or d + 1 actives certainly enclose the origin, or nothing new is found and integers have to decide. A support
query is a scan of n products.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Floats
from plannercheck.ndim.filters import Posed, encloses_origin, gap_error

# The distance falls every round; near contact rounding makes it stall, and integers are left to decide.
_MOST_ROUNDS = 200
# Relative progress below which a round has found nothing new.
_STALLED = 1e-14
# Vertices by dimension and body about a contact.
_ABOUT_CONTACT = 2
# Weights below this are rounding.
_NO_WEIGHT = 1e-14
# The smallest length of a direction.
_TINY = 1e-300


@dataclass(frozen=True)
class Found:
    """The result of the search in doubles.

    Attributes:
        shares: The verdict, proved; None if it is not.
        active_p: Vertices (or halfspaces) of the first body that decide.
        active_r: The same of the second.
        rounds: Number of rounds of supports.
        visited: Vertices and halfspaces looked at.
    """

    shares: bool | None
    active_p: tuple[int, ...]
    active_r: tuple[int, ...]
    rounds: int
    visited: int


class _Actives:
    """Pairs of vertices, their differences, and the mixture of them nearest to the origin."""

    def __init__(self, first: tuple[int, int], difference: Floats) -> None:
        self.pairs = [first]
        self.differences = difference[None]
        self.weights = np.ones(1)

    @property
    def nearest(self) -> Floats:
        return np.asarray(self.weights @ self.differences)

    def add(self, pair: tuple[int, int], difference: Floats) -> None:
        self.pairs.append(pair)
        self.differences = np.vstack([self.differences, difference])
        self.weights = np.append(self.weights, 0.0)
        while not self._settle():
            pass

    def _settle(self) -> bool:
        """One minor cycle: to the flat's nearest point, or as far as the weights stay positive."""
        goal = _affine_weights(self.differences)
        falling = goal <= _NO_WEIGHT
        if not falling.any():
            self.weights = goal
            return True
        steps = self.weights[falling] / np.maximum(self.weights[falling] - goal[falling], np.finfo(float).tiny)
        step = min(1.0, float(steps.min()))
        self.weights = (1 - step) * self.weights + step * goal
        kept = self.weights > _NO_WEIGHT
        if kept.all():
            kept[np.argmin(self.weights)] = False
        self._keep(kept)
        return len(self.weights) == 1

    def _keep(self, kept: NDArray[np.bool_]) -> None:
        if not kept.any():
            kept[-1] = True
        self.pairs = [pair for pair, keep in zip(self.pairs, kept.tolist(), strict=True) if keep]
        self.differences = self.differences[kept]
        weights = np.maximum(self.weights[kept], 0.0)
        total = float(weights.sum())
        self.weights = weights / total if total > 0 else np.full(len(weights), 1.0 / len(weights))


def _affine_weights(points: Floats) -> Floats:
    """Weights of sum 1 that mix the point of the points' flat nearest to the origin."""
    if len(points) == 1:
        return np.ones(1)
    edges = (points[1:] - points[0]).T
    rest = np.linalg.lstsq(edges, -points[0], rcond=None)[0]
    return np.append(1.0 - rest.sum(), rest)


def nearest(p: Posed, r: Posed, starts: Sequence[Floats]) -> Found:
    """Looks for a proof that two bodies are apart or share a point.

    `starts` are directions from the second to the first to try first, at least one (d,).
    """
    search = _Search(p, r)
    return search.run(starts)


class _Search:
    def __init__(self, p: Posed, r: Posed) -> None:
        self.p, self.r = p, r
        self.rounds = 0
        self.direction = np.zeros(0)
        self.rounding = p.rounding + r.rounding

    def run(self, starts: Sequence[Floats]) -> Found:
        pair, difference, separates = self._support(starts[0])
        actives = _Actives(pair, difference)
        for direction in starts[1:]:
            if separates or len(actives.pairs) > len(direction):
                break
            pair, difference, separates = self._support(direction)
            if pair not in actives.pairs:
                actives.add(pair, difference)
        while not separates and self.rounds < _MOST_ROUNDS:
            point = actives.nearest
            square = float(point @ point)
            if len(actives.pairs) > len(point):
                if encloses_origin(actives.differences, self.rounding):
                    return self._found(True, actives)
                return self._found(None, actives)
            # Below its rounding the nearest point has no direction, and no gap can be proved.
            if math.sqrt(square) <= gap_error(point / max(math.sqrt(square), _TINY), self.p, self.r):
                return self._found(None, actives)
            pair, difference, separates = self._support(point)
            if separates or pair in actives.pairs or point @ difference >= square * (1 - _STALLED):
                return self._found(False if separates else None, actives, pair)
            actives.add(pair, difference)
        return self._found(False if separates else None, actives)

    def _support(self, direction: Floats) -> tuple[tuple[int, int], Floats, bool]:
        size = float(np.abs(direction).max())
        direction = direction / size if size > 0 else np.eye(len(direction))[0]
        self.direction = direction
        self.rounds += 1
        low, low_height = self.p.lowest(direction)
        high, minus_height = self.r.lowest(-direction)
        separates = low_height + minus_height > gap_error(direction, self.p, self.r)
        return (low, high), self.p.point(low) - self.r.point(high), separates

    def _found(self, shares: bool | None, actives: _Actives, extra: tuple[int, int] | None = None) -> Found:
        pairs = actives.pairs + ([extra] if extra else [])
        first, second = [a for a, _ in pairs], [b for _, b in pairs]
        if shares is None:
            # Integers play fewer games if they start with what is about the contact.
            few = _ABOUT_CONTACT * len(self.direction)
            first += self.p.lowest_few(self.direction, few)
            second += self.r.lowest_few(-self.direction, few)
        visited = self.rounds * (len(self.p.vertices) + len(self.r.vertices))
        return Found(shares, tuple(dict.fromkeys(first)), tuple(dict.fromkeys(second)), self.rounds, visited)
