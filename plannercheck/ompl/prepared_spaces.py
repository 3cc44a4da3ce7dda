"""OMPL's spaces of a checker, set up once and borrowed by one plan after the other.

In: a checker, how its motions are judged, how its root moves. Out: `borrowed_space`, a `PreparedSpace`: an OMPL space,
and a SpaceInformation with validators. `returned_space` keeps it for the next plan.

While it is borrowed, a plan has it for itself, so that plans of several threads share nothing. Each plan gets a new
planner, problem, solution and simplifier. A prepared space refers to its checker weakly: C++ owns the validators, which
Python's garbage collector does not see, so that a strong reference would keep the checker alive forever.
"""

from __future__ import annotations

import atexit
import weakref
from collections.abc import Sequence
from typing import Any, TypeAlias
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike
from ompl import base, util

from plannercheck.checking.protocols import AnyChecker
from plannercheck.common.array_types import Floats
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.real_numbers import check_length
from plannercheck.motions.certifier import DEFAULT_TOLERANCE
from plannercheck.motions.checker import Checker
from plannercheck.ompl.angle_checkers import check_checker
from plannercheck.ompl.joint_space import JointSpace
from plannercheck.ompl.motion_validators import Space, motion_validator
from plannercheck.ompl.planar_space import PlanarSpace
from plannercheck.ompl.pose_bounds import default_bounds
from plannercheck.ompl.pose_parts import has_free_bodies
from plannercheck.ompl.pose_space import PoseSpace
from plannercheck.planar.checker import Checker as PlanarChecker
from plannercheck.planar.curves import Curve

# What spaces of one checker differ by: resolution (m), curve, turning radius (m).
_Key: TypeAlias = tuple[float | None, Curve, float | None]

# These planners sort states by a projection. OMPL may draw a random one when it sets up a space, which has to be after
# the plan's seed is set: they get a new space each time.
_PROJECTING = ("BKPIECE1", "KPIECE1", "LBKPIECE1")


class PreparedSpace:
    """A space that reads and writes states, with OMPL's SpaceInformation: all that it needs but planner and problem."""

    def __init__(self, space: Space, information: Any, kept: list[PreparedSpace] | None) -> None:
        """Takes a space and its information; `kept` is where it is put for other plans, None for this one only."""
        self.space, self.information, self.kept = space, information, kept
        self._ends: tuple[Any, ...] = ()

    def end_states(self, ends: Sequence[Floats]) -> tuple[Any, ...]:
        """OMPL states of start and goals, for a problem that copies them."""
        if len(self._ends) != len(ends):
            self._ends = tuple(self.information.allocState() for _ in ends)
        for state, q in zip(self._ends, ends, strict=True):
            self.space.write(state, q)
        return self._ends

    def draw_seeds(self) -> None:
        """Draws as many of OMPL's seeds as setting up the space would have drawn now.

        So a seed gives the same plan whether the space is new or not. OMPL draws two for the random projection of a
        space of more than two bounded joints: for its matrix, and for the samples that give its extent.
        """
        space = self.information.getStateSpace()
        if self.kept is not None and isinstance(space, base.RealVectorStateSpace) and space.getDimension() > 2:
            util.RNG()
            util.RNG()


# Spaces that no plan has now. Pop and append of a list are single steps for other threads.
_KEPT: WeakKeyDictionary[AnyChecker, dict[_Key, list[PreparedSpace]]] = WeakKeyDictionary()
atexit.register(_KEPT.clear)  # before nanobind looks for leaks


def borrowed_space(
    checker: AnyChecker,
    planner: str,
    resolution: float | None,
    curve: Curve,
    turning_radius: float | None,
    ends: Sequence[Floats],
    bounds: ArrayLike | None = None,
) -> PreparedSpace:
    """A space that is ready, for this plan only; arguments as for `plan`, `ends` as for `JointSpace`."""
    key = (resolution, curve, turning_radius)
    is_kept = planner not in _PROJECTING
    if is_kept:
        try:
            return _taken(_KEPT[checker][key])
        except (KeyError, IndexError):
            pass
    space = space_of(checker, curve, turning_radius, ends, bounds)
    if not is_kept or isinstance(space, PoseSpace) or (isinstance(space, JointSpace) and space.depends_on_ends):
        return PreparedSpace(space, space_information(checker, space, resolution), None)
    information = space_information(weakref.proxy(checker), space, resolution)
    information.setup()
    return PreparedSpace(space, information, _KEPT.setdefault(checker, {}).setdefault(key, []))


