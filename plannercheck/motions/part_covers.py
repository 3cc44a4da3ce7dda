"""Entries of proofs where a body is a set of parts: a few directions for each interval, along which parts are apart.

In: a verifier of entries, a pair, poses on the motion. Out: entries that together cover the motion, all parts, and all
triangles of the other body. Directions are fixed in the frame of the set, or of a link from which a tube displaces the
bodies less. A few fixed directions that keep most parts away come first. Then the distance to the nearest remaining
part gives a direction, which keeps its neighbours away as well. The verifier decides which parts a direction keeps
away. If the nearest part is not among them, the interval is halved; if that part comes too near to the hull of a solid
or of another set, that body's range is halved instead.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plannercheck.bodies.circumscribed import BOX_SIGNS
from plannercheck.bodies.distance import distance
from plannercheck.bodies.polytope import Polytope
from plannercheck.common.array_types import Bools, Floats, Ints64
from plannercheck.common.arrays import distinct_rows
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
# So many of the parts tell which direction is tried next: as good as all of them, and soon.
_LOOKED_AT = 4096

# The directions that are tried first: to the faces, edges and corners of a cube.
_FIXED = np.array([d for d in itertools.product([-1.0, 0.0, 1.0], repeat=3) if any(d)])


class _Cell(NamedTuple):
    """An interval, halved so often, and a range of the other body's triangles or parts; (0, 1) of a convex one."""

    start: float
    end: float
    depth: int
    other: tuple[int, int]


class _View(NamedTuple):
    """A cell as it is seen from the frame of its directions.

    Attributes:
        turn: (3, 3) from the set's body to the frame, in the middle.
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
        self._frame = checker.frame_of(pair, not self._is_first)
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
        found = self._along_fixed(cell, view)
        if found is None:
            return None, self._shorter(cell)
        left, chosen = found
        while len(left):
            apart, direction = self._of_part(cell, view, int(left[0]))
            if apart <= self._needed:
                return None, self._smaller(cell)
            kept = self._kept(cell, direction, left)
            if not kept[0]:
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
        swept, axes, placed = [], np.eye(3), np.eye(4)
        for t in (cell.start, cell.end, (cell.start + cell.end) / 2):
            bodies, links = self._poses.at(t)
            from_world = np.eye(4) if self._frame == WORLD else np.linalg.inv(links[self._frame])
            seen, placed = from_world @ bodies[self._other], from_world @ bodies[self._set]
            swept.append(hull.vertices @ seen[:3, :3].T + seen[:3, 3])
            axes = seen[:3, :3].T
        return _View(placed[:3, :3], placed[:3, 3], np.concatenate(swept), axes, bodies)

    def _along_fixed(self, cell: _Cell, view: _View) -> tuple[Ints64, list[Floats]] | None:
        """Rows of parts that fixed directions leave, the nearest first as far as these tell, and those that count.

        Which direction is the next one is told by some of the parts that are left. None if it keeps none of them.
        """
        directions = np.concatenate([view.axes, -view.axes, _FIXED])
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        own = self._hulls.hull(self._other, cell.other).inflation_radius
        highs = (directions @ view.swept.T).max(axis=1) + own + self._needed
        chosen, left, untried = list[Floats](), np.arange(len(self._parts)), np.ones(len(directions), dtype=bool)
        while len(left):
            some = left[:: -(-len(left) // _LOOKED_AT)]
            counts = np.count_nonzero(self._gaps(view, directions, highs, some) > 0, axis=1) * untried
            best = int(counts.argmax())
            if not counts[best]:
                break
            untried[best] = False
            kept = self._kept(cell, directions[best], left)
            if not kept.any():  # far too long an interval for what it is like in between
                return None
            chosen.append(directions[best])
            left = left[~kept]
        near = self._gaps(view, directions, highs, left).max(axis=0, initial=-np.inf)
        return left[near.argsort(kind="stable")], chosen

    def _gaps(self, view: _View, directions: Floats, highs: Floats, rows: Ints64) -> Floats:
        """(directions, n) how far some parts are beyond what is in their way, about, m."""
        some = self._parts.taken(rows)
        heights = [some.least(d @ view.turn) + (d @ view.shift - h) for d, h in zip(directions, highs, strict=True)]
        return np.asarray(heights - some.radii)

    def _of_part(self, cell: _Cell, view: _View, row: int) -> tuple[float, Floats]:
        """How far a part is from the other body in the middle, m, and the direction to it, in the frame."""
        part = Polytope(_corners(self._parts.vertices[row], self._hulls.model.bodies[self._set]))
        other = self._hulls.hull(self._other, cell.other)
        found = distance(part, other, view.bodies[self._set], view.bodies[self._other])
        turn = view.turn @ view.bodies[self._set][:3, :3].T  # from the world to the frame
        return found.lower_bound - float(self._parts.radii[row]), turn @ found.direction


def _corners(vertices: Floats, body: PosedBody) -> Floats:
    """The corners of a part, m."""
    if body.parts == "boxes":
        low, high = vertices
        return distinct_rows(np.where(BOX_SIGNS > 0, high, low))[0]
    if body.parts == "prisms":
        return distinct_rows(np.concatenate([vertices, vertices * [1, 1, 0] + [0, 0, body.base]]))[0]
    return vertices
