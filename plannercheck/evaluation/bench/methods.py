"""The methods that `plannercheck bench states` compares: how to build each, and its claimed error.

In: a checker. Out: `Method`s. All judge the same pairs of the same robot. Cut-off hierarchies, balls, capsules and
boxes replace the robot's bodies only; obstacles stay as they are. The error of such a stand-in is computed from its
shape (`furthest` of hausdorff.py); it is the largest one over the bodies of all pairs. They stand in for hulls: beside
solids there are coal, which takes them as surfaces, and our own verdicts of their hulls.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import Box, Capsule, GeometryObject, Sphere
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench import other_libraries
from plannercheck.evaluation.bench.bounding_volumes import ball_around, box_around, capsule_around
from plannercheck.evaluation.bench.coal_loop import CoalAtBest
from plannercheck.evaluation.bench.compiled_coal_loop import library
from plannercheck.evaluation.bench.hausdorff import furthest, furthest_of_balls
from plannercheck.evaluation.bench.pair_peers import COAL_AT_BEST
from plannercheck.evaluation.bench.solid_checkers import as_hull, has_solids, substituted, with_hulls
from plannercheck.evaluation.bench.timing import one_by_one
from plannercheck.evaluation.bench.truncated_hierarchies import inner_levels, outer_levels
from plannercheck.evaluation.bench.vamp_model import VampModel
from plannercheck.motions.checker import Checker
from plannercheck.ompl.joint_space import JointSpace

Kind = Literal["exact", "hulls", "inner", "outer", "spheres", "capsules", "boxes", "coal", "coal loop", "fcl", "vamp"]
_Around = Callable[[Polytope], tuple[Box | Capsule | Sphere, Floats]]

# All kinds except the exact ones, which are always compared, and coal's loop, which comes with coal.
KINDS: tuple[Kind, ...] = ("inner", "outer", "spheres", "capsules", "boxes", "coal", "fcl", "vamp")
# Those that take solids as they are.
_KINDS_OF_SOLIDS: tuple[Kind, ...] = ("coal",)

# States that slower methods judge in a round; their rates are over these.
_ONE_BY_ONE_STATES, _COAL_STATES, _FCL_STATES = 5000, 1000, 200


@dataclass(frozen=True)
class Method:
    """A method to build.

    Attributes:
        name: The name in tables.
        kind: The kind of method.
        note: Says what is timed, and how.
        build: Builds what judges.
        error: How far the bodies are off at most, m, of what `build` returned; None where nothing is known.
        judge: Judges states by what `build` returned.
        states: Most states to judge in a round; None for all.
        prepare: Makes of what `build` returned and of configurations what `judge` takes, outside the timing.
        overhead: Work on what `prepare` returned whose time is taken off; None for none.
        described: What was timed, where only what `build` returned knows; None where `note` says it.
    """

    name: str
    kind: Kind
    note: str
    build: Callable[[], Any]
    error: Callable[[Any], float | None]
    judge: Callable[[Any, Any], Bools]
    states: int | None = None
    prepare: Callable[[Any, Floats], Any] = lambda built, q: q
    overhead: Callable[[Any, Any], object] | None = None
    described: Callable[[Any], str] | None = None


def methods(checker: Checker, kinds: Iterable[Kind] | None = None) -> Iterator[Method]:
    """Methods of some kinds, the exact ones always, and first; None takes all kinds that there are for the bodies.

    Raises:
        PlannercheckError: If a kind is named that has no solids, and there are some.
    """
    solids = has_solids(checker)
    known = _KINDS_OF_SOLIDS if solids else KINDS
    chosen = known if kinds is None else tuple(kinds)
    if refused := [kind for kind in chosen if kind not in known]:
        raise PlannercheckError(f"{', '.join(refused)}: these are compared on hulls, solids with {', '.join(known)}")
    yield from _exact(checker)
    if solids:
        note = "check_states on the hulls of solids"  # which fill what solids leave empty
        yield Method("plannercheck, hulls", "hulls", note, partial(with_hulls, checker), _unknown, _by_batch)
    for kind in chosen:
        match kind:
            case "inner" | "outer":
                yield from _cut_off(checker, kind)
            case "spheres":
                yield _wrapped(checker, kind, ball_around)
            case "capsules":
                yield _wrapped(checker, kind, capsule_around)
            case "boxes":
                yield _wrapped(checker, kind, box_around)
            case "coal":
                yield from _coal(checker)
            case "fcl":
                note, build = "loop in Python over the pairs whose boxes meet", partial(other_libraries.fcl, checker)
                yield Method("python-fcl", "fcl", note, build, _unknown, _by_call, _FCL_STATES)
            case "vamp":
                yield from _vamp(checker)


def _exact(checker: Checker) -> Iterator[Method]:
    build = partial(substituted, checker, {})
    batch = Method("plannercheck, batch", "exact", "check_states", build, partial(_stated, 0.0), _by_batch)
    yield batch
    yield replace(
        batch,
        name="plannercheck, one by one",
        note="is_valid, called from Python",
        judge=lambda built, rows: one_by_one(built.is_valid, rows),
        prepare=lambda built, q: list(q),
        states=_ONE_BY_ONE_STATES,
    )
    yield replace(
        batch,
        name="plannercheck, lists",
        note="is_valid of lists of numbers, called from Python",
        judge=lambda built, rows: one_by_one(built.is_valid, rows),
        prepare=lambda built, q: q.tolist(),
        states=_ONE_BY_ONE_STATES,
    )
    if checker.state_validity() is not None and (space := _ompl_space(checker)) is not None:
        yield replace(
            batch,
            name="plannercheck, OMPL callback",
            note="state_validity() on OMPL states, called from Python",
            build=lambda: build().state_validity(space.numbers.states),
            judge=one_by_one,
            prepare=lambda built, q: _ompl_states(space, q),
            states=_ONE_BY_ONE_STATES,
        )


def _by_batch(built: Any, q: Any) -> Bools:
    return np.asarray(built.check_states(q))


def _ompl_space(checker: Checker) -> JointSpace | None:
    """The space in which OMPL plans for a robot; None where it has none."""
    try:
        return JointSpace(checker.robot)
    except PlannercheckError:
        return None


def _ompl_states(space: JointSpace, q: Floats) -> list[Any]:
    """OMPL states of configurations (n, nq)."""
    from ompl import base

    information = base.SpaceInformation(space.ompl_space())
    return [space.state(information, row) for row in q]


def _cut_off(checker: Checker, side: Literal["inner", "outer"]) -> Iterator[Method]:
    """Stand-ins from each level of the hierarchies; a body with fewer levels stays at its coarsest."""
    levels_of = inner_levels if side == "inner" else outer_levels
    levels = {k: levels_of(p) for k, p in _own(checker) if p.dimension == 3 and p.inflation_radius == 0}
    for level in range(1, 1 + max(map(len, levels.values()), default=0)):
        chosen = {k: found[min(level, len(found)) - 1] for k, found in levels.items() if found}
        yield Method(
            f"{side} bodies, level {level}",
            side,
            "check_states on the hierarchies' bodies at this level; their preparation counts, not finding them",
            partial(substituted, checker, {k: as_hull(checker.bodies[k], p) for k, p in chosen.items()}),
            partial(_hausdorff, checker, chosen, side),
            _by_batch,
        )


def _own(checker: Checker) -> list[tuple[int, Polytope]]:
    """The robot's bodies that some pair needs."""
    own = checker.polytopes[: len(checker.robot.bodies)]
    return [(k, polytope) for k, polytope in enumerate(own) if polytope is not None]


