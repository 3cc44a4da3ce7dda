"""coal at its best: a C++ loop over posed states (coal_loop.cpp, which compiled_coal_loop.py compiles).

In: a checker. Out: a `CoalLoop` over the same bodies and pairs, which judges groups of states whose poses it is given.
Solids are coal's trees of boxes around triangles, so they are surfaces there; solids that are their hulls are hulls.

The best settings of coal depend on the states: a guess from the last call helps along a motion, not on random states.
So there are `VARIANTS`, and `fastest` tries all of them on the timed states; for meshes it tries each kind of boxes on
the first states.
"""

from __future__ import annotations

import ctypes
import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import Box, Capsule, Cone, Cylinder, Shape, Sphere
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.arrays import distinct, grouped
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench.compiled_coal_loop import library
from plannercheck.evaluation.bench.timing import seconds_of
from plannercheck.motions.checker import Checker

# In the order of coal_loop.cpp's `Kind`.
_BOX, _SPHERE, _CAPSULE, _CYLINDER, _CONE, _HULL = range(6)
_MESH_BOXES = {"OBB": 6, "OBBRSS": 7}
# In the order of coal's enumerations.
_GJK = ("plain GJK", "Polyak", "Nesterov")
_GUESSES = ("fixed guess", "cached guess", "guess from boxes")
_FROM_BOXES = _GUESSES.index("guess from boxes")
_FILTERS = ("no boxes", "world boxes", "world and body boxes")
# States whose poses are computed at once: with those of all obstacles, they take 40 kB each in a large scene.
_BLOCK = 1024
# Each variant is tried so often, and the least time counts.
_TRIALS = 3
# States on which variants are tried where there are meshes, which take coal far longer than hulls.
_TRIED_WITH_MESHES = 200
# A triangle whose area is this part of its size squared is none: its sign is rounding.
_FLAT = 2.0**-40


class Variant(NamedTuple):
    """How the loop asks coal.

    Attributes:
        gjk: 0 plain, 1 with Polyak's acceleration, 2 with Nesterov's.
        guess: Where GJK starts: 0 always alike, 1 where the pair's last call ended, 2 from the bodies' boxes.
        boxes: What is asked first: 0 nothing, 1 boxes along the world's axes, 2 then those in the bodies' frames.
    """

    gjk: int
    guess: int
    boxes: int

    def __str__(self) -> str:
        return f"{_GJK[self.gjk]}, {_GUESSES[self.guess]}, {_FILTERS[self.boxes]}"


# For states of many bodies, most of them far apart.
VARIANTS = tuple(Variant(*choice) for choice in itertools.product((0, 1, 2), (0, 1, 2), (1, 2)))
# For a pair whose last answer says nothing: without the guess that it left.
COLD_VARIANTS = tuple(Variant(*choice) for choice in itertools.product((0, 1, 2), (0, 2), (0, 1)))


@dataclass(frozen=True)
class PosedBodies:
    """Bodies as coal takes them.

    Attributes:
        polytopes: Their hulls, or solids, for those that are no simple shape.
        shapes: Their shapes where coal has them as such; else None.
        moves: (k,) which change their poses from state to state.
        pairs: (p, 2) indices; a pair has at least one body that moves.
        names: Their names, for errors.
    """

    polytopes: Sequence[Polytope]
    shapes: Sequence[Shape | None]
    moves: Bools
    pairs: NDArray[Any]
    names: Sequence[str]


class CoalStates:
    """States whose poses coal has; freed with the object."""

    def __init__(self, loop: CoalLoop, poses: Floats) -> None:
        """Takes the poses (n, movers, 4, 4), m."""
        self.count = len(poses)
        self._library = loop.library
        self.handle = ctypes.c_void_p(
            loop.library.coal_loop_pose(loop.handle, np.ascontiguousarray(poses, dtype=np.float64), len(poses))
        )

    def __del__(self) -> None:
        self._library.coal_loop_unpose(self.handle)


