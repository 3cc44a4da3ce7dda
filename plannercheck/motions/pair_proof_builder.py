"""Builds proofs of what is decided about pairs of links: boxes of joint values with planes, or with deep overlaps.

In: decisions. Out: `PairProofs`, of which the verifier's check (`proofs/pair_checks.py`) took every leaf. Idea: the
search of pair_decisions.py is run again, and a cell is a leaf once the verifier takes planes along the shortest ways in
its middle, or a surface of differences of vertices around 0, or a point of theirs near 0; else it is cut.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property, partial

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import GeometryObject
from plannercheck.common.array_types import Floats, Ints, Ints64
from plannercheck.common.arrays import distinct
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.optional_imports import extra_module
from plannercheck.common.progress import report
from plannercheck.motions.joint_cells import are_free
from plannercheck.motions.pair_decisions import PairDecider, PairDecision
from plannercheck.motions.proof_builder import rounding_margin
from plannercheck.motions.proof_model import space_model
from plannercheck.motions.sampling import MotionSampler
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.link_pairs import Cell, Overlap, PairProof, PairProofs, Plane
from plannercheck.proofs.pair_checks import PairChecker

# Cells that are judged at once, and the most of a proof.
_BATCH, _MOST_CELLS = 512, 1_000_000

# A surface around 0 gets at most so many corners, and is to be this much further away than needed. A triangle that is
# flatter has no plane in ball arithmetic.
_MOST_CORNERS, _ROOM, _FLAT = 150, 1 + 1e-6, 1e-12

# Directions in which the first corners of a surface are sought.
_FIRST = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if x or y or z], dtype=float)


class LinkPairs:
    """The bodies of some pairs of links, as `PosedPairs`.

    Attributes:
        robot: The decider's, whose group has all joints of one value.
        bodies: The robot's.
        pairs: (k, 2) indices of bodies.
        paddings: (bodies,) none, m.
        polytopes: The bodies, prepared.
        motion_sampler: Whose whole turns a motion leaves out.
    """

    def __init__(self, decider: PairDecider, links: Sequence[tuple[str, str]]) -> None:
        """Takes at least one pair of names.

        Raises:
            PlannercheckError: If one of the names is no link with bodies.
        """
        self.robot = decider.robot
        self.bodies: tuple[GeometryObject, ...] = tuple(self.robot.bodies)
        self.pairs: Ints = np.concatenate([decider.pairs(*both) for both in links])
        self.paddings: Floats = np.zeros(len(self.bodies))
        self.polytopes: tuple[Polytope | None, ...] = tuple(decider.polytope(k) for k in range(len(self.bodies)))
        self.motion_sampler = MotionSampler(self.robot)


def pair_proofs(decider: PairDecider, decisions: Sequence[PairDecision], seconds: float) -> PairProofs:
    """Builds the proofs of decisions; of those that are open, and of others for which none is found, there is none.

    Each takes at most so many seconds of processor time.

    Raises:
        PlannercheckError: If python-flint is not installed, or all decisions are open.
    """
    flint = extra_module("flint", "proofs", "proofs of pairs")
    from plannercheck.proofs.well_formed import hashes_of

    known = [each for each in decisions if each.answer != "open"]
    if not known:
        raise PlannercheckError("all pairs are open, so that there is nothing to prove")
    robot, of_links = decider.robot, LinkPairs(decider, [(each.link_a, each.link_b) for each in known])
    model = space_model(of_links)
    margin = rounding_margin(robot, model, decider.lower, decider.upper, np.stack([decider.lower, decider.upper]))
    limits = tuple(decider.lower.tolist()), tuple(decider.upper.tolist())
    empty = PairProofs(robot.name, hashes_of(model), model, *limits, margin, ())
    bits, flint.ctx.prec = flint.ctx.prec, 64
    try:
        found = []
        for k, each in enumerate(known):
            report(k, len(known), "proofs")
            found.append(_PairBuilder(decider, empty, of_links, each).proof(time.process_time() + seconds))
        report(len(known), len(known), "proofs")
    finally:
        flint.ctx.prec = bits
    return replace(empty, pairs=tuple(each for each in found if each is not None))


class _PairBuilder:
    """Builds the proof about one pair."""

    def __init__(self, decider: PairDecider, empty: PairProofs, of_links: LinkPairs, decision: PairDecision) -> None:
        self._decider, self._decision, links = decider, decision, (decision.link_a, decision.link_b)
        self._checker, self._search = PairChecker(empty, *links), decider.search(*links)
        self._used = distinct(of_links.pairs)  # the model's bodies, by index of the robot's
        self._polytopes = of_links.polytopes
        self._limits = np.array(empty.lower), np.array(empty.upper)

    def proof(self, until: float) -> PairProof | None:
        """The proof; None if none is found in time."""
        answer, example, cells = self._decision.answer, self._decision.example, None
        if answer == "collides":
            assert example is not None
            cell = self._overlapping(example, example)
            cells = None if cell is None else [cell]
        else:
            cells = self._tree(self._free if answer == "never" else self._all_overlapping, until)
        if cells is None or answer == "open":
            return None
        state = tuple(example.tolist()) if answer == "collides" and example is not None else ()
        return PairProof(self._decision.link_a, self._decision.link_b, answer, tuple(cells), state)

    def _tree(self, leaves: Callable[[Floats, Floats], list[Cell | None]], until: float) -> list[Cell] | None:
        """The cells in preorder, largest first sought; `leaves` gives those of boxes (n, nq) that are proved."""
        nodes: list[tuple[Cell, int]] = []  # a cell, and where its halves are
        boxes = [self._limits]
        while len(nodes) < len(boxes):
            if time.process_time() > until or len(boxes) > _MOST_CELLS:
                return None
            batch = boxes[len(nodes) : len(nodes) + _BATCH]
            lows, highs = (np.array(side) for side in zip(*batch, strict=True))
            for low, high, leaf in zip(lows, highs, leaves(lows, highs), strict=True):
                if leaf is None and not self._search.columns:
                    return None
                nodes.append((self._cut(low, high) if leaf is None else leaf, len(boxes)))
                if leaf is None:
                    column, value = nodes[-1][0].column, nodes[-1][0].value
                    below, above = high.copy(), low.copy()
                    below[column] = above[column] = value
                    boxes += [(low, below), (above, high)]
        cells, waiting = list[Cell](), [0]
        while waiting:
            cell, halves = nodes[waiting.pop()]
            cells.append(cell)
            waiting += [halves + 1, halves] if not cell.planes and not cell.overlaps else []
        return cells

    def _cut(self, low: Floats, high: Floats) -> Cell:
        """Across the side that moves bodies most."""
        column = int(((high - low) * self._search.levers).argmax())
        return Cell(column, float((low[column] + high[column]) / 2))

    def _free(self, lows: Floats, highs: Floats) -> list[Cell | None]:
        """Leaves with planes, of boxes that the certifier proves free."""
        rows = np.flatnonzero(are_free(self._search.certifier, lows, highs))
        found: list[Cell | None] = [None] * len(lows)
        if len(rows):
            for row, cell in zip(rows.tolist(), self._planes((lows[rows] + highs[rows]) / 2), strict=True):
                if self._checker.holds(cell, (lows[row].tolist(), highs[row].tolist()), "never"):
                    found[row] = cell
        return found

    def _planes(self, middles: Floats) -> list[Cell]:
        """Leaves with planes along the shortest ways at configurations (n, nq)."""
        poses, links = self._search.body_poses(middles), self._decider.robot.link_poses(middles)
        columns = []
        for pair, (first, second) in enumerate(self._checker.pairs):
            *_, along = self._distances(poses, first, second)
            turned = np.einsum("nji,nj->ni", links[:, self._frames[pair], :3, :3], along).tolist()
            columns.append([Plane(first, second, self._frames[pair], tuple(row)) for row in turned])
        return [Cell(planes=planes) for planes in zip(*columns, strict=True)]

    def _distances(self, poses: Floats, first: int, second: int) -> tuple[Floats, ...]:
        """The core's answer about two bodies of the model, at poses (n, bodies, 4, 4)."""
        a, b = (int(self._used[k]) for k in (first, second))
        p, r = self._polytopes[a], self._polytopes[b]
        assert p is not None
        assert r is not None
        of_a, of_b = (np.ascontiguousarray(poses[:, k]) for k in (a, b))
        return tuple(core.distance_batch(p.core, of_a, r.core, of_b))

    @cached_property
    def _frames(self) -> list[int]:
        """For each pair of bodies the link from which a cell's displacements are least."""
        halves = np.where(self._search.levers > 0, 1e-3 / np.maximum(self._search.levers, 1e-3), 0.0)
        middle = (self._limits[0] + self._limits[1]) / 2
        own = self._checker.opened(((middle - halves).tolist(), (middle + halves).tolist()))
        pairs = range(len(self._checker.pairs))
        return [min(self._checker.frames, key=partial(self._checker.widened, own, pair)) for pair in pairs]

    def _all_overlapping(self, lows: Floats, highs: Floats) -> list[Cell | None]:
        """Leaves with an overlap."""
        return [self._overlapping(low, high) for low, high in zip(lows, highs, strict=True)]

    def _overlapping(self, low: Floats, high: Floats) -> Cell | None:
        """A leaf with an overlap of the two bodies that are deepest in each other in the middle; None if it fails."""
        middle, box = (low + high) / 2, (low.tolist(), high.tolist())
        poses, own = self._search.body_poses(middle[None]), self._checker.opened(box)
        deepest, pair = max(
            (-float(self._distances(poses, *bodies)[1][0]), k) for k, bodies in enumerate(self._checker.pairs)
        )
        needed = self._checker.deep_enough(own, pair) * _ROOM
        if not deepest > needed:
            return None
        bodies = self._checker.pairs[pair]
        polytopes = [self._polytopes[int(self._used[k])] for k in bodies]
        sides = [
            each.vertices @ poses[0, self._used[k], :3, :3].T + poses[0, self._used[k], :3, 3]
            for each, k in zip(polytopes, bodies, strict=True)
            if each is not None
        ]
        left = needed - sum(self._checker.radii(pair))
        found = surface_around_0(sides[0], sides[1], left) if left >= 0 else point_near_0(sides[0], sides[1], -left)
        cell = None if found is None else Cell(overlaps=(Overlap(*bodies, *found),))
        try:
            return cell if cell is not None and self._checker.holds(cell, box, "always") else None
        except UnprovedError:
            return None


