"""Entries of proofs where a body is a set of parts: a few directions for each interval, along which parts are apart.

In: a verifier of entries, a pair, poses on the motion. Out: entries that together cover the motion, all parts, and all
triangles of the other body. Directions are fixed in the frame of the set. First come those of a fixed few that keep
most parts away at once, then that of the distance of the nearest part that is left, which keeps its neighbours away as
well. The verifier decides which parts they keep away. If the nearest part is not among them, the interval is halved, or
if that part comes too near to the hull of a solid or of another set, that body's range is.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plannercheck.bodies.circumscribed import BOX_SIGNS
from plannercheck.bodies.distance import distance
from plannercheck.bodies.polytope import Polytope
from plannercheck.common.array_types import Bools, Floats, Ints64
from plannercheck.motions.solid_covers import PartHulls, PosedMotion, halved
from plannercheck.proofs.data import WORLD, Entry, PosedBody
from plannercheck.proofs.parts import parts_of

if TYPE_CHECKING:
    from plannercheck.proofs.entries import EntryChecker

# An interval is halved at most this often.
_DEEPEST = 20
# Halvings that the verifier may need within an entry by balls.
_WITHIN = 2
# More cells than this are not looked at: the pair then counts as lost.
_MOST_CELLS = 20_000
# The directions that are tried first: to the faces, edges and corners of a cube.
_FIXED = np.array([d for d in itertools.product([-1.0, 0.0, 1.0], repeat=3) if any(d)])


class _Cell(NamedTuple):
    """An interval, halved so often, and a range of the other body's triangles or parts; (0, 1) of a convex one."""

    start: float
    end: float
    depth: int
    other: tuple[int, int]


class _View(NamedTuple):
    """A cell as it is seen from the set's frame.

    Attributes:
        turn: (3, 3) from the set's body to the frame.
        shift: (3,) m.
        swept: (k, 3) vertices of the other body at the start, in the middle and at the end, m.
        axes: (3, 3) rows: the other body's own axes in the middle.
        bodies: Poses of bodies in the middle.
    """

    turn: Floats
    shift: Floats
    swept: Floats
    axes: Floats
    bodies: Floats


