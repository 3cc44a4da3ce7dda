"""Whether objects that move in a scene are where proofs have them, at the times of the scene's clock that these say.

In: motions with their clocks, and for each group of objects where the scene has them at some times: numbers that change
linearly in between, unit vectors by slerp. Out: how far turns are off, or an `UnprovedError`. Positions, and numbers of
screws, may differ by the motion's tube, in fractions: polynomials differ no more than their control points do. Around
a unit vector there is no tube: it is compared at both ends of the motion.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any, NamedTuple

from flint import arb

from plannercheck.common.shown_times import shown_seconds, shown_span
from plannercheck.proofs.data import Motion
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.jets import by_length

# How far a motion may reach beyond both times between which objects go straight, s.
_BEYOND = Fraction(1, 10**9)

# How far a number of a unit vector may be off.
_OFF_TURN = 1e-9


class Course(NamedTuple):
    """Where some objects are in time.

    Attributes:
        names: The objects, in words.
        column: The first of their columns.
        times: (m,) s of the scene's clock, growing.
        rows: (m, width) their numbers then.
        units: (first, past) of numbers that form a unit vector.
        stands: Whether they stand still before and after.
    """

    names: str
    column: int
    times: Sequence[float]
    rows: Sequence[Sequence[float]]
    units: Sequence[tuple[int, int]]
    stands: bool


def check_clocks(motions: Sequence[Motion], courses: Sequence[Course]) -> float:
    """By how much numbers of unit vectors are off at most; raises at the first motion that is another one."""
    off = 0.0
    for k, motion in enumerate(motions):
        if len(motion.clock) != 2:
            raise UnprovedError(f"motion {k} has no clock, and {courses[0].names} is elsewhere at other times")
        for course in courses:
            try:
                off = max(off, _off(motion, course))
            except UnprovedError as why:
                raise UnprovedError(f"motion {k}: {why}") from None
    return off


def _off(motion: Motion, course: Course) -> float:
    """The same of one motion and course."""
    begin, end = map(Fraction, motion.clock)
    step, shares, beyond = _step(course, begin, end)
    is_unit = {j for first, past in course.units for j in range(first, past)}
    control = [[Fraction(x) for x in row[course.column :]] for row in motion.control]
    for j in range(len(course.rows[0])):
        if j in is_unit:
            continue
        a, b = (Fraction(row[j]) for row in step)
        ends = [a + (b - a) * share for share in shares]
        degree = len(control) - 1
        off = max(abs(row[j] - ends[0] - (ends[1] - ends[0]) * i / degree) for i, row in enumerate(control))
        allowed = Fraction(motion.tube[course.column + j]) if motion.tube else Fraction(0)
        off += beyond * _speed(course, j)
        if off > allowed:
            raise UnprovedError(
                f"{course.names} is not where the scene has it from {shown_span(*motion.clock)}:"
                f" column {course.column + j} is off by {float(off):.3g}, and its tube is {float(allowed):.3g}"
            )
    return max(_turns_off(motion, course, step, shares), default=0.0)


def _step(
    course: Course, begin: Fraction, end: Fraction
) -> tuple[tuple[Sequence[float], Sequence[float]], list[Fraction], Fraction]:
    """The rows between which objects go, which parts of that way a motion takes, and how far it reaches beyond, s."""
    times = [Fraction(time) for time in course.times]
    k = bisect_right(times, (begin + end) / 2)
    if k in (0, len(times)):
        low, high = (begin, times[0]) if k == 0 else (times[-1], end)
        beyond = max(end - high, low - begin, Fraction(0))
        if not course.stands:
            raise UnprovedError(f"the scene does not say where {course.names} is at {shown_seconds(float(begin))} s")
        row = course.rows[0 if k == 0 else -1]
        found, shares = (row, row), [Fraction(0), Fraction(1)]
    else:
        low, high = times[k - 1], times[k]
        beyond = max(end - high, low - begin, Fraction(0))
        found = course.rows[k - 1], course.rows[k]
        shares = [(time - low) / (high - low) for time in (begin, end)]
    if beyond > _BEYOND:
        raise UnprovedError(f"{course.names} does not go straight from {shown_span(float(begin), float(end))}")
    return found, shares, beyond


def _speed(course: Course, column: int) -> Fraction:
    """Twice the largest speed of a number: on either side of a time it may be that."""
    steps = zip(pairwise(course.times), pairwise(course.rows), strict=True)
    speeds = (abs(Fraction(b[column]) - Fraction(a[column])) / (Fraction(t) - Fraction(s)) for (s, t), (a, b) in steps)
    return 2 * max(speeds)


def _turns_off(
    motion: Motion, course: Course, step: tuple[Sequence[float], Sequence[float]], shares: Sequence[Fraction]
) -> Iterator[float]:
    """How far unit vectors are off at both ends."""
    for first, past in course.units:
        for numbers, share in zip((motion.start, motion.end), shares, strict=True):
            given = by_length(numbers[course.column + first : course.column + past])
            before, after = (by_length(row[first:past]) for row in step)
            meant = _slerp(before, after, share)
            off = max(float(abs(a - b).upper()) for a, b in zip(given, meant, strict=True))
            if not off <= _OFF_TURN:
                raise UnprovedError(f"{course.names} is not turned as in the scene: off by {off:.3g}")
            yield off


def _slerp(a: Sequence[Any], b: Sequence[Any], share: Fraction) -> list[Any]:
    """A part of the way between unit vectors, which are less than half a turn of the vector apart."""
    cosine = sum((x * y for x, y in zip(a, b, strict=True)), arb(0))
    across = [y - cosine * x for x, y in zip(a, b, strict=True)]
    length = sum((x * x for x in across), arb(0)).sqrt()
    if not length > 1e-15:  # as good as no turn
        return list(a)
    angle = arb.atan2(length, cosine) * (arb(share.numerator) / arb(share.denominator))
    return [angle.cos() * x + angle.sin() / length * y for x, y in zip(a, across, strict=True)]
