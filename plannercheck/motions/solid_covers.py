"""Entries of proofs where bodies are solids: planes between parts of their surfaces, over intervals of a motion.

In: a verifier of entries, a pair, poses on the motion. Out: entries that together cover the motion and all pairs of
triangles. Parts are ranges of triangles, which lie close together (`proof_model.spatial_order`). Where the hulls of two
parts are apart in the middle of an interval, the direction of their distance is tried; the verifier decides whether it
holds. Else the interval is halved, or, if the parts come too near to each other on it, the larger part.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from plannercheck.bodies.distance import distance
from plannercheck.bodies.polytope import Polytope
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct
from plannercheck.proofs.data import WORLD, Entry, Model
from plannercheck.proofs.parts import part_count, parts_of

if TYPE_CHECKING:
    from plannercheck.proofs.entries import EntryChecker

# An interval is halved at most this often.
_DEEPEST = 24
# Halvings that the verifier may need within an entry.
_WITHIN = 2
# More cells than this are not looked at: the pair then counts as lost.
_MOST_CELLS = 20_000
# Parts are cut if they come nearer than so many times what they have to keep.
_ROOM = 2.0


class Poses(NamedTuple):
    """World poses at a parameter: of the model's bodies (n, 4, 4), and of links (k, 4, 4), m."""

    bodies: Floats
    links: Floats


class PosedMotion(Protocol):
    """A motion whose poses are asked for at parameters."""

    def at(self, t: float) -> Poses:
        """The poses at a parameter."""


class Cell(NamedTuple):
    """An interval, halved so often, and ranges of triangles of both bodies; (0, 1) of a convex one."""

    start: float
    end: float
    depth: int
    first: tuple[int, int]
    second: tuple[int, int]


class PartHulls:
    """Hulls of parts of a model's bodies, each made when it is first asked for."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self._known: dict[tuple[int, int, int], Polytope] = {}

    def hull(self, body: int, part: tuple[int, int]) -> Polytope:
        """The hull of a range of triangles, or a box around parts and their radii; of a convex body all of it."""
        key = (body, *part)
        if key not in self._known:
            own = self.model.bodies[body]
            if own.parts:
                some = parts_of(own).taken(slice(*part))
                self._known[key] = Polytope(some.box, inflation_radius=float(some.radii.max(initial=0.0)))
            else:
                self._known[key] = Polytope(self._corners(body, part))
        return self._known[key]

    def count(self, body: int) -> int:
        """How many triangles or parts a body has; 1 for a convex one."""
        own = self.model.bodies[body]
        return max(1, part_count(own) if own.parts else len(own.triangles))

    def size(self, body: int, part: tuple[int, int]) -> float:
        """The extent of a part, m; 0 for one that can't be cut."""
        return 0.0 if part[1] - part[0] < 2 else float(np.ptp(self.hull(body, part).vertices, axis=0).max())

    def _corners(self, body: int, part: tuple[int, int]) -> Floats:
        own = self.model.bodies[body]
        return own.vertices[distinct(own.triangles[slice(*part)])] if own.triangles else own.vertices


class SolidCover:
    """The entries of one pair.

    Attributes:
        lost: Whether some part is not proved apart from another one; then entries are not all.
    """

    def __init__(self, checker: EntryChecker, parts: PartHulls, pair: int, poses: PosedMotion, needed: float) -> None:
        """Takes the pair; `needed` is the distance that the bodies have to keep, m."""
        self._checker, self._parts, self._pair, self._poses, self._needed = checker, parts, pair, poses, needed
        self._rows = parts.model.pairs[pair]
        self._bodies = [parts.model.bodies[k] for k in self._rows]
        self._counts = [parts.count(k) for k in self._rows]
        self._frame = checker.frame_of(pair)
        self.lost = False

    def entries(self) -> list[Entry]:
        """What keeps the pair apart all along."""
        balls = Entry(self._pair, 0.0, 1.0, "balls")
        if self._checker.holds(balls, _WITHIN):
            return [balls]
        found, cells = list[Entry](), [Cell(0.0, 1.0, 0, (0, self._counts[0]), (0, self._counts[1]))]
        looked_at = 0
        while cells and not self.lost:
            cell = cells.pop()
            looked_at += 1
            entry = self._apart(cell)
            if entry is not None:
                found.append(entry)
                continue
            halves = self._halves(cell) if looked_at < _MOST_CELLS else []
            self.lost = not halves
            cells += halves[::-1]
        return found

    def _apart(self, cell: Cell) -> Entry | None:
        """An entry that holds; None if none is found."""
        apart, direction, links = self._distance(cell, (cell.start + cell.end) / 2)
        if apart <= self._needed:
            return None
        parts = [
            () if part == (0, count) else part
            for part, count in zip((cell.first, cell.second), self._counts, strict=True)
        ]
        for frame in dict.fromkeys((self._frame, self._bodies[0].link, self._bodies[1].link)):
            seen = direction if frame == WORLD else links[frame][:3, :3].T @ direction
            entry = Entry(self._pair, cell.start, cell.end, "plane", frame, tuple(seen.tolist()), *parts)
            if self._checker.holds(entry, _WITHIN):
                return entry
        return None

    def _halves(self, cell: Cell) -> list[Cell]:
        """Both halves of a cell; none if it can't be cut."""
        near = min(self._distance(cell, t)[0] for t in (cell.start, (cell.start + cell.end) / 2, cell.end))
        sizes = [self._parts.size(*part) for part in zip(self._rows, (cell.first, cell.second), strict=True)]
        if max(sizes) > 0 and (near <= _ROOM * self._needed or cell.depth >= _DEEPEST):
            if sizes[0] >= sizes[1]:
                return [cell._replace(first=half) for half in halved(cell.first)]
            return [cell._replace(second=half) for half in halved(cell.second)]
        if near <= self._needed or cell.depth >= _DEEPEST:
            return []
        middle = (cell.start + cell.end) / 2
        return [
            cell._replace(end=middle, depth=cell.depth + 1),
            cell._replace(start=middle, depth=cell.depth + 1),
        ]

    def _distance(self, cell: Cell, t: float) -> tuple[float, Floats, Floats]:
        """How far the hulls of both parts are apart at a parameter, the direction, and the poses of links."""
        bodies, links = self._poses.at(t)
        a, b = self._rows
        found = distance(self._parts.hull(a, cell.first), self._parts.hull(b, cell.second), bodies[a], bodies[b])
        return found.lower_bound, found.direction, links


def halved(part: tuple[int, int]) -> Sequence[tuple[int, int]]:
    """Both halves of a range."""
    middle = (part[0] + part[1]) // 2
    return (part[0], middle), (middle, part[1])