class PartCover:
    """The entries of one pair of which one body is a set of parts.

    Attributes:
        lost: Whether some part is not proved apart; then entries are not all.
    """

    def __init__(self, checker: EntryChecker, hulls: PartHulls, pair: int, poses: PosedMotion, needed: float) -> None:
        """Takes the pair; `needed` is the distance that the bodies have to keep, m, radii of balls left out."""
        self._checker, self._hulls, self._pair, self._poses, self._needed = checker, hulls, pair, poses, needed
        first, second = hulls.model.pairs[pair]
        self._is_first = bool(hulls.model.bodies[first].parts)
        self._set, self._other = (first, second) if self._is_first else (second, first)
        self._frame = hulls.model.bodies[self._set].link
        self._parts = parts_of(hulls.model.bodies[self._set])
        self._whole = 0, hulls.count(self._other)
        self.lost = False

    def entries(self) -> list[Entry]:
        """What keeps the pair apart all along."""
        found, cells = list[Entry](), [_Cell(0.0, 1.0, 0, self._whole)]
        looked_at = 0
        while cells and not self.lost:
            cell = cells.pop()
            looked_at += 1
            entry, halves = self._apart(cell)
            if entry is not None:
                found.append(entry)
                continue
            self.lost = not halves or looked_at >= _MOST_CELLS
            cells += halves[::-1]
        return found

    def _apart(self, cell: _Cell) -> tuple[Entry | None, list[_Cell]]:
        """An entry that holds, or what else to look at."""
        balls = Entry(self._pair, cell.start, cell.end, "balls")
        if cell.other == self._whole and self._checker.holds(balls, _WITHIN):
            return balls, []
        if not len(self._parts):
            return self._entry(cell, _FIXED[:1]), []
        view = self._view(cell)
        left, near, chosen = self._along_fixed(cell, view)
        while len(left):
            nearest = left[near[left].argmin()]
            apart, direction = self._of_part(cell, view, int(nearest))
            if apart <= self._needed:
                return None, self._smaller(cell)
            kept = self._kept(cell, direction, left)
            if not kept[left == nearest].all():
                return None, self._shorter(cell)
            chosen.append(direction)
            left = left[~kept]
        entry = self._entry(cell, np.array(chosen))
        return (entry, []) if self._checker.holds(entry, _WITHIN) else (None, self._shorter(cell))

    def _shorter(self, cell: _Cell) -> list[_Cell]:
        middle = (cell.start + cell.end) / 2
        if cell.depth >= _DEEPEST:
            return self._smaller(cell)
        return [cell._replace(end=middle, depth=cell.depth + 1), cell._replace(start=middle, depth=cell.depth + 1)]

    def _smaller(self, cell: _Cell) -> list[_Cell]:
        return [cell._replace(other=half) for half in halved(cell.other)] if cell.other[1] - cell.other[0] > 1 else []

    def _entry(self, cell: _Cell, directions: Floats) -> Entry:
        signed = directions if self._is_first else -directions
        ranges = (), () if cell.other == self._whole else cell.other
        first, second = ranges if self._is_first else ranges[::-1]
        numbers = tuple(signed.ravel().tolist())
        return Entry(self._pair, cell.start, cell.end, "plane", self._frame, numbers, first, second)

    def _kept(self, cell: _Cell, direction: Floats, rows: Ints64) -> Bools:
        """(n,) which of these parts a direction keeps apart, as the verifier has it."""
        return self._checker.parts_apart(self._entry(cell, direction[None]), rows)

    def _view(self, cell: _Cell) -> _View:
        hull = self._hulls.hull(self._other, cell.other)
        swept, axes = [], np.eye(3)
        for t in (cell.start, cell.end, (cell.start + cell.end) / 2):
            bodies, links = self._poses.at(t)
            link = np.eye(4) if self._frame == WORLD else links[self._frame]
            seen = np.linalg.inv(link) @ bodies[self._other]
            swept.append(hull.vertices @ seen[:3, :3].T + seen[:3, 3])
            axes = seen[:3, :3].T
        pose = np.reshape(self._hulls.model.bodies[self._set].pose, (3, 4))
        return _View(pose[:, :3], pose[:, 3], np.concatenate(swept), axes, bodies)

    def _along_fixed(self, cell: _Cell, view: _View) -> tuple[Ints64, Floats, list[Floats]]:
        """Rows of parts that fixed directions leave, how far each is along the best one, m, and those that count."""
        directions = np.concatenate([view.axes, -view.axes, _FIXED])
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        own = self._hulls.hull(self._other, cell.other).inflation_radius
        highs = (directions @ view.swept.T).max(axis=1) + own
        gaps = (
            np.array(
                [
                    self._parts.least(d @ view.turn) + (d @ view.shift - high - self._needed)
                    for d, high in zip(directions, highs, strict=True)
                ]
            )
            - self._parts.radii
        )
        near, chosen, left, wins = gaps.max(axis=0), list[Floats](), np.arange(len(self._parts)), gaps > 0
        while len(left):
            counts = np.count_nonzero(wins, axis=1)
            best = int(counts.argmax())
            if not counts[best]:
                break
            kept = self._kept(cell, directions[best], left)
            wins[best] = False
            if kept.any():
                chosen.append(directions[best])
                left, wins = left[~kept], wins[:, ~kept]
        return left, near, chosen

    def _of_part(self, cell: _Cell, view: _View, row: int) -> tuple[float, Floats]:
        """How far a part is from the other body in the middle, m, and the direction to it, in the set's frame."""
        part = Polytope(_corners(self._parts.vertices[row], self._hulls.model.bodies[self._set]))
        other = self._hulls.hull(self._other, cell.other)
        found = distance(part, other, view.bodies[self._set], view.bodies[self._other])
        placed = np.reshape(self._hulls.model.bodies[self._set].pose, (3, 4))[:, :3]
        turn = placed @ view.bodies[self._set][:3, :3].T  # from the world to the frame
        return found.lower_bound - float(self._parts.radii[row]), turn @ found.direction


def _corners(vertices: Floats, body: PosedBody) -> Floats:
    """The corners of a part, m."""
    if body.parts == "boxes":
        low, high = vertices
        return np.unique(np.where(BOX_SIGNS > 0, high, low), axis=0)
    if body.parts == "prisms":
        return np.unique(np.concatenate([vertices, vertices * [1, 1, 0] + [0, 0, body.base]]), axis=0)
    return vertices
