"""Padding: distances that bodies have to keep, besides not touching.

In: one distance in m for all pairs, or parts of it by the names of links, obstacles or bodies. Out: each body's own
part, by which it is swollen. A pair has to keep more than the sum of both bodies' parts apart. Points and faces are
untouched and swells are exact, so padded verdicts are as exact as others: swells add without rounding in the test. Only
a part that is added to a swell that a ball or a capsule has already is rounded, once, to a double.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from plannercheck.errors import PlannercheckError, unknown_name
from plannercheck.shapes import Body

Padding: TypeAlias = float | Mapping[str, float]


def padding_parts(padding: Padding, bodies: Sequence[Body], labels: Sequence[str]) -> NDArray[np.float64]:
    """Each body's part.

    Args:
        padding: The distance that every pair keeps, m, or parts by name: a body's own, else its link's or obstacle's,
            else 0. A pair keeps the sum of its two parts.
        bodies: All bodies.
        labels: The link or obstacle of each.

    Returns:
        (bodies,), m.

    Raises:
        PlannercheckError: If a length is negative or not finite, or a name is unknown.
    """
    if not isinstance(padding, Mapping):
        return np.full(len(bodies), _checked(padding, "padding") / 2)
    names = {*labels, *(body.name for body in bodies)}
    for name in padding:
        if name not in names:
            raise unknown_name("padded body, link or obstacle", name, sorted(names))
    parts = {name: _checked(length, f"padding of {name!r}") for name, length in padding.items()}
    own = (parts.get(body.name, parts.get(label, 0.0)) for body, label in zip(bodies, labels, strict=True))
    return np.array(list(own), dtype=np.float64)


def _checked(length: float, what: str) -> float:
    if isinstance(length, bool) or not isinstance(length, int | float | np.floating) or not 0 <= length < np.inf:
        raise PlannercheckError(f"{what} must be a length in m of at least 0, not {length!r}")
    return float(length)
