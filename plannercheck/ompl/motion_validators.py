"""OMPL's motion validators: motions proved free by one call of the core, or sampled.

In: a checker, its OMPL space. Out: `motion_validator`. Motions are proved free. If a resolution is given, they are
sampled instead, so densely that no point moves further than it between two states.
"""

from __future__ import annotations

import weakref
from typing import Any, TypeAlias

import numpy as np
from ompl import base

from plannercheck.checking.protocols import AnyChecker
from plannercheck.common.array_types import Floats
from plannercheck.common.core import core
from plannercheck.motions.certifier import DEFAULT_TOLERANCE
from plannercheck.motions.checker import Checker
from plannercheck.motions.sampling import coarse_to_fine
from plannercheck.ompl.curved_space import sampled_curve
from plannercheck.ompl.joint_space import JointSpace
from plannercheck.ompl.planar_space import PlanarSpace
from plannercheck.ompl.pose_space import PoseSpace
from plannercheck.planar.checker import Checker as PlanarChecker
from plannercheck.planar.motion_certifier import STRAIGHT

# Any kind of space: it reads and writes states, and computes their differences.
Space: TypeAlias = JointSpace | PoseSpace | PlanarSpace

# A curved motion is checked coarse to fine, to find a collision early: first this many states, then twice as many each
# time.
_FIRST_STATES = 8


class _CountingValidator(base.MotionValidator):  # type: ignore[misc]  # OMPL's bindings are untyped
    """The common part of all validators.

    The counters are kept here; `SpaceInformation.getCheckedMotionCount` reads OMPL's own, which stay 0.
    """

    def __init__(self, information: Any, space: Space) -> None:
        """Keeps the space, but not the SpaceInformation, which keeps this object."""
        super().__init__(information)
        self._space = space
        self._counts = core.MotionCounts()
        itself = weakref.ref(self)  # the core's functions take no part in the search for cycles

        def judged(s1: Any, s2: Any) -> bool:
            validator = itself()
            assert validator is not None  # OMPL calls it
            return validator._judged(s1, s2)

        self.__dict__["checkMotion"] = core.remembered_failures(judged, space.numbers.failure)

    def _is_free(self, s1: Any, s2: Any) -> bool:
        raise NotImplementedError

    def _last_valid(self, s1: Any, s2: Any) -> tuple[bool, float, Floats]:
        """Whether the motion is free, the last valid place on it, and the configuration there."""
        raise NotImplementedError

    def checkMotion(self, s1: Any, s2: Any) -> bool:  # noqa: N802  # OMPL's name
        """Whether the motion between two states is free, both ends included; objects have a compiled one."""
        return self._judged(s1, s2)

    def _judged(self, s1: Any, s2: Any) -> bool:
        free = self._is_free(s1, s2)
        self._counts.add(free)
        return free

    def checkMotionWithLastValid(self, s1: Any, s2: Any, last_valid: Any = None) -> tuple[bool, float]:  # noqa: N802
        """The same, and how far the motion is free.

        Args:
            s1: Start.
            s2: End.
            last_valid: A state to overwrite with the last one known free (if sampled, the last one before the first
                collision); None for none.

        Returns:
            Whether the motion is free, and the last valid state's place between 0 and 1 (0 also if the start
            collides).
        """
        free, last, q = self._last_valid(s1, s2)
        if last_valid is not None:
            self._space.write(last_valid, q)
        self._counts.add(free)
        return free, last

    def getValidMotionCount(self) -> int:  # noqa: N802
        """Motions found free since the counters were reset."""
        return int(self._counts.free)

    def getInvalidMotionCount(self) -> int:  # noqa: N802
        """Motions found colliding since the counters were reset."""
        return int(self._counts.refused)

    def getCheckedMotionCount(self) -> int:  # noqa: N802
        """All motions checked since the counters were reset."""
        return self.getValidMotionCount() + self.getInvalidMotionCount()

    def getValidMotionFraction(self) -> float:  # noqa: N802
        """Free motions as a part of all; 0 if there were none."""
        return self.getValidMotionCount() / max(self.getCheckedMotionCount(), 1)

    def resetMotionCounter(self) -> None:  # noqa: N802
        """Sets the counters to 0."""
        self._counts.reset()


class ProvedMotions(_CountingValidator):
    """Motions in space, each proved free by one call of the core."""

    def __init__(self, information: Any, checker: Checker, space: JointSpace, tolerance: float) -> None:
        """Takes the checker's certifier; `tolerance` as for `Checker.check_motion`, m."""
        super().__init__(information, space)
        self._joints, self._tolerance = space, tolerance
        self._certifier = checker.motion_certifier
        # OMPL calls it instead of the method, without a frame of Python.
        self.__dict__["checkMotion"] = self._certifier.motion_validity(
            tolerance,
            self._counts,
            space.numbers.states,
            np.flatnonzero(space.continuous).tolist(),
            space.numbers.failure,
        )

    def _ends(self, s1: Any, s2: Any) -> tuple[list[float], list[float]]:
        q0 = self._joints.read(s1)
        return q0, self._joints.end(q0, self._joints.read(s2))

    def _last_valid(self, s1: Any, s2: Any) -> tuple[bool, float, Floats]:
        q0, q1 = (np.array(q) for q in self._ends(s1, s2))
        result = self._certifier.motion_result(q0, q1, self._tolerance)
        state = self._certifier.states(q0, q1, np.array([result.free_until]))[0]
        return result.free, result.free_until, state


