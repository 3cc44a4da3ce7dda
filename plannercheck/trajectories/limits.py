"""Limits that a curve breaks, also between its points.

In: a curve and limits of its columns. Out: an `Excess` for each joint and kind of limit that is broken, with the
instant of the largest excess.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import comb
from typing import Literal

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.shown_times import shown_seconds
from plannercheck.trajectories.curve import Curve, differentiated

Kind = Literal["position", "velocity", "acceleration"]
KINDS: tuple[Kind, ...] = ("position", "velocity", "acceleration")

# A coefficient below this part of the largest one is lost in rounding.
_NEGLIGIBLE = 2.0**-60


@dataclass(frozen=True)
class Excess:
    """A limit that a trajectory breaks.

    Attributes:
        joint: The joint's name.
        kind: "position", "velocity" or "acceleration".
        time: The instant at which it is broken most, s.
        value: The value there; rad or m, by s.
        limit: The limit on this side.
    """

    joint: str
    kind: Kind
    time: float
    value: float
    limit: float

    def __str__(self) -> str:
        return f"{self.joint}: {self.kind} {self.value:.6g} at {shown_seconds(self.time)} s, beyond {self.limit:.6g}"


def broken_limits(curve: Curve, names: Sequence[str], kind: Kind, lower: Floats, upper: Floats) -> list[Excess]:
    """The limits of one kind that a curve breaks.

    Args:
        curve: The curve.
        names: Names of its nq columns.
        kind: What is limited.
        lower: (nq,) the lower limits, -inf where there is none.
        upper: (nq,) the upper limits, inf where there is none.
    """
    worst: dict[str, tuple[float, Excess]] = {}
    for k, (start, end) in enumerate(zip(curve.breaks[:-1], curve.breaks[1:], strict=True)):
        control = differentiated(curve.pieces[k], end - start, KINDS.index(kind))
        # A polynomial lies in the hull of its control points, so most columns need no roots.
        for j in np.flatnonzero((control.min(axis=0) < lower) | (control.max(axis=0) > upper)).tolist():
            for s, value in extremes(control[:, j]):
                over = max(value - upper[j], lower[j] - value)
                if over > 0 and over > worst.get(names[j], (0.0, None))[0]:
                    limit = upper[j] if value > upper[j] else lower[j]
                    at = float(start + s * (end - start))
                    worst[names[j]] = (over, Excess(names[j], kind, at, float(value), float(limit)))
    return [worst[name][1] for name in names if name in worst]


def extremes(control: Floats) -> Iterator[tuple[float, float]]:
    """Parameters and values of a polynomial (degree + 1,) at its ends and where its derivative is 0."""
    degree = len(control) - 1
    powers = np.array(
        [
            comb(degree, i) * sum((-1) ** (i - j) * comb(i, j) * control[j] for j in range(i + 1))
            for i in range(degree + 1)
        ]
    )
    yield 0.0, control[0]
    yield 1.0, control[-1]
    derivative = np.polynomial.polynomial.polyder(powers)
    # Between 0 and 1, leading terms below rounding change nothing, and would make the roots overflow.
    counting = np.flatnonzero(np.abs(derivative) > _NEGLIGIBLE * np.abs(derivative).max())
    for root in np.polynomial.polynomial.polyroots(derivative[: counting[-1] + 1]) if len(counting) else ():
        if abs(root.imag) < 1e-9 and 0 < root.real < 1:
            yield float(root.real), float(np.polynomial.polynomial.polyval(root.real, powers))
