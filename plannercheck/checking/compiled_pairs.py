"""Pairs of bodies, compiled: what the core judges configurations with.

In: a robot, bodies, some of a checker's pairs. Out: `CompiledPairs`, the core's checker of just these pairs and just
the bodies in them. Bodies are prepared when a table first needs them (`Preparation`), so that what no configuration
within the limits can touch costs nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.polytope import Polytope, prepared
from plannercheck.bodies.shapes import Body, HullAndSwell, hull_and_swell
from plannercheck.common.core import core
from plannercheck.robots.configurations import LARGEST_VALUE
from plannercheck.robots.robot import Robot

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]

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


class CompiledPairs:
    """The core's checker of some pairs.

    Attributes:
        rows: (k,) which of the checker's pairs these are, ascending.
        polytopes: The prepared bodies in them, by index.
        core: The compiled checker of these pairs.
    """

    def __init__(
        self,
        robot: Robot,
        bodies: Sequence[Body],
        preparation: Preparation,
        pairs: Ints,
        rows: NDArray[np.int64],
        limits: tuple[Floats, Floats] | None,
        options: Sequence[Any],
        kernel: Any | None = None,
    ) -> None:
        """Prepares the bodies and compiles.

        Args:
            robot: The robot.
            bodies: All bodies.
            preparation: Of these bodies.
            pairs: (n, 2) indices of bodies.
            rows: Which of the pairs to take.
            limits: Configurations (nq,) between which the core may judge one; None for any.
            options: The core's: of the pair test, and switches.
            kernel: The kinematics that will pose the links, so that those which it never moves are posed here, once.
        """
        self.rows = rows
        self._count = len(bodies)
        self._used = np.unique(pairs[rows])
        self.polytopes = {k: preparation.polytope(k) for k in self._used.tolist()}
        links, placements = mounted(robot, [bodies[k] for k in self._used], kernel)
        anything = np.full(robot.nq, LARGEST_VALUE)
        lower, upper = (np.clip(limit, -anything, anything) for limit in limits or (-anything, anything))
        self.core = core.Checker(
            [polytope.core for polytope in self.polytopes.values()],
            links,
            placements,
            np.searchsorted(self._used, pairs[rows]).astype(np.int32).reshape(-1, 2),
            len(robot.link_names),
            lower,
            upper,
            *options,
            robot.sampled_link_poses,
        )

    def named(self, first: Ints) -> Ints:
        """Indices of these pairs (n,) as indices of the checker's, −1 kept."""
        if not len(self.rows):
            return first
        return np.where(first < 0, first, self.rows[first]).astype(np.int32)

    def colliding(self, link_poses: Floats) -> NDArray[np.bool_]:
        """(n, k) which of these pairs collide at poses of the links (n, links, 4, 4), m."""
        return np.asarray(self.core.all_of_poses(np.ascontiguousarray(link_poses))).astype(bool)

    def body_poses(self, link_poses: Floats) -> Floats:
        """(n, bodies, 4, 4) at poses of the links (n, links, 4, 4), m; NaN for bodies of none of these pairs."""
        poses = np.full((len(link_poses), self._count, 4, 4), np.nan)
        poses[:, self._used] = self.core.body_poses(np.ascontiguousarray(link_poses))
        return poses


def mounted(robot: Robot, bodies: Sequence[Body], kernel: Any | None) -> tuple[Ints, Floats]:
    """What bodies hang on.

    Args:
        robot: The robot.
        bodies: The robot's or a scene's.
        kernel: The kinematics that will pose the links; what it never moves counts as the world's. None: all may move.

    Returns:
        (n,) indices of links, -1 for the world, and (n, 4, 4) poses there, m, with the bits that verdicts are about.
    """
    links = np.array([-1 if b.link is None else robot.link_index(b.link) for b in bodies], dtype=np.int32)
    placements = np.array([body.pose for body in bodies], dtype=np.float64).reshape(-1, 4, 4)
    if kernel is not None:
        still = np.array([link >= 0 and kernel.link_is_constant(link) for link in links.tolist()], dtype=bool)
        poses = np.ascontiguousarray(robot.link_poses(robot.reference)[links[still]])
        placements[still] = core.placed_on_links(poses, placements[still])
        links[still] = -1
    return links, placements


def added(first: Mapping[str, Any], second: Mapping[str, Any]) -> dict[str, Any]:
    """The sum of two tables of counters, nested ones included."""
    return {
        name: added(value, second[name]) if isinstance(value, Mapping) else value + second[name]
        for name, value in first.items()
    }