def surface_around_0(
    first: Floats, second: Floats, needed: float
) -> tuple[tuple[tuple[int, int], ...], tuple[tuple[int, int, int], ...]] | None:
    """A hull of differences of vertices (n, 3) and (m, 3) whose faces have 0 further behind them than needed, m.

    Its corners, as a vertex of each, and its triangles; None if there is none, or it has too many corners.
    """
    known: dict[tuple[int, int], None] = {}
    left_out = set[tuple[int, int]]()

    def add(directions: Floats) -> None:
        known.update(dict.fromkeys(each for each in _corners(first, second, directions) if each not in left_out))

    add(_FIRST)
    while len(known) <= _MOST_CORNERS:
        corners = list(known)
        points = np.array([first[a] - second[b] for a, b in corners])
        try:
            hull = Polytope(points)
        except PlannercheckError:
            return None  # flat
        if not len(hull.faces):
            return None  # flat
        a, b, c = (hull.vertices[hull.faces[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        lengths = np.linalg.norm(normals, axis=1)
        place = {row.tobytes(): k for k, row in enumerate(points)}
        rows = [place[row.tobytes()] for row in hull.vertices]
        sides = np.stack([((c - b) ** 2).sum(axis=1), ((a - c) ** 2).sum(axis=1), ((b - a) ** 2).sum(axis=1)])
        flat = np.flatnonzero(lengths <= _FLAT * sides.max(axis=0))
        if len(flat) and len(hull.vertices) == 4:
            return None
        if len(flat):  # what is on another edge but for rounding is no corner
            middles = {corners[rows[k]] for k in hull.faces[flat, sides[:, flat].argmax(axis=0)].tolist()}
            left_out |= middles
            known = {each: None for each in known if each not in middles}
            continue
        normals /= lengths[:, None]
        behind = (normals * a).sum(axis=1)
        if behind.min() > needed:
            return tuple(corners[k] for k in rows), tuple((int(x), int(y), int(z)) for x, y, z in hull.faces)
        before = len(known)
        add(normals[np.argsort(behind)[:4]])
        if len(known) == before:
            return None
    return None


def point_near_0(
    first: Floats, second: Floats, distance: float
) -> tuple[tuple[tuple[int, int], ...], tuple[()], tuple[float, ...]] | None:
    """A mean of differences of vertices (n, 3) and (m, 3) that is nearer to 0 than a distance, m.

    Its corners, as a vertex of each, no triangles, and weights; None if there is none. The search is Wolfe's: of the
    corners' hull the point next to 0 shows the direction of the next corner.
    """
    corners, weights = _corners(first, second, _FIRST[:1]), np.ones(1)
    nearest = math.inf
    while len(corners) <= _MOST_CORNERS:
        points = np.array([first[a] - second[b] for a, b in corners])
        point = weights @ points
        length = float(np.linalg.norm(point))
        if length * _ROOM < distance:
            kept = weights > 0
            chosen = tuple(each for each, keep in zip(corners, kept.tolist(), strict=True) if keep)
            return chosen, (), tuple(weights[kept].tolist())
        (new,) = _corners(first, second, -point[None])
        if new in corners or length >= nearest:  # rounding took the last corner out again, so it would for ever
            return None
        nearest = length
        corners, weights = [*corners, new], np.append(weights, 0.0)
        points = np.vstack([points, first[new[0]] - second[new[1]]])
        rows, weights = _next_to_0(points, weights)
        corners = [corners[k] for k in rows.tolist()]
    return None


def _next_to_0(points: Floats, weights: Floats) -> tuple[Ints64, Floats]:
    """Which points (n, 3) the point of their hull next to 0 is a mean of, and by which weights."""
    kept: Ints64 = np.arange(len(points))
    while True:
        some = points[kept]
        equations = np.pad(some @ some.T, ((0, 1), (0, 1)), constant_values=1.0)
        equations[-1, -1] = 0.0
        best = np.linalg.lstsq(equations, np.append(np.zeros(len(kept)), 1.0), rcond=None)[0][:-1]
        if (best > 0).all() or len(kept) == 1:
            return kept, best
        falls = best <= 0
        steps = weights[falls] / (weights[falls] - best[falls])
        weights = weights + steps.min() * (best - weights)
        stays = weights > 1e-15
        stays[np.flatnonzero(falls)[steps.argmin()]] = False
        kept, weights = kept[stays], weights[stays]


def _corners(first: Floats, second: Floats, directions: Floats) -> list[tuple[int, int]]:
    """The vertices whose difference is furthest along each direction (n, 3)."""
    both = (first @ directions.T).argmax(axis=0), (second @ directions.T).argmin(axis=0)
    return list(zip(*(rows.tolist() for rows in both), strict=True))
