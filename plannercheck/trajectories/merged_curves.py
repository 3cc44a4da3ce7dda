"""Curves of several things on one clock, side by side as one curve.

In: curves on one clock. Out: one curve, whose pieces are cut at all their breaks; each piece has the numbers of all.

The bounds of `Curve.error`, in units of 2⁻⁵³ of the largest control point: a cut by the polar form takes one average of
3 errors a degree for each of its arguments, an elevation of the degree one of 4 errors. A break is at most 4 errors of
the clock's largest time away from where it was, over which a number moves by at most its speed. A quaternion at a cut
is rounded to doubles; its turn is off by some 10⁻¹⁶ rad, which no bound here counts: tubes are not around unit vectors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.trajectories.curve import Curve
from plannercheck.trajectories.rounding import UNIT

# Errors of a cut and an elevation for each degree, and of a time on the clock.
_CUT, _CLOCK = 8, 4


def shifted(curve: Curve, seconds: float) -> Curve:
    """The same curve so many seconds later."""
    if seconds == 0:
        return curve
    breaks = curve.breaks + seconds
    if not (np.diff(breaks) > 0).all():
        raise PlannercheckError(f"a piece is shorter than doubles can tell at {breaks[-1]:g} s: begin the clock later")
    error = curve.error + _late(curve, max(float(np.abs(curve.breaks).max()), float(np.abs(breaks).max())))
    return replace(curve, breaks=breaks, error=_kept(error, curve))


def between(curve: Curve, begin: float, end: float) -> Curve:
    """A curve from begin to end, s, on which it stands still before its first break and after its last."""
    breaks, pieces = curve.breaks.tolist(), list(curve.pieces)
    if begin < breaks[0]:
        breaks, pieces = [begin, *breaks], [np.repeat(pieces[0][:1], 2, axis=0), *pieces]
    if end > breaks[-1]:
        breaks, pieces = [*breaks, end], [*pieces, np.repeat(pieces[-1][-1:], 2, axis=0)]
    inner = [time for time in breaks if begin < time < end]
    whole = Curve(np.array(breaks), tuple(pieces), curve.error, curve.units)
    cuts = np.array([begin, *inner, end])
    return _cut(whole, cuts)


def side_by_side(curves: Sequence[Curve]) -> Curve:
    """Curves of one duration as one: the columns of the first, then those of the second, and so on."""
    times = np.sort(np.concatenate([curve.breaks for curve in curves]))
    times = times[np.append(True, np.diff(times) > 0)]
    parts = [_cut(curve, times) for curve in curves]
    degrees = [max(map(len, row)) - 1 for row in zip(*(part.pieces for part in parts), strict=True)]
    pieces = tuple(
        np.concatenate([_elevated(part.pieces[k], degree) for part in parts], axis=1)
        for k, degree in enumerate(degrees)
    )
    shifts = np.concatenate([[0], np.cumsum([curve.nq for curve in curves])[:-1]]).tolist()
    units = tuple((a + by, b + by) for part, by in zip(parts, shifts, strict=True) for a, b in part.units)
    raised = max(degrees) * _CUT * UNIT
    error = np.concatenate([_kept(part.error + raised * _largest(part), part) for part in parts])
    return Curve(times, pieces, error, units)


def _cut(curve: Curve, times: Floats) -> Curve:
    """The curve from the first to the last of some times (m,), s, cut at all of them; each break within is one."""
    if np.array_equal(times, curve.breaks):
        return curve
    piece = np.searchsorted(curve.breaks[1:-1], times[:-1], side="right").tolist()
    pieces = tuple(_part(curve, k, *times[j : j + 2].tolist()) for j, k in enumerate(piece))
    degree = max(map(len, curve.pieces)) - 1
    error = curve.error + 2 * degree * _CUT * UNIT * _largest(curve) + _late(curve, float(np.abs(times).max()))
    return Curve(times, pieces, _kept(error, curve), curve.units)


def _late(curve: Curve, latest: float) -> Floats:
    """(nq,) how far a curve gets while a clock's time, up to the latest, s, rounds."""
    steps = np.diff(curve.breaks).tolist()
    hops = [(len(p) - 1) / h * np.abs(np.diff(p, axis=0)).max(axis=0) for p, h in zip(curve.pieces, steps, strict=True)]
    return np.asarray(np.max(hops, axis=0) * _CLOCK * UNIT * latest)


def _kept(error: Floats, curve: Curve) -> Floats:
    """An error with that of the curve for the numbers of unit vectors."""
    for first, past in curve.units:
        error[first:past] = curve.error[first:past]
    return error


def _largest(curve: Curve) -> Floats:
    return np.asarray(np.max([np.abs(each).max(axis=0) for each in curve.pieces], axis=0))


def _part(curve: Curve, k: int, begin: float, end: float) -> Floats:
    """Control points of piece k from begin to end, s."""
    first, last = curve.breaks[k : k + 2].tolist()
    a, b = (0.0 if time <= first else 1.0 if time >= last else (time - first) / (last - first) for time in (begin, end))
    control = curve.pieces[k]
    if (a, b) == (0.0, 1.0):
        return control
    degree = len(control) - 1
    part = np.stack([_polar_form(control, [a] * (degree - j) + [b] * j) for j in range(degree + 1)])
    for start, past in curve.units:
        part[1:-1, start:past] = 0.0
        for row, s in ((0, a), (-1, b)):
            whole = control[0 if s == 0 else -1] if s in (0.0, 1.0) else curve.turned(k, s)
            part[row, start:past] = whole[start:past]
    return part


def _polar_form(control: Floats, arguments: Sequence[float]) -> Floats:
    """De Casteljau's averages with an argument of its own each step."""
    points = control
    for s in arguments:
        points = points[:-1] * (1 - s) + points[1:] * s
    return np.asarray(points[0])


def _elevated(control: Floats, degree: int) -> Floats:
    """The same polynomial's control points (degree + 1, nq)."""
    for n in range(len(control), degree + 1):
        share = np.arange(1, n)[:, None] / n
        control = np.concatenate([control[:1], share * control[:-1] + (1 - share) * control[1:], control[-1:]])
    return control