def _hausdorff(checker: Checker, chosen: dict[int, Polytope], side: str, built: Any) -> float:
    distances = []
    for k, polytope in chosen.items():
        body = checker.polytopes[k]
        assert body is not None
        inside, around = (polytope, body) if side == "inner" else (body, polytope)
        distances.append(furthest(around.vertices, inside))
    return max(distances, default=0.0)


def _wrapped(checker: Checker, kind: Kind, wrap: _Around) -> Method:
    def build() -> Checker:
        substitutes = {}
        for k, polytope in _own(checker):
            body = checker.bodies[k]
            shape, pose = wrap(polytope)
            substitutes[k] = GeometryObject(body.name, body.link, _product(body.pose, pose), shape)
        return substituted(checker, substitutes)

    def error(built: Checker) -> float:
        off = [_sticks_out(built.polytopes[k], polytope, wrap(polytope)[1]) for k, polytope in _own(checker)]
        return max(off, default=0.0)

    return Method(f"bounding {kind}", kind, "check_states, one a body", build, error, _by_batch)


def _sticks_out(around: Polytope | None, polytope: Polytope, pose: Floats) -> float:
    """How far a posed body sticks out of a body; for one without volume at most the size."""
    assert around is not None
    corners = around.vertices @ pose[:3, :3].T + pose[:3, 3]
    if polytope.dimension < 3:
        return float(np.linalg.norm(corners - polytope.vertices.mean(axis=0), axis=1).max() + around.inflation_radius)
    return furthest_of_balls(
        corners, np.full(len(corners), around.inflation_radius - polytope.inflation_radius), polytope
    )


def _product(a: Floats, b: Floats) -> Floats:
    pose = a @ b
    pose[3] = [0, 0, 0, 1]
    return pose


def _coal(checker: Checker) -> Iterator[Method]:
    with suppress(PlannercheckError):  # which the method itself raises again
        library()  # compiled now, not while building is timed
    note = "computeCollisions from Python, stopping at the first collision; the error is the tolerance"
    for tolerance in other_libraries.COAL_TOLERANCES:
        for name, with_tree in (("AABB tree", True), ("all pairs", False)):
            title = f"Pinocchio + coal, {name}, tolerance {tolerance:g}"
            built = partial(other_libraries.coal, checker, tolerance, with_tree)
            yield Method(title, "coal", note, built, partial(_stated, tolerance), _by_call, _COAL_STATES)
    yield Method(
        COAL_AT_BEST,
        "coal loop",
        "",
        partial(CoalAtBest, checker),
        partial(_stated, other_libraries.COAL_TOLERANCES[0]),
        CoalAtBest.check,
        prepare=CoalAtBest.states,
        described=lambda built: str(built.note),
    )


def _vamp(checker: Checker) -> Iterator[Method]:
    """VAMP's balls are its own: how far they are off is not known."""
    called = Method(
        "VAMP, from Python",
        "vamp",
        "validate, called from Python; each call copies the obstacles",
        partial(VampModel, checker),
        _unknown,
        VampModel.states_free,
        _ONE_BY_ONE_STATES,
        VampModel.rows,
    )
    yield replace(
        called,
        name="VAMP, in C++",
        note="a call for each state, less what a call with nothing to judge takes; eight lanes judge the same state",
        judge=VampModel.free,
        prepare=lambda built, q: built.paths(q, q),
        overhead=lambda built, paths: built.copying(len(paths)),
    )
    yield called


def _by_call(built: other_libraries.Judge, q: Any) -> Bools:
    return built(q)


def _stated(tolerance: float, built: Any) -> float:
    return tolerance


def _unknown(built: Any) -> None:
    return None
