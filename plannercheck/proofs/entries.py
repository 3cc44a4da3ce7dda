"""Checks entries of a proof in space: heights of bodies along a direction, over an interval of the motion.

In: a well-formed proof, its entries one by one. Out: whether each holds.

Let d be the entry's direction, fixed in a frame, and x -> T(t) x the map of a body into the frame. A vertex v has the
height h_v(t) = d . T(t) v, which is w(t) . v + s(t) with a row (w, s) of which jets give the value at both ends of an
interval and the second derivative all over it. On an interval of length l a height is at least the chord between its
ends less l^2/8 times the largest h_v'' (and at most the chord plus l^2/8 times the largest -h_v''). So over the whole
interval the first body's lowest vertex is above the second's highest one by at least the difference at the worse end,
less both bodies' largest deviations. If that is more than both radii plus the margin, times the direction's length, the
bodies are apart on the interval. Else the interval is halved, up to a largest depth.

A body that is not below the frame in the tree is seen from their lowest common joint: with R and p the rotation and
translation from the frame to that joint, its height is (R d) . (X - p). That is d . T x up to |d| |R^T R - 1| |T x|,
which is subtracted. Lengths in the frame differ from those of the world at most by a factor, `_stretch`.

Balls: the same with centres in place of vertices and the reach added to the radii, in the frame of both bodies' lowest
common joint, along a direction that is chosen here.

Parts of solids: the same with the corners of some of their triangles.

Sets of parts: the same for each part, several directions one after the other. A ball's height is its vertex's less its
radius times the direction's length. A set is bent as the box around it is.

Half-spaces: the same with the direction out of one, along which a point of its plane is its highest.

Tubes: the bodies have to be further apart by how far the tube displaces them, seen from the frame (`tubes.py`).

Vertices are multiplied with w in doubles: a sum of four products errs by at most 4 u of the sum of their sizes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from typing import Any

import numpy as np
from flint import arb_mat

from plannercheck.common.array_types import Bools, Ints64
from plannercheck.common.arrays import distinct
from plannercheck.proofs.chains import Chains, off_rigid
from plannercheck.proofs.covers import is_whole, pairs_in_parts
from plannercheck.proofs.data import WORLD, Entry, Model, Motion, PosedBody, ProofData
from plannercheck.proofs.end_shifts import end_shift
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.half_spaces import plane_of
from plannercheck.proofs.heights import SHIFT, Direction, Seen, direction_on, lowest
from plannercheck.proofs.jets import affine, times, total
from plannercheck.proofs.nesting import check_not_nested
from plannercheck.proofs.parts import largest_radius, parts_of
from plannercheck.proofs.rounding import ROUNDING, UNDERFLOW, UP
from plannercheck.proofs.tubes import Tube

# An interval is halved this often before its entry counts as false.
DEEPEST = 7

# The largest norm of M^T M - 1 of chains: below this 1 / sqrt(1 - defect) < 1 + defect.
_LARGEST_DEFECT = 1e-3


class EntryChecker:
    """Confirms entries of one well-formed proof."""

    def __init__(self, proof: ProofData) -> None:
        """Reads the model.

        Raises:
            UnprovedError: If the motion has no definite short way.
        """
        assert isinstance(proof.model, Model)
        self._model = model = proof.model
        assert isinstance(proof.motion, Motion)
        self._chains, self._least_margin = Chains(model, proof.motion), proof.margin
        self._tube = Tube(model, proof.motion, self._chains)
        self._links = [affine(link.placement) for link in model.links]
        poses = [affine(body.pose) for body in model.bodies]
        off = max((float(off_rigid(pose)) for pose in poses), default=0.0)
        if not self._chains.defect <= _LARGEST_DEFECT:
            raise UnprovedError(f"placements and axes are off rigid by {self._chains.defect:.3g} along a chain")
        self._stretch = (1 + self._chains.defect) * (1 + off) * UP
        self._seen = [
            plane_of(body)[0] if body.half_space else self._posed(body, pose)
            for body, pose in zip(model.bodies, poses, strict=True)
        ]
        self._balls: dict[int, Seen | None] = {}
        self._planes: dict[int, tuple[Seen, Direction]] = {}
        self._parts: dict[tuple[int, ...], Seen] = {}
        self._begin(proof.motion)

    def _begin(self, motion: Motion) -> None:
        shift = end_shift(self._model, motion, self._seen, self._stretch)
        self._margin = (self._least_margin + shift) * UP

    def on(self, motion: Motion) -> EntryChecker:
        """The same model's on another motion; errors as of the constructor."""
        made = copy(self)
        made._chains = self._chains.on(motion)
        made._tube = self._tube.on(motion, made._chains)
        made._begin(motion)
        return made

    def _posed(self, body: PosedBody, pose: Any) -> Seen:
        parts = parts_of(body) if body.parts else None
        points = body.vertices if parts is None else parts.box
        sizes = np.abs(points).max(axis=0)
        if body.link == WORLD:
            return Seen(points, sizes, WORLD, pose, parts=parts)
        return Seen(points, sizes, self._joint(body.link), self._links[body.link] * pose, parts=parts)

    def check(self, index: int, entry: Entry) -> None:
        """Confirms an entry.

        Raises:
            UnprovedError: If it does not prove its pair apart on its interval.
        """
        if not self.holds(entry):
            raise UnprovedError(f"entry {index} does not hold: {self.described(entry)}")

    def holds(self, entry: Entry, deepest: int = DEEPEST) -> bool:
        """Whether an entry holds, with at most `deepest` halvings."""
        a, b = self._model.pairs[entry.pair]
        radii = self._radii(entry)
        if entry.by == "half-space":
            return self._beyond_plane(a, b, radii, (entry.start, entry.end), deepest)
        if entry.by == "plane":
            directions = self._directions(entry)
            parts = self._part(a, entry.first), self._part(b, entry.second)
            return self._all_apart(*parts, directions, radii, (entry.start, entry.end), deepest)
        first, second = self._ball(a), self._ball(b)
        if first is None or second is None:
            return False
        reach = sum(self._model.bodies[k].reach + largest_radius(self._model.bodies[k]) for k in (a, b))
        return self._balls_apart(first, second, radii + reach, (entry.start, entry.end), deepest)

    def widened(self, pair: int, frame: int) -> float:
        """Both radii, and how far the tube displaces both bodies, seen from a link's frame, m."""
        return self._radii(Entry(pair, 0.0, 1.0, "plane", frame))

    def _radii(self, entry: Entry) -> float:
        """Both radii, and how far the tube displaces both bodies, seen from the entry's frame."""
        a, b = self._model.pairs[entry.pair]
        frame = self._joint(entry.frame) if entry.by == "plane" else WORLD
        if entry.by == "balls":
            frame = self._chains.meeting(self._seen[a].joint, self._seen[b].joint)
        radii = self._model.bodies[a].radius + self._model.bodies[b].radius
        return radii + self._tube.widening(frame, a, b)

    def needed(self, pair: int) -> float:
        """How far apart a pair has to be, at least, in the frame of either body, m."""
        return self.widened(pair, self.frame_of(pair)) + self._margin

    def frame_of(self, pair: int, is_second: bool = False) -> int:
        """The link of the first or the second body of a pair; another one if a tube displaces them less, seen from it.

        Others are those of the joints between both bodies.
        """
        own = [self._model.bodies[k].link for k in self._model.pairs[pair]]
        joints = [self._joint(link) for link in own]
        meeting = self._chains.meeting(*joints)
        between = {meeting}
        for joint in joints:
            while joint != meeting:
                between.add(joint)
                joint = self._model.joints[joint].parent
        links = own[::-1] if is_second else own
        links += [k for k, link in enumerate(self._model.links) if link.joint in between - set(joints)]
        return min(links, key=lambda link: self.widened(pair, link))

    def _joint(self, link: int) -> int:
        return WORLD if link == WORLD else self._model.links[link].joint

    def described(self, entry: Entry) -> str:
        """What an entry says, in words."""
        a, b = (self._model.bodies[k] for k in self._model.pairs[entry.pair])
        frame = "the world" if entry.frame == WORLD else self._model.links[entry.frame].name
        by = {"balls": "their balls", "half-space": "the half-space's plane"}.get(
            entry.by, f"a plane along {list(entry.direction)} in {frame}"
        )
        pair = f"{a.name!r} ({a.label!r}) and {b.name!r} ({b.label!r})"
        return f"{pair} are not kept apart on [{entry.start!r}, {entry.end!r}] by {by}"

    def parts_apart(self, entry: Entry, rows: Ints64) -> Bools:
        """(n,) which of some parts of a pair's set an entry's one direction keeps apart, all along its interval."""
        a, b = self._model.pairs[entry.pair]
        radii = self._radii(entry)
        first, second = self._part(a, entry.first), self._part(b, entry.second)
        if first.parts is not None:
            first = first._replace(parts=first.parts.taken(rows))
        else:
            second = second._replace(parts=second.parts.taken(rows))
        (direction,) = self._directions(entry)
        return self._apart_parts(first, second, direction, radii, (entry.start, entry.end))

    def _directions(self, entry: Entry) -> list[Direction]:
        rows = [entry.direction[k : k + 3] for k in range(0, len(entry.direction), 3)]
        return [self._direction(entry.frame, numbers) for numbers in rows]

    def _direction(self, frame: int, numbers: Sequence[float]) -> Direction:
        column = arb_mat(4, 1, [*numbers, 0])
        return direction_on(self._joint(frame), column if frame == WORLD else self._links[frame] * column)

    def check_nesting(self, entries: Sequence[Entry]) -> None:
        """Raises an `UnprovedError` where one body of a pair may be inside the other.

        Where no entry is of both hulls, which are apart then, that is decided at the start.
        """
        apart = {entry.pair for entry in entries if is_whole(entry)}
        for pair in sorted(pairs_in_parts(entries) - apart):
            placed = []
            for k in self._model.pairs[pair]:
                placed += [self._model.bodies[k], self.at_start(k)]
            check_not_nested(*placed)

    def at_start(self, body: int) -> Any:
        """The map of a body into the world at the motion's start, 4 x 4."""
        seen = self._seen[body]
        return self._chains.at(0.0, WORLD, seen.joint) * seen.place

    def deep_enough(self, a: int, b: int) -> float:
        """How deep two bodies have to be in each other at the start, m, to overlap wherever the tube displaces them."""
        frames = (WORLD, *range(len(self._model.joints)))
        shift = min(self._tube.widening(frame, a, b) for frame in frames)
        return (shift + self._margin) * self._stretch * UP

    def _beyond_plane(self, a: int, b: int, radii: float, span: tuple[float, float], deepest: int) -> bool:
        """Whether the body of a pair that is no half-space is beyond the plane of the other one, over a span."""
        body, half_space = (a, b) if self._model.bodies[b].half_space else (b, a)
        if half_space not in self._planes:
            self._planes[half_space] = plane_of(self._model.bodies[half_space])
        point, direction = self._planes[half_space]
        return self._all_apart(self._seen[body], point, [direction], radii, span, deepest)

    def _part(self, body: int, triangles: tuple[int, ...]) -> Seen:
        """The corners of some of a body's triangles, or some of its parts; all vertices for none."""
        seen = self._seen[body]
        if not triangles:
            return seen
        key = (body, *triangles)
        if key not in self._parts and seen.parts is not None:
            some = seen.parts.taken(slice(*triangles))
            self._parts[key] = seen._replace(points=some.box, parts=some)
        if key not in self._parts:
            rows = distinct(self._model.bodies[body].triangles[slice(*triangles)])
            self._parts[key] = seen._replace(points=seen.points[rows])
        return self._parts[key]

    def _ball(self, body: int) -> Seen | None:
        """The centre of a body's ball; None if it does not hold all vertices."""
        if body not in self._balls:
            seen, centre = self._seen[body], np.array(self._model.bodies[body].centre)
            x, y, z = (seen.points - centre).T
            furthest = float(np.hypot(np.hypot(x, y), z).max())  # squares of tiny numbers would vanish
            holds = furthest * UP + UNDERFLOW <= self._model.bodies[body].reach
            on_joint = seen.place * arb_mat(4, 1, [*centre.tolist(), 1])
            ball = Seen(centre[None], np.abs(centre), seen.joint, seen.place, on_joint)
            self._balls[body] = ball if holds else None
        return self._balls[body]

    def _balls_apart(self, a: Seen, b: Seen, radii: float, span: tuple[float, float], deepest: int) -> bool:
        """Whether two balls are, over a span, along a direction that is chosen for each part of it."""
        joint = self._chains.meeting(a.joint, b.joint)
        chosen = [0.0, 0.0, 0.0]
        for t in span:
            way = [x - y for x, y in zip(self._centre(a, joint, t), self._centre(b, joint, t), strict=True)]
            length = math.hypot(*way)
            if not length > radii:
                return False
            chosen = [x + y / length for x, y in zip(chosen, way, strict=True)]
        direction = direction_on(joint, arb_mat(4, 1, [*chosen, 0]))
        if self._apart(a, b, direction, radii, span, 0):
            return True
        middle = (span[0] + span[1]) / 2
        return deepest > 0 and all(
            self._balls_apart(a, b, radii, part, deepest - 1) for part in ((span[0], middle), (middle, span[1]))
        )

    def _centre(self, seen: Seen, joint: int, t: float) -> list[float]:
        """Where a ball's centre is in a joint's frame, in doubles: for choosing alone."""
        column = self._chains.at(t, joint, seen.joint) * seen.centre
        return [float(x) for x in column.entries()[:3]]

    def _all_apart(
        self, a: Seen, b: Seen, directions: Sequence[Direction], radii: float, span: tuple[float, float], deepest: int
    ) -> bool:
        """Whether each part of the set of a pair is beyond the other body along one of the directions, over a span.

        Of two sets that is the first one; of the second one, all parts count together. Without sets there is one
        direction.
        """
        if a.parts is None and b.parts is None:
            return len(directions) == 1 and self._apart(a, b, directions[0], radii, span, deepest)
        if any(seen.parts is not None and not len(seen.parts) for seen in (a, b)):
            return True
        for direction in directions:
            open_ = ~self._apart_parts(a, b, direction, radii, span)
            if not open_.any():
                return True
            if a.parts is not None:
                a = a._replace(parts=a.parts.taken(open_))
            else:
                b = b._replace(parts=b.parts.taken(open_))
        middle = (span[0] + span[1]) / 2
        return deepest > 0 and all(
            self._all_apart(a, b, directions, radii, part, deepest - 1)
            for part in ((span[0], middle), (middle, span[1]))
        )

    def _apart_parts(self, a: Seen, b: Seen, direction: Direction, radii: float, span: tuple[float, float]) -> Bools:
        """(n,) which parts of the set of a pair are beyond the other body along a direction, over a span."""
        length = self._stretch * direction.length * UP
        needed = (radii + self._margin) * length * UP + UNDERFLOW
        gaps = []
        for t in span:
            low = _lows(a, self._row(a, direction, t), length)
            high = -_lows(b, -self._row(b, direction, t), length)
            if a.parts is not None and b.parts is not None:
                high = high.max()
            gaps.append(low - high - ROUNDING * (np.abs(low) + np.abs(high)))
        least = np.minimum(*gaps)  # NaN of what is NaN, which is not more than anything
        apart: Bools = least > needed
        if apart.any():
            apart = apart & (least * (1 - ROUNDING) - self._loss(a, b, direction, span) > needed)
        return apart

    def _apart(
        self, a: Seen, b: Seen, direction: Direction, radii: float, span: tuple[float, float], deepest: int
    ) -> bool:
        """Whether the first body is beyond the second along a direction, over a span."""
        needed = (radii + self._margin) * self._stretch * direction.length * UP + UNDERFLOW
        gaps = []
        for t in span:
            low, high = lowest(a, self._row(a, direction, t)), -lowest(b, -self._row(b, direction, t))
            gaps.append(low - high - ROUNDING * (abs(low) + abs(high)))
        if not all(gap > needed for gap in gaps):  # also of no numbers
            return False
        if min(gaps) * (1 - ROUNDING) - self._loss(a, b, direction, span) > needed:
            return True
        middle = (span[0] + span[1]) / 2
        return deepest > 0 and all(
            self._apart(a, b, direction, radii, part, deepest - 1) for part in ((span[0], middle), (middle, span[1]))
        )

    def _loss(self, a: Seen, b: Seen, direction: Direction, span: tuple[float, float]) -> float:
        """By how much, at most, two bodies come nearer along a direction within a span than at its ends."""
        bent = -lowest(a, -self._bending(a, direction, span)), -lowest(b, self._bending(b, direction, span))
        length = span[1] - span[0]
        # In this order, as the square of a short length is below the range of doubles where its product is not.
        deviation = length * (length / 8 * (_positive(bent[0]) + _positive(bent[1]))) * UP
        return (deviation + self._off(a, direction, span) + self._off(b, direction, span)) * UP

    def _row(self, seen: Seen, direction: Direction, t: float) -> Any:
        """The row (w, s) of heights at a parameter, 1 x 4."""
        chains = self._chains
        if chains.is_above(direction.joint, seen.joint):
            return direction.row * chains.at(t, direction.joint, seen.joint) * seen.place
        above = chains.meeting(direction.joint, seen.joint)
        frame = chains.at(t, above, direction.joint)
        turned = (frame * direction.column).transpose()
        return turned * (chains.at(t, above, seen.joint) * seen.place - frame * SHIFT)

    def _bending(self, seen: Seen, direction: Direction, span: tuple[float, float]) -> Any:
        """The second derivative of the row, all over a span."""
        chains = self._chains
        if chains.is_above(direction.joint, seen.joint):
            second = chains.jet(span, direction.joint, seen.joint).second
            return _NOTHING if second is None else direction.row * second * seen.place
        above = chains.meeting(direction.joint, seen.joint)
        frame, body = chains.jet(span, above, direction.joint), chains.jet(span, above, seen.joint)
        turned = [None if part is None else (part * direction.column).transpose() for part in frame]
        from_frame = [total(times(x, seen.place), times(y, -SHIFT)) for x, y in zip(body, frame, strict=True)]
        crossed = times(turned[1], from_frame[1])
        second = total(
            times(turned[2], from_frame[0]), None if crossed is None else crossed * 2, times(turned[0], from_frame[2])
        )
        return _NOTHING if second is None else second

    def _off(self, seen: Seen, direction: Direction, span: tuple[float, float]) -> float:
        """What the height of a body that is not below the frame may be off by, since turns are rigid up to rounding."""
        chains = self._chains
        if chains.is_above(direction.joint, seen.joint):
            return 0.0
        above = chains.meeting(direction.joint, seen.joint)
        frame, body = chains.jet(span, above, direction.joint), chains.jet(span, above, seen.joint)
        rows = (body.value * seen.place - frame.value * SHIFT).entries()
        sizes = [*seen.sizes.tolist(), 1.0]
        far: float = sum(float(rows[4 * i + k].abs_upper()) * sizes[k] for i in range(3) for k in range(4))
        return far * self._stretch * chains.defect * direction.length * UP


# A row of a height that does not change.
_NOTHING = arb_mat(1, 4, [0] * 4)


def _lows(seen: Seen, row: Any, length: float) -> Any:
    """How low a body reaches; (n,) of a set, its parts' radii along a direction of this length taken off."""
    return lowest(seen, row) if seen.parts is None else seen.parts.lowest(row) - seen.parts.radii * (length * UP)


def _positive(x: float) -> float:
    """The number, or 0 if it is below; what is no number stays none, so that nothing is proved by it."""
    return 0.0 if x <= 0 else x
