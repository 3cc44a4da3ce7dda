"""The bodies of a checker, prepared when a pair first needs them.

In: bodies and their paddings. Out: `Preparation`, which makes the `Polytope` of a body when it is first asked for, so
that bodies which no configuration within the limits can touch cost nothing. Equal shapes share one polytope, across
checkers as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any
from weakref import WeakValueDictionary

import numpy as np

from plannercheck.bodies.polytope import Polytope, prepared
from plannercheck.bodies.shapes import GeometryObject, InflatedHull, inflated_hull
from plannercheck.common.array_types import Floats

# Up to this many points, preparing a body is faster than finding, reading and checking a cached file.
_FEW_POINTS = 32


class Preparation:
    """The bodies of a checker, prepared one by one as they are needed.

    Attributes:
        hulls: Points, faces and inflation radius of each body, its padding included.
        paddings: (bodies,) the part of each inflation radius that is padding, m.
    """

    def __init__(
        self, bodies: Sequence[GeometryObject], excess: float, paddings: Floats, earlier: Preparation | None = None
    ) -> None:
        """Computes points and faces of shapes that are new.

        Args:
            bodies: All bodies.
            excess: How far polytopes of curved shapes may stick out, as a part of the radius.
            paddings: (bodies,) m.
            earlier: The preparation of another checker with the same excess: its prepared bodies are taken over.
        """
        self._bodies = bodies
        self.paddings = paddings
        self.hulls: list[InflatedHull] = []
        self._polytopes: list[Polytope | None] = []
        self._known: WeakValueDictionary[bytes, Polytope] = WeakValueDictionary() if earlier is None else earlier._known
        before = {} if earlier is None else earlier._by_shape()
        for body, part in zip(bodies, paddings.tolist(), strict=True):
            known = before.get((id(body.shape), part))
            hull, polytope = known if known else (_padded(inflated_hull(body.shape, excess), part), None)
            self.hulls.append(hull)
            self._polytopes.append(polytope)

    def _by_shape(self) -> dict[tuple[int, float], tuple[InflatedHull, Polytope | None]]:
        """What is known, by shape (`_bodies` keeps the shapes alive) and padding."""
        keys = ((id(body.shape), part) for body, part in zip(self._bodies, self.paddings.tolist(), strict=True))
        return dict(zip(keys, zip(self.hulls, self._polytopes, strict=True), strict=True))

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_known": None}  # shared with other checkers, so not pickled

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._known = WeakValueDictionary()

    def polytope(self, body: int) -> Polytope:
        """The prepared body."""
        found = self._polytopes[body]
        if found is None:
            points, faces, inflation_radius = self.hulls[body]
            key = np.float64(inflation_radius).tobytes() + points.tobytes()
            found = self._known.get(key)
            if found is None:
                prepare = Polytope if len(points) <= _FEW_POINTS else prepared
                found = prepare(points, faces, inflation_radius, f"body {self._bodies[body].name!r}")
                self._known[key] = found
            self._polytopes[body] = found
        return found

    def prepared_bodies(self) -> tuple[Polytope | None, ...]:
        """The prepared bodies, None for those not needed so far."""
        return tuple(self._polytopes)


def _padded(hull: InflatedHull, padding: float) -> InflatedHull:
    points, faces, inflation_radius = hull
    return points, faces, inflation_radius + padding
