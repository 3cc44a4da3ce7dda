"""The bodies of a checker, prepared when a pair first needs them.

In: bodies and their paddings. Out: `Preparation`, which makes the hull and the `Polytope` of a body at their first use,
so that bodies which no configuration within the limits can touch are never prepared. A shape keeps its prepared body:
checkers of the same robot, and of scenes that share objects, prepare nothing twice. The curved shapes of the last
scenes stay for a while, since the next scene from a file may have them again. Equal hulls share one polytope.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any
from weakref import WeakKeyDictionary, WeakValueDictionary

import numpy as np

from plannercheck.bodies.kinds import kind_of_shape, traits_of
from plannercheck.bodies.polytope import Polytope, polytopes_of_boxes, prepared
from plannercheck.bodies.shapes import (
    Box,
    Capsule,
    Cone,
    Cylinder,
    GeometryObject,
    InflatedHull,
    Shape,
    Sphere,
    inflated_hull,
)
from plannercheck.bodies.solids import Solid
from plannercheck.checking.reach_bounds import Boxes, boxes_of
from plannercheck.common.array_types import Floats
from plannercheck.common.progress import reported

# Up to this many points, preparing a body is faster than finding, reading and checking a cached file.
_FEW_POINTS = 32


class _PreparedShape:
    """A shape with one padding: its hull and its polytope, once they are needed."""

    __slots__ = ("_box", "_hull", "polytope", "setting")

    def __init__(self, setting: tuple[float, float]) -> None:
        self.setting = setting  # excess and padding
        self._hull: InflatedHull | None = None
        self._box: Boxes | None = None
        self.polytope: Polytope | None = None

    def hull(self, shape: Shape) -> InflatedHull:
        """Points, faces and inflation radius, the padding included."""
        if self._hull is None:
            excess, padding = self.setting
            points, faces, inflation_radius = inflated_hull(shape, excess)
            if not traits_of(kind_of_shape(shape)).is_bounded:
                inflation_radius = math.inf  # a pose may be beyond its points
            self._hull = points, faces, inflation_radius + padding
        return self._hull

    def box(self, shape: Shape) -> Boxes:
        """The box and the ball around the hull, one row."""
        if self._box is None:
            self._box = boxes_of([self.hull(shape)])
        return self._box


# Some prepared bodies of these kinds outlive their scene, unless they may be large.
_CURVED = (Sphere, Cylinder, Cone, Capsule)
_USUAL_EXCESS = 1e-5

# So many bodies of a shape, last used with different excesses or paddings, are cached.
_MOST_SETTINGS = 4

# In a scene of more bodies, boxes are not looked up among those of other scenes: making them is as fast.
_MOST_LOOKED_UP = 1000

# By shape, for each excess and padding, most often one. Shapes that compare equal are the same shape.
_PREPARED: WeakKeyDictionary[Shape, tuple[_PreparedShape, ...]] = WeakKeyDictionary()

# By inflation radius and points; solids that are not their hulls, by their triangles as well.
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
        are_few = len(bodies) <= _MOST_LOOKED_UP
        for body, part in zip(bodies, paddings.tolist(), strict=True):
            shape = body.shape
            key = id(shape), part
            entry = before.get(key) or self._by_shape.get(key)
            if entry is None:
                is_known = are_few or type(shape) is not Box
                entry = _known(shape, (excess, part)) if is_known else _PreparedShape((excess, part))
            self._by_shape[key] = entry
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
        """The hulls of the first bodies."""
        return [self.hull(body) for body in range(count)]

    def boxes(self, bodies: Sequence[int]) -> Boxes:
        """The boxes and balls around some bodies' hulls; those that are boxes need no hull."""
        are_boxes = [type(self._bodies[body].shape) is Box for body in bodies]
        if all(are_boxes):
            return self._of_boxes(bodies)
        first = [k for k, is_box in enumerate(are_boxes) if is_box]
        last = [k for k, is_box in enumerate(are_boxes) if not is_box]
        others = [self._entries[bodies[k]].box(self._bodies[bodies[k]].shape) for k in last]
        found = (self._of_boxes([bodies[k] for k in first]), *others) if first else others
        order = np.argsort(first + last)
        return Boxes(*(np.concatenate(parts)[order] for parts in zip(*found, strict=True)))

    def _of_boxes(self, bodies: Sequence[int]) -> Boxes:
        high = self._sizes(bodies) / 2
        radius = np.sqrt((high**2).sum(axis=1))
        return Boxes(-high, high, np.zeros_like(high), radius, self.paddings[np.asarray(bodies, dtype=np.int64)])

    def _sizes(self, bodies: Sequence[int]) -> Floats:
        """(n, 3) edge lengths of bodies that are boxes, m."""
        shapes = (self._bodies[body].shape for body in bodies)
        numbers = [edge for shape in shapes if isinstance(shape, Box) for edge in shape.size]
        return np.array(numbers, dtype=np.float64).reshape(-1, 3)

    def prepare(self, bodies: Sequence[int]) -> None:
        """Prepares all boxes among some bodies at once."""
        asked = [body for body in bodies if self._entries[body].polytope is None]
        asked = [body for body in asked if type(self._bodies[body].shape) is Box]
        if asked:
            made = polytopes_of_boxes(self._sizes(asked), self.paddings[asked])
            for body, polytope in zip(asked, made, strict=True):
                self._entries[body].polytope = polytope

    def polytope(self, body: int) -> Polytope:
        """The prepared body."""
        entry = self._entries[body]
        if entry.polytope is None:
            self.prepare([body])
        if entry.polytope is None:
            entry.polytope = self._prepared(body)
        return entry.polytope

    def _prepared(self, body: int) -> Polytope:
        """The prepared body, shared by equal hulls; a solid that is not its hull is shared by equal solids."""
        shape, padding = self._bodies[body].shape, float(self.paddings[body])
        if not traits_of(kind_of_shape(shape)).has_hull:
            return Polytope.of_shape(shape, padding)
        points, faces, inflation_radius = self.hull(body)
        key = np.float64(inflation_radius).tobytes() + points.tobytes()
        if isinstance(shape, Solid) and not shape.equals_hull:
            key += shape.digest
        found = _POLYTOPES.get(key)
        if found is None:
            name = self._bodies[body].name
            prepare = Polytope if len(points) <= _FEW_POINTS else prepared
            with reported(f"preparing body {name}"):
                found = Polytope.of_shape(
                    shape, padding, lambda: prepare(points, faces, inflation_radius, f"body {name!r}")
                )
            _POLYTOPES[key] = found
        return found

    def prepared_bodies(self) -> tuple[Polytope | None, ...]:
        """The prepared bodies, None for those not needed so far."""
        return tuple(entry.polytope for entry in self._entries)


@lru_cache(maxsize=64)
def _lasting(shape: Shape, setting: tuple[float, float]) -> _PreparedShape:
    """The entry of a curved shape, which equal shapes share, since a curved shape is nothing but its sizes."""
    return _PreparedShape(setting)


def _known(shape: Shape, setting: tuple[float, float]) -> _PreparedShape:
    """The entry of a shape with an excess and a padding; a new one if there is none."""
    if type(shape) in _CURVED and setting[0] >= _USUAL_EXCESS:
        return _lasting(shape, setting)
    of_shape = _PREPARED.get(shape, ())
    for entry in of_shape:
        if entry.setting == setting:
            return entry
    entry = _PreparedShape(setting)
    _PREPARED[shape] = (*of_shape[1 - _MOST_SETTINGS :], entry)
    return entry
