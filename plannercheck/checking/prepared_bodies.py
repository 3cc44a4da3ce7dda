"""The bodies of a checker, prepared when a pair first needs them.

In: bodies, how much each is padded. Out: `Preparation`, which has a `Polytope` of each body that was asked for, so that
what no configuration within the limits can touch costs nothing. Equal shapes share one, also among checkers.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.polytope import Polytope, prepared
from plannercheck.bodies.shapes import Body, HullAndSwell, hull_and_swell

Floats = NDArray[np.float64]

# Points up to which a body is prepared faster than a file of the cache is found, read and checked.
_FEW_POINTS = 32


class Preparation:
    """The bodies of a checker, prepared one by one as they are needed; equal shapes share one, also among checkers.

    Attributes:
        hulls: Points, faces and swell of each body, its padding included.
        paddings: (bodies,) how much of the swells is padding, m.
    """

    def __init__(
        self, bodies: Sequence[Body], excess: float, paddings: Floats, earlier: Preparation | None = None
    ) -> None:
        """Computes points and faces of shapes that are new.

        Args:
            bodies: All of them.
            excess: How far polytopes of curved shapes may stick out.
            paddings: (bodies,) m.
            earlier: Of another checker with the same excess, whose prepared bodies are taken over.
        """
        self._bodies = bodies
        self.paddings = paddings
        self.hulls: list[HullAndSwell] = []
        self._polytopes: list[Polytope | None] = []
        self._known: WeakValueDictionary[bytes, Polytope] = WeakValueDictionary() if earlier is None else earlier._known
        before = {} if earlier is None else earlier._by_shape()
        for body, part in zip(bodies, paddings.tolist(), strict=True):
            known = before.get((id(body.shape), part))
            hull, polytope = known if known else (_padded(hull_and_swell(body.shape, excess), part), None)
            self.hulls.append(hull)
            self._polytopes.append(polytope)

    def _by_shape(self) -> dict[tuple[int, float], tuple[HullAndSwell, Polytope | None]]:
        """What there is of each shape, which `_bodies` keeps alive, and padding."""
        keys = ((id(body.shape), part) for body, part in zip(self._bodies, self.paddings.tolist(), strict=True))
        return dict(zip(keys, zip(self.hulls, self._polytopes, strict=True), strict=True))

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_known": None}  # what is shared with other checkers stays with them

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._known = WeakValueDictionary()

    def polytope(self, body: int) -> Polytope:
        """The prepared body."""
        found = self._polytopes[body]
        if found is None:
            points, faces, swell = self.hulls[body]
            key = np.float64(swell).tobytes() + points.tobytes()
            found = self._known.get(key)
            if found is None:
                prepare = Polytope if len(points) <= _FEW_POINTS else prepared
                found = prepare(points, faces, swell, f"body {self._bodies[body].name!r}")
                self._known[key] = found
            self._polytopes[body] = found
        return found

    def so_far(self) -> tuple[Polytope | None, ...]:
        """The bodies that are prepared, None for the others."""
        return tuple(self._polytopes)


def _padded(hull: HullAndSwell, padding: float) -> HullAndSwell:
    points, faces, swell = hull
    return points, faces, swell + padding