class CoalLoop:
    """A loop over posed states in C++."""

    def __init__(self, bodies: PosedBodies, placed: Floats, mesh_boxes: str = "OBBRSS") -> None:
        """Hands bodies and pairs to coal; at the poses (k, 4, 4), m, those that stand still are kept.

        `mesh_boxes` is what coal has around the triangles of solids: "OBB" or "OBBRSS".

        Raises:
            PlannercheckError: If there is no compiler, or coal has no shape for a body.
        """
        self.library = library()
        self.mesh_boxes = mesh_boxes
        self.pairs = len(bodies.pairs)
        self.has_meshes = any(p.solid is not None for p in bodies.polytopes)
        self.handle = ctypes.c_void_p(self.library.coal_loop_new())
        shape_of: dict[int, int] = {}
        indices = [shape_of.setdefault(id(p), len(shape_of)) for p in bodies.polytopes]  # equal shapes are one
        for k in grouped(np.array(indices)).first.tolist():
            self._add(bodies.polytopes[k], bodies.shapes[k], bodies.names[k])
        self._checked(
            self.library.coal_loop_set(
                self.handle,
                len(indices),
                np.array(indices, dtype=np.int32),
                np.ascontiguousarray(bodies.moves, dtype=np.uint8),
                np.ascontiguousarray(placed, dtype=np.float64),
                len(bodies.pairs),
                np.ascontiguousarray(bodies.pairs, dtype=np.int32),
            ),
            "these pairs",
        )

    @classmethod
    def of_checker(cls, checker: Checker, mesh_boxes: str = "OBBRSS") -> CoalLoop:
        """The loop over a checker's pairs; bodies in no pair are left out; `mesh_boxes` as of `CoalLoop`."""
        used = distinct(checker.pairs).tolist()
        index = {body: k for k, body in enumerate(used)}
        polytopes = [p for body in used if (p := checker.polytopes[body]) is not None]
        assert len(polytopes) == len(used)
        items = [checker.bodies[body] for body in used]
        pairs = np.array([[index[a], index[b]] for a, b in checker.pairs.tolist()], dtype=np.int32).reshape(-1, 2)
        moves = np.array([item.link is not None for item in items])
        bodies = PosedBodies(polytopes, [item.shape for item in items], moves, pairs, [item.name for item in items])
        loop = cls(bodies, checker.body_poses(checker.robot.random_configurations(1, 0))[0][used], mesh_boxes)
        loop._checker, loop._movers = checker, np.array(used)[moves]
        return loop

    _checker: Checker | None = None
    _movers: NDArray[Any] = np.zeros(0, dtype=int)

    def posed(self, poses: Floats) -> CoalStates:
        """States for `check`, given the poses (n, movers, 4, 4) of the bodies that move, in their order, m."""
        return CoalStates(self, poses)

    def states(self, q: Floats) -> CoalStates:
        """States for `check`, given configurations (n, nq) of the checker's robot."""
        assert self._checker is not None
        blocks = np.array_split(q, range(_BLOCK, len(q), _BLOCK))
        return self.posed(np.concatenate([self._checker.body_poses(block)[:, self._movers] for block in blocks]))

    def check(self, states: CoalStates, variant: Variant, ends: NDArray[np.int64] | None = None) -> Bools:
        """Which groups of states, by where they end, are free: (groups,); without ends each state is a group."""
        groups = np.arange(1, states.count + 1) if ends is None else np.ascontiguousarray(ends, dtype=np.int64)
        free = np.empty(len(groups), dtype=bool)
        self._checked(
            self.library.coal_loop_check(self.handle, states.handle, groups, len(groups), *variant, free),
            "these states",
        )
        return free

    def check_pairs(self, states: CoalStates, variant: Variant) -> Bools:
        """Which pairs collide, in each state by itself: (states, pairs)."""
        hit = np.empty((states.count, self.pairs), dtype=bool)
        self._checked(
            self.library.coal_loop_check_pairs(self.handle, states.handle, *variant, hit.reshape(-1)), "these states"
        )
        return hit

    def fastest(
        self, states: CoalStates, ends: NDArray[np.int64] | None = None, variants: Sequence[Variant] = VARIANTS
    ) -> tuple[Variant, float]:
        """The variant that judges these states fastest, and its seconds; each is tried several times by turns."""
        best = dict.fromkeys(variants, float("inf"))
        for _ in range(_TRIALS):
            for variant in variants:
                spent = seconds_of(lambda variant=variant: self.check(states, variant, ends))  # type: ignore[misc]
                best[variant] = min(best[variant], spent)
        chosen = min(best, key=best.__getitem__)
        return chosen, best[chosen]

    def _add(self, polytope: Polytope, shape: Shape | None, name: str) -> None:
        kind, numbers = _simple(shape)
        points, faces = polytope.vertices, polytope.faces if kind == _HULL else np.zeros((0, 3))
        if polytope.solid is not None:
            points, faces = polytope.solid.points(), polytope.solid.triangles()
            a, b, c = (points[corner] for corner in faces.T)
            across, sizes = np.cross(b - a, c - a), np.abs([b - a, c - a]).max(axis=(0, 2))
            has_area = np.abs(across).max(axis=1) > _FLAT * sizes**2  # coal has a sphere in contact with any other one
            kind, faces = _MESH_BOXES[self.mesh_boxes], faces[has_area]
        if kind == _HULL and polytope.dimension < 3:
            raise PlannercheckError(f"coal has no shape for {name}, which has no volume")
        points = np.ascontiguousarray(points, dtype=np.float64)
        faces = np.ascontiguousarray(faces, dtype=np.int32)
        given = np.array([*numbers, 0.0, 0.0, 0.0])
        done = self.library.coal_loop_add_shape(self.handle, kind, given, points, len(points), faces, len(faces))
        self._checked(done, name)

    def _checked(self, failed: int, what: str) -> None:
        if failed:
            reason = self.library.coal_loop_error(self.handle).decode(errors="replace")
            raise PlannercheckError(f"coal refuses {what}: {reason}")

    def __del__(self) -> None:
        if hasattr(self, "handle"):
            self.library.coal_loop_delete(self.handle)


