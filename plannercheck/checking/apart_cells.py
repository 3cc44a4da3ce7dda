"""Proves for which values of one or two joints a pair of the robot's bodies is apart, for any values of the others.

In: chains of joints, pairs of bodies on links, prepared bodies, their poses in sampled states. Out: `PairsInCells`, for
pairs that such proofs settle often: cells of two columns of the configuration, and a bit for each pair that may meet
there. A state then needs one look-up instead of tests of the bounds and boxes of all these pairs.

The idea. If all joints between two bodies are driven by at most two columns, these alone set the relative pose. In the
middle of a cell the core computes a lower bound of the distance. Within the cell, each joint that a column drives, on
the way to either body, moves no point by more than its lever arm times half the cell's width (reach_bounds.py). So a
distance that exceeds the sum of these motions, and the margin of unreachable_pairs.py, proves the whole cell. Cells
that are not proved are cut into four, down to the finest. Both bodies have to move: one at rest is an obstacle in the
core.

The core finds a cell by (value - low) * cells / span in doubles, and middles are computed by low + width * number. Both
err by less than 1e-9 of the span, since spans are more than 1e-6 of their limits (`Chains`). So a point's motion within
a cell errs by less than 1e-6 of itself, and the margin allows 1e-5. Like all proofs of reach, these hold within the
joint limits only.
"""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.polytope import Polytope
from plannercheck.checking.reach_bounds import Chains, Cut
from plannercheck.checking.unreachable_pairs import MARGIN, RELATIVE
from plannercheck.common.array_types import Bools, Floats, Ints, Ints64
from plannercheck.common.cache import cache_folder, read_cached, write_to_cache
from plannercheck.common.core import core

# Pairs that share cells: each has a bit of a byte.
_MOST_PAIRS = 8

# Cells along each column, from coarse to fine, by the number of columns.
_CELLS = {1: (16, 64, 256), 2: (8, 16, 32, 64)}

# Cells are used where, in all, they settle half a pair a state that balls do not, or in a block of as many (measured).
_WORTH, _BLOCK = 0.5, 8

# Steps after which a distance has to exceed what it is compared with: 64 prove no cell more, 8 fewer (measured).
_ROUNDS = 16

_FORMAT = b"apart cells 1"


class CellFlags(NamedTuple):
    """Cells of two columns, as the core takes them.

    Attributes:
        columns: Both columns.
        lows: Where the cells of each begin, rad or m.
        per_unit: How many cells there are a unit of each.
        may_meet: (cells of the first, of the second) a bit for each pair that may meet there.
    """

    columns: list[int]
    lows: list[float]
    per_unit: list[float]
    may_meet: NDArray[np.uint8]


class PairsInCells(NamedTuple):
    """Up to eight pairs with the same cells.

    Attributes:
        cells: The core's ApartCells.
        pairs: (8,) indices of pairs, by bit; -1 for none.
        made_of: What the core made the cells of.
    """

    cells: Any
    pairs: Ints
    made_of: CellFlags

    def of(self, rows: Ints64) -> PairsInCells:
        """The same with indices into a list of which these pairs are the given rows (k,)."""
        return self._replace(pairs=np.where(self.pairs < 0, -1, rows[self.pairs]).astype(np.int32))


