"""The verifier of proofs about pairs of links: boxes of joint values in place of intervals of time.

In: `PairProofs`. Out: a `Verification` for each pair. A leaf's box is a motion that stands still in its middle, with a
tube of half its sides: so `entries.py` decides about planes, and `overlaps.py` about overlaps. The model is cut down to
the joints between both links, with the lowest joint that carries both as the world: what other joints do can't matter.
Nothing is shared with what found the proofs, but that its builder asks the same checks which candidates hold.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from plannercheck.common.model_comparisons import model_comparison
from plannercheck.common.optional_imports import extra_module
from plannercheck.proofs.data import JOINTS, WORLD, Entry, Hashes, Model, Motion, ProofData, Verification
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.link_pairs import (
    Cell,
    Overlap,
    PairProof,
    PairProofs,
    Plane,
    bodies_of,
    columns_of,
    joints_between,
)

if TYPE_CHECKING:
    from plannercheck.proofs.entries import EntryChecker

# The precision of ball arithmetic, one machine word.
_BITS = 64

# Least and largest number of each column, rad and m.
Box = tuple[Sequence[float], Sequence[float]]


def verify_pairs(proofs: PairProofs) -> tuple[Verification, ...]:
    """Confirms each pair's proof in ball arithmetic.

    Raises:
        PlannercheckError: If python-flint is not installed.
    """
    flint = extra_module("flint", "proofs", "proofs of pairs")
    bits, flint.ctx.prec = flint.ctx.prec, _BITS
    try:
        fault = _fault_of(lambda: check_pairs_well_formed(proofs))
        if fault is not None:
            return tuple(Verification(False, fault, 0, 0.0) for _ in proofs.pairs)
        return tuple(_verified(proofs, pair) for pair in proofs.pairs)
    finally:
        flint.ctx.prec = bits


def pair_model_confirmed(proofs: PairProofs, robot: Any) -> Verification:
    """Whether the model and the limits are those of a robot's files, as of `verify.model_confirmed`."""
    began, compared = time.perf_counter(), tuple[str, ...]()
    try:
        check_pairs_well_formed(proofs)
        compared = model_comparison("pairs")(proofs, robot, None, None, None, None)
    except UnprovedError as found:
        return Verification(False, str(found), 0, time.perf_counter() - began)
    return Verification(True, None, 0, time.perf_counter() - began, compared)


def check_pairs_well_formed(proofs: PairProofs) -> None:
    """Raises an `UnprovedError` for proofs whose model, limits or hashes are wrong."""
    from plannercheck.proofs.numbers_of_proofs import check_length, check_numbers
    from plannercheck.proofs.well_formed import check_well_formed

    for limits, what in ((proofs.lower, "lower limits"), (proofs.upper, "upper limits")):
        check_length(limits, proofs.model.columns, what)
        check_numbers(limits, what)
    if any(low > high for low, high in zip(proofs.lower, proofs.upper, strict=True)):
        raise UnprovedError("a lower limit is above the upper one")
    motion = _standing(proofs.lower)
    check_well_formed(ProofData("space", proofs.robot, "", proofs.hashes, proofs.model, motion, proofs.margin, ()))


def _standing(q: Sequence[float], tube: Sequence[float] = ()) -> Motion:
    numbers = tuple(q)
    return Motion(numbers, numbers, numbers, "screw", (), tuple(tube))


def _verified(proofs: PairProofs, pair: PairProof) -> Verification:
    began, confirmed = time.perf_counter(), 0

    def check() -> None:
        nonlocal confirmed
        for _ in PairChecker(proofs, pair.link_a, pair.link_b).checked(pair):
            confirmed += 1

    fault = _fault_of(check)
    return Verification(fault is None, fault, confirmed, time.perf_counter() - began)


def _fault_of(check: Callable[[], None]) -> str | None:
    """What a check finds."""
    try:
        check()
    except UnprovedError as found:
        return str(found)
    except (ArithmeticError, ValueError) as found:
        return f"numbers can't be computed with: {found}"
    return None