class ProvedPoses(_CountingValidator):
    """Motions of robots with free bodies, each proved free along OMPL's interpolation."""

    def __init__(self, information: Any, checker: Checker, space: PoseSpace, tolerance: float) -> None:
        """Takes the checker; `tolerance` as for `Checker.check_motion`, m."""
        super().__init__(information, space)
        self._poses, self._tolerance, self._checker = space, tolerance, checker

    def _is_free(self, s1: Any, s2: Any) -> bool:
        starts, ends, *others = self._poses.pieces(s1, s2)
        return self._are_free(starts, ends) and self._are_free(*others)

    def _are_free(self, starts: Floats, ends: Floats) -> bool:
        return bool(self._checker.check_motions(starts, ends, tolerance=self._tolerance, path="slerp").all())

    def _last_valid(self, s1: Any, s2: Any) -> tuple[bool, float, Floats]:
        starts, ends, *others = self._poses.pieces(s1, s2)
        if not self._are_free(*others):
            return False, 0.0, starts[0]
        certifier, sampler = self._checker.certifier_of("slerp"), self._checker.motion_sampler
        for k, (q0, q1) in enumerate(zip(starts, sampler.shorter_turn(starts, ends), strict=True)):
            result = certifier.motion_result(q0, q1, self._tolerance, given=ends[k])
            if not result.free:
                last = certifier.states(q0, q1, np.array([result.free_until]))[0]
                return False, (k + result.free_until) / len(starts), last
        return True, 1.0, ends[-1]


class ProvedPlanarMotions(_CountingValidator):
    """Motions in the plane, straight or on curves, each proved free by one call of the core."""

    def __init__(self, information: Any, checker: PlanarChecker, space: PlanarSpace, tolerance: float) -> None:
        """Takes the checker's certifier; `tolerance` as for `Checker.check_motion`, m."""
        super().__init__(information, space)
        self._plane, self._tolerance, self._sampler = space, tolerance, checker.motion_sampler
        self._certifier = checker.motion_certifier

    def _motion(self, s1: Any, s2: Any) -> tuple[Floats, Floats, Floats]:
        """Both ends, and the pieces of a curve between them."""
        q0, q1 = np.array(self._plane.read(s1)), np.array(self._plane.read(s2))
        curves, end = self._plane.curves, self._sampler.shorter_turn(q0, q1)
        if curves is None:
            return q0, end, STRAIGHT
        end[2] = q1[2]  # the very double: rounding may choose between two curves of equal length
        return q0, end, curves.pieces(q0, end, self._sampler.extent)

    def _is_free(self, s1: Any, s2: Any) -> bool:
        q0, q1, pieces = self._motion(s1, s2)
        return self._certifier.is_free(q0, q1, self._tolerance, pieces)

    def _last_valid(self, s1: Any, s2: Any) -> tuple[bool, float, Floats]:
        q0, q1, pieces = self._motion(s1, s2)
        result = self._certifier.motion_result(q0, q1, self._tolerance, pieces=pieces)
        state = self._certifier.states(q0, q1, np.array([result.free_until]), pieces)[0]
        return result.free, result.free_until, state


class SampledMotions(_CountingValidator):
    """Motions in space or in the plane, judged at sampled states."""

    def __init__(self, information: Any, checker: AnyChecker, space: Space, resolution: float | None) -> None:
        """Keeps the checker; `resolution` as for its `check_motion`, m."""
        super().__init__(information, space)
        self._checker, self._resolution, self._sampler = checker, resolution, checker.motion_sampler

    def _is_free(self, s1: Any, s2: Any) -> bool:
        if self._space.is_straight:
            return self._checker.check_motion(*self._ends(s1, s2), self._resolution)
        steps = self._space.curve_steps(s1, s2, self._sampler, self._resolution)
        parameters = coarse_to_fine(steps)
        done, size = 0, _FIRST_STATES
        while done < len(parameters):
            states = self._space.curve_states(s1, s2, parameters[done : done + size])
            if not self._checker.check_states(states).all():
                return False
            done, size = done + size, 2 * size
        return True

    def _last_valid(self, s1: Any, s2: Any) -> tuple[bool, float, Floats]:
        states = self._states(s1, s2)
        colliding = np.flatnonzero(~self._checker.check_states(states))
        last = len(states) - 1 if len(colliding) == 0 else max(int(colliding[0]) - 1, 0)
        return len(colliding) == 0, last / (len(states) - 1), states[last]

    def _states(self, s1: Any, s2: Any) -> Floats:
        """The sampled states (k, nq) of a motion, both ends included."""
        if not self._space.is_straight:
            return sampled_curve(self._space, s1, s2, self._sampler, self._resolution)
        q0, q1 = self._ends(s1, s2)
        steps = int(self._sampler.steps(q0[None], q1[None], self._resolution)[0])
        return np.asarray(self._sampler.states(q0, q1, np.arange(steps + 1) / steps))

    def _ends(self, s1: Any, s2: Any) -> tuple[Floats, Floats]:
        """Both ends; angles of the second are on the short way from the first, as in OMPL's interpolation."""
        q0, q1 = np.array(self._space.read(s1)), np.array(self._space.read(s2))
        return q0, self._sampler.shorter_turn(q0, q1)


def motion_validator(
    information: Any,
    checker: AnyChecker,
    space: Space,
    resolution: float | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
) -> ProvedMotions | ProvedPoses | ProvedPlanarMotions | SampledMotions:
    """The validator for a checker: motions are proved free within a tolerance, m, or sampled with a resolution, m."""
    if resolution is None and isinstance(checker, Checker) and isinstance(space, PoseSpace):
        return ProvedPoses(information, checker, space, tolerance)
    if resolution is None and isinstance(checker, Checker):
        assert isinstance(space, JointSpace)
        return ProvedMotions(information, checker, space, tolerance)
    if resolution is None and isinstance(checker, PlanarChecker):
        assert isinstance(space, PlanarSpace)
        return ProvedPlanarMotions(information, checker, space, tolerance)
    return SampledMotions(information, checker, space, resolution)