def fastest_loop(
    make: Callable[[str], CoalLoop],
    states_of: Callable[[CoalLoop, int | None], CoalStates],
    variants: Sequence[Variant] = VARIANTS,
) -> tuple[CoalLoop, Variant]:
    """The loop and the variant that judge some states fastest.

    `make` makes the loop, given what coal has around the triangles of solids; `states_of` gives a loop's states, or the
    first so many of them.
    """
    loops = [make("OBBRSS")]
    first = None
    if loops[0].has_meshes:
        loops.append(make("OBB"))
        first = _TRIED_WITH_MESHES
        variants = [each for each in variants if each.guess != _FROM_BOXES]  # coal's single triangles have none
    found = [(loop, *loop.fastest(states_of(loop, first), variants=variants)) for loop in loops]
    loop, variant, _ = min(found, key=lambda each: each[2])
    return loop, variant


class CoalAtBest:
    """coal's loop, asked as is fastest for the first states that it gets."""

    def __init__(self, checker: Checker) -> None:
        """Builds the loop."""
        self._loop = CoalLoop.of_checker(checker)
        self._checker = checker
        self._variant: Variant | None = None

    @property
    def note(self) -> str:
        """How coal is asked."""
        meshes = f", meshes in {self._loop.mesh_boxes}" if self._loop.has_meshes else ""
        return f"C++ loop over poses given beforehand: {self._variant}{meshes}"

    def states(self, q: Floats) -> CoalStates:
        """Configurations (n, nq) as coal takes them."""
        if self._variant is None:
            self._loop, self._variant = fastest_loop(self._made, lambda loop, first: loop.states(q[:first]))
        return self._loop.states(q)

    def _made(self, mesh_boxes: str) -> CoalLoop:
        if mesh_boxes == self._loop.mesh_boxes:
            return self._loop
        return CoalLoop.of_checker(self._checker, mesh_boxes)

    def check(self, states: CoalStates) -> Bools:
        """Which are free."""
        assert self._variant is not None
        return self._loop.check(states, self._variant)


def _simple(shape: Shape | None) -> tuple[int, tuple[float, ...]]:
    """The kind and the lengths of a shape that coal has without a polytope around it."""
    match shape:
        case Box(size=size):
            return _BOX, size
        case Sphere(radius=radius):
            return _SPHERE, (radius,)
        case Capsule(radius=radius, length=length):
            return _CAPSULE, (radius, length)
        case Cylinder(radius=radius, length=length):
            return _CYLINDER, (radius, length)
        case Cone(radius=radius, length=length):
            return _CONE, (radius, length)
    return _HULL, ()