def _taken(kept: list[PreparedSpace]) -> PreparedSpace:
    prepared = kept.pop()
    prepared.kept = kept
    return prepared


def returned_space(prepared: PreparedSpace) -> None:
    """Keeps a space for the next plan of its kind, unless it was made for one plan only."""
    kept, prepared.kept = prepared.kept, None  # no circle, which would outlive the checker
    if kept is not None:
        kept.append(prepared)


def space_of(
    checker: AnyChecker,
    curve: Curve = "straight",
    turning_radius: float | None = None,
    held: Sequence[Floats] = (),
    bounds: ArrayLike | None = None,
) -> Space:
    """The space in which a checker's robot is planned for; arguments as for `setup`, `held` as for `JointSpace`."""
    check_checker(checker)
    has_poses = isinstance(checker, Checker) and has_free_bodies(checker.robot)
    if bounds is not None and not has_poses:
        raise PlannercheckError("bounds are for robots with a floating, planar or ball joint; others have limits")
    if isinstance(checker, PlanarChecker):
        return PlanarSpace(checker.robot, curve, turning_radius)
    if curve != "straight" or turning_radius is not None:
        raise PlannercheckError("curves and turning radii are for planar robots")
    if isinstance(checker, Checker) and has_poses:
        return PoseSpace(checker.robot, default_bounds(checker, held) if bounds is None else bounds, *held)
    return JointSpace(checker.robot, *held)  # type: ignore[arg-type]  # the other kind of checker


def space_information(
    checker: AnyChecker, space: Space, resolution: float | None, tolerance: float = DEFAULT_TOLERANCE
) -> Any:
    """OMPL's SpaceInformation with a checker's validators, not set up; arguments as for `setup`."""
    for name, length in (("resolution", resolution), ("tolerance", tolerance)):
        if length is not None:
            check_length(length, name)
    information = base.SpaceInformation(space.ompl_space())
    information.setStateValidityChecker(_state_validity(information, checker, space))
    information.setMotionValidator(motion_validator(information, checker, space, resolution, tolerance))
    return information


def _state_validity(information: Any, checker: AnyChecker, space: Space) -> Any:
    """OMPL's state validity checker; in space it also has clearances."""
    if isinstance(checker, Checker):
        assert isinstance(space, JointSpace | PoseSpace)
        return _ExactStates(information, checker, space)

    def is_valid(state: Any) -> bool:
        return checker.is_valid(np.array(space.read(state)))

    return core.remembered_failures(is_valid, space.numbers.failure)


class _ExactStates(base.StateValidityChecker):  # type: ignore[misc]  # OMPL's bindings are untyped
    """Judges states, and gives clearances to OMPL's samplers, paths and objectives."""

    def __init__(self, information: Any, checker: Checker, space: JointSpace | PoseSpace) -> None:
        """Keeps the space, but not the SpaceInformation, which keeps this object."""
        super().__init__(information)
        self._checker, self._space = checker, space
        is_plain = isinstance(space, JointSpace)
        compiled = checker.state_validity(space.numbers.states, space.numbers.failure) if is_plain else None
        if compiled is not None:
            self.__dict__["isValid"] = compiled  # OMPL calls it instead of the method, without a frame of Python

    def isValid(self, state: Any) -> bool:  # noqa: N802  # OMPL's name
        """Whether a state is free of collision."""
        return self._checker.is_valid(np.array(self._space.read(state)))

    def clearance(self, state: Any) -> float:
        """The least distance of all pairs, m; where bodies overlap, the negative of a depth (`Checker.clearance`)."""
        return self._checker.clearance(np.array(self._space.read(state)))