class PairChecker:
    """Confirms cells of one pair of links.

    Attributes:
        columns: Those that move joints between the links.
        pairs: All pairs of their bodies, as indices of the whole model.
        frames: Links that are on joints between them, as indices of the whole model.
    """

    def __init__(self, proofs: PairProofs, link_a: str, link_b: str) -> None:
        """Cuts a well-formed model down to the joints between two links.

        Raises:
            UnprovedError: If they have no bodies, or a joint between them takes several numbers.
        """
        model = proofs.model
        both = [bodies_of(model, link) for link in (link_a, link_b)]
        if link_a == link_b or not all(both):
            raise UnprovedError(f"{link_a!r} and {link_b!r} are not two links with bodies")
        ends = [model.bodies[bodies[0]].link for bodies in both]
        if any(model.bodies[k].link != end for bodies, end in zip(both, ends, strict=True) for k in bodies):
            raise UnprovedError(f"{link_a!r} or {link_b!r} is the name of several links")
        above, joints = joints_between(model, *ends)
        for k in joints:
            if JOINTS[model.joints[k].kind].numbers > 1 and max(model.joints[k].columns) >= 0:
                raise UnprovedError(f"joint {model.joints[k].name!r} between the links takes several numbers")
        self.columns = columns_of(model, joints)
        self.pairs = [(a, b) for a in both[0] for b in both[1]]
        self.frames = [k for k, link in enumerate(model.links) if link.joint in joints or k in ends]
        self._proofs = proofs
        self._body = {k: new for new, k in enumerate((*both[0], *both[1]))}
        self._link = {WORLD: WORLD} | {k: new for new, k in enumerate(self.frames)}
        self._model = self._between(model, {above: WORLD} | {k: new for new, k in enumerate(joints)})

    def _between(self, model: Model, new: dict[int, int]) -> Model:
        """The model of what is between the links."""
        joints = (model.joints[k] for k in new if new[k] != WORLD)
        links = (model.links[k] for k in self.frames)
        return Model(
            tuple(replace(joint, parent=new[joint.parent]) for joint in joints),
            tuple(replace(link, joint=new[link.joint]) for link in links),
            tuple(replace(model.bodies[k], link=self._link[model.bodies[k].link]) for k in self._body),
            tuple((self._body[a], self._body[b]) for a, b in self.pairs),
            (),
            model.columns,
        )

    def checked(self, pair: PairProof) -> Iterator[None]:
        """Confirms a proof, a leaf at a time.

        Raises:
            UnprovedError: At what is not proved.
        """
        if pair.answer == "collides":
            self._check_state(pair)
            yield
            return
        if pair.answer not in ("never", "always"):
            raise UnprovedError(f"the answer {pair.answer!r:.40} is none of never, always, collides")
        waiting: list[Box] = [(self._proofs.lower, self._proofs.upper)]
        for k, cell in enumerate(pair.cells):
            if not waiting:
                raise UnprovedError(f"cell {k} is beyond the tree")
            box = waiting.pop()
            if cell.column == WORLD:
                if not self.holds(cell, box, pair.answer):
                    raise UnprovedError(f"cell {k} does not hold: {self._described(box)}")
                yield
            else:
                waiting += self._halves(k, cell, box)
        if waiting:
            raise UnprovedError(f"the tree ends before its leaves do: {len(waiting)} boxes are not proved")

    def _halves(self, k: int, cell: Cell, box: Box) -> list[Box]:
        """What a cell is cut into, the half below last."""
        low, high = (list(side) for side in box)
        if cell.column not in self.columns or not low[cell.column] <= cell.value <= high[cell.column]:
            raise UnprovedError(f"cell {k} is cut at {cell.value!r} in column {cell.column}, which is not in its box")
        middle_high, middle_low = high.copy(), low.copy()
        middle_high[cell.column] = middle_low[cell.column] = cell.value
        return [(middle_low, high), (low, middle_high)]

    def _check_state(self, pair: PairProof) -> None:
        limits = zip(self._proofs.lower, pair.state, self._proofs.upper, strict=False)
        if len(pair.state) != self._proofs.model.columns or not all(low <= x <= high for low, x, high in limits):
            raise UnprovedError("the state has other columns, or is beyond the limits")
        if len(pair.cells) != 1 or not self.holds(pair.cells[0], (pair.state, pair.state), "collides"):
            raise UnprovedError("the state is not shown to collide")

    def opened(self, box: Box) -> EntryChecker:
        """What decides about planes and overlaps in a box."""
        middle = [(low + high) / 2 for low, high in zip(*box, strict=True)]
        # A difference is rounded by half a unit in its last place.
        tube = [math.nextafter(max(h - m, m - low), math.inf) for low, m, h in zip(box[0], middle, box[1], strict=True)]
        return self._in_any_box.on(_standing(middle, tube))

    @cached_property
    def _in_any_box(self) -> EntryChecker:
        from plannercheck.proofs.entries import EntryChecker

        motion, nothing = _standing(self._proofs.lower), Hashes("", "", "")
        return EntryChecker(ProofData("space", "", "", nothing, self._model, motion, self._proofs.margin, ()))

    def widened(self, own: EntryChecker, pair: int, frame: int) -> float:
        """How far apart a pair's bodies have to be, seen from a link of `frames`, to be apart in all of a box, m."""
        return own.widened(pair, self._link[frame])

    def deep_enough(self, own: EntryChecker, pair: int) -> float:
        """How deep the bodies of a pair have to be in each other in a box's middle to overlap in all of it, m."""
        return own.deep_enough(*self._model.pairs[pair])

    def radii(self, pair: int) -> tuple[float, float]:
        """How far both bodies of a pair reach around their vertices' hulls, m."""
        a, b = self._model.pairs[pair]
        return self._model.bodies[a].radius, self._model.bodies[b].radius

    def holds(self, cell: Cell, box: Box, answer: str) -> bool:
        """Whether a leaf proves its box, for `answer`."""
        own = self.opened(box)
        if answer == "never":
            return {(plane.first, plane.second) for plane in cell.planes} == set(self.pairs) and all(
                self._is_apart(own, plane) for plane in cell.planes
            )
        return len(cell.overlaps) == 1 and self._is_overlap(own, cell.overlaps[0])

    def _is_apart(self, own: EntryChecker, plane: Plane) -> bool:
        if plane.frame not in self._link or len(plane.direction) != 3:
            return False
        pair = self.pairs.index((plane.first, plane.second))
        if any(self._model.bodies[k].parts or self._model.bodies[k].half_space for k in self._model.pairs[pair]):
            return False
        entry = Entry(pair, 0.0, 0.0, "plane", self._link[plane.frame], plane.direction)
        return bool(own.holds(entry, 0))

    def _is_overlap(self, own: EntryChecker, overlap: Overlap) -> bool:
        from plannercheck.proofs.overlaps import is_deeper

        if (overlap.first, overlap.second) not in self.pairs:
            return False
        pair = self.pairs.index((overlap.first, overlap.second))
        a, b = self._model.pairs[pair]
        bodies = [self._model.bodies[k] for k in (a, b)]
        if any(body.triangles or body.parts or body.half_space for body in bodies):
            return False
        sides = [(body.vertices, own.at_start(k)) for body, k in zip(bodies, (a, b), strict=True)]
        return is_deeper(overlap, sides[0], sides[1], self.deep_enough(own, pair), self.radii(pair))

    def _described(self, box: Box) -> str:
        """A box in words: the columns that count."""
        return ", ".join(f"column {k} in [{box[0][k]!r}, {box[1][k]!r}]" for k in self.columns) or "all that there is"