def pairs_in_cells(
    chains: Chains, pairs: Ints, polytopes: Callable[[int], Polytope], sampled: Callable[[], Floats]
) -> tuple[PairsInCells, ...]:
    """The cells of those pairs for which they pay.

    Args:
        chains: The robot's chains, whose margins cover all rounding.
        pairs: (k, 2) indices of bodies on links that may meet.
        polytopes: A function that gives a prepared body.
        sampled: A function that gives the bodies' poses (n, bodies, 4, 4) in sampled states, m.

    Returns:
        Tables with indices into the pairs; each pair is in one of them at most.
    """
    by_cut: dict[Cut, list[int]] = {}
    for k, (a, b) in enumerate(pairs.tolist()):
        if (cut := chains.whole_cut(a, b)) is not None:
            by_cut.setdefault(cut, []).append(k)
    if not by_cut:
        return ()
    near = _near(chains, sampled(), pairs)
    found: list[PairsInCells] = []
    for cut, rows in by_cut.items():
        rows = [k for k in rows if all(polytopes(body).traits.has_hull for body in pairs[k].tolist())]
        if _in_a_block(near[rows]).sum() < _WORTH:
            continue
        apart = _apart(chains, cut, [(int(a), int(b)) for a, b in pairs[rows]], polytopes)
        left = 1 - apart.reshape(len(rows), -1).mean(axis=1)
        settled = np.maximum(near[rows] - left, _in_a_block(near[rows]) - _in_a_block(left))
        for chosen in _chunks(np.flatnonzero(settled > 0)):
            if settled[chosen].sum() >= _WORTH:
                found.append(_in_cells(chains, cut, np.array(rows)[chosen], apart[chosen]))
    return tuple(found)


def _chunks(rows: Ints64) -> list[Ints64]:
    return [rows[k : k + _MOST_PAIRS] for k in range(0, len(rows), _MOST_PAIRS)]


def _in_a_block(part: Floats) -> Floats:
    """The part of the blocks of states in which an event of a part of the states occurs."""
    return np.asarray(1 - (1 - part) ** _BLOCK)


def _near(chains: Chains, poses: Floats, pairs: Ints) -> Floats:
    """(k,) the part of the sampled states in which the balls around a pair meet."""
    centre, radius = chains.boxes.centre, chains.boxes.radius + chains.boxes.inflation_radius
    own = poses[:, : chains.count]
    at = np.einsum("nbij,bj->nbi", own[..., :3, :3], centre[: chains.count]) + own[..., :3, 3]
    away = np.linalg.norm(at[:, pairs[:, 0]] - at[:, pairs[:, 1]], axis=-1)
    return np.asarray((away <= radius[pairs[:, 0]] + radius[pairs[:, 1]]).mean(axis=0))


def _in_cells(chains: Chains, cut: Cut, rows: Ints64, apart: Bools) -> PairsInCells:
    """The core's table of up to eight pairs (k,) with proved cells (k, cells…)."""
    flags = (~apart).reshape(len(rows), apart.shape[1], -1).astype(np.uint8)
    may_meet = np.bitwise_or.reduce(flags << np.arange(len(rows), dtype=np.uint8)[:, None, None], axis=0)
    low, high = (limit[list(cut)] for limit in (chains.robot.lower, chains.robot.upper))
    columns, lows, per_unit = list(cut), low.tolist(), (np.array(apart.shape[1:]) / (high - low)).tolist()
    if len(cut) == 1:  # a second number, all of whose values are in one cell
        columns, lows, per_unit = [*columns, *columns], [*lows, *lows], [*per_unit, 0.0]
    numbers = np.full(_MOST_PAIRS, -1, dtype=np.int32)
    numbers[: len(rows)] = rows
    made_of = CellFlags(columns, lows, per_unit, np.ascontiguousarray(may_meet))
    return PairsInCells(core.apart_cells(*made_of), numbers, made_of)


def _apart(chains: Chains, cut: Cut, pairs: Sequence[tuple[int, int]], polytopes: Callable[[int], Polytope]) -> Bools:
    """(pairs, cells…) the cells in which each pair is apart, from the disk cache if it has them."""
    counts = _CELLS[len(cut)]
    shape = len(pairs), *(counts[-1],) * len(cut)
    path = _cache_file(chains, cut, pairs, polytopes)
    data = read_cached(path) if path is not None else None
    if data is not None and len(data) == (int(np.prod(shape)) + 7) // 8:
        bits = np.unpackbits(np.frombuffer(data, dtype=np.uint8), count=int(np.prod(shape)))
        return bits.reshape(shape).astype(bool)
    apart = np.array([apart_in_cells(chains, cut, pair, polytopes) for pair in pairs])
    if path is not None:
        write_to_cache(path, np.packbits(apart).tobytes())
    return apart


