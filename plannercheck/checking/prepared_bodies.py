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
from plannercheck.robots.robot import Robot

# Up to this many points, preparing a body is faster than finding, reading and checking a cached file.
_FEW_POINTS = 32


class _Body:
    """A body's hull, and its polytope once a pair needs it. Checkers that have the body share this object."""

    __slots__ = ("hull", "polytope")

    def __init__(self, hull: InflatedHull) -> None:
        self.hull = hull
        self.polytope: Polytope | None = None


class Preparation:
    """The bodies of a checker, prepared one by one as they are needed.

    Attributes:
        hulls: Points, faces and inflation radius of each body, its padding included.
        paddings: (bodies,) the part of each inflation radius that is padding, m.
        excess: How far polytopes of curved shapes may stick out, as a part of the radius.
    """

    def __init__(
        self, bodies: Sequence[GeometryObject], excess: float, paddings: Floats, earlier: Preparation | None = None
    ) -> None:
        """Computes points and faces of shapes that are new.

        Args:
            bodies: All bodies.
            excess: How far polytopes of curved shapes may stick out, as a part of the radius.
            paddings: (bodies,) m.
            earlier: The preparation of other bodies with the same excess: what it has is taken over.
        """
        self._bodies = bodies  # they keep the shapes alive, whose ids are keys
        self.paddings, self.excess = paddings, excess
        self._known: WeakValueDictionary[bytes, Polytope] = WeakValueDictionary() if earlier is None else earlier._known
        before = {} if earlier is None else earlier._by_shape
        self._by_shape: dict[tuple[int, float], _Body] = {}
        self._entries: list[_Body] = []
        for body, part in zip(bodies, paddings.tolist(), strict=True):
            key = id(body.shape), part
            entry = (
                self._by_shape.get(key) or before.get(key) or _Body(_padded(inflated_hull(body.shape, excess), part))
            )
            self._by_shape[key] = entry
            self._entries.append(entry)
        self.hulls = [entry.hull for entry in self._entries]

    def __getstate__(self) -> dict[str, Any]:
        polytopes = [entry.polytope for entry in self._entries]
        return {"bodies": self._bodies, "excess": self.excess, "paddings": self.paddings, "polytopes": polytopes}

    def __setstate__(self, state: dict[str, Any]) -> None:
        Preparation.__init__(self, state["bodies"], state["excess"], state["paddings"])
        for entry, polytope in zip(self._entries, state["polytopes"], strict=True):
            entry.polytope = polytope

    def polytope(self, body: int) -> Polytope:
        """The prepared body."""
        entry = self._entries[body]
        if entry.polytope is None:
            points, faces, inflation_radius = entry.hull
            key = np.float64(inflation_radius).tobytes() + points.tobytes()
            found = self._known.get(key)
            if found is None:
                prepare = Polytope if len(points) <= _FEW_POINTS else prepared
                found = prepare(points, faces, inflation_radius, f"body {self._bodies[body].name!r}")
                self._known[key] = found
            entry.polytope = found
        return entry.polytope

    def prepared_bodies(self) -> tuple[Polytope | None, ...]:
        """The prepared bodies, None for those not needed so far."""
        return tuple(entry.polytope for entry in self._entries)


def preparation_of_robot(
    robot: Robot, bodies: Sequence[GeometryObject], excess: float, paddings: Floats
) -> Preparation:
    """The preparation of the bodies on a robot's links, or of stand-ins for them: one for all checkers of the robot.

    Args:
        robot: The robot.
        bodies: Its bodies come first.
        excess: As for `Preparation`.
        paddings: (bodies,) m.
    """
    own = tuple(bodies[: len(robot.bodies)])
    shares = paddings[: len(own)]
    key = ("bodies", own, excess, shares.tobytes())
    return robot.remembered(key, lambda: Preparation(own, excess, shares))


def _padded(hull: InflatedHull, padding: float) -> InflatedHull:
    points, faces, inflation_radius = hull
    return points, faces, inflation_radius + padding
