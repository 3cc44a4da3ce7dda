"""The bodies of a checker, prepared when a pair first needs them.

In: bodies and their paddings. Out: `Preparation`, which makes the hull and the `Polytope` of a body when they are first
asked for, so that bodies which no configuration within the limits can touch cost nothing. What has been made of a shape
stays as long as the shape: checkers of the same robot, and of scenes that share objects, prepare nothing twice. Equal
hulls share one polytope.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any
from weakref import WeakKeyDictionary, WeakValueDictionary

import numpy as np

from plannercheck.bodies.polytope import Polytope, polytope_of_box, prepared
from plannercheck.bodies.shapes import Box, GeometryObject, InflatedHull, Shape, inflated_hull
from plannercheck.bodies.solids import Solid
from plannercheck.checking.reach_bounds import Boxes, boxes_of
from plannercheck.common.array_types import Floats

# Up to this many points, preparing a body is faster than finding, reading and checking a cached file.
_FEW_POINTS = 32


class _PreparedShape:
    """A shape with one padding: its hull and its polytope, once they are needed."""

    __slots__ = ("_hull", "polytope", "setting")

    def __init__(self, setting: tuple[float, float]) -> None:
        self.setting = setting  # excess and padding
        self._hull: InflatedHull | None = None
        self.polytope: Polytope | None = None

    def hull(self, shape: Shape) -> InflatedHull:
        """Points, faces and inflation radius, the padding included."""
        if self._hull is None:
            excess, padding = self.setting
            points, faces, inflation_radius = inflated_hull(shape, excess)
            self._hull = points, faces, inflation_radius + padding
        return self._hull


# Of a shape, so many last used with different excesses or paddings are kept.
_MOST_SETTINGS = 4

# By shape, for each excess and padding, most often one. Shapes that compare equal are the same shape.
_PREPARED: WeakKeyDictionary[Shape, tuple[_PreparedShape, ...]] = WeakKeyDictionary()

# By inflation radius and points, of solids that are not their hulls by their triangles, too.
_POLYTOPES: WeakValueDictionary[bytes, Polytope] = WeakValueDictionary()


class Preparation:
    """The bodies of a checker, prepared one by one as they are needed.

    Attributes:
        paddings: (bodies,) the part of each inflation radius that is padding, m.
        excess: How far polytopes of curved shapes may stick out, as a part of the radius.
    """

    def __init__(
        self, bodies: Sequence[GeometryObject], excess: float, paddings: Floats, earlier: Preparation | None = None
    ) -> None:
        """Looks up what is known of the shapes.

        Args:
            bodies: All bodies.
            excess: How far polytopes of curved shapes may stick out, as a part of the radius.
            paddings: (bodies,) m.
            earlier: The preparation of another checker with the same excess; it only saves look-ups.
        """
        self._bodies = bodies  # they keep the shapes alive, whose ids are keys
        self.paddings, self.excess = paddings, excess
        before = {} if earlier is None else earlier._by_shape
        self._by_shape: dict[tuple[int, float], _PreparedShape] = {}
        self._entries: list[_PreparedShape] = []
        for body, part in zip(bodies, paddings.tolist(), strict=True):
            key = id(body.shape), part
            entry = self._by_shape[key] = before.get(key) or _known(body.shape, (excess, part))
            self._entries.append(entry)

    def __getstate__(self) -> dict[str, Any]:
        return {
            "bodies": self._bodies,
            "excess": self.excess,
            "paddings": self.paddings,
            "polytopes": self.prepared_bodies(),
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        Preparation.__init__(self, state["bodies"], state["excess"], state["paddings"])
        for entry, polytope in zip(self._entries, state["polytopes"], strict=True):
            entry.polytope = entry.polytope or polytope

    def hull(self, body: int) -> InflatedHull:
        """Points, faces and inflation radius of a body, its padding included."""
        return self._entries[body].hull(self._bodies[body].shape)

    def hulls(self, count: int) -> list[InflatedHull]:
        """Those of the first bodies."""
        return [self.hull(body) for body in range(count)]

    def boxes(self, bodies: Sequence[int]) -> Boxes:
        """The boxes and balls around some bodies' hulls; those that are boxes need no hull."""
        shapes = [self._bodies[body].shape for body in bodies]
        if not all(type(shape) is Box for shape in shapes):
            return boxes_of([self.hull(body) for body in bodies])
        high = np.array([shape.size for shape in shapes if isinstance(shape, Box)]).reshape(-1, 3) / 2
        radius = np.sqrt((high**2).sum(axis=1))
        return Boxes(-high, high, np.zeros_like(high), radius, self.paddings[np.asarray(bodies, dtype=np.int64)])

    def polytope(self, body: int) -> Polytope:
        """The prepared body."""
        entry = self._entries[body]
        if entry.polytope is None and type(self._bodies[body].shape) is Box:
            entry.polytope = polytope_of_box(*self.hull(body)[::2])  # equal boxes share it already
        if entry.polytope is None:
            entry.polytope = self._prepared(body)
        return entry.polytope

    def _prepared(self, body: int) -> Polytope:
        """The prepared body, shared by equal hulls; a solid that is not its hull is shared by equal solids."""
        shape = self._bodies[body].shape
        points, faces, inflation_radius = self.hull(body)
        key = np.float64(inflation_radius).tobytes() + points.tobytes()
        if isinstance(shape, Solid) and not shape.equals_hull:
            key += shape.digest
        found = _POLYTOPES.get(key)
        if found is None:
            prepare = Polytope if len(points) <= _FEW_POINTS else prepared
            found = prepare(points, faces, inflation_radius, f"body {self._bodies[body].name!r}")
            found = found.of_solid(shape) if isinstance(shape, Solid) else found
            _POLYTOPES[key] = found
        return found

    def prepared_bodies(self) -> tuple[Polytope | None, ...]:
        """The prepared bodies, None for those not needed so far."""
        return tuple(entry.polytope for entry in self._entries)


def _known(shape: Shape, setting: tuple[float, float]) -> _PreparedShape:
    """What is known of a shape with an excess and a padding, to be added to."""
    of_shape = _PREPARED.get(shape, ())
    for entry in of_shape:
        if entry.setting == setting:
            return entry
    entry = _PreparedShape(setting)
    _PREPARED[shape] = (*of_shape[1 - _MOST_SETTINGS :], entry)
    return entry