def _cache_file(
    chains: Chains, cut: Cut, pairs: Sequence[tuple[int, int]], polytopes: Callable[[int], Polytope]
) -> Any:
    """Where these cells are cached: by all that they depend on."""
    folder = cache_folder()
    if folder is None:
        return None
    key = hashlib.sha256(_FORMAT + repr((cut, _CELLS, MARGIN, RELATIVE)).encode())
    chains.add_to(key)
    for pair in pairs:
        key.update(repr(pair).encode())
        for body in map(polytopes, pair):
            key.update(repr((body.inflation_radius, body.vertices.shape)).encode())
            key.update(np.ascontiguousarray(body.vertices).tobytes())
    return folder / f"{key.hexdigest()}.cells"


def apart_in_cells(chains: Chains, cut: Cut, pair: tuple[int, int], polytopes: Callable[[int], Polytope]) -> Bools:
    """The cells, (cells along each column of the cut…), in which two bodies on links are apart.

    The cut has the columns on which the pair's relative pose depends; `polytopes` gives a prepared body.
    """
    counts = _CELLS[len(cut)]
    relative = _RelativePoses(chains, cut, pair)
    bodies = [polytopes(body).core for body in pair]
    apart = np.zeros((counts[-1],) * len(cut), dtype=bool)
    left, before = np.zeros((1, len(cut)), dtype=np.int64), 1
    for count in counts:
        left, before = _cut_up(left, count // before), count
        poses, room = relative.in_cells(left, count)
        proved = core.distance_bounds(bodies[0], poses[0], bodies[1], poses[1], _ROUNDS) > room
        _mark(apart, left[proved], counts[-1] // count)
        left = left[~proved]
    return apart


class _RelativePoses:
    """Poses of two bodies in the middles of cells, and the distance that keeps them apart in a whole cell."""

    def __init__(self, chains: Chains, cut: Cut, pair: tuple[int, int]) -> None:
        self._chains, self._cut = chains, list(cut)
        branches = chains.branches(*pair)
        self._ends = [chains.end(body, branch, cut) for body, branch in zip(pair, branches, strict=True)]
        self._around = chains.neighbourhood({end.frame for end in self._ends})
        self._low, self._high = (limit[self._cut] for limit in (chains.robot.lower, chains.robot.upper))
        self._levers = np.array([[end.ball_levers[column] for column in cut] for end in self._ends])

    def in_cells(self, cells: Ints64, count: int) -> tuple[list[Floats], Floats]:
        """Both bodies' poses (n, 4, 4), and the distance (n,) m, in cells (n, columns) of `count` along each column."""
        half = (self._high - self._low) / (2 * count)
        q = np.tile(np.array(self._chains.robot.reference), (len(cells), 1))
        q[:, self._cut] = self._low + half * (2 * cells + 1)
        all_poses = self._around.poses(q)
        poses = [np.ascontiguousarray(all_poses[:, self._around.place[end.frame]]) for end in self._ends]
        sway = self._levers @ half
        extent = sway.sum() + sum(
            np.linalg.norm(at[:, :3, :3] @ end.centre + at[:, :3, 3], axis=1)
            + np.linalg.norm(end.centre)  # a body may be far from its own frame, whose rotation may be off rigid
            + end.radius
            for at, end in zip(poses, self._ends, strict=True)
        )
        return poses, sway.sum() + MARGIN + RELATIVE * extent


def _mark(apart: Bools, cells: Ints64, finer: int) -> None:
    """Marks all finest cells within cells (n, columns) that are so many times as wide."""
    coarse = np.zeros([count // finer for count in apart.shape], dtype=bool)
    coarse[tuple(cells.T)] = True
    for axis in range(apart.ndim):
        coarse = coarse.repeat(finer, axis)
    apart |= coarse


def _cut_up(cells: Ints64, parts: int) -> Ints64:
    """The cells (n, columns) cut into this many parts along each column."""
    steps = np.array(list(itertools.product(range(parts), repeat=cells.shape[1])), dtype=np.int64)
    return np.asarray((parts * cells[:, None] + steps).reshape(-1, cells.shape[1]))
