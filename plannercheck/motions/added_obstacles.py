"""How a prepared cell tests obstacles that C++ adds: with which paddings, and against which bodies of the robot.

In: a checker's settings, robot, scene and bodies. Out: `AddedObstacles`. Allowed collisions and paddings act by name,
and an obstacle that C++ adds has one body of its own name, whatever it replaces. So a trial scene has such an obstacle
of each name that an entry or an obstacle has, and of one name more, and its pairs are listed as those of every scene.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import Box, GeometryObject
from plannercheck.checking.prepared_bodies import Preparation
from plannercheck.checking.settings import Settings
from plannercheck.common.array_types import Floats
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

# The padding of an obstacle's body and of each copy, m; and pairs of a robot's body with one of these.
Treatment: TypeAlias = tuple[tuple[float, ...], tuple[tuple[int, int], ...]]


class AddedObstacles(NamedTuple):
    """Obstacles that are added.

    Attributes:
        treatments: By name; "" is any other name. Empty where the checker takes no other scene.
        copies: Copies of the robot's bodies, which follow the checker's bodies: which body, and its padding, m.
        bases: By index of a body in a treatment, the robot's body which it is or copies.
    """

    treatments: Mapping[str, Treatment]
    copies: Sequence[tuple[int, float]]
    bases: Mapping[int, int]

    def prepared(self, robot: Robot, preparation: Preparation) -> tuple[Polytope | None, ...]:
        """The prepared bodies of a checker, with all that are in a treatment, and then those of the copies."""
        known = len(preparation.paddings)
        for body in self.bases:
            if body < known:
                preparation.polytope(body)
        paddings = np.array([padding for _, padding in self.copies], dtype=np.float64)
        more = Preparation([robot.bodies[base] for base, _ in self.copies], preparation.excess, paddings)
        return *preparation.prepared_bodies(), *(more.polytope(k) for k in range(len(self.copies)))


def added_obstacles(
    settings: Settings, robot: Robot, scene: Scene, bodies: Sequence[GeometryObject], paddings: Floats
) -> AddedObstacles:
    """Lists them; `bodies` and `paddings` (n,), m, are the checker's."""
    if settings.bodies is not None:
        return AddedObstacles({}, (), {})
    names = _names(settings, robot, scene)
    trial = scene.copy()
    for name in scene.object_names:
        trial.remove(name)
    for name in names:
        trial.add(name, _SHAPE)
    padded = settings.padded(robot, trial, is_first=False)
    own = {id(body): k for k, body in enumerate(robot.bodies)}
    sides = [(own.get(id(body), -1), share) for body, share in zip(bodies, paddings.tolist(), strict=True)]
    places = {side: k for k, side in enumerate(sides)}
    shares: dict[str, list[float]] = {name: [] for name in names}
    numbers = []  # of each body among those of its name
    for label, share in zip(padded.labels, padded.shares.tolist(), strict=True):
        of_label = shares.setdefault(label, [])
        numbers.append(len(of_label))
        of_label.append(share)
    pairs: dict[str, list[tuple[int, int]]] = {name: [] for name in shares}
    copies, bases = list[tuple[int, float]](), dict[int, int]()
    for a, b in padded.pairs[0].tolist():
        if id(padded.bodies[b]) in own:
            continue
        side = own[id(padded.bodies[a])], float(padded.shares[a])
        if side not in places:
            places[side] = len(bodies) + len(copies)
            copies.append(side)
        bases[places[side]] = side[0]
        pairs[padded.labels[b]].append((places[side], numbers[b]))
    treatments = {name: (tuple(shares[name]), tuple(pairs[name])) for name in names}
    usual = treatments[names[0]]
    others = {name: how for name, how in treatments.items() if how != usual}
    return AddedObstacles({"": usual, **others}, copies, bases)


_SHAPE = Box((1.0, 1.0, 1.0))


def _names(settings: Settings, robot: Robot, scene: Scene) -> list[str]:
    """One name that means nothing, then those that an obstacle may have and that mean something."""
    padding = settings.padding if isinstance(settings.padding, Mapping) else {}
    allowed = scene.allowed
    said: list[Iterable[str]] = [(entry,) if isinstance(entry, str) else entry for entry in padding]
    said += [scene.object_names, allowed.defaults, *allowed.pairs, *((name,) for *_, name in allowed.geometries)]
    carried = [name for body in robot.bodies if body.carried for name in (body.name, body.carried)]
    found = sorted({name for group in said for name in group}.difference(robot.link_names, carried, [""]))
    longest = max([*found, *robot.link_names, *carried, *(body.name for body in robot.bodies)], key=len, default="")
    return [longest + "+", *found]
