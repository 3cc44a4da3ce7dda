"""Poses of a planar robot's links on a motion, in ball arithmetic.

In: a well-formed model and motion. Out: `Paths`: for a span of the parameter on one piece, the places of links at both
ends, and bounds on how far points of a body leave their chords.

A place is a pair of complex balls: the unit number of the link's turn, and its origin. Seen from a link, or from the
world, a point of a body is o + e^(i f1) u1 + e^(i f2) u2 + … with complex constants u, one for each link on the way;
the angles f and the origin o are linear in the parameter. So its second derivative over the span, times the span's
length squared, is at most the sum of |f'|^2 |u|, with f' the change of f over the span. The point leaves its chord by
at most an eighth of that.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from flint import acb, arb

from plannercheck.proofs.planar_proof import Piece, PlanarModel, PlanarMotion

# The world, where the index of a link or frame is expected.
WORLD = -1

# A double nearest to an upper bound may be below it by half a unit of its last place.
_UP = 1 + 2.0**-50

# Places are kept for at most this many parameters, so that memory stays bounded.
_MOST_KNOWN = 4096


class Span(NamedTuple):
    """Part of a motion.

    Attributes:
        piece: On which it lies; the motion's end is a piece of its own, after the last.
        start: Parameter of the motion.
        end: Parameter.
    """

    piece: int
    start: float
    end: float


class Place(NamedTuple):
    """The pose of a link: turned by `turn`, of length 1, its origin at `origin`, m."""

    turn: Any
    origin: Any


class Root(NamedTuple):
    """Where a free root goes on a piece, all of them balls; parameters as those of `Piece`."""

    start: Any
    length: Any
    origin: Any
    way: Any
    heading: Any
    turn: Any
    arm: Any
    slip: float


class Paths:
    """The links of one robot on one motion; what is computed is kept."""

    def __init__(self, model: PlanarModel, motion: PlanarMotion) -> None:
        """Reads the model and the motion."""
        self._links = model.links
        self._start = [arb(value) for value in motion.start]
        self._end = [arb(value) for value in motion.end]
        self._anchors = [acb(link.x, link.y) for link in model.links]
        self._lengths = [float(abs(anchor).abs_upper()) * _UP for anchor in self._anchors]
        self._roots = self._root_pieces(motion)
        self._ends = [piece.end for piece in motion.pieces] or [1.0]
        self._known: dict[tuple[int, float], list[Place]] = {}

    def _root_pieces(self, motion: PlanarMotion) -> list[Root]:
        """The root's pieces; the last one of a curve is its end, at which the root stands."""
        if self._links[0].joint != "free":
            nothing = acb(0)
            return [Root(arb(0), arb(1), nothing, nothing, arb(0), arb(0), nothing, 0.0)]
        at = [acb(q[0], q[1]) for q in (self._start, self._end)]
        if motion.curve == "straight":
            turn = self._end[2] - self._start[2]
            return [Root(arb(0), arb(1), at[0], at[1] - at[0], self._start[2], turn, acb(0), 0.0)]
        pieces = [_root_on(piece) for piece in motion.pieces]
        return [*pieces, Root(arb(1), arb(0), at[1], acb(0), self._end[2], arb(0), acb(0), 0.0)]

    def spans(self, start: float, end: float) -> list[Span]:
        """The parts of an interval on each piece; the end of a curve alone for an interval of no length at 1."""
        if start == end:
            return [Span(len(self._roots) - 1, start, end)]
        spans, begin = [], 0.0
        for k, stop in enumerate(self._ends):
            low, high = max(start, begin), min(end, stop)
            if low < high:
                spans.append(Span(k, low, high))
            begin = stop
        return spans

    def slip(self, span: Span) -> float:
        """The slip of the span's piece, m."""
        return self._roots[span.piece].slip

    def places(self, piece: int, t: float) -> list[Place]:
        """The places of all links at a parameter that is on a piece."""
        if (piece, t) not in self._known:
            if len(self._known) >= _MOST_KNOWN:
                self._known.clear()
            self._known[piece, t] = self._computed(piece, t)
        return self._known[piece, t]

    def _computed(self, piece: int, t: float) -> list[Place]:
        angles: list[Any] = []
        places: list[Place] = []
        for index, link in enumerate(self._links):
            if link.parent == WORLD:
                angle, origin = arb(link.angle), self._anchors[index]
            else:
                angle, (turn, place) = angles[link.parent] + link.angle, places[link.parent]
                origin = place + turn * self._anchors[index]
            if link.joint == "revolute":
                angle = angle + self._value(link.column, t)
            elif link.joint == "free":
                place, heading = self._root(self._roots[piece], t)
                angle, origin = angle + heading, origin + place
            angles.append(angle)
            places.append(Place(unit(angle), origin))
        return places

    def _value(self, column: int, t: float) -> Any:
        return self._start[column] + (self._end[column] - self._start[column]) * t

    def _root(self, root: Root, t: float) -> tuple[Any, Any]:
        """Place and heading."""
        s = (t - root.start) / root.length if root.length != 0 else arb(0)
        heading = root.heading + root.turn * s
        return root.origin + root.way * s + unit(heading) * root.arm, heading

    def ends(self, piece: int) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
        """Places and headings of a free root at both ends of a piece of a curve."""
        root = self._roots[piece]
        return self._root(root, root.start), self._root(root, root.start + root.length)

    def given_ends(self) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
        """Places and headings of a free root at the motion's start and end."""
        start, end = self._start, self._end
        return (acb(start[0], start[1]), start[2]), (acb(end[0], end[1]), end[2])

    # ----- what is seen from a frame

    def meeting(self, first: int, second: int) -> int:
        """The last link that carries both, -1 for the world."""
        while first != second:
            if first > second:
                first = self._links[first].parent
            else:
                second = self._links[second].parent
        return first

    def deviation(self, span: Span, frame: int, link: int, extent: float) -> float:
        """At least how far a point within `extent` of a link's origin leaves its chord, seen from a frame, m."""
        way = []
        while link != frame:
            way.append(link)
            link = self._links[link].parent
        reached = [extent, *(self._lengths[k] for k in way)]  # from each link on the way to the next, or into the body
        share, rate, total = self._share(span), arb(0), 0.0
        for index, length in reversed(list(zip(way, reached, strict=False))):
            rate = rate + self._rate(index, span, share)
            if self._links[index].joint == "free":
                length += float(abs(self._roots[span.piece].arm).abs_upper()) * _UP
            total += (float(abs(rate).abs_upper()) * _UP) ** 2 * length
        return total / 8 * _UP**8

    def _share(self, span: Span) -> Any:
        """The span's share of its piece."""
        root = self._roots[span.piece]
        return (arb(span.end) - span.start) / root.length if root.length != 0 else arb(0)

    def _rate(self, index: int, span: Span, share: Any) -> Any:
        link = self._links[index]
        if link.joint == "free":
            return self._roots[span.piece].turn * share
        if link.joint == "revolute":
            return (self._end[link.column] - self._start[link.column]) * (arb(span.end) - span.start)
        return arb(0)


def unit(angle: Any) -> Any:
    """e^(i angle)."""
    sin, cos = angle.sin_cos()
    return acb(cos, sin)


def _root_on(piece: Piece) -> Root:
    return Root(
        arb(piece.start),
        arb(piece.end) - piece.start,
        acb(*piece.origin),
        acb(*piece.way),
        arb(piece.heading),
        arb(piece.turn),
        acb(*piece.arm),
        piece.slip,
    )
