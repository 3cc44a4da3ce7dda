"""Checks entries of a proof in the plane: heights of bodies along a direction, over an interval of the motion.

In: a well-formed proof whose kind is "plane", its entries one by one. Out: an `UnprovedError` at one that does not
hold. Links are posed by the proof's own table (`planar_paths.py`) with python-flint.

One entry, by a line. Let d be the direction, fixed in the frame of the last link that carries both bodies. On a part of
the interval the height d . x of every point x of a body, seen from that frame, is at least the chord between its
heights at both ends less |d| times the body's `deviation`. So the first body's lowest vertex stays above the second's
highest one by at least the difference at the worse end, less |d| times both deviations. If that is more than |d| times
the margin plus the piece's slip, the bodies are apart on the part. Else the part is halved, up to a largest depth.

By circles ("balls"): the same with both centres in place of the vertices and the radii added to the margin, along a
direction that the verifier chooses, from one centre to the other where they are closest on their chord.

Vertices are multiplied in doubles: w . v errs by at most 3 u of the sum of the products' sizes, u = 2^-53.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.proofs.data import Entry, ProofData
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.planar_proof import PlanarBody, PlanarModel

# A part is halved this often before its entry counts as not confirmed.
_DEEPEST = 14

# A sum of two products in doubles errs by 3 u of their sizes, to first order; twice that is more than enough.
_ROUNDING = 6 * 2.0**-53
_UP = 1 + 2.0**-50
_UNDERFLOW = 1e-290  # far below any length, m: covers products and sums below the range of doubles


class Line(NamedTuple):
    """The height of a body's points, as a linear function of their coordinates in its own frame.

    Attributes:
        factors: (2,) middle.
        offset: A ball.
        loose: Radius of each factor, and more for their rounding.
    """

    factors: Floats
    offset: Any
    loose: float


class PlanarEntryChecker:
    """Confirms entries of one well-formed proof."""

    def __init__(self, proof: ProofData) -> None:
        """Reads the model and the motion."""
        from flint import acb, arb

        from plannercheck.proofs.planar_paths import Paths

        assert isinstance(proof.model, PlanarModel)
        self._acb, self._arb = acb, arb
        self._bodies, self._pairs = proof.model.bodies, proof.model.pairs
        self._paths: Any = Paths(proof.model, proof.motion)  # type: ignore[arg-type]  # of the plane, as was checked
        self._margin = proof.margin
        self._sizes = [float(np.abs(body.vertices).max()) for body in self._bodies]
        self._extents = [float(np.hypot(*body.vertices.T).max()) * _UP for body in self._bodies]
        self._centre_extents = [math.hypot(*body.centre) * _UP for body in self._bodies]

    def check(self, index: int, entry: Entry) -> None:
        """Confirms an entry.

        Raises:
            UnprovedError: If it does not prove its pair apart on its interval.
        """
        a, b = self._pairs[entry.pair]
        frame = self._paths.meeting(self._bodies[a].link, self._bodies[b].link)
        name = f"entry {index} ({self._bodies[a].label} and {self._bodies[b].label})"
        if entry.by == "plane" and entry.frame != frame:
            raise UnprovedError(f"{name}: its line is fixed in frame {entry.frame}, not in {frame}, which carries both")
        for span in self._paths.spans(entry.start, entry.end):
            self._confirm(entry, a, b, frame, span, 0, name)

    def _confirm(self, entry: Entry, a: int, b: int, frame: int, span: Any, depth: int, name: str) -> None:
        if entry.by == "plane":
            excess = self._line_excess(entry.direction, a, b, frame, span)
        else:
            excess = self._circles_excess(a, b, frame, span)
        if excess > 0:
            return
        middle = (span.start + span.end) / 2
        if depth >= _DEEPEST or not span.start < middle < span.end:
            kind = "line" if entry.by == "plane" else "circles"
            raise UnprovedError(
                f"{name}: its {kind} do not keep both apart by the margin on [{span.start!r}, {span.end!r}]; "
                f"{excess!r} m are lacking"
            )
        for start, end in ((span.start, middle), (middle, span.end)):
            self._confirm(entry, a, b, frame, span._replace(start=start, end=end), depth + 1, name)

    # ----- lines

    def _line_excess(self, direction: tuple[float, ...], a: int, b: int, frame: int, span: Any) -> float:
        """At most the gap along a direction on a span less what it has to exceed, m; proved if it is above 0."""
        d = self._acb(*direction)
        needed: float = self._margin + self._paths.slip(span)
        for body in (a, b):
            needed += self._deviation(span, frame, body, self._extents[body])
        gaps = [self._gap(d, a, b, frame, span.piece, t) for t in {span.start, span.end}]
        length = float(abs(d).abs_upper()) * _UP
        return min(gaps) - needed * _UP**4 * length

    def _deviation(self, span: Any, frame: int, body: int, extent: float) -> float:
        link = self._bodies[body].link
        return 0.0 if link < 0 else float(self._paths.deviation(span, frame, link, extent))

    def _gap(self, d: Any, a: int, b: int, frame: int, piece: int, t: float) -> float:
        """At most the height of the lowest vertex of a over the highest of b."""
        one, two = (self._line(d, body, frame, piece, t) for body in (a, b))
        low = self._bodies[a].vertices @ one.factors
        high = self._bodies[b].vertices @ two.factors
        between = one.offset - two.offset
        loose = self._loose(one, a) + self._loose(two, b) + _UNDERFLOW
        gap = float(between.lower()) + float(low.min()) - float(high.max())
        rounding = _ROUNDING * (abs(float(between.mid())) + abs(float(low.min())) + abs(float(high.max())))
        return gap - (loose + rounding) * _UP**4

    def _loose(self, line: Line, body: int) -> float:
        """How far off a body's heights may be by the factors' radii and the doubles' rounding."""
        return (line.loose + _ROUNDING * float(np.abs(line.factors).sum())) * self._sizes[body]

    def _line(self, d: Any, body: int, frame: int, piece: int, t: float) -> Line:
        """The height of a body's points at a parameter, along a direction of a frame."""
        given = self._bodies[body]
        if given.link < 0:
            m = given.pose
            x, y = d.real, d.imag
            factors = x * m[0] + y * m[3], x * m[1] + y * m[4]
            return _line_of(*factors, x * m[2] + y * m[5])
        places = self._paths.places(piece, t)
        turned, shift = d, self._acb(0)  # the direction in the world, and the frame's origin
        if frame >= 0:
            turned, shift = d * places[frame].turn, places[frame].origin
        own = places[given.link]
        factors = turned.conjugate() * own.turn  # the height of v is the real part of this times v
        return _line_of(factors.real, -factors.imag, (turned.conjugate() * (own.origin - shift)).real)

    # ----- circles

    def _circles_excess(self, a: int, b: int, frame: int, span: Any) -> float:
        """At most the gap between two circles on a span less what it has to exceed, m; proved if it is above 0."""
        needed: float = self._margin + self._paths.slip(span) + self._bodies[a].reach + self._bodies[b].reach
        for body in (a, b):
            needed += self._deviation(span, frame, body, self._centre_extents[body])
        ends = [self._between(a, b, frame, span.piece, t) for t in (span.start, span.end)]
        d = _nearest(*(complex(float(z.real.mid()), float(z.imag.mid())) for z in ends))
        if d == 0:
            return -needed
        direction = self._acb(d.real, d.imag)
        heights = [float((direction.conjugate() * z).real.lower()) for z in ends]
        lowest = min(heights)
        lowest -= abs(lowest) * 2.0**-50
        return lowest - needed * _UP**4 * float(abs(direction).abs_upper()) * _UP - _UNDERFLOW

    def _between(self, a: int, b: int, frame: int, piece: int, t: float) -> Any:
        """From the centre of b to that of a, seen from a frame."""
        places = self._paths.places(piece, t)
        way = self._centre(a, places) - self._centre(b, places)
        return way if frame < 0 else places[frame].turn.conjugate() * way

    def _centre(self, body: int, places: list[Any]) -> Any:
        given: PlanarBody = self._bodies[body]
        if given.link >= 0:
            place = places[given.link]
            return place.origin + place.turn * self._acb(*given.centre)
        m, (x, y) = given.pose, (self._arb(value) for value in given.centre)
        return self._acb(x * m[0] + y * m[1] + m[2], x * m[3] + y * m[4] + m[5])


def _line_of(x: Any, y: Any, offset: Any) -> Line:
    factors = np.array([float(x.mid()), float(y.mid())])
    rounding = 2.0**-52 * (abs(factors[0]) + abs(factors[1]))
    return Line(factors, offset, (float(x.rad()) + float(y.rad()) + rounding) * _UP)


def _nearest(first: complex, last: complex) -> complex:
    """Unit vector to the point of a segment that is nearest to 0; 0 where that is at 0."""
    way = last - first
    square = abs(way) ** 2
    part = 0.0 if square == 0 else min(1.0, max(0.0, -(first * way.conjugate()).real / square))
    nearest = first + part * way
    return nearest / abs(nearest) if abs(nearest) > 0 else 0j
